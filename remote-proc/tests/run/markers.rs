//! A run whose localizer makes the poses of its markers: its frames and its words come too.

use std::time::Duration;

use bus::message::{CaptureClock, Event, Level, Lost, MarkerFrame, MarkerSight, Wire};
use bus::port::{Publisher, Subscriber};
use bus::topic::{EVENT, MARKERS};
use geometry::{Marker, Rigid, Tracker};

use crate::rig::{Room, Second, alone, free_endpoint, until, world};

const SCENE: &str = "[tracker]\nsource = \"markers\"\n[tracker.markers]\nmarker = \"T\"\n\
                     [localizer]\nkind = \"openigtlink\"\npeer = \"plus\"\naddress = \"127.0.0.1:18944\"\n";

/// No two frames are alike in any field.
fn frame(seq: u64) -> MarkerFrame {
    let t_ns = i64::MAX - 1000 * seq as i64;
    let mut frame = MarkerFrame {
        seq,
        t_device_ns: t_ns,
        t_capture_ns: t_ns - 1,
        t_arrival_ns: t_ns - 2,
        t_publish_ns: t_ns - 3,
        t_uncertain_ns: t_ns - 4,
        clock: CaptureClock::Mapped.code(),
        ..MarkerFrame::EMPTY
    }
    .of_device("a localizer");
    let mut seen = MarkerSight::seen(0, Rigid::<Tracker, Marker>::identity(), seq as f64 / 7.0);
    seen.t_mm = [seq as f64 / 3.0, -0.0, f64::MIN_POSITIVE];
    let sights = [seen, MarkerSight::lost(1, Lost::NotSeen, seq as i64)];
    frame.set(&sights).unwrap();
    frame
}

#[test]
fn frames_of_markers_come_bit_for_bit_and_so_do_the_localizers_words() {
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let mut room = Room::showing(SCENE, world.path(), Duration::from_secs(1), [8, 8, 8], |_| {});
    let near = Publisher::<MarkerFrame>::open(&room.bus, &MARKERS, "").unwrap();
    let words = Publisher::<Event>::open(&room.bus, &EVENT, "localizer").unwrap();
    let second = Second::open(world.path(), "second", &endpoint);
    let far = Subscriber::<MarkerFrame>::open(&second.bus, &MARKERS, "", MARKERS.buffer).unwrap();
    let _sender = room.send(world.path(), &endpoint);
    let receiver = second.receive(world.path(), &endpoint, &room.id());
    until("the first pose", || {
        room.serve_late_joiners();
        room.pose();
        second.poses.next().unwrap()
    });
    // One at a time, as a link that has no room for one within 0.2 ms drops it, and a busy machine has none at times.
    for seq in 0..40 {
        let sent = frame(seq);
        near.send(sent).unwrap();
        let came = until("a frame of markers", || far.next().unwrap());
        assert_eq!(came.wire_bytes(), sent.wire_bytes(), "{}", receiver.said());
    }
    assert!(far.next().unwrap().is_none());

    let said = Event::new(3, 77, Level::Warning, "localizer: its clock was set");
    words.send(said).unwrap();
    room.event(4, "first incision");
    let mut came = Vec::new();
    until("both events", || {
        came.extend(second.events.next().unwrap());
        (came.len() == 2).then_some(())
    });
    let of_localizer = came.iter().find(|event| event.seq == 3).unwrap();
    assert_eq!(of_localizer.wire_bytes(), said.wire_bytes());
    assert!(came.iter().any(|event| event.words() == "first incision"));
}
