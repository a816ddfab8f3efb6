//! How many pairings as good as one that was found are to be expected of touches that have nothing to do with the beads.
//!
//! An a-contrario bound, as for point matches by Moisan and Stival (2004): beads are taken for drawn from a normal density of their own
//! spread `L`. Of a given pairing of n pairs the residuals, `3 n - 6` numbers beside the six of a motion, lie within a ball of radius `r` with
//! probability
//!
//! ```text
//! P = V(3 n - 6, r) 8 pi^2 sqrt(det I) (2 pi)^(-3 (n - 1) / 2) det(L)^(-(n - 1) / 2) E[exp(-1/2 sum y^T R^T L^-1 R y)]
//! ```
//!
//! with the touches `y` about their centre, their tensor of inertia `I` and the mean `E` over all rotations `R`; there are `C(N, n) M! / (M - n)!`
//! such pairings of N touches and M beads.

use std::f64::consts::{PI, TAU};

use geometry::{Frame, Point};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Rotations that the mean is taken over.
const ROTATIONS: u32 = 2048;
/// Beads in a plane are taken for this share of their spread thick: thinner, the rotations between two samples would count.
const LEAST_THICKNESS: f64 = 0.2;

/// Of `touches` touched points, those at `paired` were paired with as many of `beads`, with residuals that may have been `radius_mm`
/// together: how many such pairings are to be expected by chance.
pub(super) fn expected<To: Frame, From: Frame>(
    paired: &[Point<From>],
    touches: usize,
    beads: &[Point<To>],
    radius_mm: f64,
) -> f64 {
    let n = paired.len();
    // About their centres: a motion's shift is integrated over all places.
    let (arms, beads_mm) = (centred(paired), centred(beads));
    let spread = scatter(&beads_mm) / beads.len() as f64;
    let floor = LEAST_THICKNESS * LEAST_THICKNESS * spread.trace() / 3.0 + radius_mm * radius_mm / n as f64;
    // Beads are known to the residuals' size at best, and no density is sharper.
    let spread = spread + Matrix3::identity() * floor;
    let Some(inverse) = spread.try_inverse() else {
        return f64::INFINITY;
    };
    // How far residuals move with a turn: the volume that a turn sweeps.
    let own = scatter(&arms);
    let inertia = Matrix3::identity() * own.trace() - own;
    // why: in logarithms, as sixty factors of some 1e-6 are no number.
    let free = 3 * n - 6;
    let parts = [
        ln_ball(free, radius_mm),
        (8.0 * PI * PI).ln() + 0.5 * inertia.determinant().max(f64::MIN_POSITIVE).ln(),
        -0.5 * (n as f64 - 1.0) * (3.0 * TAU.ln() + spread.determinant().ln()),
        ln_mean(&arms, &inverse),
        ln_pairings(touches, beads.len(), n),
    ];
    parts.iter().sum::<f64>().exp()
}

/// Places about their mean, mm.
fn centred<F>(points: &[Point<F>]) -> Vec<Vector3<f64>> {
    let all = || points.iter().map(|p| Vector3::from(p.mm()));
    let centre = all().sum::<Vector3<f64>>() / points.len() as f64;
    all().map(|p| p - centre).collect()
}

fn scatter(places: &[Vector3<f64>]) -> Matrix3<f64> {
    places.iter().map(|p| p * p.transpose()).sum()
}

/// The logarithm of the volume of a ball: `pi^(d/2) / gamma(d/2 + 1) r^d`.
fn ln_ball(dimension: usize, radius: f64) -> f64 {
    // V(d) = V(d - 2) 2 pi / d, from V(0) = 1 and V(1) = 2.
    let first = if dimension % 2 == 1 { 2.0_f64.ln() } else { 0.0 };
    let rest = (1..=dimension).rev().step_by(2).filter(|d| *d > 1);
    first + rest.map(|d| (TAU / d as f64).ln()).sum::<f64>() + dimension as f64 * radius.ln()
}

/// The logarithm of the mean of `exp(-1/2 sum y^T R^T L^-1 R y)` over rotations that lie evenly.
fn ln_mean(arms: &[Vector3<f64>], inverse: &Matrix3<f64>) -> f64 {
    // The sum over the arms is a trace of their scatter, so that many touches cost no more than three.
    let own = scatter(arms);
    let exponents: Vec<f64> = (0..ROTATIONS)
        .map(|k| {
            let r = rotation(k);
            -0.5 * (r * own * r.transpose() * inverse).trace()
        })
        .collect();
    // The greatest is taken off first: all may be below what a number holds.
    let most = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + (exponents.iter().map(|x| (x - most).exp()).sum::<f64>() / f64::from(ROTATIONS)).ln()
}

