//! Where a sender listens and whom a receiver dials: `tls/HOST:PORT`, or `tcp/LOOPBACK:PORT` on one machine.
//!
//! zenoh takes options behind an endpoint (`tls/host:7447#verify_name_on_connect=false`) that would undo what the configuration says.
//! So an endpoint is read here into its parts, and only these parts are given on.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use rustls::pki_types::ServerName;

/// How bytes travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// Plain, and nobody shows who they are: on loopback alone.
    Tcp,
    /// Encrypted, both ends with certificates.
    Tls,
}

/// Which end of the link an endpoint belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The sender's: an address of this machine. Port 0 lets the operating system choose one.
    Listen,
    /// The receiver's: the sender's host, by the name in its certificate.
    Connect,
}

/// An endpoint that was read and may be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Endpoint {
    transport: Transport,
    end: End,
    host: Host,
    port: u16,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Host {
    Ip(IpAddr),
    Name(String),
}

/// Why an endpoint is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EndpointError {
    /// It is not of the form `tls/HOST:PORT`.
    #[error("`{found}` is no endpoint; write tls/HOST:PORT, or tcp/127.0.0.1:PORT on one machine")]
    Form {
        /// What was written.
        found: String,
    },
    /// Options stand behind it.
    #[error("`{found}` has options behind the port; an endpoint is tls/HOST:PORT and nothing more")]
    Options {
        /// What was written.
        found: String,
    },
    /// Another way of travelling.
    #[error("`{found}` travels by `{transport}`; allowed are tls, and tcp on loopback")]
    Transport {
        /// What was written.
        found: String,
        /// The part before the slash.
        transport: String,
    },
    /// The host is neither a name nor an address.
    #[error("`{host}` in `{found}` is neither the name of a host nor an address (IPv6 in brackets)")]
    Host {
        /// What was written.
        found: String,
        /// The part before the port.
        host: String,
    },
    /// The port is none.
    #[error("`{port}` in `{found}` is no port; allowed are {least} to 65535")]
    Port {
        /// What was written.
        found: String,
        /// The part behind the host.
        port: String,
        /// The least that is allowed there.
        least: u16,
    },
    /// Plain TCP, and the host is not this machine.
    #[error(
        "`{found}` is plain TCP and leaves this machine: anybody on the way could read and alter it. \
         Make keys (`remote-proc keys --out DIR --host NAME`) and write tls/{host}:{port}"
    )]
    Exposed {
        /// What was written.
        found: String,
        /// The host.
        host: String,
        /// The port.
        port: u16,
    },
    /// An IPv6 address dialled by TLS, which zenoh cannot check a certificate for.
    #[error(
        "`{found}`: zenoh checks no certificate against an IPv6 address; write the host's name, which its certificate states"
    )]
    Ipv6 {
        /// What was written.
        found: String,
    },
    /// A receiver cannot dial all addresses.
    #[error("`{found}`: {host} means every address of a machine, and is none to connect to")]
    Unspecified {
        /// What was written.
        found: String,
        /// The host.
        host: String,
    },
}

impl Endpoint {
    /// Reads where a sender listens.
    ///
    /// # Errors
    /// Each variant of [`EndpointError`] but the last two.
    pub fn listen(text: &str) -> Result<Self, EndpointError> {
        Self::read(text, End::Listen)
    }

    /// Reads whom a receiver dials.
    ///
    /// # Errors
    /// Each variant of [`EndpointError`].
    pub fn connect(text: &str) -> Result<Self, EndpointError> {
        let endpoint = Self::read(text, End::Connect)?;
        let found = || text.to_owned();
        match &endpoint.host {
            Host::Ip(ip) if ip.is_unspecified() => {
                let host = ip.to_string();
                Err(EndpointError::Unspecified { found: found(), host })
            }
            Host::Ip(IpAddr::V6(_)) if endpoint.transport == Transport::Tls => {
                Err(EndpointError::Ipv6 { found: found() })
            }
            _ => Ok(endpoint),
        }
    }

