//! The normal equations with what they leave out: how the derivatives themselves turn.
//!
//! The second derivative of half the sum of squares is
//!
//! ```text
//! sum J^T W J  -  sum (W r) . d2 predicted                                                                     (10)
//! ```
//!
//! and (4) has the first term only. The second grows with the residuals: beside a model that is far from the discs, as a
//! flat plate is where it is bent, it is as large as the first, and steps without it lead to and fro. It is had here from
//! differences of the gradient, one view at a time, as the views share nothing but the numbers of the first block.
//!
//! A pose moves by `exp(w)` from the left; its second derivative is the symmetric part of the gradient's differences.

use geometry::motion::Pose;
use nalgebra::{SMatrix, SVector, Vector6};

use super::normal::{Normal, Numbers, Square};
use super::paraboloid::SHARED;
use super::predict::slopes;
use super::state::{State, in_place};
use super::view::Station;

/// Differences are taken over this share of a deviation, that with which a number alone would be known: over that much
/// the second derivative is constant to a thousandth and less, and the rounding of the gradient is `1e-13` of it.
const DIFFERENCE_DEVIATIONS: f64 = 1e-3;
/// The unknowns of one view.
const VIEW_UNKNOWNS: usize = SHARED + 6;
type Gradient = SVector<f64, VIEW_UNKNOWNS>;

/// The equations of one view with the second derivative (10) in the place of `sum J^T W J`; none where a number leaves what
/// numbers can be. `known` are the deviations, one a shared number, that the differences are taken over.
pub(super) fn curved(
    normal: &Normal,
    station: &Station,
    state: &State,
    pose: &Pose,
    (free, known): (&[bool; SHARED], &Numbers),
) -> Option<Normal> {
    let here = gradient(station, state, pose, free);
    let mut second = SMatrix::<f64, VIEW_UNKNOWNS, VIEW_UNKNOWNS>::zeros();
    for k in (0..VIEW_UNKNOWNS).filter(|k| free.get(*k).copied().unwrap_or(true)) {
        // Each column is a difference of gradients, which are exact: only one order is taken numerically.
        let (there, h) = if k < SHARED {
            let step = Numbers::ith(k, known[k] * DIFFERENCE_DEVIATIONS);
            let moved = state.moved(&step, Vec::new())?;
            (gradient(station, &moved, pose, free), known[k] * DIFFERENCE_DEVIATIONS)
        } else {
            let h = DIFFERENCE_DEVIATIONS * normal.spread.1[k - SHARED].max(f64::MIN_POSITIVE).sqrt().recip();
            let moved = in_place(pose, &Vector6::ith(k - SHARED, h))?;
            (gradient(station, state, &moved, free), h)
        };
        second.set_column(k, &((there - here) / h));
    }
    // A second derivative is symmetric; differences are so but for their errors, which this halves.
    let second = (second + second.transpose()) * 0.5;
    second.iter().all(|x| x.is_finite()).then(|| Normal {
        own: second.fixed_view::<SHARED, SHARED>(0, 0).into_owned(),
        mixed: second.fixed_view::<SHARED, 6>(0, SHARED).into_owned(),
        pose: second.fixed_view::<6, 6>(SHARED, SHARED).into_owned(),
        ..normal.clone()
    })
}

/// The deviations with which each shared number would be known alone; 1 for one that nothing depends on.
pub(super) fn known(normals: &[Normal]) -> Numbers {
    let sum: Square = normals.iter().map(|n| n.own).sum();
    sum.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 1.0 })
}

/// The derivative of half a view's sum of squares by the shared numbers and its pose.
fn gradient(station: &Station, state: &State, pose: &Pose, free: &[bool; SHARED]) -> Gradient {
    let eye = state.eye(pose);
    let mut sum = Gradient::zeros();
    for s in &station.sightings {
        let (at, (by_numbers, by_pose)) = slopes(s, &eye);
        let pull = s.information * (at - s.pixel);
        for k in (0..SHARED).filter(|k| free[*k]) {
            sum[k] += by_numbers.column(k).dot(&pull);
        }
        for k in 0..6 {
            sum[SHARED + k] += by_pose.column(k).dot(&pull);
        }
    }
    sum
}
