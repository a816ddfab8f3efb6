//! The pelvis: muscles inside and outside, iliac wings, hips, sacrum, bladder and rectum.

use super::{BONE_HU, FAT_HU, GAS_HU, MUSCLE_HU};
use crate::canvas::{Canvas, Solid};
use crate::plan::Plan;
use crate::surface::{STRAIGHT, Surface};
use crate::vec3::{add, mirror, upright};

/// Paints everything below the iliac crests but the spine and the vessels.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    paint_muscles(plan, canvas);
    paint_wings(canvas);
    paint_hips(canvas);
    paint_sacrum(plan, canvas);
    paint_pelvic_organs(canvas);
}

/// The funnel on which the wings lie, moved outwards by `by` mm.
fn funnel(by: f64) -> Surface {
    Surface::ellipsoid([0.0, -8.0, 25.0], [120.0, 84.0, 152.0]).grown(by)
}

/// Seen from the side, the wing is what lies in this ellipse; moved outwards by `by` mm.
fn wing_outline(by: f64) -> Surface {
    Surface::Drum {
        centre: [0.0, 22.0, -62.0],
        axes: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        semi: [63.0 + by, 92.0 + by, 170.0],
    }
}

/// Gluteal muscles outside the wings, the obturators below them, iliacus inside, and the fat of the pelvis.
fn paint_muscles(plan: &Plan, canvas: &mut Canvas) {
    let under_skin = Surface::Trunk(plan.skin.inset(14.0, 12.0, 14.0));
    for side in [-1.0, 1.0] {
        let masses = [
            ([118.0, 26.0, -62.0], [38.0, 60.0, 88.0]),
            ([66.0, 70.0, -96.0], [58.0, 34.0, 74.0]),
            ([62.0, 14.0, -128.0], [52.0, 46.0, 34.0]),
        ];
        for (centre, semi) in masses {
            let mass = Surface::ellipsoid(mirror(centre, side), semi);
            canvas.add(Solid::tissue(MUSCLE_HU, mass).and(under_skin.clone()));
        }
    }
    canvas.add(Solid::tissue(MUSCLE_HU, funnel(0.0)).and(wing_outline(3.0)));
    canvas.add(Solid::tissue(FAT_HU, funnel(-20.0)).and(wing_outline(40.0)));
}

/// Curved plates: the funnel's wall, 9 mm thick, cut to the outline, the sacral joint and the sciatic notch.
fn paint_wings(canvas: &mut Canvas) {
    for side in [-1.0, 1.0] {
        for (hu, thin) in [(BONE_HU[0], 0.0), (BONE_HU[1], 1.8)] {
            let wing = Solid::tissue(hu, funnel(-thin))
                .without(funnel(-10.0 + thin))
                .and(wing_outline(-thin))
                .below([-side, 0.0, 0.0], [side * (38.0 + thin), 0.0, 0.0])
                .without(Surface::ellipsoid(
                    [side * 60.0, 62.0, -98.0],
                    [60.0, 34.0 + thin, 34.0 + thin],
                ));
            canvas.add(wing);
        }
    }
}

/// The sockets' roofs and the heads of the femurs; the scan ends in the middle of them.
fn paint_hips(canvas: &mut Canvas) {
    for side in [-1.0, 1.0] {
        let centre = mirror([92.0, 2.0, -122.0], side);
        let ball = |radius| Surface::Ball { centre, radius };
        canvas.bone([650.0, 280.0], 2.0, ball(33.0));
        canvas.tissue(60.0, ball(26.0));
        canvas.bone([600.0, 330.0], 2.0, ball(24.0));
    }
}

/// A wedge leaning backwards with the openings of its nerves.
fn paint_sacrum(plan: &Plan, canvas: &mut Canvas) {
    let top = plan.spine_at(-0.5 * plan.pitch);
    let tilt = [0.0, -0.46, 1.0];
    let axes = upright(tilt);
    let wedge = Surface::Ellipsoid {
        centre: add(top, [0.0, 22.0, -34.0]),
        axes,
        semi: [55.0, 17.0, 72.0],
    };
    for (hu, thin) in [(BONE_HU[0], 0.0), (BONE_HU[1], 1.8)] {
        let cut = add(top, [0.0, 0.0, -5.0 - thin]);
        canvas.add(Solid::tissue(hu, wedge.grown(-thin)).below(axes[2], cut));
    }
    for (row, x) in [(0.0, 22.0), (1.0, 19.0), (2.0, 16.0)] {
        for side in [-1.0, 1.0] {
            let middle = add(top, mirror([x, 16.0 + 13.0 * row, -27.0 - 22.0 * row], side));
            let ends = [add(middle, [0.0, -18.0, -6.0]), add(middle, [0.0, 18.0, 6.0])];
            canvas.tissue(FAT_HU, Surface::tube(ends, 4.0));
            canvas.tissue(30.0, Surface::tube(ends, 2.0));
        }
    }
}

fn paint_pelvic_organs(canvas: &mut Canvas) {
    let bladder = Surface::ellipsoid([2.0, -42.0, -112.0], [40.0, 30.0, 30.0]);
    canvas.tissue(45.0, bladder.clone());
    canvas.tissue(8.0, bladder.grown(-3.0));
    let rectum = Surface::Ellipsoid {
        centre: [-3.0, 44.0, -108.0],
        axes: STRAIGHT,
        semi: [19.0, 15.0, 48.0],
    };
    canvas.tissue(50.0, rectum.clone());
    canvas.tissue(-20.0, rectum.grown(-4.0));
    canvas.tissue(GAS_HU, Surface::ellipsoid([-3.0, 37.0, -106.0], [7.0, 4.5, 14.0]));
}
