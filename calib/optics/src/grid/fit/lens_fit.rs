//! One fit of the whole grid to the pixels through a lens: homography, what the lens moves, radius and blur for all discs,
//! and to each disc a grey of its own.

use std::collections::HashMap;

use fit::median;
use nalgebra::{Matrix2, Vector2};

use crate::disc::Ellipse;
use crate::grid::check::own_pixels::{Block, Chosen, Greys, Guess, OwnPixels, Part, Room};
use crate::grid::fit::contrast::light;
use crate::grid::fit::lens_model::{
    BLUR, LensModel, MAX_STEPS, NUMBERS, Numbers, Slopes, Square, inverse, prior, step,
};
use crate::grid::fit::normal_equations::LEAST_BLUR;
use crate::grid::lattice::Cell;
use crate::image::Image;

/// A step that is to gain less of chi squared is the last.
const LAST_GAIN_CHI2: f64 = 0.1;
/// A step that is held back by no more of the diagonal goes along all but what nothing is known of: a lens's middle and its
/// tangential fields do nearly the same.
const FREE_DAMPING: f64 = 1e-10;
/// Pixels up to so many deviations of the blur and a half from a disc are fitted.
const MARGIN_DEVIATIONS: f64 = 2.5;
/// Of all discs the most that may be left out as no part of the grid, and how far off they are.
// Squares: six deviations, or four times as far as the usual disc.
const WRONG_DISCS: [f64; 2] = [36.0, 16.0];
/// One of so many pixels is enough to come near.
const THIN: Part = Part::Pixels(5);
/// Shares of the contrast by which pixels may be off, from coming near to the end.
const MODEL_ERRORS_CONTRAST: [f64; 3] = [0.5, 0.15, 0.08];

/// What a fit ends with.
pub(crate) struct Fitted {
    pub(crate) bent: LensModel,
    pub(crate) covariance: Square,
    pub(crate) noise: f64,
    /// Each disc, its centre's offset from the fit and the information of that.
    pub(crate) own: Vec<Own>,
    /// Discs that are not where the others have them, and how far off they are.
    pub(crate) wrong: HashMap<Cell, Vector2<f64>>,
    pub(crate) greys: Vec<(Vector2<f64>, Greys)>,
}

/// What a disc's own pixels say of its centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Own {
    pub(crate) cell: Cell,
    pub(crate) off: Vector2<f64>,
    /// Inverse covariance of `off`.
    pub(crate) information: Matrix2<f64>,
}

/// What is fitted, and in which image.
pub(crate) struct LensFit<'a> {
    pub(crate) image: &'a Image,
    pub(crate) bright: bool,
}

/// Everything at one set of numbers.
struct Total {
    matrix: Square,
    vector: Numbers,
    squares: f64,
    pixels: usize,
    blocks: Vec<Block>,
    slopes: Vec<Slopes>,
}

impl Total {
    /// The residuals' variance.
    fn variance(&self) -> f64 {
        // Each disc's four greys are eliminated from the equations, not from the degrees of freedom.
        let numbers = NUMBERS + 4 * self.blocks.len();
        // Rounding to whole steps has the variance 1/12: drawn images without noise have no less.
        (self.squares / self.pixels.saturating_sub(numbers).max(1) as f64).max(1.0 / 12.0)
    }
}

