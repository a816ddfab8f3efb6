//! Rigid polygons: three parameters (II 3.2.3).

use nalgebra::Vector2;

use super::deformable::turned;
use super::{Boundary, Solid};
use crate::sparse::Triplets;

/// Why a polygon cannot be a solid. Vertices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BadPolygon {
    /// Fewer than three vertices.
    #[error("a polygon has at least 3 vertices; {found} were given")]
    TooFew {
        /// How many.
        found: usize,
    },
    /// A coordinate is not finite.
    #[error("vertex {vertex} lies at ({x}, {y}): not finite")]
    NotFinite {
        /// The vertex.
        vertex: usize,
        /// Its abscissa.
        x: f64,
        /// Its ordinate.
        y: f64,
    },
    /// Two vertices that follow one another coincide.
    #[error("vertices {vertex} and {next} coincide")]
    Repeated {
        /// The vertex.
        vertex: usize,
        /// The one after it.
        next: usize,
    },
    /// Two sides cross or touch.
    #[error("sides {first} and {second} cross or touch")]
    Crossing {
        /// A side, by its first vertex.
        first: usize,
        /// The other.
        second: usize,
    },
    /// It runs clockwise, or has no area.
    #[error("the area of the polygon is {area:e}: give its vertices counter-clockwise, not all on a line")]
    Clockwise {
        /// The signed area.
        area: f64,
    },
}

/// A rigid polygon. Parameters: the displacement of its centre of gravity, and the length of the arc `L theta` that a
/// point at the radius of gyration `L` has turned through.
#[derive(Debug, Clone)]
pub struct Rigid {
    centre: Vector2<f64>,
    gyration: f64,
    weight: Vector2<f64>,
    /// Vertices and, after them, middles of the sides, from the centre.
    arms: Vec<Vector2<f64>>,
    boundary: Boundary,
}

impl Rigid {
    /// A polygon with its vertices counter-clockwise. `weight` is the force on a unit of area.
    ///
    /// # Errors
    /// [`BadPolygon`].
    pub fn new(vertices: &[Vector2<f64>], weight: Vector2<f64>) -> Result<Self, BadPolygon> {
        check(vertices)?;
        let (area, centre, inertia) = moments(vertices);
        // Coordinates near the limits of numbers may overflow to NaN, which is not `<= 0`.
        if area.is_nan() || area <= 0.0 {
            return Err(BadPolygon::Clockwise { area });
        }
        let n = vertices.len();
        let middle = |k: usize| (vertices[k] + vertices[(k + 1) % n]) * 0.5;
        let points: Vec<Vector2<f64>> = vertices.iter().copied().chain((0..n).map(middle)).collect();
        let arcs = (0..n).map(|k| [k, n + k, (k + 1) % n]).collect();
        let mut boundary = Boundary::new(arcs, |node| points[node]);
        boundary.straight = true;
        Ok(Self {
            centre,
            // With the arc at this radius a turn has the unit of length, and counts like a shift of the same size.
            gyration: (inertia / area).sqrt(),
            weight: weight * area,
            arms: points.iter().map(|p| p - centre).collect(),
            boundary,
        })
    }

    /// The centre of gravity in the reference configuration.
    pub fn centre(&self) -> Vector2<f64> {
        self.centre
    }

    /// The angle of its parameters, radians.
    pub fn angle(&self, a: &[f64]) -> f64 {
        a[2] / self.gyration
    }

    /// An arm in its current direction.
    fn arm(&self, a: &[f64], node: usize) -> Vector2<f64> {
        let arm = self.arms[node];
        arm + turned(arm, self.angle(a))
    }
}

fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Area, centre, and second moment about the centre, summed about the first vertex.
fn moments(vertices: &[Vector2<f64>]) -> (f64, Vector2<f64>, f64) {
    // About a vertex: far from zero the areas of the fan would be differences of large numbers.
    let origin = vertices[0];
    let (mut area, mut first, mut second) = (0.0, Vector2::zeros(), 0.0);
    for k in 1..vertices.len() - 1 {
        let (p, q) = (vertices[k] - origin, vertices[k + 1] - origin);
        let triangle = 0.5 * cross(p, q);
        area += triangle;
        first += (p + q) * (triangle / 3.0);
        second += triangle / 6.0 * (p.norm_squared() + p.dot(&q) + q.norm_squared());
    }
    let mean = first / area;
    // Steiner's theorem moves the second moment to the centre.
    (area, origin + mean, second - area * mean.norm_squared())
}

