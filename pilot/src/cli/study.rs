//! `pilot study`: whole operations in silico. They are done by `study`.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Args;

use crate::cli::error::CliError;
use crate::spawn;

pub(crate) const STUDY_HELP: &str = "\
Starts `study`, which takes the same words (`study --help` says what a study file holds): seeded operations go the whole way, from the \
calibration of the marker to the target, by the functions and files of the real chain and in virtual time, and what the poses predicted of their error is \
held against the simulator's truth. A folder that an earlier run of the same study has left is gone on with.

Examples:
  pilot study config/study/small.toml --out DIR
  pilot study config/study/accuracy.toml --out DIR --threads 2";

#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// Study files, `--out DIR` and other options of `study`.
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        required = true,
        value_name = "FILE.toml ... --out DIR"
    )]
    words: Vec<OsString>,
}

/// Hands over to `study`; its exit code is the pilot's.
pub(crate) fn study(args: &StudyArgs) -> Result<ExitCode, CliError> {
    let status = spawn::hand_over("study", &args.words)?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}
