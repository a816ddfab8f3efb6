//! A sequence of the PLUS toolkit (MHA) as a recording.
//!
//! Of each frame one transform is taken, or composed of those that lead there ([`geometry::named`]), as the pose it is said to be: `/tool_pose` says `ct_from_tool`, and what the
//! sequence calls it is in the metadata `imported`. Times are those of the sequence from its first frame on, rounded to ns.
//! Where a frame has no such transform, or the status of any that it is composed of is not OK, the pose is lost. Error of a rotation: that of its digits,
//! at most [`MOST_OFF`] from the nearest rotation, which is taken.

mod header;

use std::collections::BTreeMap;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use bus::clock;
use bus::message::{Lost, ToolPose, Tracked};
use geometry::named::{Chain, Disagree, NamedRigid};
use geometry::rotation::{RotationError, RotationMatrix};
use geometry::{Rigid, Vector};
use mcap::records::Metadata;
use scene::Compression;

use crate::wire::schema::Source;
use crate::write::file_error::words;
use crate::write::paths;
use crate::write::pose_log::{Entry, PoseLog};
use crate::write::sink::Sink;
use header::Frame;

/// Farthest that a matrix may be from a rotation (Frobenius): six digits are within 1e-5.
pub const MOST_OFF: f64 = 1e-3;
/// A chunk is closed after so many poses.
const PER_CHUNK: usize = 1000;

/// The name of the metadata record that says what was imported.
pub const IMPORTED: &str = "imported";

/// Why nothing was imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The sequence cannot be read.
    #[error("reading {path}: {source}")]
    Read {
        /// The sequence.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Something is wrong in its header.
    #[error("{path}, line {line}: {what}")]
    Line {
        /// The sequence.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A matrix is no rotation.
    #[error("{path}, line {line}: the matrix is not a rotation: {source}")]
    Rotation {
        /// The sequence.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong.
        source: RotationError,
    },
    /// The transform cannot be told.
    #[error("{path}: {asked}. It has: {found}. Name one with --transform NAME")]
    Transform {
        /// The sequence.
        path: PathBuf,
        /// What was asked for.
        asked: String,
        /// What there is.
        found: String,
    },
    /// Two chains of transforms end apart.
    #[error("{path}, frame {frame}: {source}. Name one of the transforms that are in the file with --transform NAME")]
    Disagree {
        /// The sequence.
        path: PathBuf,
        /// Its number in the file.
        frame: u32,
        /// How far.
        source: Disagree,
    },
    /// There is such a file.
    #[error("{0} exists already. Give another name with --out FILE.mcap, or --force to replace it")]
    Exists(PathBuf),
    /// The new file cannot be written.
    #[error("writing {path}: {why}")]
    Write {
        /// The new file, under its temporary name.
        path: PathBuf,
        /// Why.
        why: String,
    },
}

/// What was imported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Imported {
    /// The transform's name in the sequence.
    pub transform: String,
    /// Frames.
    pub frames: u64,
    /// Frames without a valid transform.
    pub lost: u64,
}

/// Makes the recording `out` of the sequence `input`; an existing one is replaced only where `force` is.
///
/// # Errors
/// Each variant of [`ImportError`]; a new file is then not there.
pub fn import(input: &Path, transform: Option<&str>, out: &Path, force: bool) -> Result<Imported, ImportError> {
    if out.exists() && !force {
        return Err(ImportError::Exists(out.to_owned()));
    }
    let read = |source| ImportError::Read {
        path: input.to_owned(),
        source,
    };
    let open = || {
        Ok(BufReader::new(
            scene::file::open(input).map_err(|error| read(error.into()))?.0,
        ))
    };
    // Which transforms lead to the one that is asked for is known at the header's end only.
    let chain = header::chosen(input, transform, &header::names(input, open()?)?)?;
    let names: Vec<&str> = chain.names().into_iter().collect();
    let poses = poses(input, &header::frames(input, open()?, &names)?, &chain, &names)?;
    let name = match (chain.links(), transform) {
        ([link], _) if !link.inverse => link.name.clone(),
        (_, asked) => format!("{} ({chain})", asked.unwrap_or_default()),
    };
    let partial = paths::partial(out);
    let write = |why: String| ImportError::Write {
        path: partial.clone(),
        why,
    };
    let written = write_poses(&partial, input, &name, &poses);
    if let Err(error) = written {
        // Of no use; if it cannot be removed, its name says so.
        let _ = std::fs::remove_file(&partial);
        return Err(write(words(&error)));
    }
    std::fs::rename(&partial, out).map_err(|e| write(e.to_string()))?;
    Ok(Imported {
        transform: name,
        frames: poses.len() as u64,
        lost: poses.iter().filter(|pose| pose.status != 0).count() as u64,
    })
}

