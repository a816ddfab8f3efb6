//! The configuration of both zenoh sessions, built here and nowhere else: no file and no environment variable is read.
//!
//! The sender is a peer that listens and connects to nobody; a receiver is a client that connects to it alone. Neither looks for others
//! (no multicast, no gossip) nor is found by them. What may cross the link stands in `access`.
//!
//! One variable of the environment acts on zenoh all the same: `ZENOH_RUNTIME` sets how many threads it has, and nothing else.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use zenoh::Config;

use super::endpoint::{End, Endpoint, Transport};
use super::keys::{Keys, Side};

mod access;

pub use access::{KEYS, LONGEST_QUERY};

/// Milliseconds without a sign of life after which a link is closed; each end sends one every quarter of that.
pub const LEASE_MS: u32 = 1500;
/// The most receivers at once; whoever comes next is refused, and the others keep theirs.
pub const MOST_RECEIVERS: usize = 32;
/// The longest message that a receiver puts together, in bytes; a longer one is dropped there.
pub const LONGEST_MESSAGE: usize = 8 << 20;
/// The longest that a sender puts together: of a query, which is small.
const LONGEST_FROM_RECEIVER: usize = 1 << 16;

/// Microseconds that a message waits for a place in a receiver's queue before it is dropped for that receiver. Only the first one
/// waits: while that queue is full, the next are dropped at once.
const DROP_AFTER_US: u32 = 200;
/// The same for the further parts of a message that is longer than a batch.
const DROP_PARTS_AFTER_US: u32 = 5000;
/// Microseconds that a reply, which is not dropped, waits before the link to that receiver is closed.
const CLOSE_AFTER_US: u32 = 1_000_000;
/// Bytes of a batch: what is written at once, and what a pose may have to wait for.
const BATCH: u32 = 16 << 10;
/// Batches in the queue of each of the eight priorities.
const BATCHES: u32 = 4;
/// Bytes that the operating system may hold back for a receiver: by default it grows to megabytes, which on a slow link are seconds
/// that a pose waits behind a volume.
const SEND_BUFFER: u32 = 64 << 10;

/// Bytes that the operating system may hold of what a receiver said: it says little, and what is held is still read when it is cut off.
const RECEIVE_BUFFER: u32 = 64 << 10;

/// The most bytes that a sender's queues hold of one receiver, without the operating system's buffer.
pub const QUEUES_OF_ONE_RECEIVER: u32 = BATCH * BATCHES * 8;

/// Why there is no configuration.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// TLS without keys.
    #[error("{endpoint} needs keys: `remote-proc keys --out DIR --host NAME` makes them")]
    NoKeys {
        /// The endpoint.
        endpoint: String,
    },
    /// Keys of the other side.
    #[error("the keys are those of the {found}, and this is the {expected}")]
    OtherSide {
        /// Whose keys they are.
        found: Side,
        /// Who needs some.
        expected: Side,
    },
    /// An endpoint of the other end.
    #[error("{endpoint} was read as the endpoint of the other end")]
    OtherEnd {
        /// The endpoint.
        endpoint: String,
    },
    /// zenoh does not take a setting: it is of another version than this was written for.
    #[error("zenoh refuses the setting {key}: {reason}")]
    Setting {
        /// Its key.
        key: &'static str,
        /// What zenoh says.
        reason: String,
    },
}

/// The sender's: it listens at `at`, and what it puts and replies goes out; of what comes in, subscriptions and queries alone are taken.
///
/// # Errors
/// Each variant of [`ConfigError`].
pub fn sender(at: &Endpoint, keys: Option<&Keys>) -> Result<Config, ConfigError> {
    build(Side::Sender, at, keys)
}

/// A receiver's: it connects to `to`, may subscribe and query, and takes what the sender puts and replies.
///
/// # Errors
/// Each variant of [`ConfigError`].
pub fn receiver(to: &Endpoint, keys: Option<&Keys>) -> Result<Config, ConfigError> {
    build(Side::Receiver, to, keys)
}

fn build(side: Side, endpoint: &Endpoint, keys: Option<&Keys>) -> Result<Config, ConfigError> {
    let end = match side {
        Side::Sender => End::Listen,
        Side::Receiver => End::Connect,
    };
    if endpoint.end() != end {
        return Err(ConfigError::OtherEnd {
            endpoint: endpoint.to_string(),
        });
    }
    let mut settings = common();
    settings.extend(match side {
        Side::Sender => listening(endpoint),
        Side::Receiver => connecting(endpoint),
    });
    match (endpoint.transport(), keys) {
        (Transport::Tcp, _) => settings.extend([
            ("transport/link/protocols", json!(["tcp"])),
            ("transport/link/tcp/so_sndbuf", json!(SEND_BUFFER)),
        ]),
        (Transport::Tls, None) => {
            return Err(ConfigError::NoKeys {
                endpoint: endpoint.to_string(),
            });
        }
        (Transport::Tls, Some(keys)) if keys.side() != side => {
            return Err(ConfigError::OtherSide {
                found: keys.side(),
                expected: side,
            });
        }
        (Transport::Tls, Some(keys)) => settings.extend(encrypted(side, keys)),
    }
    if side == Side::Sender {
        let buffer = match endpoint.transport() {
            Transport::Tcp => "transport/link/tcp/so_rcvbuf",
            Transport::Tls => "transport/link/tls/so_rcvbuf",
        };
        settings.push((buffer, json!(RECEIVE_BUFFER)));
    }
    settings.extend(access::of(side, endpoint.transport()));
    let mut config = Config::default();
    for (key, value) in settings {
        let refused = config.insert_json5(key, &value.to_string());
        refused.map_err(|error| ConfigError::Setting {
            key,
            reason: error.to_string(),
        })?;
    }
    Ok(config)
}

