//! The true error of a pose at a target, and what each link of the chain has made of it.
//!
//! With the true links `R` (`ct_from_reference`), `B` (`tracker_from_reference`), `M` (`tracker_from_marker`), `T`
//! (`marker_from_tool`) the tool is at `P = R B^-1 M T`. Hats are what was measured, `G` lays the calibrated marker's frame on the true one, and
//! `M0` is the pose of a frame without noise by the calibrated emitters. At a target x (`e(A) = A x - x`):
//!
//! ```text
//! whole          e(P^ P^-1)                                                                                         (1)
//! registration   e(R^ R0^-1)                    R0: where the marker on the patient was when it was registered      (2)
//! bump           e(R0 R^-1)                                                                                         (3)
//! reference      e(R B^^-1 B R^-1)              the noise of the frame, at the marker on the patient                (4)
//! frame          e(Q M^ M0^-1 Q^-1)             and at the tool's;  Q = R B^-1                                      (5)
//! marker         e(Q M0 G^-1 M^-1 Q^-1)         the calibrated emitters                                             (6)
//! tool           e(Q M G T^ T^-1 M^-1 Q^-1)     tip, base, seat                                                     (7)
//! organs         e(D)                           D: where breath, or the tube, has moved the organs since the CT     (8)
//! ```
//!
//! Where organs move, errors are told in the organ's frame: the tool truly is at `D^-1 P` there, and (1) is `e(P^ P^-1 D)`.
//!
//! The links' errors add to the whole's but for products of two of them, which [`Told::rest_mm`] holds.

use calib::pose::{Pose, Sighting, solve};
use geometry::{Ct, Frame, Marker, Point, Reference, Rigid, Tool, Uncertain, Vector};
use nalgebra::Vector3;
use tracker_proc::chain::{Chain, Registration};
use tracker_proc::operating_room::Frame as Seen;

/// The links as they truly are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct True {
    /// Where the marker on the patient was while the patient was registered.
    pub(crate) registered: Rigid<Ct, Reference>,
    /// And is now.
    pub(crate) ct_from_reference: Rigid<Ct, Reference>,
    /// The tool in its marker.
    pub(crate) marker_from_tool: Rigid<Marker, Tool>,
    /// The true marker from the calibrated one.
    pub(crate) gauge: Rigid<Marker, Marker>,
}

/// What a link has made of the error at a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinkError {
    /// The error, mm.
    pub(crate) found: [f64; 3],
    /// Root mean square of its length by the link's own covariance; `None` of a link that nobody states an error of.
    pub(crate) predicted_rms_mm: Option<f64>,
}

/// All that is told of one pose at one target.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Told {
    /// (1), mm.
    pub(crate) error: [f64; 3],
    /// Normalised by the covariance: three degrees of freedom.
    pub(crate) nees: f64,
    /// The ball that holds 95 of 100 by the covariance, mm.
    pub(crate) ball_95_mm: f64,
    /// How far the registration is off by itself, (2) and (3) together, and the radius that its own covariance gives for 95 of 100, mm.
    pub(crate) registration: [f64; 2],
    /// (2) to (8), in the order of [`LINKS`].
    pub(crate) links: [LinkError; LINKS.len()],
}

/// The links, in words.
pub const LINKS: [&str; 7] = ["registration", "bump", "reference", "frame", "marker", "tool", "organs"];

impl Told {
    /// What the links' errors leave of the whole, mm.
    pub(crate) fn rest_mm(&self) -> f64 {
        let sum = |k: usize| self.links.iter().map(|link| link.found[k]).sum::<f64>();
        length([0, 1, 2].map(|k| self.error[k] - sum(k)))
    }
}