/// The frames in the order of their numbers.
fn poses(
    path: &Path,
    frames: &BTreeMap<u32, Frame>,
    chain: &Chain,
    names: &[&str],
) -> Result<Vec<ToolPose>, ImportError> {
    let began = frames.values().find_map(|frame| frame.time_s).unwrap_or(0.0);
    let pose = |(seq, (number, frame)): (u64, (&u32, &Frame))| {
        let t_ns = clock::seconds(frame.time_s.unwrap_or(began) - began);
        let mut pose = ToolPose {
            seq,
            t_device_ns: clock::seconds(frame.time_s.unwrap_or(began)),
            t_capture_ns: t_ns,
            t_publish_ns: t_ns,
            ..ToolPose::EMPTY
        };
        // What is not valid is not looked at.
        let valid = frame
            .matrices
            .iter()
            .zip(&frame.bad)
            .map(|(m, bad)| m.as_ref().filter(|_| !bad));
        let links = valid.map(|m| m.map(|(line, matrix)| rigid(path, *line, matrix)).transpose());
        let links: Vec<Option<NamedRigid>> = links.collect::<Result<_, _>>()?;
        let of = |name: &str| links[names.iter().position(|n| *n == name)?];
        let composed = chain.pose(of).map_err(|source| ImportError::Disagree {
            path: path.to_owned(),
            frame: *number,
            source,
        })?;
        pose.set(match composed {
            Some(p) => {
                let [x, y, z] = p.translation_mm();
                Tracked::Valid(Rigid::from_parts(p.rotation(), Vector::new(x, y, z)))
            }
            None => Tracked::Lost(Lost::NotSeen),
        });
        Ok(pose)
    };
    (0..).zip(frames).map(pose).collect()
}

fn rigid(path: &Path, line: usize, m: &[f64; 16]) -> Result<NamedRigid, ImportError> {
    let bottom = [m[12], m[13], m[14], m[15] - 1.0];
    if bottom.iter().any(|x| x.abs() > 1e-6) {
        let found = &m[12..];
        return Err(ImportError::Line {
            path: path.to_owned(),
            line,
            what: format!("the last row of the matrix is {found:?} instead of 0 0 0 1"),
        });
    }
    let row = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
    let matrix = RotationMatrix::new([row(0), row(1), row(2)], MOST_OFF).map_err(|source| ImportError::Rotation {
        path: path.to_owned(),
        line,
        source,
    })?;
    Ok(Rigid::from_parts(matrix.rotation(), Vector::new(m[3], m[7], m[11])))
}

fn write_poses(partial: &Path, input: &Path, transform: &str, poses: &[ToolPose]) -> mcap::McapResult<()> {
    let file = std::sync::Arc::new(std::fs::File::create(partial)?);
    let mut log = PoseLog::new(Sink::new(std::sync::Arc::clone(&file)), Compression::Zstd, &[])?;
    let facts = [
        (
            "file",
            input.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        ),
        ("transform", transform.to_owned()),
        (
            "times",
            "from the sequence's first frame on; t_device_ns are the sequence's own".to_owned(),
        ),
    ];
    log.metadata(&Metadata {
        name: IMPORTED.to_owned(),
        metadata: facts.map(|(key, value)| (key.to_owned(), value)).into(),
    })?;
    for chunk in poses.chunks(PER_CHUNK) {
        for pose in chunk {
            log.put(Entry::Pose(Source::Tool, pose))?;
        }
        log.flush()?;
    }
    io::Write::flush(&mut log.finish()?)?;
    Ok(file.sync_all()?)
}

#[cfg(test)]
mod tests;
