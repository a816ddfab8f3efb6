//! One triangle, and the place of it that is nearest to a point.

use nalgebra::Vector3;

/// The corners of a triangle: what the search for a nearest place reads, and nothing else.
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    pub(crate) a: Vector3<f64>,
    pub(crate) b: Vector3<f64>,
    pub(crate) c: Vector3<f64>,
}

/// The pseudo-normals of a triangle, its edges and its corners (Baerentzen and Aanaes 2005): with the one at the nearest place, the sign
/// of the scalar product says on which side of the whole surface a point is.
#[derive(Debug, Clone)]
pub(crate) struct Normals {
    /// Of the face, of length 1; zero where it has no area.
    pub(super) face: Vector3<f64>,
    /// Of the edges ab, bc, ca.
    pub(super) edges: [[f32; 3]; 3],
    /// Of the corners.
    pub(super) corners: [[f32; 3]; 3],
    /// Bits 0 to 2: edges on an open border; 3 to 5: corners on one.
    pub(super) open: u8,
    /// At the corners, of the smooth surface that the facets stand for: the sum by angle of the faces there that are turned by less than
    /// a crease against this one.
    pub(super) smooth: [[f32; 3]; 3],
    /// By how much that surface bulges over this triangle, mm.
    pub(crate) bulge_mm: f32,
}

/// The place of a triangle that is nearest to a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near {
    pub(crate) distance2: f64,
    pub(crate) place: Vector3<f64>,
    part: Part,
}

/// The nearest place of a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Foot {
    pub(crate) distance2: f64,
    pub(crate) place: Vector3<f64>,
    /// The triangle, by its place in the tree.
    pub(crate) triangle: u32,
    /// Pseudo-normal there, of any length.
    pub(crate) normal: Vector3<f64>,
    /// Whether the place is on an open border.
    pub(crate) is_open: bool,
}

fn wide(n: [f32; 3]) -> Vector3<f64> {
    Vector3::new(n[0].into(), n[1].into(), n[2].into())
}

/// A part of a triangle.
#[derive(Debug, Clone, Copy)]
enum Part {
    Face,
    Edge(usize),
    Corner(usize),
}

impl Triangle {
    /// The nearest place (Ericson 2005, section 5.1.5).
    #[inline]
    pub(crate) fn near(&self, p: &Vector3<f64>) -> Near {
        let (place, part) = self.nearest(p);
        Near {
            distance2: (p - place).norm_squared(),
            place,
            part,
        }
    }

    #[inline]
    fn nearest(&self, p: &Vector3<f64>) -> (Vector3<f64>, Part) {
        let Self { a, b, c } = self;
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return (*a, Part::Corner(0));
        }
        let bp = p - b;
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return (*b, Part::Corner(1));
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (a + ab * (d1 / (d1 - d3)), Part::Edge(0));
        }
        let cp = p - c;
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return (*c, Part::Corner(2));
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (a + ac * (d2 / (d2 - d6)), Part::Edge(2));
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            return (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Part::Edge(1));
        }
        // A triangle without area never comes here but by rounding: then any place of it will do.
        let sum = va + vb + vc;
        let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        (a + ab * (vb * share) + ac * (vc * share), Part::Face)
    }
}

impl Normals {
    /// The nearest place with what is known there.
    pub(super) fn foot(&self, near: &Near, triangle: u32) -> Foot {
        let normal = match near.part {
            Part::Face => self.face,
            Part::Edge(k) => wide(self.edges[k]),
            Part::Corner(k) => wide(self.corners[k]),
        };
        Foot {
            distance2: near.distance2,
            place: near.place,
            triangle,
            normal,
            is_open: self.is_open(near),
        }
    }

    /// Whether a place is on an open border.
    pub(crate) fn is_open(&self, near: &Near) -> bool {
        let bit = match near.part {
            Part::Face => 0,
            Part::Edge(k) => 1 << k,
            Part::Corner(k) => 8 << k,
        };
        self.open & bit != 0
    }

    /// The normal, at a place of its triangle, of the smooth surface that the facets stand for: between those of the corners (Phong 1975).
    pub(super) fn smooth(&self, Triangle { a, b, c }: &Triangle, place: &Vector3<f64>) -> Vector3<f64> {
        let (ab, ac, ap) = (b - a, c - a, place - a);
        let (bb, bc, cc) = (ab.norm_squared(), ab.dot(&ac), ac.norm_squared());
        let (pb, pc) = (ap.dot(&ab), ap.dot(&ac));
        let whole = bb * cc - bc * bc;
        if whole <= 0.0 {
            return self.face;
        }
        let (v, w) = ((cc * pb - bc * pc) / whole, (bb * pc - bc * pb) / whole);
        let corner = |k: usize| wide(self.smooth[k]).try_normalize(0.0).unwrap_or(self.face);
        let sum = corner(0) * (1.0 - v - w) + corner(1) * v + corner(2) * w;
        sum.try_normalize(1e-9).unwrap_or(self.face)
    }
}

impl Foot {
    /// Signed distance and its gradient. On the surface itself, where the way to it has no direction, that of the pseudo-normal.
    #[inline]
    pub(crate) fn signed(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let way = p - self.place;
        let distance = self.distance2.sqrt();
        let sign = if way.dot(&self.normal) < 0.0 { -1.0 } else { 1.0 };
        // Below this the direction is that of the rounding of coordinates of a metre.
        if distance < 1e-9 {
            let normal = self.normal.try_normalize(0.0).unwrap_or_else(Vector3::x);
            return (sign * distance, normal);
        }
        (sign * distance, way * (sign / distance))
    }
}
