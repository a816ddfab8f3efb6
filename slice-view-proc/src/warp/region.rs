//! Where an organ is at rest: a function of the place on a grid, negative inside.

use super::error::NoShape;

/// Values of a region, at most.
const MOST_VALUES: u64 = 1 << 26;

/// A function that is trilinear between the values of a grid along the axes of the CT; inside is where it is negative. Beyond the grid
/// is outside.
#[derive(Debug, Clone)]
pub struct Region {
    origin: [f64; 3],
    step_mm: f64,
    dims: [u32; 3],
    values: Vec<f32>,
}

impl Region {
    /// `values` run fastest along x, then y, then z; the first is at `origin`, mm in the CT's frame.
    ///
    /// # Errors
    /// [`NoShape::Region`], where less than two values lie along an axis, their number is not the grid's, or one is no number.
    pub fn new(origin: [f64; 3], step_mm: f64, dims: [u32; 3], values: Vec<f32>) -> Result<Self, NoShape> {
        let count = dims.iter().fold(1, |all: u64, n| all.saturating_mul(u64::from(*n)));
        let refused = |why: String| Err(NoShape::Region(why));
        if dims.iter().any(|n| *n < 2) || count > MOST_VALUES {
            return refused(format!(
                "a grid of {dims:?} values; 2 an axis to {MOST_VALUES} in all are allowed"
            ));
        }
        if values.len() as u64 != count {
            return refused(format!("{} values on a grid of {count}", values.len()));
        }
        let numbers = origin.iter().all(|x| x.is_finite()) && values.iter().all(|v| v.is_finite());
        if !(numbers && step_mm > 0.0 && step_mm.is_finite()) {
            return refused("a value, the origin or the step is no usable number".to_owned());
        }
        Ok(Self {
            origin,
            step_mm,
            dims,
            values,
        })
    }

    /// The function at a place; infinite beyond the grid.
    #[inline]
    pub fn at(&self, place: [f64; 3]) -> f64 {
        let index = self.index(place);
        let (mut low, mut part) = ([0_usize; 3], [0.0; 3]);
        for a in 0..3 {
            let last = f64::from(self.dims[a] - 1);
            // Negated as a whole: what is no number lies outside.
            if !(index[a] >= 0.0 && index[a] <= last) {
                return f64::INFINITY;
            }
            // At the last value the cell before it serves.
            low[a] = (index[a] as usize).min(self.dims[a] as usize - 2);
            part[a] = index[a] - low[a] as f64;
        }
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let edge = |y: usize, z: usize| {
            let at = self.offset([low[0], low[1] + y, low[2] + z]);
            mix(f64::from(self.values[at]), f64::from(self.values[at + 1]), part[0])
        };
        let [near, far] = [0, 1].map(|z| mix(edge(0, z), edge(1, z), part[1]));
        mix(near, far, part[2])
    }

    /// The least and the largest value that the function can have in a box; beyond the grid counts as largest.
    pub(super) fn bounds(&self, low: [f64; 3], high: [f64; 3]) -> [f64; 2] {
        let (low, high) = (self.index(low), self.index(high));
        let beyond = (0..3).any(|a| low[a] < 0.0 || high[a] > f64::from(self.dims[a] - 1));
        let mut found = [f64::INFINITY, if beyond { f64::INFINITY } else { f64::NEG_INFINITY }];
        let range = |a: usize| {
            let last = f64::from(self.dims[a] - 1);
            low[a].floor().clamp(0.0, last) as usize..=high[a].ceil().clamp(0.0, last) as usize
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let value = f64::from(self.values[self.offset([x, y, z])]);
                    found = [found[0].min(value), found[1].max(value)];
                }
            }
        }
        found
    }

    fn index(&self, place: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| (place[a] - self.origin[a]) / self.step_mm)
    }

    fn offset(&self, [x, y, z]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.dims.map(|n| n as usize);
        x + nx * (y + ny * z)
    }
}
