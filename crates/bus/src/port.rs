//! Ports: typed ends of the topics in [`crate::topic`].

mod command;
mod frame;
mod handed;
mod headed;
mod places;
mod services;
mod stream;
mod us_image;
mod volume;

pub use command::{CommandClient, CommandServer, Pending, Reply, Request};
pub use frame::{Frame, FramePublisher, FrameSubscriber, Shown};
pub use handed::HandedVolume;
pub use headed::{Headed, HeadedPublisher, HeadedSubscriber, Value};
pub use places::Crowded;
pub use services::{Members, Services};
pub use stream::{Publisher, Subscriber};
pub use us_image::{UsImage, UsImagePublisher, UsImageSubscriber};
pub use volume::{LoanedVolume, SharedVolume, VolumePublisher, VolumeSubscriber};

use std::fmt::Debug;

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::Builder;
use iceoryx2::service::port_factory::event::PortFactory as EventFactory;

use crate::node::{Ipc, MAX_NODES, patiently};
use crate::topic::Topic;
use crate::{Bus, BusError};
use places::take_place;

/// A plain struct that can lie in shared memory: each struct of [`crate::message`].
pub trait Message: ZeroCopySend + Debug + Copy + 'static {}
impl<T: ZeroCopySend + Debug + Copy + 'static> Message for T {}

fn open_error<E: Debug>(topic: &str, what: &'static str) -> impl FnOnce(E) -> BusError {
    let topic = topic.to_owned();
    move |e| BusError::Open {
        topic,
        what,
        why: format!("{e:?}"),
    }
}

fn transfer_error<E: Debug>(topic: &str, what: &'static str) -> impl FnOnce(E) -> BusError {
    let topic = topic.to_owned();
    move |e| BusError::Transfer {
        topic,
        what,
        why: format!("{e:?}"),
    }
}

/// The limits of a topic's row, whatever its payload.
fn limited<P: Debug + IceoryxSend + ?Sized, H: Debug + ZeroCopySend>(
    builder: Builder<P, H, Ipc>,
    topic: &Topic,
) -> Builder<P, H, Ipc> {
    builder
        .enable_safe_overflow(true)
        .max_publishers(topic.publishers)
        .max_subscribers(topic.subscribers)
        .max_nodes(MAX_NODES)
        .history_size(topic.history)
        .subscriber_max_buffer_size(topic.buffer)
        .subscriber_max_borrowed_samples(topic.borrowed)
}

fn service_name(name: &str) -> Result<ServiceName, BusError> {
    ServiceName::new(name).map_err(open_error(name, "join"))
}

/// The event that wakes a topic's receivers, beside the topic itself.
fn event_service(bus: &Bus, topic: &Topic, name: &str) -> Result<EventFactory<Ipc>, BusError> {
    bus.node
        .service_builder(&service_name(name)?)
        .event()
        .max_notifiers(topic.subscribers + 1)
        .max_listeners(topic.subscribers)
        .max_nodes(MAX_NODES)
        .event_id_max_value(1)
        .open_or_create()
        .map_err(open_error(name, "wake"))
}

/// What wakes the receivers of a topic; `None` where the topic wakes nobody.
fn notifier(bus: &Bus, topic: &Topic, name: &str) -> Result<Option<Notifier<Ipc>>, BusError> {
    if !topic.wakes {
        return Ok(None);
    }
    let notifier = event_service(bus, topic, name)?.notifier_builder().create();
    notifier.map(Some).map_err(open_error(name, "notify"))
}

/// What a receiver of a topic is woken by.
fn listener(bus: &Bus, topic: &Topic, name: &str) -> Result<Listener<Ipc>, BusError> {
    patiently(bus, || {
        let service = event_service(bus, topic, name)?;
        take_place((bus, &service), (name, "listen"), |service| {
            service.listener_builder().create()
        })
    })
}
