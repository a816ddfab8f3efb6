//! Speckle against its statistics (Wagner et al., IEEE Trans. Sonics Ultrason. 30(3), 1983).

use ultrasound::{Pose, Scanner, Scene, Settings, Shape};

use super::{linear, straight};

/// One look, no noise, a range in which nothing is cut off, and tissue without layers.
fn plain() -> Settings {
    Settings {
        compound: false,
        range_db: 110.0,
        gain_db: 80.0,
        noise_db: -200.0,
        ..Settings::shallow()
    }
}

fn uniform(_: [f64; 3]) -> f64 {
    205.0
}

/// Amplitudes of a part of the image around the foci.
fn amplitudes(scanner: &mut Scanner, settings: &Settings, pose: &Pose) -> Vec<f64> {
    let shape: Shape = *scanner.shape();
    let grey = scanner.scan(&Scene::of(&uniform), pose, 1).unwrap();
    let rows = 150..260;
    let level = |grey: u8| 10.0_f64.powf((f64::from(grey) / 255.0 * settings.range_db - settings.gain_db) / 20.0);
    rows.flat_map(|row| (20..380).map(move |column| (row, column)))
        .map(|(row, column)| level(grey[row * shape.columns() + column]))
        .collect()
}

fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}

#[test]
fn amplitudes_are_those_of_rayleigh() {
    let settings = plain();
    let mut scanner = Scanner::new(&linear(), &settings).unwrap();
    assert!(scanner.scatterers_per_cell() > 9.9);
    // Six planes 10 mm apart: 36 x 11 mm each, 1000 cells of 0.45 x 0.8 mm; 6000 in all.
    let values: Vec<f64> = (0..6)
        .flat_map(|i| {
            let pose = Pose::new([0.0, 0.0, 10.0 * f64::from(i)], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
            amplitudes(&mut scanner, &settings, &pose)
        })
        .collect();
    let (mean, deviation) = moments(&values);
    // sqrt(pi / (4 - pi)) = 1.913. The ratio's relative error over N independent values is about 0.8 / sqrt N: 0.02 for
    // 6000; four of them, and as much again for 10 scatterers a cell and grey of 0.4 dB.
    assert!((mean / deviation - 1.913).abs() < 0.16, "{}", mean / deviation);
    // The level is what the tissue is said to have, -22 dB by its power: 5 % of 6000 cells' power and of the edges.
    let power = 10.0 * (mean * mean + deviation * deviation).log10();
    assert!((power + 22.0).abs() < 0.5, "{power} dB");
}

#[test]
fn speckle_leaves_with_the_motion_across_the_image() {
    let settings = plain();
    let mut scanner = Scanner::new(&linear(), &settings).unwrap();
    let mut at = |aside: f64| {
        let pose = Pose::new([0.0, 0.0, aside], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
        let power = amplitudes(&mut scanner, &settings, &pose);
        power.into_iter().map(|value| value * value).collect::<Vec<f64>>()
    };
    let first = at(0.0);
    assert_eq!(first, at(0.0), "the probe came back");
    let width = settings.elevation.width_at(20.5);
    let deviation = width / 2.355;
    for part in [0.25, 0.5, 1.0, 3.0] {
        let other = at(part * width);
        let ((a, sa), (b, sb)) = (moments(&first), moments(&other));
        let product = first.iter().zip(&other).map(|(x, y)| (x - a) * (y - b)).sum::<f64>() / first.len() as f64;
        let found = product / (sa * sb);
        // The field's correlation is that of two Gaussians s apart, exp(-s^2 / 4 sigma^2); that of its power the square.
        let closed = (-(part * width / deviation).powi(2) / 2.0).exp();
        // 1000 cells, of exponential power: four times 1 / sqrt 1000.
        assert!((found - closed).abs() < 0.13, "{part} widths: {found} for {closed}");
    }
}

#[test]
fn speckle_goes_with_the_tissue() {
    let settings = plain();
    let mut scanner = Scanner::new(&linear(), &settings).unwrap();
    let mut grey = |x: f64| {
        let pose = Pose::new([x, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
        scanner.scan(&Scene::of(&uniform), &pose, 1).unwrap()
    };
    let (here, moved) = (grey(0.0), grey(4.0));
    // 4 mm are 40 columns: the same tissue, seen by other beams, which do not lie quite the same.
    let pairs: Vec<(f64, f64)> = (150..260)
        .flat_map(|row| (60..340).map(move |column| row * 401 + column))
        .map(|at| (f64::from(here[at + 40]), f64::from(moved[at])))
        .collect();
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    let ((ma, sa), (mb, sb)) = (moments(&a), moments(&b));
    let correlation = pairs.iter().map(|(x, y)| (x - ma) * (y - mb)).sum::<f64>() / pairs.len() as f64 / (sa * sb);
    assert!(correlation > 0.8, "{correlation}");
}

#[test]
fn the_same_seed_and_number_give_the_same_bits() {
    let body = |[x, y, z]: [f64; 3]| 50.0 + 10.0 * (x / 3.0).sin() - 100.0 * (y / 9.0 + z).cos();
    let image = |seed: u64, number: u64| {
        let settings = Settings {
            seed,
            noise_db: -20.0,
            ..Settings::shallow()
        };
        let mut scanner = Scanner::new(&linear(), &settings).unwrap();
        // What was made before leaves nothing behind.
        scanner.scan(&Scene::of(&uniform), &straight(), 99).unwrap();
        scanner.scan(&Scene::of(&body), &straight(), number).unwrap()
    };
    let first = image(3, 5);
    assert!(first == image(3, 5));
    assert!(first != image(3, 6), "the noise is the number's");
    assert!(first != image(4, 5), "the tissue is the seed's");
}
