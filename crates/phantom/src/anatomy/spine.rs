//! The spine from T11 to L5: bodies, discs, arches, processes and the canal.

use super::{BONE_HU, FAT_HU};
use crate::canvas::Canvas;
use crate::plan::Plan;
use crate::surface::Surface;
use crate::vec3::{Vec3, add, mirror, scale, upright};

/// HU of a disc.
const DISC_HU: f64 = 90.0;
/// HU of the sac with the nerves.
const SAC_HU: f64 = 30.0;
/// Levels above L5 that the scan holds: L5 is 0, T11 is 6.
const LEVELS: std::ops::RangeInclusive<i32> = 0..=6;
/// Front-back half-width of a body, mm.
const BODY_HALF_DEPTH: f64 = 17.0;
/// Share of the pitch that is bone; the rest is disc.
const BONE_SHARE: f64 = 0.74;
/// Thickness of the compact bone around a body, mm.
const SHELL_MM: f64 = 1.7;

/// Paints the spine over the muscles.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    for level in LEVELS {
        let z = f64::from(level) * plan.pitch;
        paint_disc(plan, canvas, z - plan.pitch / 2.0, level);
        paint_body(plan, canvas, z, level);
        paint_arch(plan, canvas, z, level);
    }
    paint_canal(plan, canvas);
}

/// Bodies get narrower upwards.
fn half_width(plan: &Plan, level: i32) -> f64 {
    plan.body_half_width - 0.9 * f64::from(level)
}

fn drum(plan: &Plan, z: f64, semi: Vec3) -> Surface {
    Surface::Drum {
        centre: plan.spine_at(z),
        axes: upright(plan.spine_direction(z)),
        semi,
    }
}

fn paint_body(plan: &Plan, canvas: &mut Canvas, z: f64, level: i32) {
    let half_height = plan.pitch * BONE_SHARE / 2.0;
    let body = drum(plan, z, [half_width(plan, level), BODY_HALF_DEPTH, half_height]);
    canvas.bone(BONE_HU, SHELL_MM, body);
}

fn paint_disc(plan: &Plan, canvas: &mut Canvas, z: f64, level: i32) {
    // Into the bodies a little, so that no fat shows between disc and bone where the column bends.
    let half_height = plan.pitch * (1.0 - BONE_SHARE) / 2.0 + 2.0;
    let wide = half_width(plan, level) - 0.5;
    canvas.tissue(DISC_HU, drum(plan, z, [wide, BODY_HALF_DEPTH - 0.5, half_height]));
}

/// Pedicles, laminae, facets, transverse and spinous processes of one vertebra.
fn paint_arch(plan: &Plan, canvas: &mut Canvas, z: f64, level: i32) {
    let at = |offset: Vec3| add(plan.spine_at(z), offset);
    let lumbar = level <= 4;
    for side in [-1.0, 1.0] {
        let here = |offset: Vec3| at(mirror(offset, side));
        let rod = |from: Vec3, to: Vec3, radii| Surface::Tube {
            ends: [here(from), here(to)],
            radii,
        };
        let pedicle = rod([14.0, 13.0, 5.0], [17.0, 30.0, 2.0], [5.0, 5.5]);
        canvas.bone(BONE_HU, 1.6, pedicle);
        let lamina = rod([16.0, 31.0, -1.0], [3.0, 41.0, -9.0], [4.8, 4.2]);
        canvas.bone(BONE_HU, 1.5, lamina);
        let facet = rod([18.0, 33.0, 6.0], [20.0, 35.0, -17.0], [6.5, 5.5]);
        canvas.bone([BONE_HU[0], 380.0], 2.0, facet);
        let reach = if lumbar { 42.0 } else { 30.0 };
        let transverse = rod([17.0, 29.0, 3.0], [reach, 36.0, 4.0], [4.2, 3.0]);
        canvas.bone([520.0, 200.0], 1.5, transverse);
    }
    let spinous = Surface::Ellipsoid {
        centre: at([0.0, 52.0, -10.0]),
        axes: upright([0.0, -0.25, 1.0]),
        semi: [3.6, 17.0, 10.5],
    };
    canvas.bone([560.0, 240.0], 1.5, spinous);
}

/// A sac of nerves in a little fat, smooth through all levels.
fn paint_canal(plan: &Plan, canvas: &mut Canvas) {
    let stations: Vec<Vec3> = (0..=16)
        .map(|i| {
            let z = -35.0 + 16.0 * f64::from(i);
            let behind = scale([0.0, 1.0, 0.0], BODY_HALF_DEPTH + 8.0);
            add(plan.spine_at(z), behind)
        })
        .collect();
    for (hu, radius) in [(FAT_HU, 9.0), (SAC_HU, 7.2)] {
        let path: Vec<(Vec3, f64)> = stations.iter().map(|&p| (p, radius)).collect();
        canvas.vessel(hu, &path);
    }
}
