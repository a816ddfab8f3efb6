//! What a mesh is made of.

use nalgebra::Vector3;

use super::rule::Surface;
use crate::space::gap::gap_of;

/// An element: its nodes, three unknowns each, and its table.
#[derive(Debug, Clone)]
pub struct Element {
    /// Free nodes.
    pub nodes: Vec<u32>,
    /// Number of its table; whole cubes of one size share theirs.
    pub table: u32,
}

/// A point inside a mesh's region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumePoint {
    /// Number of its cube.
    pub(super) cell: u32,
    /// Where it is in the reference configuration, mm.
    pub at: Vector3<f64>,
    /// Volume that it stands for, mm^3.
    pub volume: f64,
}

impl VolumePoint {
    /// The number of its cube.
    pub fn cube(&self) -> usize {
        self.cell as usize
    }
}

/// A point of the surface of a mesh's region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Number of its cube.
    pub(super) cell: u32,
    /// Where it is in the reference configuration, mm.
    pub at: Vector3<f64>,
    /// Unit normal out of the region.
    pub normal: Vector3<f64>,
    /// Area that it stands for, mm^2.
    pub area: f64,
    /// Half of the way to the next point, mm: places of the surface that no other point is nearer to are about so far off at most. See [`super::Mesh::lay_points`].
    pub gap: f64,
}

impl SurfacePoint {
    pub(super) fn of(cell: usize, surface: &Surface) -> Self {
        Self {
            cell: cell as u32,
            at: surface.at,
            normal: surface.normal,
            area: surface.area,
            gap: gap_of(surface.area),
        }
    }
}
