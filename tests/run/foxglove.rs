//! `recorder serve --foxglove`, looked at by a client of other software.

#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]
#![allow(clippy::print_stdout, reason = "what was seen")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::support::{SMALL, World, kill_9, python, stderr, stdout, wait_for};
use serde_json::Value;

struct Served(Child, String);

impl Served {
    fn start(world: &World) -> Self {
        let mut command = world.command("recorder");
        command.args(["serve", "--foxglove", "--listen", "127.0.0.1:0", "--every", "50ms"]);
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let said = lines.next().unwrap().unwrap();
        let port = said
            .split("ws://127.0.0.1:")
            .nth(1)
            .and_then(|rest| rest.split(';').next());
        let port = port.unwrap_or_else(|| panic!("{said}")).to_owned();
        assert!(said.contains("RESEARCH DISPLAY"), "{said}");
        Self(child, port)
    }

    fn look(&self, python: &Path, seconds: &str) -> Value {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_foxglove.py");
        let output = Command::new(python)
            .arg(script)
            .args([&self.1, seconds])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        println!("{}", stdout(&output));
        serde_json::from_str(&stdout(&output)).unwrap()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_run_is_seen_in_foxglove_and_a_pose_that_is_lost_is_taken_away() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    let scene = format!("{SMALL}\n[[targets]]\nname = \"node\"\nct_mm = [10, 20, 30]\n");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    pilot.wait_live();
    let mut served = Served::start(&world);
    // Longer than between two notices and two rounds of what comes late is told.
    let seen = served.look(&python, "6");
    assert!(seen["name"].as_str().unwrap().contains("RESEARCH DISPLAY"), "{seen}");
    let topics = seen["topics"].as_object().unwrap();
    let count = |topic: &str| topics.get(topic).and_then(Value::as_u64).unwrap_or(0);
    for topic in ["/tf", "/scene", "/log", "/status", "/workflow"] {
        assert!(count(topic) > 0, "{topic}: {seen}");
    }
    // Whose examination it is, and what few may listen to, is nobody's.
    assert!(
        !topics
            .keys()
            .any(|topic| topic.contains("identity") || topic.contains("emitters")),
        "{seen}"
    );
    assert!(seen["scene"].as_array().unwrap().contains(&"tool".into()), "{seen}");
    // Both are the pose's own doubles, but for the division by 1000.
    assert!(seen["off_mm"].as_f64().unwrap() < 1e-9, "{seen}");
    let node: Vec<f64> = serde_json::from_value(seen["targets"]["node"].clone()).unwrap();
    assert!(
        node.iter()
            .zip([10.0, 20.0, 30.0])
            .all(|(found, mm)| (found - mm).abs() < 1e-9),
        "{seen}"
    );
    assert!(!seen["images"].as_object().unwrap().is_empty(), "{seen}");
    let notice = seen["notice"].as_str().unwrap();
    assert!(notice.starts_with("RESEARCH DISPLAY "), "{seen}");
    assert!(notice.contains("SIMULATED TRACKER"), "{seen}");
    assert_eq!(seen["hangs_on"], "ct", "{seen}");
    let log = seen["log"].as_array().unwrap();
    assert!(
        log.iter()
            .any(|line| line.as_str().unwrap().contains("RESEARCH DISPLAY")),
        "{seen}"
    );
    // A tracker that ends again and again is held: there is no pose any more, and none comes back.
    wait_for("a tracker that is held", || {
        pilot.pid("tracker").into_iter().for_each(kill_9);
        let status = pilot.status()?;
        let is_held = |process: &Value| process["name"] == "tracker" && process["stage"] == "held";
        let is_lost = |view: &Value| view["state"] == "lost";
        let (processes, views) = (status["processes"].as_array()?, status["views"].as_array()?);
        (processes.iter().any(is_held) && views.iter().all(is_lost)).then_some(())
    });
    let seen = served.look(&python, "1");
    assert!(seen["deleted"].as_array().unwrap().contains(&"tool".into()), "{seen}");
    assert!(seen["notice"].as_str().unwrap().contains("NO POSE"), "{seen}");
    // Who comes late too is told that the tool is nowhere.
    assert_eq!(seen["hangs_on"], "NO POSE", "{seen}");
    // Images go on where the examination is not the patient's; here as in the window nothing of the tool is shown by them.
    for arguments in [&["restart", "tracker"][..], &["reject"]] {
        let said = world.output("pilot", arguments);
        assert!(said.status.success(), "{}", stderr(&said));
        pilot.wait_live();
    }
    let seen = served.look(&python, "1");
    let notice = seen["notice"].as_str().unwrap();
    assert!(notice.contains("WITHHELD: the examination is said not to be"), "{seen}");
    assert!(seen["deleted"].as_array().unwrap().contains(&"tool".into()), "{seen}");
    assert_eq!(seen["hangs_on"], "NO POSE", "{seen}");
    pilot.stop();
    let ended = wait_for("the server to end with its run", || served.0.try_wait().unwrap());
    assert!(ended.success(), "{ended}");
}

#[test]
fn nobody_else_is_served_and_there_must_be_a_run() {
    let world = World::new();
    let refused = |arguments: &[&str]| {
        let output = world.output("recorder", &[&["serve", "--foxglove"], arguments].concat());
        assert_eq!(output.status.code(), Some(1), "{}", stdout(&output));
        stderr(&output)
    };
    for address in ["0.0.0.0:8765", "192.0.2.1:8765", "[::]:8765"] {
        let said = refused(&["--listen", address]);
        assert!(said.contains("only this machine's own addresses"), "{said}");
    }
    let said = refused(&[]);
    assert!(said.contains("default"), "{said}");
}
