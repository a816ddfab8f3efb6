//! Where what is replayed goes.

use bus::message::{EmitterFrame, ToolPose};
use bus::port::Publisher;
use bus::topic::{EMITTERS, TOOL_POSE};
use bus::{Bus, BusError};

use crate::replay::tape::Moment;

/// The topic in whose writer's place the replayer stands.
#[derive(Debug)]
pub(super) enum Outlet {
    /// The tracker's: the recorded poses.
    Poses(Publisher<ToolPose>),
    /// The localizer's: the frames that they were made of.
    Frames(Publisher<EmitterFrame>),
}

impl Outlet {
    pub(super) fn open(bus: &Bus, emitters: bool) -> Result<Self, BusError> {
        Ok(match emitters {
            true => Self::Frames(Publisher::open(bus, &EMITTERS, "")?),
            false => Self::Poses(Publisher::open(bus, &TOOL_POSE, "")?),
        })
    }

    /// Whether there is something of `moment` to publish.
    pub(super) fn takes(&self, moment: &Moment) -> bool {
        matches!(self, Self::Poses(_)) || moment.frame.is_some()
    }

    pub(super) fn send(&self, moment: &Moment) -> Result<(), BusError> {
        match (self, &moment.frame) {
            (Self::Poses(poses), _) => poses.send(moment.pose),
            (Self::Frames(frames), Some(frame)) => frames.send(**frame),
            (Self::Frames(_), None) => Ok(()),
        }
    }

    pub(super) fn serve_late_joiners(&self) {
        match self {
            Self::Poses(poses) => poses.serve_late_joiners(),
            Self::Frames(frames) => frames.serve_late_joiners(),
        }
    }
}
