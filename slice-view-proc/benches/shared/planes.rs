//! Planes by chance, the same in every run.

use geometry::{Ct, Direction, Point, SlicePlane, Vector};

use super::ct::CENTRE_MM;

/// Directions of columns and rows.
pub(crate) type Axes = [Direction<Ct>; 2];

/// Numbers by chance.
#[derive(Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// In -1..1.
    pub(crate) fn number(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Uniform on the sphere.
    pub(crate) fn direction(&mut self) -> Direction<Ct> {
        loop {
            let v = Vector::new(self.number(), self.number(), self.number());
            if let Some(direction) = v.direction().filter(|_| (0.1..1.0).contains(&v.norm())) {
                return direction;
            }
        }
    }

    /// Two orthogonal directions.
    pub(crate) fn axes(&mut self) -> Axes {
        loop {
            let (right, other) = (self.direction(), self.direction());
            if let Some(down) = right.cross(other).direction() {
                return orthogonal(right, down);
            }
        }
    }

    /// Up to `reach_mm` from the middle of the volume along each axis.
    pub(crate) fn point(&mut self, reach_mm: f64) -> Point<Ct> {
        let [x, y, z] = CENTRE_MM.map(|middle| middle + reach_mm * self.number());
        Point::new(x, y, z)
    }
}

/// `down` turned so that it is orthogonal to `right` to the last digit.
pub(crate) fn orthogonal(right: Direction<Ct>, down: Direction<Ct>) -> Axes {
    let straight = right.cross(down).cross(right.vector()).direction();
    [right, straight.expect("not parallel")]
}

/// A square image of `side` pixels.
pub(crate) fn square(centre: Point<Ct>, axes: Axes, pixel_mm: f64, side: u32) -> SlicePlane {
    SlicePlane::centred(centre, axes, pixel_mm, [side, side]).expect("a usual image")
}
