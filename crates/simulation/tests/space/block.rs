//! A block of 100 mm on a fixed ground, pushed by a round tube of 20 mm from above.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Plane, Settings as Cells};
use simulation::space::frames::{Frames, Settings};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::tube::Tube;

/// Half the block's width, and its height, mm.
const HALF: f64 = 50.0;
pub(crate) const HEIGHT: f64 = 100.0;
pub(crate) const RADIUS: f64 = 10.0;
/// 5 kPa, in N/mm^2.
const YOUNG: f64 = 5e-3;

/// The side of cubes, mm, and how near to the middle of the top those of each level are halved.
#[derive(Clone, Copy)]
pub(crate) struct Grid {
    pub(crate) side: f64,
    pub(crate) fine: &'static [f64],
}

/// The tube's pose with its tip `depth` below the top, moved aside and tilted about `y`.
pub(crate) fn pose(depth: f64, aside: f64, tilt: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(aside, 0.0, HEIGHT - depth + RADIUS),
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt),
    )
}

/// The tube.
pub(crate) fn tube() -> Tube {
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 200.0, RADIUS).unwrap();
    tube.at(pose(0.0, 0.0, 0.0)).unwrap()
}

/// The block's solid.
pub(crate) fn body(grid: Grid, nu: f64) -> Deformable {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let corners = [Vector3::new(-HALF, -HALF, 0.0), Vector3::new(HALF, HALF, HEIGHT)];
    let top = Vector3::new(0.0, 0.0, HEIGHT);
    let refine = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let nearest = top.sup(low).inf(high);
        let level = (grid.side / (high.x - low.x)).log2().round() as usize;
        grid.fine
            .get(level)
            .is_some_and(|reach| (nearest - top).norm() < *reach)
    };
    let settings = Cells {
        levels: grid.fine.len() as u32,
        ..Cells::of_side(grid.side)
    };
    let mesh = Mesh::new(&everywhere, corners, &settings, &refine).unwrap();
    let material = Material::new(Law::NeoHookean, YOUNG, nu).unwrap();
    Deformable::new(mesh, material, Vector3::zeros()).unwrap()
}

/// The block alone.
pub(crate) fn block(grid: Grid, nu: f64) -> System {
    let body = body(grid, nu);
    let held = body.mesh().nodes_where(|x| x.z < 1e-9);
    let mut system = System::new();
    system.add(body);
    for n in held {
        (0..3).for_each(|k| system.fixed[3 * n + k] = true);
    }
    system
}

/// True for points of the top that the tube may come to, up to so far from the middle.
pub(crate) fn top(reach: f64) -> impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool {
    move |x, normal| normal.z > 0.5 && x.xy().norm() < reach
}

/// Frames of the block for a tube that may press the top up to so far from the middle.
pub(crate) fn frames(grid: Grid, nu: f64, reach: f64, settings: Settings) -> Frames {
    let system = block(grid, nu);
    let a = system.initial();
    Frames::new(system, a, 0, tube(), settings, top(reach)).unwrap()
}
