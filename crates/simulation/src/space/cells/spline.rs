//! A field given by numbers on a grid: the tensor product of uniform cubic B-splines.

use nalgebra::Vector3;

use super::field::{Bounds, Field};

/// Coefficients on a grid, `level` subtracted. Beyond the grid its outermost coefficients go on.
///
/// The value is between the least and the largest coefficient near the place, and so are slopes between differences of
/// coefficients: bounds within a box are exact without a search.
#[derive(Debug, Clone)]
pub struct Spline {
    size: [usize; 3],
    origin: Vector3<f64>,
    spacing: Vector3<f64>,
    coefficients: Vec<f32>,
    level: f64,
}

impl Spline {
    /// Coefficients `size[0] x size[1] x size[2]`, x fastest, the first at `origin`. `None` where their number is not that,
    /// a size is 0, or a number is not finite or a spacing not above 0.
    pub fn new(
        size: [usize; 3],
        origin: Vector3<f64>,
        spacing: Vector3<f64>,
        coefficients: Vec<f32>,
        level: f64,
    ) -> Option<Self> {
        let count = size[0].checked_mul(size[1])?.checked_mul(size[2])?;
        let finite = origin.iter().all(|x| x.is_finite()) && coefficients.iter().all(|c| c.is_finite());
        let spaced = spacing.iter().all(|s| s.is_finite() && *s > 0.0);
        let fits = count == coefficients.len() && count > 0;
        (finite && spaced && fits && level.is_finite()).then_some(Self {
            size,
            origin,
            spacing,
            coefficients,
            level,
        })
    }

    /// The same with another level.
    #[must_use]
    pub fn at_level(self, level: f64) -> Self {
        Self { level, ..self }
    }

    /// The grid's first and last place.
    pub fn corners(&self) -> [Vector3<f64>; 2] {
        let last = Vector3::from_fn(|k, _| self.spacing[k] * (self.size[k] - 1) as f64);
        [self.origin, self.origin + last]
    }

    fn coefficient(&self, at: [i64; 3]) -> f64 {
        let [i, j, k] = [0, 1, 2].map(|a| at[a].clamp(0, self.size[a] as i64 - 1) as usize);
        f64::from(self.coefficients[(k * self.size[1] + j) * self.size[0] + i])
    }

    /// Of each axis: the first of four coefficients, and where between the second and the third the place is.
    fn place(&self, at: &Vector3<f64>) -> [(i64, f64); 3] {
        [0, 1, 2].map(|k| {
            // A place far beyond the grid, where all is constant, must not overflow.
            let t = ((at[k] - self.origin[k]) / self.spacing[k]).clamp(-8.0, self.size[k] as f64 + 8.0);
            (t.floor() as i64 - 1, t - t.floor())
        })
    }

    fn sum(&self, place: &[(i64, f64); 3], weights: [[f64; 4]; 3]) -> f64 {
        let mut sum = 0.0;
        for (k, z) in (0..).zip(weights[2]) {
            for (j, y) in (0..).zip(weights[1]) {
                let row: f64 = (0..)
                    .zip(weights[0])
                    .map(|(i, x)| x * self.coefficient([place[0].0 + i, place[1].0 + j, place[2].0 + k]))
                    .sum();
                sum += z * y * row;
            }
        }
        sum
    }

    /// First and last coefficient of each axis that a value in the box depends on.
    fn reach(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [[i64; 2]; 3] {
        let ends = [self.place(low), self.place(high)];
        [0, 1, 2].map(|k| [ends[0][k].0, ends[1][k].0 + 3])
    }
}

/// The four cubic B-splines at `t` between two knots.
fn weights(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        2.0 / 3.0 - t * t * (1.0 - 0.5 * t),
        2.0 / 3.0 - s * s * (1.0 - 0.5 * s),
        t * t * t / 6.0,
    ]
}

/// Their derivatives.
fn slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t]
}

impl Field for Spline {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        let place = self.place(at);
        self.sum(&place, place.map(|(_, t)| weights(t))) - self.level
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        let place = self.place(at);
        Vector3::from_fn(|axis, _| {
            let each = [0, 1, 2].map(|k| {
                let t = place[k].1;
                if k == axis { slopes(t) } else { weights(t) }
            });
            self.sum(&place, each) / self.spacing[axis]
        })
    }

    /// Half a step of its grid: a cubic bends once between two knots.
    fn resolution(&self) -> f64 {
        0.5 * self.spacing.min()
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
        visit(self.reach(low, high), |at| {
            let c = self.coefficient(at) - self.level;
            bounds = [bounds[0].min(c), bounds[1].max(c)];
        });
        bounds
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        let reach = self.reach(low, high);
        [0, 1, 2].map(|axis| {
            let (mut bounds, mut within) = ([f64::INFINITY, f64::NEG_INFINITY], reach);
            // The derivative is a spline of one degree less of the differences.
            within[axis][1] -= 1;
            visit(within, |at| {
                let mut next = at;
                next[axis] += 1;
                let difference = self.coefficient(next) - self.coefficient(at);
                bounds = [bounds[0].min(difference), bounds[1].max(difference)];
            });
            bounds.map(|b| b / self.spacing[axis])
        })
    }
}

fn visit(reach: [[i64; 2]; 3], mut each: impl FnMut([i64; 3])) {
    for k in reach[2][0]..=reach[2][1] {
        for j in reach[1][0]..=reach[1][1] {
            for i in reach[0][0]..=reach[0][1] {
                each([i, j, k]);
            }
        }
    }
}
