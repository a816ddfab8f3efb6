//! Files of calibrations and registrations: read, checked, and held against the scene's gates.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use calib::file::{FileError, MAX_BYTES, Registered, RegistrationFile, ToolFile};
use calib::gate::{Gates, Reached, Verdict};
use geometry::{Ct, Marker, Point, Tool, Uncertain};
use scene::tracking::{CalibrationLink, RegistrationLink};

use crate::chain::Registration;

/// What the files must have been made for.
#[derive(Debug, Clone)]
pub(super) struct Expected {
    pub(super) tool: String,
    pub(super) ct_hash: String,
    pub(super) has_reference: bool,
    /// The point of the patient at which the registration's error counts.
    pub(super) target: Point<Ct>,
}

/// The tool's frame in its marker from its file.
pub(super) fn calibration(link: &CalibrationLink, expected: &Expected) -> Result<Uncertain<Marker, Tool>, String> {
    calibration_of(link, &expected.tool)
}

/// The same for a tool of this name.
pub(crate) fn calibration_of(link: &CalibrationLink, tool: &str) -> Result<Uncertain<Marker, Tool>, String> {
    let path = &link.file.path;
    let failed = |error: FileError| format!("{}: {error}", name(path));
    let file = ToolFile::parse(&text(path)?).map_err(failed)?;
    let marker = link.file.marker.as_deref().unwrap_or(&file.marker);
    file.of(tool, marker).map_err(failed)?;
    let gates = Gates {
        max_rms_mm: link.gates.max_rms_mm,
        max_tip_error_mm: link.gates.max_tip_error_mm,
        max_condition: link.gates.max_condition,
        min_coverage_rad: link.gates.min_cone_rad,
        ..Gates::default()
    };
    passed(path, "calibration", &gates, &file.reached)?;
    Ok(file.marker_from_tool)
}

/// The patient's place from its file.
#[derive(Debug, Clone)]
pub(super) struct Filed {
    pub(super) registration: Registration,
    /// What keeps nobody from using it, and should be known.
    pub(super) warning: Option<String>,
}

/// Reads it.
pub(super) fn registration(link: &RegistrationLink, expected: &Expected) -> Result<Filed, String> {
    let path = &link.file.path;
    let failed = |error: FileError| format!("{}: {error}", name(path));
    let file = RegistrationFile::parse(&text(path)?).map_err(failed)?;
    if file.ct_hash.is_none() && !link.unchecked_ct {
        return Err(format!(
            "{}: does not say of which CT it is; make it with calib register --ct, or set tracker.registration.unchecked_ct",
            name(path)
        ));
    }
    let (own, asked) = (file.marker.as_deref(), link.file.marker.as_deref());
    if let (None, Some(asked)) = (own, asked) {
        return Err(format!(
            "{}: does not say of which marker it is, and {asked:?} is used; make it with --marker, or leave tracker.registration.marker out",
            name(path)
        ));
    }
    file.of(&expected.ct_hash, asked.or(own).unwrap_or_default())
        .map_err(failed)?;
    let gates = Gates {
        max_rms_mm: link.gates.max_fre_mm,
        max_condition: link.gates.max_condition,
        max_target_mm: link.gates.max_tre_mm,
        ..Gates::default()
    };
    passed(path, "registration", &gates, &file.reached(expected.target))?;
    let registration = match file.registered {
        // The marker on the patient would be looked at by nobody.
        Registered::Fixed(_) if expected.has_reference => {
            return Err(format!(
                "{}: found a registration from tracker, expected one from reference: the scene has a marker on the patient, whose motion would not be followed",
                name(path)
            ));
        }
        Registered::Fixed(ct_from_tracker) => Registration::Fixed(ct_from_tracker),
        Registered::Referenced(ct_from_reference) if expected.has_reference => {
            Registration::Referenced(ct_from_reference)
        }
        Registered::Referenced(_) => {
            return Err(format!("{}: rests on a reference, and the scene has none", name(path)));
        }
    };
    let too_small = || format!("{}: errors are more than is stated: {UNTOLD}", name(path));
    Ok(Filed {
        registration,
        warning: file.lacks_shared.then(too_small),
    })
}

/// Of a registration that lacks it.
const UNTOLD: &str = "its touches do not tell the error of the tip's calibration";

/// Refuses what does not keep the gates of the scene.
fn passed(path: &Path, table: &str, gates: &Gates, reached: &Reached) -> Result<(), String> {
    match gates.judge(reached) {
        Verdict::Accepted => Ok(()),
        verdict @ Verdict::Refused(_) => Err(format!(
            "{}: by the gates of tracker.{table}.gates {verdict}",
            name(path)
        )),
    }
}

