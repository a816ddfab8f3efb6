//! A mesh: elements over free nodes, from a field and a grid.

use nalgebra::Vector3;

use super::eighths::Eighths;
use super::grid::{Cell, Grid};
use super::parts::{Element, SurfacePoint, VolumePoint};
use super::ties::Ties;
use crate::space::element::{Dilatation, Order, Table};

/// Elements over a region.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Reference positions of the free nodes, mm. They may lie a little outside the region.
    pub nodes: Vec<Vector3<f64>>,
    /// The elements.
    pub elements: Vec<Element>,
    /// Their tables.
    pub tables: Vec<Table>,
    /// Points of the region's surface, with the area that each stands for.
    pub surface: Vec<SurfacePoint>,
    pub(super) grid: Grid,
    pub(super) order: Order,
    pub(super) cells: Vec<Cell>,
    pub(super) ties: Ties,
    /// Points inside, cube by cube.
    pub(super) points: Vec<VolumePoint>,
    pub(super) dilatation: Dilatation,
    /// Where cubes that the surface cuts hold some of the region.
    pub(super) inside: Vec<Option<Eighths>>,
    /// Volume in cubes that hold too little to count.
    pub(super) left_out: f64,
}

impl Mesh {
    /// Volume of the elements, mm^3.
    pub fn volume(&self) -> f64 {
        self.elements.iter().map(|e| self.table(e).volume()).sum()
    }

    /// Volume of the region in cubes that were left out, as hardly anything is in them, mm^3.
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// The table of an element.
    pub fn table(&self, element: &Element) -> &Table {
        &self.tables[element.table as usize]
    }

    /// Unknowns: three to a node.
    pub fn unknowns(&self) -> usize {
        3 * self.nodes.len()
    }

    /// True where the elements have dilatations of their own.
    pub fn is_mixed(&self) -> bool {
        self.dilatation != Dilatation::Plain
    }

    /// The space of the elements' dilatations.
    pub fn dilatation(&self) -> Dilatation {
        self.dilatation
    }

    /// Points inside with the volume that each stands for, cube by cube.
    pub fn points(&self) -> &[VolumePoint] {
        &self.points
    }

    /// Free nodes on the lattice's own places that satisfy `wanted`: to hold them, where the region ends with the grid.
    pub fn nodes_where(&self, wanted: impl Fn(&Vector3<f64>) -> bool) -> Vec<usize> {
        (0..self.nodes.len()).filter(|n| wanted(&self.nodes[*n])).collect()
    }

    /// The cubes.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}
