//! A tube that slips through a stretched surface between its points, and points near enough to one another that it does not.
//!
//! A tube of 5 mm radius in a block of 100 mm, cubes of 6.25 mm at it.

#![allow(clippy::print_stdout, reason = "the table is what these tests are for")]

use nalgebra::Vector3;
use simulation::law::{Law, Ogden};
use simulation::space::cells::{Ball, Depth, Mesh, Plane, Settings, SurfacePoint};
use simulation::space::equilibrium::NoEquilibrium;

use super::push::{EVERYWHERE, Pushed, quarter};

const RADIUS: f64 = 5.0;
const MOST: f64 = 0.5 * RADIUS;

/// A quarter of the block; points on the top near the tube so far from one another.
fn block(levels: u32, spacing: f64) -> Mesh {
    let settings = Settings {
        levels,
        ..Settings::of_side(25.0)
    };
    let mut mesh = quarter(&settings, &[30.0, 15.0][..levels as usize]);
    mesh.lay_points(&EVERYWHERE, Depth::default(), |_, high| {
        (high.z > 99.0 && high.x < 30.0 && high.y < 30.0).then_some(spacing)
    });
    mesh
}

fn area(mesh: &Mesh) -> f64 {
    mesh.surface.iter().map(|p| p.area).sum()
}

/// The least distance of two points, and the largest of a place of another, denser set from the nearest point.
fn apart(points: &Mesh, places: &Mesh) -> (f64, f64) {
    let nearest = |at: &Vector3<f64>, but: f64| {
        let away = points.surface.iter().map(|p| (p.at - at).norm());
        away.filter(|away| *away > but).fold(f64::INFINITY, f64::min)
    };
    let least = points
        .surface
        .iter()
        .map(|p| nearest(&p.at, 0.0))
        .fold(f64::INFINITY, f64::min);
    let most = places.surface.iter().map(|p| nearest(&p.at, -1.0)).fold(0.0, f64::max);
    (least, most)
}

#[test]
fn points_are_as_near_to_one_another_as_asked_and_stand_for_all_of_the_area() {
    let ball = Ball {
        centre: Vector3::new(0.3, -0.7, 1.1),
        radius: 8.0,
    };
    let tilted = Plane {
        point: Vector3::new(0.1, 0.2, 0.3),
        normal: Vector3::new(0.3, -0.4, 1.0),
    };
    let make = |field: &dyn simulation::space::cells::Field, spacing: f64| {
        let corners = [-10.0, 10.0].map(Vector3::repeat);
        let mut mesh = Mesh::new(field, corners, &Settings::of_side(5.0), &|_, _| false).unwrap();
        let before = (area(&mesh), mesh.unknowns());
        mesh.lay_points(field, Depth::default(), |_, _| Some(spacing));
        assert!(
            (area(&mesh) / before.0 - 1.0).abs() < 2e-4,
            "{} {before:?}",
            area(&mesh)
        );
        assert_eq!(mesh.unknowns(), before.1);
        mesh
    };
    for field in [&ball as &dyn simulation::space::cells::Field, &tilted] {
        let (mesh, dense) = (make(field, 1.0), make(field, 0.4));
        let (least, most) = apart(&mesh, &dense);
        println!("{} points: {least} to {most} mm apart", mesh.surface.len());
        // Places looked at are at most half of the spacing apart along their base, 0.36 from its middle.
        assert!(least >= 1.0 && most < 1.5 && most > 0.5, "{least} {most}");
        // Two Gauss points in more parts are as near to one another, and stand for the same area.
        let corners = [-10.0, 10.0].map(Vector3::repeat);
        let mut few = Mesh::new(field, corners, &Settings::of_side(5.0), &|_, _| false).unwrap();
        few.lay_points_by(field, |_, _| {
            Some((
                1.0,
                Depth {
                    points: 2,
                    ..Depth::default()
                },
            ))
        });
        let (least, most) = apart(&few, &dense);
        assert!(
            few.surface != mesh.surface && least >= 1.0 && most < 1.5,
            "{least} {most}"
        );
        assert!((area(&few) / area(&mesh) - 1.0).abs() < 2e-4, "{}", area(&few));
        // The same points each time.
        assert_eq!(make(field, 1.0).surface, mesh.surface);
        // A spacing that no part of a cube is small enough for leaves the points as they are.
        let mut kept = mesh.clone();
        kept.lay_points(field, Depth::default(), |_, _| Some(1e-6));
        let same = |(one, other): (&SurfacePoint, &SurfacePoint)| one.at == other.at && one.area == other.area;
        assert!(kept.surface.len() == mesh.surface.len() && kept.surface.iter().zip(&mesh.surface).all(same));
        // None stands for next to nothing, which would settle slowly.
        let smallest = mesh.surface.iter().map(|p| p.area).fold(f64::INFINITY, f64::min);
        println!("least area {smallest} mm^2");
    }
}

