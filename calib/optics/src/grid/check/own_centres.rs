//! Where a fit of the whole has each disc, and what the disc's own pixels say of that.

use nalgebra::Vector2;

use crate::disc::Ellipse;
use crate::grid::check::own_pixels::{Chosen, Greys, Guess, OwnPixels, Part, Room};
use crate::grid::fit::contrast::light;
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::grid_fit::{GridFit, MARGIN_DEVIATIONS, MODEL_ERROR_CONTRAST, SLOPE_UNIT_PX};
use crate::grid::fit::lens_fit::{Fitted, Own, own};
use crate::grid::fit::normal_equations::{DISC, PAPER, Params};
use crate::grid::fit::paper_edge::CLEAR;
use crate::grid::homography::{jacobian, project};
use crate::image::Image;

/// Rows that tell whether single discs agree with the whole.
const ROWS_READ: Part = Part::Rows(2);

impl GridFit {
    /// A grid behind a lens, with the plane of contrast through those of its discs; none where these tell no plane.
    pub(crate) fn of_bent(fitted: &Fitted) -> Option<Self> {
        let light = light(&fitted.greys)?;
        Some(Self {
            h: fitted.bent.h(),
            radius: fitted.bent.radius(),
            sigma: fitted.bent.sigma(),
            // From disc less paper to paper less disc, and from slopes a pixel to slopes a hundred pixels.
            contrast: [0, 1, 2].map(|k| -light.plane[k] * if k == 0 { 1.0 } else { SLOPE_UNIT_PX }),
            origin: light.origin,
            noise: fitted.noise,
            covariance: fitted.covariance.fixed_view::<8, 8>(0, 0).into_owned(),
            params: Params::zeros(),
            bent: Some(fitted.bent.clone()),
        })
    }

    /// Contrast and paper about a cell, as a fit without a lens has them.
    pub(crate) fn greys(&self, cell: [i32; 2]) -> Greys {
        let off = (self.at(cell) - self.origin) / SLOPE_UNIT_PX;
        let plane = |k: usize| self.params[k] + self.params[k + 1] * off.x + self.params[k + 2] * off.y;
        let slope = |k: usize| self.params[DISC + k] / SLOPE_UNIT_PX;
        Greys {
            contrast: plane(DISC),
            change: Vector2::new(slope(1), slope(2)),
            paper: [plane(PAPER), slope(4), slope(5)],
        }
    }

    /// What each disc's pixels say beside this fit, which is one without a lens.
    pub(crate) fn own(&self, image: &Image, cells: &[[i32; 2]]) -> Option<Vec<Own>> {
        let outlines: Option<Vec<Ellipse>> = cells.iter().map(|c| self.outline(*c)).collect();
        let outlines = outlines?;
        let chosen = |(cell, outline): (&[i32; 2], &Ellipse)| Chosen {
            cell: *cell,
            outline: *outline,
            pitch: jacobian(&self.h, point(*cell)),
        };
        let chosen: Vec<Chosen> = cells.iter().zip(&outlines).map(chosen).collect();
        let local = OwnPixels::new(
            image,
            &chosen,
            self.sigma,
            MARGIN_DEVIATIONS * self.sigma + 0.5,
            CLEAR * self.sigma,
            ROWS_READ,
        )?;
        let greys: Vec<Greys> = cells.iter().map(|c| self.greys(*c)).collect();
        let all = Guess {
            outlines: &outlines,
            sigma: self.sigma,
            greys: &greys,
        };
        let (mut room, mut out) = (Room::default(), Vec::with_capacity(cells.len()));
        for (i, cell) in cells.iter().enumerate() {
            // What is farther off than noise and model may be is dirt or glare, and says nothing of the disc.
            // As in the whole fit's own last phase, so that both look at about the same pixels.
            let limit = (5.0 * self.noise).max(MODEL_ERROR_CONTRAST * greys[i].contrast.abs());
            if let Some(block) = local.block(i, &all, limit, &mut room) {
                let left = block.vector.fixed_rows::<2>(0).into_owned();
                out.extend(own(*cell, &left, &block, self.noise.powi(2)));
            }
        }
        Some(out)
    }

    /// The image of a cell's centre.
    pub(crate) fn at(&self, cell: [i32; 2]) -> Vector2<f64> {
        match &self.bent {
            Some(bent) => bent.at(cell),
            None => project(&self.h, point(cell)),
        }
    }

    /// The image of a cell's disc.
    pub(crate) fn outline(&self, cell: [i32; 2]) -> Option<Ellipse> {
        match &self.bent {
            Some(bent) => bent.outline(cell),
            None => Ellipse::of_circle(&self.h, point(cell), self.radius),
        }
    }
}
