//! Whether residuals go with the order of the points, or with their place: what is left of a marker that slid slowly, or of soft tissue under
//! the tip on one side of the bone, once the pose has taken what it can of it.
//!
//! Both are score tests of numbers that were not fitted (Rao 1948): to first order residuals are `s_i + z_i theta` with `theta` unknown beside
//! the pose. With `H` the normal equations and `a_i` a residual's derivative, what the pose can answer is taken off,
//!
//! ```text
//! B = sum w z a',   z~ = z - B H^-1 a,   U = sum w z s,   V = c sum v z~ z~' + (what priors and the shared error add)
//! F = U' V^-1 U / m                                                                                                    (1)
//! ```
//!
//! with `m` numbers, votes `v`, and `c` the scatter that residuals have themselves, drawn towards that of the noise told as if [`TOLD_WORTH`]
//! residuals had shown it: a noise that was told somewhat wrongly is no trend, and few residuals do not say much of it.
//!
//! What the pose can answer leaves no residual and is not seen: of tissue on one side of a ball three quarters are a shift of it.

mod chances;
mod order;
mod side;

use geometry::Frame;
use nalgebra::{Const, DimMin, SMatrix, SVector};

use super::rows::Rows;
use crate::kernel::tukey_scatter;
use crate::points::Points;
use crate::solve::{Matrix8, State, UNKNOWNS, Vector8};

pub(super) use chances::deviations_of_count;
use chances::deviations_of_f;

/// Normal deviations of which 1 in 1000 is above.
pub(crate) const ONE_IN_1000: f64 = 3.090_232;
/// The noise that was told counts as so many residuals.
const TOLD_WORTH: f64 = 30.0;
/// With fewer residuals over the unknowns nothing is said.
const LEAST_LEFT: f64 = 4.0;
/// What is added to a variance against rounding, a share of its trace: what is not seen at all has no pull either.
const ROUNDING: f64 = 1e-9;

/// What residuals go with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// How unlikely it is by chance alone, as deviations of a normal number: 3.09 is 1 in 1000.
    pub deviations: f64,
    /// How large it is, mm: of the order the way of the points' middle from the first to the last point, of a side how much further outside of
    /// the bone its points lie than the others.
    pub mm: f64,
    /// Where to: the way's direction, or that of the side, of length 1 in the bone's axes; zeros where it is none.
    pub towards: [f64; 3],
}

/// Both, `None` where too few points are left to say, and what they add to the covariance about the points' middle.
pub(super) struct Trends {
    pub(super) order: Option<Trend>,
    pub(super) side: Option<Trend>,
    pub(super) adds: Matrix8,
}

impl Trends {
    /// Of what nothing is asked.
    pub(super) fn none() -> Self {
        Self {
            order: None,
            side: None,
            adds: Matrix8::zeros(),
        }
    }
}

/// A fit to first order.
pub(super) struct Linear<'a, F: Frame> {
    pub(super) points: &'a Points<F>,
    pub(super) rows: &'a Rows,
    pub(super) state: &'a State,
    /// The inverse of the normal equations; zeros for what is held.
    pub(super) held: &'a Matrix8,
    /// Normal equations of what is known before.
    pub(super) known: Matrix8,
    /// Unknowns that the points hold.
    pub(super) fitted: f64,
    /// Tukey's constant.
    pub(super) end: f64,
    /// Deviation that was told of what lies under the tip on one side, mm.
    pub(super) side_mm: f64,
}

/// Looks for both.
pub(super) fn trends<F: Frame>(linear: &Linear<'_, F>) -> Trends {
    let (order, of_order) = linear.order().unzip();
    let (side, of_side) = linear.side().unzip();
    let of = |added: Option<Matrix8>| added.unwrap_or_else(Matrix8::zeros);
    Trends {
        order,
        side,
        adds: of(of_order) + of(of_side),
    }
}

