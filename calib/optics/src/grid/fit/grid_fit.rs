//! One fit of the whole grid to the pixels: homography, radius, blur, and planes of grey for discs and paper.

use std::collections::HashSet;

use fit::{Damping, End, Limits, Made, Rule, Step, least_squares, median};
use nalgebra::{Matrix3, SMatrix, SVector, Vector2};

use crate::disc::{Coverage, Ellipse};
use crate::grid::fit::disc_jacobian::{ellipse_slopes, point};
use crate::grid::fit::lens_model::LensModel;
use crate::grid::fit::normal_equations::{BLUR, Equations, LEAST_BLUR, N, Params, SHAPES, Sums, inverse, step};
use crate::grid::fit::sample_pixels::{Outlines, Pixel, SamplePixels};
use crate::grid::homography::{jacobian, project};
use crate::image::Image;

const MAX_STEPS: usize = 25;
/// Of the normal equations, as [`step`] holds back.
const DAMPING: Damping = Damping {
    start: 1e-3,
    rule: Rule::Factors {
        fall: 0.1,
        least: 1e-10,
        rise: 10.0,
        raised: 0.0,
    },
    most: 1e5,
    singular: true,
};
/// More damping than this makes a step short however far the end is.
const MOST_AT_END: f64 = 0.1;
/// A step that is to leave less of chi squared to gain is the last: 0.1 is a third of a deviation of all parameters
/// together.
const LAST_GAIN_CHI2: f64 = 0.1;
/// Pixels up to so many deviations of the blur and a half from a disc are fitted.
// At 2.5 deviations a blurred straight edge has 0.6 % of its contrast left: farther pixels tell grey alone.
pub(crate) const MARGIN_DEVIATIONS: f64 = 2.5;
/// The share of the contrast that the model may be wrong by.
pub(crate) const MODEL_ERROR_CONTRAST: f64 = 0.08;
/// One of so many discs is enough to come near, and one of so many pixels where there are fewer discs than [`THIN_BY_DISCS_FROM`].
const THIN_PART: usize = 5;
const THIN_BY_DISCS_FROM: usize = 50;
/// At the least blur edges are sharper than pixels, which the model cannot follow: a step that gains less of what is left,
/// which is no noise, is the last.
const SHARP_GAIN: f64 = 0.01;
/// The unit of the planes of grey, pixels.
pub(crate) const SLOPE_UNIT_PX: f64 = 100.0;

/// A grid as its pixels show it.
#[derive(Debug, Clone)]
pub(crate) struct GridFit {
    /// From columns and rows to pixels.
    pub(crate) h: Matrix3<f64>,
    /// A disc's radius, steps of the grid.
    pub(crate) radius: f64,
    /// The blur's deviation, pixels.
    pub(crate) sigma: f64,
    /// Paper less disc at a place, steps of a sample: value, slopes per 100 px about `origin`.
    pub(crate) contrast: [f64; 3],
    pub(crate) origin: Vector2<f64>,
    /// The residuals' deviation, steps of a sample.
    pub(crate) noise: f64,
    /// Covariance of the eight entries of `h`, row by row.
    pub(crate) covariance: SMatrix<f64, 8, 8>,
    pub(crate) params: Params,
    /// The lens that the discs are seen through, where there is one.
    pub(crate) bent: Option<LensModel>,
}

/// What is fitted, and where.
pub(crate) struct Grid<'a> {
    pub(crate) image: &'a Image,
    pub(crate) cells: &'a [[i32; 2]],
    /// Places of large discs: pixels nearest to them are left out.
    pub(crate) marks: &'a HashSet<[i32; 2]>,
    pub(crate) bright: bool,
}

/// Which pixels are looked at.
struct Pixels {
    /// Those of a fifth of the discs, or a fifth of the pixels where there are few discs.
    thin: bool,
    /// Those that are farther off than this share of the contrast, and than noise is, are left out.
    cut: f64,
    /// Where the planes of grey have their values.
    origin: Vector2<f64>,
}

fn homography_of(p: &Params) -> Matrix3<f64> {
    Matrix3::new(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], 1.0)
}

/// How much of discs a pixel sees, behind the derivatives of that by the first [`SHAPES`] parameters.
type Seen = [f64; SHAPES + 1];

