//! Grids behind a lens, on bent sheets and in uneven light: whether centres are as near to the truth as is stated; and grids
//! that their surroundings hid.

#![allow(clippy::expect_used, reason = "a step that fails here is a test that fails")]

use crate::common::Random;
use crate::common::lens_scene::{Glass, LensScene, PITCH, Seen};
use optics::grid::{Found, GridSpec, Refinement, find};

/// Sums of squares over the discs: of distances to the truth, in the turn that fits best, and of those stated.
fn squares(found: &Found, seen: &Seen) -> [f64; 2] {
    let turned = |k: usize, [c, r]: [usize; 2]| match k {
        0 => [c, r],
        1 => [9 - r, c],
        2 => [9 - c, 9 - r],
        _ => [r, 9 - c],
    };
    let of = |k: usize| {
        let off = found.discs.iter().map(|d| {
            let [c, r] = turned(k, [d.col, d.row]);
            (d.at - seen.centres[10 * r + c]).norm_squared()
        });
        off.sum::<f64>()
    };
    let stated = found.discs.iter().map(|d| d.covariance.trace()).sum();
    [(0..4).map(of).fold(f64::MAX, f64::min), stated]
}

fn spec() -> GridSpec {
    GridSpec::new(10, 10, PITCH)
}

fn radial(k1: f64) -> Glass {
    Glass {
        radial: [k1, 0.0, 0.0],
        ..Glass::default()
    }
}

/// Some images of a scene from all sides, with their ratios of error to error stated; the ratio of all together.
fn ratio(scene: &LensScene, images: u64, most: f64) -> (f64, Vec<Refinement>) {
    let (mut sums, mut models) = ([0.0; 2], Vec::new());
    for seed in 1..=images {
        let scene = LensScene {
            roll_deg: 180.0 * Random::new(seed + 31).signed(),
            seed,
            ..scene.clone()
        };
        let seen = scene.draw();
        let found = find(&seen.image, &spec()).unwrap_or_else(|e| panic!("{scene:?}: {e}"));
        let [error, stated] = squares(&found, &seen);
        assert!(
            error < most * most * stated,
            "{} of {}: {scene:?}",
            error.sqrt(),
            stated.sqrt()
        );
        sums[0] += error;
        sums[1] += stated;
        models.push(found.refinement);
    }
    ((sums[0] / sums[1]).sqrt(), models)
}

/// A lens that moved discs by up to 1.9 px off the nearest plane was put on a plane, to 0.019 px as was said.
#[test]
fn a_lens_is_not_hidden_by_a_fit_of_a_plane() {
    for k1 in [-0.1, -0.01, 0.003, 0.1] {
        let scene = LensScene {
            tilt_deg: 30.0,
            glass: radial(k1),
            ..LensScene::default()
        };
        let (ratio, models) = ratio(&scene, 3, 2.0);
        assert!(models.iter().all(|m| *m == Refinement::Lens), "{k1}: {models:?}");
        assert!(ratio < 1.5, "{k1}: {ratio}");
    }
}

/// Over lens, blur and tilt: in no image more than three times what is stated, in all together about that.
#[test]
fn errors_are_those_stated_whatever_the_lens() {
    let mut ratios = Vec::new();
    for k1 in [-0.4, -0.2, 0.001, 0.2, 0.4] {
        for (blur, tilt_deg) in [(0.5, 0.0), (1.2, 40.0), (2.5, 20.0), (0.8, 65.0)] {
            let scene = LensScene {
                tilt_deg,
                blur,
                noise: 3.0,
                glass: radial(k1),
                ..LensScene::default()
            };
            ratios.push(ratio(&scene, 2, 3.0).0);
        }
    }
    let mean = (ratios.iter().map(|r| r * r).sum::<f64>() / ratios.len() as f64).sqrt();
    println!("{mean:.3}, {ratios:.2?}");
    assert!((0.7..1.5).contains(&mean), "{mean}: {ratios:?}");
}

/// The lens's middle and the homography move discs alike, in another mixture at each state of a fit; covariances were those of the state before
/// the last, and up to sixteen times too large.
#[test]
fn errors_of_a_weak_lens_at_a_grazing_angle_are_not_stated_too_large() {
    for k1 in [-0.1, 0.1] {
        let scene = LensScene {
            tilt_deg: 65.0,
            blur: 0.5,
            noise: 3.0,
            glass: radial(k1),
            ..LensScene::default()
        };
        let (ratio, _) = ratio(&scene, 6, 2.0);
        // Some 17 numbers over 6 images: a deviation of 0.07, of 1.
        assert!((0.75..1.3).contains(&ratio), "{k1}: {ratio}");
    }
}

