//! Where an organ is at rest: a function of the place on a grid, negative inside.

use super::error::NoShape;
use super::slopes::Slopes;

/// Values of a region, at most.
const MOST_VALUES: u64 = 1 << 26;

/// Of a distance within which a sign does not change so much is used, less so many mm: more than rounding of either can take.
const SURELY: f64 = 0.999;
const SURELY_MM: f64 = 1e-6;

/// A function that is trilinear between the values of a grid along the axes of the CT; inside is where it is negative. Beyond the grid
/// is outside.
#[derive(Debug, Clone)]
pub struct Region {
    origin: [f64; 3],
    step_mm: f64,
    dims: [u32; 3],
    values: Vec<f32>,
    /// Steps of a mm.
    steps: f64,
    slopes: Slopes,
    /// Whether the inside reaches the grid's border.
    is_open: bool,
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
        let mut region = Self {
            origin,
            step_mm,
            dims,
            values,
            steps: 1.0 / step_mm,
            slopes: Slopes::default(),
            is_open: false,
        };
        region.slopes = Slopes::of(dims, step_mm, &region.values);
        let [nx, ny, nz] = dims.map(|n| n as usize);
        let ends = |k: usize, n: usize| k == 0 || k == n - 1;
        let at_border = |k: usize| ends(k % nx, nx) || ends(k / nx % ny, ny) || ends(k / (nx * ny), nz);
        region.is_open = (0..region.values.len()).any(|k| region.values[k] < 0.0 && at_border(k));
        Ok(region)
    }

    /// The function at a place; infinite beyond the grid.
    #[inline]
    pub fn at(&self, place: [f64; 3]) -> f64 {
        let index = self.index(place);
        // Negated as a whole: what is no number lies outside.
        if !(0..3).all(|a| index[a] >= 0.0 && index[a] <= self.last(a)) {
            return f64::INFINITY;
        }
        self.within(index)
    }

    /// The function at a place of the grid, by steps from its origin.
    #[inline(always)]
    fn within(&self, index: [f64; 3]) -> f64 {
        let (mut low, mut part) = ([0_usize; 3], [0.0; 3]);
        for a in 0..3 {
            // At the last value the cell before it serves.
            low[a] = (index[a] as usize).min(self.dims[a] as usize - 2);
            part[a] = index[a] - low[a] as f64;
        }
        let [nx, ny, _] = self.dims.map(|n| n as usize);
        let first = self.offset(low);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let edge = |at: usize| mix(f64::from(self.values[at]), f64::from(self.values[at + 1]), part[0]);
        let near = mix(edge(first), edge(first + nx), part[1]);
        let far = mix(edge(first + nx * ny), edge(first + nx * ny + nx), part[1]);
        mix(near, far, part[2])
    }

    #[inline(always)]
    fn last(&self, axis: usize) -> f64 {
        f64::from(self.dims[axis] - 1)
    }

    /// The corners of the grid's box.
    pub(super) fn ends(&self) -> [[f64; 3]; 2] {
        let high = |a: usize| self.origin[a] + self.step_mm * f64::from(self.dims[a] - 1);
        [self.origin, [high(0), high(1), high(2)]]
    }

    /// Whether a place is inside, and a distance, mm, within which that is the same of all others.
    #[inline(always)]
    pub(super) fn clear(&self, place: [f64; 3]) -> (bool, f64) {
        let index = self.index(place);
        let [x, y, z] = index;
        let in_grid = x >= 0.0 && y >= 0.0 && z >= 0.0 && x <= self.last(0) && y <= self.last(1) && z <= self.last(2);
        if !in_grid || self.is_open {
            return self.clear_anywhere(index);
        }
        let value = self.within(index);
        (value < 0.0, surely(self.same_mm(index, value)))
    }

    /// About a place of the grid where the function has a value: how far it has the same sign within the grid, mm.
    #[inline(always)]
    fn same_mm(&self, index: [f64; 3], value: f64) -> f64 {
        let [reach, lazy] = self.slopes.near(index);
        let near = value.abs() * lazy;
        if near < reach { near } else { reach }
    }

    /// [`Self::clear`] beyond the grid too, and where the inside reaches its border.
    #[cold]
    fn clear_anywhere(&self, index: [f64; 3]) -> (bool, f64) {
        let (mut nearest, mut within, mut beyond) = (index, f64::INFINITY, 0.0_f64);
        for a in 0..3 {
            let last = self.last(a);
            nearest[a] = index[a].max(0.0).min(last);
            within = within.min(index[a].min(last - index[a]) * self.step_mm);
            beyond = beyond.max((-index[a]).max(index[a] - last) * self.step_mm);
        }
        let value = self.within(nearest);
        let inside = value < 0.0 && within >= 0.0;
        let near = self.same_mm(nearest, value);
        // The nearest place of the grid is no further from any of its places than this one, and beyond the grid is outside as well.
        let clear = match (inside, value < 0.0) {
            (true, _) => within.min(near),
            (false, true) => beyond,
            (false, false) => beyond.max(near),
        };
        (inside, surely(clear))
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

    #[inline(always)]
    fn index(&self, place: [f64; 3]) -> [f64; 3] {
        let ([x, y, z], steps) = (self.origin, self.steps);
        [(place[0] - x) * steps, (place[1] - y) * steps, (place[2] - z) * steps]
    }

    #[inline(always)]
    fn offset(&self, [x, y, z]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.dims.map(|n| n as usize);
        x + nx * (y + ny * z)
    }
}

/// A distance less what rounding may take.
#[inline(always)]
fn surely(clear: f64) -> f64 {
    let clear = SURELY * clear - SURELY_MM;
    if clear > 0.0 { clear } else { 0.0 }
}
