//! The normal equations of emitters and poses, with the poses eliminated.
//!
//! A sighting `a` of the emitter `b` under the pose `(R, t)` leaves `r = a - (R b + t)`, of information `W`. With a
//! small motion `(w, v)` after the pose, turning about the image of the body's origin, and a small `db`,
//!
//! ```text
//! d(R b + t) = J (w, v) + R db,     J = [ -[R b]x / L   1 ]                                                     (1)
//! ```
//!
//! `w` counted in units of 1 / L, L the body's radius, so that all unknowns are lengths. Per view, with `H = sum J^T W J`,
//! `h = sum J^T W r`, and per sighting `A = R^T W J`,
//!
//! ```text
//! S_ij = [i = j] sum R^T W R - sum A_i H^-1 A_j^T,     s_i = sum R^T W r - sum A_i H^-1 h                       (2)
//! S db = s,     (w, v) = H^-1 (h - sum A_j^T db_j)                                                              (3)
//! ```
//!
//! summed over views: 3 N unknowns instead of 3 N + 6 K (the bundle adjustment of photogrammetry, Triggs et al. 2000).
//! `S` annuls the six motions of the whole marker; they are the gauge and are held at zero.

use geometry::motion::Pose;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

use super::Refused;
use super::views::Station;

/// Emitters by column, and a pose per station: localizer's axes about the view's centre, from the body's.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) places: Vec<Vector3<f64>>,
    pub(super) poses: Vec<Pose>,
}

/// `J` of (1), for the image `y = R b`.
pub(super) fn jacobian(y: &Vector3<f64>, radius: f64) -> Matrix3x6<f64> {
    let mut j = Matrix3x6::zeros();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(&(y.cross_matrix() / -radius));
    j.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
    j
}

/// One sighting's part in (2).
struct Term {
    column: usize,
    /// `A`.
    coupling: Matrix3x6<f64>,
    /// `R^T W R`.
    own: Matrix3<f64>,
    /// `R^T W r`.
    pull: Vector3<f64>,
}

/// One view with its pose eliminated.
pub(super) struct View {
    terms: Vec<Term>,
    inverse: Matrix6<f64>,
    gradient: Vector6<f64>,
}

