//! Requests to a process and their replies.

use std::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::service::port_factory::request_response::PortFactory;

use super::places::take_place;
use super::{event_service, open_error, service_name, transfer_error};
use crate::clock;
use crate::message::{Command, ReplyHeader};
use crate::node::{Ipc, MAX_NODES, patiently};
use crate::topic::COMMAND;
use crate::{Bus, BusError};

/// The longest reply. A segment that may grow instead costs the server 3 MB of book-keeping for each client that comes
/// and goes: a burst of short-lived clients then holds it up for seconds.
const REPLY_BYTES: usize = 64 * 1024;
/// How often a waiting client looks.
const LOOK: Duration = Duration::from_micros(500);
/// How long a client waits between two looks whether there is still somebody to answer.
const LOOK_FOR_SERVER: Duration = Duration::from_millis(100);

pub(super) fn service(bus: &Bus, name: &str) -> Result<PortFactory<Ipc, Command, (), [u8], ReplyHeader>, BusError> {
    bus.node
        .service_builder(&service_name(name)?)
        .request_response::<Command, [u8]>()
        .response_user_header::<ReplyHeader>()
        .max_servers(COMMAND.publishers)
        .max_clients(COMMAND.subscribers)
        .max_active_requests_per_client(1)
        .max_loaned_requests(1)
        .max_response_buffer_size(1)
        .max_borrowed_responses_per_pending_response(1)
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

    /// Answers. `Err` refuses the request with its reason. An answer longer than 64 KiB becomes a refusal that says so.
    ///
    /// # Errors
    /// [`BusError::Transfer`]; a client that has gone is no error.
    pub fn reply(self, answer: Result<&str, &str>) -> Result<(), BusError> {
        let too_long = |text: &str| format!("the answer has {} bytes; {REPLY_BYTES} is the most", text.len());
        let refusal;
        let (refused, text) = match answer {
            Ok(text) if text.len() > REPLY_BYTES => {
                refusal = too_long(text);
                (1, refusal.as_str())
            }
            Ok(text) => (0, text),
            Err(text) => (1, &text[..text.floor_char_boundary(REPLY_BYTES)]),
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

/// A request that was sent. Dropped, its answer goes nowhere.
#[derive(Debug)]
pub struct Pending {
    port: PendingResponse<Ipc, Command, (), [u8], ReplyHeader>,
    name: String,
    clock: clock::Clock,
    asked_ns: i64,
}

impl Pending {
    /// The answer, where it has come. Never waits.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn reply(&self) -> Result<Option<Reply>, BusError> {
        let response = self
            .port
            .receive()
            .map_err(transfer_error(&self.name, "receiving the answer"))?;
        Ok(response.map(|response| Reply {
            refused: response.user_header().refused != 0,
            text: String::from_utf8_lossy(response.payload()).into_owned(),
        }))
    }

    /// How long it has been waited for, ns.
    pub fn waited_ns(&self) -> i64 {
        self.clock.now_ns() - self.asked_ns
    }

    /// That it is not waited for any longer.
    pub fn no_answer(&self) -> BusError {
        BusError::NoAnswer {
            service: self.name.clone(),
            waited: Duration::from_nanos(self.waited_ns().max(0) as u64),
        }
    }
}

impl CommandClient {
    /// Prepares to ask `process`.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, process: &str) -> Result<Self, BusError> {
        let name = COMMAND.of(process);
        patiently(bus, || {
            let service = service(bus, &name)?;
            let port = take_place((bus, &service), (&name, "ask"), |service| {
                service.client_builder().create()
            })?;
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
        self.ask_while(command, patience, || true)
    }

    /// The same as long as there is somebody to answer, by `is_there`, asked ten times a second.
    ///
    /// # Errors
    /// [`BusError::NoAnswer`] after `patience` and where nobody is there, [`BusError::Transfer`].
    pub fn ask_while(
        &self,
        command: Command,
        patience: Duration,
        is_there: impl Fn() -> bool,
    ) -> Result<Reply, BusError> {
        let pending = self.send(command)?;
        let mut next_look = clock::ns(LOOK_FOR_SERVER);
        loop {
            if let Some(reply) = pending.reply()? {
                return Ok(reply);
            }
            let waited = pending.waited_ns();
            let is_late = waited > clock::ns(patience);
            if is_late || waited > next_look && !is_there() {
                return Err(pending.no_answer());
            }
            if waited > next_look {
                next_look = waited + clock::ns(LOOK_FOR_SERVER);
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Asks, and waits for nothing.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn send(&self, command: Command) -> Result<Pending, BusError> {
        let port = self
            .port
            .send_copy(command)
            .map_err(transfer_error(&self.name, "asking"))?;
        let _ = self.notifier.notify();
        Ok(Pending {
            port,
            name: self.name.clone(),
            clock: self.clock.clone(),
            asked_ns: self.clock.now_ns(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::CommandKind;
    use crate::run::{RunContext, SHM_DIR};

    #[test]
    fn where_nobody_is_left_to_answer_nobody_is_waited_for() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), 0).unwrap();
        let bus = Bus::join(&run).unwrap();
        let (server, client) = (
            CommandServer::open(&bus, "pilot").unwrap(),
            CommandClient::open(&bus, "pilot").unwrap(),
        );
        let hour = Duration::from_secs(3600);
        let answer = client.ask_while(Command::new(CommandKind::Status), hour, || false);
        assert!(matches!(answer, Err(BusError::NoAnswer { waited, .. }) if waited < hour));
        drop((server, client, bus));
        run.sweep();
    }

    /// A client's connection lies in shared memory at each side; the server goes through all of it when the client
    /// leaves. With segments that may grow it had 3 MB, and a burst of clients held the pilot up for seconds.
    #[test]
    fn a_client_costs_the_server_little_and_long_answers_are_refused() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), 0).unwrap();
        let (bus, other) = (Bus::join(&run).unwrap(), Bus::join(&run).unwrap());
        let server = CommandServer::open(&bus, "pilot").unwrap();
        let client = CommandClient::open(&other, "pilot").unwrap();
        for (length, refused) in [(REPLY_BYTES, false), (REPLY_BYTES + 1, true)] {
            let text = "x".repeat(length);
            let pending = client.port.send_copy(Command::new(CommandKind::Status)).unwrap();
            server.next().unwrap().unwrap().reply(Ok(&text)).unwrap();
            let response = pending.receive().unwrap().unwrap();
            assert_eq!(response.user_header().refused != 0, refused);
            assert!(refused || response.payload() == text.as_bytes());
        }
        let files = std::fs::read_dir(SHM_DIR).unwrap().flatten();
        let ours = files.filter(|f| f.file_name().to_string_lossy().starts_with(&run.prefix()));
        let connections: Vec<u64> = ours
            .filter(|f| f.path().extension().is_some_and(|e| e == "connection"))
            .map(|f| f.metadata().unwrap().len())
            .collect();
        assert_eq!(connections.len(), 2, "one each way");
        assert!(connections.iter().all(|&bytes| bytes < 64 * 1024), "{connections:?}");
        drop((server, client, bus, other));
        run.sweep();
    }
}
