//! `pilot choose`, `mark`, `hold` and `follow`: what a person asks of a run that is going, without a window.

use bus::message::{Command, CommandKind};
use clap::Subcommand;
use clap::builder::NonEmptyStringValueParser;

use super::ask::{ask_process, newest_pose};
use super::error::CliError;

const CHOOSE_HELP: &str = "\
The distance on every image is that to the chosen target, and no other takes its place, however near the tip comes to it.

Examples:
  pilot choose para-aortic-left        a target of the scene, by its name
  pilot choose --none                  nothing is aimed at
  pilot status                         what is chosen";

const MARK_HELP: &str = "\
The words stand in the recording's /log, with the moment.

Example:
  pilot mark first biopsy taken";

const HOLD_HELP: &str = "\
Every screen holds the newest pose until `pilot follow`. The images that renderers publish go on.

Example:
  pilot hold";

const FOLLOW_HELP: &str = "\
Example:
  pilot follow";

/// What a person asks of a run that is going.
#[derive(Debug, Subcommand)]
pub(crate) enum GuideVerb {
    /// Chooses the target that is aimed at.
    #[command(after_help = CHOOSE_HELP)]
    Choose {
        /// Its name in the scene.
        #[arg(required_unless_present = "none", value_parser = NonEmptyStringValueParser::new())]
        target: Option<String>,
        /// None is aimed at.
        #[arg(long, conflicts_with = "target")]
        none: bool,
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Notes this moment, with these words, in the recording.
    #[command(after_help = MARK_HELP)]
    Mark {
        /// The words, of 96 bytes at most.
        #[arg(required = true)]
        words: Vec<String>,
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Has all screens hold the newest pose.
    #[command(after_help = HOLD_HELP)]
    Hold {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Has all screens follow the tool again.
    #[command(after_help = FOLLOW_HELP)]
    Follow {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
}

impl GuideVerb {
    /// Asks the run; what it answered.
    ///
    /// # Errors
    /// As [`ask_process`]; [`CliError::TooLong`] for words that a request has no room for, [`CliError::NoPose`].
    pub(crate) fn carry_out(&self) -> Result<String, CliError> {
        let (run, command) = match self {
            Self::Choose { target, run, .. } => {
                let name = target.as_deref().unwrap_or_default();
                (run, with_text(CommandKind::Choose, name)?)
            }
            Self::Mark { words, run } => (run, with_text(CommandKind::Mark, &words.join(" "))?),
            Self::Hold { run } => (run, Command::hold(newest_pose(run)?)),
            Self::Follow { run } => (run, Command::new(CommandKind::Follow)),
        };
        ask_process(run, "pilot", command, |_| Ok(()))
    }
}

/// Words that are cut off would be other words.
fn with_text(kind: CommandKind, text: &str) -> Result<Command, CliError> {
    match text.len() <= Command::TEXT {
        true => Ok(Command::with_text(kind, text)),
        false => Err(CliError::TooLong {
            found: text.len(),
            most: Command::TEXT,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_whole_or_refused() {
        let fits = "é".repeat(Command::TEXT / 2);
        assert_eq!(with_text(CommandKind::Mark, &fits).unwrap().words(), fits);
        let said = with_text(CommandKind::Mark, &format!("{fits}a"))
            .unwrap_err()
            .to_string();
        assert!(said.contains("97 bytes; at most 96"), "{said}");
    }
}
