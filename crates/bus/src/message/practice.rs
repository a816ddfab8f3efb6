//! What the simulated hand is to do, so that calibration, registration and check can be practised.

use geometry::{Base, Ct, Frame, Rigid, Tool, Vector};

use super::pose::{ToolPose, Tracked};
use super::{Command, CommandKind, text_field};

/// What the simulated hand is to do from now on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Practice {
    /// Where its tool is, or about which place it moves.
    pub place: PracticeFrame,
    /// How it moves.
    pub motion: PracticeMotion,
}

/// A pose of the tool, and what it is in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PracticeFrame {
    /// In the patient, where it lies.
    Patient(Rigid<Ct, Tool>),
    /// On the calibration base of the room.
    Base(Rigid<Base, Tool>),
}

/// A motion about a pose of the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PracticeMotion {
    /// The scripted way to the target and back; the pose is of no meaning.
    Approach,
    /// Held still, as well as a hand can.
    Hold,
    /// Left in its place by the hand: nothing moves it.
    Rest,
    /// Turned about its tip, to all sides, by up to this half opening, radians.
    Pivot(f64),
    /// Spun about its shaft, the tip in its place.
    Spin,
}

impl PracticeMotion {
    const fn word(self) -> &'static str {
        match self {
            Self::Approach => "approach",
            Self::Hold => "hold",
            Self::Rest => "rest",
            Self::Pivot(_) => "pivot",
            Self::Spin => "spin",
        }
    }
}

impl Command {
    /// The request that the simulated hand does something.
    pub fn practise(practice: &Practice) -> Self {
        let (view, pose) = match practice.place {
            PracticeFrame::Patient(pose) => (0, pose),
            PracticeFrame::Base(pose) => (1, renamed(pose)),
        };
        let mut carried = ToolPose::EMPTY;
        carried.set(Tracked::Valid(pose));
        let number = match practice.motion {
            PracticeMotion::Pivot(half_rad) => half_rad,
            _ => 0.0,
        };
        Self {
            view,
            pose: carried,
            text: text_field(practice.motion.word()),
            ..Self::with_number(CommandKind::Practise, number)
        }
    }

    /// What the simulated hand is to do.
    ///
    /// # Errors
    /// Which part of the request is impossible, in words.
    pub fn practice(&self) -> Result<Practice, String> {
        let motion = match self.words().as_str() {
            "approach" => PracticeMotion::Approach,
            "hold" => PracticeMotion::Hold,
            "rest" => PracticeMotion::Rest,
            "pivot" if (0.0..=1.4).contains(&self.number) => PracticeMotion::Pivot(self.number),
            "pivot" => return Err(format!("half opening {} rad, 0 to 1.4 is allowed", self.number)),
            "spin" => PracticeMotion::Spin,
            other => {
                return Err(format!(
                    "motion {other:?}, approach, hold, rest, pivot or spin is allowed"
                ));
            }
        };
        let pose = match self.pose.tracked() {
            Ok(Tracked::Valid(pose)) => pose,
            Ok(Tracked::Lost(_)) => return Err("there is no pose in it".to_owned()),
            Err(error) => return Err(error.to_string()),
        };
        let place = match self.view {
            0 => PracticeFrame::Patient(pose),
            1 => PracticeFrame::Base(renamed(pose)),
            other => return Err(format!("frame {other}, 0 (patient) or 1 (base) is allowed")),
        };
        Ok(Practice { place, motion })
    }
}

/// The same numbers between other frames: a request has room for one pose, and says beside it what that is in.
fn renamed<A: Frame, B: Frame>(pose: Rigid<A, Tool>) -> Rigid<B, Tool> {
    let [x, y, z] = pose.translation_mm();
    Rigid::from_parts(pose.rotation(), Vector::new(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_practice_comes_back_and_what_is_none_is_refused() {
        let ct =
            Rigid::<Ct, Tool>::from_rotation_vector(Vector::new(0.3, -0.2, 1.0), Vector::new(1.0, 2.0, 3.0)).unwrap();
        let base = Rigid::<Base, Tool>::from_rotation_vector(Vector::new(0.0, 0.5, 0.0), Vector::new(9.0, 0.0, 3.0));
        for place in [PracticeFrame::Patient(ct), PracticeFrame::Base(base.unwrap())] {
            for motion in [
                PracticeMotion::Approach,
                PracticeMotion::Hold,
                PracticeMotion::Rest,
                PracticeMotion::Pivot(0.5),
                PracticeMotion::Spin,
            ] {
                let practice = Practice { place, motion };
                assert_eq!(Command::practise(&practice).practice(), Ok(practice));
            }
        }
        let good = Command::practise(&Practice {
            place: PracticeFrame::Patient(ct),
            motion: PracticeMotion::Pivot(0.5),
        });
        let bad = |change: fn(&mut Command)| {
            let mut command = good;
            change(&mut command);
            command.practice().unwrap_err()
        };
        assert!(bad(|c| c.number = f64::NAN).contains("half opening NaN"));
        assert!(bad(|c| c.view = 7).contains("frame 7"));
        assert!(bad(|c| c.text = text_field("dance")).contains("dance"));
        assert!(bad(|c| c.pose = ToolPose::EMPTY).contains("no pose"));
        assert!(bad(|c| c.pose.t_mm[0] = f64::INFINITY).contains("finite"));
    }
}
