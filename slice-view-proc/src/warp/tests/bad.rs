//! What is refused, and what is told though it should not be.

use super::fields::dent;
use super::stage::{Mesh, block, draw, in_box, plane};
use crate::warp::picture::NoWarp;
use crate::warp::{Cube, NoShape, Organ, Pixel, Region, Shape, Warp};

const AXIAL: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn refused(cubes: &[Cube], nodes: usize, piece_mm: f64) -> NoShape {
    Shape::new(cubes, nodes, in_box([0.0; 3], 5.0), piece_mm).unwrap_err()
}

#[test]
fn a_mesh_that_cannot_be_is_refused_by_name() {
    let mesh = Mesh::new(&block([0.0; 3], 10.0, 2), |x| x);
    let nodes = mesh.now.len();
    assert!(matches!(refused(&[], nodes, 2.0), NoShape::Count { what: "cubes", .. }));
    assert!(matches!(
        refused(&mesh.cubes, 0, 2.0),
        NoShape::Count { what: "nodes", .. }
    ));
    assert!(matches!(
        refused(&mesh.cubes, nodes - 1, 2.0),
        NoShape::Cube { cube: 7, .. }
    ));
    for piece in [0.0, -1.0, f64::NAN, 1e-3] {
        assert!(
            matches!(refused(&mesh.cubes, nodes, piece), NoShape::Piece(_)),
            "{piece}"
        );
    }
    let with = |change: fn(&mut Cube)| {
        let mut cubes = mesh.cubes.clone();
        change(&mut cubes[3]);
        refused(&cubes, nodes, 2.5)
    };
    let bad: [fn(&mut Cube); 5] = [
        |cube| cube.side = f64::NAN,
        |cube| cube.low[1] = f64::INFINITY,
        |cube| cube.side = 30.0,
        |cube| cube.low[0] += 0.7,
        |cube| cube.low[0] += 1e12,
    ];
    for change in bad {
        assert!(
            matches!(with(change), NoShape::Cube { cube: 3, .. }),
            "{}",
            with(change)
        );
    }
    let far = with(|cube| cube.low = [2e9; 3]);
    assert!(
        matches!(
            far,
            NoShape::Count {
                what: "corners of pieces",
                ..
            }
        ),
        "{far}"
    );
    let many = vec![mesh.cubes[0].clone(); 300];
    let many = refused(&many, nodes, 0.156_25);
    assert!(
        matches!(
            many,
            NoShape::Count {
                what: "pieces of all cubes",
                ..
            }
        ),
        "{many}"
    );
    // A box about the cubes that would hold more corners than there is memory for.
    assert!(matches!(
        with(|cube| cube.low = [1e6; 3]),
        NoShape::Count {
            what: "corners of pieces",
            ..
        }
    ));
}

#[test]
fn a_region_that_cannot_be_is_refused_by_name() {
    let new =
        |dims: [u32; 3], count: usize, step: f64, value: f32| Region::new([0.0; 3], step, dims, vec![value; count]);
    for (dims, count, step, value) in [
        ([1, 2, 2], 4, 1.0, 0.0),
        ([2, 2, 2], 7, 1.0, 0.0),
        ([2, 2, 2], 8, 0.0, 0.0),
        ([2, 2, 2], 8, f64::NAN, 0.0),
        ([2, 2, 2], 8, 1.0, f32::NAN),
        ([u32::MAX; 3], 8, 1.0, 0.0),
    ] {
        assert!(
            matches!(new(dims, count, step, value), Err(NoShape::Region(_))),
            "{dims:?} {count} {step} {value}"
        );
    }
}

