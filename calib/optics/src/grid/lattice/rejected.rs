//! Lattices that need no fit: those of which the rest is out of the image, and those that were refused before.

use nalgebra::{Vector2, Vector3};

use crate::grid::fit::disc_jacobian::point;
use crate::grid::homography::{jacobian, project};
use crate::grid::lattice::Cell;
use crate::grid::lattice::sized::{Search, SizedLattice};

/// How far corners of the same lattice may lie apart, beside the pitch: as centroids of two smoothings do.
const SAME_PITCHES: f64 = 0.1;
/// Lines so many columns or rows out of the image may yet be in it: candidates tell but about where.
const BEYOND_STEPS: f64 = 1.0;

/// A lattice that a fit has refused.
pub(crate) struct RejectedLattices {
    size: [i32; 2],
    corners: [Vector2<f64>; 4],
    /// Large discs, counted from the first corner.
    marks: Vec<Cell>,
}

fn corners([[left, right], [top, bottom]]: [[i32; 2]; 2]) -> [Cell; 4] {
    [[left, top], [right, top], [right, bottom], [left, bottom]]
}

impl RejectedLattices {
    pub(crate) fn new(sized: &SizedLattice) -> Self {
        let (span, h) = (sized.placed.span, &sized.placed.h);
        let from_first = |m: &Cell| [m[0] - span[0][0], m[1] - span[1][0]];
        let mut marks: Vec<Cell> = sized.marks.iter().map(from_first).collect();
        marks.sort_unstable();
        Self {
            size: span.map(|s| s[1] - s[0]),
            corners: corners(span).map(|c| project(h, point(c))),
            marks,
        }
    }

    /// Whether another lattice's fit would start where this one's did.
    pub(crate) fn is(&self, sized: &SizedLattice) -> bool {
        let (other, h) = (Self::new(sized), &sized.placed.h);
        let pitch = corners(sized.placed.span).map(|c| jacobian(h, point(c)).singular_values().min());
        let near = |k: usize| (other.corners[k] - self.corners[k]).norm() < SAME_PITCHES * pitch[k];
        self.size == other.size && self.marks == other.marks && (0..4).all(near)
    }
}

impl Search<'_> {
    /// Whether the whole grid is to be seen, and the image has no place for so many columns and rows.
    pub(crate) fn is_beyond(&self, sized: &SizedLattice) -> bool {
        let Some([columns, rows]) = self.room(sized) else {
            return false;
        };
        let [cols, lines] = [self.spec.cols, self.spec.rows].map(|n| n as f64);
        let holds = |a: f64, b: f64| columns >= a && rows >= b;
        self.spec.marks.is_empty() && !holds(cols, lines) && !holds(lines, cols)
    }

    /// How many columns and rows have a part in the image; none where it shows the grid's horizon.
    fn room(&self, sized: &SizedLattice) -> Option<[f64; 2]> {
        let back = sized.placed.h.try_inverse()?;
        let [right, bottom] = [self.image.width(), self.image.height()].map(|n| n as f64 - 1.0);
        let ends = [[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]];
        let ends = ends.map(|[x, y]| back * Vector3::new(x, y, 1.0));
        // Of one sign where the horizon is out of the image: the image is then a quadrangle of the grid's plane.
        let in_front = ends.iter().all(|p| p.z * ends[0].z > 0.0);
        let lines = |k: usize| {
            let places = ends.map(|p| p[k] / p.z);
            let (low, high) = places
                .iter()
                .fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
            (high + BEYOND_STEPS).floor() - (low - BEYOND_STEPS).ceil() + 1.0
        };
        in_front.then(|| [lines(0), lines(1)])
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use nalgebra::Matrix3;

    use super::*;
    use crate::grid::GridSpec;
    use crate::grid::lattice::index_lattice::IndexedLattice;
    use crate::image::Image;

    fn sized(h: Matrix3<f64>, span: [[i32; 2]; 2]) -> SizedLattice {
        let placed = IndexedLattice {
            cells: HashMap::new(),
            h,
            span,
        };
        SizedLattice {
            placed,
            small: Vec::new(),
            marks: HashSet::from([[span[0][0] + 2, span[1][0]]]),
            radius: 0.2,
        }
    }

    /// Steps of 10 px, cell (0, 0) at a place.
    fn steps(x: f64, y: f64) -> Matrix3<f64> {
        Matrix3::new(10.0, 0.0, x, 0.0, 10.0, y, 0.0, 0.0, 1.0)
    }

    #[test]
    fn a_lattice_is_the_same_wherever_it_is_counted_from() {
        let tried = RejectedLattices::new(&sized(steps(30.0, 20.0), [[0, 5], [0, 4]]));
        assert!(tried.is(&sized(steps(50.4, 50.0), [[-2, 3], [-3, 1]])));
        // A tenth of the pitch off and more, and one line more.
        assert!(!tried.is(&sized(steps(51.1, 50.0), [[-2, 3], [-3, 1]])));
        assert!(!tried.is(&sized(steps(50.0, 50.0), [[-2, 3], [-3, 2]])));
        let other = SizedLattice {
            marks: HashSet::from([[1, 0]]),
            ..sized(steps(30.0, 20.0), [[0, 5], [0, 4]])
        };
        assert!(!tried.is(&other));
    }

    #[test]
    fn a_grid_is_beyond_the_image_where_it_has_no_place_for_it() {
        let image = Image::from_bytes(101, 81, &[0; 101 * 81]).unwrap();
        let beyond = |cols: usize, rows: usize, h: Matrix3<f64>| {
            let spec = GridSpec::new(cols, rows, 1.0);
            let (image, blobs) = (&image, Vec::new());
            Search {
                image,
                spec: &spec,
                blobs,
            }
            .is_beyond(&sized(h, [[0, 3], [0, 3]]))
        };
        // Places from 0 to 10 and 0 to 8, and one more on each side.
        assert!(!beyond(13, 11, steps(0.0, 0.0)) && !beyond(11, 13, steps(40.0, 40.0)));
        assert!(beyond(14, 5, steps(0.0, 0.0)) && beyond(12, 12, steps(0.0, 0.0)));
        // The horizon crosses the image.
        let tilted = Matrix3::new(10.0, 0.0, 50.0, 0.0, 0.0, 40.0, 0.0, 0.1, 1.0) * steps(0.0, 0.0);
        assert!(!beyond(200, 200, tilted));
    }
}
