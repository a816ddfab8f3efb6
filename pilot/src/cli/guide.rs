//! `pilot choose`, `images`, `mark`, `hold` and `follow`: what a person asks of a run that is going, without a window.

use bus::message::{Change, Command, CommandKind, ImagesWish};
use clap::Subcommand;
use clap::builder::NonEmptyStringValueParser;
use scene::WindowLevel;

use super::ask::{ask_process, newest_pose};
use super::error::CliError;

const CHOOSE_HELP: &str = "\
The distance on every image is that to the chosen target, and no other takes its place, however near the tip comes to it.

Examples:
  pilot choose para-aortic-left        a target of the scene, by its name
  pilot choose --none                  nothing is aimed at
  pilot status                         what is chosen";

const IMAGES_HELP: &str = "\
Images of poses that are captured from now on; each says its own window and field. What is not named stays as it is.

Examples:
  pilot images --window bone           abdomen, soft-tissue, bone, lung or vessels
  pilot images --window 40,400         centre and width, HU
  pilot images --field 60              what the shorter side of local images shows, mm
  pilot images --organs rest           organs that a model moves as the examination has them; moved: as the model has them
  pilot images --scene                 all are the scene's again
  pilot status                         what holds";

const MARK_HELP: &str = "\
The words stand in the recording's /log, with the moment.

Example:
  pilot mark first biopsy taken";

const HOLD_HELP: &str = "\
Every screen holds the newest pose until `pilot follow`. The images that renderers publish go on.

Example:
  pilot hold";

const CONFIRM_HELP: &str = "\
Another hash than that of the run's examination is refused, and takes a confirmation back.

Example:
  pilot confirm 366cff1c...            as `pilot status --json` has it under volume.hash";

const REJECT_HELP: &str = "\
Example:
  pilot reject";

const NAVIGATE_HELP: &str = "\
A scene with `strict = true` under [workflow] demands a confirmed examination and a check that was passed; research runs start by \
themselves.

Example:
  pilot navigate";

const REST_HELP: &str = "\
Example:
  pilot rest";

const MOVED_HELP: &str = "\
Example:
  pilot moved                          and then: pilot steps check";

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
    /// Changes the window of all images and the field of local ones.
    #[command(after_help = IMAGES_HELP)]
    Images {
        /// How HU become grey: a name, or centre and width in HU.
        #[arg(long, value_name = "NAME|C,W", value_parser = window, allow_hyphen_values = true, required_unless_present_any = ["field", "organs", "scene"])]
        window: Option<WindowLevel>,
        /// What the shorter side of local images shows.
        #[arg(long, value_name = "MM", allow_hyphen_values = true)]
        field: Option<f64>,
        /// Organs that a model moves: as the examination has them, or where the model has them.
        #[arg(long, value_name = "rest|moved", value_parser = at_rest)]
        organs: Option<bool>,
        /// What is not named here is the scene's again.
        #[arg(long)]
        scene: bool,
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
    /// Says that the examination is the patient's, by its hash as the screen or `pilot status` shows it.
    #[command(after_help = CONFIRM_HELP)]
    Confirm {
        /// The hash: 64 hexadecimal digits.
        hash: String,
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Says that the examination is not the patient's: nothing is navigated until one is confirmed.
    #[command(after_help = REJECT_HELP)]
    Reject {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Starts the navigation, where all that the scene demands has been done.
    #[command(after_help = NAVIGATE_HELP)]
    Navigate {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Ends the navigation; the run goes on.
    #[command(after_help = REST_HELP)]
    Rest {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
    },
    /// Says that the marker on the patient was moved, or may have been: the registration must be checked before anybody navigates on.
    #[command(after_help = MOVED_HELP)]
    Moved {
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
            Self::Images {
                window,
                field,
                organs,
                scene,
                run,
            } => {
                let wish = ImagesWish {
                    field_mm: change(*field, *scene),
                    window: change(*window, *scene),
                    at_rest: change(*organs, *scene),
                };
                (run, Command::images(wish))
            }
            Self::Mark { words, run } => (run, with_text(CommandKind::Mark, &words.join(" "))?),
            Self::Confirm { hash, run } => (run, with_text(CommandKind::Confirm, hash)?),
            Self::Reject { run } => (run, Command::new(CommandKind::Reject)),
            Self::Navigate { run } => (run, Command::new(CommandKind::Navigate)),
            Self::Rest { run } => (run, Command::new(CommandKind::Rest)),
            Self::Moved { run } => (run, Command::new(CommandKind::Bumped)),
            Self::Hold { run } => (run, Command::hold(newest_pose(run)?)),
            Self::Follow { run } => (run, Command::new(CommandKind::Follow)),
        };
        ask_process(run, "pilot", command, |_| Ok(()))
    }
}

fn change<T>(value: Option<T>, scene: bool) -> Change<T> {
    match value {
        Some(value) => Change::Set(value),
        None if scene => Change::Scene,
        None => Change::Keep,
    }
}

fn at_rest(text: &str) -> Result<bool, String> {
    match text {
        "rest" => Ok(true),
        "moved" => Ok(false),
        _ => Err("expected rest or moved".to_owned()),
    }
}

/// A window by its name, or its centre and width.
fn window(text: &str) -> Result<WindowLevel, String> {
    let numbers = || {
        let (centre, width) = text.split_once(',')?;
        Some(WindowLevel {
            centre_hu: centre.trim().parse().ok()?,
            width_hu: width.trim().parse().ok()?,
        })
    };
    let found = WindowLevel::named(text).or_else(numbers);
    found.ok_or_else(|| {
        "expected abdomen, soft-tissue, bone, lung or vessels, or centre and width in HU as 40,400".to_owned()
    })
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
    fn a_window_is_a_name_or_two_numbers() {
        let of = |text| window(text).map(|w| (w.centre_hu, w.width_hu));
        assert_eq!(of("bone"), Ok((400.0, 2000.0)));
        assert_eq!(of("-600, 1500"), Ok((-600.0, 1500.0)));
        for bad in ["Bone", "40", "40,", "40,400,1", ""] {
            assert!(of(bad).unwrap_err().contains("soft-tissue"), "{bad}");
        }
    }

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
