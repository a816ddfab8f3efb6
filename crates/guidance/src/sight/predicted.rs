//! The error that a pose's covariance predicts at the target.

use std::f64::consts::PI;

use geometry::uncertain::CovarianceError;
use geometry::{Ct, Direction, Point, Rigid, Tool, Uncertain};

use super::input::{Covariance, MAX_MM};

/// The root of the 0.95 quantile of chi-squared with two degrees of freedom, `sqrt(-2 ln 0.05)`: its distribution is
/// `1 - exp(-x / 2)`.
const SCALE_95_2D: f64 = 2.447_746_830_680_816;
/// The 0.975 quantile of the normal distribution: 95 % lie within as many deviations on either side.
const SCALE_95_1D: f64 = 1.959_963_984_540_054;
/// The 0.999 quantile of chi-squared with three degrees of freedom (Abramowitz and Stegun 1964, table 26.8).
const CHI_SQUARE_999: f64 = 16.266_236_196_238_13;
/// Roundings of a sight's lengths, in units of the largest coordinate's last place.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

/// Why the error is not known.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Unknown {
    /// The pose came without a covariance.
    #[error("the pose has no covariance")]
    Missing,
    /// The covariance is zero without being said to be exact.
    #[error("the covariance is zero, as of a pose without one")]
    Zero,
    /// The numbers are no covariance.
    #[error("{0}")]
    NotACovariance(CovarianceError),
    /// The error is too large to be told: above [`MAX_MM`], or a turn of more than half a turn in one case of a thousand.
    #[error("the predicted error is beyond {MAX_MM} mm or half a turn")]
    TooLarge,
}

/// The 95 % ellipse in the sight's plane, about the target or about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// The 2 x 2 covariance in (right, up), mm^2.
    pub covariance_mm2: [[f64; 2]; 2],
    /// The half-axes of the ellipse that holds 95 % of a normal error, mm: the longer first.
    pub half_axes_mm: [f64; 2],
    /// From right towards up to the longer half-axis, rad, -pi/2 to pi/2; 0 where both are alike.
    pub turn_rad: f64,
}

/// The predicted error at the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// In the sight's plane at the target's depth.
    pub ellipse: Ellipse,
    /// Along the axis: 95 % of a normal error lie within as much on either side, mm.
    pub along_95_mm: f64,
    /// The radius of a ball that holds at least 95 % of the error in space, mm: never below the ellipse's half-axes.
    pub ball_95_mm: f64,
    /// What the lengths above leave out, mm: second order of the turn, at most `w^2 c / 2` with the turn `w` that is exceeded in
    /// one case of a thousand and the target's distance `c` from the origin of `Ct`; and rounding. Alone of all numbers of a sight
    /// it depends on where the origin of `Ct` is, as the covariance's motion turns about it.
    pub remainder_mm: f64,
}

impl Ellipse {
    /// From a symmetric 2 x 2 matrix, semidefinite to rounding: its eigenvalues in closed form.
    fn new(covariance_mm2: [[f64; 2]; 2]) -> Self {
        let [[a, b], [_, c]] = covariance_mm2;
        let (mean, half) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        // Rounding may leave less than nothing of the lesser one.
        let half_axis = |variance: f64| SCALE_95_2D * variance.max(0.0).sqrt();
        Self {
            covariance_mm2,
            half_axes_mm: [half_axis(mean + half), half_axis(mean - half)],
            turn_rad: 0.5 * (2.0 * b).atan2(a - c),
        }
    }

    /// Whether a point at `offset` (right, up), mm, from the middle lies in the ellipse. One without width holds its middle line.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let (sin, cos) = self.turn_rad.sin_cos();
        let along = [x * cos + y * sin, y * cos - x * sin];
        let part = |offset: f64, half: f64| if offset == 0.0 { 0.0 } else { offset / half };
        part(along[0], self.half_axes_mm[0]).hypot(part(along[1], self.half_axes_mm[1])) <= 1.0
    }
}

/// The error at `target`, in the axes (right, up, along).
pub(super) fn at(
    target: Point<Ct>,
    axes: [Direction<Ct>; 3],
    ct_from_tool: Rigid<Ct, Tool>,
    covariance: Covariance,
) -> Result<Predicted, Unknown> {
    let uncertain = uncertain(ct_from_tool, covariance)?;
    // The place of the tool that now lies at the target: what it moves by, the target is missed by.
    let at = uncertain * (ct_from_tool.inverse() * target);
    let c = at.covariance();
    // First, as eigenvalues of what is not finite are not to be had.
    if !c.iter().all(|x| x.abs() <= MAX_MM * MAX_MM) {
        return Err(Unknown::TooLarge);
    }
    let turn = turn_999(&uncertain);
    let axes = axes.map(Direction::components);
    let between = |i: usize, j: usize| -> f64 {
        let row = |k: usize| (0..3).map(|l| c[(k, l)] * axes[j][l]).sum::<f64>();
        (0..3).map(|k| axes[i][k] * row(k)).sum()
    };
    let across = between(0, 1);
    let predicted = Predicted {
        ellipse: Ellipse::new([[between(0, 0), across], [across, between(1, 1)]]),
        along_95_mm: SCALE_95_1D * between(2, 2).max(0.0).sqrt(),
        ball_95_mm: at.radius_95_mm(),
        remainder_mm: remainder(target, &ct_from_tool, turn),
    };
    let is_told = predicted.ball_95_mm <= MAX_MM && predicted.remainder_mm <= MAX_MM && turn <= PI;
    is_told.then_some(predicted).ok_or(Unknown::TooLarge)
}

fn uncertain(ct_from_tool: Rigid<Ct, Tool>, covariance: Covariance) -> Result<Uncertain<Ct, Tool>, Unknown> {
    match covariance {
        Covariance::Missing => Err(Unknown::Missing),
        Covariance::Exact => Ok(ct_from_tool.into()),
        Covariance::Upper(upper) if upper.iter().all(|&x| x == 0.0) => Err(Unknown::Zero),
        Covariance::Upper(upper) => Uncertain::from_upper(ct_from_tool, upper).map_err(Unknown::NotACovariance),
    }
}

/// The turn that is exceeded in at most one case of a thousand, rad.
fn turn_999(uncertain: &Uncertain<Ct, Tool>) -> f64 {
    let turns = uncertain.covariance().fixed_view::<3, 3>(0, 0).into_owned();
    // The squared turn is at most the largest variance times chi-squared of three degrees of freedom.
    (CHI_SQUARE_999 * turns.symmetric_eigenvalues().max().max(0.0)).sqrt()
}

/// See [`Predicted::remainder_mm`]: `abs(exp(w) c - c - w x c) <= abs(w)^2 abs(c) / 2` for every turn w.
fn remainder(target: Point<Ct>, ct_from_tool: &Rigid<Ct, Tool>, turn: f64) -> f64 {
    let far = target.distance(Point::new(0.0, 0.0, 0.0));
    0.5 * turn * turn * far + ROUNDINGS * (far + ct_from_tool.translation().norm())
}
