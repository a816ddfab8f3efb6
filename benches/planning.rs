//! From a step of the wheel to the pixels of the next slice on the glass.
//!
//! `cargo bench --bench planning -- [STEPS] [load N]`: plans in config/demo.toml on an X server in memory of 1920 x 1080, beside N busy
//! loops (0). Turns the wheel STEPS (300) times over the axial image and reads a part of it back off the screen until it is another. Needs Xvfb.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(unreachable_pub, reason = "a module of this program, and not a crate")]

#[path = "../tests/support/display.rs"]
mod display;
#[path = "../tests/support/load.rs"]
mod load;
#[path = "../tests/support/mod.rs"]
mod support;

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use bus::clock::{monotonic_ns, ms};
use bus::run::RunContext;
use display::Display;
use load::Load;
use support::{Pilot, World, wait_for};
use window::code::Shown;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConnectionExt as _, ImageFormat, MOTION_NOTIFY_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;

/// Between two looks at the screen.
const LOOK: Duration = Duration::from_millis(1);
/// Between two steps: a person's hand.
const PAUSE: Duration = Duration::from_millis(70);
/// The middle of the axial image, and the part of it that is read back.
const AT: [i16; 2] = [228, 330];
const PART: [u16; 2] = [200, 8];

fn main() {
    let (_, steps, load) = load::asked();
    let (steps, load) = (steps.unwrap_or(300.0) as usize, load.unwrap_or(0));
    let Some(display) = Display::new([1920, 1080]) else {
        return;
    };
    let world = World::new();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml");
    let mut command = world.command("pilot");
    command
        .env("DISPLAY", &display.name)
        .arg("plan")
        .arg(world.path("plan.json"))
        .args(["--from-scene", "--window", "--scene"]);
    command.arg(demo).stdout(Stdio::null()).stderr(Stdio::null());
    let pilot = Pilot::of(&world, "plan", command.spawn().unwrap());
    let run = wait_for("the run", || RunContext::load(&world.run_dir("plan")).ok());
    wait_for("images", || {
        display.code(&run).filter(|(code, _)| code.shown() == Shown::NotLive)
    });
    std::thread::sleep(Duration::from_secs(2));
    let _load = Load::new(load);
    println!("| beside {load} busy loops: {steps} times | to another picture, ms, p50 / p99 / largest | above 33 ms |");
    println!("|---|---|---|");
    // There and back, so that it stays in the examination.
    let wheel = |k: usize| if (k / 40).is_multiple_of(2) { 4 } else { 5 };
    println!(
        "| a step of the wheel | {} |",
        changes(&display, steps, |k| button(&display, wheel(k)))
    );
    pilot.stop();
}

fn button(display: &Display, button: u8) {
    for kind in [BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT] {
        fake(display, kind, button);
    }
}

fn fake(display: &Display, kind: u8, detail: u8) {
    let [x, y] = AT;
    let sent = display.eye.xtest_fake_input(kind, detail, 0, display.root, x, y, 0);
    sent.unwrap();
    display.eye.flush().unwrap();
}

fn part(display: &Display) -> Vec<u8> {
    let [x, y] = [AT[0] - PART[0] as i16 / 2, AT[1] - 40];
    let asked = display
        .eye
        .get_image(ImageFormat::Z_PIXMAP, display.root, x, y, PART[0], PART[1], !0);
    asked.unwrap().reply().unwrap().data
}

fn changes(display: &Display, times: usize, change: impl Fn(usize)) -> String {
    fake(display, MOTION_NOTIFY_EVENT, 0);
    let mut took: Vec<f64> = (0..times)
        .map(|k| {
            std::thread::sleep(PAUSE);
            let before = part(display);
            let began_ns = monotonic_ns();
            change(k);
            loop {
                std::thread::sleep(LOOK);
                let took_ms = ms(monotonic_ns() - began_ns);
                // Slices of a uniform organ may be alike: such a step says nothing.
                if part(display) != before {
                    return took_ms;
                }
                if took_ms > 2000.0 {
                    return f64::NAN;
                }
            }
        })
        .filter(|took_ms| took_ms.is_finite())
        .collect();
    took.sort_unstable_by(f64::total_cmp);
    let at = |part: f64| took[((took.len() - 1) as f64 * part) as usize];
    let late = took.iter().filter(|took_ms| **took_ms > 33.0).count();
    format!(
        "{:.1} / {:.1} / {:.1} | {late} of {}",
        at(0.5),
        at(0.99),
        at(1.0),
        took.len()
    )
}
