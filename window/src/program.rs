//! What the window's screens have in common as a program: what it is told, why it ends, pictures of the screen.

use std::path::{Path, PathBuf};

use bus::BusError;
use bus::process::JoinError;
use bus::volume::LabelMap;
use guidance::safety::LabelNames;
use scene::VolumeSpec;

use crate::display::{DisplayError, Wanted};
use crate::paint::{PaintError, canvas};

type Read<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// Reads label maps: handed in by the binary, as this crate knows no formats of volumes.
#[derive(Debug, Clone, Copy)]
pub struct LabelReader {
    /// The map of an examination, as a volume.
    pub map: fn(&Path, &VolumeSpec) -> Read<LabelMap>,
    /// The names that it comes with.
    pub names: fn(&Path) -> Read<LabelNames>,
}

/// Why a window ended.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// There is no display, or it was lost.
    #[error(transparent)]
    Display(#[from] DisplayError),
    /// A frame was not painted.
    #[error(transparent)]
    Paint(#[from] PaintError),
}

/// What the command line says.
#[derive(Debug, Clone)]
pub(crate) struct Options {
    pub(crate) wanted: Wanted,
    pub(crate) only_sight: bool,
    /// Where pictures of the screen go.
    pub(crate) shots: PathBuf,
    /// The process's name in the run.
    pub(crate) name: String,
    /// Reads a label map, for the planning screen.
    pub(crate) load: LabelReader,
}

/// Writes a picture of the screen, by a thread of its own.
pub(crate) fn write_shot(pixels: &[u32], size: [u32; 2], path: PathBuf) -> Result<(), String> {
    let picture = canvas(pixels, size);
    let write = move || match picture::write_png(&path, &picture, &[]) {
        Ok(()) => {}
        Err(error) => bus::stderr_line!("window: {error}"),
    };
    let started = std::thread::Builder::new().name("screenshot".to_owned()).spawn(write);
    started.map(drop).map_err(|error| format!("no screenshot: {error}"))
}
