//! Which pixel is what.

use chance::SplitMix64;

use super::fields::{ALL, rigid};
use super::stage::{Mesh, axes, block, distance, draw, graded, in_box, inverse, place, plane, region};
use crate::warp::{Organ, Pixel, Warp};

/// Pieces of cubes of two sizes, whose shared faces round differently, close without a gap and without an overlap: well within the tissue
/// all pixels are inside, once.
#[test]
fn tissue_has_no_holes_and_no_pixel_twice() {
    let (mut warp, mut rng) = (Warp::default(), SplitMix64::new(2));
    let mut seen = 0;
    for (name, field) in ALL {
        let mesh = Mesh::new(&graded(), field);
        let shape = mesh.shape(in_box([0.0; 3], 19.0), 2.5);
        for _ in 0..40 {
            let centre = field([0; 3].map(|_| rng.around(0.0, 12.0)));
            let plane = plane(centre, axes(&mut rng), 0.25, [96, 96]);
            let warped = draw(&mut warp, &plane, &shape, &mesh);
            assert_eq!(warped.twice, 0, "{name}");
            for k in 0..warped.pixels.len() {
                let now = place(&plane, k);
                let Some(rest) = inverse(field, now, warped.rest[k].map(f64::from)) else {
                    continue;
                };
                // The quadratic map of 10 mm cubes is within 0.4 mm of the field.
                if rest.iter().all(|x| x.abs() < 19.0 - 0.4) {
                    assert_eq!(warped.pixels[k], Pixel::Inside(0), "{name} {k} {rest:?}");
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 300_000, "{seen}");
}

/// A plane exactly through nodes and edges of pieces, its pixels exactly on them.
#[test]
fn a_plane_through_nodes_has_no_holes() {
    let mut warp = Warp::default();
    let mesh = Mesh::new(&graded(), |x| x);
    let shape = mesh.shape(in_box([0.0; 3], 19.0), 2.5);
    for z in [0.0, 5.0, 10.0, 2.5, -10.0] {
        for axes in [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
            [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]],
        ] {
            let plane = plane([0.0, 0.0, z], axes, 1.25, [17, 17]);
            let warped = draw(&mut warp, &plane, &shape, &mesh);
            assert!(warped.pixels.iter().all(|p| *p == Pixel::Inside(0)), "{z} {axes:?}");
            let off = (0..warped.pixels.len()).map(|k| distance(place(&plane, k), warped.rest[k].map(f64::from)));
            assert!(off.fold(0.0, f64::max) < 1e-5);
        }
    }
}

/// A ball that is turned and moved: what its pixels are is known but for a band of the thickness that the region's grid leaves open.
#[test]
fn a_moved_ball_is_inside_where_it_is_and_vacated_where_it_was() {
    let (mut warp, mut rng) = (Warp::default(), SplitMix64::new(3));
    let mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), rigid);
    let radius = 14.0;
    let ball = region([0.0; 3], 17.0, 0.5, move |x| distance(x, [0.0; 3]) - radius);
    let shape = mesh.shape(ball, 2.5);
    // A distance is bent by 1 / radius across: a trilinear function of it is off by 3 h^2 / 8 of that.
    let open = 3.0 / 8.0 * 0.25 / radius + 1e-4;
    let mut counts = [0; 3];
    for _ in 0..20 {
        let plane = plane([0; 3].map(|_| rng.around(1.0, 6.0)), axes(&mut rng), 0.5, [100, 90]);
        let warped = draw(&mut warp, &plane, &shape, &mesh);
        for (k, pixel) in warped.pixels.iter().enumerate() {
            let own = place(&plane, k);
            let (now, rest) = (
                distance(own, rigid([0.0; 3])) - radius,
                distance(own, [0.0; 3]) - radius,
            );
            if now.abs() < open || (now > 0.0 && rest.abs() < open) {
                continue;
            }
            let expected = match (now < 0.0, rest < 0.0) {
                (true, _) => Pixel::Inside(0),
                (false, true) => Pixel::Vacated,
                (false, false) => Pixel::Outside,
            };
            assert_eq!(*pixel, expected, "{own:?} {now} {rest}");
            counts[[Pixel::Inside(0), Pixel::Vacated, Pixel::Outside]
                .iter()
                .position(|p| p == pixel)
                .unwrap()] += 1;
            if expected == Pixel::Outside {
                assert!(distance(own, warped.rest[k].map(f64::from)) < 1e-5);
            }
        }
    }
    assert!(counts.iter().all(|n| *n > 2000), "{counts:?}");
}