impl Grid<'_> {
    /// Comes near from a homography, a radius in steps of the grid, and a blur in pixels, by a fifth of what there is to be
    /// seen. None where it does not settle on a grid that stands out.
    pub(crate) fn near(&self, h: &Matrix3<f64>, radius: f64, sigma: f64) -> Option<GridFit> {
        let mut params = Params::zeros();
        // Cell (0, 0) is the lattice's seed, which lies in the image: its depth, this entry, does not vanish.
        let h = h / h[(2, 2)];
        (0..8).for_each(|k| params[k] = h[(k / 3, k % 3)]);
        (params[8], params[9]) = (radius, sigma);
        // About the middle of the grid the planes' values and slopes are hardly correlated.
        let origin = self.cells.iter().map(|c| project(&h, point(*c))).sum::<Vector2<f64>>() / self.cells.len() as f64;
        let phase = |cut: f64| Pixels {
            thin: true,
            cut,
            origin,
        };
        // With all greys at 0 the residuals are the samples themselves, and one linear solution gives the planes.
        let greys = self.greys(&params, &phase(1.0))?;
        params.fixed_rows_mut::<6>(SHAPES).copy_from(&greys);
        // What is no part of the model counts less from phase to phase: first outlines are half a pixel off.
        let (params, _) = self.settled(params, phase(0.5))?;
        let (params, now) = self.settled(params, phase(0.15))?;
        self.result(&params, &now, origin)
    }

    /// The planes of grey for the outlines given.
    fn greys(&self, params: &Params, pixels: &Pixels) -> Option<SVector<f64, 6>> {
        self.equations(&self.places(params, pixels)?, params, pixels)?.greys()
    }

    /// The fit again from one to nearly the same discs, to all that is to be seen or to a fifth of it.
    pub(crate) fn refit(&self, from: &GridFit, thin: bool) -> Option<GridFit> {
        let pixels = Pixels {
            thin,
            cut: MODEL_ERROR_CONTRAST,
            origin: from.origin,
        };
        let (params, now) = self.settled(from.params, pixels)?;
        self.result(&params, &now, from.origin)
    }

    /// The least squares of some pixels, and the equations there.
    ///
    /// Pixels that are far off at the start (glare, dirt, spots that are no discs) are left out from then on.
    fn settled(&self, start: Params, pixels: Pixels) -> Option<(Params, Equations)> {
        let mut places = self.places(&start, &pixels)?;
        self.clean(&mut places, &start, &pixels)?;
        let chosen = Chosen {
            grid: self,
            places: &places,
            pixels: &pixels,
        };
        let limits = Limits {
            flat: 1.0,
            ..Limits::tries(MAX_STEPS)
        };
        let mut end = least_squares(&chosen, start, DAMPING, limits)?;
        // On its way yet: its covariance would be that of a place where the least is not.
        if end.end == End::OutOfSteps {
            return None;
        }
        // A last step is made without a look: the squares are those before it, less what the linear model lets them
        // fall by.
        if end.end == End::Last {
            end.at.squares -= end.gain;
        }
        Some((end.state, end.at))
    }

    /// How far outlines go from one set of parameters to another, beside the blur: so much of a step is not linear.
    fn motion(&self, from: &Params, to: &Params) -> f64 {
        let (a, b) = (homography_of(from), homography_of(to));
        let one = |cell: &[i32; 2]| {
            let at = point(*cell);
            let pitch = jacobian(&a, at).determinant().abs().sqrt();
            (project(&b, at) - project(&a, at)).norm() + pitch * (to[8] - from[8]).abs()
        };
        // The most over the discs, not the mean: one outline that moves by more than its blur is enough for a step that
        // is not linear.
        let most = self.cells.iter().map(one).fold(0.0, f64::max);
        (most + (to[9] - from[9]).abs()) / from[9]
    }

    fn result(&self, params: &Params, now: &Equations, origin: Vector2<f64>) -> Option<GridFit> {
        // `equations` refuses 2 N pixels and fewer: degrees of freedom are left.
        let noise = (now.squares / (now.pixels.checked_sub(N)? as f64)).sqrt();
        // Grey levels are whole numbers: residuals below the deviation of their rounding do not make the fit more certain.
        let covariance = inverse(&now.matrix)? * (noise * noise).max(1.0 / 12.0);
        // A step of the discs' grey: contrast is that of the paper less the discs, positive for dark ones.
        let contrast = [0, 1, 2].map(|k| -params[SHAPES + k]);
        let right = if self.bright {
            contrast[0] < 0.0
        } else {
            contrast[0] > 0.0
        };
        right.then(|| GridFit {
            h: homography_of(params),
            radius: params[8],
            sigma: params[9],
            contrast,
            origin,
            noise,
            covariance: covariance.fixed_view::<8, 8>(0, 0).into_owned(),
            params: *params,
            bent: None,
        })
    }

    /// Which pixels count is up to the start: were it up to the parameters, smaller discs would leave out residuals.
    fn places(&self, start: &Params, pixels: &Pixels) -> Option<SamplePixels> {
        let by_discs = pixels.thin && self.cells.len() >= THIN_BY_DISCS_FROM;
        let without = |place: Vector2<f64>| {
            !self.marks.is_empty() && self.marks.contains(&[place.x.round() as i32, place.y.round() as i32])
        };
        let outlines = Outlines {
            h: homography_of(start),
            radius: start[8],
            sigma: start[9],
            margin: MARGIN_DEVIATIONS * start[9] + 0.5,
            thin: if pixels.thin && !by_discs { THIN_PART } else { 1 },
            without: &without,
        };
        // Steps of a knight: of any 5 in a row or a column one, so that all parts of the grid count.
        let some = |c: &&[i32; 2]| !by_discs || (c[0] + 2 * c[1]).rem_euclid(THIN_PART as i32) == 0;
        let cells: Vec<[i32; 2]> = self.cells.iter().filter(some).copied().collect();
        SamplePixels::new(&outlines, &cells, self.cells, [self.image.width(), self.image.height()])
    }

    fn equations(&self, places: &SamplePixels, params: &Params, pixels: &Pixels) -> Option<Equations> {
        let (h, mut sums) = (homography_of(params), Sums::default());
        // Discs are visited one by one: what a pixel sees of several is whole only after the last.
        let mut shared = vec![[0.0; SHAPES + 1]; places.shared.len()];
        let begin = |cell: [i32; 2]| {
            let ellipse = Ellipse::of_circle(&h, point(cell), params[8])?;
            Some((ellipse, params[9], ellipse_slopes(&h, point(cell), params[8])))
        };
        places.visit(begin, |raster, slopes, pixel, y| {
            let x = pixel.x as usize;
            let mut alone = [0.0; SHAPES + 1];
            // Discs do not overlap, so that what a pixel sees of several is their sum.
            let values = pixel.shared().map_or(&mut alone, |i| &mut shared[i]);
            add(values, &raster.at(x), slopes);
            if pixel.shared().is_none() {
                self.sum(&mut sums, params, pixels, &alone, [x, y]);
            }
        })?;
        for (values, at) in shared.iter().zip(&places.shared) {
            self.sum(&mut sums, params, pixels, values, at.map(|k| k as usize));
        }
        let out = sums.equations(places.count());
        // Fewer residuals than twice the parameters tell next to nothing of the noise.
        (out.pixels > 2 * N).then_some(out)
    }

    fn sum(&self, sums: &mut Sums, params: &Params, pixels: &Pixels, values: &Seen, at: [usize; 2]) {
        let (place, f) = (pixels.place(at), values[SHAPES]);
        let (disc, residual) = self.residual(params, &place, f, at);
        // The model is paper + disc f: it goes with f along the disc's plane, with 1 along the paper's.
        let greys = [f, f * place[1], f * place[2], 1.0, place[1], place[2]];
        sums.add(&values[..SHAPES], disc, &greys, residual);
    }

    /// Grey of the disc less the paper at a place, and the pixel less the model.
    fn residual(&self, params: &Params, place: &[f64; 3], f: f64, [x, y]: [usize; 2]) -> (f64, f64) {
        let plane = |k: usize| (0..3).map(|i| params[k + i] * place[i]).sum::<f64>();
        let (disc, paper) = (plane(SHAPES), plane(SHAPES + 3));
        (disc, f64::from(self.image.sample(x, y)) - paper - disc * f)
    }

    /// Leaves out pixels that are farther off than noise and outlines can be.
    fn clean(&self, places: &mut SamplePixels, params: &Params, pixels: &Pixels) -> Option<()> {
        let h = homography_of(params);
        let off = |f: f64, at: [usize; 2]| self.residual(params, &pixels.place(at), f, at).1.abs();
        let (mut shared, mut alone) = (vec![0.0; places.shared.len()], Vec::new());
        let begin = |cell: [i32; 2]| Some((Ellipse::of_circle(&h, point(cell), params[8])?, params[9], ()));
        places.visit(begin, |raster, (), pixel: Pixel, y| {
            let x = pixel.x as usize;
            match pixel.shared() {
                Some(i) => shared[i] += raster.value(x),
                None => alone.push(off(raster.value(x), [x, y])),
            }
        })?;
        let several = shared.iter().zip(&places.shared);
        let shared: Vec<f64> = several.map(|(f, at)| off(*f, at.map(|k| k as usize))).collect();
        // 5 deviations, by the median of normal noise.
        let median = median(alone.iter().chain(&shared).copied().collect());
        // The share of the contrast keeps what only the outlines, wrong as yet, put off: those pixels are what moves
        // them.
        let cut = (5.0 * 1.4826 * median).max(pixels.cut * params[SHAPES].abs());
        if alone.iter().chain(&shared).any(|r| *r > cut) {
            let stays = |off: &[f64]| off.iter().map(|r| *r <= cut).collect::<Vec<bool>>();
            places.retain(&stays(&alone), &stays(&shared));
        }
        Some(())
    }
}

