//! The overview in a run: it follows poses, is turned by whoever asks, says no figure, and comes back.

use std::time::Duration;

use crate::support::{Pilot, SMALL, World, kill_9, png_texts, report, wait_for};
use bus::Bus;
use bus::message::{Ages, Command, FrameHeader, FrameState, ImagePlane};
use bus::port::{CommandClient, FrameSubscriber};
use bus::run::RunContext;
use bus::topic::VIEW_FRAME;
use geometry::{Direction, Point, SlicePlane};

const AGES: Ages = Ages {
    stale_ns: i64::MAX / 2,
    lost_ns: i64::MAX / 2,
};

/// The small scene and an overview of it.
fn scene() -> String {
    SMALL.to_owned()
        + "[[views]]\nname = \"surface\"\nplane = \"surface\"\nextent = \"global\"\nsize = [256, 224]\n\
           surface = { from = { azimuth_deg = 30 }, bone_hu = 250 }\n"
}

fn newest(frames: &FrameSubscriber) -> (FrameHeader, Vec<u8>) {
    let frame = wait_for("an image of the surface", || frames.newest().unwrap());
    (
        *frame.header(),
        frame.shown(frame.header().stamp.t_framed_ns, AGES).rgba.to_vec(),
    )
}

/// How many pixels differ.
fn differ(a: &[u8], b: &[u8]) -> usize {
    a.chunks(4).zip(b.chunks(4)).filter(|(a, b)| a != b).count()
}

fn is_live(pilot: &Pilot<'_>) -> u64 {
    let status = pilot.wait_live();
    let views = status["views"].as_array().unwrap();
    let view = views.iter().find(|view| view["name"] == "surface").unwrap();
    view["seq"].as_u64().unwrap()
}

#[test]
fn a_surface_follows_poses_is_turned_and_comes_back() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", &scene()), &world.path("out"), "default");
    is_live(&pilot);
    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let frames = FrameSubscriber::open(&bus, &VIEW_FRAME, "surface").unwrap();
    let client = CommandClient::open(&bus, "view-surface").unwrap();
    let ask = |command| client.ask(command, Duration::from_secs(60)).unwrap();
    let (header, straight) = newest(&frames);
    assert_eq!(header.stamp.frame_state(), Some(FrameState::Live));
    assert_eq!((header.stamp.view, header.width, header.height), (3, 256, 224));
    // Nothing is measured on it.
    assert_eq!(header.slice_plane(), Ok(None));

    // From behind: the anatomy is another picture, and poses go on.
    let axes = [-Direction::X, -Direction::Z];
    let behind = SlicePlane::centred(Point::new(0.0, 0.0, 40.0), axes, 1.6, [256, 224]).unwrap();
    let reply = ask(Command::turn(3, Some(&behind)));
    assert_eq!((reply.refused, reply.text.as_str()), (false, "turned"));
    let turned = wait_for("the surface from behind", || {
        let (later, rgba) = newest(&frames);
        (later.stamp.seq > header.stamp.seq && differ(&rgba, &straight) > 5000).then_some(rgba)
    });
    let reply = ask(Command::turn(3, None));
    assert!(!reply.refused);
    wait_for("the surface as the scene says", || {
        let (_, rgba) = newest(&frames);
        (differ(&rgba, &straight) < 5000 && differ(&rgba, &turned) > 5000).then_some(())
    });

    let plane = Command::turn(3, Some(&behind)).plane;
    for bad in [
        ImagePlane {
            pixel_mm: f64::NAN,
            ..plane
        },
        ImagePlane {
            origin_mm: [0.0, 1e300, 0.0],
            ..plane
        },
        ImagePlane {
            right: [f64::INFINITY, 0.0, 0.0],
            ..plane
        },
        ImagePlane { pixel_mm: 1e6, ..plane },
        ImagePlane {
            down: plane.right,
            ..plane
        },
    ] {
        let reply = ask(Command {
            plane: bad,
            ..Command::turn(3, None)
        });
        assert!(
            reply.refused && reply.text.contains("asked for"),
            "{bad:?}: {}",
            reply.text
        );
    }
    for view in [0, 4, u32::MAX] {
        let reply = ask(Command::turn(view, Some(&behind)));
        assert!(
            reply.refused && reply.text.contains("is not a surface"),
            "{}",
            reply.text
        );
    }
    let reply = ask(Command::look(3, plane));
    assert!(reply.refused && reply.text.contains("can be turned"), "{}", reply.text);

    let before = is_live(&pilot);
    let pid = pilot.pid("view-surface").unwrap();
    kill_9(pid);
    pilot.wait_for("another renderer", |status| {
        crate::support::pid_in(status, "view-surface").is_some_and(|now| now != pid) && crate::support::all_live(status)
    });
    assert!(is_live(&pilot) > before);
    // Not in success: a renderer has died.
    pilot.stop();
    let report = report(&world.path("out"));
    let view = &report["views"][3];
    assert_eq!((&view["name"], &view["unflagged_old"]), (&"surface".into(), &0.into()));
    assert_eq!(
        (&view["process"], &view["png"]),
        (&"view-surface".into(), &"surface.png".into())
    );
    let texts = png_texts(&world.path("out/surface.png"));
    let sliced = png_texts(&world.path("out/axial-global.png"));
    assert_eq!(
        (&texts["pose_seq"], &texts["volume_hash"]),
        (&sliced["pose_seq"], &sliced["volume_hash"])
    );
}

