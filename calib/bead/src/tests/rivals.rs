//! What is no bead, and beads in bad company.

use super::specimen::{Image, Random, Scanner};
use crate::{Found, Reason, Refused, Search, find};

const METAL_HU: f64 = 12_000.0;
const MIDDLE: [f64; 3] = [12.0, 12.0, 12.0];

fn scanner() -> Scanner {
    Scanner {
        clip_hu: 3071.0,
        noise_hu: 20.0,
        ..Scanner::of([0.6, 0.6, 0.8])
    }
}

fn image() -> Image {
    scanner().empty([41, 41, 31], 40.0)
}

fn found(image: &Image) -> Found {
    find(&image.volume(&mut Random(3), None), &Search::of_radius(1.0)).unwrap()
}

/// A cylinder along z with round ends: a wire or a screw's shaft.
fn rod(image: &mut Image, [x, y, z]: [f64; 3], radius: f64, half_mm: f64, hu: f64) {
    image.add(
        [x, y, z],
        radius,
        hu,
        |dx, dy| {
            if dx.hypot(dy) < radius { half_mm } else { 0.0 }
        },
    );
}

#[test]
fn wires_screws_clips_plates_and_large_balls_are_no_beads() {
    for (what, radius, half_mm) in [
        ("a wire of 1 mm", 0.5, 9.0),
        ("a wire of 2 mm", 1.0, 9.0),
        ("a screw of 4 mm", 2.0, 8.0),
        ("a pin that ends in the volume", 1.0, 30.0),
        ("a clip of 6 mm", 0.7, 3.0),
    ] {
        let mut image = image();
        let z = if half_mm > 20.0 { 40.0 } else { 12.0 };
        rod(&mut image, [12.0, 12.0, z], radius, half_mm, METAL_HU);
        let found = found(&image);
        assert!(found.beads.is_empty(), "{what}: {:?}", found.beads);
        assert!(!found.rejected.is_empty(), "{what} is told of");
    }
    for radius in [2.0, 3.0] {
        let mut image = image();
        image.bead(MIDDLE, radius, METAL_HU);
        assert!(found(&image).beads.is_empty(), "a ball of {radius} mm");
    }
}

#[test]
fn calcifications_and_bone_are_no_metal() {
    let mut image = image();
    image.bead(MIDDLE, 1.0, 2400.0);
    let calcification = found(&image);
    assert!(calcification.beads.is_empty(), "{:?}", calcification.beads);
    let mut image = self::image();
    image.bead(MIDDLE, 2.0, 1800.0);
    image.bead([6.0, 6.0, 12.0], 4.0, 1500.0);
    assert!(found(&image).beads.is_empty());
}

#[test]
fn beads_on_bone_and_on_the_skin_are_found_where_they_are() {
    let mut image = image();
    // Bone of 1400 HU fills one side up to the bead's surface; air lies beyond the other bead.
    let [nx, ny, _] = image.dims;
    for (i, value) in image.values.iter_mut().enumerate() {
        let (x, y) = ((i % nx) as f64 * 0.6, (i / nx % ny) as f64 * 0.6);
        *value = if y > 20.0 { -1000.0 } else { 40.0 } + 1360.0 * super::specimen::phi((5.0 - x) / 0.45);
    }
    let truth = [[6.1, 10.0, 12.3], [15.2, 20.2, 11.7]];
    truth.iter().for_each(|c| image.bead(*c, 1.0, METAL_HU));
    let found = found(&image);
    assert_eq!(found.beads.len(), 2, "{:?}", found.rejected);
    for truth in truth {
        let distance = |bead: &crate::Bead| {
            let squares = bead.centre.mm().into_iter().zip(truth).map(|(a, b)| (a - b).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let error = found.beads.iter().map(distance).fold(f64::INFINITY, f64::min);
        // An edge of bone or air within the window draws the centre by less than a fifth of a voxel.
        assert!(error < 0.12, "{error}");
    }
}

/// A large body of soft tissue once had more spots than a search takes.
#[test]
fn grains_of_noise_in_soft_tissue_are_no_spots() {
    let found = found(&image());
    // 52 111 voxels have some 2000 local maxima.
    assert!(found.spots < 20, "{}", found.spots);
}

#[test]
fn uniform_and_noisy_volumes_have_no_beads_and_no_trouble() {
    for level in [-1000.0, 0.0, 3071.0] {
        let scanner = Scanner {
            noise_hu: 0.0,
            ..scanner()
        };
        let found = find(
            &scanner.empty([20, 20, 20], level).volume(&mut Random(1), None),
            &Search::of_radius(1.0),
        );
        assert!(found.unwrap().beads.is_empty());
    }
    let noisy = Scanner {
        noise_hu: 900.0,
        ..scanner()
    };
    let found = find(
        &noisy.empty([40, 40, 40], 500.0).volume(&mut Random(1), None),
        &Search::of_radius(1.0),
    )
    .unwrap();
    assert!(found.beads.is_empty(), "{:?}", found.beads);
    for dims in [[1, 1, 1], [2, 1, 1], [1, 9, 9]] {
        assert!(found_in(dims).beads.is_empty());
    }
}

fn found_in(dims: [u32; 3]) -> Found {
    find(
        &scanner().empty(dims, 3000.0).volume(&mut Random(1), None),
        &Search::of_radius(1.0),
    )
    .unwrap()
}

#[test]
fn searches_that_cannot_be_are_refused_by_name() {
    let volume = image().volume(&mut Random(1), None);
    let refused = |search: Search| find(&volume, &search).unwrap_err();
    let good = Search::of_radius(1.0);
    for radius_mm in [[0.0, 1.0], [2.0, 1.0], [1.0, 11.0], [f64::NAN, 1.0]] {
        assert!(matches!(refused(Search { radius_mm, ..good }), Refused::Radius(_)));
    }
    for metal_hu in [f64::NAN, -5.0, 999.0, f64::INFINITY] {
        assert!(matches!(refused(Search { metal_hu, ..good }), Refused::Metal(_)));
    }
    let small = refused(Search::of_radius(0.2));
    assert!(matches!(small, Refused::TooCoarse { .. }), "{small}");
    assert!(small.to_string().contains("bone is brighter"), "{small}");
    let fine = Scanner::of([0.05, 0.05, 0.05])
        .empty([3, 3, 3], 0.0)
        .volume(&mut Random(1), None);
    assert!(matches!(
        find(&fine, &Search::of_radius(1.0)),
        Err(Refused::TooFine { .. })
    ));
}

#[test]
fn two_beads_that_touch_are_told_of_and_not_taken() {
    let mut image = image();
    image.bead(MIDDLE, 1.0, METAL_HU);
    image.bead([12.0, 12.0, 14.4], 1.0, METAL_HU);
    let found = found(&image);
    assert!(found.beads.is_empty(), "{:?}", found.beads);
    assert!(
        matches!(found.rejected[0].reason, Reason::NotAlone { .. }),
        "{:?}",
        found.rejected
    );
    let mut apart = self::image();
    apart.bead(MIDDLE, 1.0, METAL_HU);
    apart.bead([12.0, 12.0, 17.5], 1.0, METAL_HU);
    assert_eq!(self::found(&apart).beads.len(), 2);
}
