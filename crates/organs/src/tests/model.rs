//! The model with the tube and without it.

use nalgebra::{Isometry3, Vector3};
use simulation::control::Potential;
use simulation::space::frames::{Frames, Settings, State};

use super::{RADIUS, SCENE, SPACING, label, labelled, labels, plan};
use crate::Model;
use crate::hold::How;

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

/// It was told that the tube touches no organ.
#[test]
fn a_tube_so_thin_that_it_meets_no_point_is_refused_by_the_cubes() {
    let thin = SCENE
        .replace("diameter = 12.0", "diameter = 0.2")
        .replace("step = 2.0", "step = 0.04")
        .replace("within = [12.0]", "within = [0.1]");
    let (plan, labels) = (plan(&thin).unwrap(), labels(AXES).unwrap());
    let refused = Model::without_tube(&plan, &labels).unwrap_err();
    assert_eq!(refused.key, "organs.0.cubes", "{refused:?}");
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

/// What springs of the bath hold, mm^2.
fn bath(model: &Model) -> f64 {
    let areas = model.held.iter().filter(|held| held.by.starts_with("the bath"));
    let areas = areas.map(|held| match held.how {
        How::Springs { area, .. } => area,
        How::Nodes(_) => 0.0,
    });
    areas.sum()
}

/// The wall of a hole was held by the bath from within: a hollow ball was stiffer than a full one.
#[test]
fn a_bath_does_not_hold_the_wall_of_a_hole() {
    // Its target is in the hole.
    let plan = plan(&SCENE.replace("at = [0.0, 0.0, 0.0]", "at = [0.0, -14.0, 0.0]")).unwrap();
    let hollow = labelled(AXES, |at| if at.norm() < 9.0 { 0 } else { label(at) }).unwrap();
    let [full, hollow] = [labels(AXES).unwrap(), hollow].map(|labels| Model::without_tube(&plan, &labels).unwrap());
    assert!(hollow.bodies[0].facts.holes > 0 && full.bodies[0].facts.holes == 0);
    let walls = hollow.bodies[0].mesh.surface.iter();
    let walls = walls
        .filter(|p| hollow.bodies[0].faces_hole(&p.at, &p.normal))
        .map(|p| p.area);
    // A ball of 9 mm in voxels of 3, smoothed.
    assert!(walls.sum::<f64>() > 500.0);
    // Smoothing by 3 mm moves a sphere of 18 mm by some 3^2 / 18 = 0.5 mm, 5.6 % of its area, which the level gives back to each of the two surfaces in part.
    assert!(
        (bath(&hollow) / bath(&full) - 1.0).abs() < 0.056,
        "{} {}",
        bath(&hollow),
        bath(&full)
    );
}

/// An organ that lies flat on what keeps it out is not pressed at rest: where both smoothed surfaces overlap, at the rim, the other one recedes.
#[test]
fn an_organ_that_lies_on_an_obstacle_is_not_in_it_at_rest() {
    let attachment = "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"\n";
    let contact = "[[contacts]]\norgan = \"ball\"\nwith = [\"floor\"]\nball = 3.0\n";
    assert!(SCENE.contains(attachment));
    let plan = plan(&SCENE.replace(attachment, contact)).unwrap();
    let flat = labelled(AXES, |at| if (9.0..27.0).contains(&at.y) { 3 } else { label(at) }).unwrap();
    let model = Model::without_tube(&plan, &flat).unwrap();
    let (system, receded) = (&model.system, model.obstacles[0].receded_mm);
    // A part of a voxel of 3 mm.
    assert!((0.05..3.0).contains(&receded), "{receded}");
    let a = system.initial();
    assert!(system.obstacles[0].depth(&system.bodies, &a) < 1e-9);
    // As near as it can be: moved by what it receded and a little more, the organ is in it.
    let mut moved = a;
    moved.iter_mut().skip(1).step_by(3).for_each(|y| *y = receded + 0.5);
    assert!(system.obstacles[0].depth(&system.bodies, &moved) > 0.4);
}

/// Points were an eighth of the tube's radius apart, however large that: under a wide tube a cube had one, and areas held depended on the tube.
#[test]
fn points_are_four_to_a_side_however_wide_the_tube() {
    let of = |diameter: f64| {
        let text = SCENE.replace("diameter = 12.0", &format!("diameter = {diameter}"));
        Model::without_tube(&plan(&text).unwrap(), &labels(AXES).unwrap()).unwrap()
    };
    let [thin, wide] = [12.0, 400.0].map(of);
    assert!(
        (bath(&wide) / bath(&thin) - 1.0).abs() < 0.02,
        "{} {}",
        bath(&wide),
        bath(&thin)
    );
    let largest = |model: &Model| model.bodies[0].mesh.surface.iter().map(|p| p.area).fold(0.0, f64::max);
    // A point stands for what is nearer to it than to others, and no place is farther from one than their distance of 3 mm.
    assert!(largest(&wide) < std::f64::consts::PI * 3.0 * 3.0, "{}", largest(&wide));
}

/// A scene with the floor, and a wall on it beside the ball that is thinner than the contact's ball, so far from the middle.
fn walled(at: f64) -> Result<Model, scene::Invalid> {
    let attachment = "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"\n";
    let contact = "[[contacts]]\norgan = \"ball\"\nwith = [\"floor\"]\nsmoothing = 2.0\nball = 4.0\n";
    let plan = plan(&SCENE.replace(attachment, contact)).unwrap();
    let wall = labelled(AXES, |x| {
        let wall = (x.x - at).abs() < 3.0 && (0.0..27.0).contains(&x.y);
        if wall && label(x) != 1 { 3 } else { label(x) }
    });
    Model::without_tube(&plan, &wall.unwrap())
}

/// A thin edge anywhere in the organ's box refused the whole scene.
#[test]
fn a_thin_wall_that_the_organ_does_not_lie_at_is_left_out_and_told() {
    let model = walled(28.0).unwrap();
    let left = model.obstacles[0].left_out.unwrap();
    println!("{left:?}, {} mm", model.obstacles[0].reach_mm);
    // The wall's face is 25 mm from the middle, the ball's surface 18: both by half a voxel, and a foot by its own distance from the next.
    assert!((4.0..9.0).contains(&left.apart), "{left:?}");
    assert!(left.area > 20.0 && left.at[0] > 20.0, "{left:?}");
    let refused = walled(18.0).unwrap_err();
    assert_eq!(refused.key, "contacts.0.ball", "{refused:?}");
    assert!(refused.found.contains("thinner than its ball"), "{refused:?}");
}

/// How deep the ball's surface comes into the floor's voxels, which no contact asks, mm, before and at the end of 6 mm frame by frame; and the force on the floor.
fn pushed(contact: bool) -> ([f64; 2], f64) {
    let attachment = "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"\n";
    let table = "[[contacts]]\norgan = \"ball\"\nwith = [\"floor\"]\nsmoothing = 2.0\nball = 4.0\n";
    let scene = SCENE.replace("levels = 1, within = [12.0]", "levels = 0, within = []");
    // Looked for as far as a stroke of 8 mm may take it.
    let text = scene.replace(attachment, if contact { table } else { "" });
    let text = text.replace("stroke = 4.0", "stroke = 8.0");
    let (plan, labels) = (
        plan(&text.replace("young = 1e-3", "young = 1e-4")).unwrap(),
        labels(AXES).unwrap(),
    );
    let model = Model::without_tube(&plan, &labels).unwrap();
    let (way, free, last) = (model.way, model.free, model.way.last(&model.bodies[0].field));
    let wanted = |at: &Vector3<f64>, _: &Vector3<f64>| way.spacing([at, at], last).is_some();
    let (a, tube) = (model.system.initial(), way.tube(free - 1.0).unwrap());
    let begin = *tube.pose();
    let mut frames = Frames::new(model.system, a, 0, tube, Settings::default(), wanted).unwrap();
    let deepest = |frames: &Frames| {
        let bodies = &frames.system().bodies;
        let part = bodies.part(0, frames.state());
        let at = (0..bodies.solid(0).points()).map(|k| bodies.solid(0).point(part, k));
        // The floor is flat: from a voxel's front face on.
        let first = (labels.own(&Vector3::new(0.0, RADIUS, 0.0)).y / SPACING).ceil();
        let front = (first - 0.5) * SPACING;
        at.filter(|at| labels.at(at) == 3)
            .map(|at| at.y - front)
            .fold(0.0, f64::max)
    };
    let before = deepest(&frames);
    for k in 0..=3 {
        let pose = Isometry3::translation(0.0, 2.0 * f64::from(k), 0.0) * begin;
        let frame = frames.frame(&pose);
        assert_eq!(frame.state, State::Settled, "{k}: {frame:?}");
    }
    let on = frames.bone_force(0).map_or(0.0, |on| on.force.y);
    ([before, deepest(&frames)], on)
}

#[test]
fn a_ball_that_is_pushed_onto_the_floor_frame_by_frame_stays_out_of_its_voxels() {
    let ([at_rest, kept], on) = pushed(true);
    let ([_, gone], none) = pushed(false);
    println!(
        "in the floor's voxels {at_rest:.2} mm at rest, {kept:.2} with contact, {gone:.2} without; {on:.3} N on it"
    );
    // Smoothed, the surface of a flat floor is its voxels' face but near its rim: a third of a voxel is left for that and for what it receded.
    assert!(
        kept < at_rest + SPACING / 3.0 && gone > kept + SPACING / 3.0,
        "{kept} {gone}"
    );
    assert!(on > 0.01 && none == 0.0, "{on}");
}

/// Points near enough to one another for a contact's ball all over an organ took minutes, on its far side too.
#[test]
fn points_are_dense_only_where_the_organ_can_come_to_what_is_rigid() {
    let attachment = "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"\n";
    let contact = "[[contacts]]\norgan = \"ball\"\nwith = [\"floor\"]\nsmoothing = 2.0\nball = 3.0\n";
    let scene = SCENE.replace("stroke = 4.0\nstep = 2.0", "stroke = 1.0\nstep = 1.0");
    let scene = scene.replace(
        "side = 12.0, levels = 1, within = [12.0]",
        "side = 6.0, levels = 0, within = []",
    );
    let made = |text: &str| Model::without_tube(&plan(text).unwrap(), &labels(AXES).unwrap()).unwrap();
    let (with, without) = (
        made(&scene.replace(attachment, contact)),
        made(&scene.replace(attachment, "")),
    );
    let reach = with.obstacles[0].reach_mm;
    assert!((reach - 4.5).abs() < 1e-12, "{reach}");
    // The floor's face is half a voxel beyond the ball's at most; a cube reaches by its diagonal beyond its nearest place, and smoothing by 1.54 of 2 mm.
    let off = |at: &Vector3<f64>| RADIUS - SPACING - labels(AXES).unwrap().patient(at).y;
    let (diagonal, spread) = (6.0 * 3.0_f64.sqrt(), 1.54 * 2.0 + SPACING);
    let points = |model: &Model, low: f64, high: f64| -> Vec<_> {
        let all = model.bodies[0].mesh.surface.iter();
        all.filter(|p| (low..high).contains(&off(&p.at))).copied().collect()
    };
    let (near, far) = (
        points(&with, -10.0, reach),
        points(&with, reach + spread + diagonal + SPACING, 100.0),
    );
    println!("{} points near, {} far", near.len(), far.len());
    // Places looked at are 0.3 of the ball's radius apart at least, and 0.45 at most: each stands for what is nearer to it than to others.
    let most = near.iter().map(|p| p.area).fold(0.0, f64::max);
    assert!(
        near.len() > 100 && most < std::f64::consts::PI * (1.5_f64 * 0.9).powi(2),
        "{most}"
    );
    assert!(!far.is_empty());
    assert_eq!(far, points(&without, reach + spread + diagonal + SPACING, 100.0));
}
