//! A mesh: elements over free nodes, from a field and a grid.

use nalgebra::Vector3;

use super::elements::elements;
use super::field::Field;
use super::fill::fill;
use super::grid::{Cell, Cover, Grid};
use super::points::VolumePoint;
use super::settings::{NoMesh, Settings};
use super::surface::{SurfacePoint, faces};
use super::ties::Ties;
use crate::space::element::{Dilatation, Order, Table};

/// An element: its nodes, three unknowns each, and its table.
#[derive(Debug, Clone)]
pub struct Element {
    /// Free nodes.
    pub nodes: Vec<u32>,
    /// Number of its table; whole cubes of one size share theirs.
    pub table: u32,
}

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
    points: Vec<VolumePoint>,
    dilatation: Dilatation,
    /// Volume in cubes that hold too little to count.
    left_out: f64,
}

impl Mesh {
    /// The mesh of the part of a region in a box. Cubes for which `fine` holds are halved, as far as settings allow.
    ///
    /// # Errors
    /// Every variant of [`NoMesh`].
    pub fn new(
        field: &dyn Field,
        [low, high]: [Vector3<f64>; 2],
        settings: &Settings,
        fine: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, NoMesh> {
        settings.check()?;
        if !(high - low).iter().all(|x| x.is_finite() && *x > 0.0) {
            let [low, high] = [low, high].map(Into::into);
            return Err(NoMesh::Box { low, high });
        }
        let cover = Cover {
            low,
            high,
            side: settings.side,
            levels: settings.levels,
            wanted: &|low, high| field.bounds(low, high)[0] < 0.0,
            fine,
            most: settings.most_cubes,
        };
        let mut grid = Grid::new(&cover).ok_or(NoMesh::TooMany {
            side: settings.side,
            levels: settings.levels,
            most: settings.most_cubes,
        })?;
        let mut filled = fill(field, &mut grid, settings);
        if filled.cells.is_empty() {
            return Err(NoMesh::Empty);
        }
        let parts: Vec<f64> = filled.cells.iter().map(|f| f.fill).collect();
        let ties = Ties::new(&grid, settings.order, &parts, settings.least_fill)?;
        let mut mesh = Self {
            nodes: ties.free.iter().map(|at| grid.place(*at)).collect(),
            elements: Vec::new(),
            tables: Vec::new(),
            surface: std::mem::take(&mut filled.surface),
            points: std::mem::take(&mut filled.points),
            order: settings.order,
            cells: filled.cells.iter().map(|f| f.cell).collect(),
            grid,
            ties,
            dilatation: settings.dilatation,
            left_out: filled.left_out,
        };
        let whole: Vec<bool> = filled.cells.iter().map(|f| f.whole).collect();
        mesh.surface.extend(faces(&mesh, &whole));
        (mesh.elements, mesh.tables) = elements(&mesh, &filled.cells)?;
        Ok(mesh)
    }

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
