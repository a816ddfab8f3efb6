//! Planes that are asked for, on the bus of a real run.

mod surface;

use std::time::Duration;

use crate::support::{SMALL, World, report, wait_for};
use bus::Bus;
use bus::message::{Command, CommandKind, FrameState, ImagePlane};
use bus::port::{CommandClient, Frame, FrameSubscriber};
use bus::run::RunContext;
use bus::topic::LOOK_FRAME;

/// Across the generated patient, oblique, with the window of bone.
const PLANE: ImagePlane = ImagePlane {
    origin_mm: [-60.0, -40.0, 10.0],
    right: [1.0, 0.0, 0.0],
    down: [0.0, 0.6, -0.8],
    pixel_mm: 0.75,
    centre_hu: 400.0,
    width_hu: 2000.0,
};

fn rgba(frame: &Frame) -> Vec<u8> {
    let ages = bus::message::Ages {
        stale_ns: 1,
        lost_ns: 2,
    };
    let shown = frame.shown(i64::MAX, ages);
    assert_eq!(shown.state, Some(FrameState::Look));
    shown.rgba.to_vec()
}

#[test]
fn a_plane_that_is_asked_for_is_shown_as_it_was_asked_for_and_disturbs_no_pose() {
    let world = World::new();
    let scene = SMALL.replace("size = [128, 128]", "size = [256, 224]");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    pilot.wait_live();
    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let looks = FrameSubscriber::open_waking_on(&bus, &LOOK_FRAME, "frontal-local").unwrap();
    let live = FrameSubscriber::open(&bus, &bus::topic::VIEW_FRAME, "frontal-local").unwrap();
    let client = CommandClient::open(&bus, "view-frontal").unwrap();
    let ask = |command| client.ask(command, Duration::from_secs(60)).unwrap();
    let looked = |plane| {
        let reply = ask(Command::look(1, plane));
        assert_eq!((reply.refused, reply.text.as_str()), (false, "drawn"));
        wait_for("the image of a plane", || looks.newest().unwrap())
    };
    let first = looked(PLANE);
    let header = *first.header();
    assert_eq!(header.plane, PLANE);
    assert!(header.slice_plane().unwrap().is_some());
    assert_eq!(
        (header.stamp.view, header.stamp.seq, header.stamp.on_request),
        (1, 0, 1)
    );
    // The same again is the same to the bit, whatever the tool did meanwhile; another window is another image.
    let pixels = rgba(&first);
    assert!(rgba(&looked(PLANE)) == pixels);
    assert!(
        rgba(&looked(ImagePlane {
            centre_hu: 40.0,
            width_hu: 400.0,
            ..PLANE
        })) != pixels
    );
    for (plane, words) in [
        (
            ImagePlane {
                pixel_mm: f64::NAN,
                ..PLANE
            },
            "the plane asked for",
        ),
        (ImagePlane { pixel_mm: 0.0, ..PLANE }, "the plane asked for"),
        (
            ImagePlane {
                pixel_mm: 50.0,
                ..PLANE
            },
            "the shorter side is 11200, expected 1 to 2000 mm",
        ),
        (
            ImagePlane {
                right: PLANE.down,
                ..PLANE
            },
            "the plane asked for",
        ),
        (
            ImagePlane {
                width_hu: f64::NAN,
                ..PLANE
            },
            "width_hu is NaN",
        ),
        (
            ImagePlane {
                origin_mm: [0.0, 0.0, 1e300],
                ..PLANE
            },
            "origin_mm",
        ),
    ] {
        let reply = ask(Command::look(1, plane));
        assert!(reply.refused && reply.text.contains(words), "{words}: {}", reply.text);
    }
    for view in [0, 2, 3, u32::MAX] {
        let reply = ask(Command::look(view, PLANE));
        assert!(
            reply.refused && reply.text.contains("is not drawn by this process"),
            "{}",
            reply.text
        );
    }
    assert!(looks.newest().unwrap().is_none());
    // A hundred requests later the view still follows its poses.
    let seq = |status: &serde_json::Value| status["views"][1]["seq"].as_u64().unwrap();
    let before = seq(&pilot.wait_live());
    (0..100).for_each(|_| drop(looked(PLANE)));
    let after = pilot.wait_for("later poses", |status| {
        crate::support::all_live(status) && seq(status) > before
    });
    assert!(seq(&after) > before);
    let frame = wait_for("a live image", || live.newest().unwrap());
    assert_ne!(frame.header().stamp.frame_state(), Some(FrameState::Look));
    assert!(ask(Command::new(CommandKind::Choose)).refused);
    pilot.stop();
    // Images of planes are none of the view's poses.
    let report = report(&world.path("out"));
    let view = &report["views"][1];
    assert!(view["rendered"].as_u64().unwrap() <= report["poses"]["published"].as_u64().unwrap());
    assert_eq!(view["unflagged_old"], 0);
}
