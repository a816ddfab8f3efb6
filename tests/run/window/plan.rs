//! A plan made on the screen of a real X server, with its pointer and keys: what stands in the file is what was pointed at.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use super::press;
use crate::display::Display;
use crate::support::{Pilot, World, kill_9, stderr, wait_for};
use bus::clock::monotonic_ns;
use bus::run::RunContext;
use geometry::{Ct, Point};
use phantom::Phantom;
use serde_json::Value;
use window::code::Shown;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConnectionExt as _, ImageFormat, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
    MOTION_NOTIFY_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;

const SCENE: &str =
    "seed = 1\n[volume]\nspacing_mm = 2.5\n[limits]\nsilent_s = 30.0\nstop_s = 30.0\nrestart_window_s = 3600.0";
const SPACING_MM: f64 = 2.5;
/// Keys of every X server with an evdev map, as Xvfb has.
const T: u8 = 28;
const E: u8 = 26;
const Z: u8 = 52;
const M: u8 = 58;
const PLUS: u8 = 86;
const CLOSING_BRACKET: u8 = 35;
const CONTROL: u8 = 37;

fn fake(display: &Display, kind: u8, detail: u8, [x, y]: [i16; 2]) {
    let sent = display.eye.xtest_fake_input(kind, detail, 0, display.root, x, y, 0);
    sent.unwrap();
    display.eye.flush().unwrap();
}

fn point(display: &Display, at: [i16; 2]) {
    fake(display, MOTION_NOTIFY_EVENT, 0, at);
}

fn click(display: &Display, button: u8, at: [i16; 2]) {
    point(display, at);
    for kind in [BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT] {
        fake(display, kind, button, at);
    }
}

fn with_control(display: &Display, key: u8) {
    fake(display, KEY_PRESS_EVENT, CONTROL, [0, 0]);
    press(display, key);
    fake(display, KEY_RELEASE_EVENT, CONTROL, [0, 0]);
}

/// The grey of one pixel of the screen.
fn grey(display: &Display, [x, y]: [i16; 2]) -> f64 {
    let asked = display
        .eye
        .get_image(ImageFormat::Z_PIXMAP, display.root, x, y, 1, 1, !0);
    f64::from(asked.unwrap().reply().unwrap().data[0])
}

fn read(path: &Path) -> Option<Value> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

fn plan_with(path: &Path, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
    wait_for(what, || read(path).filter(&holds))
}

fn place(value: &Value) -> Point<Ct> {
    let [x, y, z] = std::array::from_fn(|axis| value[axis].as_f64().unwrap());
    Point::new(x, y, z)
}

/// Least and largest HU of the patient within a voxel of `p`, as the grey of the window 40 / 400.
fn greys_about(patient: &Phantom, p: Point<Ct>) -> [f64; 2] {
    let step = |k: usize| (k as f64 / 5.0 - 1.0) * SPACING_MM;
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..11 * 11 * 11 {
        let [dx, dy, dz] = [k % 11, k / 11 % 11, k / 121].map(step);
        let [x, y, z] = p.mm();
        let hu = patient.hu(Point::new(x + dx, y + dy, z + dz));
        let grey = ((hu - (40.0 - 200.0)) / 400.0).clamp(0.0, 1.0) * 255.0;
        (least, most) = (least.min(grey), most.max(grey));
    }
    [least, most]
}

/// What a process says of itself.
fn note(status: &Value, process: &str) -> String {
    let processes = status["processes"].as_array().unwrap();
    let found = processes.iter().find(|found| found["name"] == process).unwrap();
    found["note"].as_str().unwrap_or_default().to_owned()
}

fn start<'a>(world: &'a World, display: &Display, path: &Path) -> (Pilot<'a>, RunContext) {
    let scene = world.file("s.toml", SCENE);
    let mut command = world.command("pilot");
    command
        .env("DISPLAY", &display.name)
        .arg("plan")
        .arg(path)
        .args(["--window", "--scene"])
        .arg(scene);
    let pilot = Pilot::of(world, "plan", command.stdout(Stdio::null()).spawn().unwrap());
    let run = wait_for("the run", || RunContext::load(&world.run_dir("plan")).ok());
    wait_for("images to plan on", || {
        display.code(&run).filter(|(code, _)| code.shown() == Shown::NotLive)
    });
    (pilot, run)
}

