//! Places of an organ's surface and inside, and the nodes that move them.

use nalgebra::Vector3;
use simulation::space::cells::{Field, LabelField, Mesh};

/// From one place of the surface to the next, mm; of a small organ this part of the cube root of its volume.
const STEP_MM: f64 = 1.0;
const PART: f64 = 0.125;
/// Steps from one place inside to the next.
const INSIDE: usize = 3;
/// A grid has at most so many places, and an organ so many on its surface: else they are laid farther apart.
const MOST_ON_GRID: f64 = 2e7;
const MOST: usize = 60_000;
/// Halvings of the way from one place of the grid to the next, on which the surface lies.
const HALVINGS: usize = 12;

/// Places with what moves them; those of the surface come first.
#[derive(Debug)]
pub(super) struct Samples {
    /// How far they are apart on the surface at most, mm.
    pub(super) step: f64,
    /// At rest.
    pub(super) places: Vec<Vector3<f64>>,
    /// Of those of the surface, outward.
    pub(super) normals: Vec<Vector3<f64>>,
    rows: Vec<(u32, f64)>,
    starts: Vec<usize>,
}

impl Samples {
    pub(super) fn new(mesh: &Mesh, field: &LabelField) -> Self {
        let [low, high] = field.corners;
        let volume = (high - low).product();
        let mut step = STEP_MM
            .min(PART * field.facts.volume.cbrt())
            .max((volume / MOST_ON_GRID).cbrt());
        loop {
            let (surface, inner) = laid(field, step);
            if surface.len() <= MOST {
                return Self::moved_by(mesh, field, step, surface, inner);
            }
            step *= 1.25;
        }
    }

    fn moved_by(
        mesh: &Mesh,
        field: &LabelField,
        step: f64,
        surface: Vec<Vector3<f64>>,
        inner: Vec<Vector3<f64>>,
    ) -> Self {
        let mut all = Self {
            step,
            places: Vec::new(),
            normals: Vec::new(),
            rows: Vec::new(),
            starts: vec![0],
        };
        // What no cube is near to is not in the model.
        for at in surface {
            if let Some(normal) = field.slope(&at).try_normalize(0.0)
                && all.push(mesh, at)
            {
                all.normals.push(normal);
            }
        }
        inner.into_iter().for_each(|at| {
            all.push(mesh, at);
        });
        all
    }

    fn push(&mut self, mesh: &Mesh, at: Vector3<f64>) -> bool {
        let Some(shares) = mesh.shares(&at) else {
            return false;
        };
        self.places.push(at);
        self.rows.extend(shares.iter().map(|share| (share.node, share.weight)));
        self.starts.push(self.rows.len());
        true
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// How many are of the surface.
    pub(super) fn surface(&self) -> usize {
        self.normals.len()
    }

    /// Where all are with these displacements of the organ's nodes; without any, at rest.
    pub(super) fn moved(&self, part: &[f64]) -> Vec<Vector3<f64>> {
        if part.is_empty() {
            return self.places.clone();
        }
        let each = self.places.iter().zip(self.starts.windows(2));
        each.map(|(at, ends)| at + crate::body::displacement(&self.rows[ends[0]..ends[1]], part))
            .collect()
    }
}

/// Places where lines of a grid go through the surface, and places of a coarser one inside.
fn laid(field: &LabelField, step: f64) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let [low, high] = field.corners;
    let count = [0, 1, 2].map(|a| ((high[a] - low[a]) / step).ceil().max(1.0) as usize + 1);
    let place = |at: [usize; 3]| low + Vector3::from(at.map(|n| n as f64)) * step;
    let index = |[x, y, z]: [usize; 3]| (z * count[1] + y) * count[0] + x;
    let all = || (0..count[2]).flat_map(|z| (0..count[1]).flat_map(move |y| (0..count[0]).map(move |x| [x, y, z])));
    let values: Vec<bool> = all().map(|at| field.value(&place(at)) < 0.0).collect();
    let (mut surface, mut inner) = (Vec::new(), Vec::new());
    for at in all() {
        let is_inside = values[index(at)];
        if is_inside && at.iter().all(|n| n % INSIDE == 0) {
            inner.push(place(at));
        }
        for axis in 0..3 {
            let mut next = at;
            next[axis] += 1;
            if next[axis] < count[axis] && values[index(next)] != is_inside {
                surface.push(between(field, place(at), place(next), is_inside));
            }
        }
    }
    (surface, inner)
}

/// Where the surface is between two places, of which the first is inside or the other one.
fn between(field: &LabelField, first: Vector3<f64>, second: Vector3<f64>, is_inside: bool) -> Vector3<f64> {
    let [mut inside, mut outside] = if is_inside { [first, second] } else { [second, first] };
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inside + outside);
        if field.value(&middle) < 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    // The one that is outside for certain: nothing touches itself by rounding.
    outside
}
