//! A hand that glides over a patient's skin with an ultrasound probe, above bone that lies near it.

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tool, checked};
use phantom::Phantom;

/// From here on it is bone, HU, as the simulated scanner has it.
const BONE_HU: f64 = 300.0;
/// Below it is air, HU.
const AIR_HU: f64 = -500.0;
/// Bone that is nearer to the skin or further from it is passed by, mm.
const DEPTH_MM: std::ops::RangeInclusive<f64> = 8.0..=62.0;
/// Lines around the body: heights, mm.
const HEIGHTS_MM: [f64; 7] = [-20.0, -32.0, -44.0, -56.0, -68.0, -82.0, -96.0];
/// Places on one of them, rad apart: 5 mm on the skin.
const APART_RAD: f64 = 0.035;

/// Where the probe is held on the skin, one place after the other.
pub(crate) fn places(patient: &Phantom, seed: u64) -> Vec<Rigid<Ct, Tool>> {
    let mut all = Vec::new();
    for (line, z) in HEIGHTS_MM.into_iter().enumerate() {
        // The patient lies on his back: the sides and the front can be reached.
        let steps = (3.6 / APART_RAD) as u32;
        for step in 0..steps {
            let step = if line % 2 == 0 { step } else { steps - 1 - step };
            let azimuth = std::f64::consts::PI - 0.23 + APART_RAD * f64::from(step);
            let number = u64::from(step) + 1000 * line as u64;
            all.extend(held(patient, azimuth, z, &Chance::new(seed, number)));
        }
    }
    all
}

/// The probe above the bone that lies inwards of a place around the body; `None` where there is none near the skin.
fn held(patient: &Phantom, azimuth: f64, z: f64, chance: &Chance) -> Option<Rigid<Ct, Tool>> {
    let out = [azimuth.cos(), azimuth.sin(), 0.0];
    let at = |far: f64, from: [f64; 3], way: [f64; 3]| std::array::from_fn(|i| from[i] + far * way[i]);
    let centre = [0.0, 5.0, z];
    // From outside inwards: the skin, then bone.
    let inwards = |limit: f64, from: [f64; 3], way: [f64; 3]| {
        let hu = |far: f64| patient.hu(point(at(far, from, way)));
        (0..600).map(|i| 0.4 * f64::from(i)).find(|far| hu(*far) > limit)
    };
    let start = at(220.0, centre, out);
    let inward = out.map(|part| -part);
    let bone = at(inwards(BONE_HU, start, inward)?, start, inward);
    let normal = normal(patient, bone)?;
    // Square to the bone, as far as a hand is.
    let lean = |draw: u64| 0.12 * chance.normal(draw);
    let away = unit(std::array::from_fn(|i| normal[i] + lean(i as u64)))?;
    let above = at(120.0, bone, away);
    let depth_mm = 120.0 - inwards(AIR_HU, above, away.map(|part| -part))?;
    if !DEPTH_MM.contains(&depth_mm) {
        return None;
    }
    // Pressed into the skin a little.
    let tip = at(depth_mm - 1.0, bone, away);
    let down = away.map(|part| -part);
    // The image lies along the body's circumference, turned by the hand somewhat.
    let around = [-out[1], out[0], 0.5 * chance.normal(7)];
    let right = unit(reject(around, down))?;
    let elevation = cross(down, right);
    let columns = [right, elevation, down];
    rigid(columns, tip)
}

fn point([x, y, z]: [f64; 3]) -> Point<Ct> {
    Point::new(x, y, z)
}

/// Out of the bone, by its HU.
fn normal(patient: &Phantom, bone: [f64; 3]) -> Option<[f64; 3]> {
    let hu = |axis: usize, by: f64| {
        let mut place = bone;
        place[axis] += by;
        patient.hu(point(place))
    };
    unit(std::array::from_fn(|axis| hu(axis, -0.6) - hu(axis, 0.6)))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let long = dot(v, v).sqrt();
    (long > 1e-9).then(|| v.map(|part| part / long))
}

fn reject(v: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    let along = dot(v, from);
    std::array::from_fn(|i| v[i] - along * from[i])
}

/// The motion whose axes are these columns.
fn rigid(columns: [[f64; 3]; 3], origin: [f64; 3]) -> Option<Rigid<Ct, Tool>> {
    let rotation = nalgebra::Matrix3::from_fn(|row, column| columns[column][row]);
    let turn = nalgebra::UnitQuaternion::from_matrix(&rotation);
    let quaternion = [turn.w, turn.i, turn.j, turn.k];
    checked::rigid(quaternion, origin, 1e-6).ok()
}
