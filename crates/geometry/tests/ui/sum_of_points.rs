//! Two positions have a difference, not a sum.

use geometry::{Ct, Point};

fn main() {
    let entry = Point::<Ct>::new(1.0, 2.0, 3.0);
    let target = Point::<Ct>::new(4.0, 5.0, 6.0);
    let _ = entry + target;
}
