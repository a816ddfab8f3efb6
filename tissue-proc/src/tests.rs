//! Tests of whole answers.

use std::path::Path;

use geometry::{Ct, Direction, Point, Rigid, Tool, Vector};
use scene::Scene;
use simulation::space::frames::State;

use crate::anatomy::{Anatomy, make};
use crate::live::Answer;

const ENTRY: [f64; 3] = [115.1, 86.3, 115.4];
const NODE: [f64; 3] = [28.5, 2.6, 50.0];

fn scene(spacing: f64) -> Scene {
    let text = format!("[volume]\nsource = \"phantom\"\nspacing_mm = {spacing:?}\n[tissue]\norgans = \"demo-kidney.toml\"");
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/solids/scene.toml");
    Scene::parse(&text, &beside).unwrap()
}

fn anatomy(scene: &Scene) -> Anatomy {
    let volume = volume_loader::load_seeded(&scene.volume, scene.seed).unwrap();
    let spec = scene.tissue.as_ref().unwrap();
    make((scene, spec), (&volume.grid, volume.hash.0), volume_loader::load_labels_seeded).unwrap()
}

/// The tool with its tip on the way, `left` mm before the node.
fn on_the_way(left: f64) -> Rigid<Ct, Tool> {
    let way: [f64; 3] = std::array::from_fn(|a| NODE[a] - ENTRY[a]);
    let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
    let z = geometry::checked::direction(way).unwrap();
    let tip = Point::new(
        NODE[0] - way[0] / length * left,
        NODE[1] - way[1] / length * left,
        NODE[2] - way[2] / length * left,
    );
    Rigid::from_axes(tip, z, Direction::X).unwrap()
}

#[test]
#[ignore]
fn explore() {
    let scene = scene(3.0);
    let began = std::time::SystemTime::now();
    let mut anatomy = anatomy(&scene);
    println!("{} after {:?}", anatomy.said, began.elapsed().unwrap());
    let mut worst = (0.0_f64, 0);
    let mut left = 130.0;
    while left > 5.0 {
        let began = std::time::SystemTime::now();
        let answer = anatomy.live.answer(on_the_way(left));
        let ms = began.elapsed().unwrap().as_secs_f64() * 1e3;
        if ms > worst.0 { worst = (ms, 0); }
        match answer {
            Answer::State(f) => {
                if !matches!(f.state, State::Settled) || (left * 3.0_f64).round() as i64 % 6 == 0 {
                    println!("{left:.2} {:?} {:.4} N res {:.1e} det {:.2} steps {} factor {} {ms:.1} ms", f.state, f.force.force.norm(), f.residual, f.least_determinant, f.steps, f.factor);
                }
            }
            other => println!("{left:.2} {other:?} {ms:.1} ms"),
        }
        left -= 1.0 / 3.0;
    }
    println!("worst {worst:?}");
    let _ = Vector::<Ct>::new(0.0, 0.0, 0.0);
}
