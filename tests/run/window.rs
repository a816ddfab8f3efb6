//! The operator's window of a real run, on a real X server: what stands on the glass is read back from there.

mod localizer;
mod plan;
mod restart;
mod sight_pixels;

use std::process::Stdio;

use crate::display::Display;
use crate::support::{Pilot, SMALL, World, is_alive, kill_9, stderr, wait_for};
use bus::run::RunContext;
use rustix::process::{Pid, Signal, kill_process};
use window::code::Shown;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{KEY_PRESS_EVENT, KEY_RELEASE_EVENT};
use x11rb::protocol::xtest::ConnectionExt as _;

/// F9 on the keyboard of every X server with an evdev map, as Xvfb has.
const F9: u8 = 75;

/// Presses a key, and lets go of it.
fn press(display: &Display, key: u8) {
    for kind in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
        display
            .eye
            .xtest_fake_input(kind, key, 0, display.root, 0, 0, 0)
            .unwrap();
    }
    display.eye.flush().unwrap();
}

fn start<'a>(world: &'a World, display: &Display) -> (Pilot<'a>, RunContext) {
    let scene = world.file("s.toml", SMALL);
    let mut command = world.command("pilot");
    command
        .env("DISPLAY", &display.name)
        .args(["run", "--window", "--run", "default", "--out"]);
    let child = command
        .arg(world.path("out"))
        .arg(scene)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let pilot = Pilot::of(world, "default", child);
    pilot.wait_live();
    let run = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
    (pilot, run)
}

/// H7: a monitor that was lost in the middle of an operation, and a tool that was not followed afterwards.
#[test]
fn h7_a_killed_window_comes_back_with_live_images() {
    let world = World::new();
    let Some(display) = Display::new([1280, 800]) else {
        return;
    };
    let (pilot, run) = start(&world, &display);
    let mut last = None;
    for _ in 0..3 {
        let (code, pid) = wait_for("live images on the glass", || {
            let (code, pid) = display.code(&run)?;
            (code.shown() == Shown::Live && last != Some(pid)).then_some((code, pid))
        });
        // The glass moves: a later picture, of a later pose.
        wait_for("a later picture", || {
            let (later, by) = display.code(&run)?;
            (by == pid && later.is_behind(code)).then_some(())
        });
        assert_eq!(pilot.pid("window"), Some(u64::from(pid)));
        kill_9(u64::from(pid));
        last = Some(pid);
    }
    pilot.wait_live();
    // The report names processes that were killed as a problem.
    assert_eq!(pilot.stop().code(), Some(3));
}

/// H1, as far as the window itself can say it: images that nobody draws any more are not live on the glass.
#[test]
fn h1_a_silent_tracker_is_not_live_on_the_glass() {
    let world = World::new();
    let Some(display) = Display::new([1280, 800]) else {
        return;
    };
    let (pilot, run) = start(&world, &display);
    let shows = |wanted: Shown| {
        wait_for("that on the glass", || {
            display.code(&run).filter(|(code, _)| code.shown() == wanted)
        });
    };
    shows(Shown::Live);
    let renderer = Pid::from_raw(pilot.pid("view-axial").unwrap() as i32).unwrap();
    kill_process(renderer, Signal::STOP).unwrap();
    shows(Shown::NotLive);
    kill_process(renderer, Signal::CONT).unwrap();
    shows(Shown::Live);
    assert!(pilot.stop().success());
}

#[test]
fn a_key_takes_a_picture_of_the_screen() {
    let world = World::new();
    let Some(display) = Display::new([1280, 800]) else {
        return;
    };
    let (pilot, run) = start(&world, &display);
    wait_for("the window", || display.code(&run));
    press(&display, F9);
    let picture = wait_for("the picture", || {
        let files = std::fs::read_dir(world.path("out"))
            .ok()?
            .flatten()
            .map(|file| file.path());
        let mut pictures = files.filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("screen-") && name.ends_with(".png")
        });
        image::open(pictures.next()?).ok()
    });
    assert_eq!((picture.width(), picture.height()), (1280, 800));
    assert!(pilot.stop().success());
}

#[test]
fn without_a_display_a_window_is_refused_and_a_display_that_is_lost_ends_no_navigation() {
    let world = World::new();
    let scene = world.file("s.toml", SMALL);
    let mut refused = world.command("pilot");
    refused
        .env_remove("DISPLAY")
        .args(["run", "--window", "--for", "1s", "--out"])
        .arg(world.path("none"))
        .arg(&scene);
    let output = refused.output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("DISPLAY is not set"), "{}", stderr(&output));
    let Some(mut display) = Display::new([1280, 800]) else {
        return;
    };
    let (pilot, run) = start(&world, &display);
    wait_for("the window", || display.code(&run));
    let before = pilot.pid("view-axial").unwrap();
    display.server.kill().unwrap();
    pilot.wait_held("window", |_| true);
    assert!(is_alive(before));
    pilot.wait_for("images all the same", crate::support::all_live);
}
