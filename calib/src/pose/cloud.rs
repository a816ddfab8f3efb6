//! The emitters seen, the pose of greatest likelihood of them, and which of them disagrees.

use geometry::rotation::{Rotation, RotationVector};
use geometry::{Frame, Point, Rigid, Tracker, Uncertain, Vector};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::sighting::{Gates, Lost, MAX_EMITTERS, Pose, Sighting};
use super::{Body, Localizer, radius_95_mm};
use crate::registration::{Method, Pairs, fit};

/// Gauss-Newton steps from the closed solution; it is so near that the second changes nothing that can be measured.
const GAUSS_NEWTON_STEPS: usize = 3;
/// A step below this, radians and mm, ends the iteration: the next would be of its square.
const STEP_END: f64 = 1e-7;

/// The emitters of the body that are seen and still trusted.
pub(super) struct Cloud<F> {
    pub(super) count: usize,
    index: [usize; MAX_EMITTERS],
    to: [Point<Tracker>; MAX_EMITTERS],
    from: [Point<F>; MAX_EMITTERS],
    own: [Matrix3<f64>; MAX_EMITTERS],
    pub(super) last_residual: Option<Lost>,
}

/// A pose of the cloud: `tracker = rotation (p - from_centre) + to_centre`.
pub(super) struct Solved {
    turn: Rotation,
    /// The matrix of `turn`.
    rotation: Matrix3<f64>,
    from_centre: Vector3<f64>,
    to_centre: Vector3<f64>,
    /// (J^T W J)^-1 about the centre in `Tracker`.
    covariance: Matrix6<f64>,
    /// `R b'`: the emitters about the centre, in `Tracker`.
    arms: [Vector3<f64>; MAX_EMITTERS],
    residuals: [Vector3<f64>; MAX_EMITTERS],
    covariances: [Matrix3<f64>; MAX_EMITTERS],
    information: [Matrix3<f64>; MAX_EMITTERS],
}

impl<F: Frame> Cloud<F> {
    pub(super) fn collect(body: &Body<F>, seen: &[Sighting]) -> Result<Self, Lost> {
        let mut cloud = Self {
            count: 0,
            index: [0; MAX_EMITTERS],
            to: [Point::new(0.0, 0.0, 0.0); MAX_EMITTERS],
            from: [Point::new(0.0, 0.0, 0.0); MAX_EMITTERS],
            own: [Matrix3::zeros(); MAX_EMITTERS],
            last_residual: None,
        };
        for (index, sighting) in seen.iter().take(MAX_EMITTERS).enumerate() {
            let place = sighting.place.mm();
            let emitter = body.emitters().get(sighting.emitter);
            // A number that is not finite would spread to the whole pose, and an unknown emitter has no place.
            let Some(emitter) = emitter.filter(|_| place.iter().all(|x| x.is_finite())) else {
                return Err(Lost::Malformed {
                    index,
                    emitter: sighting.emitter,
                    place,
                });
            };
            // The first sighting of an emitter counts: a localizer that names one twice means one of them wrongly.
            if cloud.index[..cloud.count].contains(&sighting.emitter) {
                continue;
            }
            let n = cloud.count;
            cloud.index[n] = sighting.emitter;
            cloud.to[n] = sighting.place;
            cloud.from[n] = emitter.place;
            cloud.own[n] = emitter.covariance_mm2;
            cloud.count += 1;
        }
        Ok(cloud)
    }

    pub(super) fn leave_out(&mut self, index: usize) {
        // The order of emitters has no meaning, so that the last takes the empty place and nothing is moved.
        let last = self.count - 1;
        self.index.swap(index, last);
        self.to.swap(index, last);
        self.from.swap(index, last);
        self.own.swap(index, last);
        self.count = last;
    }

