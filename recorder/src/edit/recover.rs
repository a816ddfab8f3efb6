//! Makes a whole file of everything that can be read in an unfinished or damaged one.

use std::fs::{self, File};
use std::io::{BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use mcap::{McapResult, Writer};
use scene::Compression;

use crate::edit::progress::Progress;
use crate::edit::recovered;
use crate::read::damage::OpenError;
use crate::read::info::Info;
use crate::read::scan::{self, Item, Scan};
use crate::write::file_error::words;
use crate::write::paths;
use crate::write::pose_log;
use crate::write::session_file::synced;

/// Why a file could not be made whole.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// Nothing can be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The name of the new file cannot be told.
    #[error("{0} does not end in .recording, so the new file's name cannot be told: give it with --out FILE.mcap")]
    NoName(PathBuf),
    /// There is such a file.
    #[error("{0} exists already. Give another name with --out FILE.mcap, or --force to replace it")]
    Exists(PathBuf),
    /// The new file would replace the old one.
    #[error("{0} would be replaced by what is readable of it. Give another name with --out FILE.mcap")]
    Itself(PathBuf),
    /// The new file cannot be written.
    #[error("writing {path}: {why}. The old file is as it was; make room, or give another place with --out FILE.mcap")]
    Write {
        /// The new file, under its temporary name.
        path: PathBuf,
        /// Why.
        why: String,
    },
}

/// The name of the whole file: `out`, or `input` without `.recording`.
///
/// # Errors
/// [`RecoverError::NoName`], [`RecoverError::Exists`] unless `force`, [`RecoverError::Itself`].
pub fn target(input: &Path, out: Option<PathBuf>, force: bool) -> Result<PathBuf, RecoverError> {
    let out = out.or_else(|| paths::without_recording(input));
    let out = out.ok_or_else(|| RecoverError::NoName(input.to_owned()))?;
    let same = |a: &Path, b: &Path| fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b));
    if same(input, &out) {
        return Err(RecoverError::Itself(out));
    }
    if out.exists() && !force {
        return Err(RecoverError::Exists(out));
    }
    Ok(out)
}

/// Copies everything readable in `input` to a whole file `out`, which is replaced if it exists; see [`target`]. Until
/// the copy is whole and on disk it has another name.
///
/// # Errors
/// [`RecoverError::Open`], [`RecoverError::Write`].
pub fn recover(input: &Path, out: &Path) -> Result<Info, RecoverError> {
    let scan = scan::open(input)?;
    let partial = paths::partial(out);
    let copied = copy(scan, input, &partial).and_then(|info| {
        fs::rename(&partial, out)?;
        paths::sync_folder(out)?;
        Ok(info)
    });
    copied.map_err(|e| {
        // What is there of the copy is of no use; if it cannot be removed, its name says so.
        let _ = fs::remove_file(&partial);
        RecoverError::Write {
            path: partial,
            why: words(&e),
        }
    })
}

fn copy(scan: Scan<impl Read>, input: &Path, partial: &Path) -> McapResult<Info> {
    let (file, info) = copy_into(scan, input, BufWriter::new(File::create(partial)?))?;
    synced(file)?;
    Ok(info)
}

fn copy_into<W: Write + Seek>(mut scan: Scan<impl Read>, input: &Path, sink: W) -> McapResult<(W, Info)> {
    let mut out = pose_log::options(Compression::Zstd).create(sink)?;
    let mut info = Info::default();
    let mut progress = Progress::new("recovering");
    while let Some(item) = scan.next() {
        let (read, length) = scan.progress();
        progress.at(read, length);
        match item {
            Ok(item) => {
                put(&mut out, &item)?;
                info.take(Ok(&item));
            }
            Err(damage) => info.take(Err(damage)),
        }
    }
    if let Some(losses) = recovered::record(input, &info.damage) {
        out.write_metadata(&losses)?;
    }
    out.finish()?;
    Ok((out.into_inner(), info))
}

/// Copies what was read.
pub(crate) fn put<W: Write + Seek>(out: &mut Writer<W>, item: &Item) -> McapResult<()> {
    match item {
        Item::Channel(channel) => {
            if let Some(schema) = &channel.schema {
                out.add_schema_with_id(schema.id, &schema.name, &schema.encoding, &schema.data)?;
            }
            let schema = channel.schema.as_ref().map_or(0, |schema| schema.id);
            let (topic, encoding) = (&channel.topic, &channel.message_encoding);
            out.add_channel_with_id(channel.id, schema, topic, encoding, &channel.metadata)?;
            Ok(())
        }
        Item::Message(message) => out.write(message),
        Item::Attachment(file) => out.attach(file),
        Item::Metadata(facts) => out.write_metadata(facts),
    }
}

#[cfg(test)]
mod tests;
