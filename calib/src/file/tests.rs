use serde_json::{Value, json};

use super::sequence::{frames, header_end, transforms};
use super::*;
use geometry::{Marker, Tracker};
use proptest::prelude::*;

fn tool() -> Value {
    let mut covariance = [0.0; 21];
    for (place, variance) in [(0, 1e-6), (6, 1e-6), (15, 0.01), (18, 0.01), (20, 0.02)] {
        covariance[place] = variance;
    }
    json!({
        "trocar_calibration": 1, "kind": "tool", "date_utc": "2026-01-01T00:00:00Z", "program": "calib", "tool": "scope",
        "marker": "ball", "verdict": "accepted", "gates": [{"name": "a", "limit": 1.0, "found": 0.5, "kept": true}],
        "tool_frame": {"quaternion_wxyz": [1.0, 0.0, 0.0, 0.0], "translation_mm": [1.0, 2.0, 3.0],
            "covariance_upper": covariance, "roll_by": "x", "tip_off_axis_mm": 0.1},
    })
}

fn sealed(mut value: Value) -> String {
    value["id"] = content_id(value.clone()).into();
    value.to_string()
}

fn registration() -> Value {
    let row = |i: usize| -> Vec<f64> { (0..6).map(|j| if i == j { 1e-4 } else { 0.0 }).collect() };
    json!({
        "format": "trocar-registration", "version": 1, "to": "ct", "from": "tracker",
        "transform": {"quaternion_wxyz": [1.0, 0.0, 0.0, 0.0], "translation_mm": [1.0, 2.0, 3.0], "scale": 1.0},
        "covariance": (0..6).map(row).collect::<Vec<_>>(), "ct_hash": "ab", "marker": "ball",
    })
}

/// A variance of 1 mm^2 per axis at the target holds 95 % within 2.7955 mm (chi with 3 degrees of freedom).
#[test]
fn files_say_how_good_they_are() {
    let mut value = tool();
    let reached = ToolFile::parse(&sealed(value.clone())).unwrap().reached;
    // The trace of the translation's part, and turns of 1e-6 about x and y at the tip 1, 2, 3.
    let expected = (0.01_f64 + 0.01 + 0.02 + 1e-6 * (13.0 + 10.0)).sqrt();
    assert!((reached.tip_error_mm.unwrap() - expected).abs() < 1e-12);
    assert_eq!((reached.rms_mm, reached.coverage_rad), (None, None));
    value["pivot"] = json!({"inliers": 400, "rms_mm": 0.3, "condition": 7.0, "coverage": {"principal": [
        {"angle_deg": 40.0}, {"angle_deg": 30.0}, {"angle_deg": 1.0}]}});
    let reached = ToolFile::parse(&sealed(value)).unwrap().reached;
    assert_eq!(
        (reached.rms_mm, reached.condition, reached.count),
        (Some(0.3), Some(7.0), Some(400))
    );
    assert_eq!(reached.coverage_rad, Some(30.0_f64.to_radians()));

    let mut value = registration();
    let at = |value: &Value| {
        let file = RegistrationFile::parse(&value.to_string()).unwrap();
        file.reached(geometry::Point::new(1.0, 2.0, 3.0))
    };
    assert_eq!((at(&value).rms_mm, at(&value).condition), (None, None));
    (value["fre_rms_mm"], value["condition"]) = (0.7.into(), 3.0.into());
    let row = |i: usize| -> Vec<f64> { (0..6).map(|j| if i == j && i > 2 { 1.0 } else { 0.0 }).collect() };
    value["covariance"] = (0..6).map(row).collect::<Vec<_>>().into();
    let reached = at(&value);
    assert_eq!((reached.rms_mm, reached.condition), (Some(0.7), Some(3.0)));
    // The radius is good to 1e-3 of itself.
    assert!((reached.target_mm.unwrap() - 2.7955).abs() < 3e-3, "{reached:?}");
}

