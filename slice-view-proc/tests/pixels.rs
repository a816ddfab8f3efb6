//! What an image must be, whatever the code: ramps, moved and mirrored volumes, slabs of layers, means of areas.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod common;

use common::{bound, exact, fast, largest_difference, noise, plane, volume};
use geometry::{Direction, Vector};
use proptest::prelude::*;
use scene::{Filter, Minify, Sampling, Slab, SlabMode};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    /// Every filter that reproduces lines does so, away from the border.
    #[test]
    fn a_ramp_stays_a_ramp(normal in prop::array::uniform3(-1.0..1.0), pixel_mm in 0.01..0.3, which in 0_usize..3) {
        let filter = [Filter::Linear, Filter::Cubic, Filter::BSpline][which];
        let ramp = volume([48, 48, 48], |[x, y, z]| (7 * x - 11 * y + 5 * z) as i16);
        let Some(into) = Vector::new(normal[0], normal[1], normal[2]).direction() else { return Ok(()) };
        let Some(right) = into.cross(Direction::Y).direction() else { return Ok(()) };
        let down = into.cross(right).direction().unwrap();
        let plane = plane([23.5, 24.25, 22.75], [right, down], pixel_mm, [40, 30]);
        let hu = fast(&ramp, &plane, filter.into());
        // Of 1128 HU at most; the mirrored border of the B-spline is 16 voxels away, where 0.268^16 of it is left.
        let allowed = bound(filter.into(), 1128.0) + 1e-6;
        for (i, hu) in hu.iter().enumerate() {
            let [x, y, z] = plane.point((i % 40) as f64, (i / 40) as f64).mm();
            let want = 7.0 * x - 11.0 * y + 5.0 * z;
            prop_assert!((f64::from(*hu) - want).abs() <= f64::from(allowed), "{filter:?}: {hu}, not {want}");
        }
    }
}

/// Positions that f64 holds exactly, so that nothing at all may change.
#[test]
fn moving_volume_and_plane_by_whole_voxels_changes_no_bit() {
    let axes = [
        [Direction::X, Direction::Y],
        [Direction::Y, -Direction::Z],
        [-Direction::Z, Direction::X],
    ];
    let still = volume([40, 36, 32], noise);
    let moved = volume([40, 36, 32], |[x, y, z]| noise([x + 3, y - 2, z + 5]));
    for axes in axes {
        for sampling in common::samplings() {
            // Far enough inside that both images see the same voxels; the B-spline's mirror is felt everywhere.
            if sampling.filter == Filter::BSpline {
                continue;
            }
            let a = plane([20.125, 18.5, 17.375], axes, 0.375, [19, 17]);
            let b = plane([17.125, 20.5, 12.375], axes, 0.375, [19, 17]);
            assert_eq!(fast(&still, &a, sampling), fast(&moved, &b, sampling), "{sampling:?}");
        }
    }
}

#[test]
fn a_mirrored_volume_has_the_mirrored_image() {
    let still = volume([31, 30, 29], noise);
    let mirrored = volume([31, 30, 29], |[x, y, z]| noise([30 - x, y, z]));
    // Half a voxel and ties apart, where nearest may take either.
    let size = [64, 48];
    let a = plane([13.1, 14.3, 12.2], [Direction::X, Direction::Y], 0.7, size);
    let b = plane([16.9, 14.3, 12.2], [Direction::X, Direction::Y], 0.7, size);
    for sampling in common::samplings() {
        let (a, b) = (fast(&still, &a, sampling), fast(&mirrored, &b, sampling));
        let b: Vec<f32> = b.chunks(64).flat_map(|row| row.iter().rev().copied()).collect();
        let off = largest_difference(&a, &b);
        assert!(off <= 2.0 * bound(sampling, 2000.0), "{sampling:?}: {off}");
    }
}

/// A slab of whole voxel layers is their mean, maximum and minimum, written out by hand.
#[test]
fn slabs_are_what_their_layers_make_them() {
    let noisy = volume([20, 20, 20], noise);
    let at = plane([9.0, 9.0, 10.0], [Direction::X, Direction::Y], 1.0, [9, 9]);
    // Three layers of 1 mm about slice 10: at 9, 10 and 11.
    let layers = |x: i64, y: i64| [9, 10, 11].map(|z| f32::from(noise([x, y, z])));
    for (mode, of) in [
        (SlabMode::Mean, (|l| (l[0] + l[1] + l[2]) / 3.0) as fn([f32; 3]) -> f32),
        (SlabMode::Maximum, |l| l[0].max(l[1]).max(l[2])),
        (SlabMode::Minimum, |l| l[0].min(l[1]).min(l[2])),
    ] {
        let slab = Some(Slab {
            mode,
            thickness_mm: 3.0,
        });
        for filter in [Filter::Nearest, Filter::Linear, Filter::Cubic, Filter::Sinc5] {
            let sampling = Sampling { slab, ..filter.into() };
            for hu in [fast(&noisy, &at, sampling), exact(&noisy, &at, sampling)] {
                for (i, hu) in hu.iter().enumerate() {
                    let want = of(layers(5 + i as i64 % 9, 5 + i as i64 / 9));
                    assert!(
                        (hu - want).abs() <= bound(sampling, 2000.0),
                        "{sampling:?}: {hu}, not {want}"
                    );
                }
            }
        }
    }
}

/// A pixel of 4 x 4 voxels is their mean; by its centre alone it would be any of them.
#[test]
fn large_pixels_are_means() {
    let noisy = volume([40, 40, 8], noise);
    let at = plane([17.5, 17.5, 3.0], [Direction::X, Direction::Y], 4.0, [6, 6]);
    let area = Sampling {
        minify: Minify::Area,
        ..Filter::Nearest.into()
    };
    let hu = fast(&noisy, &at, area);
    for (i, hu) in hu.iter().enumerate() {
        // The middle of the image lies between its pixels 2 and 3: pixel 0 has voxels 6 to 9.
        let (x, y) = (6 + 4 * (i as i64 % 6), 6 + 4 * (i as i64 / 6));
        let sum: f32 = (0..16).map(|k| f32::from(noise([x + k % 4, y + k / 4, 3]))).sum();
        assert!(
            (hu - sum / 16.0).abs() <= bound(area, 2000.0),
            "{hu}, not {}",
            sum / 16.0
        );
    }
    let points = fast(&noisy, &at, Filter::Nearest.into());
    assert!(
        largest_difference(&hu, &points) > 100.0,
        "noise has means far from its values"
    );
}

/// What a checkerboard one voxel wide must not do: shimmer as the plane moves.
#[test]
fn fine_patterns_do_not_shimmer() {
    let checks = volume([64, 64, 4], |[x, y, _]| if (x + y) % 2 == 0 { 1000 } else { -1000 });
    let brightest = |minify| {
        let sampling = Sampling {
            minify,
            ..Filter::Linear.into()
        };
        let at = |k: u32| {
            plane(
                [31.0 + f64::from(k) * 0.23, 31.25, 1.0],
                [Direction::X, Direction::Y],
                2.0,
                [16, 16],
            )
        };
        (0..9)
            .flat_map(|k| fast(&checks, &at(k), sampling))
            .fold(0.0, |m: f32, hu| m.max(hu.abs()))
    };
    assert!(brightest(Minify::Area) < 1e-3, "{}", brightest(Minify::Area));
    assert!(brightest(Minify::Point) > 300.0, "{}", brightest(Minify::Point));
}
