//! Ultrasound images: grey values behind their header.

use super::headed::{Headed, HeadedPublisher, HeadedSubscriber};
use crate::message::UsImageHeader;
use crate::topic::US_IMAGE;
use crate::{Bus, BusError};

/// The one who delivers the images of a probe.
#[derive(Debug)]
pub struct UsImagePublisher(HeadedPublisher<UsImageHeader, u8>);

impl UsImagePublisher {
    /// Becomes the publisher, with images of up to `pixels`.
    ///
    /// # Errors
    /// [`BusError::Open`], also where another process publishes already.
    pub fn open(bus: &Bus, pixels: usize) -> Result<Self, BusError> {
        HeadedPublisher::open(bus, &US_IMAGE, pixels.min(UsImageHeader::MOST_PIXELS)).map(Self)
    }

    /// The same without patience: who may not wait tries again later.
    ///
    /// # Errors
    /// [`BusError::Open`], also for a moment while a dead process's place is being freed.
    pub fn open_once(bus: &Bus, pixels: usize) -> Result<Self, BusError> {
        HeadedPublisher::open_once(bus, &US_IMAGE, pixels.min(UsImageHeader::MOST_PIXELS)).map(Self)
    }

    /// Publishes an image; `grey` holds `width * height` bytes.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn send(&self, header: UsImageHeader, grey: &[u8]) -> Result<(), BusError> {
        self.0.send(header, grey)
    }

    /// Gives late joiners the last image, also while none comes.
    pub fn serve_late_joiners(&self) {
        self.0.serve_late_joiners();
    }
}

/// One who takes the images.
#[derive(Debug)]
pub struct UsImageSubscriber(HeadedSubscriber<UsImageHeader, u8>);

/// An image in shared memory.
#[derive(Debug)]
pub struct UsImage(Headed<UsImageHeader, u8>);

impl UsImageSubscriber {
    /// Subscribes, with room for as many unread images as the topic allows; older ones give way.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus) -> Result<Self, BusError> {
        HeadedSubscriber::open(bus, &US_IMAGE, US_IMAGE.buffer).map(Self)
    }

    /// The next unread image. One whose grey values are not those of its header is passed over.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn next(&self) -> Result<Option<UsImage>, BusError> {
        while let Some(image) = self.0.next()?.map(UsImage) {
            if image.header().pixels() == Some(image.grey().len()) {
                return Ok(Some(image));
            }
        }
        Ok(None)
    }
}

impl UsImage {
    /// What it is of.
    pub fn header(&self) -> &UsImageHeader {
        self.0.header()
    }

    /// Its grey values, row by row from the top.
    pub fn grey(&self) -> &[u8] {
        self.0.values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::monotonic_ns;
    use crate::run::RunContext;

    #[test]
    fn images_come_in_order_and_one_whose_pixels_are_not_its_header_s_does_not() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        let bus = Bus::join(&run).unwrap();
        let publisher = UsImagePublisher::open(&bus, 6).unwrap();
        let subscriber = UsImageSubscriber::open(&bus).unwrap();
        let header = |seq, width, height| UsImageHeader {
            seq,
            width,
            height,
            ..UsImageHeader::default()
        };
        publisher.send(header(0, 3, 2), &[1; 6]).unwrap();
        publisher.send(header(1, 3, 2), &[2; 5]).unwrap();
        publisher.send(header(2, u32::MAX, u32::MAX), &[3; 1]).unwrap();
        publisher.send(header(3, 2, 3), &[4; 6]).unwrap();
        let mut came = Vec::new();
        while let Some(image) = subscriber.next().unwrap() {
            came.push((image.header().seq, image.grey().to_vec()));
        }
        assert_eq!(came, [(0, vec![1; 6]), (3, vec![4; 6])]);
        // Who joins late has the last.
        let late = UsImageSubscriber::open(&bus).unwrap();
        publisher.serve_late_joiners();
        assert_eq!(late.next().unwrap().unwrap().header().seq, 3);
        drop((late, subscriber, publisher, bus));
        run.sweep();
    }

    /// What lies in shared memory of the run's segments, bytes.
    fn in_memory(run: &RunContext) -> u64 {
        use std::os::unix::fs::MetadataExt as _;
        let files = std::fs::read_dir("/dev/shm").unwrap().map(Result::unwrap);
        let own = files.filter(|file| file.file_name().to_string_lossy().starts_with(&run.prefix()));
        own.map(|file| file.metadata().map_or(0, |data| data.blocks() * 512))
            .sum()
    }

    /// A segment is as long as all readers together may ever hold, 42 images; in memory is only what was written.
    #[test]
    fn images_take_the_memory_of_those_that_readers_hold_and_no_more() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        let bus = Bus::join(&run).unwrap();
        let pixels = UsImageHeader::MOST_PIXELS as u64;
        let header = UsImageHeader {
            width: 2048,
            height: 2048,
            ..UsImageHeader::default()
        };
        let grey = vec![1; UsImageHeader::MOST_PIXELS];
        let publisher = UsImagePublisher::open(&bus, grey.len()).unwrap();
        let empty = in_memory(&run);
        let send = |count: usize| (0..count).for_each(|_| publisher.send(header, &grey).unwrap());
        send(1);
        let one = in_memory(&run) - empty;
        assert!(one >= pixels && one < pixels + (1 << 20), "{one}");
        // The last for late joiners, and the next.
        send(50);
        let two = in_memory(&run) - empty;
        assert!(two < 2 * pixels + (1 << 20), "{two}");
        // A reader that takes none: its buffer of 8, that, and one more.
        let subscriber = UsImageSubscriber::open(&bus).unwrap();
        send(50);
        let all = in_memory(&run) - empty;
        assert!(all < 10 * pixels + (1 << 20), "{all}");
        drop((subscriber, publisher, bus));
        run.sweep();
    }
}
