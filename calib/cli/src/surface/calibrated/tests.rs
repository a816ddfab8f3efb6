//! Which images and which tool a calibration is taken for.

use super::*;
use crate::commands::probe::ArrayRecord;
use ultrasound::Beams;

/// Of images of 200 x 300 pixels of 0.1 mm, 30 mm deep, by a linear array.
pub(in crate::surface) fn calibrated(images: ImagesRecord) -> Calibrated {
    Calibrated {
        path: "probe.json".into(),
        id: "0123".to_owned(),
        marker_from_image: Uncertain::from_upper(Rigid::identity(), [0.0; 21]).unwrap(),
        pixel_mm: [0.1; 2],
        lag_s: [0.0; 2],
        images,
        water_celsius: None,
    }
}

fn images() -> ImagesRecord {
    ImagesRecord {
        size_px: Some([200, 300]),
        orientation: Some("MF".to_owned()),
        array: Some(ArrayRecord::Linear {
            from_px: 0.0,
            to_px: 199.0,
            face_px: 0.0,
        }),
        lines: None,
        depth_mm: Some(30.0),
        tool: Some("Probe".to_owned()),
        marker: Some("Probe".to_owned()),
        reference: Some("Reference".to_owned()),
    }
}

fn shape(size: [usize; 2], pixel_mm: f64, [from_mm, to_mm, face_mm]: [f64; 3], depth_mm: f64) -> Shape {
    let beams = Beams::Linear {
        from_mm,
        to_mm,
        face_mm,
    };
    Shape::new(size, [pixel_mm; 2], beams, depth_mm).unwrap()
}

/// A crop, a picture that was moved, another depth with pixels of the same size and another array went unseen.
#[test]
fn images_that_are_not_those_of_the_calibration_are_refused_with_found_and_expected() {
    let probe = calibrated(images());
    let words = |shape: &Shape| probe.holds_for(7, shape).unwrap_err().to_string();
    let own = [0.0, 19.9, 0.0];
    assert!(probe.holds_for(7, &shape([200, 300], 0.1, own, 30.0)).is_ok());
    // Drawn by hand and told by the scanner: 2 pixels apart.
    assert!(
        probe
            .holds_for(7, &shape([200, 300], 0.1, [0.2, 19.8, 0.1], 30.3))
            .is_ok()
    );
    for (other, told) in [
        (
            shape([180, 300], 0.1, [0.0, 17.9, 0.0], 30.0),
            "image 7 has 180 x 300 pixels, and the probe was calibrated with 200 x 300",
        ),
        (
            shape([200, 300], 0.1, [2.0, 21.9, 0.0], 30.0),
            "where its beams run: a linear array, beams in columns 20.0 to 219.0, face in row 0.0, and the probe was calibrated \
             with a linear array, beams in columns 0.0 to 199.0",
        ),
        (shape([200, 300], 0.1, [0.0, 19.9, 2.0], 30.0), "face in row 20.0"),
        (
            shape([200, 300], 0.1, own, 25.0),
            "a depth of 25.0 mm, and the probe was calibrated at 30.0 mm",
        ),
        (
            shape([200, 300], 0.103, [0.0, 20.5, 0.0], 30.0),
            "pixels of 0.103 x 0.103 mm",
        ),
    ] {
        let words = words(&other);
        assert!(words.contains(told), "{words}");
    }
    let curved = Beams::Convex {
        centre_mm: [10.0, -60.0],
        radius_mm: 60.0,
        half_angle: 0.3,
    };
    let curved = Shape::new([200, 300], [0.1; 2], curved, 30.0).unwrap();
    assert!(
        words(&curved).contains("image 7 has a curved array"),
        "{}",
        words(&curved)
    );
    // And the curved one's own, whose radius is told to a per cent.
    let own = calibrated(ImagesRecord {
        array: Some(ArrayRecord::Curved {
            centre_px: [100.0, -606.0],
            radius_px: 606.0,
            angle_deg: 34.5,
        }),
        ..images()
    });
    assert!(own.holds_for(7, &curved).is_ok(), "{:?}", own.holds_for(7, &curved));
}

#[test]
fn what_a_calibration_does_not_say_is_refused_unless_it_is_accepted() {
    assert_eq!(calibrated(images()).unchecked(false).unwrap(), None);
    let older = calibrated(ImagesRecord::default());
    let words = older.unchecked(false).unwrap_err().to_string();
    assert!(
        words.contains("probe.json does not say the size of the images, the array (--array or --scan), the depth")
            && words.contains("--unchecked-images"),
        "{words}"
    );
    assert!(older.unchecked(true).unwrap().unwrap().contains("the tool"));
    let shallow = calibrated(ImagesRecord {
        depth_mm: None,
        ..images()
    });
    assert!(
        shallow
            .unchecked(false)
            .unwrap_err()
            .to_string()
            .contains("does not say the depth")
    );
    // How images are turned is compared where both say it, and told where one does not: never silent.
    let own = calibrated(images());
    assert_eq!(own.not_compared(true), None);
    assert!(
        own.not_compared(false)
            .unwrap()
            .starts_with("the run's images do not say")
    );
    let unsaid = calibrated(ImagesRecord::default());
    assert!(
        unsaid
            .not_compared(true)
            .unwrap()
            .starts_with("the probe's calibration")
    );
    assert!(unsaid.not_compared(false).unwrap().starts_with("neither"));
    assert!(own.is_turned_alike(7, Some("MFA")).is_ok() && own.is_turned_alike(7, None).is_ok());
    for turned in ["UF", "MN", "FM"] {
        assert!(own.is_turned_alike(7, Some(turned)).is_err(), "{turned}");
    }
}

