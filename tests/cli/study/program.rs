//! The command `pilot study`: what it leaves, and what it refuses.

use std::fs;

use crate::support::{World, stderr};

/// Coarse voxels and large beads: an examination takes a second.
const STUDY: &str = "operations = 2\n[[stratum]]\nname = \"a\"\ntargets = [\"pre-aortic\"]\n\
                     ct = { spacing_mm = [2.0, 2.0, 2.0], images = 1 }\nbeads = { diameter_mm = 4.0 }\n";

#[test]
fn a_study_is_done_by_the_sibling_and_gone_on_with() {
    let world = World::new();
    let (file, out) = (world.path("study.toml"), world.path("out"));
    fs::write(&file, STUDY).unwrap();
    let (file, out) = (file.to_string_lossy().into_owned(), out.to_string_lossy().into_owned());
    let words = ["study", &file, "--out", &out, "--threads", "2"];
    let first = world.output("pilot", &words);
    assert!(first.status.success(), "{}", stderr(&first));
    let lines = fs::read_to_string(world.path("out").join("operations.csv")).unwrap();
    assert_eq!(lines.lines().count(), 3, "{lines}");
    let page = fs::read_to_string(world.path("out").join("report.html")).unwrap();
    for section in [
        "True error at the targets",
        "Was the predicted error right?",
        "Refusals",
        "The worst",
    ] {
        assert!(page.contains(section), "{section}");
    }
    made_again(&world);
    let again = world.output("pilot", &words);
    assert!(
        again.status.success() && stderr(&again).contains("0 operations in"),
        "{}",
        stderr(&again)
    );
    assert!(stderr(&again).contains("2 were there"), "{}", stderr(&again));
    fs::write(world.path("study.toml"), STUDY.replace('2', "3")).unwrap();
    let other = world.output("pilot", &words);
    assert_eq!(other.status.code(), Some(1));
    assert!(stderr(&other).contains("is of another study"), "{}", stderr(&other));
}

/// A kept operation is made again by its recording alone, each pose to the last bit. Its scene named the examination where it was not.
fn made_again(world: &World) {
    let worst = fs::read_dir(world.path("out").join("worst")).unwrap();
    let kept: Vec<_> = worst.map(|entry| entry.unwrap().path().join("session.mcap")).collect();
    let [recording, ..] = kept.as_slice() else {
        panic!("no operation was kept")
    };
    let (recording, out) = (recording.to_string_lossy(), world.path("again"));
    let out = out.to_string_lossy();
    let words = ["replay", &*recording, "--recompute", "--headless", "--out", &*out];
    let output = world.output("pilot", &words);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = fs::read_to_string(world.path("again").join("compare.json")).unwrap();
    let compared: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [common, identical] = ["common", "identical"].map(|key| compared[key].as_u64().unwrap());
    assert!(common > 100 && identical == common, "{text}");
}

#[test]
fn studies_that_cannot_be_are_refused_by_name() {
    let world = World::new();
    let (file, out) = (world.path("study.toml"), world.path("out"));
    let (name, out) = (file.to_string_lossy().into_owned(), out.to_string_lossy().into_owned());
    for (text, words) in [
        ("", "no stratum to study"),
        (
            "[[stratum]]\nname = \"a\"\nlocalizer = { rate_hz = 0.0 }",
            "stratum \"a\": localizer.rate_hz: found 0.0; 15 to 1000",
        ),
        ("[[stratum]]\nname = \"a\"\ntargets = []", "an operation needs a target"),
    ] {
        fs::write(&file, text).unwrap();
        let output = world.output("pilot", &["study", &name, "--out", &out]);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(stderr(&output).contains(words), "{text}: {}", stderr(&output));
        assert!(
            !world.path("out").exists(),
            "nothing is made for a study that cannot be"
        );
    }
}
