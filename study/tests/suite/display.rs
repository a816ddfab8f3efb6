//! The same operation by the sight's numbers and by the window's pixels, and beside another file.

use std::fs;
use std::path::Path;

use hand::Dial;
use study::plan::Plan;
use study::record::{Ended, Row};
use study::run::run;

use crate::support::QUICK;

fn text(display: &str) -> String {
    format!(
        "seed = 3\noperations = 1\ndisplay = \"{display}\"\n{QUICK}targets = [\"pre-aortic\"]\n[[stratum]]\nname = \"a\"\n"
    )
}

fn both() -> Plan {
    let [sight, pixels] = ["sight", "pixels"].map(text);
    Plan::of_texts([
        (Path::new("sight.toml"), sight.as_str()),
        (Path::new("pixels.toml"), pixels.as_str()),
    ])
    .unwrap()
}

#[test]
fn an_operation_by_the_pixels_is_the_one_by_the_sight_to_what_a_pixel_is() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let done = run(&both(), one.path(), 2).unwrap();
    let [sight, pixels] = &done.rows[..] else {
        panic!("{:?}", done.rows)
    };
    assert_eq!(
        (sight.stratum.as_str(), pixels.stratum.as_str()),
        ("sight.a", "pixels.a")
    );
    for row in [sight, pixels] {
        assert_eq!((row.ended, row.step.as_str()), (Ended::Arrived, ""), "{row:?}");
        // ON TARGET promises it.
        assert!(row.miss_mm <= 5.0 && row.pictures[0] > 50, "{row:?}");
    }
    // All before the way is the same to the bit, and the pose is not: the hand goes by what it reads.
    assert_eq!((sight.links[0], &sight.check), (pixels.links[0], &pixels.check));
    assert_eq!(sight.strokes, pixels.strokes);
    assert_ne!(sight.tre_mm.to_bits(), pixels.tre_mm.to_bits());
    let apart = (sight.miss_mm - pixels.miss_mm).abs();
    assert!(apart <= pixel_mm(), "{apart} {}", pixel_mm());
    run(&both(), two.path(), 1).unwrap();
    let lines = [&one, &two].map(|folder| fs::read_to_string(folder.path().join("operations.csv")).unwrap());
    assert_eq!(lines[0], lines[1]);
}

/// How far ends may be apart for readings that are one pixel apart right, up and along, as those of the window's pixels are from the
/// sight's, where the bar may stand under the white line at zero for the one alone, mm.
fn pixel_mm() -> f64 {
    let dial = Dial::FULL_HD;
    let [across, _] = dial.read([2.0_f64.sqrt(), 0.0]);
    across.hypot((1.0 + dial.hidden_px) / dial.bar_px_per_mm())
}

/// What is drawn follows from the name in the file.
#[test]
fn an_operation_is_the_same_alone_and_beside_another_file() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (sight, other) = (text("sight"), text("sight").replace("seed = 3", "seed = 4"));
    let files = [
        (Path::new("sight.toml"), sight.as_str()),
        (Path::new("other.toml"), other.as_str()),
    ];
    let alone = run(&Plan::of_texts(files[..1].iter().copied()).unwrap(), one.path(), 1).unwrap();
    let beside = run(&Plan::of_texts(files).unwrap(), two.path(), 2).unwrap();
    let [first, second] = &beside.rows[..] else {
        panic!("{:?}", beside.rows)
    };
    let renamed = Row {
        stratum: "a".to_owned(),
        ..first.clone()
    };
    assert_eq!(renamed.line(), alone.rows[0].line());
    assert_ne!(first.tre_mm, second.tre_mm);
}
