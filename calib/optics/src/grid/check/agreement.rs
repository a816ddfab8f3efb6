//! A fit of the whole grid with what single discs say of it: whether it is wrong, and how far off its discs may be.

use std::collections::HashMap;

use nalgebra::{Matrix2, SMatrix, Vector2};

use crate::grid::check::misfit::{Misfit, Powers};
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::grid_fit::GridFit;
use crate::grid::fit::lens_fit::{Fitted, Own, agreeing};
use crate::grid::fit::lens_model::{LensModel, Square, plane_tangent};
use crate::grid::fit::lens_polynomial::{RADIAL, Warp};
use crate::grid::homography::project;
use crate::grid::lattice::Cell;
use crate::image::Image;

/// The degree, in column and row, of what is smooth: beside a plane, and beside a lens where there are so many discs.
const PLANE_DEGREE: i32 = 3;
const LENS_DEGREE: i32 = 5;
const LENS_DEGREE_DISCS: usize = 60;

/// A fit and its misfit.
pub(crate) struct Model {
    pub(crate) fit: GridFit,
    kind: Kind,
    /// Of polynomials of column and row.
    smooth: Option<(Powers, Misfit)>,
    /// Discs that are not where the others have them.
    wrong: HashMap<Cell, Vector2<f64>>,
}

enum Kind {
    /// What a lens about the image's middle would leave: a few numbers, which tell a lens that many would hide.
    Plane(Box<(Warp, Option<Misfit>)>),
    Lens(Box<Square>),
}

/// How the first radial fields of a lens move a cell.
fn radial(fit: &GridFit, warp: &Warp, cell: Cell) -> Vec<[f64; 2]> {
    let by = warp.by_numbers(project(&fit.h, point(cell)));
    by[..RADIAL - 1].iter().map(|(value, _)| (*value).into()).collect()
}

fn columns<const N: usize>(matrix: &SMatrix<f64, 2, N>) -> Vec<[f64; 2]> {
    matrix.column_iter().map(|c| [c[0], c[1]]).collect()
}

/// How the model's numbers move a cell.
fn tangent(fit: &GridFit, cell: Cell) -> Vec<[f64; 2]> {
    match &fit.bent {
        Some(bent) => columns(&bent.tangent(cell)),
        None => columns(&plane_tangent(&fit.h, cell)),
    }
}

fn smooth(fit: &GridFit, own: &[Own], degree: i32) -> Option<(Powers, Misfit)> {
    let powers = Powers::new(own, degree);
    let misfit = Misfit::of(own, &|c| powers.at(c), &|c| tangent(fit, c))?;
    Some((powers, misfit))
}

impl Model {
    /// Of a fit without a lens to some discs.
    pub(crate) fn plane(image: &Image, fit: &GridFit, cells: &[Cell]) -> Self {
        // Without what is off by itself: one spot that is no disc would make every plane wrong.
        let own = agreeing(&fit.own(image, cells).unwrap_or_default());
        let warp = LensModel::plane(&fit.h, fit.radius, fit.sigma, image)
            .warp()
            .lens(&Default::default());
        let lens = Misfit::of(&own, &|c| radial(fit, &warp, c), &|c| tangent(fit, c));
        Self {
            smooth: smooth(fit, &own, PLANE_DEGREE),
            kind: Kind::Plane(Box::new((warp, lens))),
            fit: fit.clone(),
            wrong: HashMap::new(),
        }
    }

    /// Of a fit behind a lens.
    pub(crate) fn bent(fit: GridFit, fitted: &Fitted) -> Self {
        let degree = if fitted.own.len() < LENS_DEGREE_DISCS {
            PLANE_DEGREE
        } else {
            LENS_DEGREE
        };
        Self {
            smooth: smooth(&fit, &fitted.own, degree),
            kind: Kind::Lens(Box::new(fitted.covariance)),
            fit,
            wrong: fitted.wrong.clone(),
        }
    }

    fn misfits(&self) -> impl Iterator<Item = &Misfit> {
        let lens = match &self.kind {
            Kind::Plane(lens) => lens.1.as_ref(),
            Kind::Lens(_) => None,
        };
        self.smooth.iter().map(|s| &s.1).chain(lens)
    }

    /// Whether it is wrong beyond doubt.
    pub(crate) fn is_seen(&self) -> bool {
        self.misfits().any(Misfit::is_seen)
    }

    /// Whether single discs have the model itself elsewhere, which its covariance does not hold.
    pub(crate) fn is_off(&self) -> bool {
        self.misfits().any(Misfit::is_off)
    }

    /// The root mean square of what it leaves that goes smoothly over the grid, beyond noise, pixels.
    pub(crate) fn misfit_px(&self) -> f64 {
        self.misfits().map(|m| m.px).fold(0.0, f64::max)
    }

    /// The covariance of a cell's image: the model's, larger where single discs are off by more than their noise, with what the
    /// model leaves there.
    pub(crate) fn covariance(&self, cell: Cell) -> Matrix2<f64> {
        let fit = &self.fit;
        let model = match (&self.kind, &fit.bent) {
            (Kind::Lens(all), Some(bent)) => {
                let slope = bent.tangent(cell);
                // By all numbers together, as the errors of the lens's and of the homography's are correlated.
                slope * **all * slope.transpose()
            }
            _ => {
                let slope = plane_tangent(&fit.h, cell);
                slope * fit.covariance * slope.transpose()
            }
        };
        let off = self.wrong.get(&cell).copied().unwrap_or_default();
        let growth = self.smooth.as_ref().map_or(1.0, |s| s.1.growth());
        let mut left = Matrix2::zeros();
        if let Some((powers, misfit)) = &self.smooth {
            left = misfit.left(cell, &|c| powers.at(c), &|c| tangent(fit, c));
        }
        if let Kind::Plane(lens) = &self.kind
            && let (warp, Some(misfit)) = &**lens
        {
            // Both are parts of the same: the larger counts.
            let by_lens = misfit.left(cell, &|c| radial(fit, warp, c), &|c| tangent(fit, c));
            left = if by_lens.trace() > left.trace() { by_lens } else { left };
        }
        // Single discs' excess is noise that the fit averages as it does the pixels' own; a smooth misfit is not
        // averaged, and adds.
        model * growth + left + off * off.transpose()
    }
}
