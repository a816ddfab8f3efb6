//! A localizer that software of others stands for, through a network that fails in every way a network fails.

#![allow(clippy::print_stdout, reason = "why a test was skipped")]
#![allow(clippy::disallowed_methods, reason = "the peer is a process of other software")]

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::support::frames::{Watch, is_connected, is_disconnected, is_seen, patient, status_says, tool};
use crate::support::proxy::{Fault, Proxy, cut_step};
use crate::support::{SMALL, World, kill_9, pid_in, python};
use bus::message::{Lost, MarkerFrame};
use recorder::read::reader;
use serde_json::Value;

/// A server of pyigtl.
struct Peer {
    child: Child,
    port: u16,
}

impl Peer {
    /// `None`, with a printed reason, where there is no pyigtl.
    fn start(version: u8) -> Option<Self> {
        let python = python()?;
        let free = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = free.local_addr().unwrap().port();
        drop(free);
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/igtl_server.py");
        let mut child = Command::new(python)
            .arg(script)
            .args([port.to_string(), version.to_string()])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        if line.trim() != "listening" {
            println!("skipped: the interpreter has no pyigtl");
            let _ = child.wait();
            return None;
        }
        Some(Self { child, port })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn scene(port: u16, more: &str) -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
        + &format!(
            "[tracker.markers]\nmarker = \"StylusToTracker\"\nreference = \"ReferenceToTracker\"\n\
             [localizer]\nkind = \"openigtlink\"\naddress = \"127.0.0.1:{port}\"\nname = \"pyigtl\"\n{more}"
        )
}

/// What the peer sent, by the number in the tool's place: the same on both sides of the network.
fn check(frame: &MarkerFrame) {
    // pyigtl sends message by message, and a busy machine lets one wait for longer than half a frame.
    let Ok(on_patient) = patient(frame) else {
        return;
    };
    let on_patient = on_patient.translation_mm();
    assert_eq!([on_patient[0], on_patient[2]], [-100.0, -1500.0]);
    match tool(frame) {
        Ok(pose) => {
            let [x, y, z] = pose.translation_mm();
            let number = (8.0 * x) as u64;
            // Of one frame of the peer, both of them: the tremor is its number.
            assert_eq!([y, z, on_patient[1]], [(number % 4096) as f64 / 1024.0, -1500.0, y]);
            assert_ne!(number % 5, 4, "said to be MISSING");
        }
        Err(reason) => {
            assert_eq!(reason, Lost::NotSeen);
        }
    }
    let behind_ns = frame.t_arrival_ns - frame.t_capture_ns;
    // Those that come in one piece are put a nanosecond apart.
    assert!((-1000..2_000_000_000).contains(&behind_ns), "{behind_ns} ns");
    assert!(frame.t_publish_ns >= frame.t_arrival_ns && frame.t_device_ns > 1_700_000_000_000_000_000);
}

#[test]
fn a_peer_of_other_software_is_followed_through_a_network_that_fails() {
    let Some(peer) = Peer::start(2) else { return };
    let network = Proxy::to(peer.port);
    let world = World::new();
    let out = world.path("out");
    let text = scene(network.port, "silent_s = 1.5\n");
    let pilot = world.start(&world.file("s.toml", &text), &out, "default");
    let watch = Watch::open(&world);
    watch.wait("poses", 4, is_connected).iter().for_each(check);
    status_says(&pilot, "frames/s");
    network.set(Fault::Bytes);
    watch
        .wait("poses byte by byte", 40, is_connected)
        .iter()
        .for_each(check);
    network.set(Fault::Delay(Duration::from_millis(30)));
    watch
        .wait("poses that are late", 40, is_connected)
        .iter()
        .for_each(check);
    // For less than it may be silent for.
    network.set(Fault::StallBehind(0, Duration::from_millis(300)));
    watch
        .wait("poses after a stall", 40, is_connected)
        .iter()
        .for_each(check);
    // A cable that is pulled: nothing comes, and after a while the connection is given up.
    network.set(Fault::Stall);
    watch.wait("the end of a silent connection", 1, is_disconnected);
    network.set(Fault::None);
    watch.wait("poses after it", 10, is_connected).iter().for_each(check);
    network.set(Fault::CutAll);
    watch.wait("the end of a cut connection", 1, is_disconnected);
    status_says(&pilot, "the peer closed the connection");
    for at in (0..).step_by(cut_step(41)) {
        network.set(Fault::Cut(at, |_| true));
        watch.wait("the end of a cut connection", 1, is_disconnected);
        watch.wait("poses after it", 2, is_connected).iter().for_each(check);
        if at >= network.length() {
            break;
        }
    }
    network.set(Fault::None);
    let before = watch.wait("poses after it", 10, is_connected);
    let others = |status: &Value| -> Vec<Value> {
        let all = status["processes"].as_array().unwrap().iter();
        let others = all.filter(|process| process["name"] != "localizer");
        others.map(|process| process["pid"].clone()).collect()
    };
    let others_before = others(&pilot.status().unwrap());
    assert!(others_before.len() > 2, "{others_before:?}");
    // What kills the process costs poses, and the numbers go on.
    let old = pid_in(&pilot.status().unwrap(), "localizer").unwrap();
    kill_9(old);
    pilot.wait_for("another localizer", |status| {
        pid_in(status, "localizer").is_some_and(|pid| pid != old)
    });
    let after = watch.wait("poses of another process", 10, is_connected);
    after.iter().for_each(check);
    assert!(after[0].seq > before[before.len() - 1].seq);
    assert_eq!(
        others(&pilot.status().unwrap()),
        others_before,
        "nothing else was started anew"
    );
    // The peer goes, and its address says nothing.
    drop(peer);
    watch.wait("the end of the peer", 1, is_disconnected);
    status_says(&pilot, "waiting for 127.0.0.1");
    let _ = pilot.stop();
    recorded(&out);
}

/// The recording has frames as they came, and what became of the connection.
fn recorded(out: &Path) {
    let frames = reader::markers(&out.join("session.mcap")).unwrap();
    let frames: Vec<MarkerFrame> = frames.map(Result::unwrap).collect();
    assert!(frames.iter().any(is_seen) && frames.iter().any(is_disconnected));
}

#[test]
fn a_peer_that_states_no_status_gives_no_pose_unless_the_scene_says_so() {
    let Some(peer) = Peer::start(1) else { return };
    for (more, seen) in [
        ("peer = \"v1\"\n", false),
        ("peer = \"v1\"\nstatus = \"absent-means-valid\"\n", true),
    ] {
        let world = World::new();
        let pilot = world.start(
            &world.file("s.toml", &scene(peer.port, more)),
            &world.path("out"),
            "default",
        );
        let watch = Watch::open(&world);
        let expected = |frame: &MarkerFrame| match seen {
            true => is_seen(frame),
            false => tool(frame) == Err(Lost::Refused),
        };
        watch.wait("frames", 20, expected);
        // A run without a picture of a pose is no success.
        let _ = pilot.stop();
    }
}

#[test]
fn what_cannot_be_dialled_is_waited_for_and_what_cannot_be_meant_is_refused() {
    let world = World::new();
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let pilot = world.start(&world.file("s.toml", &scene(free, "")), &world.path("out"), "default");
    let watch = Watch::open(&world);
    watch.wait("what is not there", 5, is_disconnected);
    status_says(&pilot, "connection refused (try ");
    // A run without a picture of a pose is no success.
    let _ = pilot.stop();
    let room = crate::support::room::Room::new();
    let same = scene(free, "")
        .replace("\"ReferenceToTracker\"", "\"StylusToTrackerOfTheRoom\"")
        .replace("\"StylusToTracker\"", "\"StylusToTrackerOfTheHall\"");
    let scene = room.file("s.toml", &same);
    room.run_is_refused(&scene, &[], "localizer-proc: | are one name within the 20 bytes");
}
