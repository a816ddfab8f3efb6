//! Liver, gallbladder, spleen, stomach and pancreas.

use super::GAS_HU;
use crate::canvas::{Canvas, Solid};
use crate::plan::Plan;
use crate::surface::Surface;
use crate::vec3::{Vec3, add, scale, upright};

/// HU before the seed's enhancement.
const LIVER_HU: f64 = 110.0;
const SPLEEN_HU: f64 = 122.0;

/// Paints the organs of the upper belly.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    paint_liver(plan, canvas);
    paint_spleen(plan, canvas);
    paint_stomach(plan, canvas);
    let pancreas = [
        ([-34.0, -24.0, 92.0], 13.0),
        ([-18.0, -27.0, 116.0], 10.0),
        ([22.0, -22.0, 131.0], 9.0),
        ([66.0, 4.0, 146.0], 9.0),
    ];
    canvas.vessel(92.0 + plan.enhancement, &pancreas);
}

/// Everything of an organ stays 2 mm inside the cavity.
fn within(plan: &Plan, hu: f64, organ: Surface) -> Solid {
    Solid::tissue(hu, organ).and(Surface::Trunk(plan.cavity().deeper(2.0)))
}

/// Two lobes, at the patient's right, with the branches of the portal vein and the gallbladder under it.
fn paint_liver(plan: &Plan, canvas: &mut Canvas) {
    let hu = LIVER_HU + plan.enhancement;
    let at = |p: Vec3| add(p, plan.shifts[0]);
    let right = Surface::Ellipsoid {
        centre: at([-88.0, -6.0, 158.0]),
        axes: upright([0.10, 0.05, 1.0]),
        semi: scale([72.0, 84.0, 92.0], plan.organ_size),
    };
    let left = Surface::Ellipsoid {
        centre: at([-14.0, -48.0, 186.0]),
        axes: upright([0.0, 0.35, 1.0]),
        semi: scale([78.0, 34.0, 52.0], plan.organ_size),
    };
    // The hollow at the back is where kidney, cava and duodenum lie.
    let hollow = Surface::ellipsoid([-34.0, 48.0, 132.0], [50.0, 46.0, 74.0]);
    canvas.add(within(plan, hu, right).without(hollow.clone()));
    canvas.add(within(plan, hu, left).without(hollow));
    paint_portal_vein(plan, canvas, at);
    let gallbladder = Surface::Ellipsoid {
        centre: at([-58.0, -52.0, 92.0]),
        axes: upright([0.2, 0.35, 1.0]),
        semi: [15.0, 15.0, 30.0],
    };
    canvas.tissue(60.0, gallbladder.clone());
    canvas.tissue(9.0, gallbladder.grown(-2.2));
}

fn paint_portal_vein(plan: &Plan, canvas: &mut Canvas, at: impl Fn(Vec3) -> Vec3) {
    let hu = 165.0 + plan.enhancement;
    let porta = at([-48.0, -22.0, 160.0]);
    let branches: [&[(Vec3, f64)]; 4] = [
        &[([-22.0, -26.0, 122.0], 6.5), (porta, 6.5)],
        &[
            (porta, 6.0),
            (at([-88.0, -8.0, 168.0]), 4.5),
            (at([-122.0, 10.0, 160.0]), 2.0),
        ],
        &[(at([-88.0, -8.0, 168.0]), 4.0), (at([-108.0, -34.0, 186.0]), 1.8)],
        &[
            (porta, 5.0),
            (at([-22.0, -46.0, 184.0]), 3.5),
            (at([24.0, -56.0, 190.0]), 1.6),
        ],
    ];
    for branch in branches {
        canvas.vessel(hu, branch);
    }
}

fn paint_spleen(plan: &Plan, canvas: &mut Canvas) {
    let spleen = Surface::Ellipsoid {
        centre: add([112.0, 30.0, 166.0], plan.shifts[1]),
        axes: upright([-0.12, 0.25, 1.0]),
        semi: scale([30.0, 44.0, 50.0], plan.organ_size),
    };
    let hilum = Surface::ellipsoid([78.0, 14.0, 164.0], [28.0, 24.0, 40.0]);
    canvas.add(within(plan, SPLEEN_HU + plan.enhancement, spleen).without(hilum));
}

/// Wall, fluid, and gas above the fluid: the patient lies on the back, so the level is a plane of one y.
fn paint_stomach(plan: &Plan, canvas: &mut Canvas) {
    let stomach = Surface::Ellipsoid {
        centre: [64.0, -38.0, 166.0],
        axes: upright([0.42, 0.30, 1.0]),
        semi: [36.0, 34.0, 58.0],
    };
    canvas.add(within(plan, 65.0, stomach.clone()));
    canvas.add(within(plan, 22.0, stomach.grown(-4.0)));
    let gas = within(plan, GAS_HU, stomach.grown(-5.0)).below([0.0, 1.0, 0.0], [0.0, -54.0, 0.0]);
    canvas.add(gas);
}
