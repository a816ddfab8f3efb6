//! The whole way from an image to a grid.

use std::collections::HashSet;

use super::blob::Blob;
use super::each::Each;
use super::error::GridRefused;
use super::found::{Found, GridSpec};
use super::homography::{jacobian, project};
use super::lattice::{Cell, largest};
use super::lines::Lines;
use super::place::{Placed, place};
use super::seat::View;
use super::slopes::point;
use super::tried::Tried;
use super::way::{WAYS, Ways};
use crate::image::{Image, noise_deviation};

/// Marks are so much larger than other discs.
const MARK: f64 = 1.6;
/// Centroids of which half lie so far off a homography, beside the pitch, and half a pixel, speak of lens distortion.
const DISTORTED: f64 = 0.015;

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
    let mut tried: Vec<Tried> = Vec::new();
    let mut ways = Ways::new(image, noise, spec.bright);
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

/// What the steps after the candidates work on.
pub(crate) struct Search<'a> {
    pub(crate) image: &'a Image,
    pub(crate) spec: &'a GridSpec,
    pub(crate) blobs: Vec<Blob>,
}

/// A lattice with what its candidates say of its discs.
pub(crate) struct Sized {
    pub(crate) placed: Placed,
    /// Cells of discs of the usual size, by rows, and of large ones; none that the border cuts, whose size is not known.
    pub(crate) small: Vec<Cell>,
    pub(crate) marks: HashSet<Cell>,
    /// The usual radius beside the pitch.
    pub(crate) radius: f64,
}

impl Search<'_> {
    /// The grid, unless what is seen is a lattice that was tried.
    fn run(&self, tried: &mut Vec<Tried>) -> Result<Found, GridRefused> {
        let (candidates, discs) = (self.blobs.len(), self.spec.cols * self.spec.rows);
        let none = GridRefused::NoLattice { candidates, discs };
        let lattice = largest(&self.blobs, discs * 9 / 10);
        if lattice.cells.len() < 9 {
            return Err(none);
        }
        let placed = place(&self.blobs, &lattice, self.spec).ok_or(none)?;
        let sized = self.sized(placed);
        let view = self.view(&sized, sized.placed.span, &sized.placed.h);
        if view.is_too_large() || self.is_beyond(&sized) || tried.iter().any(|t| t.is(&sized)) {
            return Err(view.wrong_size());
        }
        let found = self.fitted(&sized, &view);
        if found.is_err() {
            tried.push(Tried::new(&sized));
        }
        found
    }

    /// The fit of the whole grid, or of each disc where the lens bends it.
    fn fitted(&self, sized: &Sized, view: &View) -> Result<Found, GridRefused> {
        let lines = Lines { search: self, sized };
        let whole = match (self.spec.one_by_one, self.distorted(&sized.placed)) {
            (true, _) => None,
            (false, false) => lines.found(),
            (false, true) => lines.bent(),
        };
        if let Some(found) = whole {
            return found;
        }
        let seat = view.seat()?;
        let each = Each {
            search: self,
            sized,
            seat,
        };
        each.found()
    }

    /// Radii beside the pitch, by area.
    fn radius(&self, placed: &Placed, cell: &Cell, i: usize) -> f64 {
        let area = jacobian(&placed.h, point(*cell)).determinant().abs();
        (self.blobs[i].area / std::f64::consts::PI / area).sqrt()
    }

    fn sized(&self, placed: Placed) -> Sized {
        let uncut = placed.cells.iter().filter(|(_, i)| !self.blobs[**i].cut);
        let mut radii: Vec<(f64, Cell)> = uncut.map(|(c, i)| (self.radius(&placed, c, *i), *c)).collect();
        radii.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let middle = radii.get(radii.len() / 2).map_or(0.2, |r| r.0);
        let large = radii.partition_point(|r| r.0 <= MARK * middle);
        let marks = radii[large..].iter().map(|r| r.1).collect();
        let radius = radii.get(large / 2).map_or(0.2, |r| r.0).min(0.45);
        let mut small: Vec<Cell> = radii[..large].iter().map(|r| r.1).collect();
        small.sort_unstable_by_key(|c| [c[1], c[0]]);
        Sized {
            placed,
            small,
            marks,
            radius,
        }
    }

    /// Whether the lens bends the lattice: by the median, as a candidate that light or dirt cuts may lie far off.
    fn distorted(&self, placed: &Placed) -> bool {
        let off = |(c, i): (&Cell, &usize)| (self.blobs[*i].at - project(&placed.h, point(*c))).norm_squared();
        let beside = |(c, i): (&Cell, &usize)| off((c, i)) / jacobian(&placed.h, point(*c)).determinant().abs();
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.0)
        };
        let squared = DISTORTED * DISTORTED;
        median(placed.cells.iter().map(beside).collect()) > squared
            && median(placed.cells.iter().map(off).collect()) > 0.25
    }

    /// What is seen, for the decision which columns and rows it is.
    pub(crate) fn view<'b>(&'b self, sized: &'b Sized, span: [[i32; 2]; 2], h: &nalgebra::Matrix3<f64>) -> View<'b> {
        let middle = span.map(|[a, b]| 0.5 * f64::from(a + b));
        let j = jacobian(h, middle.into());
        View {
            spec: self.spec,
            span,
            small: &sized.small,
            large: &sized.marks,
            axes: [j.column(0).into_owned(), j.column(1).into_owned()],
            candidates: self.blobs.len(),
        }
    }
}