/// Two blocks that slide along one another: the border stays sharp, each side has its own places; pushed into one another, what both claim
/// is said.
#[test]
fn organs_apart_keep_their_border_and_what_two_claim_is_said() {
    let mut warp = Warp::default();
    let moved = |shift: [f64; 3]| move |x: [f64; 3]| std::array::from_fn(|a| x[a] + shift[a]);
    for (into, claimed) in [(0.0, 0), (2.0, 2 * 40)] {
        let (left, right) = ([-20.0, -20.0, -20.0], [0.0, -20.0, -20.0]);
        let meshes = [
            Mesh::new(&block(left, 10.0, 2), moved([into, 5.0, 0.0])),
            Mesh::new(&block(right, 10.0, 2), moved([0.0, -5.0, 0.0])),
        ];
        // A box of 20 mm whose faces lie on nodes of its grid.
        let shapes = [0, 1].map(|k| {
            let centre = [20.0 * k as f64 - 10.0, -10.0, -10.0];
            meshes[k].shape(in_box(centre, 10.0), 5.0)
        });
        let places = [0, 1].map(|k| meshes[k].places());
        let organs = [0, 1].map(|k| Organ {
            shape: &shapes[k],
            places: &places[k],
        });
        // 80 x 40 pixels of 0.5 mm, centres beside the borders; rows -19.75 .. 0.
        let plane = plane([0.0, -10.0, -10.1], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.5, [80, 40]);
        let warped = warp.draw(&plane, &organs).unwrap();
        // Both cover the rows from -15 to -5.
        assert_eq!(warped.twice, claimed * 20 / 40 * 2, "{into}");
        for row in 10..30 {
            let line = &warped.pixels[80 * row..80 * (row + 1)];
            let border = 40 + (2.0 * into) as usize;
            assert!(line[border..].iter().all(|p| *p == Pixel::Inside(1)), "{into} {row}");
            assert!(
                line[(2.0 * into) as usize..40].iter().all(|p| *p == Pixel::Inside(0)),
                "{into} {row}"
            );
            assert!((warped.rest[80 * row + 20][1] - (-19.75 + 0.5 * row as f32 - 5.0)).abs() < 1e-5);
            assert!((warped.rest[80 * row + 60][1] - (-19.75 + 0.5 * row as f32 + 5.0)).abs() < 1e-5);
        }
    }
}

/// Cubes reach beyond their organ's surface, and here into the other organ: that is no tissue, and none is there twice.
#[test]
fn cubes_of_two_organs_that_overlap_beyond_their_surfaces_claim_nothing_twice() {
    let moved = |shift: [f64; 3]| move |x: [f64; 3]| std::array::from_fn(|a| x[a] + shift[a]);
    // From -20 to 0 and from -8 to 12 mm along x; the organs in them from -18 to -6 and from -2 to 10.
    let meshes = [
        Mesh::new(&block([-20.0; 3], 10.0, 2), moved([0.0, 1.0, 0.0])),
        Mesh::new(&block([-8.0, -20.0, -20.0], 10.0, 2), moved([0.0, -1.0, 0.0])),
    ];
    let shapes = [0, 1].map(|k| meshes[k].shape(in_box([16.0 * k as f64 - 12.0, -10.0, -10.0], 6.0), 5.0));
    let places = [0, 1].map(|k| meshes[k].places());
    let organs = [0, 1].map(|k| Organ {
        shape: &shapes[k],
        places: &places[k],
    });
    let plane = plane([-4.0, -10.0, -10.1], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.5, [64, 40]);
    let mut warp = Warp::default();
    let warped = warp.draw(&plane, &organs).unwrap();
    assert_eq!(warped.twice, 0);
    for organ in [0, 1] {
        let own = warped
            .pixels
            .iter()
            .filter(|pixel| **pixel == Pixel::Inside(organ))
            .count();
        // 12 mm of 24 pixels a side, but for what is trilinear between values of the region at its edges.
        assert!((400..=26 * 26).contains(&own), "{own}");
    }
}
