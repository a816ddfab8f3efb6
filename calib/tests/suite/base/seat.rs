//! The tool in its seat: the mean over frames, its covariance, and a tool that moved.

use super::*;
use calib::base::{Refused, mean, seated, seen_from_marker};
use geometry::{Marker, Reference, Tool, Uncertain};

/// A motion of this covariance after the transform.
fn disturbed<A, B>(random: &mut Random, truth: Rigid<A, B>, covariance: &Matrix6<f64>) -> Rigid<A, B> {
    let factor = covariance.cholesky().unwrap().l();
    let e = factor * Vector6::from_fn(|_, _| random.normal());
    let w = Vector::<A>::new(e[0], e[1], e[2]);
    let step: Rigid<A, A> = Rigid::from_rotation_vector(w, Vector::new(e[3], e[4], e[5])).unwrap();
    step * truth
}

/// Variances of a marker's pose: 0.5 mrad and 0.05 mm about the marker, 0.1 mm in depth.
fn covariance<A: geometry::Frame, B: geometry::Frame>(truth: Rigid<A, B>, scale: f64) -> Uncertain<A, B> {
    let deviations = Vector6::new(5e-4, 5e-4, 3e-4, 0.05, 0.05, 0.1) * scale;
    let about = Matrix6::from_diagonal(&deviations.component_mul(&deviations));
    let c = truth * Point::new(0.0, 0.0, 0.0);
    Uncertain::from_covariance_about(c, truth, about).unwrap()
}

struct Room {
    tracker_from_marker: Rigid<Tracker, Marker>,
    tracker_from_reference: Rigid<Tracker, Reference>,
    reference_from_base: Rigid<Reference, Base>,
    base_from_tool: Rigid<Base, Tool>,
}

fn rigid<A, B>(random: &mut Random, size: f64, depth: f64) -> Rigid<A, B> {
    let shift = random.vector::<A>(size) + Vector::new(0.0, 0.0, depth);
    Rigid::from_rotation_vector(random.vector(1.5), shift).unwrap()
}

impl Room {
    fn new(random: &mut Random) -> Self {
        Self {
            tracker_from_marker: rigid(random, 100.0, -2000.0),
            tracker_from_reference: rigid(random, 150.0, -2000.0),
            reference_from_base: rigid(random, 80.0, 0.0),
            base_from_tool: rigid(random, 100.0, 0.0),
        }
    }

    fn truth(&self) -> Rigid<Marker, Tool> {
        let marker_from_reference = self.tracker_from_marker.inverse() * self.tracker_from_reference;
        marker_from_reference * self.reference_from_base * self.base_from_tool
    }

    /// One frame with noise, and its claimed covariance.
    fn frame(&self, random: &mut Random) -> Uncertain<Marker, Reference> {
        let marker = covariance(self.tracker_from_marker, 1.0);
        let reference = covariance(self.tracker_from_reference, 1.5);
        let noisy = |u: Rigid<Tracker, Marker>| Uncertain::new(u, marker.covariance()).unwrap();
        let marker = noisy(disturbed(random, self.tracker_from_marker, &marker.covariance()));
        let seen = disturbed(random, self.tracker_from_reference, &reference.covariance());
        seen_from_marker(&marker, &Uncertain::new(seen, reference.covariance()).unwrap())
    }
}