/// Points at eight places of the axial image. The grey that was under the pointer must be the patient's at the place that the file
/// gets: neither screen, nor plane, nor picking can be off by more than a voxel, nor a side be the other.
#[test]
fn what_is_pointed_at_on_the_glass_is_what_stands_in_the_plan() {
    let world = World::new();
    let Some(display) = Display::new([1280, 800]) else {
        return;
    };
    let path = world.path("plan.json");
    let (pilot, run) = start(&world, &display, &path);
    let patient = Phantom::new(1);
    for k in 0..8_i16 {
        let at = [90 + 20 * k, 200 + 11 * k];
        // Beside the cross that the other slices make: it is moved away by pointing elsewhere.
        click(&display, 1, [at[0] + 17, at[1] + 17]);
        let mut last = f64::NAN;
        let seen = wait_for("a picture that stands still", || {
            std::thread::sleep(Duration::from_millis(200));
            let now = grey(&display, at);
            (std::mem::replace(&mut last, now) == now).then_some(now)
        });
        point(&display, at);
        let (count, mut looks) = (usize::from(k as u16) + 1, 0);
        let plan = wait_for("a target more", || {
            // As a person does who sees that nothing came of it for half a minute: a busy machine shows no picture, and takes no key, for a while.
            if looks % 1500 == 0 {
                press(&display, T);
            }
            looks += 1;
            read(&path).filter(|plan| plan["targets"].as_array().is_some_and(|t| t.len() == count))
        });
        let p = place(&plan["targets"][count - 1]["ct_mm"]);
        let [least, most] = greys_about(&patient, p);
        // Rounded to whole HU and to whole greys, and blended between two pixels.
        assert!(
            (least - 3.0..=most + 3.0).contains(&seen),
            "{at:?}: {seen} at {p:?}, expected {least} to {most}"
        );
    }
    // From the feet: what lies further right on the image lies further to the patient's left; further down, to her back.
    let plan = read(&path).unwrap();
    let [first, last] = [0, 7].map(|k| place(&plan["targets"][k]["ct_mm"]).mm());
    assert!(
        last[0] > first[0] + 20.0 && last[1] > first[1] + 10.0,
        "{first:?} {last:?}"
    );

    // Two keys are two changes, also where the second comes before the first is written. (One key twice within a millisecond of the
    // server's would be the repetition of a key that is held down.)
    point(&display, [240, 330]);
    press(&display, E);
    press(&display, PLUS);
    press(&display, CLOSING_BRACKET);
    let sizes = |plan: &Value| ["diameter_mm", "stop_mm"].map(|key| plan["targets"][7][key].as_f64());
    let plan = plan_with(&path, "two steps", |plan| sizes(plan) == [Some(5.5), Some(0.5)]);
    assert!(plan["targets"][7]["entry_ct_mm"].is_array());
    with_control(&display, Z);
    plan_with(&path, "a step taken back", |plan| sizes(plan) == [Some(5.5), Some(0.0)]);

    // A renderer that is killed comes back, and the slice is that of the next step.
    point(&display, [150, 250]);
    let part = |display: &Display| {
        let asked = display
            .eye
            .get_image(ImageFormat::Z_PIXMAP, display.root, 40, 150, 200, 200, !0);
        asked.unwrap().reply().unwrap().data
    };
    let before = part(&display);
    kill_9(pilot.pid("view-axial").unwrap());
    for _ in 0..12 {
        click(&display, 4, [150, 250]);
    }
    wait_for("another slice", || (part(&display) != before).then_some(()));
    let moved = wait_for("a target on it", || {
        std::thread::sleep(Duration::from_millis(500));
        press(&display, T);
        let plan = read(&path)?;
        let count = plan["targets"].as_array()?.len();
        let z = place(&plan["targets"][count - 1]["ct_mm"]).mm()[2];
        let z_before = place(&plan["targets"][0]["ct_mm"]).mm()[2];
        ((z - z_before - 12.0 * SPACING_MM).abs() < 1e-6).then_some(count)
    });
    assert!(moved > 8);

    // A distance: as long as the points are apart.
    press(&display, M);
    click(&display, 1, [120, 300]);
    click(&display, 1, [180, 300]);
    let plan = plan_with(&path, "a distance", |plan| plan["measures"].is_array());
    let [a, b] = [0, 1].map(|k| place(&plan["measures"][0]["ct_mm"][k]));
    let apart = |k: usize| place(&plan["targets"][k]["ct_mm"]).mm()[0];
    // Along x, the targets are 20 pixels apart.
    let px_mm = (apart(7) - apart(0)) / 140.0;
    assert!(
        (a.distance(b) - 60.0 * px_mm).abs() < 1.5 * px_mm,
        "{a:?} {b:?} {px_mm}"
    );

    // A window that is killed comes back; what it shows is the pilot's.
    let (_, pid) = wait_for("a picture", || display.code(&run));
    kill_9(u64::from(pid));
    wait_for("the next window", || {
        display
            .code(&run)
            .filter(|(code, by)| *by != pid && code.shown() == Shown::NotLive)
    });
    // As long as the cover lies over the screen no key reaches it.
    pilot.wait_for("an uncovered screen", |status| {
        note(status, "window-watch").contains("is what it says")
    });
    // What the watch said may be of before the window was killed: the cover can still come, and takes the key.
    let mut pressed: Option<i64> = None;
    wait_for("the distance taken back", || {
        if pressed.is_none_or(|at| monotonic_ns() - at > 3_000_000_000) {
            with_control(&display, Z);
            pressed = Some(monotonic_ns());
        }
        read(&path)?["measures"].is_null().then_some(())
    });
    assert!(pilot.stop().success());
}

/// Somebody else changes the plan meanwhile: nothing of theirs is lost, and the screen's change is refused.
#[test]
fn two_that_make_one_plan_lose_nothing() {
    let world = World::new();
    let Some(display) = Display::new([1280, 800]) else {
        return;
    };
    let path = world.path("plan.json");
    let (pilot, _) = start(&world, &display, &path);
    point(&display, [150, 250]);
    press(&display, T);
    plan_with(&path, "a target", |plan| {
        plan["targets"].as_array().is_some_and(|t| t.len() == 1)
    });
    let plan = path.to_str().unwrap();
    let scene = world.path("s.toml");
    let other = world.output(
        "pilot",
        &["plan", plan, "--scene", scene.to_str().unwrap(), "--notes", "theirs"],
    );
    assert!(other.status.code() != Some(1), "{}", stderr(&other));
    let theirs = read(&path).unwrap();
    press(&display, T);
    pilot.wait_for("a refusal on the screen", |status| {
        note(status, "window").contains("changed by somebody else")
    });
    assert_eq!(read(&path).unwrap(), theirs);
    assert!(pilot.stop().success());
}