fn check(vertices: &[Vector2<f64>]) -> Result<(), BadPolygon> {
    let n = vertices.len();
    if n < 3 {
        return Err(BadPolygon::TooFew { found: n });
    }
    if let Some(vertex) = vertices.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
        let (x, y) = (vertices[vertex].x, vertices[vertex].y);
        return Err(BadPolygon::NotFinite { vertex, x, y });
    }
    if let Some(vertex) = (0..n).find(|k| vertices[*k] == vertices[(k + 1) % n]) {
        return Err(BadPolygon::Repeated {
            vertex,
            next: (vertex + 1) % n,
        });
    }
    for first in 0..n {
        // Sides next to one another share a vertex and always meet.
        for second in first + 2..n {
            let neighbours = (second + 1) % n == first;
            let side = |k: usize| [vertices[k], vertices[(k + 1) % n]];
            if !neighbours && meet(side(first), side(second)) {
                return Err(BadPolygon::Crossing { first, second });
            }
        }
    }
    Ok(())
}

/// True where two segments have a point in common, by the signs of four areas.
fn meet([a, b]: [Vector2<f64>; 2], [c, d]: [Vector2<f64>; 2]) -> bool {
    let side = |p, q, r| cross(q - p, r - p);
    let (s1, s2) = (side(a, b, c), side(a, b, d));
    let (s3, s4) = (side(c, d, a), side(c, d, b));
    // On the line and between the ends: where the vectors to both do not point the same way.
    let on = |s: f64, p: Vector2<f64>, q: Vector2<f64>, r: Vector2<f64>| s == 0.0 && (r - p).dot(&(r - q)) <= 0.0;
    (s1 * s2 < 0.0 && s3 * s4 < 0.0) || on(s1, a, b, c) || on(s2, a, b, d) || on(s3, c, d, a) || on(s4, c, d, b)
}

impl Solid for Rigid {
    fn parameters(&self) -> usize {
        3
    }

    fn translate(&self, a: &mut [f64], by: Vector2<f64>) {
        a[0] += by.x;
        a[1] += by.y;
    }

    fn rotate(&self, a: &mut [f64], angle: f64, centre: Vector2<f64>) {
        let by = turned(self.centre + Vector2::new(a[0], a[1]) - centre, angle);
        a[0] += by.x;
        a[1] += by.y;
        a[2] += angle * self.gyration;
    }

    /// `-m <g, u>` (II 3.17), `u` the displacement of the centre.
    fn energy(&self, a: &[f64]) -> Option<f64> {
        let energy = -(self.weight.x * a[0] + self.weight.y * a[1]);
        (energy.is_finite() && a[2].is_finite()).then_some(energy)
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        gradient[0] -= self.weight.x;
        gradient[1] -= self.weight.y;
        self.energy(a)
    }

    /// Zero: constraints alone hold a rigid solid.
    fn hessian(&self, _a: &[f64], _convex: bool, _sink: &mut Triplets, _offset: usize) -> Option<()> {
        Some(())
    }

    fn weight(&self, forces: &mut [f64]) {
        forces[0] += self.weight.x;
        forces[1] += self.weight.y;
    }

    fn least_determinant(&self, _a: &[f64]) -> f64 {
        1.0
    }

    fn stiffness_scale(&self) -> f64 {
        0.0
    }

    fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    fn point(&self, a: &[f64], node: usize) -> Vector2<f64> {
        self.centre + self.arm(a, node) + Vector2::new(a[0], a[1])
    }

    fn point_about(&self, a: &[f64], node: usize, origin: Vector2<f64>) -> Vector2<f64> {
        (self.centre - origin) + self.arm(a, node) + Vector2::new(a[0], a[1])
    }

    fn rows(&self, a: &[f64], node: usize, visit: &mut dyn FnMut(usize, Vector2<f64>)) {
        let arm = self.arm(a, node);
        visit(0, Vector2::x());
        visit(1, Vector2::y());
        visit(2, Vector2::new(-arm.y, arm.x) / self.gyration);
    }

    fn swerve(&self, step: &[f64], node: usize) -> f64 {
        // The centripetal acceleration `omega^2 r` of a turn at constant speed.
        (step[2] / self.gyration).powi(2) * self.arms[node].norm()
    }

    fn bend(&self, a: &[f64], node: usize, force: Vector2<f64>, sink: &mut Triplets, offset: usize) {
        // The arm turns by `a / L`: its second derivative is `-arm / L^2`.
        let second = -self.arm(a, node).dot(&force) / (self.gyration * self.gyration);
        sink.add(offset + 2, offset + 2, second);
    }
}
