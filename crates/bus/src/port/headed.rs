//! Publish-subscribe of values of one kind behind a header: images, meshes, states of tissue.

use std::fmt::Debug;

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher as IoxPublisher;
use iceoryx2::port::subscriber::Subscriber as IoxSubscriber;
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::places::take_place;
use super::{Message, limited, listener, notifier, open_error, service_name, transfer_error};
use crate::node::{Ipc, patiently};
use crate::topic::Topic;
use crate::{Bus, BusError};

/// A number of a payload.
pub trait Value: ZeroCopySend + Debug + Copy + 'static {}
impl<T: ZeroCopySend + Debug + Copy + 'static> Value for T {}

/// The one publisher of a topic of values behind a header.
#[derive(Debug)]
pub struct HeadedPublisher<H: Message + Default, T: Value> {
    port: IoxPublisher<Ipc, [T], H>,
    notifier: Option<Notifier<Ipc>>,
    topic: &'static str,
}

/// One who takes them.
#[derive(Debug)]
pub struct HeadedSubscriber<H: Message + Default, T: Value> {
    port: IoxSubscriber<Ipc, [T], H>,
    listener: Option<Listener<Ipc>>,
    topic: &'static str,
}

/// A header with its values, in shared memory.
#[derive(Debug)]
pub struct Headed<H: Message + Default, T: Value> {
    sample: Sample<Ipc, [T], H>,
}

pub(super) fn service<H: Message + Default, T: Value>(
    bus: &Bus,
    topic: &Topic,
) -> Result<PortFactory<Ipc, [T], H>, BusError> {
    let builder = bus
        .node
        .service_builder(&service_name(topic.name)?)
        .publish_subscribe::<[T]>()
        .user_header::<H>();
    limited(builder, topic)
        .open_or_create()
        .map_err(open_error(topic.name, "join"))
}

impl<H: Message + Default, T: Value> HeadedPublisher<H, T> {
    /// Becomes the publisher, with up to `most` values behind a header.
    ///
    /// # Errors
    /// [`BusError::Open`], also where another process publishes already.
    pub fn open(bus: &Bus, topic: &Topic, most: usize) -> Result<Self, BusError> {
        patiently(bus, || Self::open_once(bus, topic, most))
    }

    /// The same without patience: who may not wait tries again later.
    ///
    /// # Errors
    /// [`BusError::Open`], also for a moment while a dead process's place is being freed.
    pub fn open_once(bus: &Bus, topic: &Topic, most: usize) -> Result<Self, BusError> {
        let port = service(bus, topic)?
            .publisher_builder()
            .initial_max_slice_len(most)
            // What is taken is sent before the next is.
            .max_loaned_samples(1)
            .create()
            .map_err(open_error(topic.name, "publish"))?;
        Ok(Self {
            port,
            notifier: notifier(bus, topic, topic.name)?,
            topic: topic.name,
        })
    }

    /// Publishes and wakes the receivers.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn send(&self, header: H, values: &[T]) -> Result<(), BusError> {
        let sample = self
            .port
            .loan_slice_uninit(values.len())
            .map_err(transfer_error(self.topic, "taking memory"))?;
        let mut sample = sample.write_from_slice(values);
        *sample.user_header_mut() = header;
        sample.send().map_err(transfer_error(self.topic, "publishing"))?;
        if let Some(notifier) = &self.notifier {
            // A receiver that died a moment ago makes this fail; the others were woken.
            let _ = notifier.notify();
        }
        Ok(())
    }

    /// Gives late joiners the last, also while none comes.
    pub fn serve_late_joiners(&self) {
        let _ = self.port.update_connections();
    }
}

impl<H: Message + Default, T: Value> HeadedSubscriber<H, T> {
    /// Subscribes, with room for `depth` that were not read; older ones give way.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, topic: &Topic, depth: usize) -> Result<Self, BusError> {
        patiently(bus, || {
            let service = service(bus, topic)?;
            let port = take_place((bus, &service), (topic.name, "subscribe"), |service| {
                let builder = service.subscriber_builder().buffer_size(depth);
                builder.history_request(topic.history.min(depth)).create()
            })?;
            Ok(Self {
                port,
                listener: None,
                topic: topic.name,
            })
        })
    }

    /// The same, and woken by each: see [`crate::wake`].
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open_waking(bus: &Bus, topic: &Topic, depth: usize) -> Result<Self, BusError> {
        let mut subscriber = Self::open(bus, topic, depth)?;
        subscriber.listener = Some(listener(bus, topic, topic.name)?);
        Ok(subscriber)
    }

    pub(crate) fn listener(&self) -> Option<&Listener<Ipc>> {
        self.listener.as_ref()
    }

    /// The next that was not read.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn next(&self) -> Result<Option<Headed<H, T>>, BusError> {
        let sample = self.port.receive().map_err(transfer_error(self.topic, "receiving"))?;
        Ok(sample.map(|sample| Headed { sample }))
    }
}

impl<H: Message + Default, T: Value> Headed<H, T> {
    /// What goes before.
    pub fn header(&self) -> &H {
        self.sample.user_header()
    }

    /// What comes behind it.
    pub fn values(&self) -> &[T] {
        self.sample.payload()
    }
}
