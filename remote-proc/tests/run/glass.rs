//! The window of a second screen, on a real X server: what it says of its picture, as it paints it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use bus::clock::ns;
use bus::message::Heartbeat;
use bus::port::Subscriber;
use bus::topic::HEARTBEAT;

use crate::both::{Both, programs, small};
use crate::rig::{alone, until, world};

/// An X server in memory.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// `None`, with a word, where there is no Xvfb.
    fn open() -> Option<Self> {
        if !Path::new("/usr/bin/Xvfb").exists() {
            println!("skipped: there is no /usr/bin/Xvfb (Debian: xvfb)");
            return None;
        }
        let mut server = Command::new("/usr/bin/Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0", "1280x800x24"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        let mut said = BufReader::new(server.stdout.take().unwrap());
        said.read_line(&mut number).unwrap();
        Some(Self {
            server,
            name: format!(":{}", number.trim()),
        })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// What a picture says of itself, in the word that the window paints and puts into its sign of life (`window::code`): at least one
/// image is of the present, or images are shown and none is.
const LIVE: u64 = 0b0101;
const NOT_LIVE: u64 = 0b1010;
/// What a window on a busy machine is given.
const HELD_UP: Duration = Duration::from_secs(3);

#[test]
fn the_window_of_a_screen_that_is_cut_off_says_that_nothing_on_it_is_live() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let Some(display) = Display::open() else { return };
    let world = world();
    let both = Both::start_with(
        world.path(),
        &programs,
        &[&small(world.path())],
        &["--window"],
        |command| {
            command.env("DISPLAY", &display.name);
        },
    );
    let beats = Subscriber::<Heartbeat>::open(&both.far.bus, &HEARTBEAT, "window", 1).unwrap();
    let paints = |shown: u64| {
        until("that on the glass", || {
            let beat: Heartbeat = beats.newest().unwrap()?;
            (beat.painted_code >> 56 & 0xf == shown).then_some(())
        })
    };
    paints(LIVE);
    both.wire.stand_still(true);
    let cut_ns = both.far.bus.clock().now_ns();
    // Stale 1 s after the cut; the rest is for a window that is held up between judging its images and being done with the paint.
    let since_ns = cut_ns + ns(HELD_UP);
    let mut told = 0;
    until("four pictures of a screen that is cut off", || {
        let beat = beats.newest().unwrap()?;
        if beat.t_painted_ns > since_ns {
            let said = beat.painted_code >> 56 & 0xf;
            assert_eq!(said, NOT_LIVE, "{said:#b}\n{}", both.said());
            told += 1;
        }
        (told >= 4).then_some(())
    });
    both.wire.stand_still(false);
    paints(LIVE);
}
