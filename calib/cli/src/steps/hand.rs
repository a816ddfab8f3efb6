//! What the simulated hand does at each step.

use bus::message::{Practice, PracticeFrame, PracticeMotion};
use geometry::{Ct, Direction, Frame, Point, Rigid, Tool, Vector};

/// Half opening of the cone in which a tip is turned, rad.
const CONE_RAD: f64 = 0.6;
/// How far the shaft leans at a touch, rad: no two touches are held alike.
const LEAN_RAD: f64 = 0.25;
/// The handle is in front of the patient: the shaft points backwards.
const BACKWARDS: [f64; 3] = [0.0, 1.0, 0.0];

/// The tip in the divot, turned to all sides.
pub fn pivot(divot: Point<Ct>) -> Practice {
    in_patient(held(divot, direction(BACKWARDS), 0), PracticeMotion::Pivot(CONE_RAD))
}

/// The tip in the divot, spun about the shaft.
pub fn spin(divot: Point<Ct>) -> Practice {
    in_patient(held(divot, direction(BACKWARDS), 0), PracticeMotion::Spin)
}

/// The tip on a point of the patient; the `count`-th touch.
pub fn touch(point: Point<Ct>, count: usize) -> Practice {
    in_patient(held(point, direction(BACKWARDS), count), PracticeMotion::Hold)
}

/// The tip on a point of the base, whose plate is touched from above; the `count`-th touch.
pub fn touch_base(point: Point<geometry::Base>, above: Direction<geometry::Base>, count: usize) -> Practice {
    let into = (above.vector() * -1.0).direction().unwrap_or(above);
    Practice {
        place: PracticeFrame::Base(held(point, into, count)),
        motion: PracticeMotion::Hold,
    }
}

/// The tool in its seat, where nobody holds it.
pub fn seat(base_from_tool: Rigid<geometry::Base, Tool>) -> Practice {
    Practice {
        place: PracticeFrame::Base(base_from_tool),
        motion: PracticeMotion::Rest,
    }
}

/// The scripted way to the target and back.
pub fn approach() -> Practice {
    in_patient(Rigid::identity(), PracticeMotion::Approach)
}

fn in_patient(pose: Rigid<Ct, Tool>, motion: PracticeMotion) -> Practice {
    Practice {
        place: PracticeFrame::Patient(pose),
        motion,
    }
}

/// A direction of constants that are not all 0.
fn direction<F: Frame>([x, y, z]: [f64; 3]) -> Direction<F> {
    Vector::new(x, y, z).direction().unwrap_or(Direction::Z)
}

/// The tool with its tip at a point and its shaft along a direction, leant a little to a side that changes with `count`.
fn held<F: Frame>(tip: Point<F>, along: Direction<F>, count: usize) -> Rigid<F, Tool> {
    let z = Direction::<F>::Z.vector();
    let across = z.cross(along.vector());
    // Straight against +z any turn by half a round about an axis across does.
    let axis = across.direction().unwrap_or(Direction::X);
    let angle = across.norm().atan2(z.dot(along.vector()));
    let turned = Rigid::<F, F>::from_rotation_vector(axis.vector() * angle, Vector::new(0.0, 0.0, 0.0));
    let lean = LEAN_RAD * f64::from(u8::from(count > 0));
    let side = 2.4 * count as f64;
    let leant = Rigid::<F, Tool>::from_rotation_vector(
        Vector::new(lean * side.cos(), lean * side.sin(), 0.0),
        Vector::new(0.0, 0.0, 0.0),
    );
    // Angles below a whole turn are rotations.
    let (turned, leant) = (turned.unwrap_or(Rigid::identity()), leant.unwrap_or(Rigid::identity()));
    let [x, y, w] = tip.mm();
    Rigid::from_parts((turned * leant).rotation(), Vector::new(x, y, w))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tip_is_on_the_point_and_the_shaft_points_into_it() {
        let tip = Point::<Ct>::new(10.0, -20.0, 30.0);
        for (along, count) in [
            ([0.0, 1.0, 0.0], 0),
            ([0.0, 0.0, -1.0], 0),
            ([0.0, 0.0, 1.0], 0),
            ([1.0, -1.0, 0.3], 5),
        ] {
            let along: Direction<Ct> = direction(along);
            let pose = held(tip, along, count);
            assert!((pose * Point::<Tool>::new(0.0, 0.0, 0.0)).distance(tip) < 1e-12);
            let shaft = (pose * Direction::<Tool>::Z).vector();
            let lean = if count == 0 { 1.0 } else { LEAN_RAD.cos() };
            // 1e-12: a dozen roundings of numbers below 1.
            assert!((shaft.dot(along.vector()) - lean).abs() < 1e-12, "{along:?}");
        }
    }
}