/// Adds what a pixel sees of a disc whose outline has the slopes given.
fn add(values: &mut Seen, coverage: &Coverage, slopes: &[[f64; 9]; 5]) {
    values[SHAPES] += coverage.value;
    values[9] += coverage.slope[5];
    // Farther from the edge than the blur reaches a coverage has no slopes, and most pixels lie there.
    if coverage.slope[..5].iter().any(|s| *s != 0.0) {
        for (slope, row) in coverage.slope.iter().zip(slopes) {
            (0..9).for_each(|k| values[k] += slope * row[k]);
        }
    }
}

impl Pixels {
    fn place(&self, [x, y]: [usize; 2]) -> [f64; 3] {
        [
            1.0,
            (x as f64 - self.origin.x) / SLOPE_UNIT_PX,
            (y as f64 - self.origin.y) / SLOPE_UNIT_PX,
        ]
    }
}

/// A grid's pixels that count.
struct Chosen<'a> {
    grid: &'a Grid<'a>,
    places: &'a SamplePixels,
    pixels: &'a Pixels,
}

impl fit::Problem for Chosen<'_> {
    type State = Params;
    type At = Equations;

    fn look(&self, params: &Params) -> Option<(f64, Equations)> {
        let equations = self.grid.equations(self.places, params, self.pixels)?;
        Some((equations.squares, equations))
    }

    fn step(&self, params: &Params, now: &Equations, damping: f64) -> Option<Step<Params>> {
        let (to, gain) = next(params, now, damping)?;
        let length = self.grid.motion(params, &to);
        is_possible(&to).then_some(Step { to, length, gain })
    }

    /// So small a step is as good as what it leads to: what is left goes with its square beside the blur's.
    /// A step that damping alone made short gains little, too, and says nothing of what is left.
    fn is_last(&self, step: &Step<Params>, now: &Equations, damping: f64) -> bool {
        if damping > MOST_AT_END {
            return false;
        }
        let left = step.gain * step.length.powi(2).min(1.0);
        left < LAST_GAIN_CHI2 * now.squares / now.pixels as f64
    }

    fn is_settled(&self, made: &Made<'_, Params, Equations>) -> bool {
        made.state[BLUR] <= LEAST_BLUR && 1.0 - made.to / made.from < SHARP_GAIN
    }
}

/// Where a step leads, and by how much the squares fall with it were the model linear. A blur that would fall below the least
/// is held there: it creeps there otherwise, by less from step to step.
fn next(params: &Params, now: &Equations, damping: f64) -> Option<(Params, f64)> {
    let (change, expected) = step(now, damping, false)?;
    if params[BLUR] + change[BLUR] >= LEAST_BLUR {
        return Some((params + change, expected));
    }
    let (change, expected) = step(now, damping, true)?;
    let mut next = params + change;
    next[BLUR] = LEAST_BLUR;
    Some((next, expected))
}

fn is_possible(p: &Params) -> bool {
    // Discs whose radius is half a pitch touch: beyond, what a pixel sees of several is no longer their sum.
    (0.02..0.5).contains(&p[8]) && (LEAST_BLUR..50.0).contains(&p[BLUR]) && p.iter().all(|v| v.is_finite())
}
