//! What is not shown, and by which name.

use std::time::Duration;

use bus::clock::monotonic_ns;
use bus::message::{VolumeHash, VolumeHeader, Wire};
use bus::run::{RUNTIME_DIR_VARIABLE, ReplayOf, shm_free_bytes};

use remote_proc::protocol::{Facts, VERSION, hex, payloads};

use crate::liar::Liar;
use crate::rig::{Room, Second, alone, free_endpoint, grid, refused, remote_proc, until, world};

#[test]
fn an_examination_that_is_altered_on_the_way_is_never_shown() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    // The header claims another content than the voxels have.
    let room = Room::open(world.path(), Duration::from_secs(1), [40, 30, 20], |header| {
        header.hash[7] ^= 1
    });
    let second = Second::open(world.path(), "second", &endpoint);
    let _sender = room.send(world.path(), &endpoint);
    let mut receiver = second.receive(world.path(), &endpoint, &room.id());
    let ended = receiver.ended_while(|| room.serve_late_joiners());
    assert_eq!(ended.code(), Some(1), "{}", receiver.said());
    assert!(
        receiver
            .said()
            .contains("it was altered on the way. Nothing of it is shown"),
        "{}",
        receiver.said()
    );
    assert!(second.volumes.poll().unwrap().is_none());
}

#[test]
fn headers_that_lie_are_refused_before_memory_is_taken() {
    let _alone = alone();
    let good = VolumeHeader {
        ct_from_voxel: grid([8, 8, 8]).ct_from_voxel().rows(),
        dims: [8, 8, 8],
        brick: [1, 1, 1],
        ..VolumeHeader::default()
    };
    let mirrored_nan = [[f64::NAN; 4]; 3];
    for (header, words) in [
        (
            VolumeHeader {
                dims: [0, 5, 5],
                ..good
            },
            "dimension",
        ),
        (
            VolumeHeader {
                dims: [1 << 21, 1, 1],
                ..good
            },
            "voxels",
        ),
        (
            VolumeHeader {
                dims: [65_536, 65_536, 2],
                ..good
            },
            "voxels",
        ),
        (
            VolumeHeader {
                brick: [3, 1, 1],
                ..good
            },
            "brick",
        ),
        (
            VolumeHeader {
                ct_from_voxel: mirrored_nan,
                ..good
            },
            "NaN",
        ),
        (
            VolumeHeader {
                dims: [16_384, 16_384, 15],
                ..good
            },
            "MiB of shared memory",
        ),
    ] {
        if words == "MiB of shared memory" && shm_free_bytes().unwrap() > 8 << 30 {
            println!("skipped: so much memory that no examination is too large");
            continue;
        }
        let world = world();
        let endpoint = free_endpoint();
        let second = Second::open(world.path(), "second", &endpoint);
        let _liar = Liar::saying(
            &endpoint,
            None,
            &Facts {
                version: VERSION,
                payloads: payloads(),
                run: "room".to_owned(),
                run_id: "00000000000000ff".to_owned(),
                scene: String::new(),
                volume: Some(hex(header.wire_bytes())),
            },
        );
        let mut receiver = second.receive(world.path(), &endpoint, "ff");
        assert_eq!(receiver.ended().code(), Some(1), "{}", receiver.said());
        assert!(receiver.said().contains(words), "{words}: {}", receiver.said());
    }
}

#[test]
fn a_sender_of_another_version_is_refused_by_name() {
    let endpoint = free_endpoint();
    let facts = Facts {
        version: VERSION,
        payloads: vec!["trocar/ToolPose/3 312".to_owned()],
        run: "room".to_owned(),
        run_id: "ff".to_owned(),
        scene: String::new(),
        volume: None,
    };
    let _liar = Liar::saying(&endpoint, None, &facts);
    let mut command = remote_proc();
    command.args(["facts", &endpoint]);
    let said = refused(command);
    assert!(
        said.contains("trocar/ToolPose/3 312 is not this program's") && said.contains("same version"),
        "{said}"
    );
}

