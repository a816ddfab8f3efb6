//! Ultrasound images: grey values behind their header.

use iceoryx2::port::publisher::Publisher as IoxPublisher;
use iceoryx2::port::subscriber::Subscriber as IoxSubscriber;
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::places::take_place;
use super::{limited, open_error, service_name, transfer_error};
use crate::message::UsImageHeader;
use crate::node::{Ipc, patiently};
use crate::topic::US_IMAGE;
use crate::{Bus, BusError};

pub(super) fn service(bus: &Bus) -> Result<PortFactory<Ipc, [u8], UsImageHeader>, BusError> {
    let builder = bus
        .node
        .service_builder(&service_name(US_IMAGE.name)?)
        .publish_subscribe::<[u8]>()
        .user_header::<UsImageHeader>();
    limited(builder, &US_IMAGE)
        .open_or_create()
        .map_err(open_error(US_IMAGE.name, "join"))
}

/// The one who delivers the images of a probe.
#[derive(Debug)]
pub struct UsImagePublisher {
    port: IoxPublisher<Ipc, [u8], UsImageHeader>,
}

impl UsImagePublisher {
    /// Becomes the publisher, with images of up to `pixels`.
    ///
    /// # Errors
    /// [`BusError::Open`], also where another process publishes already.
    pub fn open(bus: &Bus, pixels: usize) -> Result<Self, BusError> {
        patiently(bus, || {
            let port = service(bus)?
                .publisher_builder()
                .initial_max_slice_len(pixels.min(UsImageHeader::MOST_PIXELS))
                .create()
                .map_err(open_error(US_IMAGE.name, "publish"))?;
            Ok(Self { port })
        })
    }

    /// Publishes an image; `grey` holds `width * height` bytes.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn send(&self, header: UsImageHeader, grey: &[u8]) -> Result<(), BusError> {
        let sample = self
            .port
            .loan_slice_uninit(grey.len())
            .map_err(transfer_error(US_IMAGE.name, "taking memory"))?;
        let mut sample = sample.write_from_slice(grey);
        *sample.user_header_mut() = header;
        sample.send().map_err(transfer_error(US_IMAGE.name, "publishing"))?;
        Ok(())
    }

    /// Gives late joiners the last image, also while none comes.
    pub fn serve_late_joiners(&self) {
        let _ = self.port.update_connections();
    }
}

/// One who takes the images.
#[derive(Debug)]
pub struct UsImageSubscriber {
    port: IoxSubscriber<Ipc, [u8], UsImageHeader>,
}

/// An image in shared memory.
#[derive(Debug)]
pub struct UsImage {
    sample: Sample<Ipc, [u8], UsImageHeader>,
}

impl UsImageSubscriber {
    /// Subscribes, with room for as many unread images as the topic allows; older ones give way.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus) -> Result<Self, BusError> {
        patiently(bus, || {
            let service = service(bus)?;
            let port = take_place((bus, &service), (US_IMAGE.name, "subscribe"), |service| {
                let builder = service.subscriber_builder().buffer_size(US_IMAGE.buffer);
                builder.history_request(US_IMAGE.history).create()
            })?;
            Ok(Self { port })
        })
    }

    /// The next unread image. One whose grey values are not those of its header is passed over.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn next(&self) -> Result<Option<UsImage>, BusError> {
        loop {
            let sample = self
                .port
                .receive()
                .map_err(transfer_error(US_IMAGE.name, "receiving"))?;
            let Some(image) = sample.map(|sample| UsImage { sample }) else {
                return Ok(None);
            };
            if image.header().pixels() == Some(image.grey().len()) {
                return Ok(Some(image));
            }
        }
    }
}

impl UsImage {
    /// What it is of.
    pub fn header(&self) -> &UsImageHeader {
        self.sample.user_header()
    }

    /// Its grey values, row by row from the top.
    pub fn grey(&self) -> &[u8] {
        self.sample.payload()
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
}
