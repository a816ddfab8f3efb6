//! The simulated hand that does what it is told: for practising calibration, registration and check.
//!
//! Where the tool is remains a function of the script's time, the seed and the orders given so far, each with its time: a frame that is
//! computed late shows what was ordered when it was captured.

use std::f64::consts::TAU;

use bus::message::{Practice, PracticeFrame, PracticeMotion};
use chance::Chance;
use geometry::{Ct, Rigid, Tool, Vector};
use scene::operating_room::PracticeRoom;

use crate::gesture::Gesture;

/// How long the hand takes from one thing to the next, s.
const GO_S: f64 = 1.2;
/// The hand trembles at about these frequencies, Hz: a physiological tremor.
const TREMOR_HZ: [f64; 3] = [7.9, 9.1, 10.3];
/// A round of the tip's turning to all sides, and of the direction it leans to, s.
const LEAN_S: f64 = 4.0;
const AROUND_S: f64 = 3.1;
/// A spin by half a turn and back, s.
const SPIN_S: f64 = 8.0;
/// How far to either side, rad.
const SPIN_RAD: f64 = 1.6;

/// A hand that does its gesture until it is told something else.
#[derive(Debug, Clone)]
pub struct Practised {
    room: PracticeRoom,
    gesture: Gesture,
    seed: u64,
    /// In the order of their times.
    orders: Vec<Order>,
}

/// What the hand was told, and when.
#[derive(Debug, Clone)]
struct Order {
    t_s: f64,
    /// Where the tool was then.
    from: Rigid<Ct, Tool>,
    /// Where it is to be, or about what it is to move.
    place: Rigid<Ct, Tool>,
    motion: PracticeMotion,
}

impl Practised {
    /// A hand that does `gesture`.
    pub fn new(room: PracticeRoom, gesture: Gesture, seed: u64) -> Self {
        Self {
            room,
            gesture,
            seed,
            orders: Vec::new(),
        }
    }

    /// From script time `t_s` on it does something else.
    pub fn order(&mut self, practice: &Practice, t_s: f64) {
        let place = match (practice.place, practice.motion) {
            (PracticeFrame::Patient(pose), PracticeMotion::Hold) => self.touched(pose),
            (PracticeFrame::Patient(pose), _) => pose,
            // The plate, its grooves and the seat guide the tool: nobody misses them.
            (PracticeFrame::Base(pose), _) => self.room.ct_from_base * pose,
        };
        let order = Order {
            t_s,
            from: self.ct_from_tool(t_s),
            place,
            motion: practice.motion,
        };
        self.orders.push(order);
    }

    /// The true pose at script time `t_s`.
    pub fn ct_from_tool(&self, t_s: f64) -> Rigid<Ct, Tool> {
        let given = self.orders.partition_point(|order| order.t_s <= t_s);
        let Some(order) = given.checked_sub(1).and_then(|last| self.orders.get(last)) else {
            return self.gesture.ct_from_tool(t_s);
        };
        let since_s = t_s - order.t_s;
        let there = self.moved(order, (since_s - GO_S).max(0.0));
        match since_s < GO_S {
            true => between(order.from, there, since_s / GO_S),
            false => there,
        }
    }

    /// Where a person's hand ends up that is to touch a point of the patient: not quite there.
    fn touched(&self, place: Rigid<Ct, Tool>) -> Rigid<Ct, Tool> {
        let chance = Chance::new(self.seed, self.orders.len() as u64);
        let off = std::array::from_fn(|axis| chance.normal(axis as u64) * self.room.touch_error_mm);
        shifted(place, off)
    }

    fn moved(&self, order: &Order, t_s: f64) -> Rigid<Ct, Tool> {
        match order.motion {
            PracticeMotion::Approach => self.gesture.ct_from_tool(t_s),
            PracticeMotion::Hold => shifted(order.place, self.tremor_mm(t_s)),
            PracticeMotion::Rest => order.place,
            PracticeMotion::Pivot(half_rad) => {
                let lean = half_rad * (TAU * t_s / LEAN_S).sin();
                let (sin, cos) = (TAU * t_s / AROUND_S).sin_cos();
                turned(order.place, [lean * cos, lean * sin, 0.0])
            }
            PracticeMotion::Spin => turned(order.place, [0.0, 0.0, SPIN_RAD * (TAU * t_s / SPIN_S).sin()]),
        }
    }