/// The k-th of rotations that fill all evenly (Shoemake 1992, by Halton's numbers).
fn rotation(k: u32) -> Matrix3<f64> {
    // From the first on: Halton's zeroth point is the corner of all three.
    let [u, v, w] = [2, 3, 5].map(|base| halton(k + 1, base));
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    let ((s1, c1), (s2, c2)) = ((TAU * v).sin_cos(), (TAU * w).sin_cos());
    let q = UnitQuaternion::new_normalize(Quaternion::new(b * c2, a * s1, a * c1, b * s2));
    q.to_rotation_matrix().into_inner()
}

fn halton(mut k: u32, base: u32) -> f64 {
    let (mut part, mut sum) = (1.0, 0.0);
    while k > 0 {
        part /= f64::from(base);
        sum += part * f64::from(k % base);
        k /= base;
    }
    sum
}

/// The logarithm of `C(N, n) M! / (M - n)!`.
fn ln_pairings(touches: usize, beads: usize, n: usize) -> f64 {
    // Where more are paired than there are, nothing is left to choose from; such sets do not come.
    let falling = |from: usize| (0..n).map(|k| (from.saturating_sub(k).max(1) as f64).ln()).sum::<f64>();
    falling(touches) + falling(beads) - falling(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Ct, Tracker};

    #[test]
    fn balls_and_pairings_are_those_of_the_tables() {
        for (dimension, volume) in [(1, 2.0), (2, PI), (3, 4.0 / 3.0 * PI), (6, PI.powi(3) / 6.0)] {
            assert!(
                (ln_ball(dimension, 1.0).exp() - volume).abs() < 1e-12 * volume,
                "{dimension}"
            );
        }
        assert!((ln_ball(3, 2.0).exp() - 32.0 / 3.0 * PI).abs() < 1e-11);
        // C(10, 4) 10! / 6! = 210 x 5040.
        assert!((ln_pairings(10, 10, 4).exp() - 1_058_400.0).abs() < 1e-5);
        assert!((ln_pairings(3, 3, 3).exp() - 6.0).abs() < 1e-12);
    }

    /// By drawing beads of the density itself, and asking for the ball of residuals itself: three touches are all there are.
    #[test]
    fn the_chance_of_one_pairing_is_that_of_many_draws() {
        let touched: Vec<Point<Tracker>> = [[60.0, -30.0, 10.0], [-70.0, 20.0, 40.0], [10.0, 80.0, -50.0]]
            .map(|[x, y, z]| Point::new(x, y, z))
            .to_vec();
        let radius = 25.0;
        let mut random = 7_u64;
        let mut next = || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| next()).sum::<f64>() - 6.0;
        let deviations = [70.0, 55.0, 60.0];
        let (mut hits, draws) = (0.0_f64, 40_000);
        for _ in 0..draws {
            let beads: Vec<Point<Ct>> = (0..3)
                .map(|_| {
                    Point::new(
                        deviations[0] * normal(),
                        deviations[1] * normal(),
                        deviations[2] * normal(),
                    )
                })
                .collect();
            let pairs = calib::registration::Pairs::new(&beads, &touched).unwrap();
            let fitted = calib::registration::fit(pairs, calib::registration::Method::default());
            let is_hit = fitted.is_ok_and(|fit| fit.fre_rms_mm(pairs) * 3.0_f64.sqrt() <= radius);
            hits += f64::from(u8::from(is_hit));
        }
        // Beads whose spread is that of the density, to the last digit.
        let corners = (0..8).map(|k| {
            let sign = |axis: usize| if k >> axis & 1 == 1 { 1.0 } else { -1.0 };
            Point::<Ct>::new(
                deviations[0] * sign(0),
                deviations[1] * sign(1),
                deviations[2] * sign(2),
            )
        });
        let corners: Vec<_> = corners.collect();
        let one = expected(&touched, 3, &corners, radius) / ln_pairings(3, 8, 3).exp();
        let found = hits / f64::from(draws);
        // Four deviations of so many hits; the floor of the spread and the ball's curvature take up to a fifth.
        let spread = 4.0 / hits.sqrt() + 0.2;
        assert!((one / found - 1.0).abs() < spread, "{one} {found} {hits}");
    }
}
