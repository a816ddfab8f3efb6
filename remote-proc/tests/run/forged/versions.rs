//! A sender of another version: it has the right keys, and its messages are of the right run.

use std::time::Duration;

use bus::clock::monotonic_ns;
use bus::message::Wire;
use remote_proc::protocol::{CLOCK, Channel, ClockAnswer, Envelope, FACTS, Facts, VERSION, hex, payloads};
use remote_proc::session::listen;
use zenoh::{Session, Wait};

use super::messages::{ears, forged};
use crate::rig::{Second, Voxels, alone, free_endpoint, until, world};

const RUN: u64 = 0xff;
const SENDER: u64 = 5;

fn answer(session: &Session, key: &str, with: impl Fn() -> Vec<u8> + Send + Sync + 'static) {
    let reply = move |query: zenoh::query::Query| {
        let _: Result<(), _> = query.reply(query.key_expr().clone(), with()).wait();
    };
    session
        .declare_queryable(key)
        .callback(reply)
        .background()
        .wait()
        .unwrap();
}

/// A sender that says so of itself; its clock is this machine's.
fn sender(endpoint: &str, version: u32, payloads: Vec<String>) -> Session {
    let session = listen(endpoint, None).unwrap();
    let facts = Facts {
        version,
        payloads,
        run: "room".to_owned(),
        run_id: format!("{RUN:x}"),
        scene: String::new(),
        volume: Some(hex(Voxels::made([8, 8, 8]).header.wire_bytes())),
    };
    let told = serde_json::to_vec(&facts).unwrap();
    answer(&session, FACTS, move || told.clone());
    answer(&session, CLOCK, || {
        let now = monotonic_ns();
        let told = ClockAnswer {
            heard_ns: now,
            answered_ns: now,
            run: RUN,
            sender: SENDER,
        };
        told.bytes()
    });
    session
}

#[test]
fn of_a_sender_of_another_version_a_receiver_shows_nothing_and_says_why() {
    let _alone = alone();
    let ours = payloads();
    let mut larger = ours.clone();
    larger[0] = "trocar/ToolPose/3 312".to_owned();
    let fewer = ours[1..].to_vec();
    let more = [ours.clone(), vec!["trocar/Other/1 8".to_owned()]].concat();
    for (version, payloads, is_ours) in [
        (VERSION + 1, ours.clone(), false),
        (VERSION, larger, false),
        (VERSION, fewer, false),
        (VERSION, more, false),
        (VERSION, ours.clone(), true),
    ] {
        let world = world();
        let endpoint = free_endpoint();
        let second = Second::open(world.path(), "second", &endpoint);
        let ears = Channel::ALL.map(|channel| ears(&second.bus, channel));
        let sender = sender(&endpoint, version, payloads);
        let receiver = second.receive(world.path(), &endpoint, &format!("{RUN:x}"));
        let (mut count, mut told, mut came) = (0, 0, 0);
        until("what comes of it", || {
            for channel in Channel::ALL {
                let envelope = Envelope {
                    run: RUN,
                    sender: SENDER,
                    count,
                };
                sender
                    .put(channel.key(), envelope.around(&forged(channel)))
                    .wait()
                    .unwrap();
            }
            count += 1;
            std::thread::sleep(Duration::from_millis(10));
            came += ears.iter().flatten().map(|drain| drain().len()).sum::<usize>();
            let said = receiver.said();
            told += usize::from(said.contains("both machines need the same version of Trocar"));
            // For a second after it was said, as before.
            (told >= 100 || came > 0).then_some(())
        });
        assert_eq!(
            (came > 0, told > 0),
            (is_ours, !is_ours),
            "{version}: {}",
            receiver.said()
        );
        assert!(second.volumes.poll().unwrap().is_none());
    }
}
