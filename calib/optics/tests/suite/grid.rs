//! Grids found in drawn images, beside the truth.

use crate::common::Random;
use crate::common::grid_series::{Drawn, SIDE, Scene, draw};
use nalgebra::Vector2;
use optics::grid::{Found, GridRefused, GridSpec, find};
use optics::image::Image;

fn scene(tilt_deg: f64, noise: f64, seed: u64) -> Drawn {
    draw(&Scene {
        tilt_deg,
        roll_deg: 17.0,
        noise,
        seed,
        ..Scene::default()
    })
}

/// Root mean square distance to the truth; panics where a disc is not the one it says.
fn error(found: &Found, drawn: &Drawn) -> f64 {
    let mut squares = 0.0;
    for disc in &found.discs {
        let off = (disc.at - drawn.centres[disc.row * 10 + disc.col]).norm();
        assert!(
            off < 0.4 * drawn.least_pitch,
            "column {} row {}: {off} px",
            disc.col,
            disc.row
        );
        squares += off * off;
    }
    (squares / found.discs.len() as f64).sqrt()
}

fn spec() -> GridSpec {
    GridSpec::new(10, 10, 20.0)
}

#[test]
fn the_series_is_found_at_noise_2_and_10() {
    for noise in [2.0, 10.0] {
        for tilt in [0.0, 15.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0, 75.0, 80.0] {
            let drawn = scene(tilt, noise, 1);
            let found = find(&drawn.image, &spec()).unwrap_or_else(|e| panic!("tilt {tilt} noise {noise}: {e}"));
            let error = error(&found, &drawn);
            println!(
                "tilt {tilt} noise {noise}: {} discs, {error:.4} px, radius {:.3}",
                found.discs.len(),
                found.radius
            );
            assert!(
                found.discs.len() >= 97,
                "tilt {tilt} noise {noise}: {}",
                found.discs.len()
            );
            // Sixteen parameters from thousands of pixels: a few thousandths at noise 2.
            assert!(error < 0.02 + 0.004 * noise, "tilt {tilt} noise {noise}: {error}");
        }
    }
}

#[test]
fn more_than_half_of_the_series_is_found_at_noise_25() {
    let tilts = [0.0, 15.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0, 75.0, 80.0, 84.0];
    let mut count = 0;
    for tilt in tilts {
        let drawn = scene(tilt, 25.0, 2);
        match find(&drawn.image, &spec()) {
            Ok(found) => {
                println!("tilt {tilt}: {:.4} px", error(&found, &drawn));
                count += 1;
            }
            Err(refused) => println!("tilt {tilt}: {refused}"),
        }
    }
    assert!(count > 6, "{count} of 11");
}

#[test]
fn images_without_a_grid_are_refused_by_name() {
    let mut random = Random::new(3);
    let noise: Vec<u8> = (0..SIDE * SIDE)
        .map(|_| (128.0 + 25.0 * random.normal()) as u8)
        .collect();
    let noise = Image::from_bytes(SIDE, SIDE, &noise).unwrap();
    let constant = Image::from_bytes(64, 64, &[9; 64 * 64]).unwrap();
    for image in [noise, constant] {
        let refused = find(&image, &spec()).unwrap_err().to_string();
        assert!(refused.contains("no grid found"), "{refused}");
    }
    for pixels in [1, 2] {
        let image = Image::from_bytes(pixels, 1, &vec![3; pixels]).unwrap();
        assert!(matches!(find(&image, &spec()), Err(GridRefused::TooSmall { .. })));
    }
    let image = Image::from_bytes(64, 64, &[9; 64 * 64]).unwrap();
    assert!(matches!(
        find(&image, &GridSpec::new(0, 10, 20.0)),
        Err(GridRefused::BadSize { cols: 0, .. })
    ));
    let pitch = find(&image, &GridSpec::new(10, 10, f64::NAN)).unwrap_err();
    assert!(matches!(pitch, GridRefused::BadPitch { .. }));
}

