//! What uncertain numbers of the model do to the places of targets: found between poses, of the state that was told last.
//!
//! Of each number with a standard deviation the forces that one of it adds are told by [`organs::Varied`], and how the state gives way to them by
//! [`simulation::space::frames::Yielding`]: to first order, with contact as it is. A place is moved by `d_i` for each, and its covariance is the sum of `d_i d_i^T`, as
//! [`simulation::space::error::Spread`] has it of states that are solved again. What a step of this leaves unknown is told as not known.

use bus::message::{MOST_ERRORS, PlaceError, TissueHeader, TissueMesh, ToolPose};
use geometry::{Ct, Point};
use nalgebra::{Isometry3, Matrix3, Vector3};
use organs::{Body, Varied};
use simulation::space::cells::Field;
use simulation::space::frames::{Frame, State};

use crate::live::Live;
use crate::message::owner;

/// A target in an organ.
#[derive(Debug)]
struct Place {
    at_rest_mm: [f64; 3],
    /// The organ's number.
    organ: usize,
    /// Nodes that move it, with weights.
    row: Vec<(u32, f64)>,
}

impl Place {
    /// By these displacements of all organs' nodes, or small changes of them.
    fn moved(&self, live: &Live, all: &[f64]) -> Vector3<f64> {
        organs::body::displacement(&self.row, live.frames.bodies().part(self.organ, all))
    }
}

/// What was found of a state is told of later ones until the tube has gone so far, mm: pushed farther, they would be larger.
const MOST_WAY_MM: f64 = 2.0;

/// Nor where the force on the tube, or the way of a target, has grown by more than this share: what is uncertain of them grows with them.
const MOST_GROWTH: f64 = 0.25;
/// A target's way may grow by so much besides, mm: images and words tell no less.
const UNSEEN_MM: f64 = 0.01;

/// How large a state is.
#[derive(Debug, Clone, PartialEq)]
struct Size {
    /// Which organs the tube presses.
    pressed: Vec<bool>,
    /// On the tube, N.
    force: Vector3<f64>,
    /// Of the targets, mm.
    ways: [f64; MOST_ERRORS],
}

impl Size {
    /// Whether the errors of a state of this size say nothing of one of `later`: too small for it, or of other organs, or of a force along which nothing is known.
    fn is_outgrown_by(&self, later: &Self) -> bool {
        let most = |before: f64| before * (1.0 + MOST_GROWTH);
        let size = self.force.norm();
        let across = later.force - self.force * (later.force.dot(&self.force) / size.powi(2).max(f64::MIN_POSITIVE));
        let is_turned =
            across.norm() > MOST_GROWTH * size.min(later.force.norm()) || later.force.dot(&self.force) < 0.0;
        if self.pressed != later.pressed || is_turned {
            return true;
        }
        let ways = self.ways.iter().zip(&later.ways);
        let mut far = ways.map(|(before, way)| *way > most(*before) + UNSEEN_MM);
        later.force.norm() > most(size) || far.any(|is_far| is_far)
    }
}

/// The errors of a state, and which that was.
#[derive(Debug, Clone)]
struct Known {
    /// Of the tube.
    pose: Isometry3<f64>,
    at_rest: bool,
    size: Size,
    pose_seq: u64,
    t_capture_ns: i64,
    count: usize,
    errors: ErrorsOf,
}

/// Covariances of places, and of the force on the tube, N^2, in the CT's axes.
#[derive(Debug, Clone, Copy)]
struct ErrorsOf {
    places: [PlaceError; MOST_ERRORS],
    force: [f64; 6],
}

/// Places and numbers, and what was found last.
#[derive(Debug)]
pub(crate) struct Errors {
    places: Vec<Place>,
    varied: Vec<Varied>,
    /// Settled states from one to the next whose errors are found.
    every: usize,
    since: usize,
    known: Option<Known>,
}

impl Errors {
    /// Of targets that lie in an organ, [`MOST_ERRORS`] at most; of the others nothing is known.
    pub(crate) fn new(
        targets: impl Iterator<Item = Point<Ct>>,
        (bodies, mesh, live): (&[Body], &TissueMesh, &Live),
        varied: Vec<Varied>,
        every: usize,
    ) -> Self {
        let place = |target: Point<Ct>| {
            let own = Vector3::from(live.own(target));
            // By the region that images take it along with, and by the organ's own surface: what one of them has elsewhere has no known error.
            let organ = owner(mesh, own.into())?;
            let body = bodies.get(organ).filter(|body| body.field.value(&own) < 0.0)?;
            let row = body.mesh.row(&own)?;
            Some(Place {
                at_rest_mm: target.mm(),
                organ,
                row,
            })
        };
        Self {
            places: targets.filter_map(place).take(MOST_ERRORS).collect(),
            varied,
            every,
            since: 0,
            known: None,
        }
    }

    /// Adds what is known to a settled state that is about to be told; of any other nothing is.
    pub(crate) fn told(&mut self, header: TissueHeader, frame: Option<&Frame>, live: &Live) -> TissueHeader {
        let is_settled = frame.is_some_and(|frame| frame.state == State::Settled);
        // An organ at rest has no error of the model; one that has just been touched may not be told that.
        let is_near = |known: &Known, frame| {
            known.at_rest == is_at_rest(live)
                && live.frames.way_to(&known.pose) <= MOST_WAY_MM
                && !known.size.is_outgrown_by(&self.size(frame, live))
        };
        let is_known = self
            .known
            .as_ref()
            .zip(frame)
            .is_some_and(|(known, frame)| is_near(known, frame));
        if !is_settled || !is_known {
            self.forget();
        }
        let Some(known) = &self.known else { return header };
        TissueHeader {
            errors_pose_seq: known.pose_seq,
            errors_t_capture_ns: known.t_capture_ns,
            errors_known: known.count as u64,
            errors: known.errors.places,
            force_covariance: known.errors.force,
            force_error_known: 1,
            ..header
        }
    }

