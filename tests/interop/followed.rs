//! A run that follows a server of the C++ library, which reads header version 1 alone.

#![allow(clippy::disallowed_methods, reason = "the peer is a process of other software")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use bus::message::{CaptureClock, Lost, MarkerFrame};
use serde_json::Value;

use crate::peers::cxx_server;
use crate::support::frames::{Watch, is_disconnected, is_seen, patient, status_says, tool};
use crate::support::proxy::{Fault, Proxy, cut_step};
use crate::support::{Pilot, SMALL, World, report, wait_for};

/// The server, as a process.
pub(crate) struct Server {
    pub(crate) child: Child,
    pub(crate) port: u16,
    lines: Arc<Mutex<Vec<String>>>,
}

impl Server {
    /// `None`, with a printed reason, where there is no compiler or no library.
    fn start(mode: &str) -> Option<Self> {
        let mut command = Command::new(cxx_server()?);
        command.arg(mode);
        Some(Self::of(command))
    }

    /// The same, however it is started.
    pub(crate) fn of(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        let port = line.trim().parse().unwrap_or_else(|_| panic!("{line:?}"));
        let lines = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&lines);
        thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                into.lock().unwrap().push(line);
            }
        });
        Self { child, port, lines }
    }

    /// What it was sent so far.
    fn was_sent(&self) -> Vec<String> {
        self.lines.lock().unwrap().clone()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(crate) fn scene(address: &str, more: &str) -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
        + &format!(
            "[tracker.markers]\nmarker = \"StylusToTracker\"\nreference = \"ReferenceToTracker\"\n\
             [localizer]\nkind = \"openigtlink\"\naddress = \"{address}\"\nstatus = \"absent-means-valid\"\n{more}"
        )
}

fn start<'a>(world: &'a World, port: u16, more: &str) -> (Pilot<'a>, Watch) {
    let scene = world.file("s.toml", &scene(&format!("127.0.0.1:{port}"), more));
    let pilot = world.start(&scene, &world.path("out"), "default");
    (pilot, Watch::open(world))
}

/// Whether the server sends the tool in this frame.
fn sends_tool(number: u64) -> bool {
    number % 5 != 4 && number % 500 < 300
}

/// What the server sent, by the number in the places.
pub(crate) fn check(frame: &MarkerFrame) {
    let number_of = |y: f64| (y * 1024.0) as u64;
    if let Ok(pose) = tool(frame) {
        let [x, y, z] = pose.translation_mm();
        let number = (8.0 * x) as u64;
        assert_eq!([number % 4000, 1500], [number_of(y), -z as u64]);
        assert!(sends_tool(number), "frame {number}, in which the tool was not sent");
    }
    if let Ok(pose) = patient(frame) {
        let [x, y, z] = pose.translation_mm();
        assert_eq!([x, z], [-100.0, -1500.0]);
        if let Ok(tool) = tool(frame) {
            assert_eq!(tool.translation_mm()[1], y, "two instants in one frame");
        }
    }
    if let Err(reason) = tool(frame) {
        assert!(matches!(reason, Lost::NotSeen | Lost::Disconnected), "{reason:?}");
    }
    assert!(frame.t_capture_ns <= frame.t_arrival_ns + 1000);
}

/// In one frame: of an instant.
fn is_whole(frame: &MarkerFrame) -> bool {
    is_seen(frame) && patient(frame).is_ok()
}

/// Waits until so many frames have come of which this holds, one after the other or not.
fn until(watch: &Watch, what: &str, count: usize, wanted: impl Fn(&MarkerFrame) -> bool) {
    let mut found = 0;
    wait_for(what, || {
        for frame in watch.come() {
            check(&frame);
            found += usize::from(wanted(&frame));
        }
        (found >= count).then_some(())
    });
}

fn is_any(_: &[u8]) -> bool {
    true
}

