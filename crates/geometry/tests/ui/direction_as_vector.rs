//! A direction has no length in mm: it moves a point only once multiplied by one.

use geometry::{Ct, Direction, Point};

fn main() {
    let entry = Point::<Ct>::new(1.0, 2.0, 3.0);
    let _ = entry + Direction::<Ct>::Z;
}
