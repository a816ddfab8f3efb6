//! `pilot replay-control`: steering a replay that is going.

use bus::message::{Command, CommandKind};
use clap::Subcommand;

use super::args::{place, speed};
use crate::cli::ask::ask_process;
use crate::cli::error::CliError;
use crate::plan::REPLAYER;

#[derive(Debug, Clone, PartialEq, Subcommand)]
pub(crate) enum Steer {
    /// Stand still; the images stay as they are, and do not grow old.
    #[command(after_help = "Example:\n  pilot replay-control pause")]
    Pause,
    /// Go on.
    #[command(after_help = "Example:\n  pilot replay-control play")]
    Play,
    /// Show the next pose and stand still.
    #[command(after_help = "Example:\n  pilot replay-control step")]
    Step,
    /// Show the pose before and stand still.
    #[command(after_help = "Example:\n  pilot replay-control back")]
    Back,
    /// Stand still, and write what is shown as files: the image of every view and what was known then.
    #[command(after_help = "Example:\n  pilot replay-control seek 3.2s && pilot replay-control moment")]
    Moment,
    /// Go on from another place: 3.2s behind the recording's first pose.
    #[command(after_help = "Example:\n  pilot replay-control seek 3.2s")]
    Seek {
        /// The place.
        #[arg(value_name = "TIME", value_parser = place)]
        at_s: f64,
    },
    /// Go on at another speed.
    #[command(after_help = "Example:\n  pilot replay-control speed 0.25 --run replay")]
    Speed {
        /// A number (1 is the speed of the recording), or `max`.
        #[arg(value_parser = speed)]
        speed: String,
    },
}

impl Steer {
    fn command(&self) -> Command {
        match self {
            Self::Pause => Command::new(CommandKind::Pause),
            Self::Play => Command::new(CommandKind::Play),
            Self::Step => Command::new(CommandKind::Step),
            Self::Back => Command::new(CommandKind::StepBack),
            Self::Moment => Command::new(CommandKind::Moment),
            Self::Seek { at_s } => Command::with_number(CommandKind::Seek, *at_s),
            // `max` reads as no number, and is infinite on the wire.
            Self::Speed { speed } => Command::with_number(CommandKind::Speed, speed.parse().unwrap_or(f64::INFINITY)),
        }
    }
}

/// Asks the replayer of `run`; returns where it stands.
pub(crate) fn steer(run: &str, steer: &Steer) -> Result<String, CliError> {
    ask_process(run, REPLAYER, steer.command(), |context| match context.replay {
        None => Err(CliError::NoReplay(run.to_owned())),
        Some(_) => Ok(()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_carry_their_number() {
        let number = |steer: Steer| steer.command().number;
        assert_eq!(number(Steer::Seek { at_s: 3.2 }), 3.2);
        assert_eq!(
            number(Steer::Speed {
                speed: "0.25".to_owned()
            }),
            0.25
        );
        assert_eq!(
            number(Steer::Speed {
                speed: "max".to_owned()
            }),
            f64::INFINITY
        );
        assert_eq!(Steer::Step.command().command_kind(), Some(CommandKind::Step));
    }
}
