//! What stands on an image that is not live: nobody is shown an old picture as if it were now.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod support;

use bus::Bus;
use bus::message::{FrameState, Lost};
use bus::port::{Frame, FrameSubscriber};
use bus::run::RunContext;
use bus::topic::VIEW_FRAME;
use rustix::process::{Pid, Signal, kill_process};
use support::{SMALL, World, wait_for};

const VIEW: &str = "axial-global";
const AMBER: [u8; 3] = [255, 180, 0];
const RED: [u8; 3] = [255, 60, 60];

/// The next image of the view for which `wanted` holds.
fn frame(world: &World, wanted: impl Fn(FrameState) -> bool) -> Frame {
    let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
    let bus = Bus::join(&context).unwrap();
    let frames = FrameSubscriber::open(&bus, &VIEW_FRAME, VIEW).unwrap();
    wait_for("such an image", || {
        let frame = frames.newest().unwrap()?;
        frame.header().stamp.frame_state().is_some_and(&wanted).then_some(frame)
    })
}

fn pixel(frame: &Frame, x: u32, y: u32) -> [u8; 3] {
    let at = ((y * frame.header().width + x) * 4) as usize;
    frame.rgba()[at..at + 3].try_into().unwrap()
}

/// The colour of the image's frame, where all its four sides have one.
fn border(frame: &Frame) -> Option<[u8; 3]> {
    let (right, bottom) = (frame.header().width - 1, frame.header().height - 1);
    let colour = pixel(frame, 0, bottom / 3);
    let sides = [(right, bottom / 3), (right / 3, 0), (right / 3, bottom)];
    sides
        .iter()
        .all(|&(x, y)| pixel(frame, x, y) == colour)
        .then_some(colour)
}

/// The mean grey of the middle, where the patient is.
fn brightness(frame: &Frame) -> f64 {
    let (w, h) = (frame.header().width, frame.header().height);
    let inner = (w / 4..3 * w / 4).flat_map(|x| (h / 2..3 * h / 4).map(move |y| (x, y)));
    let greys: Vec<f64> = inner.map(|(x, y)| f64::from(pixel(frame, x, y)[0])).collect();
    greys.iter().sum::<f64>() / greys.len() as f64
}

#[test]
fn a_silent_tracker_turns_the_border_amber() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    pilot.wait_live();
    let live = frame(&world, |state| state == FrameState::Live);
    assert!(!matches!(border(&live), Some(AMBER | RED)));
    let tracker = Pid::from_raw(pilot.pid("tracker").unwrap() as i32).unwrap();
    kill_process(tracker, Signal::STOP).unwrap();
    let stale = frame(&world, |state| state == FrameState::Stale);
    assert_eq!(border(&stale), Some(AMBER));
    let stamp = stale.header().stamp;
    assert!(
        stamp.t_rendered_ns - stamp.t_capture_ns > 1_000_000_000,
        "older than the scene's limit"
    );
    kill_process(tracker, Signal::CONT).unwrap();
    pilot.wait_live();
    assert!(pilot.stop().success());
}

#[test]
fn a_lost_pose_turns_the_border_red_and_dims_the_picture() {
    let world = World::new();
    let text = SMALL.replace("rate_hz = 60.0", "rate_hz = 60.0\ndropout = 0.02\ndropout_samples = 10");
    let pilot = world.start(&world.file("s.toml", &text), &world.path("out"), "default");
    // Held while later images come: it must stay what it was, also when its viewer has gone.
    let live = frame(&world, |state| state == FrameState::Live);
    let lost = frame(&world, |state| state == FrameState::Lost(Lost::NotSeen));
    assert_eq!(border(&lost), Some(RED));
    assert!(
        brightness(&lost) < 0.6 * brightness(&live),
        "{} {}",
        brightness(&lost),
        brightness(&live)
    );
    assert!(pilot.stop().success());
}

#[test]
fn before_the_first_valid_pose_there_is_no_picture_at_all() {
    let world = World::new();
    let text = SMALL.replace("rate_hz = 60.0", "rate_hz = 60.0\ndropout = 1.0");
    let pilot = world.start(&world.file("s.toml", &text), &world.path("out"), "default");
    let lost = frame(&world, |state| state == FrameState::Lost(Lost::NotSeen));
    assert_eq!(border(&lost), Some(RED));
    assert!(brightness(&lost) < 1.0, "{}", brightness(&lost));
    assert_eq!(pilot.stop().code(), Some(3));
    let report = support::report(&world.path("out"));
    assert!(
        report["problems"][0].as_str().unwrap().starts_with("no valid pose"),
        "{report}"
    );
    assert!(report["views"][0]["png"].is_null());
}
