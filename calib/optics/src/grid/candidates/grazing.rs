//! Smoothing for grids that are seen at a grazing angle: along their discs, not across.
//!
//! At 84 degrees a disc's image is eight times as long as it is high, and the next row begins two pixels further. A round
//! smoothing that leaves rows apart leaves the noise, too; an elongated one does not.

use nalgebra::{Matrix2, Vector2};

use crate::image::{Image, Plane, smoothed};

/// Across the discs, pixels; along them.
const ACROSS_PX: f64 = 0.4;
const ALONG_PX: f64 = 2.0;
/// Half the length of the smoothing along, pixels.
const REACH_PX: i32 = 6;
/// Where the mean squares of slopes along and across have a greater ratio, no discs are seen at a grazing angle.
const MAX_SLOPE_RATIO: f64 = 0.3;
/// The smoothing in which slopes are taken, and how many deviations of their noise count.
pub(crate) const SLOPES: f64 = 0.8;
const SLOPE_DEVIATIONS: f64 = 4.0;

/// The image smoothed along a direction, and what that leaves of noise of deviation `noise`.
pub(crate) fn along_discs(image: &Image, direction: Vector2<f64>, noise: f64) -> (Plane, f64) {
    let weights: Vec<f32> = weights(direction);
    let squares: f32 = weights.iter().map(|w| w * w).sum();
    // Of the kernel across, three weights count: 1 beside twice exp(-1 / 2 ACROSS_PX^2).
    let side = (-0.5 / (ACROSS_PX * ACROSS_PX)).exp();
    let kept = (1.0 + 2.0 * side * side) / (1.0 + 2.0 * side).powi(2);
    let plane = along(&smoothed(image, ACROSS_PX), direction, &weights);
    // Of the round kernel the part along is lost in the longer one.
    (plane, noise * (kept * f64::from(squares)).sqrt())
}

/// The unit vector along which clear slopes of an image smoothed by [`SLOPES`] are least, as they are across the discs of
/// a grid that is seen at a grazing angle; none where no direction stands out.
pub(crate) fn direction(plane: &Plane, noise: f64) -> Option<Vector2<f64>> {
    let (w, h) = (plane.width, plane.height);
    // Central differences of smoothed white noise: its derivative's deviation is that of the noise over
    // sqrt(8 pi) sigma^2.
    // A whole grey level at least: an image without noise has its rounding.
    let least = (SLOPE_DEVIATIONS * noise / ((8.0 * std::f64::consts::PI).sqrt() * SLOPES * SLOPES)).max(1.0);
    let mut sum = Matrix2::zeros();
    // Every second row tells as much of a direction as all do.
    for y in (1..h.saturating_sub(1)).step_by(2) {
        for x in 1..w.saturating_sub(1) {
            let at = |i: usize| f64::from(plane.samples[i]);
            let i = y * w + x;
            let slope = Vector2::new(at(i + 1) - at(i - 1), at(i + w) - at(i - w)) * 0.5;
            if slope.norm_squared() > least * least {
                sum += slope * slope.transpose();
            }
        }
    }
    let eigen = sum.symmetric_eigen();
    let low = eigen.eigenvalues.imin();
    // Without a clear slope both are 0, and no direction stands out.
    let grazing = eigen.eigenvalues[low] < MAX_SLOPE_RATIO * eigen.eigenvalues[1 - low];
    grazing.then(|| eigen.eigenvectors.column(low).into_owned())
}

/// Weights of whole steps along the greater part of the direction, from `-REACH_PX` to `REACH_PX`.
fn weights(direction: Vector2<f64>) -> Vec<f32> {
    // A whole pixel along the greater part is so much longer along the direction.
    let step = direction.amax().recip();
    let all: Vec<f64> = (-REACH_PX..=REACH_PX)
        .map(|k| (-0.5 * (f64::from(k) * step / ALONG_PX).powi(2)).exp())
        .collect();
    let total: f64 = all.iter().sum();
    all.iter().map(|w| (w / total) as f32).collect()
}

