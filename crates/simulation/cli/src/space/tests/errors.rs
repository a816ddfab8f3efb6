//! Targets and the three errors end to end, beside closed forms and draws.

use nalgebra::{Matrix3, Vector3};
use organs::{Model, Varied};
use serde_json::Value;
use simulation::space::frames::{Frames, Settings, State};

use super::super::Space;
use super::super::run;
use super::READ;
use super::maps::{SCENE, folder};

/// Two places of the ball.
const TARGETS: &str = r#"
[[targets]]
name = "node"
at = [10.0, -32.0, 34.0]

[[targets]]
name = "deep"
at = [14.0, -14.0, 26.0]
organ = "ball"
"#;

/// The scene with these words replaced, its targets, and a coarser way.
fn scene(changes: &[(&str, &str)]) -> String {
    let mut text = format!("{SCENE}{TARGETS}");
    for (old, new) in changes.iter().chain(&[("stroke = 4.0", "stroke = 2.0")]) {
        assert!(text.contains(old), "{old}");
        text = text.replacen(old, new, 1);
    }
    text
}

fn space(text: String) -> (Space, tempfile::TempDir) {
    let (folder, path) = folder(&Matrix3::identity(), 0.0);
    (Space::new(text, &path, None, READ).unwrap(), folder)
}

/// `result.json` of a run that was asked for errors, and all that it told.
fn found(text: String) -> (Value, String) {
    let (mut space, folder) = space(text);
    space.ask_for_errors();
    let mut told = String::new();
    told += &space.run(folder.path(), &mut |line| told_line(line)).unwrap();
    let json = std::fs::read(folder.path().join("result.json")).unwrap();
    (serde_json::from_slice(&json).unwrap(), told)
}

fn told_line(line: &str) {
    println!("{line}");
}

/// The last state of a scene.
fn last_state(space: &mut Space) -> run::Run {
    let Space {
        model, plan, labels, ..
    } = space;
    run::run(model, plan, labels, &mut |_| {}, &mut |_, _| Ok(())).unwrap()
}

/// The errors of a scene's numbers as `result.json` has them, and the force on the tube in its last state.
fn of_numbers(text: String) -> (Value, Vector3<f64>) {
    let (mut space, _folder) = space(text);
    let run = last_state(&mut space);
    let said = super::super::errors::of_numbers(&run, &space.plan, &space.labels, &space.model);
    let record = super::super::report::errors::record(&said, &space.model);
    let json = serde_json::to_value(record).unwrap();
    (json["model"].clone(), run.states.last().unwrap().on_tube.force)
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|k, _| value[k].as_f64().unwrap())
}

/// The bath without what is fixed: nothing but two stiffnesses.
const BATH_ALONE: (&str, &str) = (
    "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"\n",
    "",
);

/// The tube's place is given, so displacements depend on the ratio of all stiffnesses alone, and forces are homogeneous in them of degree 1.
#[test]
fn all_stiffnesses_together_move_no_target_and_scale_the_force() {
    let (model, force) = of_numbers(scene(&[
        BATH_ALONE,
        ("young = 0.01", "young = 0.01\nyoung_spread = 0.02"),
        ("young = 1e-3", "young = 0.02\nyoung_spread = 0.02"),
    ]));
    let [organ, bath] = [&model["parameters"][0], &model["parameters"][1]];
    assert!(organ["key"] == "organs.0.young" && bath["key"] == "surroundings.young");
    let sum = vector(&organ["force"]["by"]) + vector(&bath["force"]["by"]);
    // Euler's theorem; third derivatives are left out by differences of 0.02, and forces settle to 1e-6.
    assert!((sum / 0.02 - force).norm() < 2e-3 * force.norm(), "{sum:?} {force:?}");
    for k in 0..2 {
        let [one, two] = [organ, bath].map(|p| vector(&p["targets"][k]["by"]));
        assert!(
            (one + two).norm() < 0.02 * one.norm() && one.norm() > 1e-4,
            "{one:?} {two:?}"
        );
        // Both are one direction, so that the ellipsoid is a line of twice the variance.
        let target = &model["targets"][k];
        let expected = (one.norm_squared() + two.norm_squared()).sqrt();
        assert!((target["deviation"].as_f64().unwrap() - expected).abs() < 1e-9 * expected);
        assert!(target["half_axes"][1].as_f64().unwrap() < 0.05 * target["half_axes"][0].as_f64().unwrap());
        assert_eq!(target["linear"], true);
    }
    assert_eq!(model["taken_as_exact"], serde_json::json!(["organs.0.poisson"]));
}