#[test]
fn files_are_read_and_paired() {
    let file = ToolFile::parse(&sealed(tool())).unwrap();
    assert_eq!(file.marker_from_tool.transform().translation_mm(), [1.0, 2.0, 3.0]);
    assert_eq!(file.marker_from_tool.upper()[20], 0.02);
    assert!(file.of("scope", "ball").is_ok());
    let other = file.of("pointer", "ball").unwrap_err().to_string();
    assert_eq!(other, "made for the tool \"scope\", in use is \"pointer\"");
    assert!(file.of("scope", "star").unwrap_err().to_string().contains("marker"));

    let file = RegistrationFile::parse(&registration().to_string()).unwrap();
    assert!(matches!(file.registered, Registered::Fixed(_)));
    assert!(file.of("ab", "ball").is_ok());
    assert!(
        file.of("cd", "ball")
            .unwrap_err()
            .to_string()
            .contains("made for the CT \"ab\"")
    );
    let mut referenced = registration();
    referenced["from"] = "reference".into();
    let file = RegistrationFile::parse(&referenced.to_string()).unwrap();
    assert!(matches!(file.registered, Registered::Referenced(_)));
}

#[test]
fn a_tool_that_cannot_be_used_is_refused_by_name() {
    let changed = |key: &str, value: Value| {
        let mut tool = tool();
        *tool.pointer_mut(key).unwrap() = value;
        ToolFile::parse(&sealed(tool)).unwrap_err().to_string()
    };
    for (key, value, words) in [
        (
            "/trocar_calibration",
            json!(2),
            "found trocar_calibration 2, expected trocar_calibration 1",
        ),
        ("/kind", json!("pivot"), "kind \"pivot\""),
        ("/verdict", json!("refused"), "verdict is \"refused\""),
        ("/gates/0/kept", json!(false), "only \"accepted\""),
        (
            "/tool_frame/quaternion_wxyz",
            json!([1.0, 0.1, 0.0, 0.0]),
            "a unit quaternion",
        ),
        ("/tool_frame/translation_mm", json!([1.0, 2e9, 0.0]), "at most 1e9 mm"),
        ("/tool_frame/covariance_upper", json!(vec![0.0; 21]), "above 0 mm^2"),
        ("/tool_frame/covariance_upper/15", json!(-0.01), "variance 3 is -1e-2"),
        ("/tool_frame/covariance_upper/16", json!(9.0), "covariance"),
        ("/tool_frame", Value::Null, "expected the tool's frame"),
    ] {
        let error = changed(key, value);
        assert!(error.contains(words), "{key}: {error}");
    }
    let broken = sealed(tool()).replace("[1.0,2.0,3.0]", "[1.0,2.0,3.5]");
    assert!(
        ToolFile::parse(&broken)
            .unwrap_err()
            .to_string()
            .contains("changed after")
    );
    let cut = sealed(tool());
    let error = ToolFile::parse(&cut[..cut.len() / 2]).unwrap_err().to_string();
    assert!(error.contains("line 1 column"), "{error}");
    assert!(matches!(
        ToolFile::parse(&" ".repeat(MAX_BYTES + 1)),
        Err(FileError::TooLong { .. })
    ));
}

#[test]
fn a_registration_that_cannot_be_used_is_refused_by_name() {
    for (key, value, words) in [
        ("/version", json!(2), "version 2"),
        ("/format", json!("x"), "expected format \"trocar-registration\""),
        ("/from", json!("from"), "ct_from_from"),
        ("/transform/scale", json!(1.001), "measured in mm"),
        ("/covariance", Value::Null, "covariance is \"null\""),
        ("/covariance/0/0", json!(-1.0), "variance 0"),
        ("/covariance/0/1", json!(9.0), "covariance"),
        ("/covariance", json!(vec![vec![0.0; 6]; 6]), "above 0 mm^2"),
        (
            "/transform/quaternion_wxyz",
            json!([0.0, 0.0, 0.0, 0.0]),
            "a unit quaternion",
        ),
    ] {
        let mut file = registration();
        *file.pointer_mut(key).unwrap() = value;
        let error = RegistrationFile::parse(&file.to_string()).unwrap_err().to_string();
        assert!(error.contains(words), "{key}: {error}");
    }
}

