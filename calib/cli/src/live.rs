//! A run that is going in the place of a recording: what its localizer delivers, listened to for a while, give poses and touched points.
//!
//! Nothing is published and nothing is asked of the run's processes: a calibration listens beside the tracker.

mod dwell;
mod error;
mod images;
mod offline;
mod run;
mod sequence;
mod still;
mod touch;
mod touches;
mod watch;

use bus::message::{EmitterFrame, MarkerFrame};
use clap::{Args, ValueEnum};
use geometry::{Marker, Reference, Tool, Tracker, Uncertain};
use scene::Scene;

use crate::scene_context::SceneArgs;
use crate::values::Positive;

pub(crate) use error::LiveError;
pub(crate) use images::Looked;
pub use offline::{HeardPoses, OfflineError};
pub(crate) use run::{Listened, Run};
pub(crate) use sequence::DwellError;
pub(crate) use still::{MostMotion, Touched, touched};
pub(crate) use touch::{TOUCH_HELP, TOUCH_S, TouchArgs, tip_in, tip_of};
pub(crate) use touches::{
    calibration_id, calibration_of, comment as touches_comment, read_touches, says_frame, shared, touched_in,
};
pub(crate) use watch::{Heard, Lacks, Watch};

/// Where the markers of a run are, frame by frame. Handed in by the binary, as this crate knows no chain.
pub trait Follow {
    /// Whether the scene has a marker on the patient.
    fn has_reference(&self) -> bool;
    /// The tool's calibration in use.
    ///
    /// # Errors
    /// Why there is none, in words.
    fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String>;
    /// One frame, where it is `now_ns` on the run's clock.
    ///
    /// # Errors
    /// Why it shows no pose, in words.
    fn see(&mut self, frame: Delivered<'_>, now_ns: i64) -> Result<Seen, String>;
}

/// One frame of a localizer.
#[derive(Debug, Clone, Copy)]
pub enum Delivered<'a> {
    /// Places of emitters.
    Emitters(&'a EmitterFrame),
    /// Poses of markers.
    Markers(&'a MarkerFrame),
}

/// The markers in the localizer's frame.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// The tool's.
    pub marker: Uncertain<Tracker, Marker>,
    /// The patient's, where the scene has one.
    pub reference: Option<Uncertain<Tracker, Reference>>,
}

/// Makes a [`Follow`] of a scene.
pub type FollowMarkers = fn(&Scene) -> Result<Box<dyn Follow>, Box<dyn std::error::Error + Send + Sync>>;

/// Which run, and how it is listened to.
#[derive(Debug, Clone, Args)]
pub(crate) struct LiveArgs {
    #[command(flatten)]
    pub(crate) of: SceneArgs,
    /// For so long, s [default: 20, for a touch 1]
    #[arg(long, value_name = "S", requires = "live", allow_hyphen_values = true)]
    pub(crate) seconds: Option<Positive>,
    /// The frame of the poses [default: reference, where the scene has a marker on the patient]
    #[arg(long, value_enum, requires = "live")]
    pub(crate) against: Option<Against>,
    /// Who is told meanwhile.
    #[arg(skip)]
    pub(crate) watch: Watch,
}

/// The longest that is listened, s.
const LONGEST_S: f64 = 600.0;

impl LiveArgs {
    /// How long to listen, s: `usual` where nothing else is asked for.
    pub(crate) fn seconds_or(&self, usual: f64) -> f64 {
        self.seconds.map_or(usual, |s| s.0).min(LONGEST_S)
    }
}

/// What stands still while the instrument moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Against {
    /// The marker on the patient: localizer and patient may move.
    Reference,
    /// The localizer.
    Tracker,
}

impl Against {
    /// The name of the frame.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Tracker => "tracker",
        }
    }
}
