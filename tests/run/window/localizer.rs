//! A localizer whose peer wants each connection confirmed: it dials again when a person in front of the window says so.

#![allow(clippy::disallowed_methods, reason = "how long a test waits is its own time")]

use std::net::TcpListener;
use std::process::Stdio;
use std::time::{Duration, Instant};

use super::press;
use crate::display::Display;
use crate::support::frames::status_says;
use crate::support::{Pilot, SMALL, World, wait_for};

/// L on the keyboard of every X server with an evdev map, as Xvfb has.
const L: u8 = 46;

#[test]
fn a_key_starts_a_localizer_anew_that_waits_for_a_person() {
    let world = World::new();
    let Some(display) = Display::new([1280, 800]) else {
        return;
    };
    let peer = TcpListener::bind("127.0.0.1:0").unwrap();
    peer.set_nonblocking(true).unwrap();
    let address = peer.local_addr().unwrap();
    let scene = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
        + &format!(
            "[tracker.markers]\nmarker = \"T\"\n\
             [localizer]\nkind = \"openigtlink\"\npeer = \"v1\"\nreconnect = \"ask\"\naddress = \"{address}\"\n"
        );
    let mut command = world.command("pilot");
    let command = command.env("DISPLAY", &display.name).stdout(Stdio::null());
    let command = command.args(["run", "--window", "--run", "default", "--out"]);
    let scene = world.file("s.toml", &scene);
    let child = command.arg(world.path("out")).arg(scene).spawn().unwrap();
    let pilot = Pilot::of(&world, "default", child);
    drop(wait_for("the first connection", || peer.accept().ok()));
    status_says(&pilot, "`pilot restart localizer` dials again");
    let asked = Instant::now();
    while asked.elapsed() < Duration::from_secs(1) {
        assert!(peer.accept().is_err(), "it dialled without being asked");
    }
    wait_for("the connection that was asked for", || {
        // The first picture may come later than the words.
        press(&display, L);
        peer.accept().ok()
    });
    let _ = pilot.stop();
}
