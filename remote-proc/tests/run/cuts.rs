//! A sender that dies, and a cable that is pulled.

use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::cable::Cable;
use crate::rig::{Room, Second, alone, free_endpoint, keys, remote_proc, until, world};

#[test]
fn a_sender_that_was_killed_is_followed_by_another_and_nothing_is_fetched_twice() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let mut room = Room::open(world.path(), Duration::from_secs(1), [64, 64, 64], |_| {});
    let second = Second::open(world.path(), "second", &endpoint);
    let mut sender = room.send(world.path(), &endpoint);
    let receiver = second.receive(world.path(), &endpoint, &room.id());
    until("the first pose", || {
        room.serve_late_joiners();
        room.pose();
        second.poses.next().unwrap()
    });
    sender.signal(Signal::KILL);
    sender.ended();
    let note = until("the note of the cut", || {
        second.note().filter(|note| note.contains("NO ANSWER"))
    });
    assert!(note.starts_with("NO ANSWER for"), "{note}");
    // The reason is found out by a look.
    until("the reason", || {
        second.note().filter(|note| note.contains("refuses the connection"))
    });
    while second.poses.next().unwrap().is_some() {}
    let _sender = room.send(world.path(), &endpoint);
    let back = until("a pose again", || {
        room.serve_late_joiners();
        room.pose();
        second.poses.next().unwrap()
    });
    assert!(back.seq > 0);
    let said = receiver.said();
    assert_eq!(said.matches("is here after").count(), 1, "{said}");
    until("a note without trouble", || {
        second.note().filter(|note| !note.contains("NO ANSWER"))
    });
}

/// A receiver that follows on one that died finds the examination where its pilot kept it; here nobody kept it, so that it is
/// fetched again, and the clock is known anew before any pose.
#[test]
fn a_receiver_that_was_killed_is_followed_by_another() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let mut room = Room::open(world.path(), Duration::from_secs(1), [16, 16, 16], |_| {});
    let second = Second::open(world.path(), "second", &endpoint);
    let _sender = room.send(world.path(), &endpoint);
    for _ in 0..3 {
        let mut receiver = second.receive(world.path(), &endpoint, &room.id());
        let began = Instant::now();
        let pose = until("a pose", || {
            room.serve_late_joiners();
            let newest = room.pose();
            let came = second.poses.newest().unwrap()?;
            (newest.seq - came.seq < 5 || began.elapsed() > Duration::from_secs(5)).then_some(came)
        });
        assert!(pose.seq > 0);
        receiver.signal(Signal::KILL);
        receiver.ended();
        second.bus.remove_dead_processes();
        while second.poses.next().unwrap().is_some() {}
    }
}

/// What is cut off is told, and what comes back is new. `TROCAR_CUT_S` cuts for longer; how long the way back took is printed.
#[test]
fn a_cable_that_is_pulled_is_told_of_and_poses_come_again_when_it_is_back() {
    let _alone = alone();
    let Some(cable) = Cable::new() else { return };
    let world = world();
    let (head, last) = cable.address.rsplit_once('.').unwrap();
    let here = format!("{head}.{}", last.parse::<u8>().unwrap() - 1);
    let endpoint = format!("tls/{here}:{}", 17_000 + std::process::id() % 1000);
    let keys = keys(world.path(), &here);
    let mut room = Room::open(world.path(), Duration::from_secs(1), [16, 16, 16], |_| {});
    let second = Second::open(world.path(), "second", &endpoint);
    let _sender = room.send_by(
        {
            let mut command = remote_proc();
            command.args(["send", "--keys", &keys]);
            command
        },
        world.path(),
        &endpoint,
    );
    let receiver = second.receive_by(
        {
            let mut command = cable.command(env!("CARGO_BIN_EXE_remote-proc").as_ref());
            command.args(["receive", "--keys", &keys]);
            command
        },
        world.path(),
        &endpoint,
        &room.id(),
    );
    until("the first pose", || {
        room.serve_late_joiners();
        room.pose();
        std::thread::sleep(Duration::from_millis(5));
        second.poses.next().unwrap()
    });
    let cut_s = std::env::var("TROCAR_CUT_S")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(3.0);
    cable.set("down");
    let began = Instant::now();
    let mut newest = 0;
    let mut was_told = false;
    while began.elapsed().as_secs_f64() < cut_s {
        newest = room.pose().seq;
        std::thread::sleep(Duration::from_millis(16));
        was_told |= second.note().is_some_and(|note| note.contains("NO ANSWER"));
    }
    assert!(was_told, "{}", receiver.said());
    while second.poses.next().unwrap().is_some() {}
    cable.set("up");
    let back = Instant::now();
    until("a pose of after the cut", || {
        room.pose();
        std::thread::sleep(Duration::from_millis(16));
        let mut is_new = false;
        while let Some(pose) = second.poses.next().unwrap() {
            is_new |= pose.seq > newest;
        }
        is_new.then_some(())
    });
    println!(
        "cut for {cut_s} s, poses again after {:.3} s",
        back.elapsed().as_secs_f64()
    );
}

