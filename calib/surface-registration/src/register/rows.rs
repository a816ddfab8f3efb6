//! Residuals as they are linear at the end, by the normals of the smooth surface that the facets stand for.
//!
//! What a fit finds is the minimum on the facets. What of it the points hold is another matter: a ball of facets turned by 3 degrees
//! against one another seems to hold a turn, each facet by a little, and the bone that it stands for does not. So the covariance goes by
//! the smooth normals: between those at a triangle's corners, of faces that do not meet in a crease.

use nalgebra::Vector3;

use crate::solve::{Exact, Matrix8, Problem, Say, State, Vector8};

/// One point that has a say.
pub(super) struct Row {
    pub(super) point: usize,
    pub(super) weight: f64,
    pub(super) deviations: f64,
    /// Of the deviations by the unknowns, with the smooth normal.
    pub(super) slope: Vector8,
}

pub(super) struct Rows {
    pub(super) rows: Vec<Row>,
}

impl Rows {
    pub(super) fn new(problem: &Problem<'_, Exact<'_>>, state: &State) -> Self {
        let cloud = problem.cloud;
        let mut rows = Vec::with_capacity(cloud.len());
        for i in 0..cloud.len() {
            let (s, slope, say) = problem.residual(i, state);
            let weight = problem.kernel.at(s * s).1 * cloud.votes[i];
            if say != Say::Has || weight <= 0.0 {
                continue;
            }
            let smooth = problem.distances.smooth(i).map(|(n, _)| n);
            let n = smooth.unwrap_or_else(|| Vector3::new(slope[3], slope[4], slope[5]) / problem.sharp[i]);
            rows.push(Row {
                point: i,
                weight,
                deviations: s,
                slope: problem.slope(i, state, &n),
            });
        }
        Self { rows }
    }

    /// The normal equations of the points alone.
    pub(super) fn matrix(&self) -> Matrix8 {
        let mut sum = Matrix8::zeros();
        for row in &self.rows {
            sum.ger(row.weight, &row.slope, &row.slope, 1.0);
        }
        sum
    }
}
