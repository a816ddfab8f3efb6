//! The model of a blurred ellipse over the pixels of a window, row by row.
//!
//! What a chord gives a pixel is a product of what depends on the pixel's column and of what depends on its row: the
//! normal distribution is evaluated for each column and each row, not for each pixel.

use super::blurred::{Across, Along, Blurred, Coverage, Rim};
use super::ellipse::Ellipse;

/// A model, and what its columns and one of its rows see; its room is used again from disc to disc.
#[derive(Debug, Default)]
pub(crate) struct Raster {
    model: Option<Blurred>,
    rims: [Rim; 2],
    /// The first column.
    first: usize,
    /// For each column its first pair of chords, and where what it sees begins and ends.
    columns: Vec<[u32; 3]>,
    along: Vec<Along>,
    across: Vec<Across>,
    /// From where to where, along x, the row sees the disc, and all of it.
    outer: [f64; 2],
    core: [f64; 2],
    /// The row's distance from the centre.
    y: f64,
}

impl Raster {
    /// Takes a model, and the columns at which it is asked for.
    pub(crate) fn set(&mut self, ellipse: Ellipse, sigma: f64, columns: [usize; 2]) {
        let model = Blurred::new(ellipse, sigma);
        self.rims = model.rims();
        self.first = columns[0];
        self.columns.clear();
        self.along.clear();
        for x in columns[0]..columns[1] {
            let from = self.along.len() as u32;
            let pair = model.column(x as f64, &mut self.along) as u32;
            self.columns.push([pair, from, self.along.len() as u32]);
        }
        self.model = Some(model);
    }

    /// Goes to a row.
    pub(crate) fn row(&mut self, y: usize) {
        let Some(model) = &self.model else { return };
        let (centre, y) = (model.centre(), y as f64);
        self.y = y - centre.y;
        [self.outer, self.core] = self.rims.map(|rim| rim.at(self.y).map(|x| x + centre.x));
        self.across.clear();
        if self.outer[0] < self.outer[1] {
            model.row(y, &mut self.across);
        }
    }

    /// What a pixel of the row sees, where it is one of the columns.
    #[inline]
    pub(crate) fn at(&self, x: usize) -> Coverage {
        match self.seen(x) {
            PixelPart::Flat(value) => Coverage::flat(value),
            PixelPart::Edge(model, along, across) => {
                let off = [x as f64 - model.centre().x, self.y];
                model.coverage(along, across, off)
            }
        }
    }

    /// The value of [`Raster::at`] alone.
    #[inline]
    pub(crate) fn value(&self, x: usize) -> f64 {
        match self.seen(x) {
            PixelPart::Flat(value) => value,
            PixelPart::Edge(model, along, across) => model.value(along, across),
        }
    }

    #[inline]
    fn seen(&self, x: usize) -> PixelPart<'_> {
        let at = x as f64;
        if at >= self.core[0] && at < self.core[1] {
            return PixelPart::Flat(1.0);
        }
        let column = self.columns.get(x.wrapping_sub(self.first));
        match (&self.model, column) {
            (Some(model), Some([pair, from, end])) if at >= self.outer[0] && at < self.outer[1] => {
                let along = self.along.get(*from as usize..*end as usize);
                let across = self.across.get(*pair as usize..);
                PixelPart::Edge(model, along.unwrap_or_default(), across.unwrap_or_default())
            }
            _ => PixelPart::Flat(0.0),
        }
    }
}

/// What a pixel sees: all of a disc or nothing of it, or its edge.
enum PixelPart<'a> {
    Flat(f64),
    Edge(&'a Blurred, &'a [Along], &'a [Across]),
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Vector2};

    use super::*;

    #[test]
    fn a_window_sees_what_its_pixels_see() {
        let (mut raster, centre) = (Raster::default(), Vector2::new(20.3, 14.8));
        for (shape, sigma) in [
            ([36.0, 3.0, 20.0], 0.75),
            ([60.0, -13.0, 3.0], 0.8),
            ([4.0, 0.0, 90.0], 2.0),
        ] {
            let shape = Matrix2::new(shape[0], shape[1], shape[1], shape[2]);
            let ellipse = Ellipse { centre, shape };
            raster.set(ellipse, sigma, [5, 37]);
            let model = Blurred::new(ellipse, sigma);
            for y in 0..30 {
                raster.row(y);
                for x in 5..37 {
                    let (one, known) = (raster.at(x), model.at(x as f64, y as f64));
                    assert_eq!(one, known, "{x} {y}");
                    // The same sum in another order: roundings of numbers below 1.
                    assert!((raster.value(x) - known.value).abs() < 1e-14, "{x} {y}");
                }
                assert_eq!(raster.at(40), Coverage::flat(0.0));
            }
        }
    }
}