/// Poses come through a network that gives single bytes, delays, stalls, and cuts each `step`th byte of a piece.
fn follows_through(network: &Proxy, watch: &Watch, step: usize) {
    until(watch, "poses", 20, is_whole);
    for fault in [Fault::Bytes, Fault::Delay(Duration::from_millis(30))] {
        network.set(fault);
        until(watch, "poses through it", 60, is_whole);
    }
    // For less than it may be silent for.
    network.set(Fault::StallBehind(0, Duration::from_millis(300)));
    until(watch, "poses after a stall", 60, is_whole);
    network.set(Fault::Stall);
    until(watch, "the end of a silent connection", 1, is_disconnected);
    network.set(Fault::None);
    until(watch, "poses after it", 5, is_whole);
    // In the header, in the body and between two messages.
    for at in (0..=106).step_by(cut_step(step)) {
        network.set(Fault::Cut(at, is_any));
        until(watch, "the end of a cut connection", 1, is_disconnected);
        until(watch, "poses after it", 2, is_whole);
    }
}

#[test]
fn transforms_of_version_1_are_followed_through_a_network_that_fails_and_a_lost_tool_is_none() {
    let Some(server) = Server::start("push") else { return };
    let network = Proxy::to(server.port);
    let world = World::new();
    let (pilot, watch) = start(&world, network.port, "peer = \"v1\"\nsilent_s = 1.5\n");
    follows_through(&network, &watch, 9);
    // Two seconds in which the tool is not sent.
    until(&watch, "frames without the tool", 150, |frame| {
        tool(frame) == Err(Lost::NotSeen)
    });
    assert!(!server.was_sent().contains(&"BAD HEADER".to_owned()));
    let _ = pilot.stop();
}

/// The turn that the server states with these: 120 degrees about (1, -1, 1), and nothing of the digits of single precision is lost.
fn is_turned(frame: &MarkerFrame) -> bool {
    let is_it = |quaternion: [f64; 4]| quaternion == [0.5, 0.5, -0.5, 0.5];
    [
        tool(frame).map(|pose| pose.quaternion()),
        patient(frame).map(|pose| pose.quaternion()),
    ]
    .iter()
    .all(|quaternion| quaternion.is_ok_and(is_it))
}

#[test]
fn positions_and_quaternions_are_followed_through_a_network_that_fails_and_a_lost_tool_is_none() {
    for mode in ["positions", "quaternions"] {
        let Some(server) = Server::start(mode) else { return };
        let network = Proxy::to(server.port);
        let world = World::new();
        let (pilot, watch) = start(&world, network.port, "peer = \"v1\"\nsilent_s = 1.5\n");
        until(&watch, "turned poses", 20, is_turned);
        follows_through(&network, &watch, 35);
        until(&watch, "frames without the tool", 150, |frame| {
            tool(frame) == Err(Lost::NotSeen)
        });
        let _ = pilot.stop();
    }
}

#[test]
fn version_1_is_found_out_by_the_silence_after_version_2() {
    let Some(server) = Server::start("stream") else { return };
    let network = Proxy::to(server.port);
    let world = World::new();
    let (pilot, watch) = start(
        &world,
        network.port,
        "peer = \"auto\"\nstream_ms = 10\nsilent_s = 1.5\n",
    );
    until(&watch, "poses", 20, is_whole);
    let told = watch.told().join("\n");
    assert!(
        told.contains("no whole message within 1.0 s of a header of version 2"),
        "{told}"
    );
    status_says(&pilot, "version 1");
    let sent = server.was_sent();
    let place = |wanted: &str| sent.iter().position(|line| line == wanted);
    assert!(
        place("BAD HEADER") < place("STT_TDATA 10") && place("BAD HEADER").is_some(),
        "{sent:?}"
    );
    // Which version it is stays known.
    follows_through(&network, &watch, 35);
    until(&watch, "frames without the tool", 150, |frame| {
        tool(frame) == Err(Lost::NotSeen)
    });
    let _ = pilot.stop();
}

