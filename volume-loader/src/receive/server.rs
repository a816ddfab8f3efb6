//! The port: connections are taken, one of them becomes an association, others are told to come later.

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

use bus::clock::monotonic_ns;
use bus::process::StopFlag;

use super::association::{Association, Place, Rules, Unanswered, agree};
use super::outcome::{Ended, Outcome};
use super::progress::{Progress, tell};
use super::store::Store;
use super::wire::Wire;

/// A connection that says nothing has a thread until its time is over; more than these are closed at once.
const MAX_CONNECTIONS: usize = 8;
/// Limits of time, and whether to stop, are looked at so often.
const TICK: Duration = Duration::from_millis(50);
/// An answer is a few hundred bytes: whoever does not take it for so long reads nothing.
const WRITE_PATIENCE: Duration = Duration::from_secs(5);
/// How long an association may take to break off when this process is asked to stop, ns.
const STOPPING_NS: i64 = 5_000_000_000;

/// Why nothing is received, or no longer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServeError {
    /// The port cannot be had.
    #[error(
        "cannot listen on {address}: {source}; another program may have this port, and below 1024 a right is needed"
    )]
    Bind {
        /// The address.
        address: SocketAddr,
        /// The system's reason.
        source: io::Error,
    },
    /// Connections cannot be taken any more.
    #[error("cannot take connections on {address}: {source}")]
    Accept {
        /// The address.
        address: SocketAddr,
        /// The system's reason.
        source: io::Error,
    },
    /// It was stopped in the middle of an association.
    #[error("stopped in the middle of an association, which was broken off: what it brought is incomplete")]
    Stopped,
    /// It was stopped while what came was inspected.
    #[error("stopped before what came was inspected; it is kept")]
    NotInspected,
    /// It was stopped before the association that was waited for came.
    #[error("stopped before an association brought anything")]
    NothingCame,
    /// The one association that was waited for did not bring all it was to bring.
    #[error("the association did not bring what can be used as a whole; why stands above")]
    NotAll,
}

/// What is done with what an association brought; whether that is all right.
pub(crate) type Report = Box<dyn Fn(&Outcome) -> bool + Send + Sync>;

/// A port on which examinations are received.
pub(crate) struct Server {
    listener: TcpListener,
    address: SocketAddr,
    shared: Arc<Shared>,
}

struct Shared {
    rules: Rules,
    store: Store,
    stop: StopFlag,
    once: bool,
    report: Report,
    /// There is an association, or what it brought is being looked at.
    is_taken: AtomicBool,
    /// It is being received.
    is_receiving: AtomicBool,
    /// One was broken off because of `stop`.
    was_stopped: AtomicBool,
    connections: AtomicUsize,
}

impl Server {
    /// Opens the port.
    ///
    /// # Errors
    /// [`ServeError::Bind`].
    pub(crate) fn bind(
        rules: Rules,
        store: Store,
        stop: StopFlag,
        once: bool,
        report: Report,
    ) -> Result<Self, ServeError> {
        let address = rules.pacs.address;
        let bound = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            Ok((listener.local_addr()?, listener))
        });
        let (address, listener) = bound.map_err(|source| ServeError::Bind { address, source })?;
        let shared = Arc::new(Shared {
            rules,
            store,
            stop,
            once,
            report,
            is_taken: AtomicBool::new(false),
            is_receiving: AtomicBool::new(false),
            was_stopped: AtomicBool::new(false),
            connections: AtomicUsize::new(0),
        });
        Ok(Self {
            listener,
            address,
            shared,
        })
    }

    /// Where it listens.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Receives until it is asked to stop, or, where one association was asked for, until that is over.
    ///
    /// # Errors
    /// [`ServeError`].
    pub(crate) fn serve(self) -> Result<(), ServeError> {
        let (done, over) = mpsc::channel();
        while !self.shared.stop.is_set() {
            match self.listener.accept() {
                Ok((stream, peer)) => self.take(stream, peer, done.clone()),
                Err(error) if is_passing(&error) => {}
                Err(source) => {
                    let address = self.address;
                    return Err(ServeError::Accept { address, source });
                }
            }
            if let Ok(is_right) = over.try_recv() {
                return if is_right { Ok(()) } else { Err(ServeError::NotAll) };
            }
        }
        let until_ns = monotonic_ns() + STOPPING_NS;
        while self.shared.is_receiving.load(Ordering::Acquire) && monotonic_ns() < until_ns {
            thread::sleep(TICK);
        }
        let is_set = |flag: &AtomicBool| flag.load(Ordering::Acquire);
        match () {
            () if is_set(&self.shared.was_stopped) || is_set(&self.shared.is_receiving) => Err(ServeError::Stopped),
            () if is_set(&self.shared.is_taken) => Err(ServeError::NotInspected),
            () if self.shared.once => Err(ServeError::NothingCame),
            () => Ok(()),
        }
    }

    fn take(&self, stream: TcpStream, peer: SocketAddr, done: mpsc::Sender<bool>) {
        let shared = self.shared.clone();
        if shared.connections.fetch_add(1, Ordering::AcqRel) >= MAX_CONNECTIONS {
            shared.connections.fetch_sub(1, Ordering::AcqRel);
            tell(peer, &format!("{MAX_CONNECTIONS} connections are open; it is closed"));
            return;
        }
        thread::spawn(move || {
            let _open = Counted(&shared.connections);
            let served = catch_unwind(AssertUnwindSafe(|| serve(&shared, stream, peer)));
            let is_right = served.unwrap_or_else(|_| {
                tell(
                    peer,
                    "an error of this program ended the association; what it brought is incomplete",
                );
                Some(false)
            });
            // Nobody listens any more where the process ends.
            if let Some(is_right) = is_right.filter(|_| shared.once) {
                let _ = done.send(is_right);
            }
        });
    }
}

