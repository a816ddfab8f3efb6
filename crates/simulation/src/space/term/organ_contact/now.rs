//! Two solids that touch, as they are now.

use std::cell::Cell;

use nalgebra::Vector3;

use super::OrganContact;
use crate::space::bodies::Bodies;
use crate::space::solid::Solid;
use crate::space::term::pressures::{Touch, depth_or_all};
use crate::space::term::pulled::Pulled;
use crate::space::tree::Tree;

/// Where the other's surface is now.
pub(super) struct Now<'a> {
    contact: &'a OrganContact,
    bodies: &'a Bodies,
    a: &'a [f64],
    /// Points of the other's surface now.
    pub(super) tree: Tree,
}

impl<'a> Now<'a> {
    pub(super) fn new(contact: &'a OrganContact, bodies: &'a Bodies, a: &'a [f64]) -> Self {
        let (solid, part) = (bodies.solid(contact.other), bodies.part(contact.other, a));
        let points = (0..solid.points()).map(|point| solid.point(part, point));
        Self {
            contact,
            bodies,
            a,
            // Anew for each state: the surface moves with the unknowns.
            tree: Tree::new(points.collect()),
        }
    }

    pub(super) fn solid(&self) -> (&dyn Solid, &[f64]) {
        let body = self.contact.body;
        (self.bodies.solid(body), self.bodies.part(body, self.a))
    }

    pub(super) fn other(&self) -> (&dyn Solid, &[f64]) {
        let other = self.contact.other;
        (self.bodies.solid(other), self.bodies.part(other, self.a))
    }

    pub(super) fn point(&self, touch: &Touch) -> Vector3<f64> {
        let (solid, part) = self.solid();
        solid.point(part, touch.point)
    }

    /// How far from the other's surface points are looked at: no deeper one is allowed.
    fn seen(&self) -> f64 {
        self.contact.surface.radius() + self.contact.spacing
    }

    /// A point that is near the other, pulled back.
    pub(super) fn pulled(&self, touch: &Touch) -> Option<Pulled> {
        let (x, (solid, part)) = (self.point(touch), self.other());
        // From the point of the surface that is nearest now, so that Newton's method begins in the right cube.
        let (nearest, apart) = self.tree.nearest_given(&x)?;
        if apart > self.seen() && touch.pressure <= 0.0 {
            return None;
        }
        let (start, _, _) = solid.reference(nearest);
        Pulled::new(solid, part, &self.contact.surface, &x, &start)
    }

    pub(super) fn gap(&self, touch: &Touch) -> Option<(f64, Pulled)> {
        self.pulled(touch).map(|pulled| (pulled.distance.value, pulled))
    }

    pub(super) fn depth(&self) -> f64 {
        let touches = self.contact.pressures.touches.iter();
        let depths = touches
            .filter_map(|touch| self.pulled(touch))
            .map(|pulled| depth_or_all(-pulled.now()));
        depths.fold(0.0, f64::max)
    }

    /// How deep the deepest point is among those that are farther from the other's surface than contact looks, mm: by the side of
    /// the surface that they are on.
    pub(super) fn far_depth(&self) -> f64 {
        let (other, part) = self.other();
        let depths = self.contact.pressures.touches.iter().filter_map(|touch| {
            let x = self.point(touch);
            let (nearest, apart) = self.tree.nearest_given(&x)?;
            let ((_, normal, _), at) = (other.reference(nearest), other.point(part, nearest));
            // So far away the way from the nearest of the points is along the normal there, outward or inward.
            let inward = (x - at).dot(&normal) < 0.0;
            (apart > self.seen() && inward).then_some(apart)
        });
        depths.fold(0.0, f64::max)
    }

    /// The energy; calls `each` with points that press. `None` where one is so deep that it may leave on the other side.
    pub(super) fn visit(&self, mut each: impl FnMut(&Touch, f64, &Pulled)) -> Option<f64> {
        let (mut allowed, most, lost) = (true, self.contact.surface.radius(), Cell::new(false));
        let energy = self.contact.pressures.visit(
            |touch| {
                let gap = self.gap(touch);
                // A point that pressed and cannot be pulled back, as tissue is inside out there, has not simply gone.
                lost.set(lost.get() || touch.pressure > 0.0 && gap.is_none());
                gap
            },
            |touch, pressure, pulled| {
                allowed &= pulled.distance.value > -most;
                each(touch, pressure, pulled);
            },
        );
        energy.filter(|_| allowed && !lost.get())
    }

    /// Unknowns with the change of the point, less that of the other's material there, and of the other's nodes the slope of
    /// their weights and the axis.
    pub(super) fn row(&self, touch: &Touch, pulled: &Pulled, row: &mut Vec<Moving>) {
        row.clear();
        let (solid, part) = self.solid();
        let offset = self.bodies.offset(self.contact.body);
        solid.rows(part, touch.point, &mut |p, way| {
            row.push(Moving {
                unknown: offset + p,
                way,
                slope: Vector3::zeros(),
                axis: 0,
            });
        });
        // What the point meets moves too: its nodes count with the opposite sign.
        let offset = self.bodies.offset(self.contact.other);
        for (share, axis) in pulled
            .shares
            .iter()
            .flat_map(|share| [0, 1, 2].map(|axis| (share, axis)))
        {
            row.push(Moving {
                unknown: offset + 3 * share.node as usize + axis,
                way: Vector3::ith(axis, -share.weight),
                slope: share.slope,
                axis,
            });
        }
    }
}

/// An unknown that moves a point or what is at it.
pub(super) struct Moving {
    pub(super) unknown: usize,
    pub(super) way: Vector3<f64>,
    pub(super) slope: Vector3<f64>,
    pub(super) axis: usize,
}
