//! Whom the sender serves among those that its own authority signed for: by the name in the certificate, and while it is in time.

use remote_proc::link::endpoint::Transport;
use remote_proc::link::keys::Side;
use remote_proc::protocol::ASKED;

use zenoh::Wait;

use crate::support::authority::{Authority, Says};
use crate::support::forger::{Shows, config};
use crate::support::room::{Room, Screen};

const MODES: [&str; 3] = ["client", "peer", "router"];

/// Connects with a certificate that says so, signed by the room's own authority.
fn signed(room: &Room, mode: &str, says: &Says) -> zenoh::Result<Screen> {
    let authority = Authority::of_folder(room.keys.path());
    let shows = Shows {
        authority: Some(authority.pem()),
        certificate: Some(authority.signs(says)),
    };
    Screen::open(config(mode, &room.endpoint, &shows, room.keys.path()))
}

fn named(name: &str) -> Says {
    Says {
        name: name.to_owned(),
        ..Says::of(Side::Receiver)
    }
}

/// All answers to questions on every key that the sender answers.
fn answers(screen: &Screen) -> Vec<String> {
    let keys = ASKED.into_iter().chain(["trocar/1/**"]);
    keys.flat_map(|key| screen.ask(key)).collect()
}

/// What somebody of this name is answered, and what it hears of a message that every receiver has.
fn given(room: &Room, mode: &str, name: &str) -> (Vec<String>, Vec<String>) {
    let screen = room.receiver();
    let somebody = signed(room, mode, &named(name)).unwrap();
    // A question that comes before the sender's answers are known ends without a word: right ones ask until they are answered.
    let mut asked = (0..if name == "trocar-receiver" { 200 } else { 5 }).map(|_| {
        std::thread::sleep(std::time::Duration::from_millis(10));
        answers(&somebody)
    });
    let answered = asked.find(|answers| !answers.is_empty()).unwrap_or_default();
    room.session.put("trocar/1/pose", name).wait().unwrap();
    screen.heard_until(&format!("trocar/1/pose {name}"));
    // The end of this question comes behind the message, on the same link and of the same priority.
    answers(&somebody);
    (answered, somebody.heard())
}

#[test]
fn a_certificate_of_the_rooms_authority_with_another_name_is_given_nothing() {
    let room = Room::open(Transport::Tls);
    for mode in MODES {
        for name in [
            "trocar-other",
            "",
            "trocar-sender",
            "trocar-receiver2",
            "TROCAR-RECEIVER",
            "*",
        ] {
            let (answered, heard) = given(&room, mode, name);
            assert_eq!((answered, heard), (vec![], vec![]), "{mode} {name:?}");
        }
        // The same way in with the right name.
        let (answered, heard) = given(&room, mode, "trocar-receiver");
        assert!(answered.contains(&"the sender's".to_owned()), "{mode}");
        assert_eq!(heard, ["trocar/1/pose trocar-receiver"], "{mode}");
    }
    assert_eq!(room.heard(), [""; 0]);
}

#[test]
fn a_receivers_certificate_that_is_over_or_not_begun_or_for_servers_is_not_let_in() {
    let room = Room::open(Transport::Tls);
    let good = Says::of(Side::Receiver);
    let valid = |days| Says {
        valid: days,
        ..good.clone()
    };
    let for_servers = Says {
        purposes: Says::of(Side::Sender).purposes,
        ..good.clone()
    };
    for mode in MODES {
        for (why, says) in [
            ("over", &valid((-9, -1))),
            ("not begun", &valid((1, 9))),
            ("for servers", &for_servers),
        ] {
            assert!(signed(&room, mode, says).is_err(), "{mode} {why}");
        }
        assert!(signed(&room, mode, &good).is_ok(), "{mode}");
    }
}
