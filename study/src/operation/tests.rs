//! The truth that errors are told by, from the light alone.

use calib::registration::{Method, Pairs, fit};
use geometry::{Frame, Tool, Tracker, Vector};
use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector4};

use super::*;
use crate::plan::Plan;
use crate::truth::length;

fn plan() -> Plan {
    let text = "seed = 4\n[[stratum]]\nname = \"a\"\nct = { spacing_mm = [2.0, 2.0, 2.0], images = 1 }\nbeads = { diameter_mm = 4.0 }\n\
                bump = { share = 1.0, mm = 5.0, deg = 2.0 }\ncheck = { max_mm = 100.0 }\ntouch = { stated_mm = 5.0 }";
    Plan::of_texts([(Path::new("a.toml"), text)]).unwrap()
}

/// One operation of a stratum with these dials.
fn breathing(mm: f64) -> Plan {
    let text = format!(
        "seed = 4\n[all]\nct = {{ spacing_mm = [2.0, 2.0, 2.0], images = 1 }}\nbeads = {{ diameter_mm = 4.0 }}\n\
         [[stratum]]\nname = \"a\"\nbreathing = {{ mm = {mm:?}, period_s = 3.5 }}"
    );
    Plan::of_texts([(Path::new("a.toml"), text.as_str())]).unwrap()
}

/// What lays points on the places where they are seen.
fn seen<F: Frame>(places: &[Point<F>], sightings: &[calib::pose::Sighting]) -> Rigid<Tracker, F> {
    let to: Vec<Point<Tracker>> = sightings.iter().map(|sighting| sighting.place).collect();
    let from: Vec<Point<F>> = sightings.iter().map(|sighting| places[sighting.emitter]).collect();
    fit(Pairs::new(&to, &from).unwrap(), Method::Svd).unwrap().transform
}

/// The same as a matrix, by other code than the chain's.
fn matrix<A, B>(pose: &Rigid<A, B>) -> Matrix4<f64> {
    let ([w, x, y, z], t) = (pose.quaternion(), pose.translation_mm());
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_homogeneous();
    turn.append_translation(&nalgebra::Vector3::from(t))
}

/// The tool's true pose from places of emitters without noise, and the error at the target by matrices: both as they are told, after a
/// bump that nobody saw.
#[test]
fn the_truth_is_what_the_light_says() {
    let (plan, folder) = (plan(), tempfile::tempdir().unwrap());
    let images = Images::new(folder.path().join("images")).unwrap();
    let stratum = &plan.strata[0];
    let target = patient().targets()[1].clone();
    for number in 0..2 {
        let scratch = tempfile::tempdir().unwrap();
        let work = Work {
            stratum,
            seed: 77 + number,
            folder: scratch.path(),
        };
        let ready = ready(&work, number, &images, std::slice::from_ref(&target))
            .map_err(|refused| refused.why)
            .unwrap();
        let from = ready.room.next_frame();
        let task = task(5, (target.centre, None), 50.0, (&ready.quiet, from)).unwrap();
        let done = approach(&task, (&ready.room.localizer, &ready.chain), &stratum.dials, from, None).unwrap();
        let last = done.last.clone().unwrap();
        let quiet = ready.quiet.frame_at(last.frame.seq, last.frame.ct_from_tool);
        let emitters = ready.room.emitters();
        let on_patient: Vec<Point<Reference>> = ready
            .chain
            .reference
            .as_ref()
            .unwrap()
            .emitters()
            .iter()
            .map(|emitter| emitter.place)
            .collect();
        let ct_from_tracker = ready.room.ct_from_reference() * seen(&on_patient, &quiet.reference).inverse();
        let by_light: Rigid<Ct, Tool> =
            ct_from_tracker * seen(&emitters, &quiet.tool) * ready.room.room.marker_from_tool;
        for p in [Point::new(0.0, 0.0, 0.0), Point::new(30.0, -20.0, 100.0)] {
            // Fits of places of 2300 mm to rounding, and levers of some hundred mm over balls of 50: 1e-11 mm times 10.
            assert!(
                (by_light * p).distance(last.frame.ct_from_tool * p) < 1e-9,
                "{by_light:?} {:?}",
                last.frame.ct_from_tool
            );
        }
        let told = told(
            &ready.truth,
            &ready.chain,
            (&last.frame, &quiet),
            &last.pose,
            (target.centre, None),
        )
        .unwrap();
        let [x, y, z] = target.centre.mm();
        let place = Vector4::new(x, y, z, 1.0);
        let shown = matrix(&last.pose.transform()) * matrix(&by_light).try_inverse().unwrap() * place;
        let error = Vector::<Ct>::new(shown.x - x, shown.y - y, shown.z - z);
        let [a, b, c] = told.error;
        assert!(
            (error - Vector::new(a, b, c)).norm() < 1e-8,
            "{error:?} {:?}",
            told.error
        );
        // 5 mm and 2 degrees about the marker on the patient, 200 mm from the target.
        assert!(
            length(told.links[1].found) > 1.0 && error.norm() > 1.0,
            "{:?}",
            told.links[1]
        );
        assert!(told.rest_mm() < 0.3, "{}", told.rest_mm());
        // The tip, too: where the outcome says that it is.
        let tip = by_light * Point::<Tool>::new(0.0, 0.0, 0.0);
        // The last picture is 50 ms old, and the hand trembles: 20 deviations of 0.07 mm times the lever.
        assert!(
            (tip.distance(target.centre) - done.outcome.miss_mm).abs() < 2.0,
            "{tip:?}"
        );
    }
}

