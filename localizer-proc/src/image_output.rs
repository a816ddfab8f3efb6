//! Ultrasound images on the bus: numbered, with the time of their capture.

use bus::BusError;
use bus::message::{CaptureClock, UsImageHeader};
use bus::port::UsImagePublisher;
use bus::process::Process;

use crate::clocks::Captured;
use crate::openigtlink::Picture;

/// Where images go. The topic is opened with the first one, whose size is not known before.
#[derive(Debug, Default)]
pub(crate) struct ImageOutput {
    open: Option<Open>,
    /// What the last image's time rests on.
    stamped: Option<CaptureClock>,
}

#[derive(Debug)]
struct Open {
    publisher: UsImagePublisher,
    /// Pixels of the largest image that it has room for.
    room: usize,
    next_seq: u64,
}

impl ImageOutput {
    /// Publishes an image.
    pub(crate) fn send(&mut self, picture: &Picture, captured: Captured, process: &Process) -> Result<(), BusError> {
        let pixels = picture.grey.len();
        let begun = self.open.as_ref().map(|open| open.next_seq);
        if self.open.as_ref().is_none_or(|open| open.room < pixels) {
            // One publisher at a time.
            self.open = None;
            self.open = Some(Open {
                publisher: UsImagePublisher::open(&process.bus, pixels)?,
                room: pixels,
                // Larger images of the same process go on behind the numbers of the others.
                next_seq: begun.unwrap_or(0),
            });
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        let header = UsImageHeader {
            seq: open.next_seq,
            t_device_ns: picture.device_ns,
            t_capture_ns: captured.at_ns,
            t_arrival_ns: picture.arrival_ns,
            t_publish_ns: process.clock().now_ns(),
            clock: captured.clock.code(),
            ..picture.header
        };
        open.publisher.send(header, &picture.grey)?;
        open.next_seq += 1;
        self.stamped = Some(captured.clock);
        Ok(())
    }

    /// Gives late joiners the last image, also while none comes.
    pub(crate) fn serve_late_joiners(&self) {
        if let Some(open) = &self.open {
            open.publisher.serve_late_joiners();
        }
    }

    /// What images are timed by, for people; empty before the first one.
    pub(crate) fn words(&self) -> String {
        match self.stamped {
            None => String::new(),
            Some(CaptureClock::Mapped) => "images stamped".to_owned(),
            Some(CaptureClock::Arrival) => "images timed by arrival".to_owned(),
        }
    }
}
