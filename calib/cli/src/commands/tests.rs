//! The commands on planted and real recordings.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use geometry::rotation::{Rotation, RotationVector};
use tempfile::TempDir;

use super::Outcome;
use crate::calibration::{CalibrationFile, Kind};
use crate::cli::{Cli, run};
use crate::register::file::RegistrationFile;

const TIP: [f64; 3] = [4.0, -3.0, 160.0];

pub(crate) fn calib(line: &str) -> Result<Outcome, String> {
    let cli = Cli::try_parse_from(line.split(' ')).map_err(|error| error.to_string())?;
    run(cli, |_| Err("no volume is read here".into()))
}

/// Real recordings beside the working tree; `None`, with the reason said, where they are not there.
pub(super) fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    if !path.exists() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    Some(path)
}

pub(super) fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

/// A line of a recording: rotation, and the place of the tip in the tracker.
fn row(t: f64, rotation: Rotation, tip: [f64; 3]) -> String {
    let lever = rotation.apply(TIP);
    let [w, x, y, z] = rotation.quaternion();
    let [a, b, c] = [0, 1, 2].map(|i| tip[i] - lever[i]);
    format!("{t},{w},{x},{y},{z},{a},{b},{c},OK\n")
}

const HEADER: &str = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm,status\n";

/// A pivoting and a spinning recording of one instrument, exact but for one slip.
fn recordings(folder: &TempDir) -> [String; 2] {
    let (mut pivot, mut spin) = (HEADER.to_owned(), HEADER.to_owned());
    for i in 0..80 {
        let a = f64::from(i);
        let rotation = turn([0.3, 2.0, -0.4]) * turn([0.5 * (0.7 * a).sin(), 0.5 * (1.1 * a).cos(), 0.1]);
        let slip = if i == 30 { 15.0 } else { 0.0 };
        pivot += &row(0.1 * a, rotation, [100.0 + slip, -50.0, 1900.0]);
        // About the marker's z axis through the tip.
        let rotation = turn([0.3, 2.0, -0.4]) * turn([0.0, 0.0, 0.05 * a]);
        spin += &row(0.1 * a, rotation, [100.0, -50.0, 1900.0]);
    }
    let _ = writeln!(pivot, "9,,,,,,,,MISSING");
    [("pivot.csv", pivot), ("spin.csv", spin)].map(|(name, text)| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    })
}

#[test]
fn a_tip_and_an_axis_make_a_tool() {
    let folder = tempfile::tempdir().unwrap();
    let [pivot, spin] = recordings(&folder);
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (tip, axis, tool) = (at("tip.json"), at("axis.json"), at("tool.json"));
    let names = "--tool scope --marker ball";
    let gates = "--max-rms-mm 0.1 --min-cone-deg 20";
    let found = calib(&format!("calib pivot --poses {pivot} --out {tip} {names} {gates}")).unwrap();
    // It was silent that the error of the marker's emitters is in no covariance.
    assert!(found.text.contains("emitters         taken as exact"), "{}", found.text);
    assert!(
        found.refused.is_none() && found.text.contains("accepted"),
        "{}",
        found.text
    );
    assert!(found.text.contains("1 poses were left out: 31"), "{}", found.text);
    assert!(
        found.text.contains("1 frames are marked as not valid"),
        "{}",
        found.text
    );
    let found = calib(&format!("calib spin --poses {spin} --tip {tip} --out {axis} {names}")).unwrap();
    assert!(
        found.text.contains("axis             (0.000000, 0.000000, 1.000000)"),
        "{}",
        found.text
    );
    let found = calib(&format!("calib tool --pivot {tip} --spin {axis} --out {tool} {names}")).unwrap();
    assert!(found.refused.is_none(), "{}", found.text);

    let file = CalibrationFile::read(Path::new(&tool), Kind::Tool).unwrap();
    let frame = file.tool_frame.unwrap();
    // Coordinates of the recordings are written to the last digit; the slip is forgotten altogether.
    assert!(
        (0..3).all(|i| (frame.translation_mm[i] - TIP[i]).abs() < 1e-9),
        "{frame:?}"
    );
    assert!(frame.tip_off_axis_mm < 1e-9 && frame.roll_by == "x", "{frame:?}");
    assert_eq!(file.computed_from.len(), 2);
    let error = calib(&format!(
        "calib tool --pivot {tip} --spin {axis} --tool scope --marker cube"
    ))
    .unwrap_err();
    assert!(
        error.contains("is of marker \"ball\", the command line's is \"cube\""),
        "{error}"
    );
}

#[test]
fn a_gate_that_is_not_kept_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let [pivot, _] = recordings(&folder);
    let out = folder.path().join("tip.json");
    let line = format!(
        "calib pivot --poses {pivot} --method algebraic --max-rms-mm 0.5 --out {}",
        out.display()
    );
    let found = calib(&line).unwrap();
    assert!(
        found.refused.as_deref().unwrap().contains("--max-rms-mm 0.5: found 1."),
        "{found:?}"
    );
    assert!(found.text.contains("NOT ACCEPTED") && found.text.contains("not written") && !out.exists());
    let found = calib(&format!("calib pivot --poses {pivot} --min-cone-deg 60")).unwrap();
    assert!(
        found.text.contains("60 are needed") && found.refused.is_some(),
        "{}",
        found.text
    );
}

