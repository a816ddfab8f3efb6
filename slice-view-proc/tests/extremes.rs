//! Planes and volumes as odd as they come: nothing panics, and the fast back end agrees with the reference.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod common;

use common::{PADDING_HU, bound, exact, fast, largest_difference, noise, plane, samplings, volume, volume_at};
use geometry::{Ct, Direction, Vector};
use scene::{Filter, Minify, Sampling};

fn oblique() -> [Direction<Ct>; 2] {
    let into = Vector::new(0.6, 0.5, 0.62).direction().unwrap();
    let right = into.cross(Direction::Y).direction().unwrap();
    [right, into.cross(right).direction().unwrap()]
}

/// Nearest at ties may take either voxel, so it is compared on planes that avoid them.
fn agrees(volume: &bus::volume::OwnedVolume, at: &geometry::SlicePlane, sampling: Sampling, what: &str) {
    let off = largest_difference(&fast(volume, at, sampling), &exact(volume, at, sampling));
    assert!(off <= bound(sampling, 2000.0), "{what}, {sampling:?}: {off} HU");
}

#[test]
fn small_and_thin_volumes() {
    for dims in [
        [1, 1, 1],
        [2, 2, 2],
        [1, 7, 9],
        [9, 1, 7],
        [7, 9, 1],
        [2, 1, 1],
        [3, 5, 4],
    ] {
        let noisy = volume(dims, noise);
        let middle = dims.map(|n| f64::from(n) / 2.0 - 0.47);
        for axes in [[Direction::X, Direction::Y], [Direction::Y, -Direction::Z], oblique()] {
            for sampling in samplings() {
                agrees(
                    &noisy,
                    &plane(middle, axes, 0.23, [21, 19]),
                    sampling,
                    &format!("{dims:?}"),
                );
            }
        }
    }
}

#[test]
fn stretched_and_sheared_volumes() {
    let stretched = [[0.5, 0.0, 0.0, -7.0], [0.0, 0.5, 0.0, 3.0], [0.0, 0.0, 5.0, -20.0]];
    let sheared = [[0.9, 0.1, 0.3, -7.0], [0.0, 0.8, 0.35, 3.0], [-0.05, 0.0, 1.3, -4.0]];
    for rows in [stretched, sheared] {
        let noisy = volume_at([24, 22, 9], rows, noise);
        let centre = noisy.grid.centre().mm().map(|c| c + 0.013);
        for axes in [[Direction::X, -Direction::Z], oblique()] {
            for sampling in samplings() {
                agrees(&noisy, &plane(centre, axes, 0.61, [33, 27]), sampling, "an affine grid");
            }
        }
    }
}

#[test]
fn pixels_of_a_nanometre_and_of_a_metre() {
    let noisy = volume([16, 15, 14], noise);
    for sampling in samplings() {
        agrees(
            &noisy,
            &plane([7.3, 7.6, 6.1], oblique(), 1e-6, [40, 30]),
            sampling,
            "pixels of 1e-6 mm",
        );
        let metre = plane([7.3, 7.6, 6.1], oblique(), 1e3, [3, 3]);
        if sampling.minify == Minify::Point {
            agrees(&noisy, &metre, sampling, "pixels of 1e3 mm");
        } else {
            // A pixel that holds the whole volume is its mean, and all around is padding.
            let hu = fast(&noisy, &metre, sampling);
            assert_ne!(hu[4], f32::from(PADDING_HU), "{sampling:?}");
            assert_eq!(hu[0], f32::from(PADDING_HU), "{sampling:?}");
        }
    }
}

#[test]
fn outside_far_away_and_edge_on() {
    let noisy = volume([16, 15, 14], noise);
    let padded = |at: &geometry::SlicePlane| {
        samplings()
            .iter()
            .all(|s| fast(&noisy, at, *s).iter().all(|&hu| hu == f32::from(PADDING_HU)))
    };
    for far in [40.0, 1e6, -1e6, 1e12] {
        assert!(
            padded(&plane([far, 7.0, 7.0], [Direction::Y, Direction::Z], 0.7, [32, 32])),
            "{far}"
        );
        assert!(padded(&plane([far, far, far], oblique(), 0.7, [32, 32])), "{far}");
    }
    // Just beyond the last cell, which ends at 13.5, by half of the slab more; and just inside it.
    let axial = |z: f64| plane([7.0, 7.0, z], [Direction::X, Direction::Y], 0.7, [8, 8]);
    assert!(padded(&axial(15.0 + 1e-9)) && padded(&axial(-2.0 - 1e-9)));
    for z in [13.5, 13.5 - 1e-12, -0.5, -0.5 + 1e-12] {
        for filter in [Filter::Linear, Filter::Cubic, Filter::Sinc3] {
            let hu = fast(&noisy, &axial(z), filter.into());
            assert!(hu.iter().all(|&hu| hu != f32::from(PADDING_HU)), "{z}");
            agrees(&noisy, &axial(z), filter.into(), "the outermost faces");
        }
    }
}

#[test]
fn images_of_one_pixel_and_of_the_largest_size() {
    let noisy = volume([16, 15, 14], noise);
    for sampling in samplings() {
        agrees(
            &noisy,
            &plane([7.3, 7.6, 6.1], oblique(), 0.31, [1, 1]),
            sampling,
            "1 x 1",
        );
        agrees(
            &noisy,
            &plane([7.3, 7.6, 6.1], oblique(), 0.31, [1, 77]),
            sampling,
            "1 x 77",
        );
    }
    let large = plane([7.3, 7.6, 6.1], oblique(), 0.0049, [4096, 4096]);
    agrees(&noisy, &large, Filter::Linear.into(), "4096 x 4096");
}

#[test]
fn the_same_image_again_has_the_same_bits() {
    let noisy = volume([40, 39, 38], noise);
    let at = plane([19.0, 20.0, 18.0], oblique(), 0.4, [130, 70]);
    for sampling in samplings() {
        assert_eq!(fast(&noisy, &at, sampling), fast(&noisy, &at, sampling));
    }
}
