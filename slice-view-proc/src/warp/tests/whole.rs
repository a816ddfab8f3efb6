//! Cubes drawn whole against their pieces, and against the portable code.

use chance::SplitMix64;

use super::fields::ALL;
use super::stage::{Mesh, axes, block, distance, draw, graded, in_box, plane};
use crate::warp::{Organ, Pixel, Warp};

/// f32 places of less than 40 mm.
const ROUNDING_MM: f64 = 2e-5;

/// Within an organ whose surface is far away every pixel is what its pieces make it, and its place differs by no more than both may be off.
#[test]
fn cubes_drawn_whole_cover_what_their_pieces_cover() {
    let (mut warp, mut slow, mut rng) = (Warp::default(), Warp::by_pieces(), SplitMix64::new(7));
    let (mut seen, mut outside, mut better) = (0, 0, 0);
    for (name, field) in ALL {
        for cubes in [block([-20.0; 3], 10.0, 4), graded()] {
            let mesh = Mesh::new(&cubes, field);
            for piece in [5.0, 2.5] {
                let shape = mesh.shape(in_box([0.0; 3], 40.0), piece);
                for k in 0..30 {
                    let centre = field([0; 3].map(|_| rng.around(0.0, 18.0)));
                    let plane = plane(centre, axes(&mut rng), [0.25, 0.6, 1.3][k % 3], [101, 77]);
                    let (found, expected) = (
                        draw(&mut warp, &plane, &shape, &mesh),
                        draw(&mut slow, &plane, &shape, &mesh),
                    );
                    assert!(found.pixels == expected.pixels, "{name} {piece} {k}");
                    let most = found.error_mm + expected.error_mm + ROUNDING_MM;
                    for at in (0..found.pixels.len()).filter(|at| found.pixels[*at] == Pixel::Inside(0)) {
                        let off = distance(found.rest[at].map(f64::from), expected.rest[at].map(f64::from));
                        assert!(off <= most, "{name} {piece} {k}: {off} > {most}");
                        seen += 1;
                    }
                    outside += found.pixels.iter().filter(|p| **p != Pixel::Inside(0)).count();
                    better += usize::from(found.error_mm < expected.error_mm);
                }
            }
        }
    }
    // That cubes were drawn whole at all shows in the error.
    assert!(
        seen > 500_000 && outside > 50_000 && better > 100,
        "{seen} {outside} {better}"
    );
}

/// With AVX2 and without, in used memory and in new, of two organs over one another.
#[test]
fn all_ways_give_the_same_bits() {
    let (mut warp, mut rng) = (Warp::default(), SplitMix64::new(8));
    let meshes = [
        Mesh::new(&block([-20.0; 3], 10.0, 4), ALL[1].1),
        Mesh::new(&graded(), ALL[2].1),
    ];
    let shapes = [
        meshes[0].shape(in_box([0.0; 3], 15.0), 5.0),
        meshes[1].shape(in_box([8.0, 0.0, 0.0], 10.0), 2.5),
    ];
    let places = [meshes[0].places(), meshes[1].places()];
    let organs = [0, 1].map(|k| Organ {
        shape: &shapes[k],
        places: &places[k],
    });
    let mut kinds = [0; 4];
    for size in [[128, 96], [37, 41], [128, 96], [1, 9]] {
        let plane = plane([0; 3].map(|_| rng.around(0.0, 8.0)), axes(&mut rng), 0.4, size);
        let mut new = Warp::default();
        let portable = new.draw_portably(&plane, &organs).unwrap();
        let found = warp.draw(&plane, &organs).unwrap();
        let bits = |rest: &[[f32; 3]]| rest.iter().map(|place| place.map(f32::to_bits)).collect::<Vec<_>>();
        assert!(
            found.pixels == portable.pixels && bits(&found.rest) == bits(&portable.rest),
            "{size:?}"
        );
        assert_eq!(
            (found.error_mm.to_bits(), found.twice),
            (portable.error_mm.to_bits(), portable.twice)
        );
        for pixel in &found.pixels {
            kinds[match pixel {
                Pixel::Outside => 0,
                Pixel::Inside(_) => 1,
                Pixel::Vacated => 2,
                Pixel::Twice => 3,
            }] += 1;
        }
    }
    assert!(kinds.iter().all(|n| *n > 100), "{kinds:?}");
}

/// About random places of a region of random values, within the distance that is said, every place is as the first.
#[test]
fn a_region_is_alike_as_far_as_it_says() {
    let mut rng = SplitMix64::new(9);
    let mut clear_mm = 0.0;
    for round in 0..40 {
        let steep = [1.0, 0.05][round % 2];
        let dims = [9, 7, 12];
        let at = |k: usize| [k % 9, k / 9 % 7, k / 63].map(|i| i as f64);
        let values = (0..9 * 7 * 12).map(|k| (distance(at(k), [4.0, 3.0, 6.0]) - 3.0 + rng.around(0.0, steep)) as f32);
        let region = crate::warp::Region::new([-1.0, 2.0, 0.5], 1.7, dims, values.collect()).unwrap();
        for _ in 0..300 {
            let from = [rng.around(6.0, 12.0), rng.around(7.0, 12.0), rng.around(10.0, 14.0)];
            let (inside, clear) = region.clear(from);
            assert_eq!(inside, region.at(from) < 0.0, "{from:?}");
            clear_mm += clear;
            for _ in 0..20 {
                let off = [0; 3].map(|_| rng.around(0.0, 1.0));
                let length = distance(off, [0.0; 3]).max(1e-9);
                let to = [0, 1, 2].map(|a| from[a] + off[a] / length * clear * 0.999);
                assert_eq!(inside, region.at(to) < 0.0, "{from:?} {to:?} {clear}");
            }
        }
    }
    // Which would be true of no distance as well.
    assert!(clear_mm > 0.5 * 40.0 * 300.0, "{clear_mm}");
}