/// What a score test of `M` numbers finds.
struct Scored<const M: usize> {
    /// F of (1), and as deviations of a normal number.
    f: f64,
    deviations: f64,
    /// The numbers.
    theta: SVector<f64, M>,
    /// What the unknowns answer to one unit of each.
    answer: SMatrix<f64, UNKNOWNS, M>,
    /// `z~` of each row times the root of its vote.
    left: Vec<SVector<f64, M>>,
}

impl<F: Frame> Linear<'_, F> {
    /// Residuals over the unknowns, and by what factor they scatter more than the noise told.
    fn freedom(&self) -> (f64, f64) {
        let votes = &self.points.cloud.votes;
        let (mut count, mut squares) = (0.0, 0.0);
        for row in &self.rows.rows {
            let vote = votes[row.point];
            count += vote;
            squares += (row.weight * row.deviations).powi(2) / vote;
        }
        (count - self.fitted, squares / tukey_scatter(self.end))
    }

    /// Tests the numbers whose derivatives of each row are `z`; `known` is one over the variance of each before.
    fn score<const M: usize>(&self, z: &[SVector<f64, M>], known: f64) -> Option<Scored<M>>
    where
        Const<M>: DimMin<Const<M>, Output = Const<M>>,
    {
        let mut pull = SVector::<f64, M>::zeros();
        let mut both = SMatrix::<f64, M, UNKNOWNS>::zeros();
        for (row, z) in self.rows.rows.iter().zip(z) {
            pull += z * (row.weight * row.deviations);
            both += z * row.slope.transpose() * row.weight;
        }
        // What the pose and the other unknowns take up of the numbers, the points cannot show.
        let answer = both * self.held;
        let (mut scatter, mut seen) = (SMatrix::<f64, M, M>::zeros(), SMatrix::<f64, M, M>::identity() * known);
        let mut common = SMatrix::<f64, M, 6>::zeros();
        let mut each = Vec::with_capacity(z.len());
        for (row, z) in self.rows.rows.iter().zip(z) {
            let vote = self.points.cloud.votes[row.point];
            let left = z - answer * row.slope;
            scatter += left * left.transpose() * vote;
            seen += left * left.transpose() * row.weight;
            each.push(left * vote.sqrt());
            // why: a calibration that turns with the tool shifts points by their place and their time, and was told.
            if let Some(shared) = self.points.shared() {
                let normal = row.slope.fixed_rows::<3>(3).transpose();
                common += left * (normal * self.state.turn * shared.levers[row.point]) * row.weight;
            }
        }
        let m = M as f64;
        let (left, squares) = self.freedom();
        // What the numbers explain is none of the scatter beside them.
        let of_noise = |square: f64| {
            let rest = (squares - square).max(0.0) + TOLD_WORTH;
            (rest / (left - m + TOLD_WORTH)).max(f64::MIN_POSITIVE)
        };
        let unit = tukey_scatter(self.end);
        // What was known of the unknowns before, and what all points share, scatters beside the points' own errors.
        let mut given = answer * self.known * answer.transpose();
        if let Some(shared) = self.points.shared() {
            given += common * shared.covariance * common.transpose();
        }
        let square = |noise: f64| {
            let mut variance = scatter * (unit * noise) + given;
            variance += SMatrix::identity() * (ROUNDING * variance.trace());
            Some(pull.dot(&variance.cholesky()?.solve(&pull)))
        };
        // By the noise told first: squares of residuals that the numbers explain.
        let explained = square(1.0)?;
        let found = square(of_noise(explained))?;
        let theta = -seen.cholesky()?.solve(&pull);
        (left - m >= LEAST_LEFT).then(|| Scored {
            f: found / m,
            deviations: deviations_of_f(found / m, m, left - m + TOLD_WORTH),
            theta,
            answer: -answer.transpose(),
            left: each,
        })
    }
}

/// What is left of a square once what chance makes of it is taken off, as a share of it: 0 where there is no more (James and
/// Stein 1961).
fn beyond_chance(found: f64, by_chance: f64) -> f64 {
    (1.0 - by_chance / found).max(0.0)
}

fn square(v: &Vector8) -> Matrix8 {
    v * v.transpose()
}
