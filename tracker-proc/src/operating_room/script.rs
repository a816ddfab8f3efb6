//! What the tool does: the scripted approach, or a gesture from a file.

use geometry::{Ct, Point, Rigid, Tool, VolumeGrid};
use scene::Target;
use scene::operating_room::Room;

use super::{Played, PlayedError, Practised};
use crate::gesture::{Gesture, GestureError, aim};

/// Where the tool truly is, as a function of the script's time.
#[derive(Debug, Clone)]
pub enum Script {
    /// Insert, rest, sweep, withdraw, again.
    Approach(Gesture),
    /// Poses from a file.
    Played(Played),
    /// The approach, until somebody practises.
    Practised(Box<Practised>),
}

/// Why a room's gesture cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum ScriptError {
    /// The scripted one.
    #[error(transparent)]
    Gesture(#[from] GestureError),
    /// The one from a file.
    #[error(transparent)]
    Played(#[from] PlayedError),
}

impl From<Gesture> for Script {
    fn from(gesture: Gesture) -> Self {
        Self::Approach(gesture)
    }
}

impl From<Played> for Script {
    fn from(played: Played) -> Self {
        Self::Played(played)
    }
}

impl Script {
    /// The script of a room: its file where it names one, read now, else its approach towards the target it names, or towards
    /// the middle of the volume `grid` (the CT's origin without one).
    ///
    /// # Errors
    /// Each variant of [`ScriptError`].
    pub fn of_room(room: &Room, targets: &[Target], grid: Option<&VolumeGrid>) -> Result<Self, ScriptError> {
        if let Some(played) = &room.played {
            return Ok(Self::Played(Played::load(played)?));
        }
        let middle = grid.map_or(Point::new(0.0, 0.0, 0.0), VolumeGrid::centre);
        let target = aim(&room.approach, targets).map_or(middle, |target| target.centre);
        Ok(Self::Approach(Gesture::new(&room.approach, target, grid)?))
    }

    /// The same by a hand that does what it is told, where the room has something to practise with; it errs by `seed`. A gesture from
    /// a file is played as it is.
    #[must_use]
    pub fn practised(self, room: &Room, seed: u64) -> Self {
        match (self, room.practice) {
            (Self::Approach(gesture), Some(practice)) => {
                Self::Practised(Box::new(Practised::new(practice, gesture, seed)))
            }
            (script, _) => script,
        }
    }

    /// The true pose at script time `t_s`.
    pub fn ct_from_tool(&self, t_s: f64) -> Rigid<Ct, Tool> {
        match self {
            Self::Approach(gesture) => gesture.ct_from_tool(t_s),
            Self::Played(played) => played.ct_from_tool(t_s),
            Self::Practised(hand) => hand.ct_from_tool(t_s),
        }
    }

    /// When the frames end, s; `None`: never.
    pub fn end_s(&self) -> Option<f64> {
        match self {
            Self::Approach(_) | Self::Practised(_) => None,
            Self::Played(played) => played.end_s(),
        }
    }
}
