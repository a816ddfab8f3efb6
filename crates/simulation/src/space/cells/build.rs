//! From a field and a grid to a mesh.

use nalgebra::Vector3;

use super::eighths::Eighths;
use super::elements::elements;
use super::field::Field;
use super::fill::fill;
use super::grid::{Cover, Grid};
use super::mesh::Mesh;
use super::settings::{NoMesh, Settings};
use super::surface::faces;
use super::ties::Ties;

/// A mesh whose volume differs from the region's by more than this part has lost some of it.
const MOST_LOST: f64 = 0.1;

impl Mesh {
    /// The mesh of the part of a region in a box, which is filled up to whole cubes of the largest side: it may end beyond `high`. Cubes for which `fine` holds are halved, as far as settings allow.
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
        // How full cubes are decides which nodes are free, and these what elements are.
        let parts: Vec<f64> = filled.cells.iter().map(|f| f.fill).collect();
        let ties = Ties::new(&grid, settings.order, &parts, settings.least_fill)?;
        let inside = filled.cells.iter().map(|f| {
            let low = grid.corners(&f.cell)[0];
            (!f.whole).then(|| Eighths::of(field, &low, grid.length(f.cell.span)))
        });
        let mut mesh = Self {
            inside: inside.collect(),
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
        mesh.is_whole(field, [low, high])?;
        mesh.is_one()?;
        Ok(mesh)
    }

    /// Its volume is the region's, where that is known and the box holds all of it.
    fn is_whole(&self, field: &dyn Field, [low, high]: [Vector3<f64>; 2]) -> Result<(), NoMesh> {
        let Some((expected, corners)) = field.known() else {
            return Ok(());
        };
        let holds = (0..3).all(|k| low[k] <= corners[0][k] && corners[1][k] <= high[k]);
        let found = self.volume() + self.left_out();
        let near = (found / expected - 1.0).abs() < MOST_LOST;
        if holds && !near {
            return Err(NoMesh::Lost { found, expected });
        }
        Ok(())
    }

    /// All elements hang together.
    fn is_one(&self) -> Result<(), NoMesh> {
        let mut part: Vec<usize> = (0..self.nodes.len()).collect();
        // Of each node the first that it hangs together with, by shorter and shorter ways.
        let find = |part: &mut Vec<usize>, mut n: usize| {
            while part[n] != n {
                part[n] = part[part[n]];
                n = part[n];
            }
            n
        };
        for element in &self.elements {
            for pair in element.nodes.windows(2) {
                let [one, other] = [0, 1].map(|k| find(&mut part, pair[k] as usize));
                // The lower of two is the name of both from now on.
                part[one.max(other)] = one.min(other);
            }
        }
        let roots: Vec<usize> = (0..part.len()).filter(|n| part[*n] == *n).collect();
        match roots.as_slice() {
            [_] | [] => Ok(()),
            [_, other, ..] => Err(NoMesh::Apart {
                count: roots.len(),
                at: self.nodes[*other].into(),
            }),
        }
    }
}
