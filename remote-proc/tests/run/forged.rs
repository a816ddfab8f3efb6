//! Forgers against the programs themselves: what they publish and answer reaches neither run's bus.

use std::path::Path;
use std::time::Duration;

use bus::message::Wire;
use remote_proc::link::keys::Side;
use remote_proc::protocol::{Channel, Envelope};
use zenoh::{Session, Wait};

use crate::authority::{Authority, Says};
use crate::forger::{Shows, config, forge_with, lie_in_wait};
use crate::rig::{Room, Second, alone, free_endpoint, keys, remote_proc, until, world};

mod floods;
mod messages;
mod quiet;
mod versions;

use messages::{ears, forged};

const MODES: [&str; 3] = ["client", "peer", "router"];

/// In the envelope of a message that the sender is about to send, as whoever may listen can make it.
fn enveloped(envelope: Envelope, key: &str) -> Vec<u8> {
    let channel = Channel::ALL.into_iter().find(|channel| channel.key() == key);
    let count = envelope.count + 3;
    let body = channel.map_or_else(|| b"forged".to_vec(), forged);
    Envelope { count, ..envelope }.around(&body)
}

/// The envelope of a message of the sender's, as a forger overhears it.
fn overheard(forger: &Session, room: &mut Room, sent: &mut Vec<Vec<u8>>) -> Envelope {
    let poses = forger.declare_subscriber(Channel::Pose.key()).wait().unwrap();
    until("a pose at the forger", || {
        sent.push(room.pose().wire_bytes().to_vec());
        let sample = poses.try_recv().unwrap()?;
        let bytes = sample.payload().to_bytes();
        Some(Envelope::open(&bytes, "", Channel::Pose.allowed()).unwrap().0)
    })
}

fn program(verb: &str, keys: Option<&str>) -> std::process::Command {
    let mut command = remote_proc();
    command.arg(verb);
    if let Some(keys) = keys {
        command.args(["--keys", keys]);
    }
    command
}

/// The receiver's own keys, as the owner of a second machine has them.
fn receivers(keys: Option<&str>) -> Shows {
    let read = |path: std::path::PathBuf| std::fs::read_to_string(path).unwrap();
    let keys = keys.map(Path::new);
    Shows {
        authority: keys.map(|keys| read(keys.join("authority.pem"))),
        certificate: keys.map(|keys| {
            let side = Side::Receiver;
            (read(side.certificate_file(keys)), read(side.key_file(keys)))
        }),
    }
}

/// Waits for a pose of `room` on the second bus; what the room sent meanwhile is added to `sent`.
fn shown(room: &mut Room, second: &Second, sent: &mut Vec<Vec<u8>>) {
    while second.poses.next().unwrap().is_some() {}
    for _ in 0..20 {
        until("a pose on the second bus", || {
            room.serve_late_joiners();
            sent.push(room.pose().wire_bytes().to_vec());
            std::thread::sleep(Duration::from_millis(10));
            second.poses.next().unwrap()
        });
    }
}

