//! From frame to frame: a block pushed by a tube, held against [`settle`].

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Plane, Settings as Cells};
use simulation::space::frames::{Frame, Frames, Settings, State};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::tube::Tube;

const HALF: f64 = 50.0;
const HEIGHT: f64 = 100.0;
const RADIUS: f64 = 10.0;

fn pose(depth: f64, aside: f64, tilt: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(aside, 0.0, HEIGHT - depth + RADIUS),
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt),
    )
}

fn block(side: f64, fine: &[f64], nu: f64) -> System {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let corners = [Vector3::new(-HALF, -HALF, 0.0), Vector3::new(HALF, HALF, HEIGHT)];
    let top = Vector3::new(0.0, 0.0, HEIGHT);
    let refine = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let nearest = top.sup(low).inf(high);
        let level = (side / (high.x - low.x)).log2().round() as usize;
        fine.get(level).is_some_and(|reach| (nearest - top).norm() < *reach)
    };
    let settings = Cells {
        levels: fine.len() as u32,
        ..Cells::of_side(side)
    };
    let mesh = Mesh::new(&everywhere, corners, &settings, &refine).unwrap();
    let held = mesh.nodes_where(|x| x.z < 1e-9);
    let material = Material::new(Law::NeoHookean, 5e-3, nu).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh, material, Vector3::zeros()).unwrap());
    for n in held {
        (0..3).for_each(|k| system.fixed[3 * n + k] = true);
    }
    system
}

fn frames(side: f64, fine: &[f64], reach: f64, settings: Settings) -> Frames {
    let system = block(side, fine, 0.49);
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 200.0, RADIUS).unwrap();
    let tube = tube.at(pose(0.0, 0.0, 0.0)).unwrap();
    let a = system.initial();
    Frames::new(system, a, 0, tube, settings, |x, n| {
        n.z > 0.5 && x.xy().norm() < reach
    })
    .unwrap()
}

fn cpu() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

#[test]
fn explore() {
    let var = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let mesh = var("MESH", 0.0) as usize;
    let (side, fine): (f64, &[f64]) = [
        (25.0, &[40.0][..]),
        (25.0, &[40.0, 25.0][..]),
        (20.0, &[30.0]),
        (20.0, &[40.0, 25.0][..]),
        (25.0, &[40.0, 16.0][..]),
        (25.0, &[30.0, 14.0, 14.0]),
    ][mesh];
    let settings = Settings {
        refresh: var("REFRESH", 1.0),
        delay: var("DELAY", 2.0) as usize,
        tolerance: var("TOL", 1e-3),
        ..Settings::default()
    };
    let mut f = frames(side, fine, var("REACH", 35.0), settings);
    println!("{} unknowns, root {}", f.state().len(), f.root_size());
    let step = var("STEP", 1.0 / 3.0);
    let mut times = Vec::new();
    let n = (20.0 / step) as usize;
    for k in 1..=2 * n {
        let depth = step * (if k > n { 2 * n - k } else { k }) as f64;
        let start = cpu();
        let frame: Frame = f.frame(&pose(depth, 0.0, 0.0));
        let ms = 1e3 * (cpu() - start);
        times.push(ms);
        if frame.state != State::Settled || k % 10 == 0 || std::env::var("ALL").is_ok() {
            println!(
                "{k} {depth:.2} {ms:.1} ms {:?} r {:.1e} unsettled {:.1e} F {:.4} det {:.2} steps {} contact {} factor {} depth {:.1e}",
                frame.state, frame.residual, frame.unsettled, frame.force.force.z, frame.least_determinant, frame.steps, frame.contact_steps, frame.factor, frame.force.depth
            );
        }
    }
    times.sort_by(f64::total_cmp);
    println!("median {:.1} p95 {:.1} worst {:.1}", times[times.len() / 2], times[times.len() * 95 / 100], times.last().unwrap());
}
