//! Images of dots and lines whose places are known, by geometry and chance alone.

use chance::SplitMix64;

pub(crate) const COLUMNS: usize = 640;
pub(crate) const ROWS: usize = 480;

/// An image that is being made: light before it is cut to 0 to 255.
pub(crate) struct Made {
    light: Vec<f64>,
    chance: SplitMix64,
}

impl Made {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            light: vec![0.0; COLUMNS * ROWS],
            chance: SplitMix64::new(seed),
        }
    }

    /// A number from 0 to 1.
    pub(crate) fn share(&mut self) -> f64 {
        (self.chance.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number between two.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Normal numbers of deviation 1 that vary together over `grain` pixels, one a pixel of a window.
    fn grains(&mut self, [columns, rows]: [usize; 2], grain: [f64; 2]) -> Vec<f64> {
        // Numbers on a grid of the grain's size, linear between: their mean square over the plane is 4/9.
        let across = [
            (columns as f64 / grain[0]) as usize + 2,
            (rows as f64 / grain[1]) as usize + 2,
        ];
        let grid: Vec<f64> = (0..across[0] * across[1]).map(|_| self.normal()).collect();
        let at = |i: usize, j: usize| grid[j * across[0] + i];
        let mut all = Vec::with_capacity(columns * rows);
        for v in 0..rows {
            for u in 0..columns {
                let (x, y) = (u as f64 / grain[0], v as f64 / grain[1]);
                let (i, j, fx, fy) = (x as usize, y as usize, x.fract(), y.fract());
                let upper = at(i, j) * (1.0 - fx) + at(i + 1, j) * fx;
                let lower = at(i, j + 1) * (1.0 - fx) + at(i + 1, j + 1) * fx;
                all.push(1.5 * (upper * (1.0 - fy) + lower * fy));
            }
        }
        all
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.share()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.share()).cos()
    }

    /// A soft dot of half-widths `size` (deviations, pixels) whose grains vary by `speckle` of it.
    pub(crate) fn dot(&mut self, centre: [f64; 2], size: [f64; 2], height: f64, speckle: f64) {
        let reach = size.map(|s| (4.0 * s).ceil() as i64);
        let window = reach.map(|r| 2 * r as usize + 1);
        let grains = self.grains(window, [6.0, 3.0]);
        let middle = centre.map(|x| x.round() as i64);
        for (j, dv) in (-reach[1]..=reach[1]).enumerate() {
            for (i, du) in (-reach[0]..=reach[0]).enumerate() {
                let (u, v) = (middle[0] + du, middle[1] + dv);
                if !(0..COLUMNS as i64).contains(&u) || !(0..ROWS as i64).contains(&v) {
                    continue;
                }
                let (x, y) = ((u as f64 - centre[0]) / size[0], (v as f64 - centre[1]) / size[1]);
                let factor = (1.0 + speckle * grains[j * window[0] + i]).max(0.0);
                self.light[v as usize * COLUMNS + u as usize] += height * factor * (-0.5 * (x * x + y * y)).exp();
            }
        }
    }

    /// A band across the image at rows `at + slope u`.
    pub(crate) fn band(&mut self, at: f64, slope: f64, size: f64, height: f64, speckle: f64) {
        let grains = self.grains([COLUMNS, ROWS], [6.0, 3.0]);
        for v in 0..ROWS {
            for u in 0..COLUMNS {
                let y = (v as f64 - at - slope * u as f64) / size;
                let factor = (1.0 + speckle * grains[v * COLUMNS + u]).max(0.0);
                self.light[v * COLUMNS + u] += height * factor * (-0.5 * y * y).exp();
            }
        }
    }

    /// Grains everywhere, as of a medium that scatters.
    pub(crate) fn medium(&mut self, height: f64) {
        let grains = self.grains([COLUMNS, ROWS], [6.0, 3.0]);
        for (light, grain) in self.light.iter_mut().zip(grains) {
            *light += height * (1.0 + 0.52 * grain).max(0.0);
        }
    }

    pub(crate) fn grey(&self) -> Vec<u8> {
        self.light
            .iter()
            .map(|light| light.round().clamp(0.0, 255.0) as u8)
            .collect()
    }
}
