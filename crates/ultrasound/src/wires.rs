//! Wires in water: dots, as long as the beam is thick where a wire runs aslant.

use crate::fan::{FULL_WIDTH, Fan};
use crate::field::Field;
use crate::scene::{Pose, Wire};
use crate::tissue::amplitude;

/// The level of a wire that is square to the image, dB, if the beam were as narrow as beams are apart.
const WIRE_DB: f64 = 52.0;
/// The level of side lobes beside the dot, dB, at the first one, and how they fall.
const LOBE_DB: f64 = -32.0;
/// Deviations of the beam across the image to which a wire is followed.
const REACH: f64 = 3.0;

/// Adds the wires. What hides them is left to who knows the beams' stops.
pub(crate) fn draw(wires: &[Wire], pose: &Pose, fan: &Fan, field: &mut Field) {
    for wire in wires {
        let [a, b] = wire.ends.map(|end| pose.inside(end));
        for (place, weight) in points(a, b, fan) {
            dot(place, weight, fan, field);
        }
    }
}

/// Places along the part of a wire within the beam's thickness, with their weights.
fn points(a: [f64; 3], b: [f64; 3], fan: &Fan) -> Vec<([f64; 2], f64)> {
    let depth = fan.shape.depth_mm();
    let thick = REACH * fan.elevation_mm(0.0).max(fan.elevation_mm(depth));
    let way: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
    // The shares of the way at which it enters and leaves the slab.
    let [low, high] = match way[2].abs() > 1e-9 {
        true => {
            let [s, t] = [-thick, thick].map(|side| (side - a[2]) / way[2]);
            [s.min(t).max(0.0), s.max(t).min(1.0)]
        }
        false if a[2].abs() <= thick => [0.0, 1.0],
        false => return Vec::new(),
    };
    if low >= high {
        return Vec::new();
    }
    let long = (high - low) * way.iter().map(|part| part * part).sum::<f64>().sqrt();
    // A quarter of a pulse apart they make one line; bounded, for a wire along the image is long.
    let count = (long / fan.step_mm).ceil().clamp(32.0, 4096.0) as usize;
    let each = long / count as f64;
    let place = |i: usize| {
        let share = low + (high - low) * (i as f64 + 0.5) / count as f64;
        let [x, y, aside]: [f64; 3] = std::array::from_fn(|k| a[k] + share * way[k]);
        let deviation = fan.elevation_mm(fan.locate([x, y]).1.clamp(0.0, depth));
        let fall = (-0.5 * (aside / deviation).powi(2)).exp() / (deviation * FULL_WIDTH);
        ([x, y], each * fall)
    };
    (0..count).map(place).filter(|(_, weight)| *weight > 1e-5).collect()
}

/// One place of a wire: the beam that meets it, and by their side lobes those that do not, which show it along an arc.
fn dot(place: [f64; 2], weight: f64, fan: &Fan, field: &mut Field) {
    let (beam, shown) = fan.locate(place);
    let last = (fan.beams - 1) as f64;
    if !(beam >= -0.5 && beam <= last + 0.5 && shown >= 0.0 && shown <= fan.shape.depth_mm()) {
        return;
    }
    let main = weight * amplitude(WIRE_DB);
    let first = (beam.max(0.0) as usize).min(fan.beams - 2);
    let share = (beam - first as f64).clamp(0.0, 1.0);
    field.line(first, shown, (main * (1.0 - share)) as f32);
    field.line(first + 1, shown, (main * share) as f32);
    let pitch = fan.pitch_mm(shown);
    let width = fan.lateral_beams(shown) * FULL_WIDTH;
    let lobe = main * amplitude(LOBE_DB) / width;
    for at in 0..fan.beams {
        let off = at as f64 - beam;
        let lobes = off.abs() / width;
        if (1.0..12.0).contains(&lobes) {
            // The way from the face's middle to a place beside the beam is longer: the arc.
            let far = shown.hypot(off * pitch);
            field.line(at, far, (lobe / (lobes * lobes)) as f32);
        }
    }
}