/// What such a link gives is printed: `cargo test --test run -- --ignored --nocapture slow`, as root, with `tc` and `nft`.
#[test]
#[ignore = "prints what a link of 1 Mbit/s that loses a fifth of its packets gives; takes a minute"]
fn a_slow_and_lossy_link_shows_what_comes_with_its_age() {
    let _alone = alone();
    let Some(cable) = Cable::new() else { return };
    let world = world();
    let (head, last) = cable.address.rsplit_once('.').unwrap();
    let here = format!("{head}.{}", last.parse::<u8>().unwrap() - 1);
    let endpoint = format!("tls/{here}:{}", 18_000 + std::process::id() % 1000);
    let keys = keys(world.path(), &here);
    let dims = [80, 80, 80];
    let mut room = Room::open(world.path(), Duration::from_secs(1), dims, |_| {});
    let second = Second::open(world.path(), "second", &endpoint);
    let number = std::process::id();
    for (name, words) in [
        (
            "tc",
            format!("qdisc add dev tn{number} root tbf rate 1mbit burst 16kbit latency 200ms"),
        ),
        ("ip", format!("netns exec tr{number} nft add table inet t")),
        (
            "ip",
            format!("netns exec tr{number} nft add chain inet t i {{ type filter hook input priority 0 ; }}"),
        ),
        (
            "ip",
            format!("netns exec tr{number} nft add rule inet t i numgen random mod 100 < 20 drop"),
        ),
    ] {
        let done = std::process::Command::new(name).args(words.split(' ')).status();
        assert!(done.is_ok_and(|status| status.success()), "{name} {words}");
    }
    let by = |verb: &str| {
        ["--keys", &keys].iter().fold(vec![verb.to_owned()], |mut all, word| {
            all.push((*word).to_owned());
            all
        })
    };
    let mut send = remote_proc();
    send.args(by("send"));
    let _sender = room.send_by(send, world.path(), &endpoint);
    let mut receive = cable.command(env!("CARGO_BIN_EXE_remote-proc").as_ref());
    receive.args(by("receive"));
    let began = Instant::now();
    let receiver = second.receive_by(receive, world.path(), &endpoint, &room.id());
    let mut came = Vec::new();
    let mut volume_s = None;
    let (mut first, mut newest) = (None, None);
    while began.elapsed() < Duration::from_secs(60) {
        room.serve_late_joiners();
        room.pose();
        std::thread::sleep(Duration::from_millis(16));
        if volume_s.is_none() && second.volumes.poll().unwrap().is_some() {
            volume_s = Some(began.elapsed().as_secs_f64());
        }
        while let Some(pose) = second.poses.next().unwrap() {
            let age_ns = room.bus.clock().now_ns() - pose.t_capture_ns;
            assert!(newest.is_none_or(|newest| pose.seq > newest), "a pose went back");
            first = first.or(Some(pose.seq));
            newest = Some(pose.seq);
            came.push(bus::clock::ms(age_ns));
        }
    }
    came.sort_by(f64::total_cmp);
    let at = |share: f64| came[(share * (came.len() - 1) as f64) as usize];
    let sent = newest.unwrap() - first.unwrap() + 1;
    println!(
        "{} KiB of voxels after {volume_s:?} s; {} of {sent} poses came, {:.0} ms old (p50), {:.0} (p90), {:.0} (p99)\n{:?}\n{}",
        dims.iter().product::<u32>() / (1 << 9),
        came.len(),
        at(0.5),
        at(0.9),
        at(0.99),
        second.note(),
        receiver.said()
    );
}
