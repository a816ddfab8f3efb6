//! `calib base` and `calib seat`: from touches to the tool; bad touches and a moving tool refused.

use std::fmt::Write;

use geometry::{Base, Marker, Point, Rigid, Tool, Tracker, Vector};

use super::*;
use crate::calibration::{CalibrationFile, Kind};

const DRAWING: &str = "\
[plane]
at_mm = [0, 0, 0]
normal = [0, 0, 1]
[[groove]]
start_mm = [15, 0, -4]
end_mm = [60, 0, -4]
half_angle_deg = 45
[[groove]]
start_mm = [-3, 15, -4]
end_mm = [-10, 60, -4]
half_angle_deg = 45
[[groove]]
start_mm = [-15, -15, -4]
end_mm = [-45, -45, -4]
half_angle_deg = 45
[seat]
quaternion = [1, 0, 0, 0]
translation_mm = [5, -7, 80]
";

fn place() -> Rigid<Tracker, Base> {
    Rigid::from_parts(turn([0.4, -0.9, 1.3]), Vector::new(120.0, -60.0, -1850.0))
}

/// Exact touches of a sharp tip; a group has the name at its place in `names`, none where it is `-`.
fn touches(names: [&str; 4]) -> String {
    let mut text = if names == ["-"; 4] { "x,y,z\n" } else { "on,x,y,z\n" }.to_owned();
    let mut touch = |name: &str, at: [f64; 3]| {
        let [x, y, z] = (place() * Point::new(at[0], at[1], at[2])).mm();
        let name = if name == "-" { String::new() } else { format!("{name},") };
        let _ = writeln!(text, "{name}{x},{y},{z}");
    };
    for i in 0..12 {
        let s = (i as f64 + 0.5) / 12.0;
        let a = 2.4 * i as f64;
        touch(names[0], [50.0 * s.sqrt() * a.cos(), 50.0 * s.sqrt() * a.sin(), 0.0]);
        touch(names[1], [15.0 + 45.0 * s, 0.0, -4.0]);
        touch(names[2], [-3.0 - 7.0 * s, 15.0 + 45.0 * s, -4.0]);
        touch(names[3], [-15.0 - 30.0 * s, -15.0 - 30.0 * s, -4.0]);
    }
    text
}

const SAID: [&str; 4] = ["plane", "groove 0", "groove 1", "groove 2"];

/// Poses of the tool's marker in the seat, the marker `by` beside the tool.
fn seated(folder: &TempDir, by: Rigid<Marker, Tool>) -> String {
    let seat: Rigid<Base, Tool> = Rigid::from_parts(Rotation::IDENTITY, Vector::new(5.0, -7.0, 80.0));
    let pose: Rigid<Tracker, Marker> = place() * seat * by.inverse();
    let ([w, x, y, z], [a, b, c]) = (pose.quaternion(), pose.translation_mm());
    let mut text = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned();
    for i in 0..5 {
        let off = 1e-3 * f64::from(i - 2);
        let _ = writeln!(text, "{i},{w},{x},{y},{z},{},{b},{c}", a + off);
    }
    write(folder, "seated.csv", &text)
}

#[test]
fn touches_and_a_seat_make_a_tool() {
    let folder = tempfile::tempdir().unwrap();
    let drawing = write(&folder, "base.toml", DRAWING);
    let by: Rigid<Marker, Tool> = Rigid::from_parts(turn([0.2, 0.1, -0.5]), Vector::new(10.0, -20.0, 140.0));
    let poses = seated(&folder, by);
    for names in [SAID, ["a", "b", "c", "d"], ["-"; 4]] {
        let path = write(&folder, "touches.csv", &touches(names));
        let (base, tool) = (folder.path().join("base.json"), folder.path().join("tool.json"));
        let line = format!(
            "calib base {path} --drawing {drawing} --max-noise-ratio 1 --overwrite --out {}",
            base.display()
        );
        let found = calib(&line).unwrap();
        assert!(found.refused.is_none(), "{}", found.text);
        let record = CalibrationFile::read(&base, Kind::Base).unwrap().base.unwrap();
        let off =
            |found: [f64; 3], planted: [f64; 3]| (0..3).map(|k| (found[k] - planted[k]).abs()).fold(0.0, f64::max);
        // Steps end at 1e-12 of the radius; touches are rounded at 1900 mm.
        assert!(
            off(record.translation_mm, place().translation_mm()) < 1e-9,
            "{names:?}: {record:?}"
        );
        assert!(record.rejected.is_empty() && record.groups.len() == 4, "{record:?}");
        let line = format!(
            "calib seat --base {} --poses {poses} --overwrite --out {}",
            base.display(),
            tool.display()
        );
        let found = calib(&line).unwrap();
        assert!(
            found.refused.is_none() && found.text.contains("frames           5"),
            "{}",
            found.text
        );
        let file = CalibrationFile::read(&tool, Kind::Tool).unwrap();
        let frame = file.tool_frame.unwrap();
        // The shifts of the frames cancel.
        assert!(off(frame.translation_mm, by.translation_mm()) < 1e-6, "{frame:?}");
        let record = file.seat.unwrap();
        assert_eq!((file.computed_from.len(), record.frames), (1, 5));
        // It was silent that the error of the marker's emitters is in no covariance.
        assert!(record.emitters.is_some_and(|words| words.starts_with("taken as exact")));
    }
}

