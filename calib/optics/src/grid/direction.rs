//! The thesis's two sketches of a grid's directions, as it gives them: what [`find`](super::find()) is compared with.
//!
//! Both take an image for a parallel projection, so that perspective bends what they look for; neither says which disc
//! is which.

use nalgebra::Vector2;

/// Samples of the signature over half a turn: half a degree each.
pub const ANGLES: usize = 360;
/// The Gaussian that the signature is smoothed with, samples; the thesis gives none.
const SMOOTHING_SAMPLES: f64 = 3.0;
/// "Approximately a right angle" with the first direction: up to so many samples from it.
const ABOUT_RIGHT: usize = 60;
/// The most points that are paired, the first ones: time goes with their square.
const MAX_POINTS: usize = 1000;
/// The periods that are tried for each angle.
const PERIODS: usize = 96;
/// Of periods that group the points nearly as well as the best the longest counts: its fractions group them too.
const NEARLY_BEST_SHARE: f64 = 0.93;

/// A candidate for a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Pixels.
    pub at: Vector2<f64>,
    /// The criterion there.
    pub chi: f64,
}

/// Lines of candidates: `direction . across = offset + k period`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines {
    /// The direction of the lines from the x axis towards y, radians, in `0..pi`.
    pub angle: f64,
    /// Their distance, pixels.
    pub period: f64,
    /// The first one's distance from the origin, pixels, in `0..period`.
    pub offset: f64,
    /// `|mean of exp(2 pi i t / period)|` over the projections `t`: 1 where all lie on the lines.
    pub share: f64,
}

/// The signature (5.5): for every pair of candidates a peak of height `chi_i chi_j / distance` at the angle of the line
/// through them, smoothed by a Gaussian of 1.5 degrees, greatest value 1. Sample `k` is the angle `k pi / ANGLES`.
///
/// All zero for fewer than two different points.
pub fn signature(candidates: &[Candidate]) -> Vec<f64> {
    // The first alone, and not a sample: the same image gives the same signature.
    let candidates = &candidates[..candidates.len().min(MAX_POINTS)];
    let mut peaks = vec![0.0; ANGLES];
    for (i, a) in candidates.iter().enumerate() {
        for b in &candidates[i + 1..] {
            let d = b.at - a.at;
            let (angle, length) = (d.y.atan2(d.x), d.norm());
            // A line has no sense: the angle counts modulo half a turn.
            let place = (angle / std::f64::consts::PI * ANGLES as f64).round() as i64;
            if length > 0.0 {
                peaks[place.rem_euclid(ANGLES as i64) as usize] += a.chi * b.chi / length;
            }
        }
    }
    let smooth = smoothed(&peaks);
    let greatest = smooth.iter().copied().fold(0.0, f64::max);
    let scale = if greatest > 0.0 { 1.0 / greatest } else { 0.0 };
    smooth.iter().map(|v| v * scale).collect()
}

/// Convolved with the Gaussian, around the circle.
fn smoothed(values: &[f64]) -> Vec<f64> {
    // At four deviations a weight is 3e-4 of the middle's. The sum is not normalised, as the greatest value is made 1
    // afterwards.
    let (n, reach) = (values.len(), (4.0 * SMOOTHING_SAMPLES) as usize);
    let weight = |k: usize| (-0.5 * (k as f64 / SMOOTHING_SAMPLES).powi(2)).exp();
    let at = |i: usize| {
        let sides = (1..=reach).map(|k| weight(k) * (values[(i + k) % n] + values[(i + n - k) % n]));
        values[i] + sides.sum::<f64>()
    };
    (0..n).map(at).collect()
}

/// The angles (radians, `0..pi`) of a grid's two directions by its signature: the greatest value, and the greatest local
/// maximum within 30 degrees of a right angle to it. None where there is none.
pub fn principal_angles(signature: &[f64]) -> Option<[f64; 2]> {
    let n = signature.len();
    let first = (0..n).max_by(|i, j| signature[*i].total_cmp(&signature[*j]))?;
    if signature[first] <= 0.0 {
        return None;
    }
    let is_peak = |i: &usize| {
        let (before, after) = (signature[(i + n - 1) % n], signature[(i + 1) % n]);
        signature[*i] > before && signature[*i] >= after
    };
    let about = n / 2 - ABOUT_RIGHT.min(n / 2)..=n / 2 + ABOUT_RIGHT.min(n / 2);
    let second = about
        .map(|k| (first + k) % n)
        .filter(is_peak)
        .max_by(|i, j| signature[*i].total_cmp(&signature[*j]))?;
    Some([first, second].map(|i| i as f64 * std::f64::consts::PI / n as f64))
}

