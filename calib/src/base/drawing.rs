//! The base as drawn: a plane and three V grooves.

use geometry::{Base, Direction, Point};
use nalgebra::{Matrix6, Vector3};

use super::Refused;
use super::feature::Feature;
use super::solve::{Hold, open};

/// A V groove: the line along its bottom, from end to end, and half the angle between its walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Groove {
    /// One end of the bottom line.
    pub start: Point<Base>,
    /// The other end.
    pub end: Point<Base>,
    /// Half the angle between the walls, rad.
    pub half_angle_rad: f64,
}

/// The plate's plane and its three grooves, in the base's frame.
///
/// Grooves end: a base whose grooves were endless lines through one point could be turned half round unseen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawing {
    plane: Point<Base>,
    normal: Direction<Base>,
    grooves: [Groove; 3],
}

/// Half angles outside this range are no grooves, rad.
const HALF_ANGLE: std::ops::RangeInclusive<f64> = 0.01..=1.56;
/// A groove makes at least this angle with the plane's normal, rad.
const TO_NORMAL: f64 = 0.2;
/// Shorter than this is no line, mm.
const SHORTEST_MM: f64 = 1e-3;
/// A drawing must hold the base at least this well when touched from end to end.
const MAX_CONDITION: f64 = 1e3;

impl Drawing {
    /// A plane through `plane` whose normal points to the side that is touched, and three grooves cut into it.
    ///
    /// # Errors
    /// [`Refused::DrawingNotFinite`], [`Refused::BadGroove`], and [`Refused::Unsolvable`] where touches all over the
    /// plane and the grooves would leave a motion open: three parallel grooves leave the slide along them.
    pub fn new(plane: Point<Base>, normal: Direction<Base>, grooves: [Groove; 3]) -> Result<Self, Refused> {
        let drawing = Self { plane, normal, grooves };
        if !finite(plane) {
            return Err(Refused::DrawingNotFinite(Feature::Plane));
        }
        for (k, g) in grooves.iter().enumerate() {
            check(k, g, normal)?;
        }
        drawing.solvable()?;
        Ok(drawing)
    }

    /// A point of the plane.
    pub const fn plane(&self) -> Point<Base> {
        self.plane
    }

    /// The plane's normal, to the side that is touched.
    pub const fn normal(&self) -> Direction<Base> {
        self.normal
    }

    /// The grooves.
    pub const fn grooves(&self) -> &[Groove; 3] {
        &self.grooves
    }

    /// Where the centre of a ball of `radius` mm is held that touches the feature: on the plane, `radius` above it; in a
    /// groove, `radius / sin(half angle)` above its bottom line, between its two walls.
    pub(super) fn hold(&self, feature: Feature, radius: f64) -> Hold {
        let normal = Vector3::from(self.normal.components());
        match feature {
            Feature::Plane => Hold {
                axes: [normal, Vector3::zeros()],
                count: 1,
                at: Vector3::from(self.plane.mm()) + normal * radius,
                along: None,
            },
            Feature::Groove(k) => {
                // `touches::check` refuses other numbers; the bound only rules out a panic.
                let g = &self.grooves[k.min(2)];
                let start = Vector3::from(g.start.mm());
                let line = Vector3::from(g.end.mm()) - start;
                let length = line.norm();
                let along = line / length;
                // Across the groove, towards the plate's upper side: a groove may run downwards.
                let up = normal - along * normal.dot(&along);
                // `check` keeps grooves 0.2 rad from the normal, so that this has a length.
                let up = up.try_normalize(0.0).unwrap_or(normal);
                Hold {
                    axes: [up, along.cross(&up)],
                    count: 2,
                    // In the cross-section the centre, the bottom and the point of contact make a right triangle with
                    // the half angle at the bottom and the radius opposite: the centre is radius / sin above.
                    at: start + up * (radius / g.half_angle_rad.sin()),
                    along: Some((along, length)),
                }
            }
        }
    }

    /// Both ends of each groove.
    pub(super) fn ends(&self) -> [Vector3<f64>; 6] {
        let [a, b, c] = self.grooves;
        [a.start, a.end, b.start, b.end, c.start, c.end].map(|p| Vector3::from(p.mm()))
    }

    /// Touches at the ends of the grooves and on the plane beside them: the best that the drawing allows.
    fn solvable(&self) -> Result<(), Refused> {
        let ends = self.ends();
        let centre = ends.iter().sum::<Vector3<f64>>() / 6.0;
        let radius = (ends.iter().map(|e| (e - centre).norm_squared()).sum::<f64>() / 6.0).sqrt();
        let mut normal = Matrix6::zeros();
        for (i, end) in ends.iter().enumerate() {
            for feature in [Feature::Plane, Feature::Groove(i / 2)] {
                let hold = self.hold(feature, 0.0);
                for axis in hold.axes() {
                    // The base lies at the identity: the condition is the same in all poses.
                    let row = super::solve::row(axis, &(end - centre), radius);
                    normal += row * row.transpose();
                }
            }
        }
        let (condition, free) = open(&normal);
        if condition <= MAX_CONDITION {
            return Ok(());
        }
        Err(Refused::Unsolvable {
            free,
            condition,
            allowed: MAX_CONDITION,
        })
    }
}

fn finite(p: Point<Base>) -> bool {
    p.mm().iter().all(|x| x.is_finite())
}

fn check(groove: usize, g: &Groove, normal: Direction<Base>) -> Result<(), Refused> {
    if !finite(g.start) || !finite(g.end) || !g.half_angle_rad.is_finite() {
        return Err(Refused::DrawingNotFinite(Feature::Groove(groove)));
    }
    let line = g.end - g.start;
    let (length_mm, half_angle_rad) = (line.norm(), g.half_angle_rad);
    // A groove without length has no direction; along the normal it is refused below by both its length and its angle.
    let along = line.direction().unwrap_or(normal);
    // By atan2, which keeps its digits where the cosine is near 1; a groove runs either way, hence the size of the
    // cosine.
    let to_normal_rad = along.cross(normal).norm().atan2(along.dot(normal).abs());
    if length_mm >= SHORTEST_MM && HALF_ANGLE.contains(&half_angle_rad) && to_normal_rad >= TO_NORMAL {
        return Ok(());
    }
    Err(Refused::BadGroove {
        groove,
        length_mm,
        half_angle_rad,
        to_normal_rad,
    })
}