/// Paper 1.2 steps beyond the outer discs, on a darker table: where rows are hardly farther apart than the blur is wide, its end
/// looked like a shift of the last row, and errors were 1.6 times those stated at 65 degrees, four times at 80.
#[test]
fn the_end_of_the_paper_moves_no_disc_that_is_blurred() {
    for (tilt_deg, blur) in [(65.0, 2.5), (80.0, 1.2), (80.0, 2.5)] {
        let scene = LensScene {
            tilt_deg,
            blur,
            noise: 1.5,
            ..LensScene::default()
        };
        let (ratio, _) = ratio(&scene, 8, 3.0);
        // Eight numbers over eight images: a deviation of 0.09, of 1.
        assert!((0.5..1.4).contains(&ratio), "{tilt_deg}: {ratio}");
    }
}

#[test]
fn without_a_lens_a_plane_is_taken() {
    for tilt_deg in [0.0, 40.0, 60.0] {
        let scene = LensScene {
            tilt_deg,
            ..LensScene::default()
        };
        let (ratio, models) = ratio(&scene, 4, 3.0);
        assert!(models.iter().all(|m| *m == Refinement::Whole), "{tilt_deg}: {models:?}");
        assert!(ratio < 1.5, "{tilt_deg}: {ratio}");
    }
}

/// Lenses whose middle is far from the image's, tangential ones, fisheyes, bent sheets, light and blur that change over the image.
#[test]
fn what_is_no_plain_lens_is_not_stated_too_small() {
    let base = LensScene {
        tilt_deg: 30.0,
        ..LensScene::default()
    };
    let glass = |glass: Glass| LensScene { glass, ..base.clone() };
    let bow = |bow_mm| LensScene { bow_mm, ..base.clone() };
    let scenes = [
        glass(Glass {
            aside: [0.25, -0.1],
            ..radial(-0.2)
        }),
        glass(Glass {
            tangential: [0.02, -0.01],
            ..radial(-0.2)
        }),
        glass(Glass {
            fisheye: true,
            ..Glass::default()
        }),
        bow([1.0, 0.0, 0.0]),
        bow([4.0, 0.0, 1.0]),
        LensScene {
            vignette: 0.5,
            ..base.clone()
        },
        LensScene {
            vignette: 0.5,
            ..glass(radial(-0.2))
        },
        LensScene {
            blur_slope: 0.6,
            blur: 1.2,
            ..glass(radial(-0.2))
        },
        LensScene {
            within: [20.0, 20.0, 240.0, 240.0],
            ..glass(radial(-0.3))
        },
    ];
    for scene in scenes {
        ratio(&scene, 2, 3.0);
    }
}

/// The end of the paper was taken for one more line of discs, as the table is darker than they are, and the grid refused as too
/// large.
#[test]
fn grey_discs_on_grey_paper_on_a_dark_table_are_found() {
    for (greys, rim, tilt_deg, blur) in [
        ([120.0, 160.0, 30.0], 0.6, 0.0, 2.0),
        ([120.0, 160.0, 30.0], 0.6, 40.0, 0.8),
        ([120.0, 160.0, 30.0], 0.6, 60.0, 0.8),
        ([120.0, 140.0, 20.0], 0.6, 40.0, 0.8),
        ([120.0, 160.0, 230.0], 1.2, 40.0, 0.8),
        ([120.0, 160.0, 230.0], 1.2, 0.0, 2.0),
    ] {
        for seed in 1..3 {
            let scene = LensScene {
                greys,
                rim,
                tilt_deg,
                blur,
                roll_deg: 17.0 * seed as f64,
                seed,
                ..LensScene::default()
            };
            let seen = scene.draw();
            let found = find(&seen.image, &spec()).unwrap_or_else(|e| panic!("{scene:?}: {e}"));
            let [error, stated] = squares(&found, &seen);
            assert_eq!(found.discs.len(), 100);
            assert!(error < 9.0 * stated, "{} {}: {scene:?}", error.sqrt(), stated.sqrt());
        }
    }
}

#[test]
fn a_plate_of_16_by_14_is_found_up_to_the_border_whatever_the_lens() {
    for (k, k1) in [0.0, -0.3, 0.3].into_iter().enumerate() {
        for (margin, tilt_deg) in [(7.0, 0.0), (10.0, 40.0)] {
            let seen = LensScene {
                cols: 16,
                rows: 14,
                tilt_deg,
                roll_deg: 7.0 * k as f64,
                within: [margin, margin, 511.0 - margin, 511.0 - margin],
                glass: radial(k1),
                ..LensScene::default()
            }
            .draw();
            let found = find(&seen.image, &GridSpec::new(16, 14, PITCH)).unwrap();
            assert_eq!((found.discs.len(), found.missing.len()), (224, 0), "{k1} {margin}");
        }
    }
}
