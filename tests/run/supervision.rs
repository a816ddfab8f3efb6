//! Any process may be killed at any time: the others go on, it comes back, and in between nothing old looks live.

use crate::support::{Pilot, SMALL, World, is_alive, kill_9, pid_in, wait_for};
use serde_json::Value;

fn view_state(status: &Value, view: &str) -> String {
    let views = status["views"].as_array().unwrap();
    let view = views.iter().find(|v| v["name"] == view).unwrap();
    view["state"].as_str().unwrap().to_owned()
}

fn start(world: &World) -> Pilot<'_> {
    start_of(world, SMALL)
}

fn start_of<'a>(world: &'a World, scene: &str) -> Pilot<'a> {
    let scene = world.file("s.toml", scene);
    let pilot = world.start(&scene, &world.path("out"), "default");
    pilot.wait_live();
    pilot
}

/// Kills `process` in a world of its own; waits until it runs again with everything live, and returns the report of the whole run.
fn kill_and_return(process: &str) -> Value {
    kill_and_return_in(&World::new(), process)
}

fn kill_and_return_in(world: &World, process: &str) -> Value {
    let pilot = start(world);
    let before = pilot.wait_live();
    let victim = pid_in(&before, process).unwrap();
    kill_9(victim);
    pilot.wait_for("the process to come back", |status| {
        let ready = |p: &Value| {
            p["name"] == process && p["stage"] == "ready" && p["pid"].as_u64().is_some_and(|pid| pid != victim)
        };
        status["processes"].as_array().unwrap().iter().any(ready) && crate::support::all_live(status)
    });
    let after = wait_for("the status", || pilot.status());
    for other in before["processes"].as_array().unwrap() {
        let name = other["name"].as_str().unwrap();
        if name != process {
            assert_eq!(pid_in(&after, name), other["pid"].as_u64(), "{name} went on");
        }
    }
    let ended = pilot.stop();
    let report = crate::support::report(&world.path("out"));
    // A death is a problem of the run, and so is what a killed recorder had not written yet.
    let lacks = lacking(world, &report);
    let problems: Vec<&str> = report["problems"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let died = format!("{process} ended once before the run did, last at ");
    let lacking = format!(
        "the recording lacks {lacks} of the {} samples that went out",
        report["poses"]["published"]
    );
    assert_eq!(
        problems.iter().filter(|p| p.starts_with(&died)).count(),
        1,
        "{problems:?}"
    );
    assert_eq!(problems.len(), 1 + usize::from(lacks > 0), "{problems:?}");
    assert_eq!(problems.contains(&lacking.as_str()), lacks > 0, "{problems:?}");
    assert_eq!(ended.code(), Some(3));
    assert!(lacks == 0 || process == "recorder", "{lacks}");
    report
}

/// How many of the samples that went out are in no file of the session.
fn lacking(world: &World, report: &Value) -> u64 {
    let files = report["recording"].as_array().unwrap().iter();
    let count = |name: &Value| {
        let file = world.path("out").join(name.as_str().unwrap());
        recorder::read::reader::poses(&file, recorder::wire::schema::TOOL_POSE)
            .unwrap()
            .filter(Result::is_ok)
            .count() as u64
    };
    report["poses"]["published"].as_u64().unwrap() - files.map(count).sum::<u64>()
}

fn check_restart(report: &Value, process: &str) {
    let restarts = report["restarts"].as_array().unwrap();
    assert_eq!(restarts.len(), 1, "{restarts:?}");
    assert_eq!(restarts[0]["process"], process);
    assert_eq!(restarts[0]["cause"], "killed by signal 9");
    // How long it took is in the report; a test on a busy machine only asks that it came back.
    assert!(
        restarts[0]["live_again_s"].as_f64().is_some_and(|s| s > 0.0),
        "{restarts:?}"
    );
    for view in report["views"].as_array().unwrap() {
        assert_eq!(view["unflagged_old"], 0);
        assert!(view["png"].is_string());
    }
}

/// Each client that came and went once cost the pilot so long that it killed its processes for a silence of its own.
#[test]
fn a_burst_of_clients_does_not_hold_up_the_pilot() {
    const CLIENTS: usize = 8;
    let world = World::new();
    let pilot = start(&world);
    std::thread::scope(|scope| {
        for _ in 0..CLIENTS {
            scope.spawn(|| {
                for _ in 0..12 {
                    pilot.status();
                }
            });
        }
    });
    pilot.wait_live();
    assert!(pilot.stop().success());
    let report = crate::support::report(&world.path("out"));
    assert_eq!(report["restarts"], serde_json::json!([]));
}

#[test]
fn a_killed_renderer_comes_back() {
    check_restart(&kill_and_return("view-axial"), "view-axial");
}

#[test]
fn a_killed_tracker_comes_back_and_the_samples_go_on_counting() {
    let world = World::new();
    let report = kill_and_return_in(&world, "tracker");
    check_restart(&report, "tracker");
    let recording = world.path("out/session.mcap");
    let poses = recorder::read::reader::poses(&recording, recorder::wire::schema::TOOL_POSE).unwrap();
    let seqs: Vec<u64> = poses.map(|pose| pose.unwrap().seq).collect();
    assert!(
        seqs.windows(2).all(|pair| pair[0] < pair[1]),
        "no sample came twice or late: {seqs:?}"
    );
    let missing = seqs.last().unwrap() - seqs[0] + 1 - seqs.len() as u64;
    assert_eq!(report["poses"]["missing"], missing);
    // The small scene allows any number of them: they are no problem, and not kept to themselves.
    assert!(missing > 0, "{report}");
    let note = report["notes"][0].as_str().unwrap();
    assert!(note.starts_with(&format!("{missing} of ")), "{note}");
}

#[test]
fn a_killed_loader_comes_back_and_the_volume_is_held_once_again() {
    let report = kill_and_return("volume-loader");
    check_restart(&report, "volume-loader");
    let ratio = report["memory"]["volume_ratio"].as_f64().unwrap();
    assert!((0.9..=1.06).contains(&ratio), "{ratio}");
}

#[test]
fn a_killed_recorder_comes_back_and_keeps_what_it_wrote() {
    let report = kill_and_return("recorder");
    check_restart(&report, "recorder");
    let recordings: Vec<_> = report["recording"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| r.as_str().unwrap())
        .collect();
    assert!(recordings.len() >= 2, "{recordings:?}");
    assert!(recordings.iter().all(|r| r.ends_with(".mcap")), "{recordings:?}");
}

#[test]
fn while_a_renderer_is_away_its_views_are_marked() {
    let world = World::new();
    // A silence that a busy machine does not make, and that the test waits for.
    let pilot = start_of(&world, &SMALL.replace("silent_s = 30.0", "silent_s = 8.0"));
    let renderer = wait_for("the renderer", || pilot.pid("view-frontal"));
    // Stopped, not killed: it is away for as long as we look.
    let pid = rustix::process::Pid::from_raw(i32::try_from(renderer).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::STOP).unwrap();
    // While the other one goes on.
    let status = pilot.wait_for("the view to be marked", |s| {
        view_state(s, "frontal-local") != "live" && view_state(s, "axial-global") == "live"
    });
    assert!(matches!(
        view_state(&status, "frontal-local").as_str(),
        "stale" | "down"
    ));
    // It gives no sign of life: it is killed and started again.
    let back = wait_for("another renderer", || {
        pilot.pid("view-frontal").filter(|&pid| pid != renderer)
    });
    pilot.wait_live();
    assert_ne!(back, renderer);
    assert_eq!(pilot.stop().code(), Some(3));
    let report = crate::support::report(&world.path("out"));
    assert_eq!(report["restarts"][0]["cause"], "gave no sign of life");
}

#[test]
fn without_a_tracker_the_views_say_that_they_are_old() {
    let world = World::new();
    let pilot = start(&world);
    let tracker = wait_for("the tracker", || pilot.pid("tracker"));
    let pid = rustix::process::Pid::from_raw(i32::try_from(tracker).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::STOP).unwrap();
    pilot.wait_for("every view to be stale", |status| {
        status["views"]
            .as_array()
            .unwrap()
            .iter()
            .all(|v| v["state"] == "stale")
    });
    rustix::process::kill_process(pid, rustix::process::Signal::CONT).unwrap();
    pilot.wait_live();
    assert!(pilot.stop().success());
}

/// They were counted, and the run ended as one that went as it should.
#[test]
fn samples_that_a_tracker_left_out_are_a_problem() {
    let world = World::new();
    let pilot = start_of(
        &world,
        &SMALL.replace("max_missing_share = 1.0", "max_missing_share = 0.01"),
    );
    let tracker = wait_for("the tracker", || pilot.pid("tracker"));
    let pid = rustix::process::Pid::from_raw(i32::try_from(tracker).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::STOP).unwrap();
    // Older than a second, of which it makes up half when it goes on.
    pilot.wait_for("an old view", |status| view_state(status, "axial-global") == "stale");
    rustix::process::kill_process(pid, rustix::process::Signal::CONT).unwrap();
    pilot.wait_live();
    assert_eq!(pilot.stop().code(), Some(3));
    let report = crate::support::report(&world.path("out"));
    let problems = report["problems"].to_string();
    let missing = report["poses"]["missing"].as_u64().unwrap();
    assert!(
        missing > 10 && problems.contains(&format!("{missing} of ")),
        "{problems}"
    );
    assert!(problems.contains("samples are missing"), "{problems}");
}

/// The report cannot be written; who looks at the terminal is told how the run went all the same.
#[test]
fn a_run_whose_output_folder_has_gone_says_how_it_went() {
    let world = World::new();
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    let mut command = world.command("pilot");
    let child = command
        .args(["run", "--headless", "--run", "default", "--out"])
        .args([&out, &scene])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut pilot = Pilot::of(&world, "default", child);
    pilot.wait_live();
    let mut terminal = pilot.child.stdout.take().unwrap();
    std::fs::remove_dir_all(&out).unwrap();
    assert_eq!(pilot.stop().code(), Some(3));
    let mut said = String::new();
    std::io::Read::read_to_string(&mut terminal, &mut said).unwrap();
    assert!(
        said.contains("poses published") && said.contains("report.json: No such file"),
        "{said}"
    );
}

#[test]
fn no_orphan_outlives_a_killed_pilot_and_the_next_run_starts_cleanly() {
    let world = World::new();
    let mut pilot = start(&world);
    let status = wait_for("the status", || pilot.status());
    let children: Vec<u64> = status["processes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|p| p["pid"].as_u64())
        .collect();
    assert_eq!(children.len(), 6);
    kill_9(u64::from(pilot.child.id()));
    pilot.child.wait().unwrap();
    wait_for("the children to die with the pilot", || {
        (!children.iter().any(|&pid| is_alive(pid))).then_some(())
    });
    drop(pilot);
    let again = world.navigate(&world.path("s.toml"), &world.path("out2"), &["--for", "500ms"]);
    assert!(again["problems"].as_array().unwrap().is_empty(), "{again}");
}

/// The report said that a disk held up the recorder, which had gone on: it was the pilot that had been stopped.
#[test]
fn a_pilot_that_was_stopped_says_so_and_blames_nobody() {
    let world = World::new();
    let pilot = start_of(&world, &SMALL.replace("silent_s = 30.0", "silent_s = 3.0"));
    pilot.wait_live();
    let pid = rustix::process::Pid::from_child(&pilot.child);
    let signal = |signal| rustix::process::kill_process(pid, signal).unwrap();
    signal(rustix::process::Signal::STOP);
    std::thread::sleep(std::time::Duration::from_secs(5));
    signal(rustix::process::Signal::CONT);
    pilot.wait_live();
    assert_eq!(pilot.stop().code(), Some(3));
    let problems = crate::support::report(&world.path("out"))["problems"].to_string();
    assert!(problems.contains("the pilot stood still for"), "{problems}");
    assert!(!problems.contains("the recorder's work"), "{problems}");
}

#[test]
fn a_crash_loop_is_held_and_the_rest_goes_on() {
    let world = World::new();
    let scene = world.file("s.toml", &SMALL.replace("[limits]", "[limits]\nrestarts = 2"));
    let pilot = world.start(&scene, &world.path("out"), "default");
    pilot.wait_live();
    for _ in 0..3 {
        let pid = wait_for("the renderer to run", || pilot.pid("view-axial"));
        kill_9(pid);
        wait_for("its end to be noticed", || {
            (pilot.pid("view-axial") != Some(pid)).then_some(())
        });
    }
    let status = pilot.wait_held("view-axial", |s| view_state(s, "frontal-local") == "live");
    assert_eq!(view_state(&status, "axial-global"), "down");
    let held = status["processes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|p| p["name"] == "view-axial");
    assert_eq!(held.unwrap()["endings"], 3);
    assert!(
        held.unwrap()["last_ending"]
            .as_str()
            .unwrap()
            .ends_with("killed by signal 9")
    );
    assert_eq!(pilot.stop().code(), Some(3));
    let report = crate::support::report(&world.path("out"));
    assert_eq!(report["held"], serde_json::json!(["view-axial"]));
    assert!(report["views"][0]["png"].is_null());
    assert!(report["views"][1]["png"].is_string());
    assert!(!world.path("out/axial-global.png").exists());
}

#[test]
fn a_held_process_is_brought_back_by_name() {
    let world = World::new();
    let scene = world.file("s.toml", &SMALL.replace("[limits]", "[limits]\nrestarts = 1"));
    let pilot = world.start(&scene, &world.path("out"), "default");
    pilot.wait_live();
    let restart = |name: &str| world.output("pilot", &["restart", name]);
    let words = |output: &std::process::Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let refused = restart("view-axial");
    assert!(
        words(&refused).contains("view-axial is ready: only a process"),
        "{}",
        words(&refused)
    );
    let unknown = restart("axial");
    assert!(
        words(&unknown).contains("it has volume-loader, view-axial"),
        "{}",
        words(&unknown)
    );
    // The tracker too: that it was given up is told to the views, and its poses are shown again when it is back.
    for name in ["view-axial", "tracker"] {
        for _ in 0..2 {
            let victim = wait_for("it to run", || pilot.pid(name));
            kill_9(victim);
            wait_for("its end to be noticed", || {
                (pilot.pid(name) != Some(victim)).then_some(())
            });
        }
        pilot.wait_held(name, |_| true);
        assert!(restart(name).status.success());
        pilot.wait_live();
    }
    assert_eq!(pilot.stop().code(), Some(3));
    assert_eq!(
        crate::support::report(&world.path("out"))["held"],
        serde_json::json!([])
    );
}