    /// Three sines along each axis, whose mean square is that of the room.
    fn tremor_mm(&self, t_s: f64) -> [f64; 3] {
        let amplitude = self.room.tremor_mm * (2.0 / TREMOR_HZ.len() as f64).sqrt();
        std::array::from_fn(|axis| {
            let phase = |k: usize| 2.1 * axis as f64 + 1.3 * k as f64;
            let sines = TREMOR_HZ
                .iter()
                .enumerate()
                .map(|(k, hz)| (TAU * hz * t_s + phase(k)).sin());
            amplitude * sines.sum::<f64>()
        })
    }
}

fn shifted(pose: Rigid<Ct, Tool>, [x, y, z]: [f64; 3]) -> Rigid<Ct, Tool> {
    Rigid::from_parts(pose.rotation(), pose.translation() + Vector::new(x, y, z))
}

/// The tool turned about its own tip, by this rotation vector in its own axes, rad.
fn turned(pose: Rigid<Ct, Tool>, [x, y, z]: [f64; 3]) -> Rigid<Ct, Tool> {
    let turn = Rigid::<Tool, Tool>::from_rotation_vector(Vector::new(x, y, z), Vector::new(0.0, 0.0, 0.0));
    // Angles below a whole turn are rotations.
    pose * turn.unwrap_or(Rigid::identity())
}