impl LensFit<'_> {
    /// A coarse fit from what is known to a part of a disc.
    pub(crate) fn fit_coarse(&self, start: &LensModel, cells: &[Cell]) -> Option<Fitted> {
        let first = self.phase(start, cells, MODEL_ERRORS_CONTRAST[0], THIN)?;
        self.phase(&first.bent, cells, MODEL_ERRORS_CONTRAST[1], THIN)
    }

    /// The fit again from one to nearly the same discs, to a part of what is to be seen.
    pub(crate) fn nearer(&self, from: &LensModel, cells: &[Cell]) -> Option<Fitted> {
        self.phase(from, cells, MODEL_ERRORS_CONTRAST[2], THIN)
    }

    /// The fit to all that is to be seen, without discs that are none of the grid.
    pub(crate) fn refit(&self, from: &LensModel, cells: &[Cell]) -> Option<Fitted> {
        let fitted = self.phase(from, cells, MODEL_ERRORS_CONTRAST[2], Part::All)?;
        let kept = fitted.agreeing();
        if kept.len() == fitted.own.len() {
            return Some(fitted);
        }
        let last = self.phase(&fitted.bent, &kept, MODEL_ERRORS_CONTRAST[2], Part::All)?;
        let left_out = fitted.own.iter().filter(|o| !kept.contains(&o.cell));
        // Where its own pixels had it in the fit that it was part of, beside the fit that it has no say in.
        let off = |o: &Own| (o.cell, fitted.bent.at(o.cell) + o.off - last.bent.at(o.cell));
        let wrong = left_out.map(off).collect();
        Some(Fitted { wrong, ..last })
    }

    /// The least squares of some pixels.
    ///
    /// An iteration of its own beside [`fit::least_squares`]: greys follow each look, and a small step that was held back is made
    /// again with next to no damping, which belongs to no rule of damping.
    fn phase(&self, start: &LensModel, cells: &[Cell], cut: f64, part: Part) -> Option<Fitted> {
        let (mut local, cells, mut greys) = self.chosen(start, cells, part)?;
        self.reject_outliers(&mut local, start, &cells, &greys, cut)?;
        let mut bent = start.clone();
        let prior = prior(cells.len());
        let mut now = self.total(&local, &bent, &cells, &greys)?;
        let variance = now.variance();
        let held = |b: &LensModel| b.numbers.component_mul(&b.numbers).dot(&prior) * variance;
        let (mut damping, mut rise) = (1e-4, 4.0);
        for _ in 0..MAX_STEPS {
            // Slopes of outlines go with the contrast, and neighbours are taken out with theirs: the best that were
            // found count from now on.
            greys = now.blocks.iter().map(|b| b.greys).collect();
            // The squares are in grey levels: the prior, in units of the numbers, is made comparable by the
            // variance.
            let matrix = now.matrix + Square::from_diagonal(&(prior * variance));
            let vector = now.vector - prior.component_mul(&bent.numbers) * variance;
            let Some((change, expected)) = next(&bent, &matrix, &vector, damping) else {
                damping *= 10.0;
                continue;
            };
            let Some(then) = bent.moved(&change, &cells) else {
                damping *= 10.0;
                continue;
            };
            let possible = then.is_possible(&cells);
            if possible && expected < LAST_GAIN_CHI2 * variance {
                if damping <= FREE_DAMPING {
                    // Derivatives of where it ends: what the lens's middle and the homography do alike is another mixture at each place, and
                    // one of the place before says nothing of that.
                    let now = self.total(&local, &then, &cells, &greys)?;
                    return self.result(&then, &cells, &now, &prior);
                }
                // Held back, a step says little of where numbers that go together would go.
                damping = FREE_DAMPING;
                continue;
            }
            let cost = now.squares + held(&bent);
            let total = possible.then(|| self.total(&local, &then, &cells, &greys)).flatten();
            match total {
                // A cost that is not a number fails the comparison and raises the damping.
                Some(total) if total.squares + held(&then) <= cost => {
                    let gained = cost - total.squares - held(&then);
                    // By how well the step did what was expected of it (Nielsen 1999).
                    let factor = 1.0 - (2.0 * gained / expected.max(f64::MIN_POSITIVE) - 1.0).powi(3);
                    // A step that gains much more than was expected would make the factor negative.
                    damping = (damping * factor.clamp(0.02, 2.0)).max(FREE_DAMPING);
                    (bent, now, rise) = (then, total, 4.0);
                    // Edges sharper than pixels leave what the model cannot follow: each step gains a little of that,
                    // and none ends it.
                    if bent.sigma() <= LEAST_BLUR && gained < 0.01 * cost {
                        break;
                    }
                }
                _ => {
                    damping *= rise;
                    rise *= 2.0;
                }
            }
            if damping > 1e5 {
                break;
            }
        }
        self.result(&bent, &cells, &now, &prior)
    }

    /// The pixels of discs that are seen where they are expected, and those discs with their greys.
    fn chosen(&self, start: &LensModel, cells: &[Cell], part: Part) -> Option<(OwnPixels<'_>, Vec<Cell>, Vec<Greys>)> {
        let whole = |c: &Cell| {
            self.image
                .holds(start.at(*c))
                .then(|| start.outline(*c))
                .flatten()
                .map(|o| (*c, o))
        };
        let mut all: Vec<(Cell, Ellipse)> = cells.iter().filter_map(whole).collect();
        loop {
            let chosen: Vec<Chosen> = all
                .iter()
                .map(|(cell, outline)| Chosen {
                    cell: *cell,
                    outline: *outline,
                    pitch: start.pitch(*cell),
                })
                .collect();
            let margin = MARGIN_DEVIATIONS * start.sigma() + 0.5;
            // No distance is kept from the paper's end: its blurred edge is in the plane of grey that each disc has
            // here.
            let local = OwnPixels::new(self.image, &chosen, start.sigma(), margin, 0.0, part)?;
            let outlines: Vec<Ellipse> = all.iter().map(|a| a.1).collect();
            let none = vec![Greys::default(); all.len()];
            let flat = Guess {
                outlines: &outlines,
                sigma: start.sigma(),
                greys: &none,
            };
            let mut room = Room::default();
            let greys: Vec<Option<Greys>> = (0..local.count())
                // Without any greys yet a residual is the sample itself: no limit can tell which are off.
                .map(|i| local.block(i, &flat, f64::INFINITY, &mut room).map(|b| b.greys))
                .collect();
            let seen = |g: &Greys| if self.bright { g.contrast } else { -g.contrast };
            let usual = median(greys.iter().flatten().map(seen).collect());
            // Discs much fainter or stronger than most are glare, dirt or no discs; without them the usual contrast is another
            // one.
            let good = |g: &Option<Greys>| g.is_some_and(|g| seen(&g) > 0.3 * usual && seen(&g) < 2.0 * usual);
            // A lens has as many numbers as this: with fewer discs it would fit whatever they are.
            if usual <= 0.0 || 2 * all.len() < NUMBERS + 4 {
                return None;
            }
            if greys.iter().all(good) {
                let (cells, centres): (Vec<Cell>, Vec<_>) = all.iter().map(|(c, o)| (*c, o.centre)).unzip();
                let mut seen: Vec<_> = centres.into_iter().zip(greys.into_iter().flatten()).collect();
                let light = light(&seen)?;
                seen.iter_mut().for_each(|(at, g)| g.change = light.change(*at));
                return Some((local, cells, seen.into_iter().map(|s| s.1).collect()));
            }
            // At least one disc goes in each round, so that the loop ends.
            let mut stays = greys.iter().map(good);
            all.retain(|_| stays.next().unwrap_or(true));
        }
    }

    fn outlines(bent: &LensModel, cells: &[Cell]) -> Option<Vec<Ellipse>> {
        cells.iter().map(|c| bent.outline(*c)).collect()
    }

    /// Leaves out pixels that are farther off than noise and outlines can be.
    fn reject_outliers(
        &self,
        local: &mut OwnPixels,
        bent: &LensModel,
        cells: &[Cell],
        greys: &[Greys],
        cut: f64,
    ) -> Option<()> {
        let outlines = Self::outlines(bent, cells)?;
        let all = Guess {
            outlines: &outlines,
            sigma: bent.sigma(),
            greys,
        };
        let mut room = Room::default();
        let off: Vec<Vec<f64>> = (0..local.count())
            .map(|i| local.residuals(i, &all, &mut room))
            .collect();
        // Five deviations by the median of normal noise, over all discs: one that is wholly wrong must not make a
        // measure of its own.
        let least = 5.0 * 1.4826 * median(off.iter().flatten().map(|r| r.abs()).collect());
        for (i, off) in off.iter().enumerate() {
            // By each disc's own contrast, as light falls off: a model's error goes with the contrast.
            let most = least.max(cut * greys[i].contrast.abs());
            let stays: Vec<bool> = off.iter().map(|r| r.abs() <= most).collect();
            if stays.iter().any(|s| !s) {
                local.retain(i, &stays);
            }
        }
        Some(())
    }

    fn total(&self, local: &OwnPixels, bent: &LensModel, cells: &[Cell], greys: &[Greys]) -> Option<Total> {
        let outlines = Self::outlines(bent, cells)?;
        let all = Guess {
            outlines: &outlines,
            sigma: bent.sigma(),
            greys,
        };
        let mut room = Room::default();
        let mut total = Total {
            matrix: Square::zeros(),
            vector: Numbers::zeros(),
            squares: 0.0,
            pixels: 0,
            blocks: Vec::with_capacity(cells.len()),
            slopes: Vec::with_capacity(cells.len()),
        };
        // Each disc's own greys were eliminated in its block: the fit has the numbers of the lens alone.
        for (i, cell) in cells.iter().enumerate() {
            let block = local.block(i, &all, f64::INFINITY, &mut room)?;
            // The chain rule from the outline's six numbers to those of the whole grid.
            let slopes = bent.slopes(*cell)?;
            total.matrix += slopes.transpose() * block.matrix * slopes;
            total.vector += slopes.transpose() * block.vector;
            total.squares += block.squares;
            total.pixels += block.pixels;
            total.blocks.push(block);
            total.slopes.push(slopes);
        }
        Some(total)
    }

    fn result(&self, bent: &LensModel, cells: &[Cell], now: &Total, prior: &Numbers) -> Option<Fitted> {
        let variance = now.variance();
        let covariance = inverse(&(now.matrix + Square::from_diagonal(&(prior * variance))))? * variance;
        let own = |(i, cell): (usize, &Cell)| {
            let block = &now.blocks[i];
            own(*cell, &block.vector.fixed_rows::<2>(0).into_owned(), block, variance)
        };
        let own: Option<Vec<Own>> = cells.iter().enumerate().map(own).collect();
        let greys = cells.iter().zip(&now.blocks).map(|(c, b)| (bent.at(*c), b.greys));
        Some(Fitted {
            bent: bent.clone(),
            covariance,
            noise: variance.sqrt(),
            own: own?,
            wrong: HashMap::new(),
            greys: greys.collect(),
        })
    }
}