/// Poses end, and the anatomy stays, dimmed, without the tube: the image stands still and says so.
#[test]
fn a_surface_without_poses_says_so() {
    let world = World::new();
    let lost = scene().replace("stale_ms = 1000.0", "stale_ms = 1000.0\nlost_ms = 1500.0");
    let pilot = world.start(&world.file("s.toml", &lost), &world.path("out"), "default");
    is_live(&pilot);
    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let frames = FrameSubscriber::open(&bus, &VIEW_FRAME, "surface").unwrap();
    let count = |rgba: &[u8], of: fn(&[u8]) -> bool| rgba.chunks(4).filter(|pixel| of(pixel)).count();
    // Blue with a half of red in it, dimmed or not: targets have no red.
    let is_tube = |pixel: &[u8]| pixel[2] > pixel[0].saturating_add(30) && pixel[0] > pixel[2] / 2;
    let live = wait_for("the tube in the patient", || {
        let (_, rgba) = newest(&frames);
        (count(&rgba, is_tube) > 300).then_some(rgba)
    });
    let tracker = pilot.pid("tracker").unwrap();
    let stop = |signal| {
        let pid = rustix::process::Pid::from_raw(i32::try_from(tracker).unwrap()).unwrap();
        rustix::process::kill_process(pid, signal).unwrap();
    };
    stop(rustix::process::Signal::STOP);
    let states = [FrameState::Stale, FrameState::Lost(bus::message::Lost::Silent)];
    let drawn = states.map(|state| {
        wait_for("an old image", || {
            let (header, rgba) = newest(&frames);
            (header.stamp.frame_state() == Some(state)).then_some(rgba)
        })
    });
    stop(rustix::process::Signal::CONT);
    let is_bright = |pixel: &[u8]| pixel[..3].iter().all(|channel| *channel > 110);
    let is_alarm = |pixel: &[u8]| pixel[..3] == [0xff, 0x54, 0x6c];
    assert!(count(&drawn[0], is_tube) > 100);
    assert_eq!(count(&drawn[1], is_tube), 0);
    assert!(count(&drawn[1], is_alarm) > 1500 && count(&live, is_alarm) == 0);
    // Words are bright, bone is not any more.
    assert!(count(&live, is_bright) > 4 * count(&drawn[1], is_bright));
    is_live(&pilot);
    pilot.stop();
}
