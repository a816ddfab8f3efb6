//! Why a chore ended early.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{ExitCode, ExitStatus};

/// Why a chore ended early.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line asks for something that there is not.
    Usage(String),
    /// A program could not be started.
    Start { program: String, source: io::Error },
    /// A program ended with an error; what was wrong it has said itself.
    Ended { command: String, status: ExitStatus },
    /// A file or a folder of a chore.
    File { path: PathBuf, source: io::Error },
    /// Inputs that a parser does not survive lie in these folders.
    Fuzz(Vec<PathBuf>),
    /// A step of a chore failed.
    Step { name: &'static str, source: Box<Failure> },
}

impl Failure {
    /// What is wrong with a file.
    pub(crate) fn file(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        Self::File { path, source }
    }

    /// The exit code of the program that failed, so that scripts see what they would see without the chore; else 1.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Ended { status, .. } => status.code().and_then(|code| u8::try_from(code).ok()),
            _ => None,
        }
        .map_or(ExitCode::FAILURE, ExitCode::from)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(why) => f.write_str(why),
            Self::Start { program, source } => write!(f, "starting {program}: {source}; is it installed?"),
            Self::Ended { command, status } => write!(f, "`{command}` ended with {status}"),
            Self::File { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Fuzz(folders) => write!(f, "inputs that are not survived lie in {folders:?}"),
            Self::Step { name, source } => write!(f, "step {name:?} failed: {source}"),
        }
    }
}