/// What is over by itself: nobody is there, or the connection is gone before it was taken. Else a moment is waited.
fn is_passing(error: &io::Error) -> bool {
    let is_passing = matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted | io::ErrorKind::ConnectionAborted
    );
    if is_passing {
        thread::sleep(TICK);
    }
    is_passing
}

/// Takes itself off a count.
struct Counted<'a>(&'a AtomicUsize);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Takes a flag back.
struct Held<'a>(&'a AtomicBool);

impl<'a> Held<'a> {
    fn take(flag: &'a AtomicBool) -> Option<Self> {
        (!flag.swap(true, Ordering::AcqRel)).then_some(Self(flag))
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// One connection. `None` where it brought nothing and was to bring nothing: rejected, or a verification.
fn serve(shared: &Shared, stream: TcpStream, peer: SocketAddr) -> Option<bool> {
    let prepared = stream
        .set_read_timeout(Some(TICK))
        .and_then(|()| stream.set_write_timeout(Some(WRITE_PATIENCE)))
        .and_then(|()| stream.set_nodelay(true));
    if let Err(error) = prepared {
        tell(peer, &format!("the connection cannot be used: {error}"));
        return None;
    }
    let stop = || shared.stop.is_set();
    let mut wire = Wire::new(stream, &stop);
    let (mut taken, mut receiving) = (None, None);
    let agreed = agree(&mut wire, &shared.rules, || {
        taken = Held::take(&shared.is_taken);
        receiving = taken.as_ref().and_then(|_| Held::take(&shared.is_receiving));
        taken.is_some()
    });
    let agreed = match agreed {
        Ok(agreed) => agreed,
        Err(Unanswered::Rejected(why)) => {
            tell(peer, &format!("association rejected: {why}"));
            return None;
        }
        Err(Unanswered::NoRequest(why)) => {
            tell(peer, &format!("no association: {why}"));
            return None;
        }
    };
    let (accepted, (by_coding, refused)) = (agreed.contexts.len(), &agreed.refused);
    let from = agreed.from.clone();
    tell(
        peer,
        &format!("association of {from}; presentation contexts: {accepted} accepted, {refused} refused"),
    );
    for refused in by_coding.iter().take(3) {
        tell(peer, &format!("its coding is not read: {refused}"));
    }
    let mut progress = Progress::new(peer);
    let place = Place {
        rules: &shared.rules,
        store: &shared.store,
        tell: &|words| tell(peer, words),
    };
    let outcome = Association::new(&mut wire, place, agreed).run(&mut |count| progress.at(count));
    progress.finish();
    if outcome.ended == Ended::Stopped {
        shared.was_stopped.store(true, Ordering::Release);
    }
    drop(receiving);
    tell(peer, &summary(&from, &outcome));
    let is_right = (shared.report)(&outcome);
    let is_last = shared.once && outcome.asked > 0;
    if is_last {
        // The process ends with this one: an association that began now would be cut off.
        std::mem::forget(taken);
    }
    (outcome.asked > 0).then_some(is_right)
}

fn summary(from: &str, outcome: &Outcome) -> String {
    let (stored, same, refused) = (outcome.stored(), outcome.same(), outcome.refused);
    let mib = outcome.bytes as f64 / f64::from(1 << 20);
    let echoes = match outcome.echoes {
        0 => String::new(),
        echoes => format!("{echoes} verifications, "),
    };
    format!(
        "association of {from} {}: {echoes}{} instances sent, {stored} stored, {same} were there already, {refused} refused; {mib:.1} MiB",
        outcome.ended, outcome.asked
    )
}
