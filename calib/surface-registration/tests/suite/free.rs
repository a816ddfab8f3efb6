//! Bodies that points cannot hold: what is free must be named, and nothing accepted.

use std::f64::consts::TAU;

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use surface_registration::{
    Field, Free, Limits, Options, Points, Refusal, Spacing, Start, Surface, SurfacePoint, free, register,
};

use crate::shapes;

/// The motions of a body whose points `place` draws, the freest first. Facets are shape to the fit: where
/// they are turned by less than a degree against one another, a turn over them is held by tenths of a degree, not by nothing.
fn freed(body: shapes::Triangles, place: impl Fn(Chance) -> [f64; 3], target: Point<Ct>) -> Vec<Free> {
    let surface = Surface::<Ct>::new(&body.0, &body.1).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let truth: Rigid<Ct, Tracker> =
        Rigid::from_rotation_vector(Vector::new(0.4, -0.8, 0.3), Vector::new(50.0, -20.0, 700.0)).unwrap();
    let point = |i: u64| {
        let c = Chance::new(21, i);
        let [x, y, z] = place(c);
        let [ex, ey, ez] = [20, 21, 22].map(|k| 0.3 * c.normal(k));
        SurfacePoint::touched(truth.inverse() * Point::new(x + ex, y + ey, z + ez), 0.3)
    };
    let points = Points::new(&(0..80).map(point).collect::<Vec<_>>(), None, 0.0).unwrap();
    let pose =
        Rigid::from_rotation_vector(Vector::new(0.03, 0.02, -0.03), Vector::new(2.0, -1.0, 1.0)).unwrap() * truth;
    let start = Start::Guess {
        pose,
        turn_rad: 0.2,
        shift_mm: 5.0,
    };
    let found = register(&surface, &field, &points, &start, &Options::default()).unwrap();
    let refusals = Limits::default().judge(&found, &[target]);
    assert!(
        refusals.iter().any(|r| matches!(r, Refusal::Tre { .. })),
        "{refusals:?}"
    );
    let named = refusals.iter().any(|r| matches!(r, Refusal::Free(_)));
    assert!(named, "{refusals:?}");
    free(
        &found,
        &[target, Point::new(30.0, 30.0, 0.0), Point::new(-30.0, 20.0, 20.0)],
    )
}

/// How much freer the last of the first `n` motions is than the next.
fn step(motions: &[Free], n: usize) -> f64 {
    motions[n - 1].deviation_mm / motions[n].deviation_mm
}

fn turns(motions: &[Free]) -> usize {
    motions.iter().filter(|motion| motion.about_mm.is_some()).count()
}

#[test]
fn a_plane_leaves_two_slides_and_a_turn() {
    let on = |c: Chance| [60.0 * c.uniform(0) - 30.0, 60.0 * c.uniform(1) - 30.0, 0.0];
    let motions = freed(shapes::plane(200.0, 20), on, Point::new(0.0, 0.0, -60.0));
    assert!(step(&motions, 3) > 100.0, "{motions:?}");
    for motion in &motions[..3] {
        // Nothing leaves the plane: what turns does so about its normal.
        assert!(motion.slide_mm[2].abs() < 0.05 * motion.deviation_mm, "{motion:?}");
        assert!(
            motion.turn[0].hypot(motion.turn[1]) < 0.05 * (motion.turn[2].abs() + 1.0),
            "{motion:?}"
        );
    }
    let words = motions[0].to_string();
    assert!(
        words.contains("slides along") || words.contains("turns about"),
        "{words}"
    );
}

#[test]
fn a_ball_leaves_three_turns() {
    let on = |c: Chance| {
        let v = [0, 1, 2].map(|k| c.normal(k));
        let r = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| 40.0 * x / r)
    };
    let motions = freed(shapes::ball(40.0, 120), on, Point::new(0.0, 80.0, -60.0));
    assert_eq!(turns(&motions[..3]), 3, "{motions:?}");
    assert!(step(&motions, 3) > 5.0, "{motions:?}");
}

#[test]
fn a_cylinder_leaves_a_slide_and_a_turn() {
    let on = |c: Chance| {
        let f = TAU * c.uniform(0);
        [15.0 * f.cos(), 15.0 * f.sin(), 80.0 * c.uniform(1) - 40.0]
    };
    let motions = freed(shapes::tube(15.0, 150.0, 360), on, Point::new(40.0, 0.0, -60.0));
    assert!(step(&motions, 2) > 5.0, "{motions:?}");
    // Along the axis of the cylinder, and about it.
    assert!(
        motions[0].about_mm.is_none() && motions[0].slide_mm[2].abs() > 0.99 * motions[0].deviation_mm,
        "{motions:?}"
    );
    assert!(
        motions[1].about_mm.is_some() && motions[1].turn[2].abs() > 20.0 * motions[1].turn[0].hypot(motions[1].turn[1]),
        "{motions:?}"
    );
}
