//! From a field and a grid to a mesh.

use nalgebra::Vector3;

use super::elements::elements;
use super::field::Field;
use super::fill::fill;
use super::grid::{Cover, Grid};
use super::mesh::Mesh;
use super::settings::{NoMesh, Settings};
use super::surface::faces;
use super::ties::Ties;

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
}
