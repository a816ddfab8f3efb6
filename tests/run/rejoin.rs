//! Processes that are killed while they join, several at once: nothing on the bus is left in their way.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use crate::support::nifti::{self, Nifti};
use crate::support::{Pilot, SMALL, World, all_live, kill_9, pid_in, wait_for};
use bus::Bus;
use bus::message::{Command, ToolPose};
use bus::port::{CommandClient, Subscriber, VolumeSubscriber};
use bus::run::RunContext;
use bus::topic::TOOL_POSE;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// Who is killed while it makes a service leaves one that nobody can open. That the pilot makes them all is seen by their files:
/// each is older than `run.json`, which it writes before it starts anybody.
#[test]
fn every_service_is_there_before_any_process() {
    let world = World::new();
    let scene = SMALL.replace("[recording]", "[recording]\nthumbnails_per_s = 5.0");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    pilot.wait_live();
    made_before_anybody(&world, "default");
    // A replay, with a clock and a server of its own.
    assert!(pilot.stop().success());
    let session = world.path("out/session.mcap");
    let out = world.path("again");
    let arguments = [
        "replay",
        session.to_str().unwrap(),
        "--headless",
        "--loop",
        "--run",
        "replay",
        "--out",
    ];
    let mut command = world.command("pilot");
    let child = command.args(arguments).arg(out).spawn().unwrap();
    let again = Pilot::of(&world, "replay", child);
    again.wait_for("a replayed view", |status| {
        let is_shown = |view: &Value| view["state"] == "replay";
        status["views"].as_array().unwrap().iter().any(is_shown)
    });
    made_before_anybody(&world, "replay");
    again.stop();
}

fn made_before_anybody(world: &World, run: &str) {
    let dir = world.run_dir(run);
    let made = |path: std::path::PathBuf| path.metadata().unwrap().modified().unwrap();
    let told = made(dir.join("run.json"));
    let services: Vec<_> = std::fs::read_dir(dir.join("i/services")).unwrap().flatten().collect();
    assert!(services.len() > 15, "{}", services.len());
    let late = services.iter().filter(|entry| made(entry.path()) > told).count();
    assert_eq!(late, 0, "of {}", services.len());
}

/// Once in some forty such groups processes never came back: a cleaner had been killed at its work, and nobody could ever remove
/// the dead process that it was cleaning, with the places it held.
#[test]
fn groups_killed_at_once_and_again_while_they_join_come_back() {
    kill_groups(8);
}

#[test]
#[ignore = "takes minutes: cargo test --test run rejoin -- --ignored"]
fn a_thousand_groups_come_back() {
    kill_groups(1000);
}

fn kill_groups(count: usize) {
    let world = World::new();
    let scene = SMALL.replace("[limits]", "[limits]\nrestarts = 100");
    let scene = scene.replace("restart_window_s = 3600.0", "restart_window_s = 1.0");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    pilot.wait_live();
    let mut random = 12_345_u64;
    let mut next = |below: u64| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) % below
    };
    // One that has ended by itself meanwhile is killed as well.
    let kill = |pid: u64| send(pid, Signal::KILL);
    for _ in 0..count {
        let status = pilot.wait_live();
        let names: Vec<&str> = status["processes"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|p| p["name"].as_str())
            .collect();
        let mut any = || names[next(names.len() as u64) as usize];
        for _ in 0..4 {
            pid_in(&status, any()).into_iter().for_each(kill);
        }
        // At whichever point of joining it is by now.
        let again = any();
        std::thread::sleep(std::time::Duration::from_millis(next(60)));
        pilot.pid(again).into_iter().for_each(kill);
    }
    // The last one killed may still be ending: what it leaves is removed in the next round.
    pilot.wait_for("views live and nothing left of the killed", |status| {
        all_live(status) && status["dead_processes_left"] == 0
    });
    assert_eq!(pilot.stop().code(), Some(3));
    for view in crate::support::report(&world.path("out"))["views"].as_array().unwrap() {
        assert_eq!(view["unflagged_old"], 0);
    }
}

fn send(pid: u64, signal: Signal) {
    let _ = kill_process(Pid::from_raw(i32::try_from(pid).unwrap()).unwrap(), signal);
}

/// Kills `process` and waits for the one that follows on it.
fn kill_for_another(pilot: &Pilot<'_>, process: &str) -> u64 {
    let victim = wait_for(process, || pilot.pid(process));
    kill_9(victim);
    wait_for(process, || pilot.pid(process).filter(|pid| *pid != victim))
}