    /// The closed solution weighted by `3 / tr C`, then steps with the full weights. `None` where no pose follows.
    pub(super) fn solve(&self, localizer: &Localizer) -> Option<Solved> {
        let n = self.count;
        let mut weights = [0.0; MAX_EMITTERS];
        let mut seen = [Matrix3::zeros(); MAX_EMITTERS];
        for i in 0..n {
            // Where the emitter was seen, not where the pose puts it: so the weights stay the same while the pose
            // moves.
            seen[i] = localizer.covariance_mm2(self.to[i]);
            weights[i] = 3.0 / (seen[i].trace() + self.own[i].trace());
        }
        let pairs = Pairs::new(&self.to[..n], &self.from[..n])
            .ok()?
            .weighted(&weights[..n])
            .ok()?;
        // The closed solution needs no start, and takes noise as the same in all directions.
        let start = fit(pairs, Method::Newton).ok()?;
        let turn = start.transform.rotation();
        let mut solved = Solved {
            turn,
            rotation: matrix(turn),
            from_centre: centre(&self.from[..n], &weights),
            to_centre: Vector3::zeros(),
            covariance: Matrix6::zeros(),
            arms: [Vector3::zeros(); MAX_EMITTERS],
            residuals: [Vector3::zeros(); MAX_EMITTERS],
            covariances: seen,
            information: [Matrix3::zeros(); MAX_EMITTERS],
        };
        solved.to_centre = centre(&self.to[..n], &weights);
        // The last pass moves nothing: it has the equations at the pose that is returned, for its covariance.
        for step in 0.. {
            let (normal, right) = self.normal(&mut solved, &seen)?;
            let factor = normal.cholesky()?;
            let motion = factor.solve(&right);
            if step == GAUSS_NEWTON_STEPS || motion.amax() <= STEP_END {
                solved.covariance = factor.inverse();
                return Some(solved);
            }
            solved.moved(&motion)?;
        }
        None
    }

    /// `J^T W J` and `J^T W r` about the centre, `J = (-[R b']x, I)`; fills the residuals and weights in.
    fn normal(&self, solved: &mut Solved, seen: &[Matrix3<f64>]) -> Option<(Matrix6<f64>, Vector6<f64>)> {
        let zero = Matrix3::zeros();
        let (mut turn, mut both, mut shift) = (zero, zero, zero);
        let (mut torque, mut force) = (Vector3::zeros(), Vector3::zeros());
        for (i, seen) in seen.iter().enumerate().take(self.count) {
            let own = &self.own[i];
            // Both errors are independent. Most bodies are taken as exact, which saves two products of matrices.
            let covariance = if *own == zero {
                *seen
            } else {
                seen + solved.rotation * own * solved.rotation.transpose()
            };
            let w = inverse(&covariance)?;
            let y = solved.rotation * (vector(self.from[i]) - solved.from_centre);
            let residual = vector(self.to[i]) - solved.to_centre - y;
            // With Y = [y]x: J^T = (Y; I), so the blocks are Y W Y^T, Y W and W.
            let yw = crossed(&y, &w);
            turn += crossed(&y, &yw.transpose());
            both += yw;
            shift += w;
            let pull = w * residual;
            torque += y.cross(&pull);
            force += pull;
            solved.arms[i] = y;
            solved.residuals[i] = residual;
            solved.covariances[i] = covariance;
            solved.information[i] = w;
        }
        let mut normal = Matrix6::zeros();
        normal.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        normal.fixed_view_mut::<3, 3>(0, 3).copy_from(&both);
        normal.fixed_view_mut::<3, 3>(3, 0).copy_from(&both.transpose());
        normal.fixed_view_mut::<3, 3>(3, 3).copy_from(&shift);
        let right = Vector6::new(torque.x, torque.y, torque.z, force.x, force.y, force.z);
        Some((normal, right))
    }

    /// The emitter that disagrees most with the rest, if it does: its residual in units of its own deviation, which is less
    /// than that of its noise, as the pose followed it.
    pub(super) fn worst(&self, solved: &Solved, gates: &Gates) -> Option<(usize, Lost)> {
        // A limit that is not a number allows nothing: no comparison with it would refuse.
        let limit = |x: f64| if x.is_nan() { 0.0 } else { x };
        let mut worst = None;
        let mut most = limit(gates.outlier_sigmas * gates.outlier_sigmas);
        for i in 0..self.count {
            let square = solved.studentised(i);
            if square > most {
                most = square;
                worst = Some(i);
            }
        }
        let fre_rms_mm = solved.fre(self.count);
        // Many emitters that are a little off pass one by one; then their mean square is judged, and the largest one
        // named.
        let worst = worst.or_else(|| (fre_rms_mm > limit(gates.max_fre_mm)).then(|| solved.largest(self.count)))?;
        let residual = Lost::Residual {
            fre_rms_mm,
            worst: self.index[worst],
            worst_mm: solved.residuals[worst].norm(),
            allowed_mm: gates.max_fre_mm,
        };
        Some((worst, residual))
    }

