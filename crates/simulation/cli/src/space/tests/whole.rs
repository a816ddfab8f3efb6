//! A whole run on a ball: the force is the library's, whatever axes the label map has.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use serde_json::Value;
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{LabelField, LabelMap, Mesh, Settings, Smoothing};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

use super::super::Space;
use super::maps::{BALL, FLOOR, SCENE, folder};
use super::read;

fn run(turn: &Matrix3<f64>, scene: &str) -> (Value, Vec<String>, tempfile::TempDir) {
    let (folder, path) = folder(turn, 0.0);
    let space = Space::new(scene.to_owned(), &path, None, read).unwrap();
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

/// The same by the library alone, in the patient's axes about the ball's middle: force on the tube and its moment about the tip.
fn by_hand() -> [Vector3<f64>; 2] {
    let size = [30_usize, 32, 28];
    let origin = Vector3::from(size.map(|n| -1.5 * (n as f64 - 1.0)));
    let place = |n: usize| origin + 3.0 * Vector3::from([n % 30, n / 30 % 32, n / 30 / 32].map(|x| x as f64));
    let label = |n: usize| {
        let at = place(n);
        if at.norm() < BALL.1 { 1 } else { 3 * u16::from((FLOOR[0]..FLOOR[0] + FLOOR[1]).contains(&at.y)) }
    };
    let labels: Vec<u16> = (0..size.iter().product()).map(label).collect();
    let map = LabelMap { size, origin, spacing: Vector3::repeat(3.0), labels: &labels };
    let field = LabelField::new(&map, 1, &Smoothing { sigma: 3.0, ..Smoothing::default() }).unwrap();
    let near = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let middle = 0.5 * (low + high);
        // The axis is 1 mm above the middle; it enters near -20 mm and the tip goes 4 mm beyond.
        let first = field_entry(&field);
        let on_axis = Vector3::new(0.0, middle.y.min(first + 4.0), 1.0);
        high.x - low.x > 11.0 && (middle - on_axis).norm() - 0.5 * (high - low).norm() < 12.0
    };
    let mesh = Mesh::new(&field, field.corners, &Settings { levels: 1, ..Settings::of_side(12.0) }, &near).unwrap();
    let nearest: Vec<Vector3<f64>> = (0..labels.len()).filter(|n| labels[*n] == 3).map(place).collect();
    let box_distance = |x: &Vector3<f64>, v: &Vector3<f64>| (x - v).map(|c| (c.abs() - 1.5).max(0.0)).norm();
    let on_floor = |x: &Vector3<f64>| nearest.iter().any(|v| box_distance(x, v) <= 4.0);
    let mut system = System::new();
    let held = mesh.nodes_where(on_floor);
    let solid = Deformable::new(mesh, Material::new(Law::NeoHookean, 0.01, 0.45).unwrap(), Vector3::zeros()).unwrap();
    let tube = |tip: f64| Tube::straight(Point3::new(0.0, tip - 6.0, 1.0), -Vector3::y(), 200.0, 6.0).unwrap();
    let start = tube(-40.0);
    let touches = (0..solid.points()).filter_map(|k| start.first_touch(&solid.reference(k).0, &(-60.0 * Vector3::y())));
    let first = 60.0 * touches.fold(1.0, f64::min) - 40.0;
    let body = system.add(solid);
    held.iter().for_each(|n| (0..3).for_each(|k| system.fixed[3 * n + k] = true));
    let bath = |x: &Vector3<f64>, _: &Vector3<f64>| {
        let on_axis = Vector3::new(0.0, x.y.min(first), 1.0);
        if on_floor(x) || (x - on_axis).norm() < 8.0 { 0.0 } else { 1e-3 / 20.0 }
    };
    system.others.push(Box::new(Springs::new(&system.bodies, body, bath, |x| *x)));
    system.tubes.push(TubeContact::new(&system.bodies, body, tube(first), 0.1, |_, _| true).unwrap());
    let mut a = system.initial();
    let order = Dissection::by_places(&system.places(), &[]).unwrap();
    let mut newton = Newton::ordered_by(Control::default(), order);
    for stroke in [2.0, 4.0] {
        system.tubes[0].move_to(tube(first + stroke));
        settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
    }
    let force = system.tubes[0].force(&system.bodies, &a);
    let moment = force.moment + Vector3::new(0.0, -6.0, 0.0).cross(&force.force);
    [force.force, moment]
}

/// Where the axis enters the field, in the steps of 0.5 mm from the entry in which the program looks.
fn field_entry(field: &LabelField) -> f64 {
    use simulation::space::cells::Field;
    let steps = (0..200).map(|k| -40.0 + 0.5 * f64::from(k));
    steps.into_iter().find(|y| field.value(&Vector3::new(0.0, *y, 1.0)) < 0.0).unwrap()
}

#[test]
fn the_force_is_the_librarys_and_result_json_says_what_it_is() {
    let (json, lines, folder) = run(&Matrix3::identity(), SCENE);
    println!("{}", lines.join("\n"));
    assert_eq!(json["format"], "trocar-simulation-space");
    assert_eq!(json["equilibria"], true);
    assert_eq!(json["states"].as_array().unwrap().len(), 3);
    // No error is known, and none is stated.
    assert!(json["error"].is_null() && json["states"][2]["error"].is_null());
    assert!(json["error_words"].as_str().unwrap().contains("not known"));
    let last = &json["states"][2];
    let [force, moment] = by_hand();
    let found = [numbers(&last["on_tube"]["force"]), numbers(&last["on_tube"]["moment"])];
    println!("force {:?} N, by hand {force:?}; moment {:?} N mm, by hand {moment:?}", found[0], found[1]);
    // Places of the map differ by their rounding and the header's (1e-7 of 100 mm), forces settle to 1e-6.
    assert!((found[0] - force).norm() < 1e-5 * force.norm() && force.norm() > 0.05, "{found:?} {force:?}");
    assert!((found[1] - moment).norm() < 1e-5 * force.norm() * BALL.1, "{found:?} {moment:?}");
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
    assert!(lines.len() == 4 && lines[2].contains("state 2 of 2: 4.00 mm, force"), "{lines:?}");
}

#[test]
fn the_axes_of_the_file_do_not_matter() {
    let force = |turn: &Matrix3<f64>| {
        let (json, ..) = run(turn, SCENE);
        let last = &json["states"][2]["on_tube"];
        [numbers(&last["force"]), numbers(&last["moment"])]
    };
    let plain = force(&Matrix3::identity());
    // As most files have it, mirrored; and turned out of all axes, where other voxels make the ball.
    let mirrored = force(&Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0)));
    let turned = force(Rotation3::from_euler_angles(0.0, 0.0, 0.2).matrix());
    println!("plain {plain:?}\nmirrored {mirrored:?}\nturned {turned:?}");
    // The same voxels, and cubes from the other side: what the mesh is worth.
    assert!((mirrored[0] - plain[0]).norm() < 0.03 * plain[0].norm());
    assert!((turned[0] - plain[0]).norm() < 0.1 * plain[0].norm());
}
