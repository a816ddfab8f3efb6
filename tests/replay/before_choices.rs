//! A recording of version 0.2.0, which had nothing to choose: it replays as it did then.
//!
//! `data/before-choices.mcap` is a run of a second of the small scene, and beside it are the pictures of its last pose, made anew where
//! lines over the slices changed: since the tube is drawn at its true width, with the path ahead of it, and lines by the distance of pixels
//! from them. Nothing else in them differs from those of 0.2.0; they are too small for words. A generated patient other than that of 0.2.0
//! would need them made anew.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use crate::support::{World, png_texts, report, stderr, stdout};
use recorder::read::reader;
use recorder::replay::facts;
use recorder::wire::schema::TOOL_POSE;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/replay/data")
        .join(name)
}

fn pixels(path: &Path) -> Vec<u8> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap()))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

#[test]
fn a_recording_without_choices_replays_to_the_pictures_of_the_version_that_made_it() {
    let world = World::new();
    let recording = data("before-choices.mcap");
    assert_eq!(reader::guides(&recording).unwrap().count(), 0);
    let facts = facts::facts(&recording).unwrap();
    assert!(facts.damage.is_empty());
    let out = world.path("out");
    let arguments = [
        "replay",
        &*recording.to_string_lossy(),
        "--headless",
        "--speed",
        "max",
        "--out",
    ];
    let output = world.output("pilot", &[&arguments[..], &[&*out.to_string_lossy()]].concat());
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    let poses = reader::poses(&recording, TOOL_POSE).unwrap().count();
    assert_eq!(report(&out)["poses"]["published"], poses);
    for view in ["axial-global", "frontal-local", "perpendicular"] {
        let [then, now] = [
            data(&format!("before-choices-{view}.png")),
            out.join(format!("{view}.png")),
        ];
        assert_eq!(png_texts(&then), png_texts(&now));
        assert!(pixels(&then) == pixels(&now), "{view}");
    }
}