    /// How far a target in an organ has been moved, mm in the CT's axes; `None` of any other place.
    pub(crate) fn moved(&self, target: Point<Ct>, live: &Live) -> Option<[f64; 3]> {
        let place = self.places.iter().find(|place| place.at_rest_mm == target.mm())?;
        Some(live.turned(&place.moved(live, live.frames.state())))
    }

    fn size(&self, frame: &Frame, live: &Live) -> Size {
        let mut ways = [0.0; MOST_ERRORS];
        for (way, place) in ways.iter_mut().zip(&self.places) {
            *way = place.moved(live, live.frames.state()).norm();
        }
        Size {
            pressed: live.frames.pressed(),
            force: frame.force.force,
            ways,
        }
    }

    /// What was found says nothing of what comes.
    pub(crate) fn forget(&mut self) {
        (self.known, self.since) = (None, 0);
    }

    /// Finds the errors of the state that was just told, where it is settled and its turn: by numbers of states, never by a clock.
    pub(crate) fn find(&mut self, sample: &ToolPose, frame: &Frame, live: &mut Live) {
        if frame.state != State::Settled || self.varied.is_empty() {
            return;
        }
        let is_due = self.since == 0 || self.known.is_none();
        self.since = (self.since + 1) % self.every;
        if is_due {
            self.known = self.of(live).map(|errors| Known {
                pose: *live.frames.tube().pose(),
                at_rest: is_at_rest(live),
                size: self.size(frame, live),
                pose_seq: sample.seq,
                t_capture_ns: sample.t_capture_ns,
                count: self.places.len(),
                errors,
            });
        }
    }

    /// The covariances of all places and of the force; `None` where the change for one number is not known: a sum without it would be too small.
    fn of(&self, live: &mut Live) -> Option<ErrorsOf> {
        let (mut sums, mut force) = (vec![Matrix3::zeros(); self.places.len()], Matrix3::zeros());
        // An organ at rest is there by no number of the model.
        if !is_at_rest(live) {
            let a = live.frames.state();
            let forces: Option<Vec<_>> = self.varied.iter().map(|one| one.forces(a)).collect();
            let forces = forces?;
            for change in live.frames.changes(&forces)? {
                for (sum, place) in sums.iter_mut().zip(&self.places) {
                    let moved = Vector3::from(live.turned(&place.moved(live, &change.unknowns)));
                    *sum += moved * moved.transpose();
                }
                let pushed = Vector3::from(live.turned(&change.on_tube.fixed_rows::<3>(0).into_owned()));
                force += pushed * pushed.transpose();
            }
        }
        let upper = |sum: &Matrix3<f64>| [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| sum[at]);
        let mut places = [PlaceError::default(); MOST_ERRORS];
        for (error, (sum, place)) in places.iter_mut().zip(sums.iter().zip(&self.places)) {
            *error = PlaceError {
                at_rest_mm: place.at_rest_mm,
                covariance: upper(sum),
            };
        }
        Some(ErrorsOf {
            places,
            force: upper(&force),
        })
    }
}

/// Whether the organ is where the examination has it, to the bit.
fn is_at_rest(live: &Live) -> bool {
    live.frames.state().iter().all(|u| *u == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A push went 2 mm deeper, and its states were told the small errors of a touch.
    #[test]
    fn errors_of_a_shallower_push_are_not_told_of_a_deeper_one() {
        let size = |force: f64, way: f64| {
            let mut ways = [0.0; MOST_ERRORS];
            ways[MOST_ERRORS - 1] = way;
            Size {
                pressed: vec![true, false],
                force: Vector3::x() * force,
                ways,
            }
        };
        let known = size(0.4, 2.0);
        for (later, outgrown) in [
            (size(0.4, 2.0), false),
            (size(0.49, 2.4), false),
            (size(0.51, 2.0), true),
            (size(0.4, 2.6), true),
            // A push that goes back leaves the larger error.
            (size(0.1, 0.3), false),
        ] {
            assert_eq!(known.is_outgrown_by(&later), outgrown, "{later:?}");
        }
        // Of another organ, as large; and along another direction, of which the first one's error says nothing.
        let other = Size {
            pressed: vec![false, true],
            ..size(0.4, 2.0)
        };
        assert!(known.is_outgrown_by(&other));
        for force in [
            Vector3::new(0.0, 0.4, 0.0),
            Vector3::new(0.3, 0.2, 0.0),
            Vector3::new(-0.4, 0.0, 0.0),
        ] {
            assert!(
                known.is_outgrown_by(&Size {
                    force,
                    ..size(0.4, 2.0)
                }),
                "{force}"
            );
        }
        let little = Vector3::new(0.39, 0.05, 0.0);
        assert!(!known.is_outgrown_by(&Size {
            force: little,
            ..size(0.4, 2.0)
        }));
        // Of a target that is hardly moved, rounding is no growth.
        assert!(!size(0.4, 1e-9).is_outgrown_by(&size(0.4, 1e-6)));
    }
}
