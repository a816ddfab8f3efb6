//! A run's recording ends with the run: the last pictures of its replay are the run's own, the contact sheet too.

use std::path::Path;

use crate::support::{SMALL, World, pictures, stderr, stdout};
use bus::message::ToolPose;
use recorder::read::reader;
use recorder::wire::schema::TOOL_POSE;

fn poses(out: &Path) -> Vec<ToolPose> {
    let poses = reader::poses(&out.join("session.mcap"), TOOL_POSE).unwrap();
    poses.map(Result::unwrap).collect()
}

/// Replays the run in `out`, and compares every picture at its end.
fn ends_alike(world: &World, out: &Path, what: &str) {
    let again = out.with_extension("again");
    let session = out.join("session.mcap");
    let arguments = ["--headless", "--speed", "max", "--out"].map(str::to_owned);
    let mut all = vec!["replay".to_owned(), session.display().to_string()];
    all.extend(arguments);
    all.push(again.display().to_string());
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let output = world.output("pilot", &all);
    assert!(
        output.status.success(),
        "{what}: {}{}",
        stdout(&output),
        stderr(&output)
    );
    let (run, replay) = (pictures(out), pictures(&again));
    assert!(
        run.contains_key("sheet.png") && run.len() == 4,
        "{what}: {:?}",
        run.keys()
    );
    let other: Vec<&String> = run.keys().filter(|name| run.get(*name) != replay.get(*name)).collect();
    assert!(
        other.is_empty() && run.len() == replay.len(),
        "{what}: {other:?} differ"
    );
}

/// No sample of a run that is captured beyond its time.
fn nothing_beyond(poses: &[ToolPose], ms: i64, what: &str) {
    let last = poses.last().unwrap();
    assert!(last.t_device_ns < ms * 1_000_000, "{what}: {last:?}");
}

#[test]
fn a_run_whose_last_sample_is_lost_is_replayed_to_the_same_end() {
    let world = World::new();
    let text = SMALL.replace("rate_hz = 60.0", "rate_hz = 60.0\ndropout = 0.05");
    let scene = world.file("s.toml", &text);
    // Which samples are lost is the seed's doing: a run in simulated time tells.
    world.navigate(&scene, &world.path("all"), &["--for", "2s", "--speed", "max"]);
    let all = poses(&world.path("all"));
    let lost = all.iter().skip(30).find(|pose| pose.status != 0).unwrap().seq as i64;
    // The first of a dropout, its last, and the first valid one behind it (a dropout lasts six samples).
    for last in [lost, lost + 5, lost + 6] {
        let ms = (last + 1) * 1000 / 60;
        let out = world.path(&format!("lost-{last}"));
        world.navigate(&scene, &out, &["--for", &format!("{ms}ms")]);
        let recorded = poses(&out);
        assert_eq!(recorded.last().unwrap().seq as i64, last);
        assert_eq!(
            recorded.last().unwrap().status != 0,
            all[last as usize].status != 0,
            "{last}"
        );
        nothing_beyond(&recorded, ms, "simulated");
        ends_alike(&world, &out, &format!("sample {last}"));
    }
}

#[test]
fn runs_of_a_room_end_with_the_last_frame_of_their_time() {
    let world = World::new();
    // Frames that are late, out of order and lost.
    let room =
        "[tracker.room.localizer]\nlatency_ms = 30.0\njitter_ms = 5.0\nlate = 0.1\nlate_ms = 40.0\ndropped = 0.1\n";
    let text = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n") + room;
    let out = world.path("out");
    world.navigate(&world.file("s.toml", &text), &out, &["--for", "1100ms"]);
    nothing_beyond(&poses(&out), 1100, "room");
    ends_alike(&world, &out, "room");
}
