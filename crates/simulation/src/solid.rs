//! Solids as black boxes (II 3.2.1).
//!
//! What knows a solid knows the number of its parameters, which it keeps itself, an initial value and rigid motions of
//! them, the potential energy with two derivatives, and the boundary. Nothing else of the crate knows what a parameter
//! means.

mod boundary;
mod cursor;
mod deformable;
mod global;
mod rigid;

pub use boundary::Boundary;
pub use cursor::{Cursor, Local};
pub use deformable::{Deformable, NotMixed};
pub use global::{Global, OutsideBlock};
pub use rigid::{BadPolygon, Rigid};

use nalgebra::Vector2;

use crate::q9::FieldPoint;
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
    fn translate(&self, a: &mut [f64], by: Vector2<f64>);

    /// Turns it by an angle, radians, about a centre. Linear in what is deformed: exact.
    fn rotate(&self, a: &mut [f64], angle: f64, centre: Vector2<f64>);

    /// Potential energy of elasticity and weight, zero in the reference configuration (II 3.1). `None` where it has
    /// none: the law forbids the deformation, or a parameter is not a number.
    fn energy(&self, a: &[f64]) -> Option<f64>;

    /// The energy, and its derivatives *added* to `gradient`.
    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64>;

    /// The second derivatives, added to `sink` from the unknown `offset` on. Where `convex`, those of the nearest
    /// positive semidefinite matrix that is cheap to have.
    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()>;

    /// The forces of the weight on the parameters, *added* to `forces`: minus the derivative of its energy at rest.
    fn weight(&self, forces: &mut [f64]);

    /// The least determinant of the deformation gradient at the points looked at. Zero or less: turned inside out.
    fn least_determinant(&self, a: &[f64]) -> f64;

    /// A scale of its stiffness, units of stress; zero where it has none.
    fn stiffness_scale(&self) -> f64;

    /// Its boundary.
    fn boundary(&self) -> &Boundary;

    /// Where a node of the boundary is.
    fn point(&self, a: &[f64], node: usize) -> Vector2<f64>;

    /// The same about an origin, which is taken off before displacements are added: far from zero no digits are lost that differences of places
    /// near one another have.
    fn point_about(&self, a: &[f64], node: usize, origin: Vector2<f64>) -> Vector2<f64> {
        self.point(a, node) - origin
    }

    /// Calls `visit` with every parameter that moves a node of the boundary, and the derivative of its position.
    fn rows(&self, a: &[f64], node: usize, visit: &mut dyn FnMut(usize, Vector2<f64>));

    /// The first of the two parameters that are the displacement of a node of the boundary, and of nothing else. `None` where
    /// parameters do more or other than that.
    fn own(&self, _node: usize) -> Option<usize> {
        None
    }

    /// Where the nodes of every arc of the boundary are.
    fn outline(&self, a: &[f64]) -> Vec<[Vector2<f64>; 3]> {
        let arcs = self.boundary().arcs.iter();
        arcs.map(|arc| arc.map(|node| self.point(a, node))).collect()
    }

    /// The same about an origin.
    fn outline_about(&self, a: &[f64], origin: Vector2<f64>) -> Vec<[Vector2<f64>; 3]> {
        let arcs = self.boundary().arcs.iter();
        arcs.map(|arc| arc.map(|node| self.point_about(a, node, origin)))
            .collect()
    }

    /// How fast they move at `a` while the parameters change by `step` in a unit of time.
    fn velocities(&self, a: &[f64], step: &[f64]) -> Vec<[Vector2<f64>; 3]> {
        let velocity = |node: usize| match self.own(node) {
            Some(own) => Vector2::new(step[own], step[own + 1]),
            None => {
                let mut sum = Vector2::zeros();
                self.rows(a, node, &mut |parameter, by| sum += by * step[parameter]);
                sum
            }
        };
        let arcs = self.boundary().arcs.iter();
        arcs.map(|arc| arc.map(velocity)).collect()
    }

    /// A bound of the length of the second derivative of a boundary node's position by `t`, while the parameters are
    /// `a + t step`: 0 where positions are linear in the parameters.
    fn swerve(&self, _step: &[f64], _node: usize) -> f64 {
        0.0
    }

    /// How many elements its inside is drawn by: none where it is rigid.
    fn patches(&self) -> usize {
        0
    }

    /// The state at the local point `at`, in `[-1, 1]^2`, of an element of its inside.
    fn field(&self, _a: &[f64], _patch: usize, _at: [f64; 2]) -> Option<FieldPoint> {
        None
    }

    /// Adds `force . d2 point` to `sink`: nothing where positions are linear in the parameters.
    fn bend(&self, _a: &[f64], _node: usize, _force: Vector2<f64>, _sink: &mut Triplets, _offset: usize) {}
}
