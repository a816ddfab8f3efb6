//! Clouds with a planted answer, the same in every run.

#![allow(dead_code, reason = "each test program uses a part")]

pub(crate) mod ball;
pub(crate) mod plate;
mod random;

use geometry::{Ct, Point, Rigid, Tracker};

pub(crate) use random::{Random, turn};

/// `transform` applied to `from`.
pub(crate) fn images(transform: Rigid<Ct, Tracker>, from: &[Point<Tracker>]) -> Vec<Point<Ct>> {
    from.iter().map(|p| transform * *p).collect()
}

/// The angle between two unit quaternions' rotations, small angles exactly.
pub(crate) fn angle(p: [f64; 4], q: [f64; 4]) -> f64 {
    let vector = turn(p, q);
    let [x, y, z] = vector;
    (x * x + y * y + z * z).sqrt()
}
