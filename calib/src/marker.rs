//! Which shape is best for a marker of `n` emitters? The question chapter 4 of the thesis ends on.
//!
//! A marker is scored by the target registration error it predicts at the tool's tip, over the subsets of emitters that
//! a localizer sees. With emitters of equal isotropic error FLE, `TRE^2 = FLE^2 / n (1 + 1/3 sum d_k^2 / f_k^2)`: `d_k`
//! is the tip's distance from the k-th principal axis of the emitters seen, `f_k` their root mean square distance from
//! it.
//!
//! For a tip at distance `d` from the centre and emitters within `r` of it, the shapes give
//! `TRE^2 = FLE^2 / n (1 + c d^2 / r^2)`:
//!
//! | shape, all emitters seen | c |
//! |---|---|
//! | ends of a rod that points at the tip, width `w r` across it | 2/3 up to terms in `w^2`; no roll to speak of |
//! | sphere, or octahedron, cube, tetrahedron | 1 |
//! | ring, tip in its plane | 1 |
//! | ring, tip on its axis | 4/3 |
//!
//! Whoever must be seen from everywhere pays for it: emitters even on a sphere of 30 mm, each seen within 60 degrees of
//! its normal, with 0.1 mm of noise per axis and the tip at 300 mm, over 500 directions of view:
//!
//! | n | fewest seen | views without a pose | median, mm | worst, mm |
//! |---|---|---|---|---|
//! | 8 | 1 | 81 % | 1.47 | 1.79 |
//! | 12 | 2 | 21 % | 1.80 | 3.17 |
//! | 16 | 3 | none | 1.53 | 2.74 |
//! | 20 | 3 | none | 1.27 | 2.34 |
//! | 24 | 4 | none | 1.14 | 2.19 |
//!
//! The answer for n = 3 to 24: size counts first (`1 / r`), then the centre's distance from the tip (`d`), then the
//! number (`1 / sqrt(n)`), and the shape last, by a factor of at most `sqrt(2)`. So
//!
//! - one side faces the localizer, n = 3 to 7: spread the emitters as far as the drape allows, most of them along the
//!   shaft, the centre as near to the tip as may be, with enough width that no three of them line up. Three give a pose
//!   without a check; four survive the loss of one: the least to build.
//! - seen from half the directions, n = 8 to 15: two such plates back to back; a ball of so few loses the pose from
//!   some views.
//! - seen from everywhere: a ball of 16 or more, at about twice the error of all emitters at once; 24 keep four in
//!   view.
//!
//! [`score`] decides between drawings.

use geometry::{Direction, Point};

use crate::registration::{Noise, predicted_tre_mm};

/// Root mean square error at the tip over the subsets given, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// The median over the subsets that give a pose.
    pub median_mm: f64,
    /// The worst over the subsets that give a pose.
    pub worst_mm: f64,
    /// Subsets without a pose: fewer than three emitters, or emitters on a line.
    pub lost: usize,
    /// All subsets scored.
    pub subsets: usize,
}

/// Scores a marker: `emitters` and `tip` in the marker's frame (or any one frame), `noise` of one emitter as localized.
///
/// A subset lists the indices of the emitters seen; indices that do not exist are passed over. `None` where no subset
/// gives a pose.
pub fn score<F>(emitters: &[Point<F>], subsets: &[Vec<usize>], tip: Point<F>, noise: Noise) -> Option<Score> {
    let error = |subset: &Vec<usize>| {
        let seen: Vec<Point<F>> = subset.iter().filter_map(|&i| emitters.get(i).copied()).collect();
        predicted_tre_mm(&seen, tip, noise)
    };
    // Subsets without a pose have an infinite error; they are counted apart, as one would be the worst and hide all
    // others.
    let mut errors: Vec<f64> = subsets.iter().map(error).filter(|e| e.is_finite()).collect();
    errors.sort_by(f64::total_cmp);
    Some(Score {
        median_mm: *errors.get(errors.len() / 2)?,
        worst_mm: *errors.last()?,
        lost: subsets.len() - errors.len(),
        subsets: subsets.len(),
    })
}

/// The emitters seen from each of `views`: those whose normal is within `half_angle_rad` of the direction to the
/// localizer.
pub fn visible_subsets<F>(normals: &[Direction<F>], views: &[Direction<F>], half_angle_rad: f64) -> Vec<Vec<usize>> {
    let least = half_angle_rad.cos();
    let seen = |view: &Direction<F>| -> Vec<usize> {
        (0..normals.len()).filter(|&i| normals[i].dot(*view) >= least).collect()
    };
    views.iter().map(seen).collect()
}

