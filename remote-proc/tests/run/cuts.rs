//! A sender that dies, and a cable that is pulled.

use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::rig::{Room, Second, alone, free_endpoint, until, world};

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
