//! Which pixels a fit of the whole grid looks at, disc by disc.

use std::ops::Range;

use nalgebra::{Matrix3, Vector2};

use crate::disc::{Blurred, Ellipse, REACH, Raster};
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::paper_edge::{Border, CLEAR};
use crate::grid::homography::{jacobian, project};

/// In place of a place among shared pixels: one disc alone sees it.
const SEEN_BY_ONE: u32 = u32::MAX;
/// Pixels count up to so many steps from a disc.
const NEAR_STEPS: f64 = 0.75;

/// A pixel of a disc's window.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pixel {
    pub(crate) x: u32,
    shared: u32,
}

impl Pixel {
    /// Its place among the pixels that several discs see.
    pub(crate) fn shared(&self) -> Option<usize> {
        (self.shared != SEEN_BY_ONE).then_some(self.shared as usize)
    }
}

/// A row of a disc's window.
#[derive(Debug, Clone)]
struct Row {
    y: u32,
    pixels: Range<usize>,
}

/// A disc and its rows.
#[derive(Debug, Clone)]
struct Part {
    cell: [i32; 2],
    /// The window's first column, and the one behind its last.
    columns: [usize; 2],
    rows: Range<usize>,
}

/// Discs with their pixels. A pixel that several discs see is in the list of each.
#[derive(Debug, Clone, Default)]
pub(crate) struct SamplePixels {
    parts: Vec<Part>,
    rows: Vec<Row>,
    pixels: Vec<Pixel>,
    /// Pixels that several discs see: column and row.
    pub(crate) shared: Vec<[u32; 2]>,
}

/// Discs as they are when pixels are chosen.
pub(crate) struct Outlines<'a> {
    pub(crate) h: Matrix3<f64>,
    pub(crate) radius: f64,
    pub(crate) sigma: f64,
    /// Pixels up to so far from a disc are taken.
    pub(crate) margin: f64,
    /// One of so many pixels is taken.
    pub(crate) thin: usize,
    /// Whether a place of the grid is left out.
    pub(crate) is_left_out: &'a dyn Fn(Vector2<f64>) -> bool,
}

/// The list while it grows.
struct Growing<'a> {
    outlines: &'a Outlines<'a>,
    back: Matrix3<f64>,
    border: Border,
    size: [usize; 2],
    /// By pixels of the image: whether it counts.
    chosen: Vec<bool>,
    /// By how many discs it is seen.
    seen: Vec<u32>,
    places: SamplePixels,
}

impl Growing<'_> {
    fn window(&self, cell: [i32; 2], margin: f64) -> Option<[[usize; 2]; 2]> {
        let ellipse = Ellipse::of_circle(&self.outlines.h, point(cell), self.outlines.radius)?;
        Some(Blurred::new(ellipse, self.outlines.sigma).window(margin, self.size[0], self.size[1]))
    }

    /// Chooses the pixels about a cell.
    fn choose(&mut self, cell: [i32; 2]) -> Option<()> {
        let outlines = self.outlines;
        let [columns, rows] = self.window(cell, outlines.margin)?;
        let range = self.border.range(
            cell,
            &jacobian(&outlines.h, point(cell)),
            CLEAR * outlines.sigma,
            NEAR_STEPS,
        );
        let takes = |x: usize, y: usize| {
            let place = project(&self.back, Vector2::new(x as f64, y as f64));
            range.holds(&(place - point(cell))) && !(outlines.is_left_out)(place)
        };
        for y in rows[0]..rows[1] {
            for x in columns[0]..columns[1] {
                // x + 2 y spreads a fifth of the pixels by a knight's steps: each row and each column has its part.
                self.chosen[y * self.size[0] + x] |= (x + 2 * y).is_multiple_of(outlines.thin) && takes(x, y);
            }
        }
        Some(())
    }

    /// Lists the chosen pixels that see anything of a cell's disc: where blur is wide beside steps, those of others too.
    fn list(&mut self, cell: [i32; 2]) -> Option<()> {
        // Pixels are chosen within the margin, but a blurred disc reaches farther: other discs' pixels see it.
        // The same reach as the raster's: a disc left out of a pixel's list would be missing in its model.
        let reach = self.outlines.margin.max(REACH * self.outlines.sigma);
        let [columns, rows] = self.window(cell, reach)?;
        let (first, begin) = (self.places.rows.len(), self.places.pixels.len());
        for y in rows[0]..rows[1] {
            let from = self.places.pixels.len();
            for x in columns[0]..columns[1] {
                let at = y * self.size[0] + x;
                if self.chosen[at] {
                    self.seen[at] += 1;
                    let pixel = Pixel {
                        x: x as u32,
                        shared: SEEN_BY_ONE,
                    };
                    self.places.pixels.push(pixel);
                }
            }
            let pixels = from..self.places.pixels.len();
            self.places.rows.push(Row { y: y as u32, pixels });
        }
        // A disc that no chosen pixel sees takes no room.
        if self.places.pixels.len() == begin {
            self.places.rows.truncate(first);
            return Some(());
        }
        let rows = first..self.places.rows.len();
        self.places.parts.push(Part { cell, columns, rows });
        Some(())
    }

    /// Gives pixels that several discs see their places among those.
    fn shared(mut self) -> SamplePixels {
        // From now on, for such pixels, two more than the place, or the greatest number before there is one.
        const SEVERAL: u32 = u32::MAX;
        self.seen.iter_mut().filter(|n| **n > 1).for_each(|n| *n = SEVERAL);
        for row in &self.places.rows {
            for pixel in &mut self.places.pixels[row.pixels.clone()] {
                let seen = &mut self.seen[row.y as usize * self.size[0] + pixel.x as usize];
                if *seen == SEVERAL {
                    *seen = self.places.shared.len() as u32 + 2;
                    self.places.shared.push([pixel.x, row.y]);
                }
                if *seen > 1 {
                    pixel.shared = *seen - 2;
                }
            }
        }
        self.places
    }
}