/// The angular correlation (5.2.2): all candidates are projected on a line that turns; the two angles, at least 30
/// degrees apart, at which they gather best in groups at equal distances, with that distance and the first group's place.
///
/// Distances from 0.6 to 1.7 times the median of those to the nearest neighbour are tried. None for fewer than 4 points.
pub fn angular_correlation(candidates: &[Candidate]) -> Option<[Lines; 2]> {
    let points: Vec<Vector2<f64>> = candidates.iter().take(MAX_POINTS / 2).map(|c| c.at).collect();
    let near = nearest(&points)?;
    let all: Vec<Lines> = (0..ANGLES / 2).map(|k| lines(&points, k, near)).collect();
    // Diagonals gather the points as well, on more lines that lie closer: the share counts by the distance.
    let score = |l: &Lines| l.share * l.period;
    let first = *all.iter().max_by(|a, b| score(a).total_cmp(&score(b)))?;
    let apart = |l: &&Lines| {
        let d = (l.angle - first.angle).abs();
        d.min(std::f64::consts::PI - d) >= std::f64::consts::PI / 6.0
    };
    let second = *all.iter().filter(apart).max_by(|a, b| score(a).total_cmp(&score(b)))?;
    Some([first, second])
}

/// The median distance to the nearest neighbour.
fn nearest(points: &[Vector2<f64>]) -> Option<f64> {
    if points.len() < 4 {
        return None;
    }
    let to_nearest = |(i, p): (usize, &Vector2<f64>)| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, q)| (q - p).norm()).fold(f64::MAX, f64::min)
    };
    let mut distances: Vec<f64> = points.iter().enumerate().map(to_nearest).collect();
    distances.sort_by(f64::total_cmp);
    Some(distances[distances.len() / 2]).filter(|d| *d > 0.0)
}

/// The best lines at one angle: degree `k`.
fn lines(points: &[Vector2<f64>], k: usize, near: f64) -> Lines {
    let angle = k as f64 * 2.0 * std::f64::consts::PI / ANGLES as f64;
    let across = Vector2::new(-angle.sin(), angle.cos());
    let projected: Vec<f64> = points.iter().map(|p| across.dot(p)).collect();
    let at = |j: usize| {
        // A geometric ladder of 1.1 % a step: how far a wrong period is off at the farthest points goes with its
        // relative error.
        let period = near * 0.6 * (1.7_f64 / 0.6).powf(j as f64 / (PERIODS - 1) as f64);
        let (mut c, mut s) = (0.0, 0.0);
        for t in &projected {
            let (sine, cosine) = (std::f64::consts::TAU * t / period).sin_cos();
            c += cosine;
            s += sine;
        }
        // The phase of the mean of exp(2 pi i t / period) is that of the lines.
        let offset = s.atan2(c) / std::f64::consts::TAU * period;
        Lines {
            angle,
            period,
            offset: offset.rem_euclid(period),
            share: c.hypot(s) / projected.len() as f64,
        }
    };
    let tried: Vec<Lines> = (0..PERIODS).map(at).collect();
    let best = tried.iter().map(|l| l.share).fold(0.0, f64::max);
    let longest = tried.iter().rev().find(|l| l.share >= NEARLY_BEST_SHARE * best);
    longest.copied().unwrap_or_else(|| at(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 10 x 10 points seen from far: steps at 20 and 105 degrees.
    fn grid() -> Vec<Candidate> {
        let step = |deg: f64, length: f64| Vector2::new(deg.to_radians().cos(), deg.to_radians().sin()) * length;
        let (a, b) = (step(20.0, 25.0), step(105.0, 30.0));
        let at = |i: usize| a * (i % 10) as f64 + b * (i / 10) as f64 + Vector2::new(40.0, 7.0);
        (0..100).map(|i| Candidate { at: at(i), chi: 2.0 }).collect()
    }

    fn apart(a: f64, deg: f64) -> f64 {
        let d = (a.to_degrees() - deg).rem_euclid(180.0);
        d.min(180.0 - d)
    }

    #[test]
    fn both_ways_find_the_directions_of_a_grid_without_perspective() {
        let by_signature = principal_angles(&signature(&grid())).unwrap();
        let by_correlation = angular_correlation(&grid()).unwrap().map(|l| l.angle);
        for mut angles in [by_signature, by_correlation] {
            angles.sort_by(f64::total_cmp);
            // Half a degree is a sample of the signature, a degree a step of the turning line.
            assert!(apart(angles[0], 20.0) <= 1.0, "{angles:?}");
            assert!(apart(angles[1], 105.0) <= 1.0, "{angles:?}");
        }
    }

    #[test]
    fn the_period_and_the_place_of_the_lines_are_found() {
        let found = angular_correlation(&grid()).unwrap();
        for lines in found {
            // Rows at 20 degrees are 30 sin 85 px apart, columns at 105 degrees 25 sin 85; the ladder of periods has
            // steps of 1.1 %.
            let along = apart(lines.angle, 20.0) < 5.0;
            let known = if along { 30.0 } else { 25.0 } * 85.0_f64.to_radians().sin();
            assert!((lines.period / known - 1.0).abs() < 0.03, "{lines:?} {known}");
            let across = Vector2::new(-lines.angle.sin(), lines.angle.cos());
            let middle = across.dot(&grid()[55].at) - lines.offset;
            let off = (middle / lines.period - (middle / lines.period).round()).abs();
            assert!(off < 0.25 && lines.share > 0.7, "{off} {lines:?}");
        }
    }

    #[test]
    fn without_points_there_are_no_directions() {
        assert!(principal_angles(&signature(&[])).is_none());
        assert!(angular_correlation(&grid()[..3]).is_none());
        let same = vec![grid()[0]; 9];
        assert!(principal_angles(&signature(&same)).is_none());
        assert!(angular_correlation(&same).is_none());
    }
}