/// The length of a vector.
pub(crate) fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// What is told of `pose`, which the chain made of the frame `seen`; `quiet` is that frame without noise, and at the target organs have been
/// `moved` since the CT. `None` where a marker is not seen, or there is no covariance.
pub(crate) fn told(
    truth: &True,
    chain: &Chain,
    (seen, quiet): (&Seen, &Seen),
    pose: &Uncertain<Ct, Tool>,
    (target, moved): (Point<Ct>, Option<Vector<Ct>>),
) -> Option<Told> {
    let Registration::Referenced(registration) = chain.registration else {
        return None;
    };
    let (b, m) = (seen.tracker_from_reference?, seen.tracker_from_marker);
    let (r, t) = (truth.ct_from_reference, truth.marker_from_tool);
    let tool = &chain.marker_from_tool;
    let (b_seen, m_seen) = (
        reference_pose(chain, &registration, seen)?,
        marker_pose(chain, &seen.tool)?,
    );
    let m_quiet = marker_pose(chain, &both(&quiet.tool, &seen.tool))?
        .transform
        .transform();
    let q = r * b.inverse();
    let error = |a: Rigid<Ct, Ct>| ((a * target) - target).mm();
    let organs = moved.map(organs);
    let back = seen.ct_from_tool.inverse();
    let whole = error(pose.transform() * organs.map_or(back, |moved| back * moved));
    let (m_hat, b_hat) = (m_seen.transform.transform(), b_seen.transform.transform());
    let m_back = m.inverse() * q.inverse();
    // Where the target lies in the frames of the links, by what was measured: errors are carried there by each link's covariance.
    let outer = registration.transform() * b_hat.inverse();
    let at_tool = pose.transform().inverse() * target;
    let registered = registration * (registration.transform().inverse() * target);
    let links = [
        stated(error(registration.transform() * truth.registered.inverse()), registered),
        unstated(error(truth.registered * r.inverse())),
        stated(
            error(r * b_hat.inverse() * b * r.inverse()),
            registration.transform() * b_seen.transform.inverse() * (outer.inverse() * target),
        ),
        stated(
            error(q * m_hat * m_quiet.inverse() * q.inverse()),
            outer * m_seen.transform * (tool.transform() * at_tool),
        ),
        unstated(error(q * m_quiet * truth.gauge.inverse() * m_back)),
        stated(
            error(q * m * truth.gauge * tool.transform() * t.inverse() * m_back),
            outer * m_hat * *tool * at_tool,
        ),
        unstated(organs.map_or([0.0; 3], error)),
    ];
    let at = *pose * at_tool;
    Some(Told {
        error: whole,
        nees: nees(&at.covariance(), whole)?,
        ball_95_mm: at.radius_95_mm(),
        registration: [
            length(error(registration.transform() * r.inverse())),
            registered.radius_95_mm(),
        ],
        links,
    })
}

/// Where organs are that have moved so far.
fn organs(moved: Vector<Ct>) -> Rigid<Ct, Ct> {
    Rigid::from_parts(Rigid::<Ct, Ct>::identity().rotation(), moved)
}

/// What is told of a registration by itself.
pub(crate) struct Alone {
    /// How far it is off at the target, mm.
    pub(crate) error: [f64; 3],
    /// The ball that holds 95 of 100 by its own covariance, and the root mean square, mm.
    pub(crate) ball_95_mm: f64,
    pub(crate) rms_mm: f64,
    /// `None` where there is no covariance.
    pub(crate) nees: Option<f64>,
}

/// A registration at a target, of a patient whose marker truly is at `truly`: where his target is shown.
pub(crate) fn alone(found: &Uncertain<Ct, Reference>, truly: Rigid<Ct, Reference>, target: Point<Ct>) -> Alone {
    let at = *found * (truly.inverse() * target);
    let error = (at.point() - target).mm();
    Alone {
        error,
        ball_95_mm: at.radius_95_mm(),
        rms_mm: at.rms_mm(),
        nees: nees(&at.covariance(), error),
    }
}

fn stated(found: [f64; 3], at: geometry::UncertainPoint<Ct>) -> LinkError {
    LinkError {
        found,
        predicted_rms_mm: Some(at.rms_mm()),
    }
}

fn unstated(found: [f64; 3]) -> LinkError {
    LinkError {
        found,
        predicted_rms_mm: None,
    }
}

fn nees(covariance: &nalgebra::Matrix3<f64>, error: [f64; 3]) -> Option<f64> {
    let e = Vector3::from(error);
    Some(e.dot(&covariance.cholesky()?.solve(&e)))
}

/// The pose of the tool's marker, as the chain solves it.
fn marker_pose(chain: &Chain, sightings: &[Sighting]) -> Option<Pose<Marker>> {
    let tip = chain.marker_from_tool.transform() * Point::<Tool>::new(0.0, 0.0, 0.0);
    solve(&chain.marker, tip, sightings, &chain.localizer, &chain.gates).ok()
}

