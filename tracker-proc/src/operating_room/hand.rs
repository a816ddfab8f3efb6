//! The surgeon's hand, which comes near the tool's marker now and then.

use std::f64::consts::TAU;

use geometry::{Direction, Marker, Point, Vector};
use scene::operating_room::Hand;

use chance::Chance;

/// Keeps the hand's draws apart from those of the frames.
const HAND: u64 = 0x6861_6e64;
/// The hand passes this far from the emitters, mm.
const CLEAR_MM: f64 = 10.0;

/// The hand's centre at script time `t_s`, or `None` while it is away.
///
/// At `every_s k` it comes for `for_s` and goes once around the marker, whose outermost emitter is `reach_mm` from its origin,
/// on a circle of radius `reach_mm + CLEAR_MM + radius_mm`. Plane and beginning of the circle are drawn anew for each k.
pub(super) fn place(hand: &Hand, reach_mm: f64, seed: u64, t_s: f64) -> Option<Point<Marker>> {
    let coming = (t_s / hand.every_s).floor();
    let since = t_s - coming * hand.every_s;
    if t_s < 0.0 || since >= hand.for_s {
        return None;
    }
    let (first, second) = circle(Chance::new(seed ^ HAND, coming as u64));
    let (sin, cos) = (TAU * since / hand.for_s).sin_cos();
    let distance = reach_mm + CLEAR_MM + hand.radius_mm;
    Some(Point::new(0.0, 0.0, 0.0) + first * (distance * cos) + second * (distance * sin))
}

/// Two directions at right angles, even over all.
fn circle(chance: Chance) -> (Direction<Marker>, Direction<Marker>) {
    let drawn = |first: u64| {
        let [x, y, z] = [0, 1, 2].map(|i| chance.normal(first + i));
        Vector::new(x, y, z)
    };
    // Normal draws are all 0, or parallel, with a chance of 0.
    let first = drawn(0).direction().unwrap_or(Direction::X);
    let across = drawn(3).cross(first.vector());
    (first, across.direction().unwrap_or(Direction::Y))
}
