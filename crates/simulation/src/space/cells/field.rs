//! Regions of space as the places where a smooth function is negative.

use nalgebra::Vector3;

/// Least and largest value.
pub type Bounds = [f64; 2];

/// A smooth function of the place, negative inside a region and positive outside. Its scale does not matter.
pub trait Field: Sync {
    /// The value at a place.
    fn value(&self, at: &Vector3<f64>) -> f64;

    /// The derivative by the place.
    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64>;

    /// Bounds of the value within a box, which may be flat. They hold for certain, and need not be reached.
    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds;

    /// The same of the derivative along each axis.
    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3];

    /// The volume of the region and corners of a box that holds it, where that is known apart from the field: a mesh of it is held against
    /// that.
    fn known(&self) -> Option<(f64, [Vector3<f64>; 2])> {
        None
    }

    /// Boxes smaller than this have no tighter bounds, mm.
    fn resolution(&self) -> f64 {
        0.0
    }
}

/// The steepest slope along each axis in a box.
pub(in crate::space) fn steepest(field: &dyn Field, low: &Vector3<f64>, high: &Vector3<f64>) -> Vector3<f64> {
    let slopes = field.slope_bounds(low, high);
    Vector3::from_fn(|k, _| slopes[k][0].abs().max(slopes[k][1].abs()))
}

/// Whether no surface is in a box by the value in its middle and the steepest slope. A spline's own bounds are those of the whole voxel, however small a box in it:
/// by these alone every part of a shell some voxels thick would be descended from.
pub(in crate::space) fn is_clear(
    field: &dyn Field,
    low: &Vector3<f64>,
    high: &Vector3<f64>,
    steepest: &Vector3<f64>,
) -> bool {
    let half = 0.5 * (high - low);
    // Rounding of a value, by far: a box may only be passed over where none is in it.
    let rounding = 1e-12 * steepest.dot(&(low.abs() + high.abs()));
    field.value(&(low + half)).abs() > half.dot(steepest) + rounding
}

/// What lies behind a plane: `(x - point) . normal < 0`.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// A point of it.
    pub point: Vector3<f64>,
    /// Points out of the region; any length above 0.
    pub normal: Vector3<f64>,
}

impl Field for Plane {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        (at - self.point).dot(&self.normal)
    }

    fn slope(&self, _at: &Vector3<f64>) -> Vector3<f64> {
        self.normal
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        let (half, centre) = ((high - low) * 0.5, (low + high) * 0.5);
        let (middle, reach) = (self.value(&centre), half.dot(&self.normal.abs()));
        [middle - reach, middle + reach]
    }

    fn slope_bounds(&self, _low: &Vector3<f64>, _high: &Vector3<f64>) -> [Bounds; 3] {
        [0, 1, 2].map(|k| [self.normal[k]; 2])
    }
}

/// A ball: `(|x - c|^2 - r^2) / (2 r)`, near the surface the distance from it.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Its centre.
    pub centre: Vector3<f64>,
    /// Its radius, above 0.
    pub radius: f64,
}

impl Field for Ball {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        of_square(self.radius, (at - self.centre).norm_squared())
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        (at - self.centre) / self.radius
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        squares(&(low - self.centre), &(high - self.centre)).map(|s| of_square(self.radius, s))
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        let ends = [low, high].map(|x| self.slope(x));
        [0, 1, 2].map(|k| [ends[0][k], ends[1][k]])
    }
}

fn of_square(radius: f64, square: f64) -> f64 {
    0.5 * (square - radius * radius) / radius
}

/// Bounds of the square of the length of a place in a box.
fn squares(low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
    let mut sum = [0.0, 0.0];
    for k in 0..3 {
        let nearest = 0.0_f64.clamp(low[k], high[k]);
        sum[0] += nearest * nearest;
        sum[1] += low[k].abs().max(high[k].abs()).powi(2);
    }
    sum
}

/// A thick-walled ball: between two radii, `(s - a^2)(s - b^2) / (2 b (b^2 - a^2))` of `s = |x - c|^2`.
#[derive(Debug, Clone, Copy)]
pub struct Shell {
    /// Its centre.
    pub centre: Vector3<f64>,
    /// Inner and outer radius, `0 < a < b`.
    pub radii: [f64; 2],
}

impl Shell {
    pub(super) fn scale(&self) -> f64 {
        let [a, b] = self.radii;
        0.5 / (b * (b * b - a * a))
    }

    fn of_square(&self, s: f64) -> f64 {
        let [a, b] = self.radii;
        (s - a * a) * (s - b * b) * self.scale()
    }

    /// `2 (2 s - a^2 - b^2)` in the field's scale: what the place about the centre is multiplied by in the slope.
    pub(super) fn turn(&self, s: f64) -> f64 {
        let [a, b] = self.radii;
        2.0 * (2.0 * s - a * a - b * b) * self.scale()
    }
}

impl Field for Shell {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        self.of_square((at - self.centre).norm_squared())
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        let from = at - self.centre;
        from * self.turn(from.norm_squared())
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        let [a, b] = self.radii;
        let squares = squares(&(low - self.centre), &(high - self.centre));
        let ends = squares.map(|s| self.of_square(s));
        // A parabola of the square: its least value is at the middle, if that is among them.
        let middle = (0.5 * (a * a + b * b)).clamp(squares[0], squares[1]);
        [self.of_square(middle).min(ends[0]).min(ends[1]), ends[0].max(ends[1])]
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        let (low, high) = (low - self.centre, high - self.centre);
        let turn = squares(&low, &high).map(|s| self.turn(s));
        [0, 1, 2].map(|k| product([low[k], high[k]], turn))
    }
}

/// Bounds of the product of two numbers within bounds.
pub(super) fn product(one: Bounds, other: Bounds) -> Bounds {
    let all = [
        one[0] * other[0],
        one[0] * other[1],
        one[1] * other[0],
        one[1] * other[1],
    ];
    [
        all.iter().copied().fold(f64::INFINITY, f64::min),
        all.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}
