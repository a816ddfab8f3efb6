//! What is refused before anything is fitted, by name and with numbers.

use geometry::{Ct, Direction, Point, Tracker};
use nalgebra::{Matrix3x6, Matrix6};
use surface_registration::{
    Beam, BeamNoise, Field, FieldError, Points, PointsError, SharedError, Spacing, Surface, SurfaceError, SurfacePoint,
};

use crate::shapes;

fn touched(places: &[[f64; 3]]) -> Vec<SurfacePoint<Tracker>> {
    places
        .iter()
        .map(|[x, y, z]| SurfacePoint::touched(Point::new(*x, *y, *z), 0.5))
        .collect()
}

fn corners() -> Vec<[f64; 3]> {
    (0..20_u32)
        .map(|i| [f64::from(i % 5) * 9.0, f64::from(i % 3) * 11.0, f64::from(i) * 2.0])
        .collect()
}

#[test]
fn what_is_no_surface_is_refused() {
    let (corners, triangles) = shapes::ball(40.0, 12);
    let refused = |corners: &[[f64; 3]], triangles: &[[u32; 3]]| Surface::<Ct>::new(corners, triangles).unwrap_err();
    assert!(matches!(refused(&corners, &[]), SurfaceError::Count { found: 0 }));
    let mut bad = corners.clone();
    bad[5][1] = f64::NAN;
    assert!(matches!(
        refused(&bad, &triangles),
        SurfaceError::NotFinite { corner: 5, .. }
    ));
    assert!(matches!(
        refused(&corners, &[[0, 1, 99_999]]),
        SurfaceError::NoCorner {
            triangle: 0,
            found: 99_999,
            ..
        }
    ));
    let metres: Vec<[f64; 3]> = corners.iter().map(|c| c.map(|x| x * 1e-3)).collect();
    assert!(refused(&metres, &triangles).to_string().contains("is it in metres?"));
    let huge: Vec<[f64; 3]> = corners.iter().map(|c| c.map(|x| x * 1e3)).collect();
    assert!(matches!(refused(&huge, &triangles), SurfaceError::TooLarge { .. }));
    let mut turned = triangles.clone();
    turned[200].swap(0, 1);
    assert!(matches!(
        refused(&corners, &turned),
        SurfaceError::Orientation { edges: 3, .. }
    ));
    let inside_out: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let SurfaceError::InsideOut { volume_ml, .. } = refused(&corners, &inside_out) else {
        panic!()
    };
    // 4/3 pi 40^3 mm^3 are 268 ml; the polyhedron has a little less.
    assert!((-268.1..-250.0).contains(&volume_ml), "{volume_ml}");
}

/// A marrow cavity, whichever way its triangles go round: no probe reaches it.
#[test]
fn a_shell_inside_a_shell_is_left_out() {
    let (corners, triangles) = shapes::ball(40.0, 16);
    let alone = Surface::<Ct>::new(&corners, &triangles).unwrap();
    for is_turned in [false, true] {
        let (mut both, mut all) = (corners.clone(), triangles.clone());
        let first = both.len() as u32;
        let inner = shapes::ball(30.0, 12);
        both.extend(inner.0);
        all.extend(inner.1.iter().map(|[a, b, c]| {
            if is_turned {
                [a + first, c + first, b + first]
            } else {
                [a + first, b + first, c + first]
            }
        }));
        let shells = Surface::<Ct>::new(&both, &all).unwrap();
        assert_eq!((shells.facts().parts, shells.facts().inner_parts), (1, 1));
        assert_eq!(shells.facts().inner_triangles, inner.1.len() - 2 * 24);
        let p = Point::new(3.0, 31.0, 1.0);
        assert_eq!(shells.distance(p), alone.distance(p));
    }
}

/// Of a bone that is cut open the wall of its marrow may reach out over the outer one's border. One corner alone told whether it is inside: with
/// one out there the file was refused as inside out.
#[test]
fn an_inner_wall_that_reaches_out_of_an_open_shell_is_left_out() {
    let below = |(corners, mut triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>), z: f64| {
        triangles.retain(|t: &[u32; 3]| t.iter().all(|c| corners[*c as usize][2] <= z));
        (corners, triangles)
    };
    let (mut corners, mut triangles) = below(shapes::ball(40.0, 16), 15.0);
    let (outer, first) = (triangles.len(), corners.len() as u32);
    let mut inner = below(shapes::ball(30.0, 12), 25.0);
    // From the border down.
    inner
        .1
        .sort_by(|a, b| inner.0[b[0] as usize][2].total_cmp(&inner.0[a[0] as usize][2]));
    assert!(inner.0[inner.1[0][0] as usize][2] > 15.0);
    corners.extend(&inner.0);
    triangles.extend(inner.1.iter().map(|[a, b, c]| [a + first, c + first, b + first]));
    let found = Surface::<Ct>::new(&corners, &triangles).unwrap();
    assert_eq!((found.facts().parts, found.facts().inner_parts), (1, 1));
    assert!(found.facts().triangles <= outer);
}

