//! Poses that come with a covariance each.
//!
//! A pose's error is a small motion `(w, v)` of its image, `p -> exp(w) p + v`, about the centre of all translations, with
//! the 6 x 6 covariance `C`. With `y = R x + t` the residual `r = y - c` moves by `J (w, v)`, `J = (-[y]x, I)`, so that its
//! covariance is `S = J C J^T` and the most likely error of the pose `e = C J^T S^-1 r`. As in [`super::step`] the
//! equations are set up about the pose `T' = exp(-e) T` corrected by it (Gauss-Helmert): misclosure `r' = T' x - c + J' e`,
//! Jacobian `(R', -I)`, weight `S'^-1`.

use geometry::{Frame, Point, Uncertain};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

use super::linear::{Pose, Problem, State};
use super::noise::PoseNoise;
use super::step::{Normal, turned};
use super::{Refused, robust};

/// The covariance of every pose about the centre of the translations, rad and mm.
pub(super) struct Each {
    covariances: Vec<Matrix6<f64>>,
    /// What they are on the average, isotropic.
    pub(super) typical: PoseNoise,
}

impl Each {
    /// # Errors
    /// [`Refused::BadCovariance`] where the translation of a pose has no noise in some direction.
    pub(super) fn new<To: Frame, From: Frame>(
        poses: &[Uncertain<To, From>],
        problem: &Problem,
    ) -> Result<Self, Refused> {
        let [x, y, z] = problem.centre.into();
        let about = |u: &Uncertain<To, From>| u.covariance_about(Point::new(x, y, z));
        let covariances: Vec<Matrix6<f64>> = poses.iter().map(about).collect();
        let (mut turn, mut shift) = (0.0, 0.0);
        for (pose, u) in poses.iter().enumerate() {
            // Where the marker itself is: about the tracker's origin, metres away, turns would be counted as shifts.
            let at_marker = (*u * Point::new(0.0, 0.0, 0.0)).covariance();
            if at_marker.cholesky().is_none() {
                return Err(Refused::BadCovariance { pose });
            }
            turn += u.covariance().fixed_view::<3, 3>(0, 0).trace() / 3.0;
            shift += at_marker.trace() / 3.0;
        }
        let count = poses.len() as f64;
        let typical = PoseNoise {
            sigma_mm: (shift / count).sqrt(),
            sigma_rad: (turn / count).sqrt(),
        };
        Ok(Self { covariances, typical })
    }

    /// The equations of one pose; `None` where its residual has no noise in some direction.
    fn equations(&self, i: usize, pose: &Pose, state: &State) -> Option<Equations> {
        let c = &self.covariances[i];
        let y = pose.r * state.tip + pose.t;
        let (_, gain) = weighed(c, &y)?;
        let e = gain * (y - state.pivot);
        let (w, v) = (-e.fixed_rows::<3>(0).into_owned(), e.fixed_rows::<3>(3).into_owned());
        // T' = exp(-e) T applied to the tip, to second order in the turn.
        let corrected = turned(&w, &y) - v;
        // With the lever of the corrected pose: the measured one would correlate the weight with the noise.
        let (weight, _) = weighed(c, &corrected)?;
        Some(Equations {
            rotation: Matrix3::from_columns(&[0, 1, 2].map(|k| turned(&w, &pose.r.column(k).into_owned()))),
            residual: corrected - state.pivot + jacobian(&corrected) * e,
            weight,
        })
    }
}

/// `J` for the point `y`.
fn jacobian(y: &Vector3<f64>) -> Matrix3x6<f64> {
    let mut j = Matrix3x6::zeros();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(&-y.cross_matrix());
    j.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
    j
}

/// `S^-1`, and `C J^T S^-1`.
fn weighed(c: &Matrix6<f64>, y: &Vector3<f64>) -> Option<(Matrix3<f64>, nalgebra::Matrix6x3<f64>)> {
    let j = jacobian(y);
    let weight = (j * c * j.transpose()).cholesky()?.inverse();
    Some((weight, c * j.transpose() * weight))
}

/// One pose once its own error is taken out.
struct Equations {
    rotation: Matrix3<f64>,
    residual: Vector3<f64>,
    weight: Matrix3<f64>,
}

impl robust::Noise for Each {
    fn sigma_mm(&self) -> f64 {
        self.typical.sigma_mm
    }

