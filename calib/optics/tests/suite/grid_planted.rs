//! Grids with large discs, parts of grids, and what disturbs them: missing and false discs, glare, a lens; beside the truth.

use crate::common::Random;
use crate::common::grid_series::{Drawn, Scene, Sheet, draw};
use optics::grid::{Found, GridRefused, GridSpec, Refinement, find};
use optics::image::Image;

/// Large discs that no turn leaves in their places.
const MARKS: [[usize; 2]; 3] = [[2, 2], [7, 2], [2, 6]];

fn spec(marks: &[[usize; 2]]) -> GridSpec {
    GridSpec {
        marks: marks.to_vec(),
        ..GridSpec::new(10, 10, 20.0)
    }
}

fn marked() -> Sheet {
    Sheet {
        marks: MARKS.to_vec(),
        ..Sheet::default()
    }
}

/// Root mean square distance of every disc to the truth of its own column and row; fails where one is another.
fn error(found: &Found, drawn: &Drawn) -> f64 {
    let mut squares = 0.0;
    for disc in &found.discs {
        let off = (disc.at - drawn.centre(disc.col, disc.row)).norm();
        let [c, r] = [disc.col, disc.row];
        assert!(off < 0.4 * drawn.least_pitch, "column {c} row {r}: {off} px");
        squares += off * off;
    }
    (squares / found.discs.len() as f64).sqrt()
}

/// What the covariances expect of that distance.
fn expected(found: &Found) -> f64 {
    let sum: f64 = found.discs.iter().map(|d| d.covariance.trace()).sum();
    (sum / found.discs.len() as f64).sqrt()
}

#[test]
fn large_discs_decide_the_quarter_turn() {
    for (k, roll_deg) in [10.0, 100.0, 190.0, 280.0].into_iter().enumerate() {
        let drawn = draw(&Scene {
            tilt_deg: 35.0,
            roll_deg,
            noise: 5.0,
            seed: k as u64,
            sheet: marked(),
            ..Scene::default()
        });
        let found = find(&drawn.image, &spec(&MARKS)).unwrap();
        assert_eq!((found.discs.len(), found.alike), (100, 1));
        let error = error(&found, &drawn);
        // Twice the deviation of all centres together: they go with the same eight numbers. And the drawing's slivers.
        assert!(
            error < 3.0 * expected(&found) + 2e-3,
            "{roll_deg}: {error} {}",
            expected(&found)
        );
        let marks: Vec<_> = found.discs.iter().filter(|d| d.mark).map(|d| [d.col, d.row]).collect();
        assert_eq!(marks, MARKS);
        // Without the description all four turns look alike.
        let blind = find(&drawn.image, &spec(&[])).unwrap();
        assert_eq!((blind.discs.len(), blind.alike), (100, 4));
    }
}

/// Two columns, then two rows and a column, lie outside the image.
#[test]
fn a_part_of_a_grid_is_told_by_its_large_discs_and_refused_without_them() {
    for (k, aside) in [[170.0, 0.0], [-150.0, 165.0], [30.0, -180.0]].into_iter().enumerate() {
        let drawn = draw(&Scene {
            tilt_deg: 20.0,
            roll_deg: 90.0 * k as f64,
            noise: 4.0,
            seed: 40 + k as u64,
            sheet: marked(),
            aside,
            ..Scene::default()
        });
        let inside = |c: usize, r: usize| {
            let at = drawn.centre(c, r);
            at.x > 12.0 && at.y > 12.0 && at.x < 499.0 && at.y < 499.0
        };
        let count = (0..100).filter(|i| inside(i % 10, i / 10)).count();
        let found = find(&drawn.image, &spec(&MARKS)).unwrap();
        println!(
            "{aside:?}: {} of {count}, {:.4} px",
            found.discs.len(),
            error(&found, &drawn)
        );
        assert!(
            count < 90 && found.discs.len() >= count,
            "{aside:?}: {} of {count}",
            found.discs.len()
        );
        assert!(error(&found, &drawn) < 3.0 * expected(&found) + 3e-3);
        let blind = find(&drawn.image, &spec(&[])).unwrap_err();
        assert!(matches!(blind, GridRefused::WrongSize { .. }), "{blind}");
    }
}

#[test]
fn a_part_of_a_grid_that_its_large_discs_do_not_tell_is_refused() {
    // The only large disc lies outside the image: usual ones say neither turn nor place.
    let drawn = draw(&Scene {
        tilt_deg: 20.0,
        noise: 4.0,
        seed: 50,
        sheet: Sheet {
            marks: vec![[9, 4]],
            ..Sheet::default()
        },
        aside: [170.0, 0.0],
        ..Scene::default()
    });
    let refused = find(&drawn.image, &spec(&[[9, 4]])).unwrap_err();
    assert!(matches!(refused, GridRefused::Undecided { ways: 2.., .. }), "{refused}");
    // Large discs where the description has none.
    let drawn = draw(&Scene {
        tilt_deg: 20.0,
        noise: 4.0,
        seed: 51,
        sheet: marked(),
        ..Scene::default()
    });
    let refused = find(&drawn.image, &spec(&[[7, 7]])).unwrap_err();
    assert!(matches!(refused, GridRefused::Undecided { ways: 0, .. }), "{refused}");
    let text = refused.to_string();
    assert!(text.contains("100 discs") && text.contains("3 of them large"), "{text}");
    let outside = find(&drawn.image, &spec(&[[3, 10]])).unwrap_err();
    assert!(
        matches!(outside, GridRefused::BadMark { col: 3, row: 10, .. }),
        "{outside}"
    );
}