/// The name of a file without its folder: what fits on a line.
pub(super) fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The text of a file of bounded length.
fn text(path: &Path) -> Result<String, String> {
    let failed = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("{} is not there", name(path)),
        _ => format!("{}: {error}", name(path)),
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(format!("{} is no file", name(path)));
    }
    let mut text = String::new();
    let most = MAX_BYTES as u64 + 1;
    File::open(path)
        .and_then(|file| file.take(most).read_to_string(&mut text))
        .map_err(failed)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use calib::file::content_id;
    use geometry::Point;
    use scene::tracking::{CalibrationGates, LinkFile, RegistrationGates};
    use serde_json::{Value, json};

    use super::*;

    fn put(value: &Value) -> (tempfile::TempDir, LinkFile) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f.json");
        fs::write(&path, value.to_string()).unwrap();
        (folder, LinkFile { path, marker: None })
    }

    /// A tip that is off by 0.2001 mm rms by its covariance (the turns of 1e-6 act at 3.7 mm), from a pivoting of 30 degrees.
    fn tool() -> Value {
        let mut upper = [0.0; 21];
        for (place, variance) in [(0, 1e-6), (6, 1e-6), (11, 1e-6), (15, 0.01), (18, 0.01), (20, 0.02)] {
            upper[place] = variance;
        }
        let axis = |angle: f64| json!({ "angle_deg": angle });
        let mut value = json!({
            "trocar_calibration": 1, "kind": "tool", "date_utc": "", "tool": "scope", "marker": "ball",
            "verdict": "accepted", "gates": [],
            "tool_frame": {"quaternion_wxyz": [1.0, 0.0, 0.0, 0.0], "translation_mm": [1.0, 2.0, 3.0],
                "covariance_upper": upper},
            "pivot": {"inliers": 400, "rms_mm": 0.3, "condition": 7.0,
                "coverage": {"principal": [axis(40.0), axis(30.0), axis(1.0)]}},
        });
        value["id"] = content_id(value.clone()).into();
        value
    }

    #[test]
    fn a_calibration_that_fails_the_scenes_gates_is_refused_by_name() {
        let (_folder, file) = put(&tool());
        let with = |gates| {
            calibration_of(
                &CalibrationLink {
                    file: file.clone(),
                    gates,
                },
                "scope",
            )
        };
        let kept = CalibrationGates {
            max_rms_mm: Some(0.3),
            max_tip_error_mm: Some(0.21),
            max_condition: Some(7.0),
            min_cone_rad: Some(29.9_f64.to_radians()),
        };
        assert!(with(CalibrationGates::default()).is_ok() && with(kept).is_ok());
        let rms = CalibrationGates {
            max_rms_mm: Some(0.2),
            ..kept
        };
        let tip = CalibrationGates {
            max_tip_error_mm: Some(0.19),
            ..kept
        };
        let condition = CalibrationGates {
            max_condition: Some(6.0),
            ..kept
        };
        let cone = CalibrationGates {
            min_cone_rad: Some(0.6),
            ..kept
        };
        for (gates, words) in [
            (rms, "root mean square residual, mm: 0.3000, at most 0.2000"),
            (tip, "error of the tip, mm: 0.2001, at most 0.1900"),
            (condition, "condition: 7.0000, at most 6.0000"),
            (cone, "motion covered, degrees: 30.0000, at least 34.3775"),
        ] {
            let error = with(gates).unwrap_err();
            assert!(
                error.starts_with("f.json: by the gates of tracker.calibration.gates"),
                "{error}"
            );
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn what_a_gate_asks_for_and_the_file_does_not_say_is_refused() {
        let mut value = tool();
        value.as_object_mut().unwrap().remove("pivot");
        value["id"] = content_id(value.clone()).into();
        let (_folder, file) = put(&value);
        let gates = CalibrationGates {
            min_cone_rad: Some(0.3),
            ..CalibrationGates::default()
        };
        let error = calibration_of(&CalibrationLink { file, gates }, "scope").unwrap_err();
        assert!(error.contains("motion covered, degrees: not measured"), "{error}");
    }

    /// 1 mm^2 along each axis: 95 % within 2.7955 mm.
    fn registered() -> Value {
        let row = |i: usize| -> Vec<f64> { (0..6).map(|j| if i == j && i > 2 { 1.0 } else { 0.0 }).collect() };
        json!({
            "format": "trocar-registration", "version": 1, "to": "ct", "from": "tracker", "fre_rms_mm": 0.7,
            "condition": 3.0, "ct_hash": "ab", "covariance": (0..6).map(row).collect::<Vec<_>>(),
            "transform": {"quaternion_wxyz": [1.0, 0.0, 0.0, 0.0], "translation_mm": [1.0, 2.0, 3.0], "scale": 1.0},
        })
    }

    fn read(value: &Value, unchecked_ct: bool, gates: RegistrationGates) -> Result<Filed, String> {
        read_beside(false, value, unchecked_ct, gates)
    }

    fn read_beside(
        has_reference: bool,
        value: &Value,
        unchecked_ct: bool,
        gates: RegistrationGates,
    ) -> Result<Filed, String> {
        let (_folder, file) = put(value);
        let expected = Expected {
            tool: "scope".to_owned(),
            ct_hash: "ab".to_owned(),
            has_reference,
            target: Point::new(10.0, 20.0, 30.0),
        };
        registration(
            &RegistrationLink {
                file,
                unchecked_ct,
                gates,
            },
            &expected,
        )
    }

    #[test]
    fn a_registration_that_fails_the_scenes_gates_is_refused_by_name() {
        let kept = RegistrationGates {
            max_fre_mm: Some(0.7),
            max_condition: Some(3.0),
            max_tre_mm: Some(2.9),
        };
        assert!(read(&registered(), false, kept).is_ok());
        let fre = RegistrationGates {
            max_fre_mm: Some(0.6),
            ..kept
        };
        let condition = RegistrationGates {
            max_condition: Some(2.0),
            ..kept
        };
        let tre = RegistrationGates {
            max_tre_mm: Some(2.5),
            ..kept
        };
        for (gates, words) in [
            (fre, "root mean square residual, mm: 0.7000, at most 0.6000"),
            (condition, "condition: 3.0000, at most 2.0000"),
            (tre, "error predicted at the target (95 %), mm: 2.79"),
        ] {
            let error = read(&registered(), false, gates).unwrap_err();
            assert!(
                error.contains("tracker.registration.gates") && error.contains(words),
                "{error}"
            );
        }
    }

    /// The scene asked for a marker, and a file that names none was taken for one of it.
    #[test]
    fn a_registration_that_names_no_marker_is_none_of_the_scenes_marker() {
        let of = |own: Option<&str>, asked: Option<&str>| {
            let mut value = registered();
            value["marker"] = own.into();
            let (_folder, file) = put(&value);
            let marker = asked.map(str::to_owned);
            let link = RegistrationLink {
                file: LinkFile { marker, ..file },
                unchecked_ct: false,
                gates: RegistrationGates::default(),
            };
            let expected = Expected {
                tool: "scope".to_owned(),
                ct_hash: "ab".to_owned(),
                has_reference: false,
                target: Point::new(10.0, 20.0, 30.0),
            };
            registration(&link, &expected).map(drop)
        };
        let refused = of(None, Some("skull")).unwrap_err();
        assert!(
            refused.starts_with("f.json: does not say of which marker it is, and \"skull\" is used"),
            "{refused}"
        );
        assert!(of(Some("leg"), Some("skull")).is_err());
        for (own, asked) in [(Some("skull"), Some("skull")), (Some("leg"), None), (None, None)] {
            assert_eq!(of(own, asked), Ok(()));
        }
    }

    /// That the covariance is too small was said by the command that wrote the file, and to nobody later.
    #[test]
    fn a_registration_that_lacks_what_touches_share_is_used_with_a_warning() {
        let with = |key: &str, part: Value| {
            let mut value = registered();
            value[key] = part;
            read(&value, false, RegistrationGates::default()).unwrap().warning
        };
        let columns = vec![[0.0; 3]; 6];
        assert_eq!(with("shared", json!({ "calibration": null, "columns": columns })), None);
        assert_eq!(with("noise", json!({ "touches": { "shared_mm": 0.2 } })), None);
        assert_eq!(with("noise", json!({ "sigma_mm": 0.3 })), None);
        for (key, part) in [
            ("shared", json!({ "calibration": null, "columns": null })),
            ("noise", json!({ "touches": { "own_mm": 0.2, "shared_mm": null } })),
        ] {
            let warning = with(key, part).unwrap();
            assert!(
                warning.starts_with("f.json: errors are more than is stated: "),
                "{warning}"
            );
        }
    }

    /// It was in use, and the patient's motion was followed by nobody.
    #[test]
    fn a_registration_from_the_tracker_does_not_switch_the_marker_on_the_patient_off() {
        let gates = RegistrationGates::default();
        let error = read_beside(true, &registered(), false, gates).unwrap_err();
        assert!(
            error.starts_with("f.json: found a registration from tracker, expected one from reference"),
            "{error}"
        );
        let mut value = registered();
        value["from"] = "reference".into();
        let filed = read_beside(true, &value, false, gates).unwrap();
        assert!(matches!(filed.registration, Registration::Referenced(_)));
    }

    #[test]
    fn a_registration_of_no_ct_is_refused_unless_the_scene_takes_it() {
        let none = RegistrationGates::default();
        let mut value = registered();
        value.as_object_mut().unwrap().remove("ct_hash");
        let error = read(&value, false, none).unwrap_err();
        assert!(
            error.contains("does not say of which CT it is") && error.contains("unchecked_ct"),
            "{error}"
        );
        assert!(read(&value, true, none).is_ok());
        // One of another CT is refused in any case.
        value["ct_hash"] = "cd".into();
        let error = read(&value, true, none).unwrap_err();
        assert!(error.contains("made for the CT \"cd\""), "{error}");
    }
}
