//! The points of each cube.

use nalgebra::Vector3;

use super::field::Field;
use super::grid::{Cell, Grid};
use super::parts::{SurfacePoint, VolumePoint};
use super::recombine;
use super::rule::{Inside, Rule, Surface, gauss};
use super::settings::Settings;
use crate::space::element::Order;

/// Cubes filled by less than this part are left out.
const NOTHING: f64 = 1e-9;

/// A cube and what is in it.
pub(super) struct Filled {
    pub(super) cell: Cell,
    /// Its points among those of all.
    pub(super) points: std::ops::Range<usize>,
    /// Whether all of it is inside.
    pub(super) whole: bool,
    /// The part of it that is inside.
    pub(super) fill: f64,
}

/// Cubes, their points, those of the surface in them, and the volume of what is left out.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) cells: Vec<Filled>,
    pub(super) points: Vec<VolumePoint>,
    pub(super) surface: Vec<SurfacePoint>,
    pub(super) left_out: f64,
    /// Points of the surface in cubes that were left out.
    lost: Vec<Surface>,
}

/// What is in the cubes of a grid. Those with next to nothing are taken off it.
pub(super) fn fill(field: &dyn Field, grid: &mut Grid, settings: &Settings) -> Contents {
    let mut all = Contents::default();
    let cells: Vec<Cell> = grid.cells().collect();
    for cell in cells {
        let corners = grid.corners(&cell);
        if field.bounds(&corners[0], &corners[1])[1] <= 0.0 {
            all.add(cell, whole_points(&corners, settings.order), 1.0, true);
            continue;
        }
        let rule = Rule::of(field, &corners[0], &corners[1], settings.depth);
        let side = corners[1].x - corners[0].x;
        let fill = rule.volume() / side.powi(3);
        if fill <= NOTHING {
            all.left_out += rule.volume();
            // A face of the region on a face of the cubes may lie, by rounding, in the empty one of the two: without it nothing
            // could press or hold there.
            all.lost.extend(rule.surface);
            continue;
        }
        let number = all.cells.len();
        let surface = recombine::surface(&rule.surface, &corners);
        all.surface.extend(surface.iter().map(|s| SurfacePoint::of(number, s)));
        all.add(
            cell,
            recombine::inside(&rule.inside, &corners, settings.order),
            fill,
            false,
        );
    }
    all.take_lost(grid);
    let kept: Vec<Cell> = all.cells.iter().map(|f| f.cell).collect();
    grid.retain(|cell| kept.binary_search(cell).is_ok());
    all
}

impl Contents {
    /// Gives points of the surface in cubes that were left out to the cube on their inner side, if there is one. Of a whole
    /// cube all of that face is the surface once the other is gone, and is found as such.
    fn take_lost(&mut self, grid: &Grid) {
        let step = grid.length(1);
        for point in std::mem::take(&mut self.lost) {
            let inner = grid.containing(&(point.at - point.normal * (0.5 * step)));
            let number = inner.and_then(|cell| self.cells.binary_search_by_key(&cell, |f| f.cell).ok());
            let number = number.filter(|number| !self.cells[*number].whole);
            self.surface
                .extend(number.map(|number| SurfacePoint::of(number, &point)));
        }
    }

    fn add(&mut self, cell: Cell, points: Vec<Inside>, fill: f64, whole: bool) {
        let (number, first) = (self.cells.len() as u32, self.points.len());
        self.points.extend(points.into_iter().map(|p| VolumePoint {
            cell: number,
            at: p.at,
            volume: p.weight,
        }));
        self.cells.push(Filled {
            cell,
            points: first..self.points.len(),
            whole,
            fill,
        });
    }
}

/// Gauss points of a whole cube.
fn whole_points([low, high]: &[Vector3<f64>; 2], order: Order) -> Vec<Inside> {
    let rule = gauss(match order {
        Order::Linear => 2,
        Order::Quadratic => 3,
    });
    let side = high - low;
    let mut points = Vec::with_capacity(rule.len().pow(3));
    for (z, wz) in rule {
        for (y, wy) in rule {
            points.extend(rule.iter().map(|(x, wx)| Inside {
                at: low + side.component_mul(&Vector3::new(*x, *y, *z)),
                weight: side.product() * wx * wy * wz,
            }));
        }
    }
    points
}
