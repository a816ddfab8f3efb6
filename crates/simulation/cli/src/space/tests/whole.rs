//! A whole run on a ball: the force is the library's, whatever axes the label map has.

use nalgebra::{Matrix3, Point3, Vector3};
use serde_json::Value;
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Field, LabelField, LabelMap, Mesh, Settings, Smoothing};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

use super::super::Space;
use super::READ;
use super::maps::{BALL, SCENE, SIZE, folder, label};

fn run(turn: &Matrix3<f64>, scene: &str) -> (Value, Vec<String>, tempfile::TempDir) {
    let (folder, path) = folder(turn, 0.0);
    let space = Space::new(scene.to_owned(), &path, None, READ).unwrap();
    let mut lines = Vec::new();
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    let words = space.run(&out, &mut |line| lines.push(line.to_owned())).unwrap();
    lines.push(words);
    let json = serde_json::from_slice(&std::fs::read(out.join("result.json")).unwrap()).unwrap();
    (json, lines, folder)
}

fn numbers(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|k, _| value[k].as_f64().unwrap())
}

/// The same by the library alone, in the label map's axes, which are the patient's but for where they begin: force on the tube and
/// its moment about the tip. Numbers are those of the scene in the same order, so that the search takes the same way: where few
/// points touch there is more than one equilibrium, with forces that differ by 3e-4.
fn by_hand() -> [Vector3<f64>; 2] {
    let middle = 1.5 * Vector3::from(SIZE.map(|n| n as f64 - 1.0));
    let at = |n: usize| [n % SIZE[0], n / SIZE[0] % SIZE[1], n / SIZE[0] / SIZE[1]].map(|x| x as f64);
    let place = |n: usize| 3.0 * Vector3::from(at(n));
    let labels: Vec<u16> = (0..SIZE.iter().product())
        .map(|n| label(&(place(n) - middle)).into())
        .collect();
    let map = LabelMap {
        size: SIZE,
        origin: Vector3::zeros(),
        spacing: Vector3::repeat(3.0),
        labels: &labels,
    };
    let smoothing = Smoothing {
        sigma: 3.0,
        ..Smoothing::default()
    };
    let field = LabelField::new(&map, 1, &smoothing).unwrap();
    let entry = middle + Vector3::new(0.0, -40.0, 1.0);
    let from_axis = |x: &Vector3<f64>, beyond: f64| {
        let along = (x - entry).y.clamp(-200.0, beyond);
        (x - (entry + Vector3::y() * along)).norm()
    };
    let inside = |gone: &f64| field.value(&(entry + Vector3::y() * *gone)) < 0.0;
    let last = (0..200).map(|k| 0.5 * f64::from(k)).find(inside).unwrap() + 4.0;
    let near = |low: &Vector3<f64>, high: &Vector3<f64>| {
        high.x - low.x > 11.0 && from_axis(&(0.5 * (low + high)), last) - 0.5 * (high - low).norm() < 12.0
    };
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(12.0)
    };
    let mut mesh = Mesh::new(&field, field.corners, &settings, &near).unwrap();
    // As near to one another as an eighth of the tube's radius, within three radii of its way.
    mesh.lay_points(&field, settings.depth, |low, high| {
        let away = from_axis(&(0.5 * (low + high)), last) - 0.5 * (high - low).norm();
        (away < 18.0).then_some(6.0 / 8.0)
    });
    let floor: Vec<Vector3<f64>> = (0..labels.len()).filter(|n| labels[*n] == 3).map(place).collect();
    let away = |x: &Vector3<f64>, voxel: &Vector3<f64>| (x - voxel).map(|c| (c.abs() - 1.5).max(0.0)).norm_squared();
    let on_floor = |x: &Vector3<f64>| floor.iter().any(|voxel| away(x, voxel) <= 16.0);
    let held = mesh.nodes_where(on_floor);
    let material = Material::new(Law::NeoHookean, 0.01, 0.45).unwrap();
    let stiffness = 60.0 * material.lame.young() / 6.0;
    let solid = Deformable::new(mesh, material, Vector3::zeros()).unwrap();
    let tube = |gone: f64| {
        let middle = entry + Vector3::y() * gone - Vector3::y() * 6.0;
        Tube::straight(Point3::from(middle), -Vector3::y(), 200.0, 6.0).unwrap()
    };
    let way = -Vector3::y() * 4000.0;
    let touches = (0..solid.points()).filter_map(|k| tube(0.0).first_touch(&solid.reference(k).0, &way));
    let free = touches.fold(1.0, f64::min) * 4000.0 - 1e-6;
    let mut system = System::new();
    let body = system.add(solid);
    held.iter()
        .for_each(|n| (0..3).for_each(|k| system.fixed[3 * n + k] = true));
    let bath = |x: &Vector3<f64>, _: &Vector3<f64>| {
        let open = on_floor(x) || from_axis(x, free) < 8.0;
        if open { 0.0 } else { 1e-3 / 20.0 }
    };
    let springs = Springs::new(&system.bodies, body, bath, |x| *x);
    system.others.push(Box::new(springs));
    let contact = TubeContact::new(&system.bodies, body, tube(free), stiffness, |_, _| true).unwrap();
    system.tubes.push(contact);
    let mut a = system.initial();
    let order = Dissection::by_places(&system.places(), &[]).unwrap();
    let mut newton = Newton::ordered_by(Control::default(), order);
    for stroke in [0.0, 2.0, 4.0] {
        system.tubes[0].move_to(tube(free + stroke));
        settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
    }
    let force = system.tubes[0].force(&system.bodies, &a);
    // About the tip, which is 6 mm ahead of the middle of its sphere.
    let moment = force.moment + Vector3::new(0.0, -6.0, 0.0).cross(&force.force);
    [force.force, moment]
}

