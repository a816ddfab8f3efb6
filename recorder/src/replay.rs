//! Replays a recording: its poses on the topics of the tracker, with the stamps and the numbers that they had; or, in their
//! place, the frames of emitters that they were made of, for a tracker that makes poses of them again.
//!
//! * [`facts`]: what must be known of a recording before it is replayed, and whether it can be.
//! * [`tape`]: the messages of a recording in the order in which they were published.
//! * [`choices`]: what a person chose, told again at its time.
//! * [`transport`]: play, pause, step, seek, speed, loop, as a state machine without a clock of its own.
//! * [`bus::lockstep`]: at full speed, waiting until every view has drawn a pose before the next goes out; and until the tracker
//!   has made it, where it makes poses.
//! * [`images`]: pictures of every pose, or of every N-th, as files.
//! * [`moment`]: one moment as files.
//! * [`instant`]: one moment for a picture without a run.
//! * `find`: the way to a place.
//! * `lead`: what a pose goes on from behind a jump, and what it comes to beside that.
//! * [`timing`]: how well time was kept.
//! * [`account`]: what came of it.
//! * [`process`]: the replayer's process, which does what these say.
//!
//! The clock of a replay is the clock of the run that was recorded, run through anew (`bus::session`): a pose is published
//! when that clock shows its `t_publish_ns`, so that it is as old when it is shown as it was then.

pub mod account;
mod bar;
pub mod choices;
pub(crate) mod cli;
pub mod facts;
mod find;
mod heads;
pub mod images;
pub mod instant;
mod lead;
pub mod moment;
pub mod process;
mod renderers;
pub mod tape;
pub mod timing;
pub mod transport;

use std::fmt;
use std::str::FromStr;

/// How fast a recording is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// This many times the speed of the recording.
    Times(f64),
    /// As fast as every pose can be drawn in every view, none left out.
    Max,
}

impl Speed {
    /// From a request's number: infinite is [`Speed::Max`].
    ///
    /// # Errors
    /// What is allowed, in words.
    pub fn from_number(number: f64) -> Result<Self, String> {
        if number == f64::INFINITY {
            return Ok(Self::Max);
        }
        if (0.01..=100.0).contains(&number) {
            return Ok(Self::Times(number));
        }
        Err(format!(
            "a speed of {number} is not possible; allowed are 0.01 to 100 times the recording's, and `max`"
        ))
    }

    /// The number of a request.
    pub fn number(self) -> f64 {
        match self {
            Self::Times(times) => times,
            Self::Max => f64::INFINITY,
        }
    }
}

impl FromStr for Speed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "max" {
            return Ok(Self::Max);
        }
        let number: f64 = text
            .parse()
            .map_err(|_| format!("{text:?} is not a speed: give a number such as 1 or 0.25, or `max`"))?;
        if number.is_infinite() {
            return Err("give `max` for the highest speed".to_owned());
        }
        Self::from_number(number)
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Times(times) => write!(f, "{times}"),
            Self::Max => write!(f, "max"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_come_back_from_words_and_numbers() {
        for speed in [Speed::Times(1.0), Speed::Times(0.25), Speed::Max] {
            assert_eq!(speed.to_string().parse(), Ok(speed));
            assert_eq!(Speed::from_number(speed.number()), Ok(speed));
        }
        for bad in ["0", "-1", "101", "nan", "inf", "fast", ""] {
            assert!(bad.parse::<Speed>().is_err(), "{bad}");
        }
    }
}