#[test]
fn bad_touches_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let drawing = write(&folder, "base.toml", DRAWING);
    let parallel = DRAWING
        .replace("[-3, 15, -4]", "[15, 30, -4]")
        .replace("[-10, 60, -4]", "[60, 30, -4]")
        .replace("[-15, -15, -4]", "[15, -30, -4]")
        .replace("[-45, -45, -4]", "[60, -30, -4]");
    let parallel = write(&folder, "parallel.toml", &parallel);
    let good = touches(SAID);
    let order = touches(["plane", "groove 1", "groove 0", "groove 2"]);
    let words = "said (plane, groove 1, groove 0, groove 2), but the touches fit (plane, groove 0, groove 1, groove 2)";
    let beside = good.replace("\nplane,", "\ngroove 2,");
    for (text, drawing, words) in [
        (&order, &drawing, words),
        (
            &good,
            &parallel,
            "a slide along (1.00, 0.00, 0.00) in the base's axes stays open",
        ),
        (&beside, &drawing, "3 groups of touches"),
        (&"on,x,y,z\nplane,1,2,inf\n".to_owned(), &drawing, "(z): found \"inf\""),
    ] {
        let path = write(&folder, "touches.csv", text);
        let error = calib(&format!("calib base {path} --drawing {drawing}")).unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
    }
    // A tip taken for a sharp one.
    let path = write(&folder, "touches.csv", &good);
    let error = calib(&format!("calib base {path} --drawing {drawing} --tip-radius-mm 3")).unwrap_err();
    assert!(
        error.contains("do not fit the drawing") && error.contains("the tip's radius"),
        "{error}"
    );
    let found = calib(&format!("calib base {path} --drawing {drawing} --min-touches 100")).unwrap();
    assert!(
        found.refused.unwrap().contains("--min-touches 100: found 48"),
        "{}",
        found.text
    );
}

#[test]
fn a_tool_that_moved_in_its_seat_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let drawing = write(&folder, "base.toml", DRAWING);
    let path = write(&folder, "touches.csv", &touches(SAID));
    let base = folder.path().join("base.json");
    calib(&format!(
        "calib base {path} --drawing {drawing} --out {}",
        base.display()
    ))
    .unwrap();
    let poses = seated(&folder, Rigid::identity());
    let text = fs::read_to_string(&poses).unwrap();
    let [last, _] = text.lines().rev().take(2).collect::<Vec<_>>()[..] else {
        panic!("{text}")
    };
    let moved = write(
        &folder,
        "moved.csv",
        &(text.clone() + &last.replacen("4,", "5,0.6,0.8,0,0,1,2,3\n#", 1) + "\n"),
    );
    let line = |poses: &str| format!("calib seat --base {} --poses {poses}", base.display());
    let error = calib(&line(&moved)).unwrap_err();
    assert!(error.contains("the tool moved"), "{error}");
    let error = calib(&(line(&poses) + &format!(" --reference {poses}"))).unwrap_err();
    assert!(error.contains("leave --reference out"), "{error}");
    let bare = write(&folder, "bare.toml", DRAWING.split("[seat]").next().unwrap());
    calib(&format!(
        "calib base {path} --drawing {bare} --overwrite --out {}",
        base.display()
    ))
    .unwrap();
    let error = calib(&line(&poses)).unwrap_err();
    assert!(error.contains("without a table [seat]"), "{error}");
}
