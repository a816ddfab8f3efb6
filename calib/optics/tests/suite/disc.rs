//! Discs in drawn images: found, counted, and fitted as well as their noise allows.

use crate::common::Random;
use crate::common::grid_series::{Scene, draw};
use nalgebra::{Matrix2, Vector2};
use optics::disc::{DetectOptions, Ellipse, Polarity, detect, fit_disc};
use optics::image::Image;

const SIDE: usize = 32;

/// Cells of a pixel's side that light is counted in.
const FINE: usize = 4;
/// Pixels drawn around the image, for the blur.
const PAD: usize = 4;
/// The blur's deviation, pixels.
const BLUR: f64 = 0.8;

/// The share of each fine cell that lies in an ellipse upright in the image: chords of 16 rows a cell, exact along x.
fn cells(centre: Vector2<f64>, semi: [f64; 2]) -> Vec<f64> {
    const ROWS: usize = 16;
    let (n, h) = ((SIDE + 2 * PAD) * FINE, 1.0 / FINE as f64);
    let start = -(PAD as f64) - 0.5;
    let mut out = vec![0.0; n * n];
    for i in 0..n * ROWS {
        let v = (start + (i as f64 + 0.5) * h / ROWS as f64 - centre.y) / semi[1];
        if v.abs() >= 1.0 {
            continue;
        }
        let half = semi[0] * (1.0 - v * v).sqrt();
        for j in 0..n {
            let left = start + j as f64 * h;
            let overlap = (left + h).min(centre.x + half) - left.max(centre.x - half);
            out[i / ROWS * n + j] += overlap.max(0.0) / h / ROWS as f64;
        }
    }
    out
}

/// What pixels see of fine cells through a Gaussian: weights at cell distances, a pixel's own cells counted alike.
fn seen(cells: &[f64]) -> Vec<f64> {
    let n = (SIDE + 2 * PAD) * FINE;
    let gauss = |d: f64| (-0.5 * (d / BLUR).powi(2)).exp() / (BLUR * std::f64::consts::TAU.sqrt()) / FINE as f64;
    let weight = |k: usize| {
        let cell = (k as f64 + 0.5) / FINE as f64 - 0.5 - PAD as f64;
        let own = (0..FINE).map(|i| gauss(cell - (i as f64 + 0.5) / FINE as f64 + 0.5));
        own.sum::<f64>() / FINE as f64
    };
    let weights: Vec<f64> = (0..(2 * PAD + 1) * FINE).map(weight).collect();
    let sum = |from: usize, step: usize, data: &[f64]| -> f64 {
        weights.iter().enumerate().map(|(k, w)| w * data[from + k * step]).sum()
    };
    let along: Vec<f64> = (0..n * SIDE)
        .map(|i| sum(i / SIDE * n + i % SIDE * FINE, 1, cells))
        .collect();
    (0..SIDE * SIDE)
        .map(|i| sum(i / SIDE * FINE * SIDE + i % SIDE, SIDE, &along))
        .collect()
}

/// A disc of contrast 150 on 170, without the fitted model: by areas, a Gaussian of 0.8 px, square pixels, noise.
fn drawn(ellipse: &Ellipse, noise: f64, random: &mut Random) -> Image {
    let semi = [ellipse.shape[(0, 0)].sqrt(), ellipse.shape[(1, 1)].sqrt()];
    let grey = seen(&cells(ellipse.centre, semi))
        .into_iter()
        .map(|share| 170.0 - 150.0 * share);
    // 16 bits: noise below a step of 8 bits is seen too.
    let fine = |grey: f64| {
        ((grey + noise * random.normal() + 40.0) * 200.0)
            .clamp(0.0, 65535.0)
            .round() as u16
    };
    Image::new(SIDE, SIDE, grey.map(fine).collect()).unwrap()
}

#[test]
fn centres_are_as_good_as_the_noise_allows_and_their_covariance_says_so() {
    let shapes = [[9.0, 9.0], [36.0, 36.0], [36.0, 4.0]];
    for [xx, yy] in shapes {
        for noise in [1.0, 3.0, 10.0] {
            let mut random = Random::new(7);
            let (mut squares, mut predicted) = (0.0, 0.0);
            const TRIALS: usize = 200;
            for _ in 0..TRIALS {
                let centre = Vector2::new(15.5 + random.signed(), 15.5 + random.signed());
                let truth = Ellipse {
                    centre,
                    shape: Matrix2::new(xx, 0.0, 0.0, yy),
                };
                let start = Ellipse {
                    centre: centre + Vector2::new(0.4, -0.3),
                    shape: truth.shape * 1.15,
                };
                let fit = fit_disc(&drawn(&truth, noise, &mut random), &start, 0.9, 5.0).unwrap();
                squares += (fit.ellipse.centre - centre).norm_squared();
                predicted += fit.covariance.trace();
            }
            let ratio = (squares / predicted).sqrt();
            println!(
                "shape {xx} {yy}, noise {noise}: {:.4} px, {ratio:.3} of the bound",
                (squares / 400.0).sqrt()
            );
            // The bound is Fisher's, of all ten unknowns. 400 coordinates: a ratio's deviation is 1/sqrt(800) = 0.035.
            assert!((ratio - 1.0).abs() < 0.11, "{ratio}");
        }
    }
}

