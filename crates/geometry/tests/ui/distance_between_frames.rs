//! Points of different frames have no distance.

use geometry::{Ct, Point, Tracker};

fn main() {
    let in_ct = Point::<Ct>::new(1.0, 2.0, 3.0);
    let in_tracker = Point::<Tracker>::new(4.0, 5.0, 6.0);
    let _ = in_ct.distance(in_tracker);
}
