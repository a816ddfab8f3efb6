//! `calib grid`: images of a regular grid of discs to the place of each disc.

pub(crate) mod discs;
pub(crate) mod overlay;
pub(crate) mod read;
mod record;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use optics::grid::{Found, GridSpec, Refinement, find};
use serde_json::Value;

use crate::commands::Outcome;
use crate::store::{self, StoreError};
use crate::text::shown;
use crate::values::Positive;
pub use read::{ReadImageError, read_image};

pub(crate) const GRID_HELP: &str = "\
Finds the grid in each image, gives each disc its column and row, and refines all centres: to a few thousandths of a \
pixel by one fit of the whole grid: on a plane, behind a lens where single discs show one, disc by disc where that is wrong \
too (a bent sheet). A pixel's centre is at whole coordinates, x \
to the right, y down. Column 0, row 0 is the corner from which columns go to the right and rows down. A square grid \
looks the same after a quarter turn, any grid after half a turn: which corner of the object that is, only large discs \
tell, whose columns and rows --mark gives. With them a view may show a part of the grid, if they tell which part; \
without them every border line must be seen.

A grid that is not of --cols and --rows is refused with what was seen, never cut to fit. Images are PNG, JPEG or PGM of \
8 or 16 bits, at most 8192 x 8192 pixels. The exit code is 1 if in one of the images no grid was found.

Examples:
  calib grid view.png --cols 16 --rows 14 --pitch-mm 5 --overlay seen
  calib grid near.png --cols 25 --rows 18 --pitch-mm 5 --mark 7,5 --mark 17,5 --mark 7,12
  calib grid views/*.png --cols 10 --rows 10 --pitch-mm 20 --out grid.json";

#[derive(Debug, Args)]
pub(crate) struct GridArgs {
    /// Images
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// Discs in a row
    #[arg(long)]
    cols: usize,
    /// Rows
    #[arg(long)]
    rows: usize,
    /// Distance of neighbouring discs
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pitch_mm: Positive,
    /// The discs are brighter than what is around them
    #[arg(long)]
    bright: bool,
    /// Column and row of a large disc, from 0; once for each
    #[arg(long = "mark", value_name = "COL,ROW")]
    marks: Vec<Mark>,
    /// Fit each disc by itself even where the lens does not seem to distort: for calib camera
    #[arg(long)]
    one_by_one: bool,
    /// Write what was found here, as JSON
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Draw what was found into this folder: NAME.grid.png for each image, NAME.2.grid.png for the second of a name
    #[arg(long, value_name = "FOLDER")]
    overlay: Option<PathBuf>,
    /// Replace --out if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Print the result as JSON and nothing else
    #[arg(long)]
    json: bool,
}

/// Where a large disc stands.
#[derive(Debug, Clone, Copy)]
struct Mark([usize; 2]);

impl FromStr for Mark {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<&str> = text.split(',').collect();
        let [col, row] = numbers[..] else {
            return Err(format!(
                "{} numbers; a column and a row are needed, as 7,5",
                numbers.len()
            ));
        };
        let parse = |part: &str| part.trim().parse::<usize>().map_err(|e| format!("{part:?}: {e}"));
        Ok(Self([parse(col)?, parse(row)?]))
    }
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum GridError {
    #[error(transparent)]
    Image(#[from] ReadImageError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Picture(#[from] picture::PngError),
    #[error("making the folder {path}: {source}. Check the name and the permissions")]
    Folder { path: PathBuf, source: std::io::Error },
}

impl GridArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, GridError> {
        if let Some(out) = &self.out {
            store::check(out, self.overwrite)?;
        }
        if let Some(path) = &self.overlay {
            let folder = |source| GridError::Folder {
                path: path.clone(),
                source,
            };
            std::fs::create_dir_all(path).map_err(folder)?;
        }
        let spec = GridSpec {
            bright: self.bright,
            marks: self.marks.iter().map(|m| m.0).collect(),
            one_by_one: self.one_by_one,
            ..GridSpec::new(self.cols, self.rows, self.pitch_mm.0)
        };
        let (mut text, mut records, mut refused) = (String::new(), Vec::new(), Vec::new());
        for (path, stem) in self.images.iter().zip(overlay::stems(&self.images)) {
            let (words, record, why) = self.one(path, &stem, &spec)?;
            text.push_str(&words);
            records.push(record);
            refused.extend(why);
        }
        let encoded = format!("{:#}\n", record::file(&spec, &records));
        if let Some(out) = &self.out {
            store::write(out, Ok(encoded.clone()), self.images.iter().map(PathBuf::as_path))?;
            text.push_str(&format!("written to {}\n", out.display()));
        }
        let text = if self.json { encoded } else { text };
        Ok(Outcome {
            text,
            refused: refused.into_iter().next(),
        })
    }

    /// Words, record and refusal of one image.
    fn one(&self, path: &Path, stem: &str, spec: &GridSpec) -> Result<(String, Value, Option<String>), GridError> {
        let image = read_image(path)?;
        let name = shown(&path.display().to_string());
        match find(&image, spec) {
            Ok(found) => {
                if let Some(folder) = &self.overlay {
                    overlay::write(&folder.join(format!("{stem}.grid.png")), &image, &found)?;
                }
                Ok((words(&name, &found), record::found(path, &image, spec, &found), None))
            }
            Err(refusal) => {
                let why = format!("looking for the grid in {name}: {refusal}");
                let record = record::refused(path, &image, &refusal, &why);
                Ok((format!("{why}\n"), record, Some(why)))
            }
        }
    }
}

fn words(name: &str, found: &Found) -> String {
    let worst = found
        .discs
        .iter()
        .map(|d| d.covariance.trace().max(0.0).sqrt())
        .fold(0.0, f64::max);
    let how = match found.refinement {
        Refinement::Whole => "fitted as a whole on a plane".to_owned(),
        Refinement::Lens => format!(
            "fitted as a whole behind a lens, {:.2} px RMS off a homography",
            found.homography_rms_px
        ),
        Refinement::Each => format!(
            "fitted one by one, {:.2} px RMS off a homography",
            found.homography_rms_px
        ),
    };
    let how = match found.misfit_px {
        0.0 => how,
        left => format!("{how}, which leaves {left:.4} px RMS (in the covariance)"),
    };
    let turns = match found.alike {
        1 => "turned as its large discs say".to_owned(),
        n => format!("one of {n} turns that look alike"),
    };
    format!(
        "{name}: {} discs of {}, {turns}, {how}; centres to {worst:.4} px by their covariance; blur {:.2} px, noise {:.1}\n",
        found.discs.len(),
        found.discs.len() + found.missing.len(),
        found.sigma,
        found.noise
    )
}
