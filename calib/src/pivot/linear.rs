//! The methods that solve linear equations: algebraic, two-step and sphere.

use geometry::Rigid;
use nalgebra::{Matrix3, Vector3};

/// A pose with its translation relative to the centre of all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub(super) r: Matrix3<f64>,
    pub(super) t: Vector3<f64>,
}

/// The tip in the marker, mm, and the pivot relative to the centre of the translations, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) tip: Vector3<f64>,
    pub(super) pivot: Vector3<f64>,
}

/// All poses about the centre of their translations, so that a far tracker costs no digits.
#[derive(Debug)]
pub(super) struct Problem {
    pub(super) poses: Vec<Pose>,
    pub(super) centre: Vector3<f64>,
    /// Mean of the rotation matrices.
    pub(super) mean: Matrix3<f64>,
}

impl Problem {
    pub(super) fn new<To, From>(poses: &[Rigid<To, From>]) -> Self {
        let share = 1.0 / poses.len() as f64;
        let rough = poses
            .iter()
            .map(|p| Vector3::from(p.translation_mm()))
            .sum::<Vector3<f64>>()
            * share;
        // The mean is rounded, but the same number is taken off every pose, and added to the pivot in the end.
        let centred = |p: &Rigid<To, From>| Pose {
            r: p.rotation().matrix().into(),
            t: Vector3::from(p.translation_mm()) - rough,
        };
        let poses: Vec<Pose> = poses.iter().map(centred).collect();
        let mean = poses.iter().map(|p| p.r).sum::<Matrix3<f64>>() * share;
        Self {
            poses,
            centre: rough,
            mean,
        }
    }

    /// `1 / N sum (R - Rm)^T (R - Rm)`, the normal matrix of the tip once the pivot is eliminated: dimensionless. Its
    /// least eigenvalue is `1 - s^2`, `s` the largest singular value of the mean matrix, without the cancellation.
    pub(super) fn spread(&self) -> Matrix3<f64> {
        let term = |p: &Pose| {
            let d = p.r - self.mean;
            d.transpose() * d
        };
        self.poses.iter().map(term).sum::<Matrix3<f64>>() / self.poses.len() as f64
    }

    /// Condition number of the rows `(R_i, -I)`: `sqrt((1 + s) / (1 - s))`, since their normal matrix is
    /// `((I, -Rm^T), (-Rm, I))` with eigenvalues `1 +- s_k`.
    pub(super) fn condition(&self) -> f64 {
        let (values, _) = crate::registration::jacobi::symmetric3(self.spread());
        // (1 + s) / (1 - s) = (1 + s)^2 / (1 - s^2), and 1 - s^2 is the eigenvalue at hand; rounding may lead out of 0
        // to 1.
        let least = values.min().clamp(0.0, 1.0);
        (1.0 + (1.0 - least).sqrt()) / least.sqrt()
    }

    /// The pivot that fits a tip best: the mean of its places.
    fn completed(&self, tip: Vector3<f64>) -> State {
        let places = self.poses.iter().map(|p| p.r * tip + p.t);
        let pivot = places.sum::<Vector3<f64>>() / self.poses.len() as f64;
        State { tip, pivot }
    }

    /// Minimises `sum |R_i x + t_i - c|^2` over both at once. `None` where singular.
    pub(super) fn algebraic(&self) -> Option<State> {
        // With the pivot eliminated the rows are R_i - Rm; their sum is zero, so that the mean of t drops out by
        // itself.
        let right = |p: &Pose| (p.r - self.mean).transpose() * p.t;
        let right = self.poses.iter().map(right).sum::<Vector3<f64>>() / self.poses.len() as f64;
        let tip = self.spread().cholesky()?.solve(&-right);
        Some(self.completed(tip))
    }

    /// Minimises `sum |(R_i - R_j) x + t_i - t_j|^2` over pairs of poses a half and a third of the recording apart, then
    /// takes the mean of the tip's places. With all pairs it would be the algebraic method, entry by entry.
    pub(super) fn two_step(&self) -> Option<State> {
        let n = self.poses.len();
        let (mut matrix, mut vector) = (Matrix3::zeros(), Vector3::zeros());
        // Of a motion whose period is one of the strides all differences vanish; then the other one serves.
        for stride in [n / 2, n / 3] {
            for (i, p) in self.poses.iter().enumerate() {
                let q = &self.poses[(i + stride) % n];
                let d = p.r - q.r;
                matrix += d.transpose() * d;
                vector -= d.transpose() * (p.t - q.t);
            }
        }
        Some(self.completed(matrix.cholesky()?.solve(&vector)))
    }

