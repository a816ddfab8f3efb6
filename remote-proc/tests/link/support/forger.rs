//! Sessions of somebody who wants to be heard.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use remote_proc::protocol::keys;
use zenoh::qos::Priority;
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::sample::Locality;
use zenoh::{Config, Session, Wait};

/// Longer than anything here takes on a busy machine; nothing is measured by it.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// A key that nobody thought of, and those that match all.
pub(crate) const ELSEWHERE: [&str; 4] = ["trocar/1/no/such/key", "trocar/1/**", "trocar/**", "**"];

/// What a forger shows: the files that he trusts and shows, each as PEM.
pub(crate) struct Shows {
    pub(crate) authority: Option<String>,
    pub(crate) certificate: Option<(String, String)>,
}

/// A forger's session: no rules, and TLS with what he has.
pub(crate) fn config(mode: &str, endpoint: &str, shows: &Shows, folder: &std::path::Path) -> Config {
    let mut config = Config::default();
    let mut set = |key: &str, value: String| config.insert_json5(key, &value).unwrap();
    let quoted = |text: &str| format!("{text:?}");
    set("mode", quoted(mode));
    set("scouting/multicast/enabled", "false".to_owned());
    set("connect/endpoints", format!("[{endpoint:?}]"));
    set("connect/timeout_ms", "0".to_owned());
    set("connect/exit_on_failure", "true".to_owned());
    set("listen/endpoints", "[]".to_owned());
    set("transport/link/tls/verify_name_on_connect", "false".to_owned());
    let mut file = |key: &str, name: &str, pem: &str| {
        let path = folder.join(format!("forger.{name}"));
        super::authority::write(&path, pem);
        set(key, quoted(path.to_str().unwrap()));
    };
    if let Some(pem) = &shows.authority {
        file("transport/link/tls/root_ca_certificate", "authority", pem);
    }
    if let Some((certificate, key)) = &shows.certificate {
        file("transport/link/tls/connect_certificate", "certificate", certificate);
        file("transport/link/tls/connect_private_key", "key", key);
        set("transport/link/tls/enable_mtls", "true".to_owned());
    }
    config
}

/// What forged queryables were asked, in all.
#[derive(Default, Clone)]
pub(crate) struct Asked(Arc<AtomicUsize>);

impl Asked {
    pub(crate) fn count(&self) -> usize {
        self.0.load(Ordering::SeqCst)
    }
}

/// Declares queryables that lie, on every key and for all of them.
pub(crate) fn lie_in_wait(session: &Session) -> Asked {
    let asked = Asked::default();
    for key in keys().chain(ELSEWHERE) {
        let asked = asked.clone();
        let lie = move |query: zenoh::query::Query| {
            asked.0.fetch_add(1, Ordering::SeqCst);
            let key = query.key_expr().clone();
            let _: Result<(), _> = query.reply(key, "forged").wait();
        };
        session
            .declare_queryable(key)
            .complete(true)
            .callback(lie)
            .allowed_origin(Locality::Remote)
            .background()
            .wait()
            .unwrap();
    }
    asked
}

/// Puts and deletes on every key, by publishers and without, waits until the sender has seen all of it, and returns what the sender
/// answers to a query.
pub(crate) fn forge(session: &Session) -> Vec<String> {
    forge_with(session, |_| b"forged".to_vec())
}

/// The same, with what `body` makes for each key.
pub(crate) fn forge_with(session: &Session, body: impl Fn(&str) -> Vec<u8>) -> Vec<String> {
    for key in keys().chain(ELSEWHERE) {
        session.put(key, body(key)).priority(Priority::RealTime).wait().unwrap();
        session.put(key, body(key)).wait().unwrap();
        session.delete(key).wait().unwrap();
        if key.contains('*') {
            continue;
        }
        let publisher = session.declare_publisher(key).wait().unwrap();
        publisher.put(body(key)).wait().unwrap();
        drop(session.liveliness().declare_token(key).wait().unwrap());
    }
    // Behind them on the same link, so that what it brings back comes after they were looked at.
    ask(session, "trocar/1/facts")
}

/// Every reply to a query, of whoever answers.
pub(crate) fn ask(session: &Session, key: &str) -> Vec<String> {
    let query = session
        .get(key)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None);
    let replies = query.timeout(PATIENCE).wait().unwrap();
    let mut texts = Vec::new();
    while let Ok(reply) = replies.recv() {
        let text = |payload: &zenoh::bytes::ZBytes| String::from_utf8_lossy(&payload.to_bytes()).into_owned();
        texts.push(match reply.result() {
            Ok(sample) => text(sample.payload()),
            Err(error) => text(error.payload()),
        });
    }
    texts
}