/// A key of zenoh's configuration and its value. What zenoh does by default and matters here is written as well.
type Setting = (&'static str, Value);

fn common() -> Vec<Setting> {
    let batches = json!({
        "control": BATCHES, "real_time": BATCHES, "interactive_high": BATCHES, "interactive_low": BATCHES,
        "data_high": BATCHES, "data": BATCHES, "data_low": BATCHES, "background": BATCHES,
    });
    vec![
        ("scouting/multicast/enabled", json!(false)),
        ("scouting/gossip/enabled", json!(false)),
        ("adminspace/enabled", json!(false)),
        ("plugins_loading/enabled", json!(false)),
        ("timestamping/enabled", json!(false)),
        ("transport/shared_memory/enabled", json!(false)),
        ("transport/unicast/max_links", json!(1)),
        ("transport/unicast/qos/enabled", json!(true)),
        ("transport/unicast/lowlatency", json!(false)),
        ("transport/link/tx/lease", json!(LEASE_MS)),
        ("transport/link/tx/keep_alive", json!(4)),
        ("transport/link/tx/batch_size", json!(BATCH)),
        ("transport/link/tx/queue/size", batches),
        (
            "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
            json!(DROP_AFTER_US),
        ),
        (
            "transport/link/tx/queue/congestion_control/drop/max_wait_before_drop_fragments",
            json!(DROP_PARTS_AFTER_US),
        ),
        (
            "transport/link/tx/queue/congestion_control/block/wait_before_close",
            json!(CLOSE_AFTER_US),
        ),
    ]
}

fn listening(at: &Endpoint) -> Vec<Setting> {
    // Who connects and says nothing is let go after this.
    let handshake = match at.transport() {
        Transport::Tcp => String::new(),
        Transport::Tls => "#tls_handshake_timeout_ms=2000".to_owned(),
    };
    vec![
        ("mode", json!("peer")),
        ("connect/endpoints", json!([])),
        ("listen/endpoints", json!([format!("{at}{handshake}")])),
        ("listen/timeout_ms", json!(0)),
        ("listen/exit_on_failure", json!(true)),
        ("transport/unicast/accept_timeout", json!(2000)),
        ("transport/unicast/max_sessions", json!(MOST_RECEIVERS)),
        ("transport/link/rx/max_message_size", json!(LONGEST_FROM_RECEIVER)),
    ]
}

fn connecting(to: &Endpoint) -> Vec<Setting> {
    vec![
        ("mode", json!("client")),
        ("listen/endpoints", json!([])),
        ("connect/endpoints", json!([to.to_string()])),
        // Opening fails at once, so that the reason can be told; a link that stood and was cut is dialled again for ever.
        ("connect/timeout_ms", json!(0)),
        ("connect/exit_on_failure", json!(true)),
        (
            "connect/retry",
            json!({ "period_init_ms": 100, "period_max_ms": 100, "period_increase_factor": 1.0 }),
        ),
        // Of one try, connection and handshakes together: a packet that is lost while the cable is out is sent again by the operating
        // system after 1 s, 2 s, 4 s, and a new try is sooner.
        ("transport/unicast/open_timeout", json!(800)),
        ("transport/unicast/max_sessions", json!(1)),
        ("transport/link/rx/max_message_size", json!(LONGEST_MESSAGE)),
    ]
}

/// The keys go in as they were read and checked: the files may have been exchanged since.
fn encrypted(side: Side, keys: &Keys) -> Vec<Setting> {
    let encoded = |pem: &str| json!(STANDARD.encode(pem));
    let (certificate, key) = match side {
        Side::Sender => (
            "transport/link/tls/listen_certificate_base64",
            "transport/link/tls/listen_private_key_base64",
        ),
        Side::Receiver => (
            "transport/link/tls/connect_certificate_base64",
            "transport/link/tls/connect_private_key_base64",
        ),
    };
    vec![
        ("transport/link/protocols", json!(["tls"])),
        ("transport/link/tls/so_sndbuf", json!(SEND_BUFFER)),
        (
            "transport/link/tls/root_ca_certificate_base64",
            encoded(keys.authority()),
        ),
        (certificate, encoded(keys.certificate())),
        (key, encoded(keys.key())),
        ("transport/link/tls/enable_mtls", json!(true)),
        ("transport/link/tls/verify_name_on_connect", json!(true)),
        // A date cuts off no operation: an expired certificate is refused when the next link is opened.
        ("transport/link/tls/close_link_on_expiration", json!(false)),
    ]
}