    /// Fits a sphere to the marker's origins, which lie at `|x|` from the pivot, in the sense of least distances; the
    /// tip is the mean of the pivot seen from the marker. Rotations do not help to find the pivot, so that it is much
    /// the worst on small cones, and useless where the tip is at the marker's origin.
    pub(super) fn sphere(&self) -> Option<State> {
        let n = self.poses.len() as f64;
        let mean = self.poses.iter().map(|p| p.t).sum::<Vector3<f64>>() / n;
        let size = self.poses.iter().map(|p| (p.t - mean).norm_squared()).sum::<f64>() / n;
        let (mut matrix, mut vector) = (Matrix3::zeros(), Vector3::zeros());
        for p in &self.poses {
            let d = p.t - mean;
            matrix += d * d.transpose();
            // Algebraic sphere: |d|^2 = 2 d.c + (radius^2 - |c|^2) is linear in c; about the mean the constant is the
            // mean square.
            vector += d * (0.5 * (d.norm_squared() - size));
        }
        let start = matrix.cholesky()?.solve(&vector) + mean;
        let pivot = self.nearest_sphere(start);
        let tips = self.poses.iter().map(|p| p.r.transpose() * (pivot - p.t));
        Some(State {
            tip: tips.sum::<Vector3<f64>>() / n,
            pivot,
        })
    }

    /// Gauss-Newton on `sum (|t_i - c| - radius)^2`, the radius eliminated; a step that fails or does not shorten the
    /// sum ends it.
    fn nearest_sphere(&self, mut centre: Vector3<f64>) -> Vector3<f64> {
        let mut best = f64::INFINITY;
        let mut next = centre;
        for _ in 0..50 {
            let (cost, step) = self.sphere_step(&next);
            // At a pose that lies on the centre a unit vector is 0 / 0.
            if cost.is_nan() || cost >= best {
                break;
            }
            (best, centre) = (cost, next);
            let Some(step) = step else { break };
            next = centre + step;
        }
        centre
    }

    /// The sum of squares at a centre, and the step from it.
    fn sphere_step(&self, centre: &Vector3<f64>) -> (f64, Option<Vector3<f64>>) {
        let n = self.poses.len() as f64;
        let away = |p: &Pose| p.t - centre;
        let radius = self.poses.iter().map(|p| away(p).norm()).sum::<f64>() / n;
        let unit = |p: &Pose| away(p) / away(p).norm();
        let mean = self.poses.iter().map(unit).sum::<Vector3<f64>>() / n;
        let (mut matrix, mut vector, mut cost) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        for p in &self.poses {
            // The residual |t - c| - radius falls by u.dc, the mean radius by its mean: the radius is eliminated.
            let (u, r) = (unit(p) - mean, away(p).norm() - radius);
            matrix += u * u.transpose();
            vector += u * r;
            cost += r * r;
        }
        (cost, matrix.cholesky().map(|c| c.solve(&vector)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Marker, Rigid, Tracker, Vector};

    /// Six poses about a common pivot, far from the tracker's origin.
    fn planted(tip: Vector3<f64>) -> Vec<Rigid<Tracker, Marker>> {
        let pose = |i: usize| {
            let a = i as f64;
            let turn = Vector::new(0.5 * a.cos(), 0.6 * (1.7 * a).sin(), 0.4 * (2.3 * a).cos());
            let at_origin: Rigid<Tracker, Marker> =
                Rigid::from_rotation_vector(turn, Vector::new(0.0, 0.0, 0.0)).unwrap();
            let place = at_origin * Vector::new(tip.x, tip.y, tip.z);
            Rigid::from_parts(at_origin.rotation(), Vector::new(900.0, -80.0, 2100.0) - place)
        };
        (0..6).map(pose).collect()
    }

    #[test]
    fn every_method_finds_a_planted_tip() {
        let tip = Vector3::new(3.0, -5.0, 160.0);
        let problem = Problem::new(&planted(tip));
        let found = [problem.algebraic(), problem.two_step(), problem.sphere()];
        for (state, name) in found.iter().zip(["algebraic", "two-step", "sphere"]) {
            let state = state.unwrap();
            // Translations of 2300 mm are rounded to 2.3e-13; the conditions here are below 10, squared once in the
            // normal equations, and a sphere's centre is known worse by its opening, twice.
            let bound = if name == "sphere" { 1e-9 } else { 1e-10 };
            assert!((state.tip - tip).norm() < bound, "{name}: {state:?}");
            let pivot = state.pivot + problem.centre;
            assert!(
                (pivot - Vector3::new(900.0, -80.0, 2100.0)).norm() < bound,
                "{name}: {pivot}"
            );
        }
    }

    #[test]
    fn the_condition_is_that_of_the_stacked_rows() {
        let problem = Problem::new(&planted(Vector3::zeros()));
        let rows = nalgebra::DMatrix::from_fn(18, 6, |i, j| match j {
            0..3 => problem.poses[i / 3].r[(i % 3, j)],
            _ => -f64::from(i8::from(i % 3 == j - 3)),
        });
        let values = rows.svd(false, false).singular_values;
        let expected = values.max() / values.min();
        assert!((problem.condition() / expected - 1.0).abs() < 1e-12, "{expected}");
    }
}
