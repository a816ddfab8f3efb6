//! The unknowns: where they are now, and which columns they have.

use geometry::motion::{Motion, Pose};
use geometry::rotation::{Rotation, RotationVector};
use nalgebra::{DVector, Matrix3, Vector3, Vector6};

use super::options::Priors;

/// Where the fit is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    /// The middle of the image in the probe.
    pub(crate) image: Pose,
    /// Sizes of a pixel, mm.
    pub(crate) size: [f64; 2],
    /// Motion of the phantom after its given place: turn and shift.
    pub(crate) phantom: Vector6<f64>,
    /// s: the pose that goes with an image of time t is that of t + lag.
    pub(crate) lag: f64,
    /// Linear error of the tracker.
    pub(crate) tracker: Matrix3<f64>,
    /// Of each wire: play of the front across it, then of the back, mm.
    pub(crate) play: Vec<[f64; 4]>,
    /// Of a wall.
    pub(crate) wall: Wall,
}

/// A plane in the reference: `n' y = d`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wall {
    pub(crate) normal: Vector3<f64>,
    pub(crate) distance: f64,
}

/// The column at which each kind of unknown begins; `None` where it is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layout {
    pub(crate) phantom: Option<usize>,
    pub(crate) lag: Option<usize>,
    pub(crate) tracker: Option<usize>,
    pub(crate) play: Option<usize>,
    pub(crate) wall: Option<usize>,
    /// How many in all.
    pub(crate) len: usize,
}

/// Unknowns of the image itself: turn, shift, logarithms of two sizes.
pub(crate) const IMAGE: usize = 8;

impl Layout {
    pub(crate) fn new(priors: &Priors, phantom: bool, wires: usize, wall: bool) -> Self {
        let mut len = IMAGE;
        let mut take = |is_free: bool, count: usize| {
            let at = len;
            is_free.then(|| {
                len += count;
                at
            })
        };
        let phantom = take(phantom, 6);
        let lag = take(priors.lag_s > 0.0, 1);
        let tracker = take(priors.tracker > 0.0, 9);
        let play = take(priors.play_mm > 0.0 && !wall, 4 * wires);
        let wall = take(wall, 3);
        Self {
            phantom,
            lag,
            tracker,
            play,
            wall,
            len,
        }
    }
}

impl State {
    /// After a step; `None` where it leads out of all numbers.
    pub(crate) fn moved(&self, step: &DVector<f64>, layout: &Layout) -> Option<Self> {
        if step.iter().any(|x| !x.is_finite() || x.abs() > 1e6) {
            return None;
        }
        let mut next = self.clone();
        next.image = self.image.moved_in_place(&Motion {
            turn: step.fixed_rows::<3>(0).into_owned(),
            shift: step.fixed_rows::<3>(3).into_owned(),
        })?;
        for k in 0..2 {
            // In their logarithm, so that a size stays above 0; a step of e in one go is no step but a way out.
            next.size[k] *= step[6 + k].clamp(-1.0, 1.0).exp();
        }
        if let Some(at) = layout.phantom {
            next.phantom += step.fixed_rows::<6>(at);
        }
        if let Some(at) = layout.lag {
            next.lag += step[at];
        }
        if let Some(at) = layout.tracker {
            next.tracker += Matrix3::from_row_slice(step.rows(at, 9).as_slice());
        }
        if let Some(at) = layout.play {
            for (i, play) in next.play.iter_mut().enumerate() {
                for (k, value) in play.iter_mut().enumerate() {
                    *value += step[at + 4 * i + k];
                }
            }
        }
        if let Some(at) = layout.wall {
            let [a, b] = self.wall.across();
            let tilted = self.wall.normal + a * step[at] + b * step[at + 1];
            next.wall.normal = tilted.try_normalize(0.0)?;
            next.wall.distance += step[at + 2];
        }
        Some(next)
    }

    /// The turn of the phantom's motion.
    pub(crate) fn phantom_turn(&self) -> Matrix3<f64> {
        turned(&self.phantom.fixed_rows::<3>(0).into_owned())
    }
}

impl Wall {
    /// Two directions across the normal, the same for the same normal.
    pub(crate) fn across(&self) -> [Vector3<f64>; 2] {
        let mut axis = Vector3::zeros();
        axis[self.normal.iamin()] = 1.0;
        let first = self.normal.cross(&axis).try_normalize(0.0).unwrap_or_else(Vector3::x);
        [first, self.normal.cross(&first)]
    }
}

/// exp of a rotation vector, rad; the identity where it is not finite.
pub(crate) fn turned(w: &Vector3<f64>) -> Matrix3<f64> {
    let vector = RotationVector::new((*w).into());
    vector.map_or_else(|_| Matrix3::identity(), |v| Rotation::from_vector(v).matrix().into())
}

/// The pose whose x axis is along `x` and whose y axis is as near to `y` as it can be, with its origin at `t`, and
/// their lengths; `None`
/// where the two are parallel.
pub(crate) fn unskewed(x: &Vector3<f64>, y: &Vector3<f64>, t: &Vector3<f64>) -> Option<(Pose, [f64; 2])> {
    let size = [x.norm(), y.norm()];
    let (a, b) = (x.try_normalize(0.0)?, y.try_normalize(0.0)?);
    // Their two bisectors are at right angles, and half of a right angle from them lie axes that treat both alike.
    let (along, across) = ((a + b).try_normalize(1e-6)?, (a - b).try_normalize(1e-6)?);
    let (first, second) = (
        (along + across).try_normalize(0.0)?,
        (along - across).try_normalize(0.0)?,
    );
    let third = first.cross(&second);
    let rows = [0, 1, 2].map(|i| [first[i], second[i], third[i]]);
    let nearest = geometry::rotation::RotationMatrix::nearest(rows).ok()?;
    let turn = nearest.matrix.rotation();
    Some((Pose { turn, shift: *t }, size))
}
