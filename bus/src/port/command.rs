//! Requests to a process and their replies.

use std::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::AllocationStrategy;
use iceoryx2::service::port_factory::request_response::PortFactory;

use super::{event_service, open_error, service_name, transfer_error};
use crate::clock;
use crate::message::{Command, ReplyHeader};
use crate::node::{Ipc, MAX_NODES, patiently};
use crate::topic::COMMAND;
use crate::{Bus, BusError};

/// Room for a reply at first; a longer one makes the segment grow.
const REPLY_BYTES: usize = 16 * 1024;
/// How often a waiting client looks.
const LOOK: Duration = Duration::from_micros(500);

fn service(bus: &Bus, name: &str) -> Result<PortFactory<Ipc, Command, (), [u8], ReplyHeader>, BusError> {
    bus.node
        .service_builder(&service_name(name)?)
        .request_response::<Command, [u8]>()
        .response_user_header::<ReplyHeader>()
        .max_servers(COMMAND.publishers)
        .max_clients(COMMAND.subscribers)
        .max_nodes(MAX_NODES)
        .open_or_create()
        .map_err(open_error(name, "join"))
}

/// The side that answers.
#[derive(Debug)]
pub struct CommandServer {
    port: Server<Ipc, Command, (), [u8], ReplyHeader>,
    listener: Listener<Ipc>,
    name: String,
}

/// A request to be answered.
#[derive(Debug)]
pub struct Request {
    active: ActiveRequest<Ipc, Command, (), [u8], ReplyHeader>,
    name: String,
}

impl CommandServer {
    /// Becomes the process that answers for `process`.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, process: &str) -> Result<Self, BusError> {
        let name = COMMAND.of(process);
        patiently(bus, || {
            let port = service(bus, &name)?
                .server_builder()
                .initial_max_slice_len(REPLY_BYTES)
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .create()
                .map_err(open_error(&name, "answer"))?;
            let listener = event_service(bus, &COMMAND, &name)?
                .listener_builder()
                .create()
                .map_err(open_error(&name, "listen"))?;
            Ok(Self {
                port,
                listener,
                name: name.clone(),
            })
        })
    }

    pub(crate) fn listener(&self) -> &Listener<Ipc> {
        &self.listener
    }

    /// The next unanswered request.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn next(&self) -> Result<Option<Request>, BusError> {
        let active = self.port.receive().map_err(transfer_error(&self.name, "receiving"))?;
        Ok(active.map(|active| Request {
            active,
            name: self.name.clone(),
        }))
    }
}

impl Request {
    /// What is asked for.
    pub fn command(&self) -> &Command {
        self.active.payload()
    }

    /// Answers. `Err` refuses the request with its reason.
    ///
    /// # Errors
    /// [`BusError::Transfer`]; a client that has gone is no error.
    pub fn reply(self, answer: Result<&str, &str>) -> Result<(), BusError> {
        let (refused, text) = match answer {
            Ok(text) => (0, text),
            Err(text) => (1, text),
        };
        if !self.active.is_connected() {
            return Ok(());
        }
        let response = self
            .active
            .loan_slice_uninit(text.len())
            .map_err(transfer_error(&self.name, "taking memory"))?;
        let mut response = response.write_from_slice(text.as_bytes());
        response.user_header_mut().refused = refused;
        response.send().map_err(transfer_error(&self.name, "answering"))
    }
}

/// The side that asks.
#[derive(Debug)]
pub struct CommandClient {
    port: Client<Ipc, Command, (), [u8], ReplyHeader>,
    notifier: Notifier<Ipc>,
    name: String,
    clock: clock::Clock,
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// Whether the request was refused; the text says why.
    pub refused: bool,
    /// The answer.
    pub text: String,
}

impl CommandClient {
    /// Prepares to ask `process`.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, process: &str) -> Result<Self, BusError> {
        let name = COMMAND.of(process);
        patiently(bus, || {
            let port = service(bus, &name)?
                .client_builder()
                .create()
                .map_err(open_error(&name, "ask"))?;
            let notifier = event_service(bus, &COMMAND, &name)?
                .notifier_builder()
                .create()
                .map_err(open_error(&name, "notify"))?;
            Ok(Self {
                port,
                notifier,
                name: name.clone(),
                clock: bus.clock().clone(),
            })
        })
    }

    /// Asks and waits for the answer.
    ///
    /// # Errors
    /// [`BusError::NoAnswer`] after `patience`, [`BusError::Transfer`].
    pub fn ask(&self, command: Command, patience: Duration) -> Result<Reply, BusError> {
        let pending = self
            .port
            .send_copy(command)
            .map_err(transfer_error(&self.name, "asking"))?;
        let _ = self.notifier.notify();
        let deadline = self.clock.now_ns() + clock::ns(patience);
        loop {
            let response = pending
                .receive()
                .map_err(transfer_error(&self.name, "receiving the answer"))?;
            if let Some(response) = response {
                return Ok(Reply {
                    refused: response.user_header().refused != 0,
                    text: String::from_utf8_lossy(response.payload()).into_owned(),
                });
            }
            if self.clock.now_ns() > deadline {
                return Err(BusError::NoAnswer {
                    service: self.name.clone(),
                    waited: patience,
                });
            }
            std::thread::sleep(LOOK);
        }
    }
}