#[test]
fn a_grid_of_another_size_is_refused_with_what_was_seen() {
    let drawn = scene(30.0, 2.0, 4);
    for (cols, rows) in [(9, 10), (10, 9), (11, 10), (12, 12), (8, 8)] {
        let refused = find(&drawn.image, &GridSpec::new(cols, rows, 20.0)).unwrap_err();
        let GridRefused::WrongSize {
            seen_cols, seen_rows, ..
        } = refused
        else {
            panic!("{refused}");
        };
        assert_eq!([seen_cols, seen_rows], [10, 10], "{cols} x {rows}");
    }
}

#[test]
fn missing_and_false_discs_are_told() {
    let drawn = scene(45.0, 5.0, 5);
    let mut bytes: Vec<u8> = drawn.image.samples().iter().map(|s| *s as u8).collect();
    let mut paint = |at: Vector2<f64>, radius: f64, grey: u8| {
        for (i, b) in bytes.iter_mut().enumerate() {
            let d = Vector2::new((i % SIDE) as f64, (i / SIDE) as f64) - at;
            if d.norm() < radius {
                *b = grey;
            }
        }
    };
    // Glare over two discs, and two dark spots between others.
    paint(drawn.centres[34], 9.0, 175);
    paint(drawn.centres[71], 9.0, 175);
    paint((drawn.centres[22] + drawn.centres[33]) * 0.5, 4.0, 40);
    paint((drawn.centres[60] + drawn.centres[51]) * 0.5, 4.0, 40);
    let image = Image::from_bytes(SIDE, SIDE, &bytes).unwrap();
    let found = find(&image, &spec()).unwrap();
    assert!(
        found.missing.contains(&[4, 3]) && found.missing.contains(&[1, 7]),
        "{:?}",
        found.missing
    );
    assert!(found.missing.len() <= 4, "{:?}", found.missing);
    let error = error(&found, &drawn);
    assert!(error < 0.05, "{error}");
}

/// Where smaller discs left pixels out of the sum of squares, this image's fit stayed at a wrong radius.
#[test]
fn a_fit_does_not_shrink_discs_to_leave_residuals_out() {
    let drawn = scene(40.0, 2.0, 1);
    let found = find(&drawn.image, &spec()).unwrap();
    // Drawn with 3.8 mm of 20 mm; 1e-3 of the pitch is 0.03 px.
    assert!((found.radius - 0.19).abs() < 1e-3, "{}", found.radius);
}

/// Five columns of six discs of 20 px, 100 px apart, the last row's centres at `last`; edges a pixel wide.
fn large_discs(last: f64) -> Image {
    let mut grey = vec![200_u8; 512 * 512];
    for (i, value) in grey.iter_mut().enumerate() {
        let (x, y) = ((i % 512) as f64 - 47.3, (i / 512) as f64 - last);
        let near = |v: f64, first: f64, end: f64| v - 100.0 * (v / 100.0).round().clamp(first, end);
        let off = near(x, 0.0, 4.0).hypot(near(y, -5.0, 0.0));
        *value -= (160.0 * (20.5 - off).clamp(0.0, 1.0)).round() as u8;
    }
    Image::from_bytes(512, 512, &grey).unwrap()
}

#[test]
fn discs_that_the_border_cuts_do_not_bend_the_grid() {
    // 9, 14 and 27 of 40 px of the last row are seen; its centres are in the image in the last case alone.
    for (last, found) in [(522.0, 25), (517.4, 25), (504.6, 30)] {
        for one_by_one in [false, true] {
            let spec = GridSpec {
                one_by_one,
                ..GridSpec::new(5, 6, 5.0)
            };
            let grid = find(&large_discs(last), &spec).unwrap();
            assert_eq!(grid.discs.len(), found, "{last} {one_by_one}");
            assert_eq!(grid.missing.len(), 30 - found);
            for disc in &grid.discs {
                let truth =
                    nalgebra::Vector2::new(47.3 + 100.0 * disc.col as f64, last - 500.0 + 100.0 * disc.row as f64);
                // Rounding to whole steps of 160 over an edge of 125 pixels: thousandths; the drawn edge is no Gaussian.
                assert!(
                    (disc.at - truth).norm() < 0.02,
                    "{last} {one_by_one}: {} {truth}",
                    disc.at
                );
            }
        }
    }
}
