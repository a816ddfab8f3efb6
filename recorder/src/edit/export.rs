//! The messages of a topic as a table (CSV), as JSON, or as a sequence for the PLUS toolkit (MHA); the images of an ultrasound probe as
//! such a sequence too.
//!
//! What cannot be read is passed over and counted. A lost pose has no numbers: its cells are empty (`null` in JSON), and
//! its status says why. Numbers are written with as many digits as bring back the same bits.

pub mod follow;
mod images;
mod rows;
pub(crate) mod sequence;

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::edit::progress::Progress;
use crate::read::damage::OpenError;
use crate::read::reader;
use crate::read::scan::{self, Item};
use crate::write::paths;
use follow::FollowMarkers;
pub use images::ExportedImages;
use rows::Row;

/// The form of the new file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A table, comma-separated, with a header.
    Csv,
    /// A list of objects.
    Json,
    /// A sequence of the PLUS toolkit: poses, or images with --images.
    Mha,
}

/// Why nothing was exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Nothing can be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// There is such a file.
    #[error("{0} exists already. Give another name with --out FILE, or --force to replace it")]
    Exists(PathBuf),
    /// The topic is not there, or nothing that can be exported.
    #[error("{path}: no message of topic {topic:?} can be exported as {form}. {found}")]
    NoMessages {
        /// The recording.
        path: PathBuf,
        /// The topic asked for.
        topic: String,
        /// The form asked for.
        form: &'static str,
        /// What there is.
        found: String,
    },
    /// Its images make no sequence.
    #[error("the images of {path}: {why}")]
    Images {
        /// The recording.
        path: PathBuf,
        /// Why, in words.
        why: String,
    },
    /// Images go into a sequence only.
    #[error("--images goes with mha only: images are no {0}")]
    ImagesAs(&'static str),
    /// The new file cannot be written.
    #[error("writing {path}: {source}")]
    Write {
        /// The new file, under its temporary name.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// What was exported.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Exported {
    /// Messages.
    pub messages: u64,
    /// Parts of the recording, or messages, that could not be read.
    pub unreadable: u64,
}

/// Writes the messages of `topic` of the recording `input` to `out`, which is replaced only where `force` is.
///
/// # Errors
/// Each variant of [`ExportError`]; a new file is then not there.
pub fn export(input: &Path, topic: &str, format: Format, out: &Path, force: bool) -> Result<Exported, ExportError> {
    whole(out, force, |file| {
        let exported = match format {
            Format::Mha => sequence::write(input, topic, file),
            Format::Csv | Format::Json => table(input, topic, format, file),
        }?;
        match exported.messages {
            0 => Err(none(input, topic, format)),
            _ => Ok(exported),
        }
    })
}

/// Writes the images of the recording `input` to `out`, which is replaced only where `force` is: a sequence in which each image has the
/// poses that its scene's markers, followed by `follow`, had at its stamp.
///
/// # Errors
/// [`ExportError`]; a new file is then not there.
pub fn export_images(
    input: &Path,
    follow: FollowMarkers,
    out: &Path,
    force: bool,
) -> Result<ExportedImages, ExportError> {
    whole(out, force, |file| images::write(input, follow, file))
}

/// Makes the file `out` of what `write` writes, or none.
fn whole<T>(
    out: &Path,
    force: bool,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<T, ExportError>,
) -> Result<T, ExportError> {
    if out.exists() && !force {
        return Err(ExportError::Exists(out.to_owned()));
    }
    let partial = paths::partial(out);
    let fail = |source| ExportError::Write {
        path: partial.clone(),
        source,
    };
    let mut file = BufWriter::new(File::create(&partial).map_err(fail)?);
    let written = write(&mut file).map_err(|error| match error {
        ExportError::Write { source, .. } => fail(source),
        other => other,
    });
    let written = written.and_then(|exported| {
        let named = file.flush().and_then(|()| fs::rename(&partial, out));
        named.map(|()| exported).map_err(fail)
    });
    if written.is_err() {
        // Of no use; if it cannot be removed, its name says so.
        let _ = fs::remove_file(&partial);
    }
    written
}

fn none(input: &Path, topic: &str, format: Format) -> ExportError {
    let found = match crate::read::info::info(input) {
        Ok(info) => {
            let topics = info.tally.topics.iter().filter(|(_, topic)| topic.messages > 0);
            let names: Vec<_> = topics
                .map(|(name, topic)| format!("{name} ({})", topic.schema))
                .collect();
            format!(
                "It holds: {}",
                if names.is_empty() {
                    "nothing".to_owned()
                } else {
                    names.join(", ")
                }
            )
        }
        Err(error) => error.to_string(),
    };
    ExportError::NoMessages {
        path: input.to_owned(),
        topic: topic.to_owned(),
        form: match format {
            Format::Csv => "a table",
            Format::Json => "JSON",
            Format::Mha => "a sequence of poses",
        },
        found,
    }
}

fn write_error(source: io::Error) -> ExportError {
    let path = PathBuf::from("the new file");
    ExportError::Write { path, source }
}

fn table(input: &Path, topic: &str, format: Format, out: &mut impl Write) -> Result<Exported, ExportError> {
    let mut exported = Exported::default();
    let mut scan = scan::open(input)?;
    let mut progress = Progress::new("exporting");
    let mut first = true;
    while let Some(item) = scan.next() {
        let (read, length) = scan.progress();
        progress.at(read, length);
        let message = match item {
            Ok(Item::Message(message)) if message.channel.topic == topic => message,
            Ok(_) => continue,
            Err(damage) => {
                exported.unreadable += u64::from(!damage.fault.is_mere_ending());
                continue;
            }
        };
        let Ok(rows) = rows::of(&message) else {
            exported.unreadable += 1;
            continue;
        };
        exported.messages += 1;
        for row in rows {
            write_row(out, format, &row, &mut first).map_err(write_error)?;
        }
    }
    if format == Format::Json && !first {
        out.write_all(b"\n]\n").map_err(write_error)?;
    }
    Ok(exported)
}

fn write_row(out: &mut impl Write, format: Format, row: &Row, first: &mut bool) -> io::Result<()> {
    let is_first = std::mem::replace(first, false);
    if format == Format::Json {
        out.write_all(if is_first { b"[\n" } else { b",\n" })?;
        return rows::write_json(out, row);
    }
    if is_first {
        let names: Vec<_> = row.iter().map(|(name, _)| *name).collect();
        writeln!(out, "{}", names.join(","))?;
    }
    for (index, (_, cell)) in row.iter().enumerate() {
        out.write_all(if index == 0 { b"" } else { b"," })?;
        cell.write_csv(out)?;
    }
    out.write_all(b"\n")
}

#[cfg(test)]
mod tests;
