//! The model with the tube and without it.

use simulation::control::Potential;

use super::{RADIUS, SCENE, labels, plan};
use crate::Model;

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn without_the_tube_the_model_is_the_same_but_for_its_contacts() {
    let (plan, labels) = (plan(SCENE).unwrap(), labels(AXES).unwrap());
    let (with, without) = (
        Model::new(&plan, &labels).unwrap(),
        Model::without_tube(&plan, &labels).unwrap(),
    );
    assert_eq!((with.system.tubes.len(), without.system.tubes.len()), (1, 0));
    assert_eq!(with.unknowns(), without.unknowns());
    assert_eq!(with.system.fixed, without.system.fixed);
    assert_eq!(with.system.others.len(), without.system.others.len());
    assert_eq!((with.way, with.free), (without.way, without.free));
    assert_eq!((&with.held, &with.targets), (&without.held, &without.targets));
    assert_eq!(with.overlaps, without.overlaps);
    // Away from the tube its contacts are without force: of a state that it does not touch the forces are the same bits.
    let a: Vec<f64> = (0..with.system.bodies.size()).map(|k| 1e-3 * (k % 7) as f64).collect();
    let forces = |model: &Model| {
        let mut forces = vec![0.0; a.len()];
        model.system.gradient(&a, &mut forces).unwrap();
        forces
    };
    let springs = forces(&without);
    assert!(springs.iter().any(|f| *f != 0.0));
    let moved = |model: &mut Model| {
        let tube = model.way.tube(0.0).unwrap();
        model.system.tubes.iter_mut().for_each(|one| one.move_to(tube.clone()));
    };
    let mut with = with;
    moved(&mut with);
    assert_eq!(forces(&with), springs);
}

#[test]
fn the_ball_is_touched_where_it_is_and_held_by_nodes_and_bath() {
    let (plan, labels) = (plan(SCENE).unwrap(), labels(AXES).unwrap());
    let model = Model::without_tube(&plan, &labels).unwrap();
    // The tip starts 50 mm before the middle; the label's staircase and its smoothing are within a voxel.
    assert!((model.free - (50.0 - RADIUS)).abs() < 3.0, "{}", model.free);
    assert_eq!(model.held.len(), 2);
    assert_eq!(model.springs.len(), 1);
    assert!(model.system.fixed.iter().any(|fixed| *fixed));
    assert_eq!(model.targets.len(), 1);
}

#[test]
fn points_too_far_apart_for_the_tube_are_refused_without_it_too() {
    let thin = SCENE
        .replace("diameter = 12.0", "diameter = 2.0")
        .replace("step = 2.0", "step = 0.4");
    let (plan, labels) = (plan(&thin).unwrap(), labels(AXES).unwrap());
    let refused = Model::without_tube(&plan, &labels).unwrap_err();
    assert_eq!(refused.key, "organs.0.cubes");
    assert!(
        refused.found.contains("points of the surface of \"ball\""),
        "{refused:?}"
    );
    assert_eq!(Model::new(&plan, &labels).unwrap_err(), refused);
}