impl View {
    /// Forms (2) for one station; `None` where its emitters do not hold the pose.
    pub(super) fn of(
        station: &Station,
        pose: &Pose,
        column: impl Fn(usize) -> Option<usize>,
        places: &[Vector3<f64>],
        radius: f64,
    ) -> Option<Self> {
        let r = pose.matrix();
        let (mut normal, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
        let mut terms = Vec::with_capacity(station.sightings.len());
        for s in &station.sightings {
            let column = column(s.emitter)?;
            let y = r * places[column];
            let residual = s.place - y - pose.shift;
            let j = jacobian(&y, radius);
            let weighted = s.information * j;
            normal += j.transpose() * weighted;
            gradient += weighted.transpose() * residual;
            // In the body's frame, in which emitters are unknowns; the pose is eliminated in the station's.
            let back = r.transpose() * s.information;
            terms.push(Term {
                column,
                coupling: r.transpose() * weighted,
                own: back * r,
                pull: back * residual,
            });
        }
        Some(Self {
            terms,
            inverse: normal.cholesky()?.inverse(),
            gradient,
        })
    }

    /// Adds the view to `S` and `s`.
    pub(super) fn add_to(&self, matrix: &mut DMatrix<f64>, vector: &mut DVector<f64>) {
        for a in &self.terms {
            let carried = a.coupling * self.inverse;
            let mut part = vector.fixed_rows_mut::<3>(3 * a.column);
            part += a.pull - carried * self.gradient;
            let mut own = matrix.fixed_view_mut::<3, 3>(3 * a.column, 3 * a.column);
            own += a.own;
            for b in &self.terms {
                let mut block = matrix.fixed_view_mut::<3, 3>(3 * a.column, 3 * b.column);
                block -= carried * b.coupling.transpose();
            }
        }
    }

    /// The pose's step (3), `w` in units of 1 / L.
    pub(super) fn pose_step(&self, step: &DVector<f64>) -> Vector6<f64> {
        let part = |t: &Term| t.coupling.transpose() * step.fixed_rows::<3>(3 * t.column);
        self.inverse * (self.gradient - self.terms.iter().map(part).sum::<Vector6<f64>>())
    }
}

/// Orthonormal columns: the six motions of the whole body.
pub(super) fn gauge(places: &[Vector3<f64>]) -> DMatrix<f64> {
    let n = places.len();
    let mut motions = DMatrix::zeros(3 * n, 6);
    let root = places.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
    for (i, b) in places.iter().enumerate() {
        let mut shifts = motions.fixed_view_mut::<3, 3>(3 * i, 0);
        shifts.copy_from(&Matrix3::identity());
        let mut turns = motions.fixed_view_mut::<3, 3>(3 * i, 3);
        turns.copy_from(&(b.cross_matrix() / -root));
    }
    motions.qr().q()
}

/// `S` with the gauge held: `S + m G G^T`, m the mean of the diagonal, which leaves the other motions as they are.
pub(super) fn held(matrix: &DMatrix<f64>, gauge: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
    let mean = matrix.trace() / matrix.nrows() as f64;
    (matrix + gauge * gauge.transpose() * mean, mean)
}

/// The covariance of the places for a body laid best on the true one: the pseudo-inverse of `S`, mm^2.
pub(super) fn covariance(matrix: &DMatrix<f64>, gauge: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (held, mean) = held(matrix, gauge);
    let inverse = held.cholesky()?.inverse();
    // (S + m G G^T)^-1 = S^+ + G G^T / m, as S G = 0 and G is orthonormal.
    let covariance = inverse - gauge * gauge.transpose() / mean;
    Some((&covariance + covariance.transpose()) * 0.5)
}

/// Most that the ratio of the largest deviation to the least may be.
const MAX_CONDITION: f64 = 1e4;

/// The ratio of the largest deviation of any combination of places to the least.
///
/// `name` gives the emitter of a column.
pub(super) fn condition(
    matrix: &DMatrix<f64>,
    gauge: &DMatrix<f64>,
    name: impl Fn(usize) -> usize,
) -> Result<f64, Refused> {
    // The gauge's six eigenvalues are the mean of the diagonal: at most the largest, at least its 3 N-th part, so that
    // they never pass the limit by themselves.
    let (held, _) = held(matrix, gauge);
    let values = held.clone().symmetric_eigenvalues();
    // Rounding may leave a least value below zero; at zero the condition is infinite and is refused.
    let (most, least) = (values.max(), values.min().max(0.0));
    let condition = (most / least).sqrt();
    if condition <= MAX_CONDITION {
        return Ok(condition);
    }
    let eigen = held.symmetric_eigen();
    let weakest = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    // The emitter with the largest share in the weakest combination is the one that the views hardly hold.
    let share = |i: &usize| weakest.fixed_rows::<3>(3 * i).norm();
    let columns = 0..matrix.nrows() / 3;
    let emitter = columns.max_by(|a, b| share(a).total_cmp(&share(b))).map_or(0, name);
    Err(Refused::Weak {
        emitter,
        condition,
        allowed: MAX_CONDITION,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::motion::Motion;
    use geometry::rotation::{Rotation, RotationVector};

    /// Both derivatives of (1) against central differences: the third derivative times h^2 / 6, below 40 mm x 1e-10.
    #[test]
    fn derivatives_are_those_of_differences() {
        let turn = Rotation::from_vector(RotationVector::new([0.7, -1.9, 0.4]).unwrap());
        let pose = Pose {
            turn,
            shift: Vector3::new(3.0, -2.0, 5.0),
        };
        let b = Vector3::new(12.0, -25.0, 17.0);
        let (radius, h) = (30.0, 1e-5);
        let image = |x: &Vector6<f64>, d: &Vector3<f64>| {
            let (turn, shift) = (x.fixed_rows::<3>(0) / radius, x.fixed_rows::<3>(3).into_owned());
            let moved = pose.moved_in_place(&Motion { turn, shift }).unwrap();
            // A motion after the pose turns about the image of the body's origin.
            moved.matrix() * (b + d) + moved.shift
        };
        let j = jacobian(&(pose.matrix() * b), radius);
        for k in 0..6 {
            let step = Vector6::ith(k, h);
            let zero = Vector3::zeros();
            let slope = (image(&step, &zero) - image(&-step, &zero)) / (2.0 * h);
            assert!((slope - j.column(k)).amax() < 1e-8, "{k}: {slope} {j}");
        }
        for k in 0..3 {
            let step = Vector3::ith(k, h);
            let zero = Vector6::zeros();
            let slope = (image(&zero, &step) - image(&zero, &-step)) / (2.0 * h);
            assert!((slope - pose.matrix().column(k)).amax() < 1e-8, "{k}");
        }
    }

    #[test]
    fn the_gauge_is_annulled_and_orthonormal() {
        let places: Vec<Vector3<f64>> = (0..5_u32)
            .map(|i| Vector3::new(f64::from(i * i) - 4.0, f64::from(i * 7 % 5), f64::from(i * 3 % 4)))
            .collect();
        let g = gauge(&places);
        assert!((g.transpose() * &g - DMatrix::identity(6, 6)).amax() < 1e-14);
        let information = Matrix3::new(2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5);
        let sighting = |(emitter, p): (usize, &Vector3<f64>)| super::super::views::Sighting {
            emitter,
            place: *p,
            information,
        };
        let station = Station {
            view: 0,
            centre: Vector3::zeros(),
            sightings: places.iter().enumerate().map(sighting).collect(),
        };
        let pose = Pose {
            turn: Rotation::IDENTITY,
            shift: Vector3::zeros(),
        };
        let view = View::of(&station, &pose, Some, &places, 5.0).unwrap();
        let (mut s, mut v) = (DMatrix::zeros(15, 15), DVector::zeros(15));
        view.add_to(&mut s, &mut v);
        // Some tens of roundings of entries of size 2.
        assert!((&s * &g).amax() < 1e-13 && v.amax() == 0.0, "{}", s * g);
    }
}