/// Sums along a direction: whole steps along its greater part, between two pixels across it. The border is repeated.
fn along(plane: &Plane, direction: Vector2<f64>, weights: &[f32]) -> Plane {
    let (w, h) = (plane.width, plane.height);
    // Along the greater part every step is a whole pixel, so that only one weight lies between two.
    let flat = direction.x.abs() >= direction.y.abs();
    let rise = if flat {
        direction.y / direction.x
    } else {
        direction.x / direction.y
    };
    let mut samples = vec![0.0_f32; plane.samples.len()];
    for (weight, k) in weights.iter().zip(-REACH_PX..=REACH_PX) {
        let off = f64::from(k) * rise;
        let (low, share) = (off.floor() as i32, (off - off.floor()) as f32);
        for (across, part) in [(low, 1.0 - share), (low + 1, share)] {
            let [dx, dy] = if flat { [k, across] } else { [across, k] };
            let weight = weight * part;
            for (y, to) in samples.chunks_exact_mut(w).enumerate() {
                let row = (y as i64 + i64::from(dy)).clamp(0, h as i64 - 1) as usize;
                let from = &plane.samples[row * w..(row + 1) * w];
                add_shifted(to, from, dx, weight);
            }
        }
    }
    Plane {
        width: w,
        height: h,
        samples,
    }
}

/// Adds a row that is shifted by whole pixels, its ends repeated.
fn add_shifted(to: &mut [f32], from: &[f32], by: i32, weight: f32) {
    let (n, shift) = (to.len(), by.unsigned_abs() as usize);
    let shift = shift.min(n);
    let (ends, inner) = if by >= 0 {
        to.split_at_mut(n - shift)
    } else {
        to.split_at_mut(shift)
    };
    let (whole, rim, end) = if by >= 0 {
        (ends, inner, from.last())
    } else {
        (inner, ends, from.first())
    };
    let source = if by >= 0 { &from[shift..] } else { &from[..n - shift] };
    whole.iter_mut().zip(source).for_each(|(to, v)| *to += weight * v);
    let end = end.copied().unwrap_or(0.0);
    rim.iter_mut().for_each(|to| *to += weight * end);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(image: &Image, noise: f64) -> Option<Vector2<f64>> {
        direction(&smoothed(image, SLOPES), noise)
    }

    /// Stripes at an angle: their direction is found, they stay, and noise of 10 falls to what is said.
    #[test]
    fn stripes_stay_and_noise_goes() {
        let (n, turn) = (160, 0.3_f64);
        let (s, c) = turn.sin_cos();
        let stripe = |i: usize| {
            let (x, y) = ((i % n) as f64, (i / n) as f64);
            128.0 + 80.0 * (std::f64::consts::TAU * (y * c - x * s) / 6.0).sin()
        };
        let exact: Vec<u16> = (0..n * n).map(|i| stripe(i).round() as u16).collect();
        let image = Image::new(n, n, exact).unwrap();
        let found = told(&image, 1.0).unwrap();
        // Differences over two pixels make a wave of k radians a pixel lower by sin(k) / k.
        let lower = |k: f64| (k * std::f64::consts::TAU / 6.0).sin() / k;
        assert!(
            (found.y / found.x - s * lower(s) / (c * lower(c))).abs() < 0.01,
            "{found}"
        );
        let mut state = 9_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let mut noise = || ((0..12).map(|_| unit()).sum::<f64>() - 6.0) * 10.0;
        let rough: Vec<u16> = (0..n * n).map(|i| (stripe(i) + noise()).round() as u16).collect();
        let rough = Image::new(n, n, rough).unwrap();
        let (rough, left) = along_discs(&rough, told(&rough, 10.0).unwrap(), 10.0);
        let (smooth, _) = along_discs(&image, told(&image, 10.0).unwrap(), 10.0);
        let off: Vec<f64> = rough
            .samples
            .iter()
            .zip(&smooth.samples)
            .map(|(a, b)| f64::from(a - b))
            .collect();
        let deviation = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
        // Interpolation takes up to a half away; the sample, of some 160^2 / 20 independent values, tells it to 3 %.
        assert!(deviation < 1.1 * left && deviation > 0.5 * left, "{deviation} {left}");
        // Across, a wave of 6 px keeps exp(-2 pi^2 (0.16 + 1/4) / 36) of its height at least.
        let most = smooth.samples.iter().fold(0.0_f32, |m, v| m.max(*v));
        assert!(most > 128.0 + 0.75 * 80.0, "{most}");
    }

    #[test]
    fn what_has_no_direction_is_left_alone() {
        let flat = Image::new(40, 40, vec![90; 1600]).unwrap();
        assert!(told(&flat, 1.0).is_none());
        let one = Image::new(1, 1, vec![7]).unwrap();
        assert!(told(&one, 0.0).is_none());
        let disc = |i: usize| {
            if (i % 40).abs_diff(20).pow(2) + (i / 40).abs_diff(20).pow(2) < 100 {
                20
            } else {
                200
            }
        };
        let disc = Image::new(40, 40, (0..1600).map(disc).collect()).unwrap();
        assert!(told(&disc, 1.0).is_none());
    }
}
