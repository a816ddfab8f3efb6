//! Why a run's folder cannot be used.

use std::io;
use std::path::PathBuf;

use super::{MAX_DIR_BYTES, MAX_NAME, RUNTIME_DIR_VARIABLE};

/// Why a run's folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The name cannot be part of a path.
    #[error("run name {0:?}: allowed are 1 to {MAX_NAME} of the characters a-z, 0-9 and '-'")]
    Name(String),
    /// The path is too long for a socket.
    #[error(
        "run folder {0}: its path has more than {MAX_DIR_BYTES} bytes, and socket paths end at 107. \
         Set {RUNTIME_DIR_VARIABLE} to a shorter folder"
    )]
    TooLong(PathBuf),
    /// Another user owns the folder.
    #[error(
        "run folder {dir}: belongs to user {owner}, not to you ({me}). Set {RUNTIME_DIR_VARIABLE} to a folder of your own"
    )]
    Foreign {
        /// The folder.
        dir: PathBuf,
        /// Its owner's number.
        owner: u32,
        /// This process's user number.
        me: u32,
    },
    /// Others may change what lies in it.
    #[error(
        "folder {level}: {found}; who can write there could put another scene under a run. Close it to others (chmod), or set \
         {RUNTIME_DIR_VARIABLE} to a folder of your own"
    )]
    Open {
        /// The level of the run's folder.
        level: PathBuf,
        /// What it is.
        found: String,
    },
    /// No random numbers.
    #[error("drawing the name of the run's shared memory: {0}")]
    Random(io::Error),
    /// The run's files are not those that the pilot wrote.
    #[error(
        "{dir}: run.json or scene.toml is not what the pilot wrote when the run began: somebody has changed it. Nothing is \
         navigated by it"
    )]
    Changed {
        /// The run's folder.
        dir: PathBuf,
    },
    /// Another pilot holds the run.
    #[error(
        "run {name:?} is already going (pilot process {pid}). Stop it with `pilot stop --run {name}`, or start this one under another name with `--run NAME`"
    )]
    AlreadyRunning {
        /// The run.
        name: String,
        /// What the lock file says of its holder.
        pid: String,
    },
    /// Nobody holds the run.
    #[error("run {name:?} is not going. Start it with `pilot run SCENE --run {name}`")]
    NotRunning {
        /// The run.
        name: String,
    },
    /// A file operation failed.
    #[error("{doing} {path}: {source}")]
    Io {
        /// What was being done.
        doing: &'static str,
        /// With which file.
        path: PathBuf,
        /// Why it failed.
        source: io::Error,
    },
    /// The facts of the run cannot be read.
    #[error("reading {path}: {source}")]
    Facts {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
}
