//! Ultrasound images on the bus: numbered, with the time of their capture.

use bus::BusError;
use bus::clock;
use bus::message::UsImageHeader;
use bus::port::UsImagePublisher;
use bus::process::Process;

use crate::clocks::ImageTime;
use crate::openigtlink::Picture;

/// After so long without an image it is said that none comes, ns.
const ABSENT_NS: i64 = 2_000_000_000;

/// So long each image is tried anew where the one before could not be published, ns. A try takes no time that poses would wait for.
const TRIED_NS: i64 = 2_000_000_000;

/// Where images go. The topic is opened with the first one, whose size is not known before.
#[derive(Debug, Default)]
pub(crate) struct ImageOutput {
    /// The scene asks for them.
    is_asked: bool,
    open: Option<Open>,
    next_seq: u64,
    /// The last image's time, and when it arrived.
    last: Option<(ImageTime, i64)>,
    /// How often their clock was set.
    set: u32,
    /// Since when they could not be published, ns: the place of a process that died is freed after a moment.
    failing: Option<i64>,
    /// They could not be for [`TRIED_NS`], and it is not tried again.
    has_failed: bool,
}

#[derive(Debug)]
struct Open {
    publisher: UsImagePublisher,
    /// Pixels of the largest image that it has room for.
    room: usize,
}

impl ImageOutput {
    /// Of a scene that asks for images, or does not.
    pub(crate) fn new(is_asked: bool) -> Self {
        Self {
            is_asked,
            ..Self::default()
        }
    }

    /// Publishes an image. Why that failed, in words, the first time: poses go on without images.
    pub(crate) fn show(&mut self, picture: &Picture, time: ImageTime, process: &mut Process) -> Option<String> {
        if self.has_failed {
            process.counters.refused += 1;
            return None;
        }
        let Err(why) = self.send(picture, time, process) else {
            self.failing = None;
            return None;
        };
        process.counters.refused += 1;
        let now_ns = process.clock().now_ns();
        let since_ns = *self.failing.get_or_insert(now_ns);
        self.has_failed = now_ns.saturating_sub(since_ns) >= TRIED_NS;
        if !self.has_failed {
            return None;
        }
        Some(format!(
            "ultrasound images are not published any more (pilot restart localizer tries again): {why}"
        ))
    }

    fn send(&mut self, picture: &Picture, time: ImageTime, process: &Process) -> Result<(), BusError> {
        let pixels = picture.grey.len();
        if let Some(room) = room(self.open.as_ref().map(|open| open.room), pixels) {
            // One publisher at a time.
            self.open = None;
            self.open = Some(Open {
                publisher: UsImagePublisher::open_once(&process.bus, room)?,
                room,
            });
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        let header = UsImageHeader {
            seq: self.next_seq,
            t_device_ns: picture.device_ns,
            t_capture_ns: time.captured.at_ns,
            t_arrival_ns: picture.arrival_ns,
            t_publish_ns: process.clock().now_ns(),
            clock: time.captured.clock.code(),
            ..picture.header
        };
        open.publisher.send(header, &picture.grey)?;
        self.next_seq += 1;
        self.last = Some((time, picture.arrival_ns));
        self.set = self.set.saturating_add(u32::from(time.set_by_ns.is_some()));
        Ok(())
    }

    /// Gives late joiners the last image, also while none comes.
    pub(crate) fn serve_late_joiners(&self) {
        if let Some(open) = &self.open {
            open.publisher.serve_late_joiners();
        }
    }

    /// What images are timed by, for people; empty where none are asked for.
    pub(crate) fn words(&self, now_ns: i64) -> String {
        if self.has_failed {
            return "images not published".to_owned();
        }
        if self.failing.is_some() {
            return "images not published yet".to_owned();
        }
        let Some((time, at_ns)) = self
            .last
            .filter(|(_, at_ns)| now_ns.saturating_sub(*at_ns) <= ABSENT_NS)
        else {
            let is_expected = self.is_asked || self.last.is_some();
            return if is_expected { "no images come" } else { "" }.to_owned();
        };
        let set = match self.set {
            0 => String::new(),
            n => format!(", their clock set {n} x"),
        };
        match time.untimed {
            Some(why) => format!("images timed by arrival ({why}{set})"),
            // How much of it is an offset of two clocks, nobody sees: that there is none is the scene's word.
            None => {
                let late_ms = clock::ms(at_ns.saturating_sub(time.captured.at_ns));
                format!("images stamped {late_ms:.0} ms late, one clock by the scene{set}")
            }
        }
    }
}

/// How many pixels the topic is to be opened with, if anew: those of the first image, as a scanner keeps its size; by doubling where images
/// grow and grow, so that it is opened a few times alone.
fn room(had: Option<usize>, pixels: usize) -> Option<usize> {
    match had {
        None => Some(pixels),
        Some(had) if had < pixels => Some(pixels.max(2 * had).min(UsImageHeader::MOST_PIXELS)),
        Some(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image one pixel above a power of two had room for nearly two, 43 times.
    #[test]
    fn the_topic_has_room_for_the_images_that_come() {
        let most = UsImageHeader::MOST_PIXELS;
        assert_eq!(room(None, 640 * 480), Some(640 * 480));
        assert_eq!((room(Some(300), 300), room(Some(300), 1)), (None, None));
        assert_eq!((room(Some(300), 301), room(Some(300), 601)), (Some(600), Some(601)));
        assert_eq!((room(None, most), room(Some(most - 1), most)), (Some(most), Some(most)));
        // Images that grow by a pixel, from the smallest to the largest.
        let mut opened = Vec::new();
        for pixels in 256..=most {
            opened.extend(room(opened.last().copied(), pixels));
        }
        assert_eq!(opened.len(), 15);
    }
}