#[test]
fn the_covariance_of_the_seated_tool_is_the_counted_one() {
    const TRIALS: usize = 4000;
    let mut random = Random::new(70);
    let room = Room::new(&mut random);
    let base = covariance(room.reference_from_base, 1.0);
    let seat = covariance(room.base_from_tool, 0.4);
    let (mut counted, mut predicted) = (Matrix6::zeros(), Matrix6::zeros());
    let mut ratio = 0.0;
    for _ in 0..TRIALS {
        let frames: Vec<_> = (0..10).map(|_| room.frame(&mut random)).collect();
        let base = disturbed(&mut random, room.reference_from_base, &base.covariance());
        let base = Uncertain::new(base, covariance(room.reference_from_base, 1.0).covariance()).unwrap();
        let seat = Uncertain::new(
            disturbed(&mut random, room.base_from_tool, &seat.covariance()),
            seat.covariance(),
        );
        let found = seated(&frames, &base, &seat.unwrap(), 8.0).unwrap();
        let e = error(room.truth(), found.marker_from_tool.transform());
        counted += e * e.transpose() / TRIALS as f64;
        predicted += found.marker_from_tool.covariance() / TRIALS as f64;
        ratio += found.ratio.powi(2) / TRIALS as f64;
    }
    let seen = whitened(&counted, &predicted);
    // Five deviations of a counted variance: 5 sqrt(2 / 4000); second order terms are 1e-3 of it.
    assert!((seen - Matrix6::identity()).amax() < 0.115, "{seen}");
    assert!((seen.trace() / 6.0 - 1.0).abs() < 0.048, "{seen}");
    assert!(
        (ratio - 1.0).abs() < 5.0 * (2.0_f64 / 54.0 / 4000.0).sqrt() + 2e-3,
        "{ratio}"
    );
}

#[test]
fn more_frames_leave_the_error_of_the_base() {
    let mut random = Random::new(71);
    let room = Room::new(&mut random);
    let base = covariance(room.reference_from_base, 1.0);
    let exact = Uncertain::from(room.base_from_tool);
    let rms_of = |frames: usize, random: &mut Random, base: &Uncertain<Reference, Base>| {
        let frames: Vec<_> = (0..frames).map(|_| room.frame(random)).collect();
        let found = seated(&frames, base, &exact, 8.0).unwrap();
        (found.marker_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0)).rms_mm()
    };
    let free = Uncertain::from(room.reference_from_base);
    let (one, hundred) = (rms_of(1, &mut random, &free), rms_of(100, &mut random, &free));
    // A tenth of the deviation; the poses at which it is taken differ by less than a hundredth.
    assert!((10.0 * hundred / one - 1.0).abs() < 0.02, "{one} {hundred}");
    let with_base = rms_of(100, &mut random, &base);
    let alone = (Uncertain::from(room.base_from_tool.inverse()) * base.inverse() * Point::new(0.0, 0.0, 0.0)).rms_mm();
    assert!(alone > 0.0 && with_base > 2.0 * hundred, "{with_base} {hundred}");
}

#[test]
fn one_frame_passes_through_and_equal_frames_are_their_own_mean() {
    let mut random = Random::new(72);
    let room = Room::new(&mut random);
    let frame = room.frame(&mut random);
    for count in [1, 2, 50] {
        let found = mean(&vec![frame; count], 6.0).unwrap();
        // The mean turns and carries by rounding only.
        assert!(error(frame.transform(), found.mean.transform()).norm() < 1e-11);
        let share = found.mean.covariance() * count as f64;
        let scale = frame.covariance().diagonal().map(|x| 1.0 / x.sqrt());
        let off = Matrix6::from_diagonal(&scale) * (share - frame.covariance()) * Matrix6::from_diagonal(&scale);
        // Two inversions of a correlation matrix of condition 1e4 or so.
        assert!(off.amax() < 1e-8, "{off}");
    }
}

#[test]
fn a_tool_that_moved_is_named() {
    let mut random = Random::new(73);
    let mut room = Room::new(&mut random);
    let mut frames: Vec<_> = (0..12).map(|_| room.frame(&mut random)).collect();
    let slip: Rigid<Marker, Marker> =
        Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.02), Vector::new(2.0, 0.0, 0.0)).unwrap();
    room.tracker_from_marker = room.tracker_from_marker * slip;
    frames[7] = room.frame(&mut random);
    let refused = mean(&frames, 6.0).unwrap_err();
    assert!(
        matches!(refused, Refused::Moved { frame: 7, frames: 12, found, .. } if found > 6.0),
        "{refused}"
    );
    assert_eq!(mean::<Marker, Reference>(&[], 6.0).unwrap_err(), Refused::NoFrame);
    let exact = [frames[0], Uncertain::from(frames[1].transform())];
    assert_eq!(mean(&exact, 6.0).unwrap_err(), Refused::Singular { frame: 1 });
}