    fn read(text: &str, end: End) -> Result<Self, EndpointError> {
        let found = || text.to_owned();
        if text.contains(['#', '?', ';']) {
            return Err(EndpointError::Options { found: found() });
        }
        let form = || EndpointError::Form { found: found() };
        let (transport, rest) = text.split_once('/').ok_or_else(form)?;
        let transport = match transport {
            "tcp" => Transport::Tcp,
            "tls" => Transport::Tls,
            other => {
                let transport = other.to_owned();
                return Err(EndpointError::Transport {
                    found: found(),
                    transport,
                });
            }
        };
        let (host, port) = rest.rsplit_once(':').ok_or_else(form)?;
        let least = u16::from(end == End::Connect);
        let is_number = !port.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit());
        let number = port.parse().ok().filter(|number| is_number && *number >= least);
        let port = number.ok_or_else(|| EndpointError::Port {
            found: found(),
            port: port.to_owned(),
            least,
        })?;
        let host = read_host(host).ok_or_else(|| EndpointError::Host {
            found: found(),
            host: host.to_owned(),
        })?;
        let endpoint = Self {
            transport,
            end,
            host,
            port,
        };
        match transport == Transport::Tls || endpoint.is_loopback() {
            true => Ok(endpoint.resolved()),
            false => Err(EndpointError::Exposed {
                found: found(),
                host: endpoint.host(),
                port,
            }),
        }
    }

    /// How bytes travel.
    pub const fn transport(&self) -> Transport {
        self.transport
    }

    /// Whose endpoint it is.
    pub const fn end(&self) -> End {
        self.end
    }

    /// The host, as a certificate states it: a name, or an address without brackets.
    pub fn host(&self) -> String {
        match &self.host {
            Host::Ip(ip) => ip.to_string(),
            Host::Name(name) => name.clone(),
        }
    }

    /// The port; 0 lets the operating system choose one to listen at.
    pub const fn port(&self) -> u16 {
        self.port
    }

    /// Whether what is sent there stays on this machine.
    pub fn is_loopback(&self) -> bool {
        match &self.host {
            Host::Ip(ip) => ip.is_loopback(),
            Host::Name(name) => name == "localhost",
        }
    }

    /// By plain TCP `localhost` is written as its address, since a resolver may be told that it is another machine.
    fn resolved(mut self) -> Self {
        if self.transport == Transport::Tcp && matches!(self.host, Host::Name(_)) {
            self.host = Host::Ip(Ipv4Addr::LOCALHOST.into());
        }
        self
    }
}

/// In the form that zenoh reads, without any option.
impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let transport = match self.transport {
            Transport::Tcp => "tcp",
            Transport::Tls => "tls",
        };
        match &self.host {
            Host::Ip(ip) => write!(f, "{transport}/{}", SocketAddr::new(*ip, self.port)),
            Host::Name(name) => write!(f, "{transport}/{name}:{}", self.port),
        }
    }
}

fn read_host(text: &str) -> Option<Host> {
    if let Some(inner) = text.strip_prefix('[') {
        let ip = inner.strip_suffix(']')?.parse().ok()?;
        return Some(Host::Ip(IpAddr::V6(ip)));
    }
    if let Ok(ip) = text.parse::<Ipv4Addr>() {
        return Some(Host::Ip(IpAddr::V4(ip)));
    }
    // A name of digits alone is an address that was written wrongly, and resolvers read 127.1 or 2130706433 as one.
    let last = text.rsplit('.').next().unwrap_or(text);
    let is_number = last.starts_with(|first: char| first.is_ascii_digit());
    match ServerName::try_from(text) {
        Ok(ServerName::DnsName(name)) if !is_number => Some(Host::Name(name.as_ref().to_ascii_lowercase())),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
