//! The image along its beams: the grid on which everything else is measured.

use ultrasound::Image;

/// The most samples of a grid: an image of 4096 x 4096 pixels at its own spacing.
const MOST: usize = 1 << 24;
/// The most places across a beam that are averaged to one sample.
const MOST_ACROSS: usize = 4;

/// Grey values by beam and depth. Beams lie one after another, the samples of a beam side by side.
pub(super) struct Grid {
    pub(super) beams: usize,
    pub(super) depths: usize,
    /// From sample to sample, mm.
    pub(super) step_mm: f64,
    /// From beam to beam at half of the depth, mm.
    pub(super) wide_mm: f64,
    pub(super) grey: Vec<f32>,
    /// The samples of each beam that lie in the image.
    pub(super) shown: Vec<std::ops::Range<usize>>,
}

impl Grid {
    /// The image's grey, smoothed along its beams by a normal curve of `axial_mm`; `None` where it would be too large.
    pub(super) fn new(image: &Image<'_>, spacing_mm: f64, axial_mm: f64) -> Option<Self> {
        let shape = image.shape();
        let half_mm = 0.5 * shape.depth_mm();
        let width_mm = arc_mm(image, half_mm);
        let [u, v] = shape.pixel_mm();
        // Finer than the pulse makes nothing clearer, finer than the pixels neither.
        let step_mm = u.min(v).max(0.25 * axial_mm).max(shape.depth_mm() / 4096.0);
        let beams = (width_mm / spacing_mm).round().max(8.0) as usize;
        let depths = (shape.depth_mm() / step_mm).floor() as usize + 1;
        if beams.checked_mul(depths).is_none_or(|all| all > MOST) {
            return None;
        }
        let mut grid = Self {
            beams,
            depths,
            step_mm,
            wide_mm: width_mm / beams as f64,
            grey: vec![0.0; beams * depths],
            shown: Vec::with_capacity(beams),
        };
        grid.sample(image);
        grid.smooth(axial_mm / step_mm);
        Some(grid)
    }

    /// Which beam of the image a beam of the grid is; fractions lie between two.
    pub(super) fn share(&self, beam: f64) -> f64 {
        (beam + 0.5) / self.beams as f64
    }

    pub(super) fn beam(&self, beam: usize) -> &[f32] {
        &self.grey[beam * self.depths..(beam + 1) * self.depths]
    }

    fn sample(&mut self, image: &Image<'_>) {
        let shape = image.shape();
        let across = ((self.wide_mm / shape.pixel_mm()[0]).ceil() as usize).clamp(1, MOST_ACROSS);
        let inside = |place: [f64; 2]| {
            let [u, v] = shape.pixel_at(place);
            (-0.5..=shape.columns() as f64 - 0.5).contains(&u) && (-0.5..=shape.rows() as f64 - 0.5).contains(&v)
        };
        for beam in 0..self.beams {
            let middle = |row: usize| shape.along(self.share(beam as f64), row as f64 * self.step_mm).0;
            let from = (0..self.depths).find(|row| inside(middle(*row)));
            let from = from.unwrap_or(self.depths);
            let to = (from..self.depths).find(|row| !inside(middle(*row)));
            let shown = from..to.unwrap_or(self.depths);
            let line = &mut self.grey[beam * self.depths..(beam + 1) * self.depths];
            for part in 0..across {
                let offset = (part as f64 + 0.5) / across as f64 - 0.5;
                let share = (beam as f64 + 0.5 + offset) / self.beams as f64;
                // Beams are straight: two places give all others.
                let (origin, direction) = shape.along(share, 0.0);
                let start = shape.pixel_at(origin);
                let step = shape.pixel_at(direction.map(|part| part * self.step_mm));
                for row in shown.clone() {
                    let at = [start[0] + row as f64 * step[0], start[1] + row as f64 * step[1]];
                    line[row] += between(image, at) / across as f32;
                }
            }
            self.shown.push(shown);
        }
    }

    fn smooth(&mut self, sigma: f64) {
        let kernel = normal(sigma);
        let mut line = vec![0.0_f32; self.depths];
        for (beam, shown) in self.grey.chunks_mut(self.depths).zip(&self.shown) {
            if shown.is_empty() {
                continue;
            }
            line.copy_from_slice(beam);
            let reach = kernel.len() / 2;
            for row in shown.clone() {
                let is_within = row >= shown.start + reach && row + reach < shown.end;
                beam[row] = match is_within {
                    true => line[row - reach..=row + reach]
                        .iter()
                        .zip(&kernel)
                        .map(|(grey, w)| grey * w)
                        .sum(),
                    // The ends are held: a border of black would look like the flank of an echo.
                    false => (0..kernel.len())
                        .map(|k| kernel[k] * line[(row + k).saturating_sub(reach).clamp(shown.start, shown.end - 1)])
                        .sum(),
                };
            }
        }
    }
}

/// How wide all beams are together at a depth, mm.
fn arc_mm(image: &Image<'_>, depth_mm: f64) -> f64 {
    // Chords of 64 parts of a quarter turn and less are shorter than their arc by less than 1e-4 of it.
    let places = (0..=64).map(|part| image.shape().along(f64::from(part) / 64.0, depth_mm).0);
    let places: Vec<_> = places.collect();
    places
        .windows(2)
        .map(|two| (two[1][0] - two[0][0]).hypot(two[1][1] - two[0][1]))
        .sum()
}

/// Grey between four pixels; beyond the border that of the border.
fn between(image: &Image<'_>, [u, v]: [f64; 2]) -> f32 {
    let (columns, rows) = (image.shape().columns(), image.shape().rows());
    let u = u.clamp(0.0, (columns - 1) as f64);
    let v = v.clamp(0.0, (rows - 1) as f64);
    let (left, top) = ((u as usize).min(columns - 2), (v as usize).min(rows - 2));
    let (right_part, low_part) = ((u - left as f64) as f32, (v - top as f64) as f32);
    let at = top * columns + left;
    let grey = |index: usize| f32::from(image.grey()[index]);
    let above = grey(at) + right_part * (grey(at + 1) - grey(at));
    let below = grey(at + columns) + right_part * (grey(at + columns + 1) - grey(at + columns));
    above + low_part * (below - above)
}

/// A normal curve, of sum 1, from -2.5 to 2.5 deviations.
pub(super) fn normal(sigma: f64) -> Vec<f32> {
    let reach = (2.5 * sigma).ceil() as i32;
    let raw: Vec<f64> = (-reach..=reach)
        .map(|k| (-0.5 * (f64::from(k) / sigma).powi(2)).exp())
        .collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|x| (x / sum) as f32).collect()
}
