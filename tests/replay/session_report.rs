//! The report of a real run that was disturbed: what it says is what the run's own report, `recorder info` and the readers of others
//! say.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::support::{Pilot, SMALL, World, kill_9, python, report, stderr, stdout, wait_for};

/// A run with marks, choices, a renderer that is killed and a tracker that is stopped for a while.
fn disturbed(world: &World) -> std::path::PathBuf {
    let text = SMALL.replace("[recording]", "[recording]\nthumbnails_per_s = 5");
    let text = text.replace("stale_ms = 1000.0", "stale_ms = 200.0\nlost_ms = 600.0");
    let (scene, out) = (world.file("s.toml", &text), world.path("out"));
    let run = world.start(&scene, &out, "r");
    run.wait_live();
    ask(world, &["choose", "iliac-left"]);
    ask(world, &["mark", "first <b>biopsy</b>"]);
    let victim = run.pid("view-axial").unwrap();
    kill_9(victim);
    wait_for("another renderer", || {
        run.pid("view-axial").filter(|pid| *pid != victim)
    });
    run.wait_live();
    silence(&run);
    run.wait_live();
    ask(world, &["mark", "the end"]);
    let code = run.stop().code();
    assert_eq!(code, Some(3), "a process was killed");
    out
}

fn ask(world: &World, arguments: &[&str]) {
    let output = world.output("pilot", &[arguments, &["--run", "r"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
}

/// The tracker stands still until its views have lost the pose.
fn silence(run: &Pilot<'_>) {
    let pid = i32::try_from(run.pid("tracker").unwrap()).unwrap();
    let pid = rustix::process::Pid::from_raw(pid).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::STOP).unwrap();
    let lost = |status: &Value| {
        let views = status["views"].as_array().unwrap();
        views.iter().all(|view| view["state"] == "lost")
    };
    run.wait_for("every view lost", lost);
    rustix::process::kill_process(pid, rustix::process::Signal::CONT).unwrap();
}

/// Makes the report of a recording; its page and its facts.
fn made(world: &World, session: &Path) -> (String, Value) {
    let page = world.path("r.html");
    let (input, out) = (session.to_str().unwrap(), page.to_str().unwrap());
    let output = world.output("recorder", &["report", input, "--out", out, "--json", "--force"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let facts = fs::read(world.path("r.json")).unwrap();
    (
        fs::read_to_string(page).unwrap(),
        serde_json::from_slice(&facts).unwrap(),
    )
}

fn state_ns(facts: &Value, name: &str) -> u64 {
    let states = facts["states_ns"].as_array().unwrap();
    let found = states.iter().find(|state| state[0] == name);
    found.map_or(0, |state| state[1].as_u64().unwrap())
}

#[test]
fn a_disturbed_run_is_told_as_it_was() {
    let world = World::new();
    let out = disturbed(&world);
    let session = out.join("session.mcap");
    let (page, facts) = made(&world, &session);
    let of_run = report(&out);

    // What the run says of itself.
    assert_eq!(facts["basis"]["run"]["volume_hash"], of_run["volume"]["hash"]);
    assert_eq!(
        facts["poses"]["registrations"]["listed"][0][1],
        of_run["registration_id"]
    );
    assert_eq!(facts["story"]["restarts"]["count"], 1);
    assert_eq!(of_run["restarts"].as_array().unwrap().len(), 1);
    assert!(
        page.contains("view-axial") && page.contains("killed by signal 9"),
        "{page}"
    );
    assert!(
        page.contains("iliac-left") && page.contains("first &lt;b&gt;biopsy"),
        "{page}"
    );
    for word in ["SIMULATED TOOL", "NOT CHECKED", "RESEARCH", "PROBLEMS"] {
        assert!(page.contains(&format!("<strong>{word}</strong>")), "{word}");
    }
    // The tracker said nothing until the views had lost the pose, and that is not live.
    assert!(
        state_ns(&facts, "lost: tracker silent") > 0 || state_ns(&facts, "lost: samples missing") > 0,
        "{facts}"
    );
    assert_eq!(facts["marks"]["listed"][1]["pictures"].as_array().unwrap().len(), 3);

    // What `recorder info` says.
    let info = stdout(&world.output("recorder", &["info", session.to_str().unwrap()]));
    let row = info.lines().find(|line| line.starts_with("/tool_pose")).unwrap();
    let messages: u64 = row.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert_eq!(facts["poses"]["samples"], messages);
    let span = &facts["recording"]["span_ns"];
    let seconds = [0, 1].map(|i| format!("{:.3} s", span[i].as_f64().unwrap() / 1e9));
    assert!(
        info.contains(&format!("from {} to {} of the run", seconds[0], seconds[1])),
        "{info}"
    );

    others_agree(&world, &session);
}

/// The messages by Python's readers, and the page by two parsers of others.
#[expect(
    clippy::disallowed_methods,
    reason = "an independent reader is the point of the test"
)]
fn others_agree(world: &World, session: &Path) {
    let Some(python) = python() else { return };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_report.py");
    let files = [session.to_owned(), world.path("r.html"), world.path("r.json")];
    let output = Command::new(python)
        .arg(script)
        .args(files)
        .args(["200", "600"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn simulated_time_is_named_and_so_is_a_replay() {
    let world = World::new();
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    world.navigate(&scene, &out, &["--for", "2s", "--speed", "max"]);
    let (page, facts) = made(&world, &out.join("session.mcap"));
    assert!(page.contains("<strong>SIMULATED TIME</strong>"), "{page}");
    assert_eq!(facts["latency_ms"]["max"], 0.0);
}

#[test]
fn what_a_kill_leaves_is_no_whole_session() {
    let world = World::new();
    let (scene, out) = (world.file("s.toml", SMALL), world.path("out"));
    let run = world.start(&scene, &out, "r");
    run.wait_live();
    let growing = out.join("session.mcap.recording");
    wait_for("a chunk", || {
        fs::metadata(&growing).ok().filter(|about| about.len() > 50_000)
    });
    let cut = world.path("cut.mcap.recording");
    fs::copy(&growing, &cut).unwrap();
    drop(run);
    let (page, _) = made(&world, &cut);
    assert!(
        page.contains("<strong>INCOMPLETE</strong>") && page.contains("<strong>NO RUN REPORT</strong>"),
        "{page}"
    );
    assert!(!page.contains("was ended in an orderly way;"));
}