/// A forger of this mode against a sender and a receiver, from before the receiver comes.
fn attacked(mode: &str, is_tls: bool) {
    let world = world();
    let keys = is_tls.then(|| keys(world.path(), "localhost"));
    let keys = keys.as_deref();
    let endpoint = match is_tls {
        true => free_endpoint().replace("tcp/127.0.0.1", "tls/localhost"),
        false => free_endpoint(),
    };
    let mut room = Room::open(world.path(), Duration::from_secs(1), [40, 30, 20], |_| {});
    let sender = room.send_by(program("send", keys), world.path(), &endpoint);
    until("the sender", || sender.said().contains("is shown to").then_some(()));
    let forger = zenoh::open(config(mode, &endpoint, &receivers(keys), world.path()))
        .wait()
        .unwrap();
    let asked = lie_in_wait(&forger);
    let mut sent = Vec::new();

    let second = Second::open(world.path(), "second", &endpoint);
    let [of_room, of_second] = [&room.bus, &second.bus].map(|bus| Channel::ALL.map(|channel| ears(bus, channel)));
    let mut receiver = second.receive_by(program("receive", keys), world.path(), &endpoint, &room.id());
    shown(&mut room, &second, &mut sent);
    let envelope = overheard(&forger, &mut room, &mut sent);
    let answers = forge_with(&forger, |key| enveloped(envelope, key));
    assert!(!answers.is_empty(), "the sender does not answer the forger: {mode}");
    shown(&mut room, &second, &mut sent);

    let mut foreign = Vec::new();
    for (bus, ears) in [("the sender's bus", &of_room), ("the receiver's bus", &of_second)] {
        for (channel, drains) in Channel::ALL.into_iter().zip(ears) {
            let came: Vec<_> = drains.iter().flat_map(|drain| drain()).collect();
            let is_foreign = came.iter().any(|bytes| !sent.contains(bytes));
            foreign.extend(is_foreign.then(|| format!("{channel:?} on {bus}")));
            // Poses do come where it is listened.
            assert!(channel != Channel::Pose || !came.is_empty(), "{bus}");
        }
    }
    // A state of other organs would make it ask for them.
    second.beats.newest().unwrap();
    let beat = until("a sign of life", || second.beats.newest().unwrap());
    let note = beat.note_text();
    foreign.extend(
        note.contains("organs")
            .then(|| format!("Tissue at the receiver: {note}")),
    );
    assert_eq!(foreign, [""; 0], "{mode}");
    assert_eq!(asked.count(), 0, "{mode}");
    assert_eq!(second.volumes.poll().unwrap().unwrap().hash(), room.hash);
    assert_eq!(beat.counters.refused, 0, "{mode}: {}", receiver.said());
    assert!(receiver.child.try_wait().unwrap().is_none());
}

#[test]
fn a_forger_with_a_receivers_certificate_or_on_loopback_reaches_neither_bus() {
    let _alone = alone();
    for is_tls in [true, false] {
        for mode in MODES {
            attacked(mode, is_tls);
        }
    }
}

/// Listens where the sender should, by a certificate of the room's authority with this name, and publishes and answers on every key.
fn impostor(endpoint: &str, keys: &str, name: &str) -> Session {
    let says = Says {
        name: name.to_owned(),
        ..Says::of(Side::Sender)
    };
    let (certificate, key) = Authority::of_folder(Path::new(keys)).signs(&says);
    let mut config = zenoh::Config::default();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    config
        .insert_json5("listen/endpoints", &format!("[{endpoint:?}]"))
        .unwrap();
    for (setting, pem) in [("listen_certificate", certificate), ("listen_private_key", key)] {
        let path = Path::new(keys).join(setting);
        crate::authority::write(&path, &pem);
        let setting = format!("transport/link/tls/{setting}");
        config.insert_json5(&setting, &format!("{path:?}")).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

#[test]
fn who_stands_where_the_sender_should_and_is_none_gives_a_receiver_nothing() {
    let _alone = alone();
    for (name, is_sender) in [
        ("trocar-receiver", false),
        ("trocar-other", false),
        ("", false),
        ("trocar-sender", true),
    ] {
        let world = world();
        let keys = keys(world.path(), "localhost");
        let endpoint = free_endpoint().replace("tcp/127.0.0.1", "tls/localhost");
        let impostor = impostor(&endpoint, &keys, name);
        let asked = lie_in_wait(&impostor);
        let second = Second::open(world.path(), "second", &endpoint);
        let ears = Channel::ALL.map(|channel| ears(&second.bus, channel));
        let receiver = second.receive_by(program("receive", Some(&keys)), world.path(), &endpoint, "ff");
        let envelope = Envelope {
            run: 0xff,
            sender: 1,
            count: 0,
        };
        let words = if is_sender {
            "connected to"
        } else {
            "expected `trocar-sender`"
        };
        until(words, || {
            for key in remote_proc::protocol::keys() {
                impostor.put(key, enveloped(envelope, key)).wait().unwrap();
            }
            std::thread::sleep(Duration::from_millis(20));
            // Only whom it takes for the sender it asks anything.
            let is_told = receiver.said().contains(words) && second.note().is_some();
            (is_told && (asked.count() > 0) == is_sender).then_some(())
        });
        let came: usize = ears.iter().flatten().map(|drain| drain().len()).sum();
        // Neither from that one, whose answers are none.
        assert_eq!(came, 0, "{name:?}");
        assert!(second.volumes.poll().unwrap().is_none() && second.laws.newest().unwrap().is_none());
    }
}
