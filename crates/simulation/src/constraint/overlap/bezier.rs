//! Quadratic arcs by their control points, and parts of them.

use nalgebra::Vector2;

/// A box: its low and its high corner.
pub(super) type Bounds = [Vector2<f64>; 2];

/// An arc, or a part of one: it lies in the triangle of its control points. Parameters run from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bezier(pub(super) [Vector2<f64>; 3]);

impl Bezier {
    /// The arc of these three nodes, about an origin.
    pub(super) fn of(nodes: &[Vector2<f64>; 3], origin: Vector2<f64>) -> Self {
        let [first, middle, last] = nodes.map(|x| x - origin);
        // At 1/2 the arc is `(p + 2 q + r) / 4`, which must be the middle node.
        Self([first, middle * 2.0 - (first + last) * 0.5, last])
    }

    /// The bilinear form of which the arc is the diagonal.
    fn blossom(&self, s: f64, t: f64) -> Vector2<f64> {
        let [p, q, r] = self.0;
        p * ((1.0 - s) * (1.0 - t)) + q * (s * (1.0 - t) + (1.0 - s) * t) + r * (s * t)
    }

    pub(super) fn at(&self, s: f64) -> Vector2<f64> {
        self.blossom(s, s)
    }

    /// The derivative by the parameter.
    pub(super) fn slope(&self, s: f64) -> Vector2<f64> {
        let [p, q, r] = self.0;
        ((q - p) * (1.0 - s) + (r - q) * s) * 2.0
    }

    /// The part between two parameters.
    pub(super) fn part(&self, [from, to]: [f64; 2]) -> Self {
        // The control points of a part are the blossom at `(from, from)`, `(from, to)` and `(to, to)`.
        Self([self.at(from), self.blossom(from, to), self.at(to)])
    }

    /// A box round its control points.
    pub(super) fn bounds(&self) -> Bounds {
        let [p, q, r] = self.0;
        [p.inf(&q).inf(&r), p.sup(&q).sup(&r)]
    }

    /// The larger side of that box.
    pub(super) fn size(&self) -> f64 {
        let [low, high] = self.bounds();
        (high - low).amax()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::nearest::combine;
    use crate::q9::shape::{line, line_slope};

    #[test]
    fn parts_are_the_same_curve() {
        let nodes = [(3.0, 1.0), (4.2, 1.5), (5.0, 0.7)].map(|(x, y)| Vector2::new(x, y));
        let origin = Vector2::new(1.0, -2.0);
        let (arc, part) = (Bezier::of(&nodes, origin), [0.3, 0.55]);
        for k in 0..=10 {
            let s = f64::from(k) / 10.0;
            let (whole, u) = (part[0] + (part[1] - part[0]) * s, 2.0 * part[0] + 0.5 * s - 1.0);
            let expected = combine(&nodes, line(u)) - origin;
            assert!((arc.at(whole) - expected).amax() < 1e-14);
            assert!((arc.part(part).at(s) - expected).amax() < 1e-14);
            assert!((arc.slope(whole) - combine(&nodes, line_slope(u)) * 2.0).amax() < 1e-14);
        }
    }
}