/// A disc's own offset by what its pixels leave.
pub(crate) fn own(cell: Cell, left: &Vector2<f64>, block: &Block, variance: f64) -> Option<Own> {
    // Shape and blur stay as the whole fit has them: only the centre is asked for.
    let matrix: Matrix2<f64> = block.matrix.fixed_view::<2, 2>(0, 0).into_owned();
    let inverse = matrix.cholesky()?.inverse();
    Some(Own {
        cell,
        off: inverse * left,
        information: matrix / variance,
    })
}

impl Own {
    /// Its square beside its own deviation.
    pub(crate) fn squared(&self) -> f64 {
        (self.off.transpose() * self.information * self.off)[0]
    }
}

impl Fitted {
    /// Discs that lie where the others have them, or about as far off as most.
    fn agreeing(&self) -> Vec<Cell> {
        agreeing(&self.own).iter().map(|o| o.cell).collect()
    }
}

/// Those that are not much farther off than others.
pub(crate) fn agreeing(own: &[Own]) -> Vec<Own> {
    let usual = median(own.iter().map(Own::squared).collect());
    let most = WRONG_DISCS[0].max(WRONG_DISCS[1] * usual);
    own.iter().filter(|o| o.squared() <= most).copied().collect()
}

/// Where a step leads; a blur that would fall below the least is held there.
fn next(bent: &LensModel, matrix: &Square, vector: &Numbers, damping: f64) -> Option<(Numbers, f64)> {
    let (change, expected) = step(matrix, vector, damping, false)?;
    if bent.sigma() + change[BLUR] >= LEAST_BLUR {
        return Some((change, expected));
    }
    let (mut change, expected) = step(matrix, vector, damping, true)?;
    change[BLUR] = LEAST_BLUR - bent.sigma();
    Some((change, expected))
}
