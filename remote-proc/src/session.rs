//! Sessions of the link as either side opens them.

use std::path::Path;

use zenoh::Wait;

use crate::link::config::{self, ConfigError};
use crate::link::endpoint::{Endpoint, EndpointError};
use crate::link::keys::{Keys, LoadError, Side};
use crate::link::probe::{ProbeError, probe};

/// What ZENOH_RUNTIME must be, before the first session: everything that touches a connection is done by one thread, and nobody waits
/// in it for the link. A session is never closed by another thread either, which would write to the connection: it ends with its process.
pub const ONE_THREAD: &str =
    "(app: (worker_threads: 1), acc: (handover: app), tx: (handover: app), rx: (handover: app), net: (handover: app))";

/// An open session.
pub type Opened = zenoh::Session;

/// Why there is no session.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// What was given is no place.
    #[error(transparent)]
    Endpoint(#[from] EndpointError),
    /// The keys.
    #[error(transparent)]
    Keys(#[from] LoadError),
    /// The two do not go together.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The peer.
    #[error(transparent)]
    Probe(#[from] ProbeError),
    /// zenoh's own words.
    #[error("{endpoint}: {why}")]
    Open {
        /// Where.
        endpoint: String,
        /// Why not.
        why: String,
    },
    /// A key cannot be served or followed.
    #[error("declaring {key}: {why}")]
    Declaring {
        /// The key.
        key: &'static str,
        /// Why not.
        why: String,
    },
}

impl SessionError {
    pub(crate) fn declaring(key: &'static str, why: &dyn std::fmt::Display) -> Self {
        Self::Declaring {
            key,
            why: why.to_string(),
        }
    }
}

/// Listens for receivers.
///
/// # Errors
/// [`SessionError`].
pub fn listen(endpoint: &str, keys: Option<&Path>) -> Result<Opened, SessionError> {
    let at = Endpoint::listen(endpoint)?;
    let keys = keys.map(|folder| Keys::load(folder, Side::Sender)).transpose()?;
    open(endpoint, config::sender(&at, keys.as_ref())?)
}

/// Why a sender that was there does not answer, as far as a look tells.
///
/// # Errors
/// [`SessionError`].
pub fn look(endpoint: &str, keys: Option<&Path>) -> Result<(), SessionError> {
    let keys = keys.map(|folder| Keys::load(folder, Side::Receiver)).transpose()?;
    Ok(probe(&Endpoint::connect(endpoint)?, keys.as_ref())?)
}

/// Dials a sender; takes a few seconds at the most.
///
/// # Errors
/// [`SessionError`], with a name for whatever can be found out before zenoh tries.
pub fn dial(endpoint: &str, keys: Option<&Path>) -> Result<Opened, SessionError> {
    let to = Endpoint::connect(endpoint)?;
    let keys = keys.map(|folder| Keys::load(folder, Side::Receiver)).transpose()?;
    let config = config::receiver(&to, keys.as_ref())?;
    probe(&to, keys.as_ref())?;
    open(endpoint, config)
}

fn open(endpoint: &str, config: zenoh::Config) -> Result<Opened, SessionError> {
    zenoh::open(config).wait().map_err(|why| SessionError::Open {
        endpoint: endpoint.to_owned(),
        why: why.to_string(),
    })
}
