//! `calib marker`: the places found, checked and pasted; bad frames refused.

use std::fmt::Write;

use calib::marker::even_directions;
use geometry::{Direction, Marker, Point};

use super::*;
use crate::calibration::{CalibrationFile, Kind};

/// Twelve emitters on a ball and a bracket, so that the axes are steady.
fn emitters() -> Vec<Point<Marker>> {
    let origin = Point::new(0.0, 0.0, 0.0);
    let ball = even_directions(12)
        .into_iter()
        .map(|d: Direction<Marker>| origin + d * 40.0);
    ball.chain([Point::new(70.0, 10.0, 5.0)]).collect()
}

/// What a localizer sees of them from the side of +z, exactly, in 60 frames numbered from 100; `change` may swap, mirror or
/// drop.
fn frames(change: impl Fn(usize, usize, [f64; 3]) -> Option<(usize, [f64; 3])>) -> String {
    let mut text = "frame,emitter,x,y,z\n".to_owned();
    for frame in 0..60 {
        let a = frame as f64;
        let rotation = turn([0.7 * (0.37 * a).sin(), 0.31 * a, 0.9 * (0.23 * a).cos()]);
        for (emitter, b) in emitters().iter().enumerate() {
            let [x, y, z] = rotation.apply(b.mm());
            let seen = (emitter, [x + 30.0, y - 20.0, z - 1900.0]);
            // The upper half, and the bracket always.
            let (e, at) = if z > -10.0 || emitter == 12 { seen } else { continue };
            if let Some((e, [x, y, z])) = change(frame, e, at) {
                let _ = writeln!(text, "{},{e},{x},{y},{z}", 100 + frame);
            }
        }
    }
    text
}

#[test]
fn a_marker_is_found_checked_and_pasted() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "frames.csv", &frames(|_, e, at| Some((e, at))));
    let out = folder.path().join("ball.json");
    let found = calib(&format!(
        "calib marker {path} --marker ball --max-rms-mm 0.01 --out {}",
        out.display()
    ))
    .unwrap();
    assert!(
        found.refused.is_none() && found.text.contains("accepted"),
        "{}",
        found.text
    );
    let marker = CalibrationFile::read(&out, Kind::Marker).unwrap().marker_body.unwrap();
    assert_eq!((marker.emitters.len(), marker.views), (13, 60));
    // Distances are those planted, whatever the axes: rounding of 1900 mm.
    let at = |i: usize| marker.emitters[i].as_ref().unwrap().at_mm;
    let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    for (i, j) in [(0, 12), (3, 7), (11, 12)] {
        let planted = emitters()[i].distance(emitters()[j]);
        assert!((distance(at(i), at(j)) - planted).abs() < 1e-9, "{i} {j}");
    }
    let again = calib(&format!(
        "calib marker {path} --marker ball --drawing {} --tolerance-mm 0.001",
        out.display()
    ))
    .unwrap();
    assert!(
        again.text.contains("drawing          kept: 13 emitters"),
        "{}",
        again.text
    );
    let table = calib(&format!("calib marker {path} --toml")).unwrap().text;
    let scene: toml::Table = table.parse().unwrap();
    let list = &scene["tracker"]["room"]["marker"]["emitters"];
    assert_eq!(list.as_array().unwrap().len(), 13);
    let other = calib(&format!(
        "calib marker {path} --marker cube --drawing {}",
        out.display()
    ))
    .unwrap_err();
    assert!(
        other.contains("is of marker \"ball\", the command line's is \"cube\""),
        "{other}"
    );
}

#[test]
fn bad_frames_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let good = write(&folder, "good.csv", &frames(|_, e, at| Some((e, at))));
    let out = folder.path().join("ball.json");
    calib(&format!("calib marker {good} --out {}", out.display())).unwrap();
    let swap = |e: usize| match e {
        3 => 12,
        12 => 3,
        e => e,
    };
    let some = frames(|frame, e, at| Some((if frame == 7 { swap(e) } else { e }, at)));
    let all = frames(|_, e, at| Some((swap(e), at)));
    let mirror = frames(|_, e, [x, y, z]| Some((e, [-x, y, z])));
    let moved = frames(|_, e, [x, y, z]| Some((e, [if e == 5 { x } else { x + 1.0 }, y, z])));
    let few = frames(|_, e, at| (e < 2).then_some((e, at)));
    let seldom = frames(|frame, e, at| (e != 4 || frame == 0).then_some((e, at)));
    let nan = "frame,emitter,x,y,z\n0,0,1,nan,3\n".to_owned();
    let twice = "frame,emitter,x,y,z\n5,0,1,2,3\n5,0,9,2,3\n5,1,1,8,3\n".to_owned();
    let drawing = format!(" --drawing {}", out.display());
    for (name, text, options, words) in [
        (
            "swapped",
            &some,
            "",
            "emitter 3 is at the place of emitter 12 in 1 views (107)",
        ),
        (
            "exchanged",
            &all,
            drawing.as_str(),
            "emitter 3 is at the place of emitter 12",
        ),
        ("mirrored", &mirror, &drawing, "the mirror image of its drawing"),
        ("moved", &moved, &drawing, "from its place in the drawing"),
        ("few", &few, "", "three emitters off a line"),
        ("seldom", &seldom, "", "fewer than 3 views that give a pose: 4 (1)"),
        ("nan", &nan, "", "line 2, column 7 (y): found \"nan\""),
        ("twice", &twice, " --emitters 3", "view 5 sees emitter 0 twice"),
    ] {
        let path = write(&folder, "bad.csv", text);
        let error = calib(&format!("calib marker {path}{options}"))
            .map(|o| o.text)
            .unwrap_err();
        assert!(error.contains(words), "{name}: {error}");
    }
}