    fn normal(&self, problem: &Problem, state: &State, weights: &[f64]) -> Normal {
        let (mut matrix, mut vector) = (Matrix6::zeros(), Vector6::zeros());
        for (i, (pose, w)) in problem.poses.iter().zip(weights).enumerate() {
            // Forgotten poses cost nothing; one without noise in some direction has an infinite square, and so no
            // weight.
            let Some(eq) = (*w > 0.0).then(|| self.equations(i, pose, state)).flatten() else {
                continue;
            };
            let mut j = Matrix3x6::zeros();
            j.fixed_view_mut::<3, 3>(0, 0).copy_from(&eq.rotation);
            j.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Matrix3::identity());
            let back = j.transpose() * eq.weight * *w;
            matrix += back * j;
            vector += back * eq.residual;
        }
        Normal { matrix, vector }
    }

    fn squares(&self, problem: &Problem, state: &State, squares: &mut [f64]) {
        for (i, (pose, square)) in problem.poses.iter().zip(squares).enumerate() {
            let found = self.equations(i, pose, state);
            *square = found.map_or(f64::INFINITY, |eq| eq.residual.dot(&(eq.weight * eq.residual)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::robust::Noise;
    use super::*;
    use geometry::{Marker, Rigid, Tracker, Vector};

    /// Isotropic noise about each marker written as covariances gives the equations of the isotropic noise.
    #[test]
    fn isotropic_covariances_are_isotropic_noise() {
        let noise = PoseNoise {
            sigma_mm: 0.1,
            sigma_rad: 0.002,
        };
        let pose = |i: usize| {
            let a = i as f64;
            let turn = Vector::new(0.5 * a.cos(), 0.6 * (1.7 * a).sin(), 0.4 * (2.3 * a).cos());
            let t = Vector::new(10.0 * (3.1 * a).sin(), 20.0 * (0.9 * a).cos(), 900.0 + 5.0 * a.cos());
            Rigid::<Tracker, Marker>::from_rotation_vector(turn, t).unwrap()
        };
        let poses: Vec<_> = (0..8).map(pose).collect();
        let mut problem = Problem::new(&poses);
        let [r, t] = [noise.sigma_rad.powi(2), noise.sigma_mm.powi(2)];
        let c = Matrix6::from_diagonal(&Vector6::new(r, r, r, t, t, t));
        let uncertain = |p: &Rigid<Tracker, Marker>| {
            let [x, y, z] = p.translation_mm();
            Uncertain::from_covariance_about(Point::new(x, y, z), *p, c).unwrap()
        };
        let each = Each::new(&poses.iter().map(uncertain).collect::<Vec<_>>(), &problem).unwrap();
        assert!((each.typical.sigma_mm / 0.1 - 1.0).abs() < 1e-12, "{:?}", each.typical);
        let state = State {
            tip: Vector3::new(4.0, -3.0, 150.0),
            pivot: Vector3::new(1.0, 2.0, -1.0),
        };
        for (i, pose) in problem.poses.iter_mut().enumerate() {
            let a = i as f64;
            let off = Vector3::new(a.cos(), (2.0 * a).sin(), (3.0 * a).cos()) * 0.004;
            pose.t = state.pivot - pose.r * state.tip + off;
        }
        // The translations moved, and with them the places that the covariances are about.
        let moved: Vec<_> = problem
            .poses
            .iter()
            .zip(&poses)
            .map(|(p, old)| {
                let t = p.t + problem.centre;
                uncertain(&Rigid::from_parts(old.rotation(), Vector::new(t.x, t.y, t.z)))
            })
            .collect();
        let each = Each::new(&moved, &problem).unwrap();
        let (found, expected) = (
            each.normal(&problem, &state, &[1.0; 8]),
            noise.normal(&problem, &state, &[1.0; 8]),
        );
        // One corrects the pose about the pivot, the other about the marker: their levers differ by the residual, 0.007 mm of
        // 150, which the ratio of the variances across and along, 10, carries into the weights.
        let bound = 10.0 * 0.007 / 150.0;
        assert!((found.matrix - expected.matrix).norm() < bound * expected.matrix.norm());
        assert!((found.vector - expected.vector).norm() < bound * expected.vector.norm());
    }
}
