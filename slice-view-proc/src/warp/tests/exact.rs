//! Places at rest against the inverse of the map, found apart.

use chance::SplitMix64;

use super::fields::{ALL, bent, unbent};
use super::stage::{Mesh, axes, block, distance, draw, graded, in_box, inverse, place, plane};
use crate::warp::{Pixel, Warp};

/// f32 places are off by 2^-24 of 40 mm, through a stretch of up to 3.
const ROUNDING_MM: f64 = 2e-5;
/// The raster's part of the statement, by pixels of 1 mm and a stretch of less than 3.
const GRID_MM: f64 = 3.0 / 256.0;

/// Random planes through fields, meshes with and without cubes of two sizes: the error found is within the stated one, which is no more
/// than some times too large, and falls with the square of the pieces' size.
#[test]
fn places_are_within_the_stated_error_of_the_quadratic_map() {
    let (mut warp, mut rng) = (Warp::default(), SplitMix64::new(1));
    for (name, field) in ALL {
        for cubes in [block([-20.0; 3], 10.0, 4), graded()] {
            let mesh = Mesh::new(&cubes, field);
            let mut stated = Vec::new();
            for piece in [2.5, 1.25] {
                let shape = mesh.shape(in_box([0.0; 3], 18.0), piece);
                let (mut worst, mut most) = (0.0_f64, 0.0_f64);
                for _ in 0..6 {
                    let centre = field([0; 3].map(|_| rng.around(0.0, 10.0)));
                    let plane = plane(centre, axes(&mut rng), 1.0, [64, 48]);
                    let warped = draw(&mut warp, &plane, &shape, &mesh);
                    most = most.max(warped.error_mm);
                    for (k, _) in warped
                        .pixels
                        .iter()
                        .enumerate()
                        .filter(|(_, p)| **p == Pixel::Inside(0))
                    {
                        let found = warped.rest[k].map(f64::from);
                        let Some(exact) = inverse(|x| mesh.moved(x), place(&plane, k), found) else {
                            panic!("{name}: no inverse at {found:?}");
                        };
                        let off = distance(exact, found);
                        assert!(
                            off <= warped.error_mm + ROUNDING_MM,
                            "{name} {piece}: {off} > {}",
                            warped.error_mm
                        );
                        worst = worst.max(off);
                    }
                }
                println!(
                    "{name}, {} cubes, pieces of {piece} mm: {worst:.5} mm, stated {most:.5}",
                    cubes.len()
                );
                assert!(
                    most <= 20.0 * worst.max(ROUNDING_MM) + GRID_MM,
                    "{name}: {worst} is stated as {most}"
                );
                stated.push(most);
            }
            // Other planes, and a stretch that is that of other pieces: a quarter within a factor 2.
            assert!(stated[1] < 0.5 * stated[0] + GRID_MM, "{name}: {stated:?}");
        }
    }
}

/// Corners lie on a grid of parts of a pixel: beside a border where the stretch jumps a pixel may be drawn by the other side's map.
#[test]
fn a_border_where_the_stretch_jumps_is_within_the_stated_error() {
    let field = |[x, y, z]: [f64; 3]| [if x < 0.0 { x } else { 0.02 * x }, y, z];
    let back = |[x, y, z]: [f64; 3]| [if x < 0.0 { x } else { 50.0 * x }, y, z];
    let mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), field);
    let shape = mesh.shape(in_box([0.0; 3], 18.0), 2.5);
    let (mut warp, mut worst) = (Warp::default(), 0.0_f64);
    for k in 0..200 {
        let plane = plane(
            [-5e-5 * f64::from(k), 0.0, 0.3],
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            1.0,
            [9, 9],
        );
        let warped = draw(&mut warp, &plane, &shape, &mesh);
        for k in (0..81).filter(|k| warped.pixels[*k] == Pixel::Inside(0)) {
            let off = distance(back(place(&plane, k)), warped.rest[k].map(f64::from));
            assert!(
                off <= warped.error_mm + 50.0 * ROUNDING_MM,
                "{off} > {}",
                warped.error_mm
            );
            worst = worst.max(off);
        }
    }
    assert!(worst > 0.01, "{worst}");
}

/// A map with a known inverse, far from the origin too: f32 places there are off by 2^-24 of the distance.
#[test]
fn a_closed_form_is_found_again() {
    let mut warp = Warp::default();
    for far in [0.0, 1e3] {
        let shifted = move |x: [f64; 3]| bent(x.map(|x| x - far)).map(|x| x + far);
        let low = [far - 20.0; 3];
        let mesh = Mesh::new(&block(low, 10.0, 4), shifted);
        let shape = mesh.shape(in_box([far; 3], 18.0), 0.3125);
        let plane = plane([far; 3], [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]], 0.5, [128, 128]);
        let warped = draw(&mut warp, &plane, &shape, &mesh);
        let rounding = ROUNDING_MM + 4.0 * far * 2.0_f64.powi(-24);
        let mut count = 0;
        for k in (0..warped.pixels.len()).filter(|k| warped.pixels[*k] == Pixel::Inside(0)) {
            let exact = unbent(place(&plane, k).map(|x| x - far)).map(|x| x + far);
            let off = distance(exact, warped.rest[k].map(f64::from));
            assert!(off <= warped.error_mm + rounding, "{off} > {}", warped.error_mm);
            count += 1;
        }
        assert!(count > 2000 && warped.error_mm < 0.01, "{count} {}", warped.error_mm);
    }
}
