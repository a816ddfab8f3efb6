//! Centres disc by disc, where a lens bends the grid.

use std::collections::HashSet;

use nalgebra::Vector2;

use super::blob::Blob;
use super::error::GridRefused;
use super::find::missing;
use super::found::{Found, GridDisc, GridSpec, Refinement};
use super::homography::{homography, jacobian, project};
use super::lattice::Cell;
use super::place::Placed;
use super::whole::point;
use crate::disc::{DiscFit, Ellipse, fit_disc};
use crate::image::Image;

/// What a single disc's fit says, with where it belongs.
struct One {
    cell: Cell,
    fit: DiscFit,
    mark: bool,
}

/// Fits every disc of a placed lattice by itself and corrects the perspective of each.
pub(crate) fn refine(
    image: &Image,
    spec: &GridSpec,
    blobs: &[Blob],
    placed: &Placed,
    marks: &HashSet<Cell>,
    candidates: usize,
) -> Result<Found, GridRefused> {
    let mut cells: Vec<(Cell, usize)> = placed.cells.iter().map(|(c, i)| (*c, *i)).collect();
    cells.sort_unstable();
    let one = |(cell, i): (Cell, usize)| {
        let blob = &blobs[i];
        let start = Ellipse {
            centre: blob.at,
            shape: blob.shape,
        };
        // The neighbours' edges lie a pitch less two radii away; half of that is this disc's.
        let pitch = jacobian(&placed.h, point(cell)).singular_values().min();
        let margin = (0.5 * (pitch - 2.0 * start.axes().semi[0])).clamp(2.0, 8.0);
        let fit = fit_disc(image, &start, 1.2, margin).ok()?;
        let mark = marks.contains(&cell);
        Some(One { cell, fit, mark })
    };
    let ones: Vec<One> = cells.into_iter().filter_map(one).collect();
    let discs = spec.cols * spec.rows;
    let needed = (0.6 * discs as f64).ceil() as usize;
    let few = GridRefused::TooFew {
        found: ones.len(),
        discs,
        needed,
    };
    if ones.len() < needed {
        return Err(few);
    }
    let first = [placed.span[0][0], placed.span[1][0]];
    let at = |one: &One| point([one.cell[0] - first[0], one.cell[1] - first[1]]);
    let pairs: Vec<_> = ones.iter().map(|o| (at(o), o.fit.ellipse.centre)).collect();
    let h = homography(&pairs).ok_or(few)?;
    Ok(assembled(spec, &ones, h, at, candidates))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn assembled(
    spec: &GridSpec,
    ones: &[One],
    h: nalgebra::Matrix3<f64>,
    at: impl Fn(&One) -> Vector2<f64>,
    candidates: usize,
) -> Found {
    let radius_of = |o: &One| o.fit.ellipse.mean_radius() / jacobian(&h, at(o)).determinant().abs().sqrt();
    let small = || ones.iter().filter(|o| !o.mark);
    let radius = median(small().map(radius_of).collect());
    let mut squares = 0.0;
    let mut discs: Vec<GridDisc> = Vec::new();
    for one in ones {
        let place = at(one);
        let bias =
            Ellipse::of_circle(&h, place, radius_of(one)).map_or(Vector2::zeros(), |e| e.centre - project(&h, place));
        let centre = one.fit.ellipse.centre - bias;
        squares += (centre - project(&h, place)).norm_squared();
        let (col, row) = (place.x as usize, place.y as usize);
        discs.push(GridDisc {
            col,
            row,
            at: centre,
            covariance: one.fit.covariance,
            mark: one.mark,
        });
    }
    discs.sort_by_key(|d| (d.row, d.col));
    Found {
        missing: missing(&discs, spec),
        homography: h,
        radius,
        sigma: median(small().map(|o| o.fit.sigma).collect()),
        noise: median(small().map(|o| o.fit.noise).collect()),
        homography_rms_px: (squares / discs.len() as f64).sqrt(),
        refinement: Refinement::Each,
        candidates,
        discs,
    }
}
