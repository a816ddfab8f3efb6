//! What may cross the link: zenoh's access control on both ends. What no rule allows is denied.
//!
//! By TLS the rules hold for the peer whose certificate has the other side's common name, and nobody else may do anything. On the
//! receiver this is the authority's check as well: zenoh's TLS client trusts the public authorities of the web beside the one that it
//! is given, and none of these signs a certificate with the common name `trocar-sender`.
//!
//! Access control leaves out what carries no data (interests, the end of a query) and declarations of key numbers, at most 65 536 a link.

use serde_json::{Value, json};

use super::Setting;
use crate::link::endpoint::Transport;
use crate::link::keys::Side;
use crate::protocol::{ASKED, Channel};

/// Where all keys of a link lie.
pub const KEYS: &str = "trocar/1/**";
/// The longest payload and attachment of a query together, in bytes.
pub const LONGEST_QUERY: usize = 4096;

/// The settings of one side.
pub(super) fn of(side: Side, transport: Transport) -> Vec<Setting> {
    // A receiver asks and is told who can answer; it hears of the other receivers nothing.
    let (peer, asks, tells) = match side {
        Side::Sender => (Side::Receiver, "ingress", "egress"),
        Side::Receiver => (Side::Sender, "egress", "ingress"),
    };
    // Key by key: with a wildcard a receiver could subscribe to any number of keys that nobody publishes.
    let followed = Channel::ALL.map(Channel::key);
    let rules = [
        rule("follows", asks, &["declare_subscriber"], &followed),
        rule("asks", asks, &["query"], &ASKED),
        rule("tells", tells, &["put"], &followed),
        rule("answers", tells, &["reply", "declare_queryable"], &ASKED),
    ];
    let mut subject = json!({ "id": "peer" });
    match transport {
        Transport::Tls => {
            subject["link_protocols"] = json!(["tls"]);
            subject["cert_common_names"] = json!([peer.common_name()]);
        }
        Transport::Tcp => subject["link_protocols"] = json!(["tcp"]),
    }
    let access = json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [subject],
        "policies": [{ "id": "link", "rules": ["follows", "asks", "tells", "answers"], "subjects": ["peer"] }],
    });
    let mut settings = vec![("access_control", access)];
    if side == Side::Sender {
        let bound = json!([{
            "id": "queries", "flows": ["ingress"], "messages": ["query"], "key_exprs": [KEYS], "size_limit": LONGEST_QUERY,
        }]);
        settings.push(("low_pass_filter", bound));
    }
    settings
}

fn rule(id: &str, flow: &str, messages: &[&str], keys: &[&str]) -> Value {
    json!({ "id": id, "flows": [flow], "messages": messages, "permission": "allow", "key_exprs": keys })
}
