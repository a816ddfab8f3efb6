//! Contact of points with a tube, on the few unknowns that move them.
//!
//! Least `1/2 y S y - b y` with no point in the tube, by the augmented Lagrangian as in
//! [`crate::space::term::TubeContact`], with dense matrices.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::space::tube::Tube;

/// Stiffness of contact beside that of the tissue under a point. Large: a dense matrix of these sizes does not mind.
const STIFFER: f64 = 100.0;
/// Rounds of pressures, and steps of Newton's method in each, at most.
const ROUNDS: usize = 60;
const STEPS: usize = 60;
/// Force left on an unknown, beside the largest.
const BALANCE: f64 = 1e-5;
/// Depth left, beside the tube's radius; change of the forces on the unknowns, beside that on the tube. A state that is only compared with
/// another needs no more.
const DEPTH: f64 = 1e-4;
const CHANGE: f64 = 1e-3;

/// A point of the surface.
#[derive(Debug, Clone)]
pub(super) struct Spot {
    /// Unknowns that move it, and how; numbers of the root's unknowns once it is [`Pressed`].
    pub(super) row: Vec<(usize, Vector3<f64>)>,
    /// Where it was taken over to, and where it is at the beginning of a pass.
    place: [Vector3<f64>; 2],
    area: f64,
    pressure: f64,
}

impl Spot {
    pub(super) fn new(row: Vec<(usize, Vector3<f64>)>, place: Vector3<f64>, area: f64) -> Self {
        Self {
            row,
            place: [place; 2],
            area,
            pressure: 0.0,
        }
    }

    fn at(&self, y: &DVector<f64>) -> Vector3<f64> {
        self.row.iter().fold(self.place[1], |at, (p, by)| at + by * y[*p])
    }
}

/// Points and the tube.
pub(super) struct Pressed<'a> {
    root: Vec<usize>,
    spots: Vec<Spot>,
    tube: Option<&'a Tube>,
    stiffness: f64,
    force: Vector3<f64>,
}

/// The tube, and what holds the points.
type On<'a> = (&'a Tube, &'a DMatrix<f64>);

impl<'a> Pressed<'a> {
    /// `root` is sorted.
    pub(super) fn new(root: &[usize], mut spots: Vec<Spot>, tube: Option<&'a Tube>) -> Self {
        for (p, _) in spots.iter_mut().flat_map(|s| &mut s.row) {
            *p = root.partition_point(|r| *r < *p);
        }
        Self {
            root: root.to_vec(),
            spots,
            tube,
            stiffness: 0.0,
            force: Vector3::zeros(),
        }
    }

    /// The force on the tube that was found last.
    pub(super) fn force(&self) -> Vector3<f64> {
        self.force
    }

    /// Takes points to where they are at `a`; they were taken over at `start`.
    pub(super) fn moved(&mut self, a: &[f64], start: &[f64]) {
        for spot in &mut self.spots {
            let each = spot
                .row
                .iter()
                .map(|(p, by)| by * (a[self.root[*p]] - start[self.root[*p]]));
            spot.place[1] = spot.place[0] + each.sum::<Vector3<f64>>();
        }
    }

    /// The unknowns of the root under forces `b`. `None` where no state is found.
    pub(super) fn find(&mut self, matrix: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
        let tube = self.tube?;
        let area = self.spots.iter().map(|s| s.area).sum::<f64>() / self.spots.len() as f64;
        self.stiffness = STIFFER * matrix.trace() / (matrix.nrows() as f64 * area);
        let mut y = DVector::zeros(b.len());
        for _ in 0..ROUNDS {
            self.minimise((tube, matrix), b, &mut y)?;
            let (mut depth, mut force, mut change) = (0.0_f64, Vector3::zeros(), DVector::<f64>::zeros(b.len()));
            for spot in &mut self.spots {
                let distance = tube.signed_distance(&spot.at(&y));
                let new = (spot.pressure - self.stiffness * distance.value).max(0.0);
                // Some patterns of pressures push no unknown and hardly settle: what they do to the unknowns counts.
                let more = distance.gradient * (spot.area * (new - spot.pressure));
                spot.row.iter().for_each(|(p, by)| change[*p] += by.dot(&more));
                spot.pressure = new;
                force -= distance.gradient * (spot.area * new);
                depth = depth.max(-distance.value);
            }
            self.force = force;
            if depth <= DEPTH * tube.least_radius() && change.norm() <= CHANGE * force.norm() {
                return Some(y);
            }
        }
        None
    }

    /// Least energy with the pressures as they are.
    fn minimise(&self, on: On<'_>, b: &DVector<f64>, y: &mut DVector<f64>) -> Option<()> {
        for _ in 0..STEPS {
            let (energy, gradient, hessian) = self.derivatives(on, b, y);
            let largest = b.amax() + self.spots.iter().map(|s| s.area * s.pressure).fold(0.0, f64::max);
            if gradient.amax() <= BALANCE * largest {
                return Some(());
            }
            let step = hessian.cholesky()?.solve(&-&gradient);
            let slope = gradient.dot(&step);
            let mut part = 1.0;
            loop {
                let next = &*y + &step * part;
                // Within rounding of the energy every step is as good as another.
                if self.energy(on, b, &next) <= energy + 1e-4 * part * slope + 1e-13 * energy.abs() {
                    *y = next;
                    break;
                }
                part *= 0.5;
                if part < 1e-6 {
                    return Some(());
                }
            }
        }
        Some(())
    }

    fn energy(&self, (tube, matrix): On<'_>, b: &DVector<f64>, y: &DVector<f64>) -> f64 {
        let elastic = 0.5 * y.dot(&(matrix * y)) - b.dot(y);
        let each = self.spots.iter().map(|spot| {
            let distance = tube.signed_distance(&spot.at(y)).value;
            let pressure = (spot.pressure - self.stiffness * distance).max(0.0);
            0.5 * spot.area / self.stiffness * (pressure * pressure - spot.pressure * spot.pressure)
        });
        elastic + each.sum::<f64>()
    }

    fn derivatives(
        &self,
        (tube, matrix): On<'_>,
        b: &DVector<f64>,
        y: &DVector<f64>,
    ) -> (f64, DVector<f64>, DMatrix<f64>) {
        let mut gradient = matrix * y - b;
        let mut hessian = matrix.clone();
        for spot in &self.spots {
            let distance = tube.signed_distance(&spot.at(y));
            let pressure = spot.pressure - self.stiffness * distance.value;
            if pressure <= 0.0 {
                continue;
            }
            // Without the tube's roundness, which lowers the energy sideways: the matrix stays positive, and the step is as good but near
            // the end.
            let normal = distance.gradient;
            for (p, by) in &spot.row {
                let along = spot.area * normal.dot(by);
                gradient[*p] -= along * pressure;
                for (q, other) in &spot.row {
                    hessian[(*p, *q)] += along * self.stiffness * normal.dot(other);
                }
            }
        }
        (self.energy((tube, matrix), b, y), gradient, hessian)
    }
}
