//! Aorta, vena cava, their branches to kidneys and bowel, and the iliac vessels.

use crate::canvas::Canvas;
use crate::plan::Plan;
use crate::structure::{AORTA, ILIAC_ARTERIES, ILIAC_VEINS, VENA_CAVA};
use crate::vec3::{Vec3, add, lerp, mirror};

const ARTERY_HU: f64 = 300.0;
const VEIN_HU: f64 = 150.0;
/// Radii, mm.
const AORTA_MM: f64 = 9.5;
const CAVA_MM: f64 = 11.0;
const ILIAC_MM: f64 = 5.5;
/// x of the two great vessels, mm: the aorta at the left, the cava at the right.
const AORTA_X: f64 = 12.0;
const CAVA_X: f64 = -17.0;

/// y of a vessel of radius `radius` that lies on the front of the spine at height `z`.
fn vessel_y(plan: &Plan, z: f64, radius: f64) -> f64 {
    plan.spine_at(z)[1] - 17.0 - radius - 2.5
}

/// Middle of the aorta at height `z`, above its bifurcation at L4.
pub(crate) fn aorta_at(plan: &Plan, z: f64) -> Vec3 {
    [AORTA_X, vessel_y(plan, z, AORTA_MM), z]
}

/// Middle of the vena cava at height `z`; from the kidneys up it swings forwards to the liver.
pub(crate) fn cava_at(plan: &Plan, z: f64) -> Vec3 {
    let forwards = 0.0009 * (z - 120.0).max(0.0).powi(2);
    [CAVA_X, vessel_y(plan, z, CAVA_MM) + 2.0 - forwards, z]
}

/// Middles of the iliac artery of one side (+1 left), from the aorta's bifurcation down to the groin.
pub(crate) fn iliac_artery(plan: &Plan, side: f64) -> [Vec3; 4] {
    let start = aorta_at(plan, 26.0);
    let fork = mirror([33.0, plan.spine_y - 24.0, -26.0], side);
    let brim = mirror([49.0, plan.spine_y - 42.0, -70.0], side);
    [start, fork, brim, mirror([66.0, -44.0, -132.0], side)]
}

/// Paints veins first: an artery crosses in front of them.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    paint_veins(plan, canvas);
    let column = |at: fn(&Plan, f64) -> Vec3, radius| {
        (0..=16)
            .map(|i| (at(plan, 26.0 + 12.0 * f64::from(i)), radius))
            .collect::<Vec<_>>()
    };
    canvas.vessel_of(Some(VENA_CAVA), VEIN_HU + plan.enhancement, &column(cava_at, CAVA_MM));
    paint_renal_arteries(plan, canvas);
    canvas.vessel_of(Some(AORTA), ARTERY_HU, &column(aorta_at, AORTA_MM));
    for (side, structure) in [(-1.0, ILIAC_ARTERIES[1]), (1.0, ILIAC_ARTERIES[0])] {
        let [start, fork, brim, groin] = iliac_artery(plan, side);
        let path = [(start, 7.0), (fork, ILIAC_MM), (brim, 4.8), (groin, 4.5)];
        canvas.vessel_of(Some(structure), ARTERY_HU, &path);
        let inner = mirror([38.0, plan.spine_y + 2.0, -70.0], side);
        canvas.vessel_of(Some(structure), ARTERY_HU, &[(fork, 4.0), (inner, 3.0)]);
    }
    paint_mesenteric(plan, canvas);
}

/// The iliac veins lie behind and to the middle of the arteries and meet at L5.
fn paint_veins(plan: &Plan, canvas: &mut Canvas) {
    let meeting = add(cava_at(plan, 16.0), [1.0, 0.0, 0.0]);
    let hu = VEIN_HU + plan.enhancement;
    canvas.vessel_of(Some(VENA_CAVA), hu, &[(cava_at(plan, 26.0), CAVA_MM), (meeting, 9.0)]);
    for (side, structure) in [(-1.0, ILIAC_VEINS[1]), (1.0, ILIAC_VEINS[0])] {
        let [_, fork, brim, groin] = iliac_artery(plan, side);
        let path = [
            (meeting, 8.0),
            (add(fork, mirror([-8.0, 9.0, 0.0], side)), 6.0),
            (add(brim, mirror([-5.0, 11.0, 0.0], side)), 5.5),
            (add(groin, mirror([-10.0, 4.0, 0.0], side)), 5.0),
        ];
        canvas.vessel_of(Some(structure), hu, &path);
    }
    for (side, z) in [(-1.0, 116.0), (1.0, 126.0)] {
        let hilum = [side * 46.0, plan.spine_y + 3.0, z];
        // The left renal vein passes in front of the aorta.
        let over = if side > 0.0 {
            add(aorta_at(plan, z), [2.0, -14.0, 0.0])
        } else {
            lerp(cava_at(plan, z), hilum, 0.5)
        };
        canvas.vessel(hu, &[(cava_at(plan, z), 5.0), (over, 4.2), (hilum, 4.0)]);
    }
}

fn paint_renal_arteries(plan: &Plan, canvas: &mut Canvas) {
    for (side, z) in [(-1.0, 112.0), (1.0, 122.0)] {
        let hilum = [side * 48.0, plan.spine_y + 4.0, z];
        canvas.vessel(ARTERY_HU, &[(aorta_at(plan, z + 2.0), 3.0), (hilum, 2.4)]);
    }
}

/// The superior mesenteric artery and vein, in the fat before the aorta.
fn paint_mesenteric(plan: &Plan, canvas: &mut Canvas) {
    let root = aorta_at(plan, 138.0);
    let artery = [
        (root, 4.0),
        (add(root, [-2.0, -20.0, -16.0]), 3.6),
        (add(root, [-6.0, -32.0, -60.0]), 3.0),
        (add(root, [-22.0, -38.0, -104.0]), 2.0),
    ];
    // It begins on the aorta's axis: what lies in the aorta is the aorta's.
    canvas.vessel_of(None, ARTERY_HU, &artery);
    let vein = artery.map(|(p, r)| (add(p, [-11.0, -3.0, 0.0]), r + 1.4));
    canvas.vessel_of(None, VEIN_HU + 10.0 + plan.enhancement, &vein[1..]);
}
