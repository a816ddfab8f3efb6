//! The closed surfaces that everything in the patient is made of.
//!
//! Each gives its *coverage* at a point: 0 on and outside the surface, 1 from `edge` mm inside it on, and between them
//! the quintic ramp 6t^5 - 15t^4 + 10t^3 of the depth. The ramp lies wholly inside, so that a surface's bounding box holds
//! all of it; [`Surface::grown`] by half an edge puts the half value on the nominal surface.
//!
//! Depth is exact for balls, half-spaces, the caps of drums and tubes of constant radius; for the curved others it is the
//! first-order estimate F / |grad F| of an implicit F, whose relative error grows with depth / radius of curvature.

use crate::trunk::TrunkWall;
use crate::vec3::{Vec3, add, dot, norm, scale, sub};

/// A closed or half-infinite solid; lengths in mm, patient axes.
#[derive(Debug, Clone)]
pub(crate) enum Surface {
    /// A sphere.
    Ball { centre: Vec3, radius: f64 },
    /// An ellipsoid whose semi-axes lie along the orthonormal rows of `axes`.
    Ellipsoid { centre: Vec3, axes: [Vec3; 3], semi: Vec3 },
    /// An elliptic cylinder: semi-axes `semi[0]`, `semi[1]`, flat ends at +-`semi[2]` along the third axis.
    Drum { centre: Vec3, axes: [Vec3; 3], semi: Vec3 },
    /// A segment with round ends whose radius goes smoothly from one end's to the other's.
    Tube { ends: [Vec3; 2], radii: [f64; 2] },
    /// The points p with `normal` . p <= `offset`; `normal` is a unit vector.
    HalfSpace { normal: Vec3, offset: f64 },
    /// The trunk at some depth under the skin.
    Trunk(TrunkWall),
}

/// The patient's own axes.
pub(crate) const STRAIGHT: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// 6t^5 - 15t^4 + 10t^3 with t = depth / edge held to 0..1: twice continuously differentiable.
pub(crate) fn ramp(depth: f64, edge: f64) -> f64 {
    if depth >= edge {
        return 1.0;
    }
    let t = (depth / edge).max(0.0);
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

impl Surface {
    /// An ellipsoid along the patient's axes.
    pub(crate) fn ellipsoid(centre: Vec3, semi: Vec3) -> Self {
        Self::Ellipsoid {
            centre,
            axes: STRAIGHT,
            semi,
        }
    }

    /// A tube of constant radius.
    pub(crate) fn tube(ends: [Vec3; 2], radius: f64) -> Self {
        Self::Tube {
            ends,
            radii: [radius; 2],
        }
    }

    /// The same surface moved outwards by `by` mm (inwards where negative).
    pub(crate) fn grown(&self, by: f64) -> Self {
        let mut grown = self.clone();
        match &mut grown {
            Self::Ball { radius, .. } => *radius += by,
            Self::Ellipsoid { semi, .. } | Self::Drum { semi, .. } => *semi = semi.map(|r| r + by),
            Self::Tube { radii, .. } => *radii = radii.map(|r| r + by),
            Self::HalfSpace { offset, .. } => *offset += by,
            Self::Trunk(wall) => *wall = wall.deeper(-by),
        }
        grown
    }

    /// How much of the point `p` is inside, 0 to 1, with a ramp of `edge` mm inside the surface.
    pub(crate) fn coverage(&self, p: Vec3, edge: f64) -> f64 {
        match self {
            Self::Ball { centre, radius } => ramp(radius - norm(sub(p, *centre)), edge),
            Self::Ellipsoid { centre, axes, semi } => ramp(ellipsoid_depth(local(p, *centre, axes), *semi), edge),
            Self::Drum { centre, axes, semi } => {
                let q = local(p, *centre, axes);
                let side = ramp(ellipsoid_depth([q[0], q[1], 0.0], *semi), edge);
                side * ramp(semi[2] - q[2].abs(), edge)
            }
            Self::Tube { ends, radii } => ramp(tube_depth(p, *ends, *radii), edge),
            Self::HalfSpace { normal, offset } => ramp(offset - dot(*normal, p), edge),
            Self::Trunk(wall) => ramp(wall.depth(p), edge),
        }
    }

    /// The box (smallest, largest corner) outside which the coverage is zero.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Ball { centre, radius } => around(*centre, [*radius; 3]),
            Self::Ellipsoid { centre, axes, semi } => {
                let reach = |i: usize| norm([semi[0] * axes[0][i], semi[1] * axes[1][i], semi[2] * axes[2][i]]);
                around(*centre, std::array::from_fn(reach))
            }
            Self::Drum { centre, axes, semi } => {
                let reach = |i: usize| (0..3).map(|a| semi[a] * axes[a][i].abs()).sum();
                around(*centre, std::array::from_fn(reach))
            }
            Self::Tube { ends, radii } => {
                let r = radii[0].max(radii[1]);
                let low = std::array::from_fn(|i| ends[0][i].min(ends[1][i]) - r);
                (low, std::array::from_fn(|i| ends[0][i].max(ends[1][i]) + r))
            }
            Self::HalfSpace { normal, offset } => half_space_bounds(*normal, *offset),
            Self::Trunk(wall) => wall.bounds(),
        }
    }
}

fn around(centre: Vec3, reach: Vec3) -> (Vec3, Vec3) {
    (sub(centre, reach), add(centre, reach))
}

fn local(p: Vec3, centre: Vec3, axes: &[Vec3; 3]) -> Vec3 {
    let d = sub(p, centre);
    [dot(axes[0], d), dot(axes[1], d), dot(axes[2], d)]
}

/// (1 - |q/r|^2) / (2 |q/r^2|): infinite at the centre, which the ramp takes for full coverage.
fn ellipsoid_depth(q: Vec3, r: Vec3) -> f64 {
    let u = [q[0] / r[0], q[1] / r[1], q[2] / r[2]];
    let slope = norm([u[0] / r[0], u[1] / r[1], u[2] / r[2]]);
    (1.0 - dot(u, u)) / (2.0 * slope)
}

fn tube_depth(p: Vec3, ends: [Vec3; 2], radii: [f64; 2]) -> f64 {
    let axis = sub(ends[1], ends[0]);
    let d = sub(p, ends[0]);
    let t = (dot(d, axis) / dot(axis, axis)).clamp(0.0, 1.0);
    // The radius has no slope at either end, so that tube and round end meet without a kink.
    let s = t * t * (3.0 - 2.0 * t);
    radii[0] + (radii[1] - radii[0]) * s - norm(sub(d, scale(axis, t)))
}

/// Only a half-space across a patient axis bounds anything.
fn half_space_bounds(normal: Vec3, offset: f64) -> (Vec3, Vec3) {
    let (mut low, mut high) = ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
    for i in 0..3 {
        if normal[i] == 1.0 {
            high[i] = offset;
        } else if normal[i] == -1.0 {
            low[i] = -offset;
        }
    }
    (low, high)
}