    pub(super) fn accept(&self, solved: &Solved, all: usize, tip: Point<F>, gates: &Gates) -> Result<Pose<F>, Lost> {
        let refused = |tip_95_mm| Lost::Geometry {
            tip_95_mm,
            allowed_mm: gates.max_tip_mm,
        };
        let transform = solved.transform().ok_or(refused(f64::INFINITY))?;
        let tip_95_mm = radius_95_mm(&(transform * tip).covariance());
        // A NaN is neither above a gate nor is anything above it: both have to be asked for.
        if tip_95_mm.is_nan() || gates.max_tip_mm.is_nan() || tip_95_mm > gates.max_tip_mm {
            return Err(refused(tip_95_mm));
        }
        let chi = |i: usize| solved.residuals[i].dot(&(solved.information[i] * solved.residuals[i]));
        Ok(Pose {
            transform,
            fre_rms_mm: solved.fre(self.count),
            used: self.count,
            outliers: all - self.count,
            chi_squared: (0..self.count).map(chi).sum(),
            tip_95_mm,
        })
    }
}

impl Solved {
    fn moved(&mut self, motion: &Vector6<f64>) -> Option<()> {
        let vector = RotationVector::new([motion[0], motion[1], motion[2]]).ok()?;
        self.turn = Rotation::from_vector(vector) * self.turn;
        self.rotation = matrix(self.turn);
        // The motion turns about the image of the emitters' centre, which a turn leaves in its place.
        self.to_centre += motion.fixed_rows::<3>(3);
        Some(())
    }

    /// The square of residual `i` in units of its own covariance `C - J S J^T`, S that of the pose.
    fn studentised(&self, i: usize) -> f64 {
        let (y, s) = (self.arms[i], &self.covariance);
        let block = |r, c| s.fixed_view::<3, 3>(r, c).into_owned();
        // J S J^T with J = (-Y, I), Y = [y]x: Y S00 Y^T - Y S03 - (Y S03)^T + S33.
        let turn = crossed(&y, &crossed(&y, &block(0, 0)).transpose());
        let both = crossed(&y, &block(0, 3));
        let followed = turn - both - both.transpose() + block(3, 3);
        let covariance = self.covariances[i];
        // Along directions that the pose follows fully there is no residual to judge.
        let floor = Matrix3::identity() * (1e-9 * covariance.trace());
        let r = self.residuals[i];
        // Where even so no variance is left, the emitter cannot be judged and is kept.
        inverse(&(covariance - followed + floor)).map_or(0.0, |inverse| r.dot(&(inverse * r)))
    }

    fn fre(&self, count: usize) -> f64 {
        let sum: f64 = self.residuals[..count].iter().map(Vector3::norm_squared).sum();
        (sum / count as f64).sqrt()
    }

    fn largest(&self, count: usize) -> usize {
        let order = |a: &usize, b: &usize| self.residuals[*a].norm().total_cmp(&self.residuals[*b].norm());
        (0..count).max_by(order).unwrap_or(0)
    }

    fn transform<F: Frame>(&self) -> Option<Uncertain<Tracker, F>> {
        // The pose is known about the emitters, tens of mm across and metres from the tracker's origin; only here is it
        // moved to that origin.
        let t = self.to_centre - self.rotation * self.from_centre;
        let transform = Rigid::from_parts(self.turn, Vector::new(t.x, t.y, t.z));
        let c = self.to_centre;
        Uncertain::from_covariance_about(Point::new(c.x, c.y, c.z), transform, symmetric(&self.covariance)).ok()
    }
}

fn matrix(rotation: Rotation) -> Matrix3<f64> {
    rotation.matrix().into()
}

fn symmetric(c: &Matrix6<f64>) -> Matrix6<f64> {
    (c + c.transpose()) * 0.5
}

/// `[y]x m`: the vector product with each column.
#[inline]
fn crossed(y: &Vector3<f64>, m: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|c| y.cross(&m.column(c).into_owned())))
}

/// The inverse of a symmetric matrix by its cofactors; `None` where it is not positive definite. Covariances of points
/// are well conditioned: what cancels is the square of the ratio of deviations, below 1e4.
#[inline]
fn inverse(c: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let (a, b, d, e, f, g) = (c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]);
    let (aa, bb, dd) = (e * g - f * f, d * f - b * g, b * f - d * e);
    let determinant = a * aa + b * bb + d * dd;
    // Sylvester's criterion; in this form a NaN fails it.
    if !(determinant > 0.0 && a > 0.0 && aa > 0.0) {
        return None;
    }
    let (ee, ff, gg) = (a * g - d * d, b * d - a * f, a * e - b * b);
    Some(Matrix3::new(aa, bb, dd, bb, ee, ff, dd, ff, gg) / determinant)
}

fn vector<F>(p: Point<F>) -> Vector3<f64> {
    Vector3::from(p.mm())
}

fn centre<F>(points: &[Point<F>], weights: &[f64]) -> Vector3<f64> {
    let total: f64 = weights[..points.len()].iter().sum();
    let sum: Vector3<f64> = points.iter().zip(weights).map(|(p, w)| vector(*p) * *w).sum();
    sum / total
}