#[test]
fn a_connection_that_somebody_confirms_is_made_again_only_when_a_person_says_so() {
    let Some(server) = Server::start("stream") else { return };
    let network = Proxy::to(server.port);
    let world = World::new();
    let more = "peer = \"v1\"\nstream_ms = 20\nreconnect = \"ask\"\n";
    let (pilot, watch) = start(&world, network.port, more);
    until(&watch, "poses", 5, is_whole);
    network.set(Fault::Cut(7, is_any));
    until(&watch, "the end of the connection", 1, is_disconnected);
    status_says(&pilot, "`pilot restart localizer` dials again");
    // Nothing but that it is over, for longer than any wait between two tries.
    until(&watch, "frames without a connection", 6, is_disconnected);
    assert_eq!(network.made(), 1);
    let output = world.output("pilot", &["restart", "localizer"]);
    assert!(output.status.success(), "{output:?}");
    until(&watch, "poses of the next connection", 5, is_whole);
    assert_eq!(network.made(), 2);
    let asked = |line: &&String| line.starts_with("STT_TDATA");
    let sent = server.was_sent();
    let asked: Vec<&String> = sent.iter().filter(asked).collect();
    assert_eq!(asked, ["STT_TDATA 20", "STT_TDATA 20"]);
    let _ = pilot.stop();
}

/// Where a person confirms each connection, the one that shows the version is followed by the one that uses it.
#[test]
fn version_1_is_found_out_where_connections_are_confirmed() {
    let Some(server) = Server::start("stream") else { return };
    let network = Proxy::to(server.port);
    let world = World::new();
    let more = "peer = \"auto\"\nstream_ms = 20\nreconnect = \"ask\"\n";
    let (pilot, watch) = start(&world, network.port, more);
    until(&watch, "poses", 5, is_whole);
    assert_eq!(network.made(), 2);
    let _ = pilot.stop();
}

/// The program of the server, for whoever starts it otherwise.
pub(crate) fn program() -> Option<&'static Path> {
    cxx_server()
}