/// From one pose to another, beginning and ending gently.
fn between(from: Rigid<Ct, Tool>, to: Rigid<Ct, Tool>, share: f64) -> Rigid<Ct, Tool> {
    let share = share * share * (3.0 - 2.0 * share);
    let tip = from.translation() + (to.translation() - from.translation()) * share;
    Rigid::from_parts(from.rotation().slerp(to.rotation(), share), tip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Base, Direction, Point};
    use scene::Scene;
    use std::path::Path;

    fn hand() -> Practised {
        let text = "[tracker]\nsource = \"operating-room\"\n[tracker.room.practice]\ntouch_error_mm = 0.0\ntremor_mm = 0.0\n\
                    ct_from_base = { translation_mm = [300, 0, 100] }";
        let scene = Scene::parse(text, Path::new("s.toml")).unwrap();
        let scene::TrackerSource::OperatingRoom(room) = scene.tracker.source else {
            panic!("{text}")
        };
        let gesture = Gesture::new(&room.approach, Point::new(0.0, 0.0, 0.0), None);
        Practised::new(room.practice.unwrap(), gesture.unwrap(), 7)
    }

    fn pose(x: f64) -> Rigid<Ct, Tool> {
        Rigid::from_rotation_vector(Vector::new(0.3, 0.1, -0.2), Vector::new(x, 20.0, 30.0)).unwrap()
    }

    fn tip(pose: Rigid<Ct, Tool>) -> Point<Ct> {
        pose * Point::<Tool>::new(0.0, 0.0, 0.0)
    }

    #[test]
    fn the_hand_goes_there_without_a_jump_and_what_was_before_stays_as_it_was() {
        let mut hand = hand();
        let before: Vec<_> = (0..50).map(|i| hand.ct_from_tool(f64::from(i) * 0.1)).collect();
        hand.order(
            &Practice {
                place: PracticeFrame::Patient(pose(100.0)),
                motion: PracticeMotion::Hold,
            },
            5.0,
        );
        assert!((0..50).all(|i| hand.ct_from_tool(f64::from(i) * 0.1) == before[i as usize]));
        assert!(tip(hand.ct_from_tool(5.0)).distance(tip(hand.ct_from_tool(4.999_999))) < 1e-3);
        assert!(tip(hand.ct_from_tool(5.0 + GO_S)).distance(Point::new(100.0, 20.0, 30.0)) < 1e-12);
        assert_eq!(hand.ct_from_tool(9.0), pose(100.0));
    }

    #[test]
    fn a_tip_in_the_divot_stays_there_and_the_shaft_opens_the_cone() {
        let mut hand = hand();
        let practice = |motion| Practice {
            place: PracticeFrame::Patient(pose(1.0)),
            motion,
        };
        hand.order(&practice(PracticeMotion::Pivot(0.6)), 0.0);
        let axis = |pose: Rigid<Ct, Tool>| (pose * Direction::<Tool>::Z).vector();
        let mut widest = 0.0_f64;
        for i in 0..600 {
            let now = hand.ct_from_tool(GO_S + f64::from(i) / 60.0);
            // 1e-12 mm: roundings of places of 100 mm.
            assert!(tip(now).distance(tip(pose(1.0))) < 1e-12);
            widest = widest.max(axis(now).dot(axis(pose(1.0))).clamp(-1.0, 1.0).acos());
        }
        assert!((0.59..0.601).contains(&widest), "{widest}");
        hand.order(&practice(PracticeMotion::Spin), 20.0);
        for i in 0..600 {
            let now = hand.ct_from_tool(20.0 + GO_S + f64::from(i) / 60.0);
            assert!(tip(now).distance(tip(pose(1.0))) < 1e-12);
            assert!(axis(now).dot(axis(pose(1.0))) > 1.0 - 1e-12);
        }
    }

    #[test]
    fn a_place_on_the_base_is_where_the_base_stands_and_the_script_goes_on_after_it() {
        let mut hand = hand();
        let on_base = Rigid::<Base, Tool>::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), Vector::new(1.0, 2.0, 3.0));
        hand.order(
            &Practice {
                place: PracticeFrame::Base(on_base.unwrap()),
                motion: PracticeMotion::Hold,
            },
            1.0,
        );
        assert!(tip(hand.ct_from_tool(3.0)).distance(Point::new(301.0, 2.0, 103.0)) < 1e-12);
        hand.order(
            &Practice {
                place: PracticeFrame::Patient(Rigid::identity()),
                motion: PracticeMotion::Approach,
            },
            4.0,
        );
        let gesture = hand.gesture.ct_from_tool(1.0);
        assert_eq!(hand.ct_from_tool(4.0 + GO_S + 1.0), gesture);
    }

    #[test]
    fn touches_err_and_tremble_as_the_room_says() {
        let mut hand = hand();
        (hand.room.touch_error_mm, hand.room.tremor_mm) = (0.5, 0.1);
        let (mut off, mut tremor) = (0.0, 0.0);
        for i in 0..400 {
            let t_s = 10.0 * f64::from(i);
            let practice = Practice {
                place: PracticeFrame::Patient(pose(1.0)),
                motion: PracticeMotion::Hold,
            };
            hand.order(&practice, t_s);
            let order = hand.orders.last().unwrap();
            off += tip(order.place).distance(tip(pose(1.0))).powi(2);
            let place = tip(order.place);
            tremor += tip(hand.ct_from_tool(t_s + 2.0 + 0.0137 * f64::from(i)))
                .distance(place)
                .powi(2);
        }
        // Root mean squares of 1200 numbers: deviations of 2 % of 0.5 and 0.1; four of them.
        let rms = |sum: f64| (sum / 1200.0).sqrt();
        assert!((rms(off) - 0.5).abs() < 0.04, "{}", rms(off));
        assert!((rms(tremor) - 0.1).abs() < 0.01, "{}", rms(tremor));
    }

    /// The hand missed the plate, the grooves and the seat as it misses a point of the patient, and no base was ever found.
    #[test]
    fn the_calibration_base_guides_the_tool() {
        let mut hand = hand();
        (hand.room.touch_error_mm, hand.room.tremor_mm) = (0.5, 0.1);
        let place: Rigid<Base, Tool> =
            Rigid::from_rotation_vector(Vector::new(0.3, 0.1, -0.2), Vector::new(1.0, 20.0, 30.0)).unwrap();
        let practice = Practice {
            place: PracticeFrame::Base(place),
            motion: PracticeMotion::Hold,
        };
        hand.order(&practice, 3.0);
        assert_eq!(hand.orders.last().unwrap().place, hand.room.ct_from_base * place);
        // It trembles still, and not where it is left alone.
        assert_ne!(hand.ct_from_tool(9.0), hand.room.ct_from_base * place);
        let motion = PracticeMotion::Rest;
        hand.order(&Practice { motion, ..practice }, 10.0);
        for t_s in [12.0, 12.3, 19.7] {
            assert_eq!(hand.ct_from_tool(t_s), hand.room.ct_from_base * place);
        }
    }
}
