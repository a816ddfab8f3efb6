//! A patient who moves, with a marker on it and without.

use super::*;

const BREATH: &str = "[tracker.room.patient.breathing]\namplitude_mm = 10\nperiod_s = 4\ndirection = [0, 3, -4]\n";

#[test]
fn a_marker_on_the_patient_sees_it_breathe() {
    let room = approached(&scene(QUIET, &format!("{BREATH}[tracker.room.reference]\n")), 1);
    let origin = Point::<Reference>::new(0.0, 0.0, 0.0);
    let place = |seq| room.frame(seq).tracker_from_reference.unwrap() * origin;
    // 60 Hz: an expiration ends at frame 0, an inspiration at 120; a quarter of the way sin^4(pi/4) = 1/4 of the depth.
    for (seq, depth) in [(0, 0.0), (60, 2.5), (120, 10.0), (180, 2.5), (240, 0.0), (360, 10.0)] {
        let found = place(seq).distance(place(0));
        // Coordinates of 2300 mm.
        assert!((found - depth).abs() < 5e-12, "{seq}: {found}");
    }
    let ct_from_tracker = scene("", "").tracker.ct_from_tracker;
    let way = (ct_from_tracker * (place(120) - place(0))).mm();
    assert!(
        (way[0].abs() + (way[1] - 6.0).abs() + (way[2] + 8.0).abs()) < 1e-11,
        "{way:?}"
    );
}

#[test]
fn without_a_marker_the_motion_is_the_error() {
    let bump =
        "[tracker.room.patient.bump]\nat_s = 2\nover_s = 0\ntranslation_mm = [5, 0, 0]\nrotation_deg = [0, 0, 10]\n";
    for (motion, moved) in [
        (BREATH, [(0, 0.0), (120, 10.0), (240, 0.0)]),
        (bump, [(0, 0.0), (119, 0.0), (121, f64::NAN)]),
    ] {
        for referenced in [false, true] {
            let tables = format!("{motion}{}", if referenced { "[tracker.room.reference]\n" } else { "" });
            let room = approached(&scene(QUIET, &tables), 1);
            let chain = room.chain(middle()).unwrap();
            for (seq, expected_mm) in moved {
                let frame = room.frame(seq);
                let found = chain.solve(&frame.tool, &frame.reference).unwrap();
                let error = error_mm(&frame, &found, tip());
                let expected_mm = match expected_mm.is_nan() {
                    true => bumped_mm(frame.ct_from_tool * tip()),
                    false => expected_mm,
                };
                let expected_mm = if referenced { 0.0 } else { expected_mm };
                assert!(
                    (error - expected_mm).abs() < 2e-11,
                    "{motion} {referenced} {seq}: {error}"
                );
            }
        }
    }
}

/// How far (5, 0, 0) mm and 10 degrees about +z of the CT's origin move a point.
fn bumped_mm(p: Point<Ct>) -> f64 {
    let [x, y, _] = p.mm();
    let (sin, cos) = 10.0_f64.to_radians().sin_cos();
    (cos * x - sin * y + 5.0 - x).hypot(sin * x + cos * y - y)
}

#[test]
fn drift_goes_on_and_a_bump_is_smooth() {
    let tables = "[tracker.room.reference]\n[tracker.room.patient]\ndrift_mm_per_min = [6, 0, 0]\n\
        [tracker.room.patient.bump]\nat_s = 20\nover_s = 0.5\ntranslation_mm = [0, 0, 30]\n";
    let room = approached(&scene(QUIET, tables), 1);
    let origin = Point::<Reference>::new(0.0, 0.0, 0.0);
    let place = |seq| room.frame(seq).tracker_from_reference.unwrap() * origin;
    assert!((place(600).distance(place(0)) - 1.0).abs() < 5e-12);
    // The fastest of a smooth step is 1.5 times its mean speed: 30 mm in 30 frames, and the drift.
    let fastest = (1199..1232)
        .map(|seq| place(seq + 1).distance(place(seq)))
        .fold(0.0, f64::max);
    assert!((1.3..1.51).contains(&fastest), "{fastest}");
    let after = place(3600).distance(place(0));
    assert!((after - 6.0_f64.hypot(30.0)).abs() < 5e-12, "{after}");
}
