//! Poses of a pointer that is held still to the place of its tip.

use geometry::{Marker, Point, Tool, Tracker, Uncertain, UncertainPoint, Vector};
use nalgebra::Matrix3;

use super::{Listened, LiveError};

/// The fewest poses of a touch: a third of them is a mean.
const FEWEST: usize = 9;
/// How many deviations of such a difference the means of two thirds may be apart, beside the motion allowed: one touch in
/// some thousands is refused for its noise alone.
const DEVIATIONS: f64 = 4.0;

/// How far the tip may move during a touch, mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MostMotion(pub(crate) f64);

impl MostMotion {
    /// A hand that rests.
    pub(crate) const USUAL: Self = Self(0.5);
}

/// A touched point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touched {
    /// In the frame of the poses; its covariance has the noise of the emitters over all poses and the tip's calibration.
    pub(crate) place: UncertainPoint<Tracker>,
    /// The calibration's part of that: what three normal numbers of deviation 1, the same for all touches with this calibration,
    /// move the place by, a column for each, mm.
    pub(crate) shared: Matrix3<f64>,
    /// The largest distance between the mean places of the three thirds of the time.
    pub(crate) moved_mm: f64,
    /// The scatter of single poses over that of their covariances.
    pub(crate) noise_ratio: f64,
    /// Root mean square distance of the tip at single poses from their mean.
    pub(crate) rms_mm: f64,
    pub(crate) poses: usize,
}

/// The mean place of the tip over all poses, refused where they are few, or where the tip moved.
///
/// The covariance is `k sum(C_i) / n^2 + R C R^T`: the poses' own at the tip, by the factor `k >= 1` by which they scatter
/// more, and the calibration's `C`, which no number of poses makes less.
pub(crate) fn touched(
    name: &str,
    heard: &Listened,
    marker_from_tool: &Uncertain<Marker, Tool>,
    most: MostMotion,
    seconds: f64,
) -> Result<Touched, LiveError> {
    enough(name, heard, seconds)?;
    let count = heard.poses.len() as f64;
    let tip = marker_from_tool.transform() * Point::<Tool>::new(0.0, 0.0, 0.0);
    let tips: Vec<UncertainPoint<Tracker>> = heard.poses.iter().map(|pose| *pose * tip).collect();
    let mean = mean(&tips);
    let sum: Matrix3<f64> = tips.iter().map(UncertainPoint::covariance).sum();
    let scatter: f64 = tips.iter().map(|t| (t.point() - mean).norm().powi(2)).sum();
    // Sum of squares over its expectation for n - 1 degrees of freedom; 0 / 0 where nothing is known of the noise.
    let ratio = (scatter / (count - 1.0)) / (sum.trace() / count);
    let ratio = if ratio.is_finite() { ratio } else { 1.0 };
    let own = sum * (ratio.max(1.0) / (count * count));
    let moved_mm = moved(&tips);
    // Two means of a third of the poses each.
    let noise_mm = DEVIATIONS * (sum.trace() / count * 6.0 / count).sqrt();
    let most_mm = most.0 + noise_mm;
    if moved_mm > most_mm {
        return Err(LiveError::Moved {
            name: name.to_owned(),
            moved_mm,
            most_mm,
        });
    }
    let pose = heard.poses[heard.poses.len() / 2].transform();
    let calibrated = *marker_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    let shared = Matrix3::from(pose.rotation().matrix()) * root(calibrated.covariance());
    let whole = own + shared * shared.transpose();
    Ok(Touched {
        place: UncertainPoint::new(mean, (whole + whole.transpose()) * 0.5)?,
        shared,
        moved_mm,
        noise_ratio: ratio.sqrt(),
        rms_mm: (scatter / count).sqrt(),
        poses: heard.poses.len(),
    })
}

/// The root `U` of a covariance, `U U^T`, that is symmetric and has no negative eigenvalue: there is one. Of its principal axes alone each may
/// point either way, and touches of different programs would then be of different numbers.
fn root(covariance: Matrix3<f64>) -> Matrix3<f64> {
    let eigen = covariance.symmetric_eigen();
    // Of a covariance of less than full rank rounding may leave a variance below zero.
    let deviations = eigen.eigenvalues.map(|variance| variance.max(0.0).sqrt());
    eigen.eigenvectors * Matrix3::from_diagonal(&deviations) * eigen.eigenvectors.transpose()
}

/// Refuses what is too little for a mean.
fn enough(name: &str, heard: &Listened, seconds: f64) -> Result<(), LiveError> {
    let n = heard.poses.len();
    let lost = heard.frames - n;
    if lost > n {
        return Err(LiveError::Lost {
            name: name.to_owned(),
            poses: n,
            frames: heard.frames,
            needed: heard.frames.div_ceil(2),
            why: heard.why.clone(),
        });
    }
    if n < FEWEST {
        return Err(LiveError::TooFew {
            name: name.to_owned(),
            poses: n,
            seconds,
            needed: FEWEST,
        });
    }
    Ok(())
}

