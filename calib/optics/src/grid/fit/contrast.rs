//! How the contrast of discs changes over a grid.

use nalgebra::{DMatrix, DVector, Vector2};

use crate::grid::check::own_pixels::Greys;

/// From so many discs on the light falls off in two directions.
// Twice the six numbers of a surface of the second degree.
const TWO_SLOPES_DISCS: usize = 12;
/// The unit of places, pixels.
const SLOPE_UNIT_PX: f64 = 100.0;

/// The contrast (disc less paper) about a place: the surface of the second degree through that of all discs, of the first where
/// they are few.
pub(crate) struct Light {
    pub(crate) origin: Vector2<f64>,
    /// At the origin, and its slopes there, a pixel.
    pub(crate) plane: [f64; 3],
    /// By x, y, xx, xy, yy in its unit.
    slopes: Vec<f64>,
}

fn powers(x: Vector2<f64>, count: usize) -> Vec<f64> {
    [1.0, x.x, x.y, x.x * x.x, x.x * x.y, x.y * x.y][..count].to_vec()
}

/// Through discs at places; none where they tell no surface.
pub(crate) fn light(discs: &[(Vector2<f64>, Greys)]) -> Option<Light> {
    // About the discs' own middle and in a unit of their order of size, powers stay small enough for normal equations.
    let origin = discs.iter().map(|d| d.0).sum::<Vector2<f64>>() / discs.len().max(1) as f64;
    let count = if discs.len() < TWO_SLOPES_DISCS { 3 } else { 6 };
    let rows = discs.iter().flat_map(|d| powers((d.0 - origin) / SLOPE_UNIT_PX, count));
    let rows = DMatrix::from_row_iterator(discs.len(), count, rows);
    let values = DVector::from_iterator(discs.len(), discs.iter().map(|d| d.1.contrast));
    let found = (rows.transpose() * &rows)
        .cholesky()?
        .solve(&(rows.transpose() * values));
    Some(Light {
        origin,
        plane: [found[0], found[1] / SLOPE_UNIT_PX, found[2] / SLOPE_UNIT_PX],
        slopes: found.iter().skip(1).copied().collect(),
    })
}

impl Light {
    /// How the contrast changes at a place, a pixel.
    pub(crate) fn change(&self, at: Vector2<f64>) -> Vector2<f64> {
        let x = (at - self.origin) / SLOPE_UNIT_PX;
        let s = |k: usize| self.slopes.get(k).copied().unwrap_or(0.0);
        Vector2::new(
            s(0) + 2.0 * s(2) * x.x + s(3) * x.y,
            s(1) + s(3) * x.x + 2.0 * s(4) * x.y,
        ) / SLOPE_UNIT_PX
    }
}
