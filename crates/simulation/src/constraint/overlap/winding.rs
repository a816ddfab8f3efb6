//! How often a boundary winds round a point: the sum of the angles that its arcs span, seen from there.

use nalgebra::Vector2;

use super::bezier::Bezier;
use crate::constraint::shape::Shape;

/// Halvings of an arc near the point: what is left is as short as the point is far.
const MOST_HALVINGS: u32 = 64;

/// The angle from one direction to another, within half a turn.
fn angle(from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    (from.x * to.y - from.y * to.x).atan2(from.dot(&to))
}

/// The angle that an arc about the point spans: that between its ends, as soon as a circle round it leaves the point out.
fn spanned(arc: &Bezier, halvings: u32) -> f64 {
    let [p, q, r] = arc.0;
    let centre = (p + r) * 0.5;
    let square = (p - centre).norm_squared().max((q - centre).norm_squared());
    // The circle holds the control points, and so the arc: seen from outside of it, it spans less than half a turn.
    if centre.norm_squared() > square || halvings == 0 {
        return angle(p, r);
    }
    [[0.0, 0.5], [0.5, 1.0]]
        .map(|half| spanned(&arc.part(half), halvings - 1))
        .iter()
        .sum()
}

/// Turns of a boundary round a point that is not on it: 1 inside, 0 outside, others where the boundary runs through itself.
pub(super) fn turns(shape: &Shape, point: Vector2<f64>) -> f64 {
    let each = shape
        .arcs
        .iter()
        .map(|nodes| spanned(&Bezier::of(nodes, point), MOST_HALVINGS));
    each.sum::<f64>() / std::f64::consts::TAU
}

/// The same of a point on the boundary, at `s` from 0 to 1 of an arc: 1/2 where one side of it is inside and the other outside.
pub(super) fn turns_on(shape: &Shape, arc: usize, s: f64) -> f64 {
    let point = Bezier::of(&shape.arcs[arc], Vector2::zeros()).at(s);
    let each = shape.arcs.iter().enumerate().map(|(k, nodes)| {
        let arc_about = Bezier::of(nodes, point);
        if k != arc {
            return spanned(&arc_about, MOST_HALVINGS);
        }
        // Each side of it lies in the triangle of which the point is a corner.
        let ([p, q, _], [_, e, f]) = (arc_about.part([0.0, s]).0, arc_about.part([s, 1.0]).0);
        angle(p, q) + angle(e, f)
    });
    each.sum::<f64>() / std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of four arcs and a square hole in it.
    fn washer() -> Shape {
        let round = |k: u32, by: f64| {
            let angle = (f64::from(k) + by) * std::f64::consts::FRAC_PI_2;
            Vector2::new(3.0 + angle.cos(), 4.0 + angle.sin())
        };
        let mut arcs: Vec<[Vector2<f64>; 3]> = (0..4).map(|k| [0.0, 0.5, 1.0].map(|by| round(k, by))).collect();
        let hole = [(3.2, 4.2), (3.2, 3.8), (2.8, 3.8), (2.8, 4.2)].map(|(x, y)| Vector2::new(x, y));
        arcs.extend((0..4).map(|k| {
            let (p, q) = (hole[k], hole[(k + 1) % 4]);
            [p, (p + q) * 0.5, q]
        }));
        Shape::of_arcs(arcs)
    }

    #[test]
    fn points_are_inside_outside_or_in_the_hole() {
        let shape = washer();
        for (x, y, expected) in [
            (3.0, 4.0, 0.0),
            (3.5, 4.0, 1.0),
            (3.2 + 1e-13, 4.0, 1.0),
            (3.2 - 1e-13, 4.0, 0.0),
            (4.0 - 1e-13, 4.0, 1.0),
            (4.0 + 1e-13, 4.0, 0.0),
            (9.0, 4.0, 0.0),
            // Along the lines of the hole's sides and through its corners.
            (3.2, 4.5, 1.0),
            (3.4, 4.4, 1.0),
        ] {
            let found = turns(&shape, Vector2::new(x, y));
            assert!((found - expected).abs() < 1e-2, "{x} {y}: {found}");
        }
        for arc in 0..8 {
            for s in [1e-9, 0.3, 0.5, 0.999] {
                assert!((turns_on(&shape, arc, s) - 0.5).abs() < 1e-2, "{arc} {s}");
            }
        }
    }
}
