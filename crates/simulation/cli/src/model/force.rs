//! The turning part of a dead force on a point of a polygon.

use nalgebra::Vector2;
use simulation::bodies::Bodies;
use simulation::constraint::{Constraint, Term};
use simulation::solid::Cursor;
use simulation::sparse::Triplets;

/// The energy `-f . (M - c)` of a force at the point `M` of a polygon whose centre has moved by `c`, its first two
/// parameters. The rest, `-f . c`, is a load of the system's, so that it counts among the forces that residuals are
/// measured by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lever {
    pub(super) body: usize,
    pub(super) cursor: Cursor,
    pub(super) force: Vector2<f64>,
}

impl Constraint for Lever {
    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(*self)
    }
}

impl Term for Lever {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let part = bodies.part(self.body, a);
        let arm = bodies.local(self.body, &self.cursor, a).position - Vector2::new(part[0], part[1]);
        Some(-self.force.dot(&arm))
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (solid, part, first) = (
            bodies.solid(self.body),
            bodies.part(self.body, a),
            bodies.offset(self.body),
        );
        self.cursor.rows(solid, part, &mut |parameter, by, _| {
            if parameter > 1 {
                gradient[first + parameter] -= by.dot(&self.force);
            }
        });
        self.energy(bodies, a)
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        if convex {
            return Some(());
        }
        let (solid, part, first) = (
            bodies.solid(self.body),
            bodies.part(self.body, a),
            bodies.offset(self.body),
        );
        for (node, weight) in solid.boundary().arcs[self.cursor.arc]
            .into_iter()
            .zip(self.cursor.weights())
        {
            solid.bend(part, node, self.force * -weight, sink, first);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulation::constraint::{End, Link};
    use simulation::control::{Newton, Potential, Settings};
    use simulation::solid::Rigid;
    use simulation::system::System;

    fn hanging(force: Vector2<f64>) -> (System, Vec<f64>) {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vector2::new(x, y));
        let mut system = System::new();
        let body = system.add(Rigid::new(&corners, Vector2::zeros()).unwrap());
        let at = |arc| Cursor { arc, u: -1.0 };
        System::load(&mut system, body, &[(0, force.x), (1, force.y)]);
        system.terms.push(Box::new(Lever {
            body,
            cursor: at(2),
            force,
        }));
        let pin = End::Fixed(Vector2::zeros());
        system
            .terms
            .push(Box::new(Link::soft([End::On { body, cursor: at(0) }, pin], 50.0)));
        let mut a = system.initial();
        system.bodies.solid(body).rotate(&mut a, 0.9, Vector2::new(0.1, 0.2));
        (system, a)
    }

    #[test]
    fn it_has_the_derivatives_of_its_energy() {
        let (system, a) = hanging(Vector2::new(0.7, -1.3));
        let h = 1e-6;
        let mut sink = Triplets::default();
        system.hessian(&a, false, &mut sink).unwrap();
        let at = |k: usize, by: f64| {
            let mut b = a.clone();
            b[k] += by;
            let mut gradient = vec![0.0; 3];
            (system.gradient(&b, &mut gradient).unwrap(), gradient)
        };
        for k in 0..3 {
            let (plus, minus, here) = (at(k, h), at(k, -h), at(k, 0.0));
            // h^2 times third derivatives of about 50, rounding 1e-14 / h.
            assert!(((plus.0 - minus.0) / (2.0 * h) - here.1[k]).abs() < 1e-7);
            let mut unit = vec![0.0; 3];
            unit[k] = 1.0;
            for (i, column) in sink.product(&unit).into_iter().enumerate() {
                assert!(((plus.1[i] - minus.1[i]) / (2.0 * h) - column).abs() < 1e-6, "{k} {i}");
            }
        }
    }

    /// A plate on a pin turns until the force points from the pin to the point it acts on.
    #[test]
    fn a_plate_on_a_pin_turns_into_the_force() {
        let force = Vector2::new(0.6, -0.8);
        let (system, mut a) = hanging(force);
        let found = Newton::new(Settings::default()).minimise(&system, &mut a).unwrap();
        assert_eq!(found.stability.falling, 0);
        let place = |arc| system.bodies.local(0, &Cursor { arc, u: -1.0 }, &a).position;
        let along = (place(2) - place(0)).try_normalize(0.0).unwrap();
        // Residual 1e-8 of a force of 1 over an arm of 2.
        assert!((along - force).norm() < 1e-7, "{along:?}");
    }
}