/// The mean place.
fn mean(tips: &[UncertainPoint<Tracker>]) -> Point<Tracker> {
    let origin = tips[0].point();
    let sum = tips
        .iter()
        .fold(Vector::new(0.0, 0.0, 0.0), |sum, t| sum + (t.point() - origin));
    origin + sum * (1.0 / tips.len() as f64)
}

/// The largest distance between the means of three thirds.
fn moved(tips: &[UncertainPoint<Tracker>]) -> f64 {
    let third = tips.len() / 3;
    let [a, b, c] = [0, 1, 2].map(|i| mean(&tips[i * third..(i + 1) * third]));
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Rigid;
    use nalgebra::{Matrix6, Vector3, Vector6};

    /// Deterministic noise, even between -1 and 1: its variance is a third.
    fn noise(i: usize) -> f64 {
        let x = ((i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)) ^ 0x1234_5678;
        let x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((x >> 11) as f64 / (1_u64 << 53) as f64).mul_add(2.0, -1.0)
    }

    /// Poses of 0.2 mm along each axis, and a drift.
    fn heard(count: usize, drift_mm: f64) -> Listened {
        let variances = Matrix6::from_diagonal(&Vector6::new(0.0, 0.0, 0.0, 0.04, 0.04, 0.04));
        let pose = |i: usize| {
            let sigma = 0.2 * 3.0_f64.sqrt();
            let [x, y, z] = [0, 1, 2].map(|k| sigma * noise(3 * i + k));
            let at = Vector::new(100.0 + x + drift_mm * i as f64 / count as f64, y, 1900.0 + z);
            Uncertain::new(
                Rigid::from_parts(Rigid::<Tracker, Marker>::identity().rotation(), at),
                variances,
            )
            .unwrap()
        };
        let mut heard = Listened::default();
        (heard.frames, heard.poses) = (count, (0..count).map(pose).collect());
        heard
    }

    fn tool() -> Uncertain<Marker, Tool> {
        let variances = Matrix6::from_diagonal(&Vector6::new(0.0, 0.0, 0.0, 0.01, 0.01, 0.02));
        let at = Rigid::from_parts(
            Rigid::<Marker, Tool>::identity().rotation(),
            Vector::new(0.0, 0.0, 150.0),
        );
        Uncertain::new(at, variances).unwrap()
    }

    #[test]
    fn the_mean_is_as_good_as_it_says() {
        let found = touched("a", &heard(600, 0.0), &tool(), MostMotion(0.5), 1.0).unwrap();
        let off = (found.place.point() - Point::new(100.0, 0.0, 2050.0)).norm();
        // A mean of 600: 0.2 / sqrt(600) along each axis; five deviations of its length.
        assert!(off < 5.0 * 0.2 * (3.0 / 600.0_f64).sqrt(), "{off}");
        assert!((found.noise_ratio - 1.0).abs() < 0.1, "{found:?}");
        // 600 times the square of three deviations of 0.2 mm, which is known to a factor of 1 / sqrt(1800).
        assert!((found.rms_mm / (0.2 * 3.0_f64.sqrt()) - 1.0).abs() < 0.1, "{found:?}");
        let expected = 0.04 / 600.0 + 0.01;
        // The scatter may raise the first part by a tenth.
        assert!(
            (found.place.covariance()[(0, 0)] / expected - 1.0).abs() < 0.01,
            "{found:?}"
        );
        // What all touches share is the calibration's, turned into the frame of the touch.
        let calibrated = Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.02));
        assert!(
            (found.shared * found.shared.transpose() - calibrated).amax() < 1e-15,
            "{found:?}"
        );
    }

    /// Principal axes may point either way: a check would add up what cancels.
    #[test]
    fn the_root_of_a_covariance_is_one() {
        let turn = nalgebra::Rotation3::new(Vector3::new(0.3, -0.9, 0.4));
        let planted = turn.matrix() * Matrix3::from_diagonal(&Vector3::new(0.5, 0.2, 0.0)) * turn.matrix().transpose();
        // Of singular ones to the root of rounding.
        assert!((root(planted * planted) - planted).amax() < 1e-7);
    }

    #[test]
    fn a_tip_that_moves_a_lost_one_and_too_few_are_refused_with_the_numbers() {
        let refused = |heard: Listened| {
            touched("a", &heard, &tool(), MostMotion(0.5), 1.0)
                .unwrap_err()
                .to_string()
        };
        let moved = refused(heard(600, 3.0));
        // Means of thirds of a drift of 3 mm are 2 mm apart; 4 sqrt(0.12 * 6 / 600) = 0.14 mm are noise.
        assert!(
            moved.contains("the tip moved by 2.0") && moved.contains("0.64 mm are allowed"),
            "{moved}"
        );
        let few = refused(heard(8, 0.0));
        assert!(few.contains("only 8 poses in 1 s, at least 9"), "{few}");
        let mut lost = heard(20, 0.0);
        (lost.frames, lost.why) = (60, "tool: 2 emitters".to_owned());
        let lost = refused(lost);
        assert!(
            lost.contains("20 of 60 frames show the marker, at least 30") && lost.contains("2 emitters"),
            "{lost}"
        );
        assert!(touched("a", &heard(600, 0.4), &tool(), MostMotion(0.5), 1.0).is_ok());
    }
}