/// How far the worst of a denser set's places is beyond the gap of every point, mm.
fn unseen(points: &Mesh, places: &Mesh) -> f64 {
    let beyond = |at: &Vector3<f64>| {
        let each = points.surface.iter().map(|p| (p.at - at).norm() - p.gap);
        each.fold(f64::INFINITY, f64::min)
    };
    places
        .surface
        .iter()
        .map(|p| beyond(&p.at))
        .fold(f64::NEG_INFINITY, f64::max)
}

/// A cube in which another area is found keeps its points, some of which stand for next to nothing: their gaps were told by that.
#[test]
fn gaps_of_a_cube_that_keeps_its_points_are_no_less_than_its_places_are_from_them() {
    let ball = Ball {
        centre: Vector3::new(0.3, -0.7, 1.1),
        radius: 8.0,
    };
    let corners = [-10.0, 10.0].map(Vector3::repeat);
    let made = |points: usize| {
        let depth = Depth {
            points,
            ..Depth::default()
        };
        let settings = Settings {
            depth,
            ..Settings::of_side(10.0)
        };
        Mesh::new(&ball, corners, &settings, &|_, _| false).unwrap()
    };
    let mut dense = made(4);
    dense.lay_points(&ball, Depth::default(), |_, _| Some(0.4));
    // One Gauss point misses area, so that four are taken: points that were kept are nearer to one another.
    let mut few = made(4);
    let one = Depth {
        points: 1,
        ..Depth::default()
    };
    few.lay_points_by(&ball, |_, _| Some((10.0, one)));
    let (least, _) = apart(&few, &dense);
    assert!(least >= 10.0, "{least}");
    // With one Gauss point areas are off by more than a hundredth.
    let coarse = made(1);
    let two = Depth {
        points: 2,
        ..Depth::default()
    };
    // Two and four agree on another: the mesh's own is what is off.
    let mut laid = coarse.clone();
    laid.lay_points_by(&ball, |_, _| Some((1.0, two)));
    let (least, most) = apart(&laid, &dense);
    assert!(least >= 1.0 && most < 1.5, "{least} {most}");
    // No part of a cube is small enough for these.
    let mut kept = coarse.clone();
    kept.lay_points_by(&ball, |_, _| Some((1e-6, two)));
    assert_eq!(kept.surface.len(), coarse.surface.len());
    let [before, now, after] = [&coarse, &kept, &laid].map(|mesh| unseen(mesh, &dense));
    println!(
        "places up to {before:.2} mm beyond gaps before, {now:.2} where points are kept, {after:.2} where they are laid"
    );
    // The denser set's own places are on the surface to rounding.
    assert!(before > 0.3 && now <= 1e-9, "{before} {now}");
    // Places looked at are each up to 0.36 mm from the middle between it and the next.
    assert!(after < 0.36, "{after}");
    // Contact counts them.
    let wide = |factor: f64| {
        let mut block = quarter(&Settings::of_side(25.0), &[]);
        block.surface.iter_mut().for_each(|p| p.gap *= factor);
        let pushed = Pushed::of(block, 0.45, RADIUS);
        pushed.system.tubes[0].widest_gap(&pushed.system.bodies, &pushed.a)
    };
    assert!(
        wide(1.0) > 0.0 && (wide(1.5) / wide(1.0) - 1.5).abs() < 1e-9,
        "{}",
        wide(1.5)
    );
}