#[test]
fn a_state_that_cannot_be_is_refused_and_the_next_image_is_whole() {
    let mut warp = Warp::default();
    let mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), dent);
    let shape = mesh.shape(in_box([0.0; 3], 18.0), 2.5);
    let plane_of = |pixel_mm: f64| plane([0.0; 3], AXIAL, pixel_mm, [64, 64]);
    let before = draw(&mut warp, &plane_of(0.5), &shape, &mesh).clone();
    let places = mesh.places();
    let of = |places: &[[f32; 3]], warp: &mut Warp, pixel_mm: f64| {
        warp.draw(&plane_of(pixel_mm), &[Organ { shape: &shape, places }])
            .unwrap_err()
    };
    let short = of(&places[1..], &mut warp, 0.5);
    assert_eq!(
        short,
        NoWarp::Nodes {
            organ: 0,
            found: places.len() - 1,
            expected: places.len()
        }
    );
    for bad in [f32::NAN, f32::INFINITY] {
        let mut places = places.clone();
        places[77][2] = bad;
        assert!(matches!(
            of(&places, &mut warp, 0.5),
            NoWarp::Place { organ: 0, node: 77, .. }
        ));
    }
    assert_eq!(of(&places, &mut warp, 1e-5), NoWarp::Pixels(0));
    let organ = Organ {
        shape: &shape,
        places: &places,
    };
    assert_eq!(warp.draw(&plane_of(0.5), &[organ; 65]).unwrap_err(), NoWarp::Organs(65));
    let after = draw(&mut warp, &plane_of(0.5), &shape, &mesh);
    assert_eq!((&after.pixels, &after.rest), (&before.pixels, &before.rest));
}

/// A node pulled through its neighbours turns tissue inside out: the pixels about it are claimed more than once, and no others.
#[test]
fn tissue_that_is_folded_is_said() {
    let mut warp = Warp::default();
    let mut mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), |x| x);
    let shape = mesh.shape(in_box([0.0; 3], 18.0), 2.5);
    let plane = plane([0.1, 0.1, 0.1], AXIAL, 0.5, [64, 64]);
    assert_eq!(draw(&mut warp, &plane, &shape, &mesh).twice, 0);
    let node = mesh.now.iter().position(|p| *p == [0.0; 3]).unwrap();
    mesh.now[node][0] = 14.0;
    let warped = draw(&mut warp, &plane, &shape, &mesh);
    assert!(warped.twice > 20, "{}", warped.twice);
    let far = (0..64).map(|row| warped.pixels[64 * row]);
    assert!(far.into_iter().all(|p| p == Pixel::Inside(0)));
}

/// Numbers at the ends of what there is: no panic, and nothing claimed.
#[test]
fn places_far_away_are_no_panic() {
    let mut warp = Warp::default();
    let mut mesh = Mesh::new(&block([-20.0; 3], 10.0, 4), |x| x);
    let shape = mesh.shape(in_box([0.0; 3], 18.0), 2.5);
    for far in [1e30, -1e30, 3e38] {
        mesh.now.fill([far; 3]);
        let places = mesh.places();
        let organ = Organ {
            shape: &shape,
            places: &places,
        };
        for pixel in [1e-6, 0.5, 1e3] {
            if let Ok(warped) = warp.draw(&plane([0.0; 3], AXIAL, pixel, [8, 8]), &[organ]) {
                assert!(
                    warped.pixels.iter().all(|p| !matches!(p, Pixel::Inside(_))),
                    "{far} {pixel}"
                );
            }
        }
    }
    // So many of one cube that a count of sixteen bits does not hold them.
    let heap = vec![mesh.cubes[0].clone(); 40_000];
    let shape_of_heap = Shape::new(&heap, mesh.now.len(), in_box([0.0; 3], 30.0), 10.0).unwrap();
    let at_rest = Mesh::new(&block([-20.0; 3], 10.0, 4), |x| x);
    let warped = draw(
        &mut warp,
        &plane([-15.0; 3], AXIAL, 1.0, [4, 4]),
        &shape_of_heap,
        &at_rest,
    );
    assert!(warped.pixels.iter().all(|p| *p == Pixel::Twice));
    let at_one = plane([0.0; 3], AXIAL, 0.5, [1, 1]);
    mesh.now.fill([0.0; 3]);
    let collapsed = draw(&mut warp, &at_one, &shape, &mesh);
    assert_eq!(collapsed.pixels.len(), 1);
}