/// A run that ended and one that began since, behind one address: poses of the one are none of the other's examination.
#[test]
fn another_run_behind_the_same_address_is_not_shown() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let mut room = Room::open(world.path(), Duration::from_secs(1), [8, 8, 8], |_| {});
    let second = Second::open(world.path(), "second", &endpoint);
    let _sender = room.send(world.path(), &endpoint);
    let receiver = second.receive(world.path(), &endpoint, "0123456789abcdef");
    let note = until("the refusal", || {
        room.serve_late_joiners();
        room.pose();
        second.note().filter(|note| note.contains("shows another run"))
    });
    assert!(note.contains("end this one, and start anew"), "{note}");
    std::thread::sleep(Duration::from_millis(500));
    assert!(second.poses.next().unwrap().is_none(), "{}", receiver.said());
    assert!(second.volumes.poll().unwrap().is_none());
    // By its clock an old image of the other run would be young.
    assert!(second.laws.newest().unwrap().is_none());
}

/// One run ends, and the next one is shown at the same address at once: by its clock, which began anew, the last image of the first
/// would be of the present.
#[test]
fn a_run_that_follows_on_another_gives_neither_poses_nor_its_clock() {
    let _alone = alone();
    let (first, next) = (world(), world());
    let endpoint = free_endpoint();
    let mut room = Room::open(first.path(), Duration::from_secs(600), [8, 8, 8], |_| {});
    let second = Second::open(first.path(), "second", &endpoint);
    let mut sender = room.send(first.path(), &endpoint);
    let receiver = second.receive(first.path(), &endpoint, &room.id());
    until("the first pose", || {
        room.serve_late_joiners();
        room.pose();
        second.poses.next().unwrap()
    });
    sender.signal(rustix::process::Signal::KILL);
    sender.ended();
    let mut other = Room::open(next.path(), Duration::from_secs(1), [8, 8, 8], |_| {});
    let _sender = other.send(next.path(), &endpoint);
    until("the refusal", || {
        other.serve_late_joiners();
        other.pose();
        second.note().filter(|note| note.contains("shows another run"))
    });
    while second.poses.next().unwrap().is_some() {}
    for _ in 0..50 {
        other.pose();
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(second.poses.next().unwrap().is_none(), "{}", receiver.said());
    // The first run's clock goes on, from what was known of it last.
    let last = second.laws.newest().unwrap().unwrap().law().unwrap();
    let now = monotonic_ns();
    let ahead_ns = last.at(now) - (now - room.run.epoch_ns);
    assert!(ahead_ns >= 0, "{ahead_ns} ns");
}

/// A loader came back with another examination, which the run's images are not of; who looks on from outside sees that one alone.
#[test]
fn an_examination_that_the_run_does_not_show_is_not_sent() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let room = Room::open(world.path(), Duration::from_secs(1), [8, 8, 8], |_| {});
    room.shows(VolumeHash([9; 32]));
    let sender = room.send(world.path(), &endpoint);
    until("the sender's words", || {
        room.serve_late_joiners();
        sender.said().contains("none is sent").then_some(())
    });
    let mut command = remote_proc();
    command.args(["facts", &endpoint]);
    let said = refused(command);
    assert!(said.contains("has no examination yet"), "{said}");
}

#[test]
fn what_is_not_of_the_present_is_not_sent() {
    let _alone = alone();
    let world = world();
    let room = Room::open(world.path(), Duration::from_secs(1), [8, 8, 8], |_| {});
    let said = |change: &dyn Fn(&mut bus::run::RunContext)| {
        let mut run = room.run.clone();
        change(&mut run);
        run.store().unwrap();
        let mut command = remote_proc();
        command
            .env(RUNTIME_DIR_VARIABLE, world.path())
            .args(["send", "--run", "room"]);
        refused(command)
    };
    let replay = said(&|run| {
        run.replay = Some(ReplayOf {
            recording: "s.mcap".into(),
            volume_hash: None,
            tissue_again: false,
        });
    });
    assert!(
        replay.contains("run \"room\" is a replay") && replay.contains("copy the recording"),
        "{replay}"
    );
    assert!(said(&|run| run.simulated_time = true).contains("in simulated time"));
    assert!(said(&|run| run.planning = true).contains("a plan being made"));
    let mut command = remote_proc();
    command
        .env(RUNTIME_DIR_VARIABLE, world.path())
        .args(["send", "--run", "nobody"]);
    let none = refused(command);
    assert!(none.contains("\"nobody\" is not going"), "{none}");
}

#[test]
fn who_asks_nobody_is_told_why() {
    let endpoint = free_endpoint();
    let mut command = remote_proc();
    command.args(["facts", &endpoint]);
    let said = refused(command);
    assert!(said.contains("no `remote-proc send` listens at that port"), "{said}");
}