/// What a file said of itself beside what is read of it was overruled in silence: metres, another name, a mirrored matrix.
#[test]
fn a_registration_that_says_two_things_of_itself_is_refused() {
    // Half a turn about z: its matrix is known to the last digit.
    let mut whole = registration();
    whole["units"] = json!({"length": "mm", "angle": "rad"});
    whole["transform"] = json!({
        "name": "ct_from_tracker", "convention": TRANSFORM_CONVENTION, "quaternion_wxyz": [0.0, 0.0, 0.0, 1.0],
        "rotation_vector_rad": [0.0, 0.0, -std::f64::consts::PI], "translation_mm": [1.0, 2.0, 3.0], "scale": 1.0,
        "matrix": [[-1.0, 0.0, 0.0, 1.0], [0.0, -1.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]],
    });
    whole["covariance_convention"] = COVARIANCE_CONVENTION.into();
    whole["more"] = json!("is passed over");
    RegistrationFile::parse(&whole.to_string()).unwrap();
    for (pointer, value, words) in [
        ("/units/length", json!("m"), "units.length is \"m\", expected \"mm\""),
        ("/units/angle", json!("deg"), "units.angle is \"deg\", expected \"rad\""),
        (
            "/transform/name",
            json!("tracker_from_ct"),
            "transform.name is \"tracker_from_ct\", expected \"ct_from_tracker\"",
        ),
        (
            "/transform/convention",
            json!("p_from = R p_to"),
            "transform.convention is",
        ),
        ("/transform/matrix/0/0", json!(1.0), "transform.matrix is"),
        (
            "/transform/matrix/1/3",
            json!(2.001),
            "expected that of quaternion and translation",
        ),
        (
            "/transform/matrix/3",
            json!([0.0, 0.0, 0.0, 2.0]),
            "transform.matrix is",
        ),
        ("/transform/matrix", json!("none"), "transform.matrix is"),
        (
            "/transform/rotation_vector_rad/2",
            json!(3.0),
            "transform.rotation_vector_rad is",
        ),
        (
            "/covariance_convention",
            json!("(translation, rotation)"),
            "covariance_convention is",
        ),
    ] {
        let mut file = whole.clone();
        *file.pointer_mut(pointer).unwrap() = value;
        let error = RegistrationFile::parse(&file.to_string()).unwrap_err().to_string();
        assert!(error.contains(words), "{pointer}: {error}");
    }
}

const ONE: &str = "1 0 0 5 0 1 0 6 0 0 1 7 -0 0 -0 1";

#[test]
fn frames_are_in_the_order_of_their_numbers_with_every_pose_asked_for() {
    let text = format!(
        "Seq_Frame0001_AToBTransform = 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\nSeq_Frame0001_Timestamp = 2.5\n\
         Seq_Frame0000_AToBTransform = {ONE}\nSeq_Frame0000_CToBTransform = {ONE}\nSeq_Frame0000_Timestamp = 2.6\n\
         Seq_Frame0002_AToBTransform = 0 0 0 0\nSeq_Frame0002_AToBTransformStatus = INVALID\n"
    );
    assert_eq!(transforms(&text).into_iter().collect::<Vec<_>>(), ["AToB", "CToB"]);
    let found = frames(&text, &["AToB", "CToBTransform"]).unwrap();
    let there: Vec<_> = found
        .iter()
        .map(|f| (f.t_s, f.poses[0].is_some(), f.poses[1].is_some()))
        .collect();
    assert_eq!(
        there,
        [(Some(2.6), true, true), (Some(2.5), true, false), (None, false, false)]
    );
    let pose: geometry::Rigid<Tracker, Marker> = found[1].poses[0].unwrap().rigid().unwrap();
    assert_eq!(pose.translation_mm(), [5.0, 6.0, 7.0]);
    assert_eq!(header_end(b"A = 1\nElementDataFile = LOCAL\n\xff\xfe"), Some(30));
    assert_eq!(header_end(b"A = 1\n"), None);
}

proptest! {
    #[test]
    fn no_text_panics(text in "(Seq_Frame|[0-9]{1,12}|_|AToBTransform|Status|Timestamp| = |[-0-9. e]{0,9}|\n){0,40}") {
        let _ = frames(&text, &["AToB"]);
        let _ = ToolFile::parse(&text);
        let _ = RegistrationFile::parse(&text);
    }
}
