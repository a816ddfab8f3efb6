//! The error that uncertain parameters of a model make, to first order.
//!
//! A result `u` depends on independent parameters `p_i` with standard deviations `s_i`. With `u+`, `u-` found at `p_i +- s_i` its covariance is
//! `sum of d_i d_i^T`, `d_i = (u+ - u-) / 2`: a linearisation. What it leaves out shows in `(u+ + u-) / 2 - u`, which is zero of a linear
//! result.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// The roots of the 95 % quantiles of chi squared with one, two and three degrees of freedom: half axes by standard deviations.
const HALF_AXES_95: [f64; 3] = [1.959_963_984_540_054, 2.447_746_830_680_816, 2.795_483_482_915_108];
/// A variance below this part of the largest is rounding: nothing spreads that way.
const NO_SPREAD: f64 = 1e-12;
/// A departure of more than this part of the standard deviation says that the linearisation does not hold.
pub const LINEAR_PART: f64 = 0.25;

/// How a vector (a displacement, a force) changes when one parameter is moved up and down by its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Changes from the state found, parameter up and down.
    pub by: [Vector3<f64>; 2],
}

impl Shift {
    /// Half of the difference: the change for one standard deviation, to first order.
    pub fn half(&self) -> Vector3<f64> {
        (self.by[0] - self.by[1]) * 0.5
    }

    /// How far the mean of the two is from the state found: zero where the result is linear in the parameter.
    pub fn departure(&self) -> f64 {
        ((self.by[0] + self.by[1]) * 0.5).norm()
    }
}

/// What several independent parameters do together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// To first order.
    pub covariance: Matrix3<f64>,
    /// The largest departure of a parameter from linear.
    pub departure: f64,
    /// The departures of all together.
    pub shift: Vector3<f64>,
}

impl Spread {
    /// Of the shifts of all parameters, `None` for one that is not known. `None` where there is no parameter, or where one is not known or
    /// no number: what is missing is not zero.
    pub fn of(shifts: &[Option<Shift>]) -> Option<Self> {
        let mut all = Self {
            covariance: Matrix3::zeros(),
            departure: 0.0,
            shift: Vector3::zeros(),
        };
        for shift in shifts {
            // One that is not known leaves the whole unknown: a sum without it would be too small.
            let shift = (*shift)?;
            let half = shift.half();
            all.covariance += half * half.transpose();
            all.departure = all.departure.max(shift.departure());
            all.shift += (shift.by[0] + shift.by[1]) * 0.5;
        }
        let good = !shifts.is_empty() && all.covariance.iter().all(|x| x.is_finite()) && all.departure.is_finite();
        good.then_some(all)
    }

    /// The root of the trace of the covariance.
    pub fn deviation(&self) -> f64 {
        self.covariance.trace().max(0.0).sqrt()
    }

    /// Whether departures from linear, the largest and all together, are small beside the deviation, or no more than what each state is known to, `noise`.
    pub fn is_linear(&self, noise: f64) -> bool {
        self.departure.max(self.shift.norm()) <= (LINEAR_PART * self.deviation()).max(noise)
    }

    /// Half axes by standard deviations of what holds 95 %: of a line, an ellipse or an ellipsoid, as many ways as there is spread.
    pub fn half_axes_95(&self) -> f64 {
        let variances = self.covariance.symmetric_eigenvalues();
        let ways = variances.iter().filter(|v| **v > NO_SPREAD * variances.max()).count();
        HALF_AXES_95[ways.clamp(1, 3) - 1]
    }

    /// Half axes and unit directions of the ellipsoid that holds 95 % of a normal distribution of this covariance, the longest first. Each
    /// direction has its largest component above zero.
    pub fn ellipsoid(&self) -> [(f64, Vector3<f64>); 3] {
        let (eigen, factor) = (SymmetricEigen::new(self.covariance), self.half_axes_95());
        let mut axes = [0, 1, 2].map(|k| {
            let direction = eigen.eigenvectors.column(k).into_owned();
            let sign = if direction[direction.iamax()] < 0.0 { -1.0 } else { 1.0 };
            // Rounding makes a zero a little less.
            (factor * eigen.eigenvalues[k].max(0.0).sqrt(), direction * sign)
        });
        axes.sort_by(|a, b| b.0.total_cmp(&a.0));
        axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shift(up: [f64; 3], down: [f64; 3]) -> Option<Shift> {
        Some(Shift {
            by: [up.into(), down.into()],
        })
    }

    #[test]
    fn the_ellipsoid_holds_95_percent() {
        // The densities of the radius of one, two and three independent standard normal numbers, by Simpson's rule.
        let whole = (2.0 / std::f64::consts::PI).sqrt();
        for (ways, scale) in [(0, whole), (1, 1.0), (2, whole)] {
            let density = |r: f64| scale * r.powi(ways) * (-0.5 * r * r).exp();
            let half = HALF_AXES_95[ways as usize];
            let (parts, mut sum) = (2000, 0.0);
            for k in 0..=parts {
                let weight = if k == 0 || k == parts {
                    1.0
                } else {
                    2.0 + 2.0 * f64::from(k % 2)
                };
                sum += weight * density(half * f64::from(k) / f64::from(parts));
            }
            let held = sum * half / f64::from(3 * parts);
            assert!((held - 0.95).abs() < 1e-11, "{ways}: {held}");
        }
    }

    #[test]
    fn independent_shifts_along_axes_are_the_half_axes() {
        let all = [
            shift([0.0, 3.0, 0.0], [0.0, -3.0, 0.0]),
            shift([-4.0, 0.0, 0.0], [4.0, 0.0, 0.0]),
        ];
        let spread = Spread::of(&all).unwrap();
        let [long, middle, short] = spread.ellipsoid();
        assert!((long.0 - 4.0 * HALF_AXES_95[1]).abs() < 1e-14 && (long.1 - Vector3::x()).norm() < 1e-14);
        assert!((middle.0 - 3.0 * HALF_AXES_95[1]).abs() < 1e-14 && (middle.1 - Vector3::y()).norm() < 1e-14);
        assert!(short.0 == 0.0 && spread.departure == 0.0 && spread.is_linear(0.0));
        assert!((spread.deviation() - 5.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_not_linear_is_told_and_what_is_not_known_is_not_zero() {
        let bent = Spread::of(&[shift([2.0, 0.0, 0.0], [-1.0, 0.0, 0.0])]).unwrap();
        assert!(
            (bent.departure - 0.5).abs() < 1e-15
                && (bent.deviation() - 1.5).abs() < 1e-15
                && !bent.is_linear(0.4)
                && bent.is_linear(0.6)
        );
        // One number alone spreads along a line; sixteen that each depart little depart much together.
        assert!((bent.ellipsoid()[0].0 - 1.5 * HALF_AXES_95[0]).abs() < 1e-14);
        let many = Spread::of(&[shift([1.9, 0.0, 0.0], [-0.1, 0.0, 0.0]); 16]).unwrap();
        assert!(many.departure < LINEAR_PART * many.deviation() && !many.is_linear(0.0));
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[shift([1.0; 3], [-1.0; 3]), None]), None);
        assert_eq!(Spread::of(&[shift([f64::NAN; 3], [0.0; 3])]), None);
        assert_eq!(Spread::of(&[shift([f64::INFINITY; 3], [0.0; 3])]), None);
    }
}
