//! Where what is replayed goes.

use bus::message::{EmitterFrame, MarkerFrame, ToolPose, UsImageHeader};
use bus::port::{Publisher, UsImagePublisher};
use bus::topic::{EMITTERS, MARKERS, TOOL_POSE};
use bus::{Bus, BusError};

use crate::replay::tape::{Delivered, Delivery, Moment};
use crate::wire::proto::UsFrame;

/// The topic in whose writer's place the replayer stands.
#[derive(Debug)]
pub(super) enum Outlet {
    /// The tracker's: the recorded poses.
    Poses(Publisher<ToolPose>),
    /// The localizer's: the frames that they were made of.
    Emitters(Publisher<EmitterFrame>),
    /// The same for a localizer that makes the poses of its markers.
    Markers(Publisher<MarkerFrame>),
}

impl Outlet {
    pub(super) fn open(bus: &Bus, frames: Option<Delivery>) -> Result<Self, BusError> {
        Ok(match frames {
            Some(Delivery::Emitters) => Self::Emitters(Publisher::open(bus, &EMITTERS, "")?),
            Some(Delivery::Markers) => Self::Markers(Publisher::open(bus, &MARKERS, "")?),
            None => Self::Poses(Publisher::open(bus, &TOOL_POSE, "")?),
        })
    }

    /// Whether there is something of `moment` to publish.
    pub(super) fn takes(&self, moment: &Moment) -> bool {
        matches!(self, Self::Poses(_)) || moment.frame.is_some()
    }

    pub(super) fn send(&self, moment: &Moment) -> Result<(), BusError> {
        match (self, &moment.frame) {
            (Self::Poses(poses), _) => poses.send(moment.pose),
            (Self::Emitters(frames), Some(Delivered::Emitters(frame))) => frames.send(**frame),
            (Self::Markers(frames), Some(Delivered::Markers(frame))) => frames.send(**frame),
            // The tape reads what the outlet takes.
            (Self::Emitters(_) | Self::Markers(_), _) => Ok(()),
        }
    }

    pub(super) fn serve_late_joiners(&self) {
        match self {
            Self::Poses(poses) => poses.serve_late_joiners(),
            Self::Emitters(frames) => frames.serve_late_joiners(),
            Self::Markers(frames) => frames.serve_late_joiners(),
        }
    }
}

/// Where the images of an ultrasound probe go, as soon as there are some.
#[derive(Debug, Default)]
pub(super) struct UsOutlet {
    publisher: Option<UsImagePublisher>,
    /// Pixels that an image may have.
    room: usize,
}

impl UsOutlet {
    pub(super) fn send(&mut self, bus: &Bus, images: &[UsFrame]) -> Result<(), BusError> {
        for image in images {
            if image.grey.len() > UsImageHeader::MOST_PIXELS {
                // No publisher of ours sends such a one.
                continue;
            }
            if self.publisher.is_none() || image.grey.len() > self.room {
                // The one before goes first: there is a place for one.
                self.publisher = None;
                self.room = image.grey.len();
                self.publisher = Some(UsImagePublisher::open(bus, self.room)?);
            }
            if let Some(publisher) = &self.publisher {
                publisher.send(image.header, &image.grey)?;
            }
        }
        Ok(())
    }
}