/// They once waited for the loader, which reads a large examination for as long as a minute.
#[test]
fn renderers_and_trackers_that_die_while_a_loader_loads_go_on_with_the_voxels_that_others_hold() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    pilot.wait_live();
    let loader = kill_for_another(&pilot, "volume-loader");
    // Held up for longer than the test takes, and for less than it is given.
    send(loader, Signal::STOP);
    for process in ["view-axial", "tracker", "view-axial"] {
        kill_for_another(&pilot, process);
        let status = pilot.wait_live();
        assert_eq!(pid_in(&status, "volume-loader"), Some(loader));
    }
    send(loader, Signal::CONT);
    pilot.wait_for("the loader", |status| {
        let is_ready = |p: &Value| p["name"] == "volume-loader" && p["stage"] == "ready";
        status["processes"].as_array().unwrap().iter().any(is_ready) && all_live(status)
    });
    assert_eq!(pilot.stop().code(), Some(3));
    let report = crate::support::report(&world.path("out"));
    assert_eq!(
        report["restarts"].as_array().unwrap().len(),
        4,
        "{}",
        report["restarts"]
    );
    // What was handed on has been let go again.
    let ratio = report["memory"]["volume_ratio"].as_f64().unwrap();
    assert!((0.9..=1.06).contains(&ratio), "{ratio}");
    for view in report["views"].as_array().unwrap() {
        assert!(view["png"].is_string(), "{view}");
    }
}

/// A renderer that was started after the loader once showed the new patient beside views of the first one.
#[test]
fn another_examination_that_a_restarted_loader_publishes_is_shown_by_nobody() {
    let world = World::new();
    let file = world.path("patient.nii");
    let patient = |hu: u8| Vec::from(Nifti::header().with((0..nifti::VOXELS).flat_map(|_| [hu, 0])));
    std::fs::write(&file, patient(40)).unwrap();
    let scene = SMALL.replace("source = \"phantom\"\nspacing_mm = 6.0", "source = \"patient.nii\"");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    pilot.wait_live();
    std::fs::write(&file, patient(90)).unwrap();
    kill_for_another(&pilot, "volume-loader");
    pilot.wait_for("the loader", |status| {
        let is_ready = |p: &Value| p["name"] == "volume-loader" && p["stage"] == "ready";
        status["processes"].as_array().unwrap().iter().any(is_ready)
    });
    for process in ["view-axial", "recorder"] {
        kill_for_another(&pilot, process);
        pilot.wait_live();
    }
    assert_eq!(pilot.stop().code(), Some(3));
    let report = crate::support::report(&world.path("out"));
    let session = world.path("out/session.mcap");
    let facts = world.output("recorder", &["facts", session.to_str().unwrap()]);
    let facts: Value = serde_json::from_slice(&facts.stdout).unwrap();
    assert_eq!(facts["volume_hash"], report["volume"]["hash"]);
    let problems = report["problems"].to_string();
    assert!(problems.contains("two different examinations"), "{problems}");
    let hashes: Vec<String> = report["views"]
        .as_array()
        .unwrap()
        .iter()
        .map(|view| {
            let png = world.path("out").join(view["png"].as_str().unwrap());
            crate::support::png_texts(&png)["volume_hash"].clone()
        })
        .collect();
    assert_eq!(hashes.len(), 3, "{hashes:?}");
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    assert_eq!(report["volume"]["hash"], hashes[0].as_str());
}

fn context(world: &World) -> RunContext {
    RunContext::load(&world.run_dir("default")).unwrap()
}

/// Opens ports until one is refused: those, and the words of the refusal.
fn all_places<P>(mut open: impl FnMut() -> Result<P, bus::BusError>) -> (Vec<P>, String) {
    let mut ports = Vec::new();
    loop {
        match open() {
            Ok(port) => ports.push(port),
            Err(error) => return (ports, error.to_string()),
        }
    }
}

/// Two dozen clients that asked nothing once kept `pilot status` and `pilot stop` out, and nobody said who they were.
#[test]
fn clients_that_hold_every_place_of_theirs_are_named_and_leave_some_to_the_pilots_commands() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    pilot.wait_live();
    let bus = Bus::join(&context(&world)).unwrap();
    let (clients, refused) = all_places(|| CommandClient::open(&bus, "pilot"));
    let crowd = format!(
        "{0} of 24 places of \"command/pilot\" are taken, {0} by process {1} (",
        clients.len(),
        std::process::id()
    );
    assert!(refused.contains(&crowd), "{refused}");
    assert!(
        refused.ends_with("the last 8 are kept for the run's own processes"),
        "{refused}"
    );
    let status = world.output("pilot", &["status"]);
    assert!(status.status.success(), "{status:?}");
    assert!(pilot.stop().success());
    drop(clients);
}