#[test]
fn all_discs_of_a_frontal_grid_are_found_dark_and_bright() {
    for noise in [2.0, 10.0, 25.0] {
        let scene = draw(&Scene {
            tilt_deg: 0.0,
            roll_deg: 17.0,
            noise,
            seed: 1,
            ..Scene::default()
        });
        let negative: Vec<u16> = scene.image.samples().iter().map(|s| 255 - s).collect();
        let negative = Image::new(512, 512, negative).unwrap();
        for (image, polarity) in [(&scene.image, Polarity::Dark), (&negative, Polarity::Bright)] {
            let discs = detect(
                image,
                &DetectOptions {
                    polarity,
                    ..DetectOptions::new(3.0, 9.0)
                },
            )
            .unwrap();
            let near = |c: &Vector2<f64>| {
                let off = |d: &&optics::disc::Disc| (Vector2::new(d.at[0] as f64, d.at[1] as f64) - c).norm() < 2.0;
                discs.iter().find(off)
            };
            let seen: Vec<_> = scene.centres.iter().filter_map(near).collect();
            println!(
                "noise {noise} {polarity:?}: {} of 100, {} false",
                seen.len(),
                discs.len() - seen.len()
            );
            assert!(seen.len() >= 99, "noise {noise} {polarity:?}: {}", seen.len());
            let radius = seen.iter().map(|d| d.radius).sum::<f64>() / seen.len() as f64;
            // 5.9 px by the camera's geometry, within 2 % of distance.
            assert!((radius - 5.95).abs() < 0.5, "{radius}");
        }
    }
}

/// Three discs of 140 steps and one of 10: as a share of the median, 1 and 0.07.
#[test]
fn a_faint_speck_beside_dots_is_left_out_where_that_is_asked() {
    let places = [[20, 20], [20, 60], [60, 20], [60, 60]];
    let grey = |i: usize| {
        let near = |p: &&[usize; 2]| (i % 80).abs_diff(p[0]).pow(2) + (i / 80).abs_diff(p[1]).pow(2) <= 25;
        match places.iter().find(near) {
            Some([60, 60]) => 190,
            Some(_) => 60,
            None => 200,
        }
    };
    let image = Image::new(80, 80, (0..80 * 80).map(grey).collect()).unwrap();
    // Without noise the deviation of 5.4 is that of the discs themselves.
    let seen = |share: f64| {
        let options = DetectOptions {
            share,
            deviations: 0.0,
            ..DetectOptions::new(4.0, 7.0)
        };
        let discs = detect(&image, &options).unwrap();
        places.map(|p| {
            discs
                .iter()
                .any(|d| d.at[0].abs_diff(p[0]) + d.at[1].abs_diff(p[1]) <= 2)
        })
    };
    assert_eq!(seen(0.0), [true; 4]);
    assert_eq!(seen(0.05), [true; 4]);
    assert_eq!(seen(0.25), [true, true, true, false]);
}

#[test]
fn what_holds_no_disc_is_refused_by_name_or_empty() {
    let constant = Image::from_bytes(40, 40, &[77; 1600]).unwrap();
    assert!(detect(&constant, &DetectOptions::new(2.0, 6.0)).unwrap().is_empty());
    let tiny = Image::from_bytes(2, 1, &[1, 2]).unwrap();
    let refused = detect(&tiny, &DetectOptions::new(2.0, 6.0)).unwrap_err().to_string();
    assert!(refused.contains("2 x 1 pixels"), "{refused}");
    for (least, greatest) in [(0.0, 5.0), (5.0, 3.0), (f64::NAN, 4.0), (2.0, 1e9)] {
        let refused = detect(&constant, &DetectOptions::new(least, greatest))
            .unwrap_err()
            .to_string();
        assert!(refused.contains("radii from"), "{refused}");
    }
    let fit = fit_disc(&constant, &Ellipse::circle(Vector2::new(20.0, 20.0), 5.0), 1.0, 4.0);
    assert!(fit.is_err(), "{fit:?}");
}