/// Up to 12 discs missing and 6 false spots at random, over tilt and noise: what is found is right, and most is found.
#[test]
fn missing_and_false_discs_never_shift_a_row() {
    let (mut found_in, images) = (0, 24);
    for seed in 0..images {
        let mut random = Random::new(900 + seed);
        let mut place = |n: f64| (n * random.unit()) as usize;
        let hidden: Vec<[usize; 2]> = (0..place(13.0)).map(|_| [place(10.0), place(10.0)]).collect();
        let hidden: Vec<[usize; 2]> = hidden.into_iter().filter(|c| !MARKS.contains(c)).collect();
        let spots = (0..6)
            .map(|_| [11.0 * random.unit() - 1.0, 11.0 * random.unit() - 1.0, 0.15])
            .collect();
        let drawn = draw(&Scene {
            tilt_deg: 70.0 * random.unit(),
            roll_deg: 180.0 * random.signed(),
            noise: 2.0 + 10.0 * random.unit(),
            seed,
            sheet: Sheet {
                hidden: hidden.clone(),
                spots,
                ..marked()
            },
            ..Scene::default()
        });
        match find(&drawn.image, &spec(&MARKS)) {
            Ok(found) => {
                let error = error(&found, &drawn);
                assert!(error < 0.1, "{seed}: {error}");
                found_in += 1;
            }
            Err(refused) => println!("{seed}: {refused}"),
        }
    }
    assert!(found_in * 10 >= images * 8, "{found_in} of {images}");
}

#[test]
fn discs_drowned_by_light_are_missing_and_move_no_other() {
    let scene = Scene {
        tilt_deg: 40.0,
        roll_deg: 17.0,
        noise: 3.0,
        seed: 60,
        ..Scene::default()
    };
    let drawn = draw(&scene);
    let middle = drawn.centre(4, 4);
    let lit = draw(&Scene {
        glare: Some([middle.x, middle.y, 45.0]),
        ..scene
    });
    let found = find(&lit.image, &spec(&[])).unwrap();
    let drowned = (0..100).filter(|i| (drawn.centres[*i] - middle).norm() < 36.0).count();
    println!("{drowned} drowned, {} missing", found.missing.len());
    assert!(drowned >= 5 && found.missing.len() >= drowned && found.missing.len() <= drowned + 12);
    let turned = |k: usize, [c, r]: [usize; 2]| match k {
        0 => [c, r],
        1 => [9 - r, c],
        2 => [9 - c, 9 - r],
        _ => [r, 9 - c],
    };
    let worst = |k: usize| {
        let off = found.discs.iter().map(|d| {
            let [c, r] = turned(k, [d.col, d.row]);
            (d.at - drawn.centre(c, r)).norm()
        });
        off.fold(0.0, f64::max)
    };
    // A fit that shares the light's edge among 90 discs.
    let error = (0..4).map(worst).fold(f64::MAX, f64::min);
    assert!(error < 0.15, "{error}");
}

/// A lens that moves corners of the grid by up to 8 px. What it does is no polynomial, but the inverse of one.
#[test]
fn a_lens_that_bends_the_grid_leaves_every_disc_its_place() {
    for (k, bend) in [-0.06, 0.06, 0.1].into_iter().enumerate() {
        for tilt_deg in [0.0, 40.0] {
            let drawn = draw(&Scene {
                tilt_deg,
                roll_deg: 10.0,
                noise: 3.0,
                seed: 70 + k as u64,
                sheet: marked(),
                bend,
                ..Scene::default()
            });
            let found = find(&drawn.image, &spec(&MARKS)).unwrap();
            let error = error(&found, &drawn);
            println!(
                "bend {bend} tilt {tilt_deg}: {:?} {error:.4} px {:.4}",
                found.refinement,
                expected(&found)
            );
            assert_eq!(found.discs.len(), 100);
            assert_ne!(found.refinement, Refinement::Whole);
            // Twice the deviation of all centres together: they go with the same numbers. And the drawing's slivers.
            assert!(
                error < 2.0 * expected(&found) + 2e-3,
                "{bend} {tilt_deg}: {error} {}",
                expected(&found)
            );
        }
    }
}

/// The one-by-one fit lost discs whose candidate was half as large as the disc: it needs a blur of three pixels and starts at
/// one.
#[test]
fn blurred_discs_of_a_bent_grid_are_all_fitted() {
    let drawn = draw(&Scene {
        tilt_deg: 25.0,
        roll_deg: 5.0,
        noise: 1.0,
        seed: 80,
        sheet: marked(),
        bend: 0.1,
        ..Scene::default()
    });
    let blurred = optics::image::smoothed(&drawn.image, 2.8);
    let mut random = Random::new(4);
    let bytes = blurred
        .samples
        .iter()
        .map(|v| (f64::from(*v) + 4.0 * random.normal()).clamp(0.0, 255.0) as u8);
    let image = Image::from_bytes(512, 512, &bytes.collect::<Vec<u8>>()).unwrap();
    let each = GridSpec {
        one_by_one: true,
        ..spec(&MARKS)
    };
    let found = find(&image, &each).unwrap();
    assert_eq!(
        (found.refinement, found.discs.len()),
        (Refinement::Each, 100),
        "{:?}",
        found.missing
    );
    assert!(error(&found, &drawn) < 1.5 * expected(&found) + 0.01);
}
