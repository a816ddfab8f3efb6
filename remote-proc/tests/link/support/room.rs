//! A sender's session that publishes and answers, and receivers of it.

use std::sync::mpsc::{Receiver, Sender, channel};

use remote_proc::link::config;
use remote_proc::link::endpoint::{Endpoint, Transport};
use remote_proc::link::keys::{self, Keys, Side};
use remote_proc::protocol::{ASKED, keys as all_keys};
use tempfile::TempDir;
use zenoh::sample::{Locality, SampleKind};
use zenoh::{Config, Session, Wait};

use super::forger::{PATIENCE, ask};

/// The sender's room.
pub(crate) struct Room {
    pub(crate) keys: TempDir,
    pub(crate) session: Session,
    pub(crate) endpoint: String,
    /// Whether the control holds: without it forged messages must arrive, or the test could not fail.
    is_controlled: bool,
    heard: Receiver<String>,
}

impl Room {
    pub(crate) fn open(transport: Transport) -> Self {
        Self::with(transport, true)
    }

    /// One that allows everything, to show that a forger's messages would arrive.
    pub(crate) fn without_control(transport: Transport) -> Self {
        Self::with(transport, false)
    }

    fn with(transport: Transport, is_controlled: bool) -> Self {
        let keys = tempfile::Builder::new().permissions(private()).tempdir().unwrap();
        keys::make(keys.path(), &["localhost".to_owned()], 10).unwrap();
        let at = match transport {
            Transport::Tcp => "tcp/127.0.0.1:0",
            Transport::Tls => "tls/localhost:0",
        };
        let own = Keys::load(keys.path(), Side::Sender).unwrap();
        let mut config = config::sender(&Endpoint::listen(at).unwrap(), Some(&own)).unwrap();
        if !is_controlled {
            allow_everything(&mut config);
        }
        let session = zenoh::open(config).wait().unwrap();
        let locators = session.info().locators().wait();
        let port = locators[0].to_string().rsplit_once(':').unwrap().1.to_owned();
        let endpoint = format!("{}:{port}", at.rsplit_once(':').unwrap().0);
        let heard = listen(&session);
        answer(&session);
        Self {
            keys,
            session,
            endpoint,
            is_controlled,
            heard,
        }
    }

    pub(crate) fn receiver_config(&self) -> Config {
        let keys = Keys::load(self.keys.path(), Side::Receiver).unwrap();
        let mut config = config::receiver(&Endpoint::connect(&self.endpoint).unwrap(), Some(&keys)).unwrap();
        if !self.is_controlled {
            allow_everything(&mut config);
        }
        config
    }

    /// A receiver, whose subscription has arrived at the sender.
    pub(crate) fn receiver(&self) -> Screen {
        let screen = Screen::open(self.receiver_config()).unwrap();
        // Its subscription went out before this query on the same link.
        assert_eq!(screen.ask("trocar/1/clock"), ["the sender's"]);
        screen
    }

    /// Puts a message on every key.
    pub(crate) fn put_all(&self, text: &str) {
        for key in all_keys() {
            self.session.put(key, text).wait().unwrap();
        }
    }

    /// What the sender was told from outside up to now.
    pub(crate) fn heard(&self) -> Vec<String> {
        self.heard.try_iter().collect()
    }
}

/// A receiver's session, subscribed to everything that it may be.
pub(crate) struct Screen {
    pub(crate) session: Session,
    heard: Receiver<String>,
}

impl Screen {
    /// Connects, and asks for everything; whether it is let in and given something is another matter.
    pub(crate) fn open(config: Config) -> zenoh::Result<Self> {
        let session = zenoh::open(config).wait()?;
        let heard = listen(&session);
        Ok(Self { session, heard })
    }

    /// All that arrived up to now.
    pub(crate) fn heard(&self) -> Vec<String> {
        self.heard.try_iter().collect()
    }

    /// All that arrived up to this message.
    pub(crate) fn heard_until(&self, last: &str) -> Vec<String> {
        let mut all = Vec::new();
        while all.last().is_none_or(|newest| newest != last) {
            all.push(self.heard.recv_timeout(PATIENCE).unwrap());
        }
        all
    }

    /// Every reply to a query, of whoever answers.
    pub(crate) fn ask(&self, key: &str) -> Vec<String> {
        ask(&self.session, key)
    }
}

fn private() -> std::fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o700)
}

/// Notes whatever arrives from other sessions: `KEY TEXT`, or `KEY -` where it was deleted.
fn listen(session: &Session) -> Receiver<String> {
    let (tell, heard) = channel();
    let note = move |sample: zenoh::sample::Sample| {
        let text = match sample.kind() {
            SampleKind::Put => sample.payload().try_to_string().unwrap().into_owned(),
            SampleKind::Delete => "-".to_owned(),
        };
        let _: Result<(), _> = Sender::send(&tell, format!("{} {text}", sample.key_expr()));
    };
    // Key by key, as no wildcard may be followed.
    for key in all_keys() {
        follow(session, key, note.clone());
    }
    // What is no key of the link is noted too, by what may come where the rules do not hold.
    follow(session, "**", move |sample| {
        if all_keys().all(|key| key != sample.key_expr().as_str()) {
            note(sample);
        }
    });
    heard
}

fn follow(session: &Session, key: &str, note: impl Fn(zenoh::sample::Sample) + Send + Sync + 'static) {
    let subscriber = session.declare_subscriber(key).callback(note);
    subscriber.allowed_origin(Locality::Remote).background().wait().unwrap();
}

/// Answers the queries that a sender answers.
fn answer(session: &Session) {
    for key in ASKED {
        let say = |query: zenoh::query::Query| {
            let key = query.key_expr().clone();
            let _: Result<(), _> = query.reply(key, "the sender's").wait();
        };
        session
            .declare_queryable(key)
            .callback(say)
            .background()
            .wait()
            .unwrap();
    }
}

fn allow_everything(config: &mut Config) {
    let all = r#"{ enabled: false, default_permission: "allow", rules: [], subjects: [], policies: [] }"#;
    config.insert_json5("access_control", all).unwrap();
    config.insert_json5("low_pass_filter", "[]").unwrap();
}
