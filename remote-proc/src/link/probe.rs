//! A look at the peer before a session is opened: zenoh says only that it was unable to connect.
//!
//! A connection is made, with the same keys, and let go again. What it tells holds for that moment: whoever opens a session then may
//! still be refused.

use std::io;
use std::net::{IpAddr, SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use time::OffsetDateTime;

use super::endpoint::{Endpoint, Transport};
use super::keys::read::date;
use super::keys::{Keys, Side};

mod tls;

/// How long each step may take: finding the address, connecting, each answer of the handshake.
pub const LIMIT: Duration = Duration::from_secs(1);

/// Why there is no link: what was found, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The host has no address.
    #[error(
        "{host} has no address: {reason}; look at the name, or write an address that the sender's certificate states"
    )]
    Unknown {
        /// The host.
        host: String,
        /// What the resolver says.
        reason: String,
    },
    /// The machine answers, and nothing listens there.
    #[error("{at} refuses the connection: no `remote-proc send` listens at that port")]
    Closed {
        /// The address.
        at: SocketAddr,
    },
    /// No answer.
    #[error("{at} does not answer within {} s: the machine is off, the cable is out, or a firewall drops it", LIMIT.as_secs())]
    NoAnswer {
        /// The address.
        at: SocketAddr,
    },
    /// The operating system cannot get there.
    #[error("{at} cannot be reached: {source}")]
    Unreachable {
        /// The address.
        at: SocketAddr,
        /// What the operating system says.
        source: io::Error,
    },
    /// TLS was asked for without keys, or with the other side's.
    #[error("{endpoint} needs the keys of the receiver")]
    NoKeys {
        /// The endpoint.
        endpoint: String,
    },
    /// What listens there does not speak TLS.
    #[error("{at} does not speak TLS: {found}; something else listens there, or a sender without keys")]
    NotTls {
        /// The address.
        at: SocketAddr,
        /// What it answered.
        found: String,
    },
    /// The peer's certificate is over.
    #[error("the certificate of {name} at {at} ended {}, and this machine's clock says {}; make new keys", date(*not_after), date(*now))]
    Expired {
        /// The address.
        at: SocketAddr,
        /// Its common name.
        name: String,
        /// When it ended.
        not_after: OffsetDateTime,
        /// This machine's clock.
        now: OffsetDateTime,
    },
    /// The peer's certificate has not begun.
    #[error("the certificate of {name} at {at} begins {}, and this machine's clock says {}; set it", date(*not_before), date(*now))]
    NotYet {
        /// The address.
        at: SocketAddr,
        /// Its common name.
        name: String,
        /// When it begins.
        not_before: OffsetDateTime,
        /// This machine's clock.
        now: OffsetDateTime,
    },
    /// Another authority signed the peer's certificate.
    #[error(
        "the certificate of {name} at {at} is signed by `{found}`, and the keys here are of `{ours}`; copy both sides' from one set"
    )]
    Authority {
        /// The address.
        at: SocketAddr,
        /// Its common name.
        name: String,
        /// Who signed it.
        found: String,
        /// Who is trusted here.
        ours: String,
    },
    /// The peer's certificate is for other hosts.
    #[error("the certificate at {at} is for {}, and `{asked}` was asked for; write one of these, or make keys with --host {asked}", hosts.join(", "))]
    Host {
        /// The address.
        at: SocketAddr,
        /// The host that was asked for.
        asked: String,
        /// Those that the certificate states.
        hosts: Vec<String>,
    },
    /// The peer is no sender.
    #[error("the certificate at {at} is of `{found}`, expected `{}`", Side::Sender.common_name())]
    NoSender {
        /// The address.
        at: SocketAddr,
        /// Its common name.
        found: String,
    },
    /// The peer refuses the own certificate.
    #[error(
        "{at} refuses the certificate here, of `{authority}`: {alert}; the sender's keys are of another set, or its clock is wrong"
    )]
    Refused {
        /// The address.
        at: SocketAddr,
        /// The authority of the own certificate.
        authority: String,
        /// The peer's reason, as TLS names it.
        alert: String,
    },
    /// Anything else that went wrong in the handshake.
    #[error("the handshake with {at} failed: {reason}")]
    Handshake {
        /// The address.
        at: SocketAddr,
        /// What was wrong.
        reason: String,
    },
}

/// Connects to the sender once, as a session would, and takes leave.
///
/// # Errors
/// Each variant of [`ProbeError`]. Plain TCP shows only whether something listens.
pub fn probe(to: &Endpoint, keys: Option<&Keys>) -> Result<(), ProbeError> {
    let keys = match to.transport() {
        Transport::Tcp => None,
        Transport::Tls => {
            let receiver = keys.filter(|keys| keys.side() == Side::Receiver);
            Some(receiver.ok_or_else(|| ProbeError::NoKeys {
                endpoint: to.to_string(),
            })?)
        }
    };
    let (stream, at) = connect(to)?;
    keys.map_or(Ok(()), |keys| tls::greet(stream, at, &to.host(), keys))
}

/// The first of the host's addresses that takes a connection; else the error of the last.
fn connect(to: &Endpoint) -> Result<(TcpStream, SocketAddr), ProbeError> {
    let mut last = ProbeError::Unknown {
        host: to.host(),
        reason: "it has none".to_owned(),
    };
    for at in addresses(to)? {
        match TcpStream::connect_timeout(&at, LIMIT) {
            Ok(stream) => return Ok((stream, at)),
            Err(source) => last = unreached(at, source),
        }
    }
    Err(last)
}

fn unreached(at: SocketAddr, source: io::Error) -> ProbeError {
    match source.kind() {
        io::ErrorKind::ConnectionRefused => ProbeError::Closed { at },
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock => ProbeError::NoAnswer { at },
        _ => ProbeError::Unreachable { at, source },
    }
}

fn addresses(to: &Endpoint) -> Result<Vec<SocketAddr>, ProbeError> {
    let (host, port) = (to.host(), to.port());
    if let Ok(ip) = host.parse::<IpAddr>() {
        return Ok(vec![SocketAddr::new(ip, port)]);
    }
    // A resolver may take half a minute and cannot be stopped; then it ends by itself.
    let (tell, told) = mpsc::sync_channel(1);
    let name = host.clone();
    thread::spawn(move || {
        let found = (name.as_str(), port).to_socket_addrs().map(Iterator::collect::<Vec<_>>);
        let _ = tell.send(found);
    });
    match told.recv_timeout(LIMIT) {
        Ok(Ok(found)) => Ok(found),
        Ok(Err(error)) => Err(ProbeError::Unknown {
            host,
            reason: error.to_string(),
        }),
        Err(_) => Err(ProbeError::Unknown {
            host,
            reason: format!("no answer within {} s", LIMIT.as_secs()),
        }),
    }
}
