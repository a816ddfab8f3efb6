//! The surface of an organ in triangles, carried along by its mesh.

use geometry::{Affine, Ct, Point, Vector, Voxel};
use nalgebra::Vector3;
use organs::Labels;
use organs::body::{Body, displacement};
use simulation::space::cells::Field;
use surface::nets::{Lattice, extract};
use surface::{MOST_TRIANGLES, Mesh};

/// Places of an undeformed surface, the triangles between them, and what moves them.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    /// In the patient.
    places: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    rows: Vec<Vec<(u32, f64)>>,
}

/// A place of the patient as the pictures' crates have it.
pub(super) fn point(at: &Vector3<f64>) -> Point<Ct> {
    Point::new(at.x, at.y, at.z)
}

/// Samples of an organ's field on a lattice of the label map's axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples {
    pub(super) first: Vector3<f64>,
    pub(super) step: f64,
    pub(super) size: [usize; 3],
}

impl Samples {
    /// A lattice over an organ of so many steps along its largest side.
    pub(super) fn over(body: &Body, steps: f64) -> Self {
        let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let surface = body.mesh.surface.iter();
        let (low, high) = surface.fold(none, |(low, high), p| (low.inf(&p.at), high.sup(&p.at)));
        let step = (high - low).max() / steps;
        let first = low - Vector3::repeat(2.0 * step);
        let size = [0, 1, 2].map(|k| ((high[k] - first[k]) / step) as usize + 4);
        Self { first, step, size }
    }

    pub(super) fn len(&self) -> usize {
        self.size.iter().product()
    }

    pub(super) fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    pub(super) fn at(&self, n: usize) -> [usize; 3] {
        [
            n % self.size[0],
            n / self.size[0] % self.size[1],
            n / self.size[0] / self.size[1],
        ]
    }

    /// In the label map's axes.
    pub(super) fn place(&self, n: usize) -> Vector3<f64> {
        self.first + Vector3::from(self.at(n).map(|x| x as f64)) * self.step
    }
}

impl Skin {
    /// The surface of an organ by surface nets on its field; empty where there would be too many triangles.
    pub(super) fn new(body: &Body, labels: &Labels, samples: &Samples, values: &[f64]) -> Self {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| {
            let step = labels.turned(&axis) * samples.step;
            Vector::new(step.x, step.y, step.z)
        });
        let ct_from_sample: Affine<Ct, Voxel> = Affine::from_steps(point(&labels.patient(&samples.first)), axes);
        let lattice = Lattice {
            dims: samples.size.map(|n| n as u32),
            ct_from_sample,
            level: 0.0,
            most: MOST_TRIANGLES,
        };
        let layer = samples.size[0] * samples.size[1];
        let found = extract(&lattice, |z, out, _| {
            let from = z as usize * layer;
            // Inside is where the field is negative.
            out.iter_mut()
                .zip(&values[from..from + layer])
                .for_each(|(out, value)| *out = -value as f32);
            Ok(())
        });
        let found = found.unwrap_or_default();
        let places: Vec<Vector3<f64>> = found.points().iter().map(|p| Vector3::from(p.map(f64::from))).collect();
        let rows = places.iter().map(|at| row_near(body, &labels.own(at), samples.step));
        Self {
            rows: rows.collect(),
            triangles: found.triangles().to_vec(),
            places,
        }
    }

    /// The surface in a state.
    pub(super) fn deformed(&self, labels: &Labels, part: &[f64]) -> Option<Mesh> {
        let moved = self.places.iter().zip(&self.rows).map(|(at, row)| {
            let at = at + labels.turned(&displacement(row, part));
            [at.x as f32, at.y as f32, at.z as f32]
        });
        Mesh::of_triangles(moved.collect(), self.triangles.clone())
    }

    /// The largest and smallest corner of all places at rest.
    pub(super) fn bounds(&self) -> [Vector3<f64>; 2] {
        let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        self.places
            .iter()
            .fold(none, |[low, high], p| [low.inf(p), high.sup(p)])
    }
}

/// What moves a place of the surface: by its cube, by that of a place a little further in, or as the nearest point of the surface.
fn row_near(body: &Body, at: &Vector3<f64>, step: f64) -> Vec<(u32, f64)> {
    let inwards = body.field.slope(at).try_normalize(0.0).unwrap_or_default();
    let tries = (0..4).map(|k| at - inwards * (0.25 * f64::from(k) * step));
    if let Some(row) = tries.into_iter().find_map(|at| body.mesh.row(&at)) {
        return row;
    }
    let away = |p: &&simulation::space::cells::SurfacePoint| (p.at - at).norm_squared();
    let nearest = body.mesh.surface.iter().min_by(|p, q| away(p).total_cmp(&away(q)));
    nearest.map(|p| body.mesh.surface_row(p)).unwrap_or_default()
}