/// Of 10 mm: the link's error is the formula's at the time of the last frame, seq / rate; the whole is that of the tool as it is shown to
/// where the target has gone, by matrices; and the miss is to where it has gone when the operator lets go.
#[test]
fn a_target_that_breathes_is_missed_by_what_the_formula_says() {
    let (plan, folder) = (breathing(10.0), tempfile::tempdir().unwrap());
    let images = Images::new(folder.path().join("images")).unwrap();
    let stratum = &plan.strata[0];
    let target = patient().targets()[1].clone();
    let mut largest: f64 = 0.0;
    for number in 0..3 {
        let (scratch, seed) = (tempfile::tempdir().unwrap(), 90 + number);
        let work = Work {
            stratum,
            seed,
            folder: scratch.path(),
        };
        let ready = ready(&work, number, &images, std::slice::from_ref(&target));
        let ready = ready.map_err(|refused| refused.why).unwrap();
        let phase = std::f64::consts::PI * Chance::new(seed, 20).uniform(0);
        let down_mm = |t_s: f64| 10.0 * (std::f64::consts::PI * t_s / 3.5 + phase).cos().powi(6);
        let from = ready.room.next_frame();
        let task = task(5, (target.centre, None), 5.0, (&ready.quiet, from)).unwrap();
        let done = approach(&task, (&ready.room.localizer, &ready.chain), &stratum.dials, from, None).unwrap();
        let organs = Organs::Breathe(ready.breath.unwrap());
        let row = empty(stratum, number, &target);
        let row = ready.told(&done, (target.centre, target.centre), &organs, (1.0, row));
        let last = done.last.as_ref().unwrap();
        let quiet = ready.quiet.frame_at(last.frame.seq, last.frame.ct_from_tool);
        let told = told(
            &ready.truth,
            &ready.chain,
            (&last.frame, &quiet),
            &last.pose,
            (target.centre, organs.moved(last.frame.t_capture_ns).unwrap()),
        )
        .unwrap();
        let shown_down = down_mm(last.frame.seq as f64 / 60.0);
        let [x, y, z] = told.links[6].found;
        // Capture times are whole ns.
        assert!(
            x == 0.0 && y == 0.0 && (z + shown_down).abs() < 1e-6,
            "{:?} {shown_down}",
            told.links[6]
        );
        assert_eq!((row.links[6][0], told.links[6].predicted_rms_mm), (z.abs(), None));
        largest = largest.max(shown_down);
        let [x, y, z] = target.centre.mm();
        let truly = matrix(&last.frame.ct_from_tool).try_inverse().unwrap();
        let shown = matrix(&last.pose.transform()) * truly * Vector4::new(x, y, z - shown_down, 1.0);
        let off = (shown.x - x).hypot(shown.y - y).hypot(shown.z - z);
        assert!((off - row.tre_mm).abs() < 1e-8, "{off} {}", row.tre_mm);
        // 10 mm by the 0.01 rad that a pose may be turned.
        assert!(row.rest_mm < 0.1, "{}", row.rest_mm);
        let end_s = (from + 200) as f64 / 60.0 + row.time_s;
        let gone = target.centre + Vector::new(0.0, 0.0, -down_mm(end_s));
        assert!(
            (row.miss_mm - done.outcome.tip.distance(gone)).abs() < 1e-9,
            "{}",
            row.miss_mm
        );
        assert!((done.outcome.tip.distance(target.centre) - done.outcome.miss_mm).abs() < 1e-9);
    }
    assert!(
        largest > 1.0,
        "none of them was far from the end of an expiration: {largest}"
    );
}

/// Off by more than the registration's own radius, or than is allowed: else the check was wrong.
#[test]
fn a_refusal_of_the_check_is_judged_by_the_true_error() {
    for (check, registration, max_mm, right) in [
        (FAIL, [1.0, 2.0], 4.0, Some(false)),
        (FAIL, [3.0, 2.0], 4.0, Some(true)),
        (FAIL, [3.0, 9.0], 4.0, Some(false)),
        (FAIL, [5.0, 9.0], 4.0, Some(true)),
        (NOT_MADE, [5.0, 2.0], 4.0, None),
    ] {
        assert_eq!(is_right(check, registration, max_mm), right, "{check} {registration:?}");
    }
}
