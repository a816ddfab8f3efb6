//! A sender that dies, and a cable that is pulled.

use std::time::{Duration, Instant};

use rustix::process::Signal;

use bus::clock::{monotonic_ns, ns};

use crate::far::Far;
use crate::rig::{Room, Second, alone, free_endpoint, until, world};

/// Poses must be there again within 1 s, which docs/remote.md holds beside what was measured. Others may hold up a busy machine's two
/// cores for longer, so the test asks for this.
const BACK: Duration = Duration::from_secs(10);

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
    let Some(far) = Far::open([16, 16, 16], 17_000) else {
        return;
    };
    // The cable first, so that it goes last, when nobody lives in its network any more.
    let Far {
        cable,
        mut room,
        second,
        receiver,
        ..
    } = far;
    let mut newest = until("the first pose", || {
        room.serve_late_joiners();
        room.pose();
        std::thread::sleep(Duration::from_millis(5));
        second.poses.next().unwrap()
    });
    let law = until("the law", || second.laws.newest().unwrap()).law().unwrap();
    let cut_s = std::env::var("TROCAR_CUT_S")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(3.0);
    cable.set("down");
    let began = Instant::now();
    let mut sent = 0;
    let mut was_told = false;
    while began.elapsed().as_secs_f64() < cut_s {
        sent = room.pose().seq;
        std::thread::sleep(Duration::from_millis(16));
        while let Some(pose) = second.poses.next().unwrap() {
            newest = pose;
        }
        // Measured before the cut, and the clock here is never behind the true one: no margin is needed.
        let since = began.elapsed();
        let age_ns = law.at(monotonic_ns()) - newest.t_capture_ns;
        assert!(age_ns >= ns(since), "{age_ns} ns old, {since:?} after the cut");
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
            is_new |= pose.seq > sent;
        }
        is_new.then_some(())
    });
    let back = back.elapsed();
    println!("cut for {cut_s} s, poses again after {:.3} s", back.as_secs_f64());
    assert!(back < BACK, "{back:?}\n{}", receiver.said());
}
