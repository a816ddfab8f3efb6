//! The whole way from an image to a grid.

use fit::median;

use crate::grid::candidates::smoothing_passes::{SmoothingPasses, WAYS};
use crate::grid::disc_fit_by_disc::DiscByDisc;
use crate::grid::error::GridRefused;
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::growth::Growth;
use crate::grid::found::{Found, GridSpec};
use crate::grid::homography::{jacobian, project};
use crate::grid::lattice::assignment::View;
use crate::grid::lattice::index_lattice::{IndexedLattice, place};
use crate::grid::lattice::rejected::RejectedLattices;
use crate::grid::lattice::sized::{Search, SizedLattice};
use crate::grid::lattice::{Cell, largest};
use crate::image::{Image, noise_deviation};

/// Centroids of which half lie so far off a homography, beside the pitch, and half a pixel, speak of lens distortion.
const DISTORTED_PITCHES: f64 = 0.015;

/// Finds the grid in an image, gives each disc its column and row, and refines all centres.
///
/// Candidates are dark regions that hardly grow while the level rises; each disc's own ellipse is the measure of its
/// neighbourhood, so that tilt does not hide who is next to whom; a lattice grows from the best seeds; the basis in
/// which it fills the rectangle with round discs is its own. One photometric fit of the whole grid follows, and tells
/// for every place whether a disc is there. A grid of the wrong number of columns or rows is refused; where large discs
/// are described, a part of the grid is enough if they tell which part it is.
///
/// # Errors
/// [`GridRefused`], with the best partial evidence.
pub fn find(image: &Image, spec: &GridSpec) -> Result<Found, GridRefused> {
    spec.check(image)?;
    let noise = noise_deviation(image);
    let discs = spec.cols * spec.rows;
    let mut refused = GridRefused::NoLattice { candidates: 0, discs };
    // Nothing is smoothed before what came before has been looked at.
    let mut tried: Vec<RejectedLattices> = Vec::new();
    let mut ways = SmoothingPasses::new(image, noise, spec.bright);
    for way in 0..WAYS {
        let Some(blobs) = ways.candidates(way) else { continue };
        let found = Search { image, spec, blobs }.run(&mut tried);
        match found {
            Ok(found) => return Ok(found),
            // Smoothing takes no line of discs away.
            Err(error) if is_larger(&error) => return Err(error),
            Err(error) if better(&error, &refused) => refused = error,
            Err(_) => {}
        }
    }
    Err(refused)
}

/// Whether what is seen has more discs than the grid asked for and a line besides.
fn is_larger(error: &GridRefused) -> bool {
    matches!(error, GridRefused::WrongSize { found, cols, rows, .. } if *found > cols * rows + cols.max(rows))
}

/// Whether a refusal says more of the image: discs in a lattice, then candidates.
fn better(error: &GridRefused, than: &GridRefused) -> bool {
    let candidates = |e: &GridRefused| match e {
        GridRefused::NoLattice { candidates, .. } => *candidates,
        _ => usize::MAX,
    };
    (error.evidence(), candidates(error)) > (than.evidence(), candidates(than))
}

impl Search<'_> {
    /// The grid, unless what is seen is a lattice that was tried.
    fn run(&self, tried: &mut Vec<RejectedLattices>) -> Result<Found, GridRefused> {
        let (candidates, discs) = (self.blobs.len(), self.spec.cols * self.spec.rows);
        let none = GridRefused::NoLattice { candidates, discs };
        let lattice = largest(&self.blobs, discs * 9 / 10);
        // The least grid has three columns and rows.
        if lattice.cells.len() < 9 {
            return Err(none);
        }
        let placed = place(&self.blobs, &lattice, self.spec).ok_or(none)?;
        let sized = self.sized(placed);
        let view = self.view(&sized, sized.placed.span, &sized.placed.h);
        // Before the fit, which takes most of the time.
        if view.is_too_large() || self.is_beyond(&sized) || tried.iter().any(|t| t.is(&sized)) {
            return Err(view.wrong_size());
        }
        let found = self.fitted(&sized, &view);
        if found.is_err() {
            tried.push(RejectedLattices::new(&sized));
        }
        found
    }

    /// The fit of the whole grid, or of each disc where the lens bends it.
    fn fitted(&self, sized: &SizedLattice, view: &View) -> Result<Found, GridRefused> {
        let growth = Growth { search: self, sized };
        let whole = match (self.spec.one_by_one, self.distorted(&sized.placed)) {
            (true, _) => None,
            (false, false) => growth.found(),
            (false, true) => growth.bent(),
        };
        if let Some(found) = whole {
            return found;
        }
        let seat = view.seat()?;
        let each = DiscByDisc {
            search: self,
            sized,
            seat,
        };
        each.found()
    }

    /// Whether the lens bends the lattice: by the median, as a candidate that light or dirt cuts may lie far off.
    fn distorted(&self, placed: &IndexedLattice) -> bool {
        let off = |(c, i): (&Cell, &usize)| (self.blobs[*i].at - project(&placed.h, point(*c))).norm_squared();
        let beside = |(c, i): (&Cell, &usize)| off((c, i)) / jacobian(&placed.h, point(*c)).determinant().abs();
        // At a small pitch the centroids' own errors exceed 1.5 % of it: half a pixel besides is no such error.
        let squared = DISTORTED_PITCHES * DISTORTED_PITCHES;
        median(placed.cells.iter().map(beside).collect()) > squared
            && median(placed.cells.iter().map(off).collect()) > 0.25
    }
}