/// A stroke in parts; the deepest place of the surface between its points at each of them, or why it ended.
fn pushed(block: &mut Pushed, depths: &[f64]) -> Result<f64, NoEquilibrium> {
    let mut deepest = 0.0_f64;
    for depth in depths {
        block.to(*depth)?;
        let tube = block.system.tubes[0].tube();
        let places = (0..101_u32.pow(2)).map(|n| [n % 101, n / 101].map(|k| 0.12 * f64::from(k)));
        for [x, y] in places {
            let at = Vector3::new(x, y, 100.0 - 1e-9);
            let now = at + block.displacement(at.into());
            deepest = deepest.max(-tube.signed_distance(&now).value);
        }
    }
    Ok(deepest)
}

/// Sixteen points on a face of 6.25 mm are 1.2 mm from the middle between them at rest, half of what may be; not so where the face is stretched.
#[test]
fn gaps_between_points_of_a_stretched_surface_count_as_they_are() {
    let settings = Settings {
        levels: 2,
        ..Settings::of_side(25.0)
    };
    let mut coarse = Pushed::of(quarter(&settings, &[30.0, 15.0]), 0.45, RADIUS);
    let at_rest = coarse.system.tubes[0].widest_gap(&coarse.system.bodies, &coarse.a);
    let mut last = 0.0;
    // All places twice as far from the middle along x: every length along the surface up to twice.
    for factor in [1.0_f64, 2.0] {
        for (node, place) in coarse.mesh.nodes.iter().enumerate() {
            coarse.a[3 * node] = (factor - 1.0) * place.x;
        }
        last = coarse.system.tubes[0].widest_gap(&coarse.system.bodies, &coarse.a);
        println!("stretched by {factor}: {last:.3} mm, at rest {at_rest:.3} mm");
    }
    assert!(at_rest > 0.0 && at_rest < MOST);
    assert!((last / at_rest - 2.0).abs() < 1e-9, "{last} {at_rest}");
}

/// A neo-Hookean surface gives way: a place of it as small as one likes is drawn over the whole tip for next to no energy. Where the tip has
/// slipped between points this is refused, and no state before it has tissue in the tube.
#[test]
fn a_tube_that_slips_between_points_of_a_stretched_surface_is_refused() {
    let mut soft = Pushed::of(block(2, 0.7), 0.45, RADIUS);
    let dip = pushed(&mut soft, &[1.5, 3.0, 4.5, 6.0, 7.5, 9.0, 10.5, 12.0]).unwrap();
    // Of points 1.35 mm from the middle between them the sagitta is 0.19 mm.
    assert!(dip < 0.19, "{dip}");
    let refused = pushed(&mut soft, &[14.0]);
    assert!(
        matches!(refused, Err(NoEquilibrium::TooCoarse { gap, most }) if gap > most && most == MOST),
        "{refused:?}"
    );
}

/// A law whose stress rises faster than the area shrinks holds where the neo-Hookean does not.
#[test]
fn a_surface_that_stiffens_is_not_slipped_through() {
    let law = Law::Ogden(Ogden::new(&[(0.9, 2.0), (0.1, 8.0)]).unwrap());
    let mut stiff = Pushed::of_law(law, block(2, 0.7), 0.45, RADIUS);
    let dip = pushed(
        &mut stiff,
        &[
            1.5, 3.0, 4.5, 6.0, 7.5, 9.0, 10.5, 12.0, 13.5, 14.0, 14.5, 15.0, 15.5, 16.0,
        ],
    )
    .unwrap();
    assert!(dip < 0.19, "{dip}");
}