/// What is held by places alone moves as before whatever its stiffness, and its force goes with it.
#[test]
fn of_one_stiffness_alone_the_force_is_its_own_and_the_departure_that_of_the_exponential() {
    let bath = "[surroundings]\nyoung = 1e-3\nmargin = 20.0\ncorridor = 8.0\n";
    let (json, told) = found(scene(&[
        (bath, ""),
        ("young = 0.01", "young = 0.01\nyoung_spread = 0.3"),
    ]));
    println!("{told}");
    let force = vector(&json["states"][1]["on_tube"]["force"]);
    let model = &json["errors"]["model"];
    let by = &model["parameters"][0]["force"];
    let size = force.norm();
    assert!(
        (vector(&by["by"]) - force * 0.3_f64.sinh()).norm() < 1e-4 * size,
        "{by} {force:?}"
    );
    assert!((by["departure"].as_f64().unwrap() - size * (0.3_f64.cosh() - 1.0)).abs() < 1e-4 * size);
    let deviation = model["force_size_deviation"].as_f64().unwrap();
    assert!((deviation - size * 0.3_f64.sinh()).abs() < 1e-4 * size);
    // The departure is 0.15 of the deviation.
    assert_eq!(model["force"]["linear"], true);
    for k in 0..2 {
        let moved = json["states"][1]["targets"][k]["moved_by"].as_f64().unwrap();
        let deviation = model["targets"][k]["deviation"].as_f64().unwrap();
        assert!(deviation < 1e-4 * moved && moved > 0.01, "{deviation} of {moved}");
    }
    // The other two parts are there, and small where they must be.
    let errors = &json["errors"];
    let algebraic = &errors["algebraic"];
    assert!(algebraic["force"].as_f64().unwrap() < 1e-4 * size, "{algebraic}");
    for k in 0..2 {
        let one = &algebraic["targets"][k];
        assert!(
            one["by_residual"].as_f64().unwrap() < 1e-3 && one["by_going_on"].as_f64().unwrap() < 1e-4,
            "{one}"
        );
        let mesh = &errors["discretisation"]["targets"][k];
        let change = vector(&mesh["change"]).norm();
        assert!(
            (mesh["stated"].as_f64().unwrap() - 2.0 * change).abs() < 1e-12 && change > 1e-4,
            "{mesh}"
        );
    }
    let mesh = errors["discretisation"]["force"]["stated"].as_f64().unwrap();
    assert!(mesh > 1e-3 * size && mesh < size, "{mesh} of {size}");
    assert!(errors["discretisation"]["near"].as_f64().unwrap() > 0.0);
}

/// A generator of its own: the same draws each time, uniform in (0, 1).
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Normal, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let (one, two) = (self.uniform(), self.uniform());
        (-2.0 * one.ln()).sqrt() * (std::f64::consts::TAU * two).cos()
    }
}

