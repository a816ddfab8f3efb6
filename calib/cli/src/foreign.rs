//! `calib import`, `calib export` and `calib mesh`: calibrations, registrations and surfaces as other programs have them.

mod export;
mod holds;
mod import;
mod mesh;
#[cfg(test)]
mod tests;

pub(crate) use export::{EXPORT_HELP, ExportArgs};
pub(crate) use import::{IMPORT_HELP, ImportArgs};
pub(crate) use mesh::{MESH_HELP, MeshArgs, read as read_mesh};

use std::io::Read;
use std::path::{Path, PathBuf};

use exchange::Unsettled;
use exchange::itk::ItkError;
use exchange::mesh::MeshError;
use exchange::plus::PlusError;
use scene::file::OpenError;

use crate::commands::common::OwnError;

/// Why a file of another program is not read, or not written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ForeignError {
    #[error("reading {path}: {source}")]
    Open { path: PathBuf, source: OpenError },
    #[error("reading {path}: {source}")]
    Itk { path: PathBuf, source: Box<ItkError> },
    #[error("reading {path}: {source}")]
    Plus { path: PathBuf, source: Box<PlusError> },
    #[error("{path}: {source}")]
    Mesh { path: PathBuf, source: Box<MeshError> },
    #[error("{path}: the kind of surface is told by its ending; .stl, .ply, .obj and .vtk are known")]
    Surface { path: PathBuf },
    #[error("reading {path}: {source}")]
    Own {
        path: PathBuf,
        source: calib::file::FileError,
    },
    #[error("{path}: the tip's place in the marker: {source}")]
    Unsettled { path: PathBuf, source: Unsettled },
    #[error(
        "{path}: the kind of file is told by its ending; .tfm, .txt and .h5 of ITK and .xml of PLUS are known{more}"
    )]
    Ending { path: PathBuf, more: &'static str },
    #[error("{path}: {what}")]
    Lacks { path: PathBuf, what: &'static str },
    #[error("{path}: --holds {holds} says nothing of this file, which holds {has}")]
    OtherFrames { path: PathBuf, holds: String, has: String },
    #[error(
        "{path} has {has} alone, the way back: if {from} is the tool's frame, say --backwards; if {to} is, exchange --from and --to. The two put \
         the tip at different places"
    )]
    Back {
        path: PathBuf,
        has: String,
        from: String,
        to: String,
    },
    #[error("{path} has {has}, the way there, and --backwards says that it has the way back alone")]
    There { path: PathBuf, has: String },
    #[error(
        "{path}: its matrix is no rotation, and the nearest one moves the {what} by {moved}: more than a tenth of the error that you say, \
         {said}. Make the file anew with more digits, or say the error that it has"
    )]
    Moved {
        path: PathBuf,
        what: &'static str,
        moved: String,
        said: String,
    },
    #[error("what is made of {path} would not be read as a calibration: {source}")]
    Unreadable {
        path: PathBuf,
        source: calib::file::FileError,
    },
    #[error("the tool's frame of {path}: {refused}")]
    Frame {
        path: PathBuf,
        refused: Box<calib::spin::Refused>,
    },
}

impl OwnError for ForeignError {}

/// A kind of file, by its ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Itk,
    Hdf5,
    Plus,
}

impl Format {
    fn of(path: &Path) -> Result<Self, ForeignError> {
        let ending = path
            .extension()
            .map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("tfm" | "txt") => Ok(Self::Itk),
            Some("h5" | "hdf5") => Ok(Self::Hdf5),
            Some("xml") => Ok(Self::Plus),
            _ => Err(ForeignError::Ending {
                path: path.to_owned(),
                more: "",
            }),
        }
    }
}

/// The bytes of a regular file of at most so many.
pub(crate) fn bytes(path: &Path, most: usize) -> Result<Vec<u8>, ForeignError> {
    let fail = |source| ForeignError::Open {
        path: path.to_owned(),
        source,
    };
    let most = most as u64;
    let (file, about) = scene::file::open(path).map_err(fail)?;
    let too_long = |found| fail(OpenError::TooLong { found, most });
    if about.len() > most {
        return Err(too_long(about.len()));
    }
    let mut bytes = Vec::new();
    // It may grow while it is read.
    let read = file.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| fail(error.into()))?;
    match bytes.len() as u64 > most {
        true => Err(too_long(bytes.len() as u64)),
        false => Ok(bytes),
    }
}
