//! A round cone: the spheres along a segment, centre and radius linear.
//!
//! At a place with coordinate `t` along the segment and `rho` away from its line, the sphere centred at `t'` is
//! `sqrt((t - t')^2 + rho^2) - (r - s t')` away, with `s` the loss of radius by length. That is convex in `t'`, least at
//! `t' = t - rho s / c`, `c = sqrt(1 - s^2)`, where it is `c rho + s t - r`; beyond the ends, at the end's sphere.

use nalgebra::{Matrix3, Vector3};

use super::distance::Distance;

/// Nearer to the axis than this part of the radius, the direction to it is rounding.
const AXIS_PART: f64 = 1e-12;

/// The sphere at an end, with the direction that stands for the normal at its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ball {
    pub(super) centre: Vector3<f64>,
    pub(super) radius: f64,
}

/// What lies between the spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Side {
    /// Unit vector from the first centre to the last.
    pub(super) along: Vector3<f64>,
    pub(super) length: f64,
    /// Loss of radius by length: the sine of the half opening.
    pub(super) sine: f64,
    /// Above zero.
    pub(super) cosine: f64,
}

/// One segment of a tube, in the tube's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cone {
    pub(super) first: Ball,
    pub(super) last: Ball,
    /// None where one sphere holds the other: both ends are then the larger one.
    pub(super) side: Option<Side>,
    /// A unit vector square to the segment: the normal where none exists.
    square: Vector3<f64>,
}

/// The part of a cone that a place is nearest to.
#[derive(Debug, Clone, Copy)]
enum Foot<'a> {
    Ball(&'a Ball),
    Side(&'a Side),
}

impl Cone {
    /// Between two centres with their radii, which are finite and above zero.
    pub(super) fn new(first: (Vector3<f64>, f64), last: (Vector3<f64>, f64)) -> Self {
        let [first, last] = [first, last].map(|(centre, radius)| Ball { centre, radius });
        let between = last.centre - first.centre;
        let length = between.norm();
        let loss = first.radius - last.radius;
        if length > loss.abs() {
            let along = between / length;
            // As a product: near sine 1 the difference of squares would cancel.
            let cosine = ((length - loss) * (length + loss)).sqrt() / length;
            let sine = loss / length;
            // The product may underflow where one sphere all but holds the other: there is no side then.
            if cosine > 0.0 {
                return Self {
                    first,
                    last,
                    side: Some(Side {
                        along,
                        length,
                        sine,
                        cosine,
                    }),
                    square: square_to(&along),
                };
            }
        }
        let larger = if loss >= 0.0 { first } else { last };
        Self {
            first: larger,
            last: larger,
            side: None,
            square: Vector3::x(),
        }
    }

    /// Signed distance alone.
    pub(super) fn value(&self, x: &Vector3<f64>) -> f64 {
        match self.foot(x) {
            Foot::Ball(ball) => ball.value(x),
            Foot::Side(side) => {
                let (t, across) = side.split(&(x - self.first.centre));
                side.value(t, across.norm(), self.first.radius)
            }
        }
    }

    /// Signed distance with its derivatives.
    pub(super) fn distance(&self, x: &Vector3<f64>) -> Distance {
        match self.foot(x) {
            Foot::Ball(ball) => ball.distance(x, &self.square),
            Foot::Side(side) => self.distance_to_side(side, x),
        }
    }

    fn foot(&self, x: &Vector3<f64>) -> Foot<'_> {
        let Some(side) = &self.side else {
            return Foot::Ball(&self.first);
        };
        let (t, across) = side.split(&(x - self.first.centre));
        let foot = side.foot(t, across.norm());
        // Exactly at an end its sphere answers, so that the jump of the second derivative has one side only.
        if foot <= 0.0 {
            Foot::Ball(&self.first)
        } else if foot >= side.length {
            Foot::Ball(&self.last)
        } else {
            Foot::Side(side)
        }
    }

    fn distance_to_side(&self, side: &Side, x: &Vector3<f64>) -> Distance {
        let (t, across) = side.split(&(x - self.first.centre));
        let rho = across.norm();
        let value = side.value(t, rho, self.first.radius);
        let radius = self.first.radius - side.sine * t;
        let (out, bend) = if rho > AXIS_PART * radius {
            (across / rho, side.cosine / rho)
        } else {
            (self.square, 0.0)
        };
        // Straight along the cone, so only the direction around the axis bends.
        let around = side.along.cross(&out);
        Distance {
            value,
            gradient: out * side.cosine + side.along * side.sine,
            hessian: around * around.transpose() * bend,
        }
    }
}

impl Ball {
    fn value(&self, x: &Vector3<f64>) -> f64 {
        (x - self.centre).norm() - self.radius
    }

    fn distance(&self, x: &Vector3<f64>, spare: &Vector3<f64>) -> Distance {
        let from = x - self.centre;
        let far = from.norm();
        let (out, hessian) = if far > AXIS_PART * self.radius {
            let out = from / far;
            (out, (Matrix3::identity() - out * out.transpose()) / far)
        } else {
            // The curvature has no bound here: zero keeps a matrix made of it finite.
            (*spare, Matrix3::zeros())
        };
        Distance {
            value: far - self.radius,
            gradient: out,
            hessian,
        }
    }
}

impl Side {
    /// Coordinate along the segment, and what is left across it.
    pub(super) fn split(&self, from_first: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let t = from_first.dot(&self.along);
        (t, from_first - self.along * t)
    }

    /// Where along the segment the nearest sphere sits, ends not minded.
    pub(super) fn foot(&self, t: f64, rho: f64) -> f64 {
        t - rho * (self.sine / self.cosine)
    }

    fn value(&self, t: f64, rho: f64, radius: f64) -> f64 {
        self.cosine * rho + self.sine * t - radius
    }
}

/// A unit vector square to a unit vector.
fn square_to(along: &Vector3<f64>) -> Vector3<f64> {
    // Away from the axis that it leans to most, so that the product is never short.
    let helper = Vector3::ith(along.iamin(), 1.0);
    let square = along.cross(&helper);
    square / square.norm()
}
