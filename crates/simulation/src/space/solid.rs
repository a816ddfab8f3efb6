//! Solids as black boxes, as [`crate::solid`] has them in the plane.
//!
//! What knows a solid knows how many parameters it has, rigid motions of them, its energy with two derivatives, and points
//! of its surface. Nothing else knows what a parameter means.

mod deformable;
mod determinant;
mod global;
mod particles;
mod sums;

pub use crate::solid::NotMixed;
pub use deformable::Deformable;
pub use global::{Global, NoBlock};
pub use particles::{NoParticles, Particle, Particles};

use nalgebra::{Rotation3, Vector3};

use super::cells::Share;
use super::gap::gap_of;
use crate::sparse::Triplets;

/// A solid of any kind. Parameters `a` are a slice of [`Self::parameters`] numbers, all with the unit of length, so that
/// their derivatives are forces.
pub trait Solid: std::fmt::Debug + Send + Sync {
    /// How many parameters describe its deformation.
    fn parameters(&self) -> usize;

    /// The parameters of the reference configuration.
    fn initial(&self) -> Vec<f64> {
        vec![0.0; self.parameters()]
    }

    /// Moves it by a translation.
    fn translate(&self, a: &mut [f64], by: Vector3<f64>);

    /// Turns it about a centre.
    fn rotate(&self, a: &mut [f64], by: &Rotation3<f64>, centre: Vector3<f64>);

    /// Potential energy of elasticity and weight, zero in the reference configuration. `None` where it has none: the law
    /// forbids the deformation, or a parameter is not a number.
    fn energy(&self, a: &[f64]) -> Option<f64>;

    /// The energy, and its derivatives *added* to `gradient`.
    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64>;

    /// The second derivatives, added to `sink` from the unknown `offset` on. Where `convex`, those of the nearest positive
    /// semidefinite matrix that is cheap to have.
    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()>;

    /// The forces of the weight on the parameters, *added* to `forces`.
    fn weight(&self, forces: &mut [f64]);

    /// The least determinant of the deformation gradient at the points looked at. Zero or less: turned inside out.
    fn least_determinant(&self, a: &[f64]) -> f64;

    /// True where the determinant of the deformation gradient is above zero between the points looked at too, in all parts of it for which
    /// `near(where their middle is, their side)` holds: proved of whole parts; of parts that a surface cuts, at more places, those of the surface among them.
    /// By default nothing is proved, and this false.
    fn is_upright(&self, _a: &[f64], _near: &dyn Fn(&Vector3<f64>, f64) -> bool) -> bool {
        false
    }

    /// A scale of the stiffness of its parameters, force by length as their second derivatives have; zero where it has none.
    fn stiffness_scale(&self) -> f64;

    /// A scale of its stiffness against shear, units of stress: what resists where volume is kept.
    fn shear_scale(&self) -> f64 {
        self.stiffness_scale()
    }

    /// Its largest side in the reference configuration.
    fn extent(&self) -> f64;

    /// A place in the reference configuration for each parameter, near what it moves: it orders their elimination.
    fn places(&self) -> Vec<[f64; 3]>;

    /// How many points of its surface are known.
    fn points(&self) -> usize;

    /// A point of the surface in the reference configuration: its place, the unit normal out there, and the area it stands for.
    fn reference(&self, point: usize) -> (Vector3<f64>, Vector3<f64>, f64);

    /// Half of the way from a point of the surface to the next in the reference configuration, mm. By its area where no more is known.
    fn gap(&self, point: usize) -> f64 {
        gap_of(self.reference(point).2)
    }

    /// Points inside, moved by nodes as [`Self::combination`] has it: what has come through the surface between its points is found by
    /// these. None where they are not known.
    fn inner(&self) -> Vec<Inner> {
        Vec::new()
    }

    /// The largest factor by which a length along the surface is stretched at a point of it. 1 where it is not known.
    fn stretch(&self, _a: &[f64], _point: usize) -> f64 {
        1.0
    }

    /// Where a point of the surface is.
    fn point(&self, a: &[f64], point: usize) -> Vector3<f64>;

    /// Calls `visit` with every parameter that moves a point of the surface, and the derivative of its position.
    fn rows(&self, a: &[f64], point: usize, visit: &mut dyn FnMut(usize, Vector3<f64>));

    /// Where positions are linear in the parameters: nodes with weights, so that a point of the surface is at its reference
    /// place plus the weighted sum of `(a[3 n], a[3 n + 1], a[3 n + 2])`. `None` where they are not, or not by nodes.
    fn combination(&self, _point: usize) -> Option<&[(u32, f64)]> {
        None
    }

    /// Adds `force . d2 point` to `sink`: nothing where positions are linear in the parameters.
    fn bend(&self, _a: &[f64], _point: usize, _force: Vector3<f64>, _sink: &mut Triplets, _offset: usize) {}

    /// What moves the material at a reference place, with derivatives by the place: of a solid whose parameters are three
    /// displacements of each of its nodes. A place a little outside is moved as what is next to it. `None` farther away, and of
    /// other solids.
    fn shares(&self, _at: &Vector3<f64>) -> Option<Vec<Share>> {
        None
    }
}

/// A point inside a solid: its reference place, and the nodes that move it with their weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Inner {
    /// In the reference configuration.
    pub at: Vector3<f64>,
    /// Nodes and weights.
    pub row: Vec<(u32, f64)>,
}

impl Inner {
    /// Where it is.
    pub fn place(&self, a: &[f64]) -> Vector3<f64> {
        let mut at = self.at;
        for (node, weight) in &self.row {
            (0..3).for_each(|k| at[k] += weight * a[3 * *node as usize + k]);
        }
        at
    }
}

/// Turns nodes with these places and displacements about a centre.
fn rotated(a: &mut [f64], places: &[Vector3<f64>], by: &Rotation3<f64>, centre: Vector3<f64>) {
    // `R - I` first: a small turn keeps its digits where places are large.
    let turn = by.matrix() - nalgebra::Matrix3::identity();
    for (u, reference) in a.chunks_exact_mut(3).zip(places) {
        let more = turn * (reference + Vector3::new(u[0], u[1], u[2]) - centre);
        (0..3).for_each(|k| u[k] += more[k]);
    }
}

/// The largest factor by which a length along the surface is stretched at a point of it, from its normal and the slopes of what moves it.
fn stretched(normal: &Vector3<f64>, slopes: impl IntoIterator<Item = (u32, Vector3<f64>)>, a: &[f64]) -> f64 {
    let along = normal.cross(&Vector3::ith(normal.iamin(), 1.0));
    // A normal is of length 1: so is neither of the two of length 0.
    let along = along / along.norm();
    let mut ways = [along, normal.cross(&along)];
    let at_rest = ways;
    for (node, slope) in slopes {
        let moved = Vector3::from_fn(|k, _| a[3 * node as usize + k]);
        (0..2).for_each(|k| ways[k] += moved * slope.dot(&at_rest[k]));
    }
    let [one, other] = ways.map(|way| way.norm_squared());
    // The larger eigenvalue of the 2 x 2 matrix of their products.
    let (mean, half) = (0.5 * (one + other), 0.5 * (one - other));
    (mean + half.hypot(ways[0].dot(&ways[1]))).sqrt()
}
