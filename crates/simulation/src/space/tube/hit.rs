//! A straight way against a round cone: where it first touches.
//!
//! A round cone is convex and is bounded by parts of its two spheres and of its side, so the first touch is the first of
//! the touches of these, the side's counted between its ends only. Each is the root of a quadratic `a t^2 + 2 b t + c`,
//! whose discriminant `b^2 - a c` is written as a product of sum and difference of two lengths (Lagrange's identity for the
//! form of the cone): squares that nearly agree at grazing incidence are never subtracted.

use nalgebra::Vector3;

use super::cone::{Ball, Cone, Side};

/// The least `t` in `[0, 1]` with `x + t d` in the closed cone whose radii are larger by `growth`.
pub(super) fn first(cone: &Cone, x: &Vector3<f64>, d: &Vector3<f64>, growth: f64) -> Option<f64> {
    // A start inside is answered first: the roots would tell where the way leaves.
    if cone.value(x) <= growth {
        return Some(0.0);
    }
    let ends = [&cone.first, &cone.last].map(|ball| ball_touch(ball, x, d, growth));
    let side = cone.side.as_ref().and_then(|side| side_touch(cone, side, x, d, growth));
    ends.into_iter().chain([side]).flatten().reduce(f64::min)
}

fn ball_touch(ball: &Ball, x: &Vector3<f64>, d: &Vector3<f64>, growth: f64) -> Option<f64> {
    let radius = ball.radius + growth;
    let m = x - ball.centre;
    let far = m.norm();
    let (speed, moment) = (d.norm(), m.cross(d).norm());
    let quadratic = Quadratic {
        a: speed * speed,
        b: m.dot(d),
        // As a product: close to the sphere the difference of squares would cancel.
        c: (far - radius) * (far + radius),
        discriminant: (radius * speed - moment) * (radius * speed + moment),
    };
    quadratic.roots()?.into_iter().filter(on_way).reduce(f64::min)
}

fn side_touch(cone: &Cone, side: &Side, x: &Vector3<f64>, d: &Vector3<f64>, growth: f64) -> Option<f64> {
    let radius = cone.first.radius + growth;
    let m = x - cone.first.centre;
    let quadratic = side_quadratic(side, radius, &m, d);
    let between = |t: &f64| {
        let (along, across) = side.split(&(m + d * *t));
        // The form has a second, mirrored cone behind the apex.
        let ahead = radius - side.sine * along >= 0.0;
        ahead && (0.0..=side.length).contains(&side.foot(along, across.norm()))
    };
    quadratic
        .roots()?
        .into_iter()
        .filter(on_way)
        .filter(between)
        .reduce(f64::min)
}

/// `cosine^2 rho^2 = (radius - sine t)^2` along the way.
fn side_quadratic(side: &Side, radius: f64, m: &Vector3<f64>, d: &Vector3<f64>) -> Quadratic {
    let Side {
        along, sine, cosine, ..
    } = *side;
    let ((t, across), (dt, d_across)) = (side.split(m), side.split(d));
    let (rho, left) = (cosine * across.norm(), radius - sine * t);
    let fall = d_across.norm();
    let moment = m.cross(d);
    let (turn, moment_across) = side.split(&moment);
    let reach = (moment_across * sine - along.cross(d) * radius).norm();
    let turn = cosine * turn.abs();
    Quadratic {
        a: (cosine * fall - sine * dt) * (cosine * fall + sine * dt),
        b: cosine * cosine * across.dot(&d_across) + sine * dt * left,
        c: (rho - left) * (rho + left),
        discriminant: cosine * cosine * (reach - turn) * (reach + turn),
    }
}

/// `a t^2 + 2 b t + c`, with `discriminant = b^2 - a c`.
#[derive(Debug, Clone, Copy)]
struct Quadratic {
    a: f64,
    b: f64,
    c: f64,
    discriminant: f64,
}

impl Quadratic {
    /// Both roots, NaN or infinite where the degree is less; none where there is no real one.
    fn roots(&self) -> Option<[f64; 2]> {
        // A NaN passes and makes the roots NaN, which lie on no way.
        if self.discriminant < 0.0 {
            return None;
        }
        // The sum of two numbers of one sign; the other root by the product of the roots.
        let sum = -(self.b + self.discriminant.sqrt().copysign(self.b));
        Some([sum / self.a, self.c / sum])
    }
}

fn on_way(t: &f64) -> bool {
    (0.0..=1.0).contains(t)
}
