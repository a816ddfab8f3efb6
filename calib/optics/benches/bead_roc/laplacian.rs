//! The scale-normalised Laplacian of a Gaussian of a small image (Lindeberg 1998).

use optics::image::Image;

/// The greatest `-sigma^2 (g_xx + g_yy)` within `near` pixels of the middle, over these scales.
pub(crate) fn score(image: &Image, scales: &[f64], near: f64) -> f64 {
    let (width, height) = (image.width(), image.height());
    let middle = [width, height].map(|n| (n as f64 - 1.0) / 2.0);
    let mut most = 0.0_f64;
    for sigma in scales {
        let [smooth, curve] = kernels(*sigma);
        let rows = |kernel: &[f64]| along(image, kernel);
        let (gx, cx) = (rows(&smooth), rows(&curve));
        for y in 0..height {
            for x in 0..width {
                if (x as f64 - middle[0]).hypot(y as f64 - middle[1]) <= near {
                    let sum = down(&cx, width, [x, y], &smooth) + down(&gx, width, [x, y], &curve);
                    most = most.max(-sigma * sigma * sum);
                }
            }
        }
    }
    most
}

/// A Gaussian and its second derivative; the second sums to nothing, so that even ground answers nothing.
fn kernels(sigma: f64) -> [Vec<f64>; 2] {
    let reach = (4.0 * sigma).ceil() as i32;
    let at = |i: i32| (-0.5 * (f64::from(i) / sigma).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(at).sum();
    let smooth: Vec<f64> = (-reach..=reach).map(|i| at(i) / sum).collect();
    let second = |i: i32| (f64::from(i * i) / (sigma * sigma) - 1.0) / (sigma * sigma) * at(i) / sum;
    let mut curve: Vec<f64> = (-reach..=reach).map(second).collect();
    let mean = curve.iter().sum::<f64>() / curve.len() as f64;
    curve.iter_mut().for_each(|c| *c -= mean);
    [smooth, curve]
}

fn clamped(i: usize, offset: usize, half: usize, n: usize) -> usize {
    (i + offset).saturating_sub(half).min(n - 1)
}

/// The image's rows through a kernel; the outermost pixels are repeated.
fn along(image: &Image, kernel: &[f64]) -> Vec<f64> {
    let (width, half) = (image.width(), kernel.len() / 2);
    let value = |i: usize| {
        let (x, y) = (i % width, i / width);
        let tap = |(k, w): (usize, &f64)| w * f64::from(image.samples()[y * width + clamped(x, k, half, width)]);
        kernel.iter().enumerate().map(tap).sum()
    };
    (0..image.samples().len()).map(value).collect()
}

/// A column through a kernel at one pixel.
fn down(values: &[f64], width: usize, [x, y]: [usize; 2], kernel: &[f64]) -> f64 {
    let (height, half) = (values.len() / width, kernel.len() / 2);
    let tap = |(k, w): (usize, &f64)| w * values[clamped(y, k, half, height) * width + x];
    kernel.iter().enumerate().map(tap).sum()
}