#[test]
fn the_force_is_the_librarys_and_result_json_says_what_it_is() {
    let (json, lines, folder) = run(&Matrix3::identity(), SCENE);
    println!("{}", lines.join("\n"));
    assert_eq!(json["format"], "trocar-simulation-space");
    assert_eq!(json["equilibria"], true);
    assert_eq!(json["states"].as_array().unwrap().len(), 3);
    assert!(json["errors"] == "not asked for" && json["complete"] == true);
    let last = &json["states"][2];
    let [force, moment] = by_hand();
    let found = [numbers(&last["on_tube"]["force"]), numbers(&last["on_tube"]["moment"])];
    println!(
        "force {:?} N, by hand {force:?}; moment {:?} N mm, by hand {moment:?}",
        found[0], found[1]
    );
    // The same numbers, but for their rounding: forces settle to 1e-6.
    assert!(
        (found[0] - force).norm() < 1e-5 * force.norm() && force.norm() > 0.05,
        "{found:?} {force:?}"
    );
    assert!(
        (found[1] - moment).norm() < 1e-5 * force.norm() * BALL.1,
        "{found:?} {moment:?}"
    );
    let equilibrium = &last["equilibrium"];
    assert!(equilibrium["residual"].as_f64().unwrap() <= 1e-8);
    // Each of some thousand unknowns is balanced to 1e-8 of the load, pressures to 1e-6.
    assert!(equilibrium["balance"].as_f64().unwrap() < 1e-5);
    assert_eq!(equilibrium["falling"], 0);
    let tip = numbers(&last["tip"]) - numbers(&json["tube"]["first_touch"]);
    assert!((tip - Vector3::new(0.0, 4.0, 0.0)).norm() < 1e-9, "{tip:?}");
    for name in ["start.png", "shape.png", "cuts.png", "strip.png", "film.png"] {
        let bytes = std::fs::read(folder.path().join("out").join(name)).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 2000, "{name}");
    }
    // A line for each state, and one for the whole.
    assert!(
        lines.len() == 4 && lines[2].contains("state 2 of 2: 4.00 mm, force"),
        "{lines:?}"
    );
}

/// As most files have it, mirrored, and with its axes in another order: the same voxels, and cubes from other sides.
#[test]
fn the_axes_of_the_file_do_not_matter() {
    // A soft bath alone, as which nodes are held depends on the cubes.
    let from = SCENE.find("[[attachments]]").unwrap()..SCENE.find("[surroundings]").unwrap();
    let mut scene = SCENE
        .replace("stroke = 4.0", "stroke = 2.0")
        .replace("young = 1e-3", "young = 0.05");
    // Aside of the middle along two axes: it is pushed off on one side.
    scene = scene.replace("= [10.0,", "= [16.0,");
    scene.replace_range(from, "");
    let force = |turn: &Matrix3<f64>| {
        let (json, ..) = run(turn, &scene);
        let last = &json["states"][1]["on_tube"];
        [numbers(&last["force"]), numbers(&last["moment"])]
    };
    let plain = force(&Matrix3::identity());
    let mirrored = Matrix3::from_columns(&[Vector3::z(), Vector3::x(), -Vector3::y()]);
    assert!(mirrored.determinant() < 0.0);
    let other = force(&mirrored);
    println!("plain {plain:?}\nother {other:?}");
    // Cubes of 6 mm at a tip of 12 mm: forces differ by some percent as the cubes lie (1.7 and 4 % were seen). An axis that is mistaken
    // turns the force by much more than 0.1 radians, or mirrors its part to the left.
    let [one, two] = [plain[0], other[0]];
    assert!((two.norm() / one.norm() - 1.0).abs() < 0.1 && two.angle(&one) < 0.1);
    // The tube is pushed to where the ball is not: to the patient's left.
    assert!(one.x > 0.1 * one.norm() && two.x > 0.1 * one.norm());
}

#[test]
fn a_search_that_fails_is_told_and_what_was_found_is_written() {
    let (folder, path) = folder(&Matrix3::identity(), 0.0);
    let scene = format!("{SCENE}\n[search]\nmost_steps = 2\n");
    let space = Space::new(scene, &path, None, READ).unwrap();
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    let error = space.run(&out, &mut |_| {}).unwrap_err();
    assert!(
        error.contains("state 1 of 2, 2 mm") && error.contains("search.most_steps"),
        "{error}"
    );
    // Voxels of 3 mm.
    for part in [
        "last equilibrium is 0.000 mm",
        "no part of 0.094 mm or more",
        "det F",
        "stretches",
        "mm (at rest)",
    ] {
        assert!(error.contains(part), "{part:?} is not in {error}");
    }
    let json: Value = serde_json::from_slice(&std::fs::read(out.join("result.json")).unwrap()).unwrap();
    assert!(json["refused"].as_str().unwrap().contains("no convergence") && json["equilibria"] == false);
    let last = &json["states"][1];
    assert_eq!(last["label"], "NOT an equilibrium, on the way to state 1");
    // No force is stated of it.
    assert!(last.get("on_tube").is_none() && last.get("equilibrium").is_none());
    assert!(out.join("cuts.png").is_file());
}
