//! Skin, fat under it, the muscular wall and the long muscles of the back.

use super::{FAT_HU, MUSCLE_HU};
use crate::canvas::{Canvas, Solid};
use crate::plan::Plan;
use crate::structure;
use crate::surface::Surface;
use crate::vec3::{add, upright};

const SKIN_HU: f64 = 10.0;
const SUBCUTANEOUS_HU: f64 = -100.0;
/// Thickness of the skin, mm.
const SKIN_MM: f64 = 2.0;

/// The trunk from outside to the fat of its cavity.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    canvas.tissue(SKIN_HU, Surface::Trunk(plan.skin));
    canvas.tissue(SUBCUTANEOUS_HU, Surface::Trunk(plan.skin.deeper(SKIN_MM)));
    canvas.tissue(MUSCLE_HU, Surface::Trunk(plan.muscle_wall()));
    canvas.tissue(FAT_HU, Surface::Trunk(plan.cavity()));
    paint_fat_stripes(plan, canvas);
    // Rectus: two bands behind the belly's fat, a white line of fat between them.
    let front = plan.muscle_wall().centre_y - plan.muscle_wall().half[1];
    canvas.tissue(
        SUBCUTANEOUS_HU,
        Surface::ellipsoid([0.0, front - 1.0, 40.0], [3.0, 7.0, 400.0]),
    );
}

/// The flank's three muscles are told apart by thin fat between them.
fn paint_fat_stripes(plan: &Plan, canvas: &mut Canvas) {
    for depth in [4.5, 9.0] {
        let outer = Surface::Trunk(plan.muscle_wall().inset(depth, depth * 0.7, depth * 1.3));
        let inner = Surface::Trunk(
            plan.muscle_wall()
                .inset(depth + 1.3, depth * 0.7 + 0.2, depth * 1.3 + 0.2),
        );
        for (side, edge_x) in [(1.0, 70.0), (-1.0, 70.0)] {
            let stripe = Solid::tissue(-60.0, outer.clone())
                .without(inner.clone())
                .below([-side, 0.0, 0.0], [side * edge_x, 0.0, 0.0]);
            canvas.add(stripe);
        }
    }
}

/// Psoas, quadratus lumborum and the erectors of the spine, on either side.
pub(crate) fn paint_back_muscles(plan: &Plan, canvas: &mut Canvas) {
    for (side, [back, psoas_of]) in [(-1.0, structure::MUSCLES_RIGHT), (1.0, structure::MUSCLES_LEFT)] {
        let psoas_axis = [side * -0.19, 0.165, 1.0];
        let psoas = Surface::Ellipsoid {
            centre: [side * 45.0, plan.spine_y - 2.0, 18.0],
            axes: upright(psoas_axis),
            semi: [17.0, 20.0, 138.0],
        };
        canvas.add(Solid::tissue(MUSCLE_HU + 4.0, psoas).of(Some(psoas_of)));
        let quadratus = Surface::Ellipsoid {
            centre: [side * 68.0, plan.spine_y + 30.0, 72.0],
            axes: upright([side * -0.18, 0.0, 1.0]),
            semi: [19.0, 8.5, 68.0],
        };
        canvas.add(Solid::tissue(MUSCLE_HU, quadratus).of(Some(back)));
        paint_erector(plan, canvas, (side, back));
    }
}

/// The erectors follow the spine's curve: one barrel per vertebra's height would show, so they are long ellipsoids.
fn paint_erector(plan: &Plan, canvas: &mut Canvas, (side, structure): (f64, u16)) {
    for (z, dx, wide) in [(175.0, 33.0, 27.0), (75.0, 33.0, 29.0), (-20.0, 27.0, 22.0)] {
        let middle = add(plan.spine_at(z), [side * dx, 46.0, 0.0]);
        let erector = Surface::Ellipsoid {
            centre: middle,
            axes: upright(plan.spine_direction(z)),
            semi: [wide, 19.0, 115.0],
        };
        // Nothing of it may come out of the muscular wall.
        let inside = Solid::tissue(MUSCLE_HU, erector).and(Surface::Trunk(plan.muscle_wall()));
        canvas.add(inside.of(Some(structure)));
    }
}
