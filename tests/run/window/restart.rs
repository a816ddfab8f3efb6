//! A window that is killed comes back as it was: what it shows is read off the screen of a real X server, pixel by pixel.

use std::process::Stdio;
use std::time::Duration;

use super::{press, start};
use crate::display::Display;
use crate::support::{Pilot, SMALL, World, kill_9, wait_for};
use bus::run::RunContext;
use window::code::Shown;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConnectionExt as _, ImageFormat, MOTION_NOTIFY_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;

/// Keys of every X server with an evdev map, as Xvfb has.
const P: u8 = 33;
const F6: u8 = 72;
const SIZE: [u32; 2] = [1280, 800];
/// So long a picture stays as it is before it is compared: many times what is between two frames.
const STILL: Duration = Duration::from_millis(500);

/// Touches the screen there.
fn touch(display: &Display, [x, y]: [i16; 2]) {
    for (kind, detail) in [
        (MOTION_NOTIFY_EVENT, 0),
        (BUTTON_PRESS_EVENT, 1),
        (BUTTON_RELEASE_EVENT, 1),
    ] {
        display
            .eye
            .xtest_fake_input(kind, detail, 0, display.root, x, y, 0)
            .unwrap();
    }
    display.eye.flush().unwrap();
}

/// What stands on the screen below the band at its top, in which times and the coded cell go on.
fn below_the_band(display: &Display) -> Vec<u8> {
    let place = display.place().unwrap();
    let [_, height] = place.size();
    let top = (place.at[1] + height + 32) as i16;
    let rest = SIZE[1] as u16 - top as u16;
    let asked = display
        .eye
        .get_image(ImageFormat::Z_PIXMAP, display.root, 0, top, SIZE[0] as u16, rest, !0);
    asked.unwrap().reply().unwrap().data
}

/// The picture once it stands still.
fn still(display: &Display) -> Vec<u8> {
    wait_for("a picture that stands still", || {
        let first = below_the_band(display);
        std::thread::sleep(STILL);
        (below_the_band(display) == first).then_some(first)
    })
}

/// Kills the window; the process that paints the next picture in this state is another.
fn kill(display: &Display, run: &RunContext, shown: Shown) {
    let (_, pid) = wait_for("a picture", || display.code(run));
    kill_9(u64::from(pid));
    wait_for("a picture of the next window", || {
        display
            .code(run)
            .filter(|(code, by)| *by != pid && code.shown() == shown)
    });
}

fn differing(a: &[u8], b: &[u8]) -> usize {
    a.chunks(4).zip(b.chunks(4)).filter(|(a, b)| a != b).count()
}

/// H2: after a crash, views of a navigator stood the wrong way round until somebody switched a menu.
#[test]
fn h2_a_killed_window_of_a_replay_shows_the_same_pixels_again() {
    let world = World::new();
    let Some(display) = Display::new(SIZE) else {
        return;
    };
    let scene = world.file("s.toml", SMALL);
    let out = world.path("out");
    world.navigate(&scene, &out, &["--for", "1s"]);
    let mut command = world.command("pilot");
    command
        .env("DISPLAY", &display.name)
        .args(["replay", "--window", "--loop", "--run", "again", "--out"])
        .arg(world.path("replay"))
        .arg(out.join("session.mcap"));
    let pilot = Pilot::of(&world, "again", command.stdout(Stdio::null()).spawn().unwrap());
    let run = wait_for("the run", || RunContext::load(&world.run_dir("again")).ok());
    wait_for("a replay", || {
        display.code(&run).filter(|(code, _)| code.shown() == Shown::Replay)
    });
    press(&display, P);
    let all = still(&display);
    kill(&display, &run, Shown::Replay);
    assert_eq!(differing(&still(&display), &all), 0);
    // The first image, enlarged: kept in a file of the run.
    touch(&display, [320, 220]);
    let enlarged = wait_for("an enlarged image", || {
        Some(still(&display)).filter(|now| differing(now, &all) > 10_000)
    });
    kill(&display, &run, Shown::Replay);
    assert_eq!(differing(&still(&display), &enlarged), 0);
    pilot.stop();
}

/// The same of a run that navigates: what is held and what is aimed at is the pilot's.
#[test]
fn h2_a_killed_window_of_a_held_pose_shows_the_same_pixels_again() {
    let world = World::new();
    let Some(display) = Display::new(SIZE) else {
        return;
    };
    let (pilot, run) = start(&world, &display);
    wait_for("live images", || {
        display.code(&run).filter(|(code, _)| code.shown() == Shown::Live)
    });
    assert!(world.output("pilot", &["choose", "iliac-left"]).status.success());
    press(&display, F6);
    wait_for("what is held", || {
        display.code(&run).filter(|(code, _)| code.shown() == Shown::NotLive)
    });
    let held = still(&display);
    kill(&display, &run, Shown::NotLive);
    assert_eq!(differing(&still(&display), &held), 0);
    press(&display, F6);
    wait_for("live images again", || {
        display.code(&run).filter(|(code, _)| code.shown() == Shown::Live)
    });
    pilot.stop();
}
