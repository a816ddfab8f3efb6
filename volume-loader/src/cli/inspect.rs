//! `volume-loader inspect`.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use picture::{PngError, write_png};

use super::input;
use crate::inspect::{Inspection, Summary, WINDOW, inspect};
use crate::source::ReadError;

/// What to inspect, and what to make of it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    volume-loader inspect series/\n  \
    volume-loader inspect patient.nii.gz --json | jq .spacing_mm\n  \
    volume-loader inspect patient.nii.gz --png patient.png\n  \
    volume-loader inspect series/ --series 2 --json\n\n\
    Of a folder with several series each is inspected. \
    Lengths are mm, angles degrees, axes LPS (+x to the patient's left, +y to the back, +z up). The picture shows the axial, \
    frontal and sagittal planes through the volume's middle in a window of 400 HU around 40; dark blue was not measured, \
    the grey around a slanting volume is outside it. \
    Neither the report nor the picture names the patient, unless the report is asked to.")]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    input: input::Input,
    /// Prints the summary as JSON.
    #[arg(long)]
    json: bool,
    /// Also says whom a DICOM series is of, which otherwise nothing does. The picture never says it.
    #[arg(long)]
    with_identity: bool,
    /// Writes a picture of three planes.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
}

impl InspectArgs {
    /// What is at `path`, as text and without a picture.
    pub(super) fn of(path: PathBuf) -> Self {
        Self {
            input: input::Input::of(path),
            json: false,
            with_identity: false,
            png: None,
        }
    }
}

/// Why there is no summary.
#[derive(Debug, thiserror::Error)]
pub(crate) enum InspectError {
    /// The examination was refused.
    #[error(transparent)]
    Input(#[from] input::InputError),
    /// It could not be read to its end.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The picture was not written.
    #[error(transparent)]
    Png(#[from] PngError),
    /// One picture of several series.
    #[error("the folder holds {found} series: choose the one for --png with --series N, from 1 to {found}")]
    WhichPicture {
        /// How many there are.
        found: usize,
    },
    /// Some series cannot be loaded; why stands above.
    #[error("{refused} of {of} series cannot be loaded")]
    Some {
        /// How many.
        refused: usize,
        /// Of how many.
        of: usize,
    },
    /// The summary was not put into JSON.
    #[error("the summary as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Inspects, prints, and writes the picture. Of a folder with several series each is inspected.
///
/// # Errors
/// [`InspectError`]; where one of several series is refused, the others are still printed.
pub(crate) fn run(args: &InspectArgs) -> Result<(), InspectError> {
    let inputs = args.input.each_series()?;
    if let [input] = &inputs[..] {
        return report(&one(args, input)?, args.json);
    }
    if args.png.is_some() {
        return Err(InspectError::WhichPicture { found: inputs.len() });
    }
    let (mut summaries, mut refused) = (Vec::new(), 0);
    for (number, input) in (1..).zip(&inputs) {
        match one(args, input) {
            Ok(summary) if args.json => summaries.push(summary),
            Ok(summary) => say(&format!("series {number}\n{summary}\n")),
            Err(error) => {
                refused += 1;
                bus::stderr_line!("volume-loader: series {number}: {error}");
            }
        }
    }
    if args.json {
        say(&(serde_json::to_string_pretty(&summaries)? + "\n"));
    }
    match refused {
        0 => Ok(()),
        _ => Err(InspectError::Some {
            refused,
            of: inputs.len(),
        }),
    }
}

fn one(args: &InspectArgs, input: &input::Input) -> Result<Summary, InspectError> {
    let mut source = input.open()?;
    let window = args.png.as_ref().map(|_| WINDOW);
    let Inspection { mut summary, picture } = inspect(&mut source, window)?;
    if let (Some(path), Some(picture)) = (&args.png, picture) {
        write_png(path, &picture, &stamps(&summary))?;
    }
    if args.with_identity {
        let said = input.identity()?.into_iter();
        summary
            .extra
            .extend(said.map(|(name, text)| (name.to_owned(), text.into())));
    }
    Ok(summary)
}

fn report(summary: &Summary, json: bool) -> Result<(), InspectError> {
    let text = match json {
        true => serde_json::to_string_pretty(summary)? + "\n",
        false => summary.to_string(),
    };
    say(&text);
    Ok(())
}

/// To stdout; where nobody reads it any more, there is nobody to tell.
pub(super) fn say(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes());
}

/// What the picture says of itself in the file.
fn stamps(summary: &Summary) -> [(&'static str, String); 3] {
    let [nx, ny, nz] = summary.place.dims;
    [
        ("volume_hash", summary.hash.clone()),
        ("dims", format!("{nx} {ny} {nz}")),
        ("window", format!("{} {}", WINDOW.centre_hu, WINDOW.width_hu)),
    ]
}
