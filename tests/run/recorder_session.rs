//! A whole session in its recording: what the pilot adds, and what the tools make of it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{SMALL, World, stderr, stdout};
use bus::message::Workflow;
use recorder::read::info;
use recorder::read::seek::Session;
use recorder::wire::schema::{GUIDE, LOG, STATUS, TF, TOOL_POSE, WORKFLOW};

/// A session of a second, with small images.
fn session(world: &World) -> PathBuf {
    let scene = SMALL.replace(
        "[recording]",
        "[guide]\ntarget = \"iliac-left\"\n[recording]\ncompression = \"lz4\"\nthumbnails_per_s = 4.0",
    );
    let scene = world.file("scene.toml", &scene);
    let out = world.path("out");
    world.navigate(&scene, &out, &["--for", "1s"]);
    out.join("session.mcap")
}

fn recorder(world: &World, arguments: &[&str]) -> String {
    let output = world.output("recorder", arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

/// When each message of a topic was captured, ns.
fn captured(path: &Path, topic: &str) -> Vec<u64> {
    let items = recorder::read::scan::open(path).unwrap().filter_map(Result::ok);
    let times = items.filter_map(|item| match item {
        recorder::read::scan::Item::Message(message) if message.channel.topic == topic => Some(message.log_time),
        _ => None,
    });
    times.collect()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_session_has_its_report_its_log_and_small_images() {
    let world = World::new();
    let path = session(&world);
    let found = info::info(&path).unwrap();
    assert!(found.damage.is_empty(), "{:?}", found.damage);
    for view in ["axial-global", "frontal-local", "perpendicular"] {
        // At most four a second, for as long as the run lives, and one second more for how late a busy machine draws.
        let times = captured(&path, &format!("/view/{view}"));
        let span_s = (times.iter().max().unwrap() - times.iter().min().unwrap()) as f64 * 1e-9;
        assert!(
            times.len() as f64 <= 4.0 * (span_s + 1.0) + 1.0,
            "{view}: {} in {span_s} s",
            times.len()
        );
    }
    // Loader, tracker and three renderers are ready at least once each.
    assert!(
        found.tally.topics[STATUS].messages >= 5,
        "{}",
        found.tally.topics[STATUS].messages
    );
    let session = Session::open(&path).unwrap();
    let report = session.attachment("report.json").unwrap().unwrap();
    assert_eq!(report, fs::read(path.with_file_name("report.json")).unwrap());
    let log = world.path("log.csv");
    recorder(
        &world,
        &["export", "csv", text(&path), "--topic", LOG, "--out", text(&log)],
    );
    let log = fs::read_to_string(log).unwrap();
    for words in [
        "everybody ready",
        // From the first one on; a busy machine may begin with a later one.
        " on: tracked",
        "ending: the pictures show pose 59",
    ] {
        assert!(log.contains(words), "{words:?} in\n{log}");
    }
    assert!(recorder(&world, &["verify", text(&path)]).contains(": whole; "));
}

#[test]
fn the_tools_agree_with_one_another() {
    let world = World::new();
    let path = session(&world);
    let shown = recorder(&world, &["info", text(&path)]);
    for words in [
        "capture to capture",
        "capture to publication",
        "attachment report.json",
        "The file is whole.",
    ] {
        assert!(shown.contains(words), "{words:?} in\n{shown}");
    }
    let (part, mha, back) = (world.path("part.mcap"), world.path("part.mha"), world.path("back.mcap"));
    let poses = |path: &Path| {
        recorder::read::reader::poses(path, TOOL_POSE)
            .unwrap()
            .map(Result::unwrap)
            .collect::<Vec<_>>()
    };
    let all = poses(&path);
    let (first, last) = (all.len() / 6, 2 * all.len() / 3);
    let (from, to) = (all[first].t_capture_ns, all[last].t_capture_ns);
    let [from, to] = [from, to].map(|ns| format!("{}ms", ns as f64 / 1e6));
    recorder(
        &world,
        &["cut", text(&path), "--from", &from, "--to", &to, "--out", text(&part)],
    );
    assert_eq!(poses(&part), all[first..=last]);
    assert!(info::info(&part).unwrap().tally.topics[TF].messages > 0);
    recorder(&world, &["export", "mha", text(&part), "--out", text(&mha)]);
    recorder(&world, &["import", text(&mha), "--out", text(&back)]);
    let count = last - first + 1;
    assert_eq!(poses(&back).len(), count);
    let Some(python) = crate::support::python() else { return };
    let script = format!(
        "import sys, SimpleITK as s; r = s.ImageFileReader(); r.SetFileName(sys.argv[1]); i = r.Execute(); \
         print(i.GetSize(), r.GetMetaData('Seq_Frame{:04}_ToolToCtTransformStatus'))",
        last - first
    );
    #[expect(
        clippy::disallowed_methods,
        reason = "an independent reader is the point of the test"
    )]
    let read = Command::new(python).args(["-c", &script, text(&mha)]).output().unwrap();
    assert_eq!(stdout(&read).trim(), format!("(1, 1, {count}) OK"), "{}", stderr(&read));
}

#[test]
fn python_reads_a_whole_session_and_foxgloves_messages_are_as_foxglove_publishes_them() {
    let Some(python) = crate::support::python() else { return };
    let world = World::new();
    let path = session(&world);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_mcap.py");
    #[expect(
        clippy::disallowed_methods,
        reason = "an independent reader is the point of the test"
    )]
    let read = Command::new(python).arg(script).arg(&path).output().unwrap();
    assert!(read.status.success(), "{}", stderr(&read));
    let seen: serde_json::Value = serde_json::from_slice(&read.stdout).unwrap();
    let all = ["foxglove.CompressedImage", "foxglove.FrameTransform", "foxglove.Log"];
    assert_eq!(
        seen["foxglove"],
        serde_json::json!(all.map(|name| (name, true)).into_iter().collect::<BTreeMap<_, _>>())
    );
    let counts = info::info(&path).unwrap().tally;
    for (topic, found) in &counts.topics {
        assert_eq!(seen["counts"][topic].as_u64().unwrap_or(0), found.messages, "{topic}");
    }
    let guide = recorder::read::reader::guides(&path).unwrap().next().unwrap().unwrap();
    let bits = |mm: [f64; 3]| mm.map(|mm| format!("{:016x}", mm.to_bits()));
    let read = &seen["first"][GUIDE];
    assert_eq!(
        read["name"],
        "iliac-left"
            .bytes()
            .map(|byte| format!("{byte:02x}"))
            .collect::<String>()
    );
    assert_eq!(read["target_mm"], serde_json::json!(bits(guide.target_mm)));
    assert_eq!(read["plan_id"], guide.plan_id);
    let flags = seen["first"][WORKFLOW]["flags"].as_u64().unwrap() as u32;
    assert_eq!(flags & Workflow::RESEARCH, Workflow::RESEARCH);
    // PNGs by their first bytes, and every byte of what is attached.
    assert_eq!(seen["first"]["/view/perpendicular"]["head"], "89504e470d0a1a0a");
    for name in ["scene.toml", "report.json"] {
        let attached = Session::open(&path).unwrap().attachment(name).unwrap().unwrap();
        assert_eq!(seen["attachments"][name], text_of(attached), "{name}");
    }
    let records: Vec<&str> = seen["metadata"]
        .as_array()
        .unwrap()
        .iter()
        .map(|m| m["record"].as_str().unwrap())
        .collect();
    assert!(records.contains(&"run") && records.contains(&"recorder"), "{records:?}");
    let run = &seen["metadata"]
        .as_array()
        .unwrap()
        .iter()
        .rfind(|m| m["record"] == "run")
        .unwrap()["facts"];
    let hash = crate::support::report(&world.path("out"))["volume"]["hash"].clone();
    assert_eq!(run["volume_hash"], hash);
}

fn text_of(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

#[test]
fn sequences_of_the_plus_toolkit_are_imported() {
    let Some(folder) = crate::support::shared("data/tracker-plus") else {
        return;
    };
    let world = World::new();
    for (file, transform, frames) in [
        ("TransformInterpolationTest.igs.mha", "ProbeToTracker", 500),
        (
            "WaterTankBottomTranslationTrackerBuffer-trimmed.igs.mha",
            "ProbeToTracker",
            0,
        ),
    ] {
        let out = world.path(&format!("{frames}.mcap"));
        let input = folder.join(file);
        let said = recorder(
            &world,
            &["import", text(&input), "--transform", transform, "--out", text(&out)],
        );
        let found = info::info(&out).unwrap().tally.topics[TOOL_POSE].messages;
        assert!(found >= frames && found > 100, "{file}: {said}");
        assert!(recorder(&world, &["verify", text(&out)]).contains(": whole; "));
    }
}