/// The same of the patient's.
fn reference_pose(chain: &Chain, registration: &Uncertain<Ct, Reference>, seen: &Seen) -> Option<Pose<Reference>> {
    let region = registration.transform().inverse() * chain.region;
    let body = chain.reference.as_ref()?;
    solve(body, region, &seen.reference, &chain.localizer, &chain.reference_gates).ok()
}

/// Of the sightings without noise those of the emitters that were seen.
fn both(quiet: &[Sighting], seen: &[Sighting]) -> Vec<Sighting> {
    let was_seen = |sighting: &&Sighting| seen.iter().any(|other| other.emitter == sighting.emitter);
    quiet.iter().filter(was_seen).copied().collect()
}

/// A pose that is moved along x of the frame it maps to: an error that nobody states.
pub(crate) fn shifted<To: Frame, From: Frame>(link: Uncertain<To, From>, mm: f64) -> Option<Uncertain<To, From>> {
    let at = link.transform();
    let moved = Rigid::from_parts(at.rotation(), at.translation() + Vector::new(mm, 0.0, 0.0));
    Uncertain::from_upper(moved, link.upper()).ok()
}

/// The covariance of a pose whose deviations are stated so many times smaller.
pub(crate) fn understated(pose: &Uncertain<Ct, Tool>, times: f64) -> [f64; 21] {
    pose.upper().map(|variance| variance / (times * times))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Tracker;

    /// Checked by hand: diag(4, 1, 0.25) and (2, 1, 1): 1 + 1 + 4.
    #[test]
    fn nees_is_the_error_in_deviations_squared() {
        let covariance = nalgebra::Matrix3::from_diagonal(&Vector3::new(4.0, 1.0, 0.25));
        assert!((nees(&covariance, [2.0, 1.0, 1.0]).unwrap() - 6.0).abs() < 1e-12);
        assert_eq!(nees(&nalgebra::Matrix3::zeros(), [2.0, 1.0, 1.0]), None);
    }

    /// By matrices: where the marker on the patient is shown, and where it is.
    #[test]
    fn a_registration_by_itself_is_off_by_what_it_moves_the_target() {
        let rigid = |turn: [f64; 3], shift: [f64; 3]| {
            let [[a, b, c], [x, y, z]] = [turn, shift];
            Rigid::<Ct, Reference>::from_rotation_vector(Vector::new(a, b, c), Vector::new(x, y, z)).unwrap()
        };
        let homogeneous =
            |turn: [f64; 3], shift: [f64; 3]| nalgebra::Isometry3::new(shift.into(), turn.into()).to_homogeneous();
        let truly = ([0.3, -1.2, 0.4], [150.0, -120.0, -150.0]);
        let found = ([0.31, -1.19, 0.41], [152.0, -121.0, -149.5]);
        let target = nalgebra::Vector4::new(-20.0, 35.0, 60.0, 1.0);
        let inverse = homogeneous(truly.0, truly.1).try_inverse().unwrap();
        let off = homogeneous(found.0, found.1) * inverse * target - target;
        let covariance = nalgebra::Matrix6::from_diagonal_element(1e-4);
        let uncertain = Uncertain::new(rigid(found.0, found.1), covariance).unwrap();
        let told = alone(&uncertain, rigid(truly.0, truly.1), Point::new(-20.0, 35.0, 60.0));
        for k in 0..3 {
            assert!((told.error[k] - off[k]).abs() < 1e-9, "{:?} {off}", told.error);
        }
        assert!(length(told.error) > 1.0 && told.ball_95_mm > told.rms_mm && told.nees.unwrap() > 0.0);
    }

    #[test]
    fn a_shift_is_along_x_of_the_outer_frame() {
        let at =
            Rigid::<Ct, Tracker>::from_rotation_vector(Vector::new(0.3, 0.2, 0.1), Vector::new(1.0, 2.0, 3.0)).unwrap();
        let moved = shifted(Uncertain::from(at), 1.5).unwrap();
        let p = Point::new(10.0, -20.0, 30.0);
        let off = (moved.transform() * p) - (at * p);
        assert!((off - Vector::new(1.5, 0.0, 0.0)).norm() < 1e-12, "{off:?}");
    }
}