#[test]
fn another_tool_s_probe_is_refused_by_name() {
    let probe = calibrated(images());
    assert!(probe.of_tool("probe", None).is_ok());
    let words = probe.of_tool("endoscope", None).unwrap_err().to_string();
    assert!(
        words.contains("of the tool \"Probe\"") && words.contains("run's tool is \"endoscope\""),
        "{words}"
    );
    assert!(probe.of_tool("endoscope", Some("Probe")).is_ok());
    let words = probe.of_tool("probe", Some("other")).unwrap_err().to_string();
    assert!(words.contains("--probe-tool \"other\""), "{words}");
}

/// Points of one calibration with the errors of another are points of nothing.
#[test]
fn points_of_another_calibration_are_refused() {
    let probe = calibrated(images());
    let path = Path::new("seen.csv");
    let file = |line: &str| format!("# places\n{line}\nx,y,z\n");
    assert_eq!(probe.made(path, &file(&probe.comment()), false).unwrap(), None);
    let words = probe
        .made(path, &file("# by the probe's calibration 9"), true)
        .unwrap_err()
        .to_string();
    assert!(
        words.contains("calibration \"9\"") && words.contains("\"0123\""),
        "{words}"
    );
    let words = probe.made(path, "x,y,z\n", false).unwrap_err().to_string();
    assert!(words.contains("seen.csv does not say that its points"), "{words}");
    assert!(probe.made(path, "x,y,z\n", true).unwrap().is_some());
    let unknown = calibrated(ImagesRecord::default());
    let told = unknown.made(path, &file(&unknown.comment()), false).unwrap().unwrap();
    assert!(told.contains("not compared: the size of the images"), "{told}");
}

/// Water of 20 degrees was refused as a depth that was changed, and as nothing else.
#[test]
fn a_probe_that_was_calibrated_in_cold_water_is_refused_with_the_likely_causes() {
    let own = [0.0, 19.9, 0.0];
    // Found in water of 20 degrees: 1482.4 of 1540 of what the scanner says.
    let mut probe = calibrated(ImagesRecord::default());
    probe.pixel_mm = [0.1, 0.1 * 1482.38 / 1540.0];
    let words = probe
        .holds_for(7, &shape([200, 300], 0.1, own, 30.0))
        .unwrap_err()
        .to_string();
    for part in [
        "the depth was changed since",
        "in water of about 20 C",
        "3.9 % too",
        "--water-celsius",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    probe.water_celsius = Some(20.0);
    let words = probe
        .holds_for(7, &shape([200, 300], 0.1, own, 30.0))
        .unwrap_err()
        .to_string();
    assert!(words.contains("not that of 20.0 C that was told"), "{words}");
    probe.pixel_mm = [0.05; 2];
    probe.water_celsius = None;
    let words = probe
        .holds_for(7, &shape([200, 300], 0.1, own, 30.0))
        .unwrap_err()
        .to_string();
    assert!(
        words.contains("the depth was changed since; calibrate") && !words.contains("water"),
        "{words}"
    );
}

/// Points of a probe were registered without its calibration: with errors that were told too small, up to 2 mm, and no look for a mirror.
#[test]
fn points_of_a_calibrated_probe_are_not_taken_without_it() {
    let text = |second: &str| format!("# points of probe in reference\n{second}\non,x,y,z\n");
    let words = |second: &str| without_probe("p.csv".as_ref(), &text(second)).map_err(|error| error.to_string());
    let seen = calibrated(images()).comment();
    assert!(words(&seen).unwrap_err().contains("calibration \"0123\": say --probe"));
    let unsaid = calibrated(ImagesRecord::default()).comment();
    assert!(words(&unsaid).is_err());
    let matrix = Calibrated {
        id: BY_MATRIX.to_owned(),
        ..calibrated(ImagesRecord::default())
    };
    assert_eq!(words(&matrix.comment()), Ok(()));
    assert_eq!(words("1,2,3"), Ok(()));
    // A note above, a byte order mark and a changed letter turned this off.
    for changed in [
        format!("# ward 4\n\n{seen}"),
        format!("  {seen}  "),
        seen.replace("# by", "#by"),
        seen.replace("calibration", "calibrations"),
        format!("{}\n{seen}", matrix.comment()),
    ] {
        assert!(words(&changed).unwrap_err().contains("say --probe"), "{changed}");
    }
    assert!(without_probe("p.csv".as_ref(), &format!("\u{feff}{seen}\nx,y,z\n")).is_err());
}
