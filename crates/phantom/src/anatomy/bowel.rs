//! Loops of small bowel and the frame of the large one, with some gas.

use super::GAS_HU;
use crate::canvas::{Canvas, Solid};
use crate::plan::Plan;
use crate::surface::Surface;
use crate::vec3::Vec3;
use chance::SplitMix64;

/// HU of a bowel's wall.
const WALL_HU: f64 = 68.0;

/// One stretch of bowel.
struct Loop {
    path: Vec<(Vec3, f64)>,
    /// HU of what is in it.
    content: f64,
    /// Thickness of the wall, mm.
    wall: f64,
}

/// Paints the small bowel, then the colon.
pub(crate) fn paint(plan: &Plan, canvas: &mut Canvas) {
    let mut random = plan.bowel.clone();
    for row in 0..5_i32 {
        paint_loop(plan, canvas, &small_bowel(&mut random, row));
    }
    for stretch in colon(&mut random) {
        paint_loop(plan, canvas, &stretch);
        paint_gas(plan, canvas, &stretch);
    }
}

/// One winding row of small bowel, right to left, at its own height in front of the great vessels.
fn small_bowel(random: &mut SplitMix64, row: i32) -> Loop {
    let z = -72.0 + 31.0 * f64::from(row);
    let wide = if row == 0 { 46.0 } else { 72.0 };
    let turns = 9;
    let path = (0..=turns)
        .map(|i| {
            let s = f64::from(i) / f64::from(turns);
            let up = if i % 2 == 0 { 11.0 } else { -11.0 };
            let x = -wide + 2.0 * wide * s + random.around(0.0, 3.0);
            let y = [-66.0, -38.0, -58.0][(i + row) as usize % 3];
            (
                [x, y + random.around(0.0, 3.0), z + up + random.around(0.0, 3.0)],
                random.around(11.5, 1.2),
            )
        })
        .collect();
    Loop {
        path,
        content: random.around(25.0, 12.0),
        wall: 2.4,
    }
}

/// Ascending, transverse and descending colon; clear of the left flank's way to the aorta.
fn colon(random: &mut SplitMix64) -> [Loop; 3] {
    let mut stretch = |points: &[Vec3], radius: f64, content: f64| {
        let path = points.iter().map(|&p| (p, random.around(radius, 1.5))).collect();
        Loop {
            path,
            content,
            wall: 2.6,
        }
    };
    let ascending = [
        [-74.0, -20.0, -42.0],
        [-80.0, -14.0, -10.0],
        [-88.0, -8.0, 24.0],
        [-96.0, -22.0, 54.0],
    ];
    let transverse = [
        [-94.0, -40.0, 62.0],
        [-56.0, -64.0, 62.0],
        [-8.0, -72.0, 74.0],
        [44.0, -68.0, 92.0],
        [88.0, -40.0, 108.0],
    ];
    let descending = [
        [106.0, -22.0, 110.0],
        [104.0, -26.0, 66.0],
        [102.0, -26.0, 20.0],
        [84.0, -30.0, -30.0],
        [52.0, -26.0, -74.0],
    ];
    [
        stretch(&ascending, 20.0, 10.0),
        stretch(&transverse, 17.0, 0.0),
        stretch(&descending, 13.0, 20.0),
    ]
}

/// All walls first, then all contents, so that no wall stays across the bowel where two pieces meet.
fn paint_loop(plan: &Plan, canvas: &mut Canvas, stretch: &Loop) {
    for (hu, thin) in [(WALL_HU, 0.0), (stretch.content, stretch.wall)] {
        for tube in tubes(stretch, thin) {
            canvas.add(Solid::tissue(hu, tube).and(Surface::Trunk(plan.cavity().deeper(2.0 + thin))));
        }
    }
}

/// Gas floats to the front: what of each piece lies before its own middle.
fn paint_gas(plan: &Plan, canvas: &mut Canvas, stretch: &Loop) {
    for (tube, pair) in tubes(stretch, stretch.wall + 0.8).zip(stretch.path.windows(2)) {
        let level = pair[0].0[1].min(pair[1].0[1]) - 3.0;
        let gas = Solid::tissue(GAS_HU, tube)
            .and(Surface::Trunk(plan.cavity().deeper(5.5)))
            .below([0.0, 1.0, 0.0], [0.0, level, 0.0]);
        canvas.add(gas);
    }
}

fn tubes(stretch: &Loop, thin: f64) -> impl Iterator<Item = Surface> {
    stretch.path.windows(2).map(move |pair| Surface::Tube {
        ends: [pair[0].0, pair[1].0],
        radii: [pair[0].1 - thin, pair[1].1 - thin],
    })
}
