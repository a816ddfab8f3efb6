//! The operator's window of a real run, on a real X server: what stands on the glass is read back from there.

#![allow(clippy::print_stdout, reason = "why something is skipped")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::support::{Pilot, SMALL, World, is_alive, kill_9, stderr, wait_for};
use bus::run::RunContext;
use rustix::process::{Pid, Signal, kill_process};
use window::code::{Code, PROPERTY, Place, Shown, key};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, ImageFormat, KEY_PRESS_EVENT, KEY_RELEASE_EVENT};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// F9 on the keyboard of every X server with an evdev map, as Xvfb has.
const F9: u8 = 75;

/// A display in memory; gone when dropped.
struct Display {
    server: Child,
    name: String,
    eye: RustConnection,
    root: u32,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Display {
    /// `None`, with a word, where there is no Xvfb.
    fn new() -> Option<Self> {
        if !Path::new("/usr/bin/Xvfb").exists() {
            println!("skipped: there is no /usr/bin/Xvfb (Debian: xvfb)");
            return None;
        }
        #[allow(
            clippy::disallowed_methods,
            reason = "a server of others, which this test alone uses"
        )]
        let mut server = Command::new("/usr/bin/Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap())
            .read_line(&mut number)
            .unwrap();
        let name = format!(":{}", number.trim());
        let (eye, screen) = RustConnection::connect(Some(&name)).unwrap();
        let root = eye.setup().roots[screen].root;
        Some(Self {
            server,
            name,
            eye,
            root,
        })
    }

    /// The coded cell as it stands on the screen, where it can be read.
    fn code(&self, run: &RunContext) -> Option<(Code, u32)> {
        let property = self
            .eye
            .intern_atom(false, PROPERTY.as_bytes())
            .ok()?
            .reply()
            .ok()?
            .atom;
        let tree = self.eye.query_tree(self.root).ok()?.reply().ok()?;
        let place = tree.children.into_iter().find_map(|window| {
            let asked = self
                .eye
                .get_property(false, window, property, AtomEnum::CARDINAL, 0, 16)
                .ok()?;
            let cardinals: Vec<u32> = asked.reply().ok()?.value32()?.collect();
            Place::of_cardinals(&cardinals).ok()
        })?;
        let [width, height] = place.size().map(|n| n as u16);
        let [x, y] = place.at.map(|n| n as i16);
        let asked = self
            .eye
            .get_image(ImageFormat::Z_PIXMAP, self.root, x, y, width, height, !0)
            .ok()?;
        let pixels = asked.reply().ok()?.data;
        let code = window::code::Grid::read(&pixels, place.square, key(run.epoch_ns)).ok()?;
        Some((code, place.pid))
    }

    fn press(&self, key: u8) {
        for kind in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            self.eye.xtest_fake_input(kind, key, 0, self.root, 0, 0, 0).unwrap();
        }
        self.eye.flush().unwrap();
    }
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
    let Some(display) = Display::new() else { return };
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
    let Some(display) = Display::new() else { return };
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
    let Some(display) = Display::new() else { return };
    let (pilot, run) = start(&world, &display);
    wait_for("the window", || display.code(&run));
    display.press(F9);
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
    let Some(mut display) = Display::new() else { return };
    let (pilot, run) = start(&world, &display);
    wait_for("the window", || display.code(&run));
    let before = pilot.pid("view-axial").unwrap();
    display.server.kill().unwrap();
    pilot.wait_held("window", |_| true);
    assert!(is_alive(before));
    pilot.wait_for("images all the same", crate::support::all_live);
}