/// An image that is cut off is none, and the next ones are whole.
#[test]
fn images_and_poses_are_followed_through_a_network_that_fails() {
    let Some(server) = Server::start("images") else { return };
    let network = Proxy::to(server.port);
    let world = World::new();
    let (pilot, watch) = start(&world, network.port, &format!("silent_s = 1.5\n{IMAGES}"));
    until(&watch, "poses", 20, is_whole);
    let bus = bus::Bus::join(&bus::run::RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let subscriber = bus::port::UsImageSubscriber::open(&bus).unwrap();
    let images = |count: usize| {
        let mut come = 0;
        wait_for("images", || {
            watch.come().iter().for_each(check);
            while let Some(image) = subscriber.next().unwrap() {
                number_in(image.grey());
                come += 1;
            }
            (come >= count).then_some(())
        });
    };
    for fault in [
        Fault::Bytes,
        Fault::Delay(Duration::from_millis(30)),
        Fault::StallBehind(0, Duration::from_millis(300)),
    ] {
        network.set(fault);
        images(20);
    }
    // A piece may hold a pose, an image, the end of one and the beginning of the next.
    for at in (0..=4000).step_by(cut_step(400)) {
        network.set(Fault::Cut(at, is_any));
        until(&watch, "the end of a cut connection", 1, is_disconnected);
        images(2);
    }
    let _ = pilot.stop();
    let report = report(&world.path("out"));
    // A stall of 0.3 s in the middle of a busy machine's connections may look like a queue of the peer, and is told as one.
    let is_stall = |problem: &&Value| {
        problem
            .as_str()
            .is_some_and(|words| words.starts_with("poses may have been up to"))
    };
    let others: Vec<&Value> = report["problems"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|problem| !is_stall(problem))
        .collect();
    assert!(others.is_empty(), "{others:?}");
}

/// Images as the server sends them.
const IMAGES: &str = "peer = \"v1\"\n[localizer.images]\nname = \"Image\"\norientation = \"MF\"\ndepth_mm = 9\nlinear_mm = [0, 6.3, 0]\n";

/// What an image of the server holds: the number of its frame.
fn number_in(grey: &[u8]) -> u64 {
    let number = grey[..4]
        .iter()
        .rev()
        .fold(0, |number, byte| number << 8 | u64::from(*byte));
    let is_it = |at: usize| at < 4 || u64::from(grey[at]) == (number + at as u64 % 64 + 3 * (at as u64 / 64)) % 256;
    assert!((0..grey.len()).all(is_it), "an image that is turned, or of two");
    number
}

/// Images come later than the poses of their time, by the stamps of one clock.
#[test]
fn images_of_the_peer_are_published_as_they_are_with_the_time_of_the_pose_that_has_their_stamp() {
    let Some(server) = Server::start("images") else { return };
    let world = World::new();
    let (pilot, watch) = start(&world, server.port, IMAGES);
    until(&watch, "poses", 20, is_whole);
    let bus = bus::Bus::join(&bus::run::RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let subscriber = bus::port::UsImageSubscriber::open(&bus).unwrap();
    let (mut frames, mut compared) = (Vec::new(), 0);
    wait_for("60 images with the poses of their time", || {
        frames.extend(watch.come());
        while let Some(image) = subscriber.next().unwrap() {
            let (header, number) = (image.header(), number_in(image.grey()));
            assert_eq!(
                (header.device_name().as_str(), header.orientation().as_deref()),
                ("Image", Some("MF"))
            );
            let shape = header.shape().unwrap();
            assert_eq!((shape.columns(), shape.rows()), (64, 48));
            assert!(
                shape
                    .pixel_mm()
                    .iter()
                    .zip([0.1, 0.2])
                    .all(|(mm, told)| (mm - told).abs() < 1e-6)
            );
            let Some(frame) = frames
                .iter()
                .find(|frame: &&MarkerFrame| frame.t_device_ns == header.t_device_ns)
            else {
                continue;
            };
            assert_eq!(
                patient(frame).unwrap().translation_mm()[1],
                (number % 4000) as f64 / 1024.0
            );
            let is_mapped = header.capture_clock() == Some(CaptureClock::Mapped);
            if !is_mapped || frame.capture_clock() != CaptureClock::Mapped {
                continue;
            }
            // Both by one law, which has learnt from three more frames when the image comes.
            let off_ns = (header.t_capture_ns - frame.t_capture_ns).abs();
            assert!(
                off_ns <= frame.t_uncertain_ns + 100_000,
                "{off_ns} of {}",
                frame.t_uncertain_ns
            );
            // The peer sends it behind the third frame after its own, which on a busy machine follows at once: it is later by what their stamps
            // are apart, less what the law may be off.
            let later = frames.iter().filter(|f| f.t_device_ns > header.t_device_ns).nth(2);
            let Some(least_ns) = later.map(|f| f.t_device_ns - header.t_device_ns) else {
                continue;
            };
            let late_ns = header.t_arrival_ns - header.t_capture_ns;
            assert!(
                late_ns > least_ns - frame.t_uncertain_ns - 100_000,
                "{late_ns} of {least_ns} +- {}",
                frame.t_uncertain_ns
            );
            compared += 1;
        }
        (compared >= 60).then_some(())
    });
    status_says(&pilot, "images stamped");
    drop(subscriber);
    assert!(pilot.stop().success());
    let session = recorder::read::seek::Session::open(&world.path("out/session.mcap")).unwrap();
    let recorded: Vec<_> = session.us_images_from(0).unwrap().map(Result::unwrap).collect();
    assert!(recorded.len() >= 60, "{}", recorded.len());
    for pair in recorded.windows(2) {
        assert_eq!(number_in(&pair[1].grey), number_in(&pair[0].grey) + 3);
        assert_eq!(pair[1].header.seq, pair[0].header.seq + 1);
        assert_eq!(pair[0].header.orientation().as_deref(), Some("MF"));
    }
}

/// Images whose clock was set while they came, or was another one by less than 2 s, had a time by the poses' law.
#[test]
fn images_whose_clock_is_set_are_timed_by_arrival_until_it_is_known_how_and_so_is_one_too_far_off() {
    let Some(server) = Server::start("shifted") else { return };
    let world = World::new();
    let (pilot, watch) = start(&world, server.port, IMAGES);
    let bus = bus::Bus::join(&bus::run::RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let subscriber = bus::port::UsImageSubscriber::open(&bus).unwrap();
    let mut mapped = Vec::new();
    wait_for("images of the third clock", || {
        watch.come().iter().for_each(check);
        let mut last = 0;
        while let Some(image) = subscriber.next().unwrap() {
            last = number_in(image.grey());
            if image.header().capture_clock() == Some(CaptureClock::Mapped) {
                mapped.push(last);
            }
        }
        (last > 1200).then_some(())
    });
    // 100 frames a second, an image each third: two seconds until it is known how late images are, two until a step is found, and two again.
    let since = |from: u64| {
        mapped
            .iter()
            .copied()
            .filter(move |number| (from..1100).contains(number))
    };
    assert!(
        since(0).next().is_some_and(|first| (200..400).contains(&first)),
        "{mapped:?}"
    );
    let gap = mapped.windows(2).find(|pair| pair[0] >= 400 && pair[1] - pair[0] > 150);
    let [last, first] = gap.unwrap_or_else(|| panic!("{mapped:?}")) else {
        unreachable!()
    };
    assert!(*last < 700 && *first < 1100 && first - last >= 180, "{last} {first}");
    assert_eq!(mapped.iter().find(|number| **number >= 1100), None);
    status_says(&pilot, "images timed by arrival (more than 300 ms");
    let told = watch.told().join("\n");
    let by_ms = told.split_once("the clock of the images was set by ").unwrap().1;
    let by_ms: f64 = by_ms.split_once(" ms").unwrap().0.parse().unwrap();
    // What was the least lateness before it and is the least behind it are each of nine and more images, and known to half the bound.
    assert!((by_ms + 150.0).abs() < 20.0, "{by_ms}");
    assert!(
        told.contains("their clock does not keep to that of the poses"),
        "{told}"
    );
    assert!(pilot.stop().success());
}

/// PLUS sends images to whoever connects: poses go on, and what is not taken is told.
#[test]
fn images_that_the_scene_does_not_ask_for_are_told_and_leave_the_poses_alone() {
    let Some(server) = Server::start("images") else { return };
    let world = World::new();
    let (pilot, watch) = start(&world, server.port, "peer = \"v1\"\n");
    until(&watch, "poses", 60, is_whole);
    let told = watch.told().join("\n");
    assert!(
        told.contains("the peer sends images Image, which localizer.images does not name"),
        "{told}"
    );
    assert!(pilot.stop().success());
}

/// So many of the 200 poses that are sent while images are tried come meanwhile: half a second of them, where a machine is slow.
const POSES_MEANWHILE: usize = 50;

/// Another program that publishes images ended the process that brings the poses.
#[test]
fn images_that_cannot_be_published_are_told_and_leave_the_poses_alone() {
    let Some(server) = Server::start("images") else { return };
    let network = Proxy::to(server.port);
    network.set(Fault::Stall);
    let world = World::new();
    let (pilot, watch) = start(&world, network.port, IMAGES);
    let bus = bus::Bus::join(&bus::run::RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    let other = bus::port::UsImagePublisher::open(&bus, 16).unwrap();
    network.set(Fault::None);
    // While it is tried for 2 s, poses go on: 200 were sent, and of those that came before it is given up none is missing.
    let (mut numbers, mut before) = (Vec::new(), 0);
    wait_for("the end of the tries and poses after it", || {
        if before == 0
            && watch
                .told()
                .iter()
                .any(|words| words.contains("not published any more"))
        {
            before = numbers.len();
            assert!(before >= POSES_MEANWHILE, "{before} poses before images were given up");
        }
        for frame in watch.come() {
            check(&frame);
            let number = patient(&frame).map(|pose| (pose.translation_mm()[1] * 1024.0) as u64);
            numbers.extend(number);
        }
        (before > 0 && numbers.len() >= before + 60).then_some(())
    });
    let lost: u64 = numbers.windows(2).map(|pair| (pair[1] + 3999 - pair[0]) % 4000).sum();
    assert_eq!(lost, 0, "{numbers:?}");
    status_says(&pilot, "images not published");
    drop(other);
    assert!(pilot.stop().success());
}