/// Files of loose triangles name each corner anew.
#[test]
fn loose_triangles_are_one_surface() {
    let (corners, triangles) = shapes::cuboid([20.0, 20.0, 20.0], 3);
    let loose: Vec<[f64; 3]> = triangles.iter().flatten().map(|c| corners[*c as usize]).collect();
    let each: Vec<[u32; 3]> = (0..triangles.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let surface = Surface::<Ct>::new(&loose, &each).unwrap();
    assert_eq!((surface.facts().open_edges, surface.facts().parts), (0, 1));
}

#[test]
fn what_are_no_points_is_refused() {
    let refused = |points: &[SurfacePoint<Tracker>]| Points::new(points, None, 0.5).unwrap_err();
    let good = touched(&corners());
    assert!(Points::new(&good, None, 0.5).is_ok());
    assert!(matches!(refused(&good[..6]), PointsError::Count { found: 6 }));
    let mut bad = good.clone();
    bad[4].place = Point::new(1.0, f64::NAN, 0.0);
    assert!(matches!(
        refused(&bad),
        PointsError::NotFinite {
            point: 4,
            what: "place"
        }
    ));
    let mut bad = good.clone();
    bad[3] = SurfacePoint::touched(bad[3].place, 0.0);
    assert!(matches!(refused(&bad), PointsError::Covariance { point: 3 }));
    let metres: Vec<[f64; 3]> = corners().iter().map(|c| c.map(|x| x * 1e-3)).collect();
    assert!(
        refused(&touched(&metres)).to_string().contains("are they in metres?")
            || matches!(refused(&touched(&metres)), PointsError::HeldStill { .. })
    );
    let beam = |depth| Beam {
        direction: Direction::Z,
        depth_mm: Some(depth),
    };
    let noise = BeamNoise {
        axial_mm: 0.5,
        lateral_mm: 1.0,
        elevation_mm: 1.5,
    };
    let mut bad = good.clone();
    bad[7] = SurfacePoint::seen(bad[7].place, beam(-2.0), Direction::X, noise);
    assert!(matches!(refused(&bad), PointsError::Depth { point: 7, .. }));
    // Across the beam lies along it.
    bad[7] = SurfacePoint::seen(bad[7].place, beam(20.0), Direction::Z, noise);
    assert!(matches!(
        refused(&bad),
        PointsError::NotFinite {
            point: 7,
            what: "covariance"
        }
    ));
    assert!(matches!(
        Points::new(&good, None, f64::NAN),
        Err(PointsError::Held { .. })
    ));
    let shared = |n: usize, c: Matrix6<f64>| {
        Some(SharedError {
            covariance: c,
            levers: vec![Matrix3x6::zeros(); n],
        })
    };
    assert!(matches!(
        Points::new(&good, shared(19, Matrix6::identity()), 0.5),
        Err(PointsError::Shared { .. })
    ));
    assert!(matches!(
        Points::new(&good, shared(20, -Matrix6::identity()), 0.5),
        Err(PointsError::Shared { .. })
    ));
}

/// A probe held still sends thirty points a second of one place: they are one.
#[test]
fn points_of_a_probe_held_still_count_once() {
    let mut places = corners();
    places.extend((0..200_u32).map(|i| [100.0 + 1e-3 * f64::from(i % 7), 50.0, 1e-3 * f64::from(i % 5)]));
    let points = Points::new(&touched(&places), None, 0.5).unwrap();
    assert!((points.effective() - 21.0).abs() < 1e-9, "{}", points.effective());
    let still: Vec<[f64; 3]> = (0..400_u32)
        .map(|i| if i < 200 { [0.0; 3] } else { [80.0, 0.0, 0.0] })
        .collect();
    assert!(matches!(
        Points::new(&touched(&still), None, 0.5),
        Err(PointsError::HeldStill { .. })
    ));
}

#[test]
fn a_field_that_does_not_fit_is_refused() {
    let (corners, triangles) = shapes::ball(400.0, 12);
    let surface = Surface::<Ct>::new(&corners, &triangles).unwrap();
    let with = |spacing_mm| {
        Field::new(
            &surface,
            Spacing {
                spacing_mm,
                ..Spacing::default()
            },
        )
    };
    assert!(matches!(with(f64::NAN), Err(FieldError::Spacing { .. })));
    assert!(matches!(with(0.0), Err(FieldError::Spacing { .. })));
    assert!(matches!(with(0.5), Err(FieldError::TooFine { .. })));
}
