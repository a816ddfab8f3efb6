//! Messages that do not come are counted, by their channel, and told.

use std::path::Path;

use bus::message::{Guide, Heartbeat, TissueHeader, ToolPose, Wire};
use remote_proc::protocol::Channel;

use crate::liar::{Liar, RUN};
use crate::rig::{Second, Voxels, alone, free_endpoint, keys, remote_proc, until, world};

/// Counts of a channel that are sent, the others are left out.
fn sent(liar: &Liar, channel: Channel, counts: impl IntoIterator<Item = u64>, body: &[u8]) {
    for count in counts {
        liar.put(channel, count, body);
    }
}

fn beat(second: &Second, words: &str) -> Heartbeat {
    until(words, || {
        let beat = second.beats.newest().unwrap()?;
        beat.note_text().contains(words).then_some(beat)
    })
}

#[test]
fn a_sender_that_leaves_out_numbers_is_counted_and_told_of() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint().replace("tcp/", "tls/");
    let keys = keys(world.path(), "127.0.0.1");
    let liar = Liar::of(&endpoint, Some(Path::new(&keys)), Voxels::made([8, 8, 8]));
    let second = Second::open(world.path(), "second", &endpoint);
    let mut receive = remote_proc();
    receive.args(["receive", "--keys", &keys]);
    let receiver = second.receive_by(receive, world.path(), &endpoint, &format!("{RUN:x}"));
    let pose = ToolPose::EMPTY;
    until("the first pose", || {
        liar.put(Channel::Pose, 0, pose.wire_bytes());
        second.poses.next().unwrap()
    });
    // What came before its examination and its clock were known, and what came twice, is no loss.
    assert!(!beat(&second, "clock known").note_text().contains("lost"));

    sent(&liar, Channel::Pose, [1, 2, 5, 6], pose.wire_bytes());
    let told = beat(&second, "2 poses lost on the way");
    assert_eq!(told.counters.dropped, 2, "{}", receiver.said());

    // An older one comes behind a newer one where two links bring it: not shown, and no loss.
    sent(&liar, Channel::Pose, [6, 3, 7], pose.wire_bytes());
    sent(
        &liar,
        Channel::Tissue,
        [10, 11, 15],
        TissueHeader::default().wire_bytes(),
    );
    let told = beat(&second, "2 poses, 3 states lost on the way");
    assert_eq!(told.counters.dropped, 5, "{}", receiver.said());
    let came = std::iter::from_fn(|| second.poses.next().unwrap()).count();
    assert_eq!(came, 5, "1, 2, 5, 6 and 7 came\n{}", receiver.said());

    // A state that is told again and again is not lost where the next telling comes.
    sent(&liar, Channel::Guide, [0, 9], Guide::default().wire_bytes());
    sent(&liar, Channel::Event, [0, 3], &[0; Channel::Event.bytes()]);
    let told = beat(&second, "2 poses, 3 states, 2 others lost on the way");
    assert_eq!(told.counters.dropped, 7, "{}", receiver.said());
    assert_eq!(told.counters.refused, 0, "{}", receiver.said());
}