/// Programs that do not keep to that may still take all.
#[test]
fn clients_that_hold_every_place_are_named_and_the_run_can_be_stopped() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    pilot.wait_live();
    let bus = Bus::operate(&context(&world)).unwrap();
    let (clients, refused) = all_places(|| CommandClient::open(&bus, "pilot"));
    let holder = format!("{} by process {} (", clients.len(), std::process::id());
    let crowd = |text: &str| text.contains("24 of 24 places of \"command/pilot\" are taken") && text.contains(&holder);
    assert!(crowd(&refused), "{refused}");
    let status = world.output("pilot", &["status"]);
    assert!(
        !status.status.success() && crowd(&crate::support::stderr(&status)),
        "{status:?}"
    );
    // `pilot stop` says so too, and stops.
    assert_eq!(pilot.stop().code(), Some(3));
    let problems = crate::support::report(&world.path("out"))["problems"].to_string();
    assert!(crowd(&problems.replace("\\\"", "\"")), "{problems}");
}

/// Readers that held all places of a topic that every renderer reads once kept one down that had been killed.
#[test]
fn a_killed_renderer_comes_back_while_readers_hold_every_place_of_theirs() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    let first = pid_in(&pilot.wait_live(), "view-axial").unwrap();
    let bus = Bus::join(&context(&world)).unwrap();
    let poses = all_places(|| Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 1));
    let woken = all_places(|| Subscriber::<ToolPose>::open_waking(&bus, &TOOL_POSE, "", 1));
    let volumes = all_places(|| VolumeSubscriber::open(&bus));
    let requests = all_places(|| CommandClient::open(&bus, "view-axial"));
    for refused in [&poses.1, &woken.1, &volumes.1, &requests.1] {
        assert!(refused.contains("are kept for the run's own processes"), "{refused}");
    }
    kill_9(first);
    pilot.wait_for("the view again, drawn by another process", |status| {
        all_live(status) && pid_in(status, "view-axial").is_some_and(|pid| pid != first)
    });
    drop((poses, woken, volumes, requests));
    pilot.stop();
}

/// The same of programs that take all: who is killed then cannot come back, and says who is in its way.
#[test]
fn readers_that_hold_every_place_are_named() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    pilot.wait_live();
    let bus = Bus::operate(&context(&world)).unwrap();
    let (readers, refused) = all_places(|| Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 1));
    let holder = format!(
        "24 of 24 places of \"tool-pose\" are taken, {} by process {} (",
        readers.len(),
        std::process::id()
    );
    assert!(refused.contains(&holder), "{refused}");
    drop(readers);
    assert_eq!(pilot.stop().code(), Some(3));
}

/// Each request for an image was answered before the poses that had come meanwhile.
#[test]
fn clients_that_ask_for_images_again_and_again_leave_the_views_live() {
    const CLIENTS: usize = 8;
    const LOOKS: usize = 20;
    let world = World::new();
    // Images that take longer than a client to ask for the next.
    let scene = SMALL.replace("size = [128, 128]", "size = [1024, 1024]");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    pilot.wait_live();
    let (ended, answers) = (AtomicBool::new(false), AtomicU64::new(0));
    std::thread::scope(|scope| {
        for _ in 0..CLIENTS {
            scope.spawn(|| {
                let bus = Bus::join(&context(&world)).unwrap();
                let client = CommandClient::open(&bus, "view-axial").unwrap();
                let newest = Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 1).unwrap();
                let pose = wait_for("a pose", || newest.newest().unwrap());
                while !ended.load(Ordering::Relaxed) {
                    let answered = client.ask(Command::render(pose), Duration::from_secs(1)).is_ok();
                    answers.fetch_add(u64::from(answered), Ordering::Relaxed);
                }
            });
        }
        wait_for("answers", || (answers.load(Ordering::Relaxed) > 20).then_some(()));
        let live = (0..LOOKS).filter(|_| pilot.status().is_some_and(|status| all_live(&status)));
        let live = live.count();
        ended.store(true, Ordering::Relaxed);
        assert_eq!(live, LOOKS, "{answers:?} images");
    });
    pilot.stop();
    for view in crate::support::report(&world.path("out"))["views"].as_array().unwrap() {
        assert_eq!(view["unflagged_old"], 0);
    }
}
