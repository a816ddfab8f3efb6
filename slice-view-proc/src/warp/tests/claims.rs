//! Pixels that pieces claim twice: tissue or what lies beyond it.

use super::stage::{Mesh, block, draw, place, plane, region};
use crate::warp::{Pixel, Warp};

/// A map that is the identity up to a height of 10 mm, and turns back above: quadratic in each cube, so that cubes give it exactly.
const SLOWS: f64 = 0.42;

fn turning_back([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, y, z - SLOWS * (z - 10.0).max(0.0).powi(2)]
}

/// The heights at rest of what now lies at this height, and whether it is turned inside out there: a root of the quadratic, by hand.
fn heights(now: f64) -> Vec<(f64, bool)> {
    let below = (now < 10.0).then_some((now, false));
    let root = 1.0 - 4.0 * SLOWS * (now - 10.0);
    let above =
        (root > 0.0).then(|| [-1.0, 1.0].map(|sign| (10.0 + (1.0 + sign * root.sqrt()) / (2.0 * SLOWS), sign > 0.0)));
    let above = above.into_iter().flatten().filter(|(z, _)| *z >= 10.0);
    below.into_iter().chain(above).collect()
}

/// The organ from -14 mm up to a height.
fn up_to(top: f64) -> crate::warp::Region {
    region([0.0; 3], 18.0, 0.5, move |[x, y, z]| {
        x.abs().max(y.abs()).max(-z).max(14.0 + z - top) - 14.0
    })
}

const FRONTAL: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];

/// Above the organ its cubes turn back at 11.2 mm, and pieces of 2.5 mm as a whole: what they take back lies on tissue, and is none.
#[test]
fn a_fold_beyond_the_organ_is_no_tissue_twice() {
    let mut warp = Warp::default();
    let mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), turning_back);
    for top in [10.3, 10.6, 11.0] {
        let shape = mesh.shape(up_to(top), 2.5);
        // Rows from 9.86 to 10 mm; pieces reach back to 9.875 mm.
        let plane = plane([0.0, 0.3, 9.94], FRONTAL, 0.02, [32, 8]);
        let warped = draw(&mut warp, &plane, &shape, &mesh);
        assert_eq!(warped.twice, 0, "{top}");
        for k in 0..warped.pixels.len() {
            let now = place(&plane, k);
            if now[2] < 9.99 {
                assert_eq!(warped.pixels[k], Pixel::Inside(0), "{top} {now:?}");
                let off = (f64::from(warped.rest[k][2]) - now[2]).abs();
                assert!(off < 1e-5, "{top} {now:?}: {:?}", warped.rest[k]);
            }
        }
    }
}

/// The same fold within the organ: each pixel at which a root of the map lies inside out in the organ, or a second one, is told.
#[test]
fn a_small_fold_of_the_organ_is_told_pixel_by_pixel() {
    let mut warp = Warp::default();
    let mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), turning_back);
    // From far to where both places of a fold lie in one of the smallest parts: it ends at 10.595 mm, the pieces' at 10.594 mm.
    for (top, middle, pixel) in [
        (12.2, 10.3, 0.11),
        (12.6, 10.3, 0.11),
        (13.0, 10.3, 0.11),
        (12.2, 10.585, 0.001),
        (12.2, 10.5925, 1e-4),
    ] {
        let shape = mesh.shape(up_to(top), 0.625);
        let plane = plane([0.0, 0.3, middle], FRONTAL, pixel, [8, 12]);
        let warped = draw(&mut warp, &plane, &shape, &mesh);
        let mut twice = 0;
        for k in 0..warped.pixels.len() {
            let now = place(&plane, k);
            let own: Vec<(f64, bool)> = heights(now[2]).into_iter().filter(|(z, _)| *z < top).collect();
            let is_twice = own.len() > 1 || own.iter().any(|(_, folded)| *folded);
            // At the border of the fold pieces and map differ; within half a row of it no answer is asked for.
            let is_clear = |z: f64| {
                [z - 0.55 * pixel, z + 0.55 * pixel].iter().all(|z| {
                    let all: Vec<_> = heights(*z).into_iter().filter(|(z, _)| *z < top).collect();
                    (all.len() > 1 || all.iter().any(|(_, folded)| *folded)) == is_twice
                })
            };
            if is_clear(now[2]) {
                assert_eq!(warped.pixels[k] == Pixel::Twice, is_twice, "{top} {now:?}: {own:?}");
                twice += usize::from(is_twice);
            }
        }
        assert!(twice > 8 && warped.twice >= twice, "{top}: {twice}");
    }
}
