//! How the probe is held in the shipped scenes of `config/ultrasound`: the files there are made here.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::calib_sweep::probe::{gliding, sounding};
use geometry::{Ct, Frame, Phantom, Point, Rigid, Tool, Vector};

/// A round of a gesture, s, and from pose to pose.
const ROUND_S: f64 = 20.0;
const STEP_S: f64 = 0.05;
/// The middle of the wires, and how far above it the probe's face is held, mm.
const MIDDLE_MM: [f64; 3] = [20.0, 20.0, 15.0];
const ABOVE_MM: f64 = 38.0;

fn turned<A: Frame, B: Frame>(turn: [f64; 3], shift: [f64; 3]) -> Rigid<A, B> {
    let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
    Rigid::from_rotation_vector(vector(turn), vector(shift)).unwrap()
}

/// Where the tank's phantom is measured to stand in the room: `wires.xml` in the marker of the scenes, the phantom's z up to the front.
fn ct_from_phantom() -> Rigid<Ct, Phantom> {
    turned([FRAC_PI_2, 0.0, 0.0], [-20.0, 0.0, -20.0])
}

/// Rows along the phantom's x, beams down, the face here.
fn upright(face_mm: [f64; 3]) -> Rigid<Phantom, Tool> {
    turned([PI, 0.0, 0.0], face_mm)
}

fn round(pose: impl Fn(f64) -> Rigid<Phantom, Tool>) -> String {
    let steps = (ROUND_S / STEP_S).round() as u32;
    let timed = |i: u32| (f64::from(i) * STEP_S, pose(TAU * f64::from(i) / f64::from(steps)));
    csv((0..=steps)
        .map(timed)
        .map(|(t_s, pose)| (t_s, ct_from_phantom() * pose)))
}

fn csv(poses: impl Iterator<Item = (f64, Rigid<Ct, Tool>)>) -> String {
    let mut csv = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned();
    for (t_s, pose) in poses {
        let ([w, x, y, z], [a, b, c]) = (pose.quaternion(), pose.translation_mm());
        // A nanometre and a nanoradian.
        csv += &format!("{t_s:.2},{w:.9},{x:.9},{y:.9},{z:.9},{a:.6},{b:.6},{c:.6}\n");
    }
    csv
}

/// Over the wires, leaning to all sides by 17 degrees, along them, and nearer and further; slowly, as `calib probe --window-ms` takes the
/// way for straight.
pub(super) fn tank() -> String {
    round(|k| {
        let [x, y, z] = MIDDLE_MM;
        let lean = [0.3 * k.sin(), 0.25 * k.cos(), 0.3 * (2.0 * k).sin()];
        let about: Rigid<Phantom, Phantom> = turned([0.0; 3], MIDDLE_MM);
        let face = [x, y + 8.0 * (2.0 * k + 1.0).sin(), z + ABOVE_MM + 6.0 * (3.0 * k).sin()];
        about * turned::<Phantom, Phantom>(lean, [0.0; 3]) * about.inverse() * upright(face)
    })
}

/// Up and down over the flat bottom, beside the wires, at changing speed.
pub(super) fn bottom() -> String {
    round(|k| upright([130.0, 20.0, -5.0 + 7.0 * (7.0 * k).sin() + 5.0 * (11.0 * k + 1.0).sin()]))
}

/// From place to place over the patient's skin, as in the test of a sweep.
pub(super) fn patient(patient: &phantom::Phantom) -> String {
    gliding(&sounding::places(patient, 1))
}

/// The tip at rest on a place of the patient, the tool upright before him.
pub(super) fn touch(place: Point<Ct>) -> String {
    let pose = turned([-FRAC_PI_2, 0.0, 0.0], place.mm());
    csv([(0.0, pose)].into_iter())
}
