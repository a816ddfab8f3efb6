//! Points beyond the end of a surface that goes on.

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use surface_registration::{Field, Limits, Options, Points, Spacing, Start, Surface, SurfacePoint, register};

use crate::shapes::Triangles;

/// Half the length that the CT shows of it, mm; the bone itself goes on.
const END_MM: f64 = 40.0;

/// A bone about z whose radius hardly holds it along z: by a wave of 1 mm over 75 mm.
fn at(azimuth: f64, z: f64) -> [f64; 3] {
    let radius = 40.0 + 3.0 * (3.0 * azimuth).cos() + 2.0 * (azimuth - 0.4).sin().powi(3) + (z / 12.0).sin();
    [radius * azimuth.cos(), radius * azimuth.sin(), z]
}

fn bone() -> Triangles {
    let (around, along) = (120_u32, 40_u32);
    let place = |row: u32, k: u32| {
        let azimuth = std::f64::consts::TAU * f64::from(k) / f64::from(around);
        at(azimuth, END_MM * (2.0 * f64::from(row) / f64::from(along) - 1.0))
    };
    let corners = (0..=along).flat_map(|row| (0..around).map(move |k| place(row, k)));
    let number = |row: u32, k: u32| row * around + k % around;
    let cells = (0..along).flat_map(|row| (0..around).map(move |k| (row, k)));
    let triangles = cells.flat_map(|(row, k)| {
        let [a, b, c, d] = [
            number(row, k),
            number(row, k + 1),
            number(row + 1, k),
            number(row + 1, k + 1),
        ];
        [[a, b, c], [b, d, c]]
    });
    (corners.collect(), triangles.collect())
}

/// Only points within some deviations of the border were counted, a twentieth of these for a quarter, so that nothing was said of a CT
/// that did not go far enough. (That they draw nothing is told beside their price.)
#[test]
fn points_far_beyond_the_end_of_a_surface_are_counted() {
    let (corners, triangles) = bone();
    let surface = Surface::<Ct>::new(&corners, &triangles).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let chance = Chance::new(5, 0);
    // On the bone to what its facets are off it, a quarter of them up to 30 mm beyond its upper end.
    let place = |i: u64| {
        at(
            std::f64::consts::TAU * chance.uniform(2 * i),
            110.0 * chance.uniform(2 * i + 1) - END_MM,
        )
    };
    let touched = |i| {
        let [x, y, z] = place(i);
        SurfacePoint::<Tracker>::touched(Point::new(x, y, z), 0.5)
    };
    let points = Points::new(&(0..240).map(touched).collect::<Vec<_>>(), None, 0.0).unwrap();
    let turn = Vector::new(0.03, -0.02, 0.04);
    let start = Start::Guess {
        pose: Rigid::from_rotation_vector(turn, Vector::new(2.0, -3.0, 4.0)).unwrap(),
        turn_rad: 0.1,
        shift_mm: 10.0,
    };
    let found = register(&surface, &field, &points, &start, &Options::default()).unwrap();
    let middle = Point::new(0.0, 0.0, 0.0);
    let shift = (found.transform.transform() * Point::new(0.0, 0.0, 0.0)).distance(middle);
    let predicted = found.predicted_tre_mm(middle);
    assert!((0.2..0.35).contains(&found.share_beyond), "{}", found.share_beyond);
    // Points without noise are nearer than their noise allows: half a deviation is for the facets.
    assert!(shift < 0.5 * predicted && predicted < 2.0, "{shift} of {predicted}");
    let refusals = Limits::default().judge(&found, &[middle]);
    assert!(
        !refusals
            .iter()
            .any(|refusal| matches!(refusal, surface_registration::Refusal::Beyond { .. }))
    );
}