/// Draws of all three numbers, each run from the start: targets and force are where the linearisation has them, to what it says of its own
/// departure, and the ellipses are those of its changes.
#[test]
fn draws_lie_where_the_linearisation_has_them() {
    let text = scene(&[
        BATH_ALONE,
        (
            "cubes = { side = 12.0, levels = 1, within = [12.0] }",
            "cubes = { side = 8.0 }",
        ),
        ("young = 0.01", "young = 0.01\nyoung_spread = 0.15"),
        ("poisson = 0.45", "poisson = 0.4\npoisson_spread = 0.03"),
        ("young = 1e-3", "young = 0.02\nyoung_spread = 0.15"),
    ]);
    let results = |space: &mut Space| {
        let run = last_state(space);
        let last = run.states.last().unwrap();
        let moved = |k: usize| space.model.targets[k].moved(&space.model.system.bodies, &last.a);
        [moved(0), moved(1), last.on_tube.force]
    };
    let (model, _) = of_numbers(text.clone());
    let of = |record: &Value, k: usize| match k {
        2 => record["force"].clone(),
        k => record["targets"][k].clone(),
    };
    let parameters: Vec<&Value> = model["parameters"].as_array().unwrap().iter().collect();
    let shifts: [Vec<(Vector3<f64>, f64)>; 3] = [0, 1, 2].map(|k| {
        let each = parameters.iter().map(|p| {
            let shift = of(p, k);
            (vector(&shift["by"]), shift["departure"].as_f64().unwrap())
        });
        each.collect()
    });
    let start = results(&mut space(text.clone()).0);
    let mut random = Random(11);
    for _ in 0..6 {
        let z = [0; 3].map(|_| random.normal());
        let [organ, nu, bath] = [0.15 * z[0], 0.03 * z[1], 0.15 * z[2]];
        let drawn = text
            .replace("young = 0.01\n", &format!("young = {}\n", 0.01 * organ.exp()))
            .replace("poisson = 0.4\n", &format!("poisson = {}\n", 0.4 + nu))
            .replace("young = 0.02\n", &format!("young = {}\n", 0.02 * bath.exp()));
        for (k, result) in results(&mut space(drawn).0).into_iter().enumerate() {
            let linear: Vector3<f64> = shifts[k].iter().zip(z).map(|((by, _), z)| by * z).sum();
            // A departure is the second order of one number at one deviation. Were the whole second order of one sign, mixed terms of two
            // numbers would be at most twice the product of their roots (Cauchy and Schwarz). Of the third order 2 %: of an exponential, two
            // deviations of 0.15 away, it is 1.1 %.
            let root: f64 = shifts[k].iter().zip(z).map(|((_, d), z)| d.sqrt() * z.abs()).sum();
            let off = (result - start[k] - linear).norm();
            println!(
                "{k} {z:.2?}: {off:.2e} off of {:.2e}, {:.2e} by departures",
                linear.norm(),
                root * root
            );
            assert!(off < root * root + 0.02 * linear.norm());
        }
    }
    for (k, shifts) in shifts.iter().enumerate() {
        let covariance: Matrix3<f64> = shifts.iter().map(|(by, _)| by * by.transpose()).sum();
        let record = &of(&model, k)["covariance"];
        let told = Matrix3::from_fn(|row, column| record[row][column].as_f64().unwrap());
        assert!((covariance - told).norm() < 1e-9 * told.norm(), "{covariance}{told}");
    }
}

#[test]
fn what_is_not_known_is_never_zero() {
    let (json, told) = found(scene(&[(
        "cubes = { side = 12.0, levels = 1, within = [12.0] }",
        "cubes = { side = 12.0 }",
    )]));
    println!("{told}");
    let model = &json["errors"]["model"];
    assert!(model["targets"][0].is_null() && model["force"].is_null() && model["force_size_deviation"].is_null());
    assert!(
        model["not_known"][0]
            .as_str()
            .unwrap()
            .contains("no number of the scene has a standard deviation")
    );
    assert!(told.contains("model NOT KNOWN"), "{told}");
    // A run that ends early has none of them.
    let (mut space, folder) = space(format!("{}\n[search]\nmost_steps = 2\n", scene(&[])));
    space.ask_for_errors();
    space.run(folder.path(), &mut |_| {}).unwrap_err();
    let json: Value = serde_json::from_slice(&std::fs::read(folder.path().join("result.json")).unwrap()).unwrap();
    assert_eq!(json["errors"], "not known: the run ended early");
    assert_eq!(json["complete"], true);
}

