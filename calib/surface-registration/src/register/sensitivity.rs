//! What one gross error does to a registration.
//!
//! The predicted error is that of noise. An echo that happens to lie near the surface is no noise, and with few points some alone hold a motion:
//! 20 touched points of which a tenth were gross errors put targets off by 4 and 5 mm where 1 and 2 mm were predicted.
//!
//! Points that were taken at one place (a pointer held still, neighbours along a bone's line of an image) are wrong together.

use nalgebra::{Vector3, Vector6};

use super::normal::solved;
use super::rows::{Row, Rows};
use crate::solve::{Exact, Matrix8, Problem, Vector8};

/// What a gross error of one place does, to first order: the kernel lets no larger one do more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrossError {
    /// A point of that place, by its number in the list; others taken there err with it.
    pub point: usize,
    /// The error along the surface's normal that does most, mm.
    pub error_mm: f64,
    /// How far it puts the target off, mm.
    pub target_mm: f64,
}

/// The same before a target is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sensitivity {
    point: usize,
    error_mm: f64,
    /// (w, v) about the middle of the points, rad and mm.
    motion: Vector6<f64>,
}

impl Sensitivity {
    /// At a target, from the middle of the points, mm.
    pub(super) fn at(&self, arm: &Vector3<f64>) -> GrossError {
        let (w, v) = (self.motion.fixed_rows::<3>(0), self.motion.fixed_rows::<3>(3));
        GrossError {
            point: self.point,
            error_mm: self.error_mm,
            target_mm: (w.into_owned().cross(arm) + v).norm(),
        }
    }
}

/// What a gross error of each place does at most, to first order (gross-error sensitivity, Hampel et al. 1986). With few points it does up to
/// three times as much, as others lose their say with it. `matrix` are the normal equations of all points and of what was known before, turns
/// about the middle of the points; `free` is 1 for what is unknown and 0 for what is held; `end` is the kernel's, deviations.
///
/// With `H` the normal equations without that place, `a` the derivative of a residual there and `v` its vote, residuals of `s` deviations move
/// the unknowns by `H^-1 sum(v a) psi(s)`; Tukey's `psi` is greatest, `0.2862 c`, at `c / sqrt 5`.
pub(super) fn sensitivity(
    rows: &Rows,
    problem: &Problem<'_, Exact<'_>>,
    [matrix, free]: [&Matrix8; 2],
    end: f64,
) -> Vec<Sensitivity> {
    let (at, most) = (end / 5.0_f64.sqrt(), end / 5.0_f64.sqrt() * 0.64);
    let one = |(row, place): (&Row, Place)| {
        // What is held does not answer, and has no part in how the others do.
        let others = free * (matrix - place.matrix) * free;
        let moved = solved(&others, &(free * place.pull), problem.cloud.radius_mm) * most;
        Sensitivity {
            point: row.point,
            // By so much it errs where that is what is left of it.
            error_mm: (at + row.slope.dot(&moved)) / problem.sharp[row.point],
            motion: moved.fixed_rows::<6>(0).into_owned(),
        }
    };
    rows.rows.iter().zip(places(rows, problem)).map(one).collect()
}

/// What the points of one place put into the normal equations, and how they pull together.
#[derive(Clone, Copy)]
struct Place {
    matrix: Matrix8,
    pull: Vector8,
}

impl Place {
    fn of(row: &Row, vote: f64) -> Self {
        Self {
            matrix: row.slope * row.slope.transpose() * row.weight,
            pull: row.slope * vote,
        }
    }

    fn add(&mut self, other: &Self) {
        self.matrix += other.matrix;
        self.pull += other.pull;
    }
}

/// The place of each row.
fn places(rows: &Rows, problem: &Problem<'_, Exact<'_>>) -> Vec<Place> {
    let cloud = problem.cloud;
    let own = rows.rows.iter().map(|row| Place::of(row, cloud.votes[row.point]));
    let own: Vec<Place> = own.collect();
    let mut sums = own.clone();
    let mut row_of = vec![None; cloud.len()];
    for (k, row) in rows.rows.iter().enumerate() {
        row_of[row.point] = Some(k);
    }
    // why: a point without a say has none in an error of its place either; what is left of the place then counts less than one point.
    cloud.pairs(|i, j| {
        if let (Some(i), Some(j)) = (row_of[i], row_of[j]) {
            sums[i].add(&own[j]);
            sums[j].add(&own[i]);
        }
    });
    sums
}
