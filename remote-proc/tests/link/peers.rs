//! Somebody who stands where the sender should be, and configurations that are not built.

use remote_proc::link::config::{self, ConfigError};
use remote_proc::link::endpoint::{Endpoint, Transport};
use remote_proc::link::keys::{Keys, Side};
use remote_proc::protocol::{Channel, keys};
use serde_json::json;
use tempfile::TempDir;
use zenoh::{Config, Wait};

use crate::support::authority::{Authority, Says, write};
use crate::support::forger::ask;
use crate::support::room::Room;

/// A session without any rules that listens with these keys.
fn impostor(folder: &TempDir, authority: &Authority, says: &Says) -> (zenoh::Session, String) {
    let (certificate, key) = authority.signs(says);
    let mut config = Config::default();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    config
        .insert_json5("listen/endpoints", r#"["tls/localhost:0"]"#)
        .unwrap();
    for (name, pem) in [("listen_certificate", certificate), ("listen_private_key", key)] {
        let path = folder.path().join(name);
        write(&path, &pem);
        config
            .insert_json5(&format!("transport/link/tls/{name}"), &format!("{path:?}"))
            .unwrap();
    }
    let session = zenoh::open(config).wait().unwrap();
    let locator = session.info().locators().wait()[0].to_string();
    (session, locator)
}

/// A receiver of `ours` that is sent to the impostor.
fn sent_to(folder: &TempDir, ours: &Authority, locator: &str) -> zenoh::Result<zenoh::Session> {
    ours.folder(folder.path(), Side::Receiver, &Says::of(Side::Receiver));
    let keys = Keys::load(folder.path(), Side::Receiver).unwrap();
    let mut config = config::receiver(&Endpoint::connect(locator).unwrap(), Some(&keys)).unwrap();
    tell_everybody(&mut config);
    zenoh::open(config).wait()
}

/// Lets what the receiver asks for go out to anybody, so that an impostor knows what to send: what comes in is looked at here.
fn tell_everybody(config: &mut Config) {
    let mut access: serde_json::Value = serde_json::from_str(&config.get_json("access_control").unwrap()).unwrap();
    let mut push = |list: &str, value| access[list].as_array_mut().unwrap().push(value);
    let messages = json!(["declare_subscriber", "query"]);
    push(
        "rules",
        json!({ "id": "all", "flows": ["egress"], "messages": messages, "permission": "allow", "key_exprs": ["**"] }),
    );
    push("subjects", json!({ "id": "anybody" }));
    push(
        "policies",
        json!({ "id": "told", "rules": ["all"], "subjects": ["anybody"] }),
    );
    config.insert_json5("access_control", &access.to_string()).unwrap();
}

#[test]
fn who_listens_with_a_receivers_certificate_or_of_another_authority_gets_no_receiver() {
    let folder = TempDir::new().unwrap();
    let ours = Authority::new("ours");
    let mut says = Says::of(Side::Sender);
    says.purposes = Says::of(Side::Receiver).purposes;
    let mut of_another_host = Says::of(Side::Sender);
    of_another_host.hosts = vec!["nav-1".to_owned()];
    for (authority, says) in [
        (&ours, &says),
        (&ours, &of_another_host),
        (&Authority::new("ours"), &Says::of(Side::Sender)),
    ] {
        let (_session, locator) = impostor(&folder, authority, says);
        assert!(sent_to(&folder, &ours, &locator).is_err());
    }
}

/// A certificate that the receiver trusts and that is no sender's, as of a public authority for the same host, which zenoh's client
/// trusts too.
#[test]
fn from_a_trusted_peer_that_is_no_sender_a_receiver_takes_nothing() {
    for (name, is_heard) in [("trocar-sender", true), ("localhost", false)] {
        let folder = TempDir::new().unwrap();
        let ours = Authority::new("ours");
        let says = Says {
            name: name.to_owned(),
            ..Says::of(Side::Sender)
        };
        let (impostor, locator) = impostor(&folder, &ours, &says);
        let lie = |query: zenoh::query::Query| {
            let key = query.key_expr().clone();
            let _: Result<(), _> = query.reply(key, "forged").wait();
        };
        impostor
            .declare_queryable("trocar/1/**")
            .complete(true)
            .callback(lie)
            .background()
            .wait()
            .unwrap();
        let receiver = sent_to(&folder, &ours, &locator).unwrap();
        let followed = Channel::ALL.map(|of| receiver.declare_subscriber(of.key()).wait().unwrap());
        // The end of a query's replies comes behind the subscription, and behind all that was put before it.
        let before = ask(&receiver, "trocar/1/clock");
        for key in keys() {
            impostor.put(key, "forged").wait().unwrap();
        }
        let after = ask(&receiver, "trocar/1/clock");
        let wanted = (if is_heard { followed.len() } else { 0 }, usize::from(is_heard));
        let count = || followed.iter().map(|of| of.drain().count()).sum::<usize>();
        let mut heard = count();
        // On a busy machine what was put may come behind the replies all the same.
        for _ in 0..200 {
            if heard >= wanted.0 {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(50));
            heard += count();
        }
        assert_eq!((heard, before.len()), wanted, "{name}: {before:?} {after:?}");
    }
}

#[test]
fn a_configuration_needs_the_keys_and_the_endpoint_of_its_side() {
    let room = Room::open(Transport::Tls);
    let (listen, connect) = (
        Endpoint::listen(&room.endpoint).unwrap(),
        Endpoint::connect(&room.endpoint).unwrap(),
    );
    let sender = Keys::load(room.keys.path(), Side::Sender).unwrap();
    let receiver = Keys::load(room.keys.path(), Side::Receiver).unwrap();
    assert!(matches!(config::sender(&listen, None), Err(ConfigError::NoKeys { .. })));
    assert!(matches!(
        config::receiver(&connect, None),
        Err(ConfigError::NoKeys { .. })
    ));
    assert!(matches!(
        config::sender(&listen, Some(&receiver)),
        Err(ConfigError::OtherSide { .. })
    ));
    assert!(matches!(
        config::receiver(&connect, Some(&sender)),
        Err(ConfigError::OtherSide { .. })
    ));
    assert!(matches!(
        config::sender(&connect, Some(&sender)),
        Err(ConfigError::OtherEnd { .. })
    ));
    assert!(matches!(
        config::receiver(&listen, Some(&receiver)),
        Err(ConfigError::OtherEnd { .. })
    ));
    // What is printed of a configuration holds no private key.
    let config = config::sender(&listen, Some(&sender)).unwrap();
    for shown in [config.to_string(), format!("{config:?}")] {
        assert!(
            !shown.contains("PRIVATE") && !shown.contains("LS0tLS1CRUdJTi"),
            "{shown}"
        );
    }
}

#[test]
fn connections_that_say_nothing_keep_no_receiver_out() {
    let room = Room::open(Transport::Tls);
    let at = room.endpoint.strip_prefix("tls/").unwrap();
    let idle: Vec<_> = (0..200).map(|_| std::net::TcpStream::connect(at).unwrap()).collect();
    let screen = room.receiver();
    room.session.put("trocar/1/event", "last").wait().unwrap();
    assert_eq!(screen.heard_until("trocar/1/event last"), ["trocar/1/event last"]);
    drop(idle);
}
