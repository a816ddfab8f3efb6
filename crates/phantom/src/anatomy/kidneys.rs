//! Kidneys in their fat, with cortex, medulla, sinus and a little of the ureter.

use super::FAT_HU;
use crate::canvas::{Canvas, Solid};
use crate::plan::Plan;
use crate::structure;
use crate::surface::Surface;
use crate::vec3::{Vec3, add, mirror, scale, upright};

const CORTEX_HU: f64 = 178.0;
const MEDULLA_HU: f64 = 142.0;

/// Paints both kidneys; the right one lies lower.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    let sides = [
        (-1.0, 118.0, plan.shifts[2], structure::KIDNEY_RIGHT),
        (1.0, 130.0, plan.shifts[3], structure::KIDNEY_LEFT),
    ];
    for (side, z, shift, structure) in sides {
        let centre = add([side * 62.0, plan.spine_y + 11.0, z], shift);
        paint_kidney(plan, canvas, (centre, side), structure);
    }
}

fn paint_kidney(plan: &Plan, canvas: &mut Canvas, (centre, side): (Vec3, f64), structure: u16) {
    let here = |offset: Vec3| add(centre, mirror(offset, side));
    // The upper pole leans to the spine and to the back.
    let axes = upright([side * -0.22, 0.16, 1.0]);
    let kidney = Surface::Ellipsoid {
        centre,
        axes,
        semi: scale([28.0, 24.0, 54.0], plan.organ_size),
    };
    let sinus = Surface::Ellipsoid {
        centre: here([-15.0, -4.0, 0.0]),
        axes,
        semi: [21.0, 11.0, 27.0],
    };
    canvas.tissue(FAT_HU, kidney.grown(6.0));
    let cortex = Solid::tissue(CORTEX_HU + plan.enhancement, kidney.clone());
    canvas.add(cortex.of(Some(structure)));
    paint_medulla(plan, canvas, here);
    // What is within belongs to the kidney, though not all of it is tissue.
    let sinus = Solid::tissue(FAT_HU + 10.0, sinus).and(kidney.grown(4.0));
    canvas.add(sinus.of(None));
    let pelvis = [(here([-4.0, -3.0, 2.0]), 5.0), (here([-22.0, -8.0, -10.0]), 3.5)];
    canvas.vessel(12.0, &pelvis);
}

/// Pyramids: small bodies between sinus and cortex, fanned around the hilum.
fn paint_medulla(plan: &Plan, canvas: &mut Canvas, here: impl Fn(Vec3) -> Vec3) {
    for (z, reach) in [
        (-36.0, 2.0),
        (-22.0, 10.0),
        (-7.0, 14.0),
        (8.0, 14.0),
        (23.0, 9.0),
        (36.0, 0.0),
    ] {
        for dy in [-9.0, 9.0] {
            let centre = here([reach - 2.0 - 0.2 * z, dy + 0.16 * z, z]);
            let pyramid = Surface::ellipsoid(centre, [6.5, 6.0, 5.5]);
            canvas.add(Solid::tissue(MEDULLA_HU + plan.enhancement, pyramid).of(None));
        }
    }
}
