//! What a second machine is shown, and how old.

use std::time::Duration;

use bus::clock::monotonic_ns;
use bus::message::{Guide, Identity, ToolPose, Wire, Workflow};
use rustix::process::Signal;

use crate::rig::{Room, Second, alone, free_endpoint, until, world};

/// Poses between two looks of the test.
const EVERY: Duration = Duration::from_millis(4);

#[test]
fn a_run_comes_bit_for_bit_and_never_younger_than_it_is() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    // Two clocks that are a day apart.
    let mut room = Room::open(world.path(), Duration::from_secs(86_400), [120, 90, 40], |_| {});
    let second = Second::open(world.path(), "second", &endpoint);
    let _sender = room.send(world.path(), &endpoint);
    let receiver = second.receive(world.path(), &endpoint, &room.id());
    let guide = Guide {
        t_ns: 77,
        plan_id: 5,
        ..Guide::default()
    };
    room.guides.send(guide).unwrap();
    let workflow = Workflow {
        stage: 3,
        ..Workflow::default()
    };
    room.workflows.send(workflow).unwrap();
    let mut identity = Identity::from_wire(&[0; size_of::<Identity>()]).unwrap();
    identity.volume_hash = room.hash.0;
    room.identities.send(identity).unwrap();

    let volume = until("the examination", || {
        room.serve_late_joiners();
        second.volumes.poll().unwrap()
    });
    assert_eq!(volume.hash(), room.hash, "{}", receiver.said());
    let of = |header: &bus::message::VolumeHeader| bus::message::VolumeHeader {
        shm_inode: 0,
        ..*header
    };
    assert_eq!(of(volume.header()), of(&room.header));
    let mut slice = Vec::new();
    let view = volume.view();
    for (x, y, z) in [(0, 0, 0), (119, 89, 39), (5, 60, 17)] {
        let at = view.layout.table(0)[x] + view.layout.table(1)[y] + view.layout.table(2)[z];
        slice.push(view.voxels[at as usize]);
        let expected = ((x + y * 120) as u32 * 7 + z as u32 * 31) as i16;
        assert_eq!(slice.last(), Some(&expected));
    }

    // Poses are shown once the clock is known.
    until("the first pose", || {
        room.pose();
        second.poses.next().unwrap()
    });
    std::thread::sleep(Duration::from_millis(500));
    while second.poses.next().unwrap().is_some() {}
    let mut law = until("the law", || second.laws.newest().unwrap());
    let (mut sent, mut came): (Vec<ToolPose>, Vec<ToolPose>) = (Vec::new(), Vec::new());
    for _ in 0..300 {
        sent.push(room.pose());
        std::thread::sleep(EVERY);
        law = second.laws.newest().unwrap().unwrap_or(law);
        // Truth and what is known of it, on one machine: the sender's clock is this one's less its epoch.
        let now = monotonic_ns();
        let truth = now - room.run.epoch_ns;
        let ahead = law.law().unwrap().at(now) - truth;
        // Half a second of a machine that is held up, and no more: the law would be of no use.
        assert!(
            (0..500_000_000).contains(&ahead),
            "the clock is {ahead} ns ahead of the truth"
        );
        while let Some(pose) = second.poses.next().unwrap() {
            came.push(pose);
        }
    }
    until("all poses", || {
        while let Some(pose) = second.poses.next().unwrap() {
            came.push(pose);
        }
        (came.last().map(|pose| pose.seq) == sent.last().map(|pose| pose.seq)).then_some(())
    });
    let bytes = |poses: &[ToolPose]| poses.iter().map(|pose| pose.wire_bytes().to_vec()).collect::<Vec<_>>();
    assert_eq!(bytes(&came), bytes(&sent), "{}", receiver.said());

    assert_eq!(until("the guide", || second.guides.next().unwrap()), guide);
    assert_eq!(until("the workflow", || second.workflows.next().unwrap()), workflow);
    assert_eq!(until("whose it is", || second.identities.next().unwrap()), identity);
    room.event(1, "first incision");
    let event = until("the event", || second.events.next().unwrap());
    assert_eq!(event.words(), "first incision");
}

/// A second screen must not cost the first one anything, whatever it does.
#[test]
fn a_receiver_that_stands_still_holds_up_no_other() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let mut room = Room::open(world.path(), Duration::from_secs(1), [16, 16, 16], |_| {});
    let seconds = ["one", "two"].map(|name| Second::open(world.path(), name, &endpoint));
    let sender = room.send(world.path(), &endpoint);
    let receivers = [0, 1].map(|i| seconds[i].receive(world.path(), &endpoint, &room.id()));
    for second in &seconds {
        until("the first pose", || {
            room.serve_late_joiners();
            room.pose();
            second.poses.next().unwrap()
        });
    }
    receivers[0].signal(Signal::STOP);
    // 4 s at 500 Hz are 700 KiB, more than all buffers of a receiver hold, and longer than it is waited for: its link is given up
    // meanwhile, which held up the other one for 10 s.
    let mut newest = 0;
    for _ in 0..2000 {
        newest = room.pose().seq;
        std::thread::sleep(Duration::from_millis(2));
    }
    let mut seqs = Vec::new();
    until("the newest pose", || {
        while let Some(pose) = seconds[1].poses.next().unwrap() {
            seqs.push(pose.seq);
        }
        (seqs.last() == Some(&newest)).then_some(())
    });
    let gaps = seqs.windows(2).filter(|two| two[1] != two[0] + 1).count();
    // A busy machine may drop some; a link that was held up drops thousands.
    assert!(
        gaps <= 20 && seqs.len() >= 1900,
        "{gaps} gaps, {} came\n{}",
        seqs.len(),
        sender.said()
    );
    assert!(
        !receivers[1].said().contains("does not answer"),
        "{}",
        receivers[1].said()
    );
    // It comes back when it goes on, and shows what is new by then.
    receivers[0].signal(Signal::CONT);
    until("a pose of the present", || {
        let pose = room.pose();
        std::thread::sleep(Duration::from_millis(20));
        let mut is_new = false;
        while let Some(came) = seconds[0].poses.next().unwrap() {
            is_new |= came.seq >= pose.seq;
        }
        is_new.then_some(())
    });
}