impl SamplePixels {
    /// The pixels about some cells in an image of a size, with all discs that they see; none where an outline is no ellipse.
    pub(crate) fn new(outlines: &Outlines, some: &[[i32; 2]], all: &[[i32; 2]], size: [usize; 2]) -> Option<Self> {
        let mut growing = Growing {
            outlines,
            back: outlines.h.try_inverse()?,
            border: Border::of(all.iter().copied()),
            size,
            chosen: vec![false; size[0] * size[1]],
            seen: vec![0; size[0] * size[1]],
            places: Self::default(),
        };
        // All are chosen before any is listed: a disc's list holds pixels that its neighbours chose.
        some.iter().try_for_each(|cell| growing.choose(*cell))?;
        all.iter().try_for_each(|cell| growing.list(*cell))?;
        Some(growing.shared())
    }

    /// How many pixels there are.
    pub(crate) fn count(&self) -> usize {
        let alone = self.pixels.iter().filter(|p| p.shared == SEEN_BY_ONE).count();
        alone + self.shared.len()
    }

    /// Shows every pixel of every disc, with what sees it: `begin` tells the outline of a cell and the blur, and what goes
    /// with each of its pixels. None where there is no outline.
    pub(crate) fn visit<T>(
        &self,
        begin: impl Fn([i32; 2]) -> Option<(Ellipse, f64, T)>,
        mut see: impl FnMut(&Raster, &T, Pixel, usize),
    ) -> Option<()> {
        let mut raster = Raster::default();
        for part in &self.parts {
            let (ellipse, sigma, with) = begin(part.cell)?;
            raster.set(ellipse, sigma, part.columns);
            for row in &self.rows[part.rows.clone()] {
                raster.row(row.y as usize);
                let pixels = &self.pixels[row.pixels.clone()];
                pixels.iter().for_each(|p| see(&raster, &with, *p, row.y as usize));
            }
        }
        Some(())
    }

    /// Keeps pixels that stay: of those that one disc sees, in their order, and of those that several do.
    pub(crate) fn retain(&mut self, alone: &[bool], shared: &[bool]) {
        let mut several = Vec::new();
        let mut place = |(stays, at): (&bool, &[u32; 2])| {
            several.extend(stays.then_some(*at));
            stays.then(|| several.len() as u32 - 1)
        };
        let new: Vec<Option<u32>> = shared.iter().zip(&self.shared).map(&mut place).collect();
        self.shared = several;
        // Rows lie in the order of their discs, as `visit` shows them: the flags of single pixels follow it.
        let (mut kept, mut next) = (Vec::with_capacity(self.pixels.len()), alone.iter());
        for row in &mut self.rows {
            let from = kept.len();
            let stays = |p: &Pixel| match p.shared() {
                Some(i) => new[i].map(|shared| Pixel { shared, ..*p }),
                None => next.next().copied().unwrap_or(true).then_some(*p),
            };
            kept.extend(self.pixels[row.pixels.clone()].iter().filter_map(stays));
            row.pixels = from..kept.len();
        }
        self.pixels = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two discs of radius 4 px, 9 px from each other: pixels between them are seen by both, and count once.
    #[test]
    fn pixels_that_two_discs_see_count_once_and_go_once() {
        let outlines = Outlines {
            h: Matrix3::new(9.0, 0.0, 12.0, 0.0, 9.0, 12.0, 0.0, 0.0, 1.0),
            radius: 4.0 / 9.0,
            sigma: 0.5,
            margin: 2.0,
            thin: 1,
            is_left_out: &|_| false,
        };
        let cells = [[0, 0], [1, 0]];
        let mut places = SamplePixels::new(&outlines, &cells, &cells, [40, 30]).unwrap();
        // Windows reach 6 px to each side: columns 6 to 18 and 15 to 27, rows 6 to 18. Three quarters of a step are 6.75 px.
        assert_eq!((places.count(), places.shared.len()), (22 * 13, 4 * 13));
        let mut alone = 0;
        let begin = |cell| Some((Ellipse::of_circle(&outlines.h, point(cell), outlines.radius)?, 0.5, ()));
        let mut twice = vec![0; places.shared.len()];
        let seen = places.visit(begin, |_, (), pixel, _| match pixel.shared() {
            Some(i) => twice[i] += 1,
            None => alone += 1,
        });
        assert_eq!((seen, alone), (Some(()), 18 * 13));
        assert!(twice.iter().all(|n| *n == 2));
        let stays: Vec<bool> = (0..4 * 13).map(|i| i % 2 == 0).collect();
        places.retain(&[true; 18 * 13], &stays);
        assert_eq!((places.count(), places.shared.len()), (20 * 13, 2 * 13));
        places.retain(&[false; 18 * 13], &[true; 2 * 13]);
        assert_eq!(places.count(), 2 * 13);
    }
}