/// `count` directions spread evenly over the sphere: the golden spiral. Deterministic.
pub fn even_directions<F>(count: usize) -> Vec<Direction<F>> {
    // The golden angle, (3 - sqrt 5) pi: of all turns its multiples come back to one another the least.
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |i: usize| {
        // The middles of `count` bands of equal height, which have equal areas (Archimedes); the poles themselves are
        // left out.
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let r = (1.0 - z * z).sqrt();
        let (sin, cos) = (golden * i as f64).sin_cos();
        geometry::Vector::new(r * cos, r * sin, z).direction()
    };
    (0..count).filter_map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Marker;

    const TIP: Point<Marker> = Point::new(0.0, 0.0, 300.0);
    const FLE: Noise = Noise { sigma_mm: 0.1 };

    fn coefficient(emitters: &[Point<Marker>], tip: Point<Marker>, r: f64) -> f64 {
        let n = emitters.len() as f64;
        let tre = predicted_tre_mm(emitters, tip, FLE);
        let d = tip.distance(Point::new(0.0, 0.0, 0.0));
        (n * (tre / FLE.fle_rms_mm()).powi(2) - 1.0) * (r / d).powi(2)
    }

    #[test]
    fn shapes_give_the_documented_coefficients() {
        let ring = |n: usize| -> Vec<Point<Marker>> {
            let angle = |i: usize| i as f64 / n as f64 * std::f64::consts::TAU;
            (0..n)
                .map(|i| Point::new(50.0 * angle(i).cos(), 50.0 * angle(i).sin(), 0.0))
                .collect()
        };
        for n in 3..=24 {
            // The sums are exact in theory for every regular polygon; some tens of roundings.
            assert!((coefficient(&ring(n), TIP, 50.0) - 4.0 / 3.0).abs() < 1e-12, "{n}");
            assert!(
                (coefficient(&ring(n), Point::new(300.0, 0.0, 0.0), 50.0) - 1.0).abs() < 1e-12,
                "{n}"
            );
        }
        let octahedron = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
            .map(|[x, y, z]| Point::new(f64::from(x) * 30.0, f64::from(y) * 30.0, f64::from(z) * 30.0));
        assert!((coefficient(&octahedron, TIP, 30.0) - 1.0).abs() < 1e-12);
        let rod = [
            [0.1, 0.0, 50.0],
            [-0.1, 0.0, 50.0],
            [0.0, 0.1, -50.0],
            [0.0, -0.1, -50.0],
        ]
        .map(|[x, y, z]| Point::new(x, y, z));
        assert!((coefficient(&rod, TIP, 50.0) - 2.0 / 3.0).abs() < 1e-5);
    }

    #[test]
    fn a_ball_of_24_is_seen_from_everywhere_at_twice_the_error() {
        let normals = even_directions::<Marker>(24);
        let emitters: Vec<_> = normals.iter().map(|d| Point::new(0.0, 0.0, 0.0) + *d * 30.0).collect();
        let views = visible_subsets(&normals, &even_directions(500), 60.0_f64.to_radians());
        let ball = score(&emitters, &views, TIP, FLE).unwrap();
        let whole = score(&emitters, &[(0..24).collect()], TIP, FLE).unwrap();
        assert_eq!((ball.lost, ball.subsets), (0, 500));
        assert!(
            ball.median_mm > 2.0 * whole.median_mm && ball.worst_mm < 3.0,
            "{ball:?} {whole:?}"
        );
    }

    #[test]
    fn balls_score_as_documented() {
        for (n, least, lost, median, worst) in [
            (8, 1, 404, 1.47, 1.79),
            (12, 2, 105, 1.80, 3.17),
            (16, 3, 0, 1.53, 2.74),
            (20, 3, 0, 1.27, 2.34),
            (24, 4, 0, 1.14, 2.19),
        ] {
            let normals = even_directions::<Marker>(n);
            let emitters: Vec<_> = normals.iter().map(|d| Point::new(0.0, 0.0, 0.0) + *d * 30.0).collect();
            let views = visible_subsets(&normals, &even_directions(500), 60.0_f64.to_radians());
            let found = score(&emitters, &views, TIP, FLE).unwrap();
            assert_eq!(
                (views.iter().map(Vec::len).min(), found.lost),
                (Some(least), lost),
                "{n}"
            );
            // Two decimals are documented.
            assert!(
                (found.median_mm - median).abs() < 0.006 && (found.worst_mm - worst).abs() < 0.006,
                "{n} {found:?}"
            );
        }
    }

    #[test]
    fn lines_and_pairs_are_lost() {
        let line: Vec<Point<Marker>> = (0..5)
            .map(|i| Point::new(f64::from(i) * 0.1, 7.0, f64::from(i) * 0.3))
            .collect();
        assert_eq!(score(&line, &[vec![0, 1, 2, 3, 4], vec![0, 1]], TIP, FLE), None);
        assert_eq!(score(&line, &[], TIP, FLE), None);
    }
}
