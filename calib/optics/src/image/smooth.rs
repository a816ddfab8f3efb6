//! Gaussian smoothing.

use super::Image;

/// A plane of real samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples, row by row.
    pub samples: Vec<f32>,
}

/// The image convolved with a Gaussian of deviation `sigma` pixels, cut at 3.5 deviations; the border is repeated.
///
/// A deviation of 0 returns the samples as they are. 3e-4 of the weight lies beyond the cut and is shared out.
pub fn smoothed(image: &Image, sigma: f64) -> Plane {
    let (width, height) = (image.width(), image.height());
    let samples: Vec<f32> = image.samples().iter().map(|s| f32::from(*s)).collect();
    let weights = weights(sigma);
    if weights.len() == 1 {
        return Plane { width, height, samples };
    }
    let mut across = vec![0.0; samples.len()];
    for (from, to) in samples.chunks_exact(width).zip(across.chunks_exact_mut(width)) {
        along_row(from, to, &weights);
    }
    let samples = down_columns(&across, width, height, &weights);
    Plane { width, height, samples }
}

/// Half of a symmetric kernel: the middle first.
fn weights(sigma: f64) -> Vec<f32> {
    let reach = (3.5 * sigma.max(0.0)).ceil() as usize;
    let half: Vec<f64> = (0..=reach.min(4096))
        .map(|k| {
            if k == 0 {
                1.0
            } else {
                (-0.5 * (k as f64 / sigma).powi(2)).exp()
            }
        })
        .collect();
    // The middle belongs to both halves and counts once.
    let total = 2.0 * half.iter().sum::<f64>() - 1.0;
    half.iter().map(|w| (w / total) as f32).collect()
}

fn along_row(from: &[f32], to: &mut [f32], weights: &[f32]) {
    let (n, reach) = (from.len(), weights.len() - 1);
    let mut padded = vec![from[0]; n + 2 * reach];
    padded[reach..reach + n].copy_from_slice(from);
    padded[reach + n..].fill(from[n - 1]);
    to.iter_mut()
        .zip(&padded[reach..])
        .for_each(|(to, v)| *to = weights[0] * v);
    for (k, weight) in weights.iter().enumerate().skip(1) {
        let pairs = padded[reach - k..].iter().zip(&padded[reach + k..]);
        to.iter_mut()
            .zip(pairs)
            .for_each(|(to, (a, b))| *to += weight * (a + b));
    }
}

fn down_columns(from: &[f32], width: usize, height: usize, weights: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; from.len()];
    let row = |y: usize| &from[y * width..(y + 1) * width];
    for (y, to) in out.chunks_exact_mut(width).enumerate() {
        to.iter_mut().zip(row(y)).for_each(|(to, v)| *to = weights[0] * v);
        for (k, weight) in weights.iter().enumerate().skip(1) {
            let pairs = row(y.saturating_sub(k)).iter().zip(row((y + k).min(height - 1)));
            to.iter_mut()
                .zip(pairs)
                .for_each(|(to, (a, b))| *to += weight * (a + b));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_and_a_ramp_keeps_its_slope() {
        let ramp: Vec<u16> = (0..40 * 30).map(|i| (i % 40 * 10 + i / 40) as u16).collect();
        let image = Image::new(40, 30, ramp).unwrap();
        let out = smoothed(&image, 1.3);
        let at = |x: usize, y: usize| out.samples[y * 40 + x];
        // Symmetric weights of sum 1 reproduce linear functions up to the rounding of f32 at a few hundred.
        assert!((at(20, 15) - 215.0).abs() < 1e-3);
        let flat = smoothed(&Image::new(3, 1, vec![7; 3]).unwrap(), 4.0);
        assert!(flat.samples.iter().all(|v| (v - 7.0).abs() < 1e-5));
    }
}