#[test]
fn a_changed_or_misplaced_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [pivot, _] = recordings(&folder);
    let out = folder.path().join("tip.json");
    calib(&format!("calib pivot --poses {pivot} --out {}", out.display())).unwrap();
    let good = fs::read_to_string(&out).unwrap();
    let read = |text: &str, kind| {
        fs::write(&out, text).unwrap();
        CalibrationFile::read(&out, kind).map_err(|error| error.to_string())
    };
    let file = read(&good, Kind::Pivot).unwrap();
    assert!(file.of_marker(&out, "scene", "marker").is_ok());
    assert!(file.date_utc.ends_with('Z') && file.id.len() == 16);
    // Blanks do not count; numbers do.
    assert_eq!(read(&good.replace("\n  ", "\n    "), Kind::Pivot).unwrap(), file);
    let changed = good.replacen("\"inliers\": 79", "\"inliers\": 80", 1);
    assert_ne!(changed, good);
    for (text, kind, words) in [
        (changed.as_str(), Kind::Pivot, "it was changed after it was written"),
        (&good, Kind::Spin, "it is of kind pivot, spin is needed"),
        (
            &good.replacen("\"trocar_calibration\": 1", "\"trocar_calibration\": 2", 1),
            Kind::Pivot,
            "found trocar_calibration 2",
        ),
        ("{}", Kind::Pivot, "found trocar_calibration nothing"),
        ("{\"trocar_calibration\": 1}", Kind::Pivot, "missing field"),
        ("[1e999]", Kind::Pivot, "number out of range"),
        ("", Kind::Pivot, "the file is empty"),
    ] {
        let error = read(text, kind).unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
    }
    // Sealed anew, but with numbers that cannot be.
    let mut bad = file.clone();
    bad.pivot.as_mut().unwrap().covariance_upper_mm2 = Some([-1.0; 21]);
    let error = read(&bad.sealed().unwrap().to_json().unwrap(), Kind::Pivot).unwrap_err();
    assert!(error.contains("covariance_upper_mm2"), "{error}");
    let mut bad = file.clone();
    bad.gates = vec![super::common::gate("max-rms-mm", Some(1.0), 2.0, false).unwrap()];
    let error = read(&bad.sealed().unwrap().to_json().unwrap(), Kind::Pivot).unwrap_err();
    assert!(error.contains("verdict"), "{error}");
    let mut bad = file;
    bad.pivot = None;
    let error = read(&bad.sealed().unwrap().to_json().unwrap(), Kind::Pivot).unwrap_err();
    assert!(error.contains("a part of the same name"), "{error}");
}

#[test]
fn a_registration_of_another_ct_or_marker_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (pairs, out) = (folder.path().join("pairs.csv"), folder.path().join("r.json"));
    let header = "from_x,from_y,from_z,to_x,to_y,to_z\n";
    fs::write(
        &pairs,
        format!("{header}0,0,0,1,0,0\n9,0,0,10,0,0\n0,9,0,1,9,0\n0,0,9,1,0,9\n"),
    )
    .unwrap();
    let line = format!(
        "calib register --pairs {} --overwrite --out {}",
        pairs.display(),
        out.display()
    );
    calib(&format!("{line} --ct-hash abc123 --marker ball")).unwrap();
    let file = RegistrationFile::read(&out).unwrap();
    assert!(file.paired(&out, "abc123", "ball").is_ok());
    let error = file.paired(&out, "def456", "ball").unwrap_err().to_string();
    assert!(error.contains("is of the CT \"abc123\", \"def456\" is used"), "{error}");
    let error = file.paired(&out, "abc123", "cube").unwrap_err().to_string();
    assert!(error.contains("is of marker \"ball\", \"cube\" is used"), "{error}");
    // What was not told is not checked.
    calib(&line).unwrap();
    assert!(
        RegistrationFile::read(&out)
            .unwrap()
            .paired(&out, "def456", "cube")
            .is_ok()
    );
}

#[test]
fn the_published_tip_is_found_in_the_published_recording() {
    let Some(path) = shared("pivot-sks") else { return };
    let line = format!("calib pivot --poses {} --json", path.display());
    let file = |method: &str| -> CalibrationFile {
        let found = calib(&format!("{line} --method {method}")).unwrap();
        serde_json::from_str(&found.text).unwrap()
    };
    let found = file("algebraic").pivot.unwrap();
    let near = |found: [f64; 3], expected: [f64; 3]| (0..3).all(|i| (found[i] - expected[i]).abs() <= 0.0005);
    // Published to three decimals.
    assert!(near(found.tip_mm, [-14.473, 394.634, -7.407]), "{found:?}");
    assert!(near(found.pivot_mm, [-804.742, -85.474, -2112.131]), "{found:?}");
    assert!((found.rms_scalar_mm - 1.761).abs() < 0.0005, "{found:?}");
    assert!((found.condition - 10.9).abs() < 0.05, "{found:?}");
    let robust = file("errors-in-variables");
    println!("{}", calib(line.trim_end_matches(" --json")).unwrap().text);
    let recorded = robust.recorded.unwrap();
    assert_eq!((recorded.frames, recorded.poses, recorded.invalid), (57, 57, 0));
    let robust = robust.pivot.unwrap();
    assert!(robust.inliers < 57 && robust.rms_mm < found.rms_mm, "{robust:?}");
}

#[test]
fn sequences_of_other_software_are_read() {
    let Some(path) = shared("tracker-plus/WaterTankBottomTranslationTrackerBuffer-trimmed.igs.mha") else {
        return;
    };
    let several = calib(&format!("calib pivot --poses {}", path.display())).unwrap_err();
    assert!(
        several.contains("ProbeToTracker, ReferenceToTracker, StylusToTracker; choose one"),
        "{several}"
    );
    // The stylus was not pivoted in this one, and the probe was only moved along.
    for name in ["StylusToTracker", "ProbeToTracker"] {
        match calib(&format!("calib pivot --poses {} --transform {name}", path.display())) {
            Ok(found) => println!("{name}: {}", found.text),
            Err(error) => println!("{name}: {error}"),
        }
    }
}
