//! Nothing that others send reaches the sender, or another receiver through it.

use remote_proc::link::endpoint::Transport;
use remote_proc::link::keys::Side;
use remote_proc::protocol::{ASKED, keys};
use zenoh::{Config, Wait};

use crate::support::authority::{Authority, Says};
use crate::support::forger::{ELSEWHERE, Shows, config, forge, lie_in_wait};
use crate::support::room::Room;

const MODES: [&str; 3] = ["client", "peer", "router"];

fn authority_of(room: &Room) -> Option<String> {
    Some(std::fs::read_to_string(room.keys.path().join("authority.pem")).unwrap())
}

/// The keys of a receiver of this room, as its owner has them.
fn receivers(room: &Room) -> Shows {
    let read = |path: std::path::PathBuf| std::fs::read_to_string(path).unwrap();
    let folder = room.keys.path();
    let certificate = (
        read(Side::Receiver.certificate_file(folder)),
        read(Side::Receiver.key_file(folder)),
    );
    Shows {
        authority: authority_of(room),
        certificate: Some(certificate),
    }
}

fn nothing() -> Shows {
    Shows {
        authority: None,
        certificate: None,
    }
}

/// Opens a forger's session in a room with one receiver, and lets him try everything. Returns what the sender heard, what the receiver
/// heard, what it was answered, and how often the forger was asked.
fn attacked(room: &Room, config: Config) -> (Vec<String>, Vec<String>, Vec<String>, usize) {
    let screen = room.receiver();
    let forger = zenoh::open(config).wait().unwrap();
    let asked = lie_in_wait(&forger);
    // A question that comes before the sender's answers are known to the forger ends without a word.
    let mut tries = (0..200).map(|_| {
        std::thread::sleep(std::time::Duration::from_millis(10));
        forge(&forger)
    });
    assert!(tries.any(|answers| answers.contains(&"the sender's".to_owned())));
    // Behind whatever would have been passed on.
    room.session.put("trocar/1/event", "last").wait().unwrap();
    let heard = screen.heard_until("trocar/1/event last");
    let mut answers = Vec::new();
    for key in keys().chain(ELSEWHERE) {
        answers.extend(screen.ask(key));
    }
    (room.heard(), heard, answers, asked.count())
}

#[test]
fn a_forger_with_a_receivers_certificate_or_on_loopback_reaches_nobody() {
    for transport in [Transport::Tls, Transport::Tcp] {
        for mode in MODES {
            let room = Room::open(transport);
            let shows = match transport {
                Transport::Tls => receivers(&room),
                Transport::Tcp => nothing(),
            };
            let config = config(mode, &room.endpoint, &shows, room.keys.path());
            let (sender, receiver, answers, asked) = attacked(&room, config);
            assert_eq!(sender, [""; 0], "{transport:?} {mode}");
            assert_eq!(receiver, ["trocar/1/event last"], "{transport:?} {mode}");
            assert_eq!(answers, ["the sender's"; ASKED.len()], "{transport:?} {mode}");
            assert_eq!(asked, 0, "{transport:?} {mode}");
        }
    }
}

/// What the test above would see if the rules were not there.
#[test]
fn without_access_control_a_receiver_does_inject_into_another_through_the_sender() {
    let room = Room::without_control(Transport::Tls);
    let config = config("client", &room.endpoint, &receivers(&room), room.keys.path());
    let (sender, receiver, answers, asked) = attacked(&room, config);
    for heard in [sender, receiver] {
        for key in keys().chain(["trocar/1/no/such/key"]) {
            for what in ["forged", "-"] {
                assert!(heard.contains(&format!("{key} {what}")), "{key} {what}: {heard:?}");
            }
        }
    }
    assert!(answers.contains(&"forged".to_owned()) && asked > 0);
}

#[test]
fn whoever_shows_no_certificate_or_one_of_another_authority_is_not_let_in() {
    let room = Room::open(Transport::Tls);
    let screen = room.receiver();
    let other = Authority::new("another");
    let strangers = [
        nothing(),
        Shows {
            authority: authority_of(&room),
            certificate: None,
        },
        Shows {
            authority: authority_of(&room),
            certificate: Some(other.signs(&Says::of(Side::Receiver))),
        },
        Shows {
            authority: Some(other.pem()),
            certificate: Some(other.signs(&Says::of(Side::Receiver))),
        },
        // The sender's own certificate is for listening.
        Shows {
            certificate: Some(senders(&room)),
            authority: authority_of(&room),
        },
    ];
    for shows in strangers {
        for mode in MODES {
            let config = config(mode, &room.endpoint, &shows, room.keys.path());
            let refused = zenoh::open(config).wait();
            assert!(refused.is_err(), "{mode}");
        }
    }
    let plain = room.endpoint.replace("tls/localhost", "tcp/127.0.0.1");
    assert!(
        zenoh::open(config("client", &plain, &nothing(), room.keys.path()))
            .wait()
            .is_err()
    );
    room.session.put("trocar/1/event", "last").wait().unwrap();
    assert_eq!(screen.heard_until("trocar/1/event last"), ["trocar/1/event last"]);
    assert_eq!(room.heard(), [""; 0]);
}

fn senders(room: &Room) -> (String, String) {
    let read = |path: std::path::PathBuf| std::fs::read_to_string(path).unwrap();
    let folder = room.keys.path();
    (
        read(Side::Sender.certificate_file(folder)),
        read(Side::Sender.key_file(folder)),
    )
}
