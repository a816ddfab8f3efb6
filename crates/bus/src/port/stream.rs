//! Publish-subscribe of one plain struct.

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher as IoxPublisher;
use iceoryx2::port::subscriber::Subscriber as IoxSubscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::places::take_place;
use super::{Message, limited, listener, notifier, open_error, service_name, transfer_error};
use crate::node::{Ipc, patiently};
use crate::topic::Topic;
use crate::{Bus, BusError};

/// The one publisher of a topic.
#[derive(Debug)]
pub struct Publisher<T: Message> {
    port: IoxPublisher<Ipc, T, ()>,
    notifier: Option<Notifier<Ipc>>,
    name: String,
}

/// One subscriber of a topic.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    port: IoxSubscriber<Ipc, T, ()>,
    listener: Option<Listener<Ipc>>,
    name: String,
}

pub(super) fn service<T: Message>(bus: &Bus, topic: &Topic, name: &str) -> Result<PortFactory<Ipc, T, ()>, BusError> {
    let builder = bus.node.service_builder(&service_name(name)?).publish_subscribe::<T>();
    limited(builder, topic)
        .open_or_create()
        .map_err(open_error(name, "join"))
}

impl<T: Message> Publisher<T> {
    /// Becomes the publisher of `topic` for `part` (a process or view; ignored where the topic has no `*`).
    ///
    /// # Errors
    /// [`BusError::Open`], also where another process publishes already.
    pub fn open(bus: &Bus, topic: &Topic, part: &str) -> Result<Self, BusError> {
        let name = topic.of(part);
        patiently(bus, || {
            let port = service(bus, topic, &name)?
                .publisher_builder()
                .create()
                .map_err(open_error(&name, "publish"))?;
            Ok(Self {
                port,
                notifier: notifier(bus, topic, &name)?,
                name: name.clone(),
            })
        })
    }

    /// Publishes `message` and wakes the receivers.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn send(&self, message: T) -> Result<(), BusError> {
        self.port
            .send_copy(message)
            .map_err(transfer_error(&self.name, "publishing"))?;
        if let Some(notifier) = &self.notifier {
            // A receiver that died a moment ago makes this fail; the others were woken.
            let _ = notifier.notify();
        }
        Ok(())
    }

    /// Gives late joiners what history they are due, also while nothing new is sent.
    pub fn serve_late_joiners(&self) {
        let _ = self.port.update_connections();
    }
}

impl<T: Message> Subscriber<T> {
    /// Subscribes to `topic` for `part` with room for `depth` unread messages; older ones give way.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, topic: &Topic, part: &str, depth: usize) -> Result<Self, BusError> {
        let name = topic.of(part);
        patiently(bus, || {
            let service = service(bus, topic, &name)?;
            let port = take_place((bus, &service), (&name, "subscribe"), |service| {
                let builder = service.subscriber_builder().buffer_size(depth);
                builder.history_request(topic.history.min(depth)).create()
            })?;
            Ok(Self {
                port,
                listener: None,
                name: name.clone(),
            })
        })
    }

    /// The same, and woken by each message: see [`crate::wake`].
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open_waking(bus: &Bus, topic: &Topic, part: &str, depth: usize) -> Result<Self, BusError> {
        let mut subscriber = Self::open(bus, topic, part, depth)?;
        subscriber.listener = Some(listener(bus, topic, &subscriber.name)?);
        Ok(subscriber)
    }

    pub(crate) fn listener(&self) -> Option<&Listener<Ipc>> {
        self.listener.as_ref()
    }

    /// The next unread message.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn next(&self) -> Result<Option<T>, BusError> {
        let sample = self.port.receive().map_err(transfer_error(&self.name, "receiving"))?;
        Ok(sample.map(|sample| *sample.payload()))
    }

    /// Whether a message is there that was not read.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn has_unread(&self) -> Result<bool, BusError> {
        self.port.has_samples().map_err(transfer_error(&self.name, "receiving"))
    }

    /// The newest unread message; the others are passed over.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn newest(&self) -> Result<Option<T>, BusError> {
        let mut newest = None;
        while let Some(message) = self.next()? {
            newest = Some(message);
        }
        Ok(newest)
    }
}
