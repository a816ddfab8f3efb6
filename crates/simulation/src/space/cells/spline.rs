//! A field given by numbers on a grid: the tensor product of uniform cubic B-splines.

use nalgebra::{Matrix3, Vector3};

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

    /// Of each axis: the first of four coefficients, and where between the second and the third the place is.
    fn place(&self, at: &Vector3<f64>) -> [(i64, f64); 3] {
        let along = |k: usize| {
            // A place far beyond the grid, where all is constant, must not overflow.
            let t = ((at[k] - self.origin[k]) / self.spacing[k]).clamp(-8.0, self.size[k] as f64 + 8.0);
            // `floor` is a call where the processor is not known.
            let whole = t as i64;
            let knot = whole - i64::from(t < whole as f64);
            (knot - 1, t - knot as f64)
        };
        [along(0), along(1), along(2)]
    }

    /// The index of a plane of coefficients across an axis; beyond the grid the outermost.
    fn within(&self, axis: usize, at: i64) -> usize {
        at.clamp(0, self.size[axis] as i64 - 1) as usize
    }

    /// Sums of the sixteen rows of four coefficients along x about a place, each row by its weights: of which of four rows along y and z it is.
    #[inline]
    fn summed<const N: usize>(
        &self,
        place: &[(i64, f64); 3],
        weights: impl Fn(usize, usize) -> [f64; N],
    ) -> [[f64; 4]; N] {
        let mut sums = [[0.0; 4]; N];
        let mut add = |j: usize, k: usize, row: &[f32; 4]| {
            let row = row.map(f64::from);
            for (sum, weight) in sums.iter_mut().zip(weights(j, k)) {
                for (sum, c) in sum.iter_mut().zip(&row) {
                    *sum += weight * c;
                }
            }
        };
        let first = place.map(|(first, _)| first);
        let [x, y, z] = [0, 1, 2].map(|axis| self.within(axis, first[axis]));
        // Almost every place is inside, where rows are four numbers side by side and no index needs to be held to the grid.
        let fits = |axis: usize| first[axis] >= 0 && first[axis] + 3 < self.size[axis] as i64;
        if fits(0) && fits(1) && fits(2) {
            for k in 0..4 {
                let plane = &self.coefficients[((z + k) * self.size[1] + y) * self.size[0] + x..];
                for j in 0..4 {
                    if let Some(row) = plane[j * self.size[0]..].first_chunk() {
                        add(j, k, row);
                    }
                }
            }
        } else {
            let index = |axis: usize| [0, 1, 2, 3].map(|i| self.within(axis, first[axis] + i));
            for (k, z) in index(2).into_iter().enumerate() {
                for (j, y) in index(1).into_iter().enumerate() {
                    let start = (z * self.size[1] + y) * self.size[0];
                    add(j, k, &index(0).map(|x| self.coefficients[start + x]));
                }
            }
        }
        sums
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

/// Their second derivatives.
fn curvatures(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t]
}

impl Spline {
    /// The second derivative by the place.
    pub fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64> {
        let place = self.place(at);
        let [x, y, z] = place.map(|(_, t)| [weights(t), slopes(t), curvatures(t)]);
        // How often along each axis: xx, xy, xz, yy, yz, zz.
        let [xx, xy, xz, yy, yz, zz] = self.summed(&place, |j, k| {
            [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].map(|[b, c]| y[b][j] * z[c][k])
        });
        let each = [[&xx, &xy, &xz], [&xy, &yy, &yz], [&xz, &yz, &zz]];
        Matrix3::from_fn(|p, q| {
            let order = usize::from(p == 0) + usize::from(q == 0);
            dot(&x[order], each[p][q]) / (self.spacing[p] * self.spacing[q])
        })
    }
}

impl Field for Spline {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        let place = self.place(at);
        let [x, y, z] = place.map(|(_, t)| weights(t));
        let [sum] = self.summed(&place, |j, k| [y[j] * z[k]]);
        dot(&x, &sum) - self.level
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        let place = self.place(at);
        let ([x, y, z], [dx, dy, dz]) = (place.map(|(_, t)| weights(t)), place.map(|(_, t)| slopes(t)));
        let [along_x, along_y, along_z] = self.summed(&place, |j, k| [y[j] * z[k], dy[j] * z[k], y[j] * dz[k]]);
        let sum = Vector3::new(dot(&dx, &along_x), dot(&x, &along_y), dot(&x, &along_z));
        sum.component_div(&self.spacing)
    }

    /// Half a step of its grid: a cubic bends once between two knots.
    fn resolution(&self) -> f64 {
        0.5 * self.spacing.min()
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        let mut bounds = [f32::INFINITY, f32::NEG_INFINITY];
        self.visit(self.reach(low, high), |at| {
            let c = self.coefficients[at];
            bounds = [bounds[0].min(c), bounds[1].max(c)];
        });
        bounds.map(|b| f64::from(b) - self.level)
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        let reach = self.reach(low, high);
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        [0, 1, 2].map(|axis| {
            // The derivative is a spline of one degree less of the differences; beyond the grid these are zero.
            let last = self.size[axis] as i64 - 1;
            let outside = reach[axis][0] < 0 || reach[axis][1] > last;
            let mut bounds = if outside {
                [0.0; 2]
            } else {
                [f64::INFINITY, f64::NEG_INFINITY]
            };
            let mut within = reach;
            within[axis] = [reach[axis][0].clamp(0, last), reach[axis][1].clamp(0, last) - 1];
            self.visit(within, |at| {
                let [one, next] = [at, at + strides[axis]].map(|n| f64::from(self.coefficients[n]));
                bounds = [bounds[0].min(next - one), bounds[1].max(next - one)];
            });
            bounds.map(|b| b / self.spacing[axis])
        })
    }
}

impl Spline {
    /// Calls `each` with the index of every coefficient in reach, those of the border again for what lies beyond it.
    fn visit(&self, reach: [[i64; 2]; 3], mut each: impl FnMut(usize)) {
        let range = |axis: usize| {
            let [first, last] = reach[axis].map(|at| self.within(axis, at));
            // An axis of no differences has none to visit.
            if reach[axis][1] < reach[axis][0] {
                first..first
            } else {
                first..last + 1
            }
        };
        for k in range(2) {
            for j in range(1) {
                let start = (k * self.size[1] + j) * self.size[0];
                range(0).for_each(|i| each(start + i));
            }
        }
    }
}

fn dot(one: &[f64; 4], other: &[f64; 4]) -> f64 {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2] + one[3] * other[3]
}
