//! What a seed costs, without a step.

use crate::Field;
use crate::points::Cloud;
use crate::solve::{Solver, State, beyond_cost};

/// Width of the kernel that seeds are scored by, mm: about the distance of seeds.
const SCORE_MM: f64 = 6.0;

/// The points of a sample as seeds are scored on them, in single precision: a hundred thousand seeds and more go over them.
pub(super) struct Scorer<'a> {
    solver: &'a Solver<'a>,
    points: Vec<Scored>,
}

struct Scored {
    place: [f32; 3],
    beam: [f32; 3],
    vote: f32,
}

impl<'a> Scorer<'a> {
    pub(super) fn new(solver: &'a Solver<'a>, sample: &Cloud) -> Self {
        let narrow = |v: &nalgebra::Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let one = |i: usize| Scored {
            place: narrow(&sample.places[i]),
            beam: narrow(&sample.beams[i]),
            vote: sample.votes[i] as f32,
        };
        Self {
            solver,
            points: (0..sample.len()).map(one).collect(),
        }
    }

    /// The cost of a seed, in squares of `SCORE_MM`; infinite where it is not below `limit`.
    pub(super) fn score(&self, state: &State, limit: f64) -> f64 {
        let mut known = 0.0;
        for anchor in self.solver.anchors {
            let off = state.turn * anchor.from + state.shift - anchor.to;
            known += off.norm_squared() / (anchor.sigma_mm * anchor.sigma_mm + SCORE_MM * SCORE_MM) / 3.0;
        }
        let turn: [[f32; 3]; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|j| state.turn[(i, j)] as f32));
        let shift = self.solver.field.in_lattice(&state.shift);
        let turned = |v: &[f32; 3]| turn.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
        let facing = self.solver.facing as f32;
        let limit = (limit - known) as f32;
        let (mut cost, mut votes, mut beyond) = (0.0_f32, 0.0_f32, 0.0_f32);
        for point in &self.points {
            let arm = turned(&point.place);
            let (d, slope) = self.solver.field.glance([0, 1, 2].map(|k| arm[k] + shift[k]));
            if d == Field::BEYOND {
                beyond += point.vote;
                continue;
            }
            votes += point.vote;
            let beam = turned(&point.beam);
            let along = beam[0] * slope[0] + beam[1] * slope[1] + beam[2] * slope[2];
            // Beyond the lattice the distance is infinite, and not a number here.
            let share = d * d / (d * d + (SCORE_MM * SCORE_MM) as f32);
            cost += point.vote * if along <= facing && share < 1.0 { share } else { 1.0 };
            // Costs only grow: most seeds are ruled out by a few points.
            if cost >= limit {
                return f64::INFINITY;
            }
        }
        let (cost, votes, beyond) = (f64::from(cost), f64::from(votes), f64::from(beyond));
        let cost = known + cost + beyond_cost(cost, votes, beyond, 1.0);
        if cost.is_nan() { f64::INFINITY } else { cost }
    }
}
