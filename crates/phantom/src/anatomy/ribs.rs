//! The lower ribs: chains of short rods along the muscular wall, falling forwards.

use super::BONE_HU;
use crate::canvas::Canvas;
use crate::plan::Plan;
use crate::surface::Surface;
use crate::vec3::Vec3;

/// One rib: where it leaves the spine and how it runs.
struct Rib {
    /// z at the spine, mm.
    head_z: f64,
    /// How far it reaches around the trunk: 0 at the back's middle, 1 at the belly's.
    reach: f64,
    /// How much lower its tip lies, mm.
    fall: f64,
}

/// Twelfth to eighth. The lowest tip stays above the flank's way to the aorta.
const RIBS: [Rib; 5] = [
    Rib {
        head_z: 196.0,
        reach: 0.33,
        fall: 58.0,
    },
    Rib {
        head_z: 230.0,
        reach: 0.52,
        fall: 92.0,
    },
    Rib {
        head_z: 262.0,
        reach: 0.74,
        fall: 118.0,
    },
    Rib {
        head_z: 294.0,
        reach: 0.86,
        fall: 140.0,
    },
    Rib {
        head_z: 326.0,
        reach: 0.92,
        fall: 164.0,
    },
];
/// Rods per rib.
const RODS: u32 = 14;

/// Paints both sides' ribs in the wall.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    for rib in &RIBS {
        for side in [-1.0, 1.0] {
            paint_rib(plan, canvas, rib, side);
        }
    }
}

fn paint_rib(plan: &Plan, canvas: &mut Canvas, rib: &Rib, side: f64) {
    let at = |s: u32| station(plan, rib, side, f64::from(s) / f64::from(RODS));
    let rods: Vec<Surface> = (0..RODS)
        .map(|s| Surface::Tube {
            ends: [at(s), at(s + 1)],
            radii: [4.3, 4.3],
        })
        .collect();
    // First every cortex, then every marrow: no wall of cortex stays across the rib where two rods meet.
    rods.iter().for_each(|rod| canvas.tissue(BONE_HU[0], rod.clone()));
    rods.iter().for_each(|rod| canvas.tissue(BONE_HU[1], rod.grown(-1.7)));
}

/// The rib's middle at share `s` of its length: on the wall, `s` of the way around and down.
fn station(plan: &Plan, rib: &Rib, side: f64, s: f64) -> Vec3 {
    let angle = std::f64::consts::PI * (0.12 + s * (rib.reach - 0.12));
    let z = rib.head_z - rib.fall * s.powf(0.9);
    let [x, y, _] = plan
        .muscle_wall()
        .deeper(8.0)
        .exit([0.0, 10.0, z], [side * angle.sin(), angle.cos()]);
    [x, y, z]
}