/// A state in which a number cannot be moved: Poisson's ratio so near to the elements' limit that the state is not found in two steps.
#[test]
fn a_number_whose_state_is_not_found_leaves_its_part_not_known() {
    let text = scene(&[("young = 0.01", "young = 0.01\nyoung_spread = 0.3")]);
    let (mut space, _folder) = space(text);
    let run = last_state(&mut space);
    let mut hasty = space.plan.clone();
    hasty.most_steps = 1;
    let said = super::super::errors::of_numbers(&run, &hasty, &space.labels, &space.model);
    let super::super::errors::Said::Found(errors) = said else {
        panic!("{said:?}");
    };
    assert!(errors.model.targets.iter().all(Option::is_none) && errors.model.force.is_none());
    assert!(errors.model.force_size.is_none());
    assert!(
        errors.model.not_known()[0].contains("organs.0.young"),
        "{:?}",
        errors.model.not_known()
    );
}

/// By the implicit function theorem at one state, and by the states that are found again: one ellipse.
fn compare_with_states_that_are_found_again(text: String) {
    let (numbers, _) = of_numbers(text.clone());
    let (space, _folder) = space(text);
    let model = Model::without_tube(&space.plan, &space.labels).unwrap();
    let varied = Varied::all(&model, &space.plan, &space.labels).unwrap();
    let (way, free, targets) = (model.way, model.free, model.targets.clone());
    let tight = Settings {
        tolerance: 1e-8,
        depth: 1e-7,
        most_steps: 60,
        ..Settings::default()
    };
    let a = model.system.initial();
    let begin = way.tube(free - 1.0).unwrap();
    let mut frames = Frames::new(model.system, a, 0, begin, tight, |_, _| true).unwrap();
    for k in 0..=8 {
        let tube = way.tube(free + 0.25 * f64::from(k)).unwrap();
        let frame = frames.frame(tube.pose());
        assert_eq!(frame.state, State::Settled, "{k}: {frame:?}");
    }
    let forces: Vec<Vec<f64>> = varied.iter().map(|one| one.forces(frames.state()).unwrap()).collect();
    let yielding = frames.yielding().unwrap();
    let each = forces.iter().map(|forces| yielding.to(forces).unwrap().unknowns);
    let changes: Vec<Vec<f64>> = each.collect();
    assert_eq!(changes.len(), 3);
    for (k, target) in targets.iter().enumerate() {
        let mut sum = Matrix3::zeros();
        for change in &changes {
            let moved = target.moved(&frames.system().bodies, change);
            sum += moved * moved.transpose();
        }
        let record = &numbers["targets"][k]["covariance"];
        let again = Matrix3::from_fn(|row, column| record[row][column].as_f64().unwrap());
        println!(
            "target {k}: {:.3e} of {:.3e}{sum}{again}",
            (sum - again).norm(),
            again.norm()
        );
        // States a twentieth up and down leave the square of that, some 0.3 %, and points of contact that
        // come and go the rest.
        assert!((sum - again).norm() < 0.03 * again.norm(), "{sum}{again}");
    }
}

/// Without anything fixed, and with a part of the ball held.
#[test]
fn one_state_that_gives_way_has_the_ellipse_of_those_that_are_found_again() {
    compare_with_states_that_are_found_again(scene(&[
        BATH_ALONE,
        ("young = 0.01", "young = 0.01\nyoung_spread = 0.05"),
        ("poisson = 0.45", "poisson = 0.4\npoisson_spread = 0.01"),
        ("young = 1e-3", "young = 0.02\nyoung_spread = 0.05"),
    ]));
    compare_with_states_that_are_found_again(scene(&[
        ("young = 0.01", "young = 0.01\nyoung_spread = 0.05"),
        ("poisson = 0.45", "poisson = 0.45\npoisson_spread = 0.01"),
        ("young = 1e-3", "young = 1e-3\nyoung_spread = 0.05"),
    ]));
}
