//! Evolutions with planted answers: walls that press, instruments that are stopped.

use std::path::Path;

use nalgebra::Vector2;
use simulation::constraint::overlapping;

use super::{Run, run};
use crate::model::Model;
use crate::scene::Source;

fn made(text: &str) -> (Model, Run) {
    let source = Source::parse(text.to_owned(), Path::new("s.toml")).unwrap();
    let mut model = Model::new(&source.scene).unwrap_or_else(|e| panic!("{e}"));
    let run = run(&mut model, &source.scene.search, &mut |_| {});
    (model, run)
}

/// A linear block of side 1 between two exact walls: they press it by `E / (1 - nu^2)` times the strain, in plane strain,
/// and by `nu / (1 - nu)` times the mean pressure of its weight.
#[test]
fn walls_that_close_in_feel_the_stiffness_of_what_is_between() {
    let (model, run) = made(
        r#"
title = "press"
units = { length = "mm", stress = "kPa" }
materials = [{ name = "m", law = "linear", young = 2.0, poisson = 0.25 }]
solids = [{ name = "block", material = "m", weight = [0, -1e-3], rectangle = { corner = [0, 0], size = [1, 1], elements = [2, 2] } }]
walls = [
    { name = "floor", normal = [0, 1], offset = 0 },
    { name = "left", normal = [1, 0], offset = 0 },
    { name = "right", normal = [-1, 0], offset = -1 },
]
search = { walls = "exact" }
steps = [{ frames = 5, moves = [{ wall = "right", advance = 0.01 }] }]
"#,
    );
    assert_eq!(run.refused, None);
    assert_eq!(run.states.len(), 7);
    for (k, state) in run.states.iter().enumerate().skip(2) {
        let expected = 2.0 / (1.0 - 0.0625) * 0.01 * (k - 1) as f64 + 0.25 / 0.75 * 0.5e-3;
        let force = state.force_on_wall(2);
        // Elements hold the exact answer; violations are below 1e-9 of the size, forces settle to 1e-7.
        assert!(
            (force.x - expected).abs() < 1e-6 * expected,
            "{k}: {force:?} {expected}"
        );
        assert!((state.force_on_wall(1) + force).norm() < 1e-6 * expected);
        assert!(state.found.unwrap().minimum.stability.falling == 0);
        assert!(state.balance[0] < 1e-6, "{:?}", state.balance);
    }
    assert!((state_width(&model, &run) - 0.95).abs() < 1e-8);
}

fn state_width(model: &Model, run: &Run) -> f64 {
    let last = &run.states[run.states.len() - 1].a;
    let all = model.system.bodies.solid(0).boundary().nodes.iter();
    let x: Vec<f64> = all.map(|n| model.system.bodies.point(0, *n, last).x).collect();
    x.iter().fold(f64::MIN, |m, x| m.max(*x)) - x.iter().fold(f64::MAX, |m, x| m.min(*x))
}

const PUSHED: &str = r#"
title = "a tool on a block"
units = { length = "mm", stress = "kPa" }
solids = [
    { name = "block", weight = [0, -1], polygon = { vertices = [[0, 0.01], [1, 0.01], [1, 1.01], [0, 1.01]] } },
    { name = "tool", driven = true, polygon = { vertices = [[0.4, 1.31], [0.6, 1.31], [0.6, 3], [0.4, 3]] } },
]
walls = [
    { name = "floor", normal = [0, 1], offset = 0 },
    { name = "left", normal = [1, 0], offset = -0.005 },
    { name = "right", normal = [-1, 0], offset = -1.005 },
]
contact = { widths = [1e-2, 1e-2] }
search = { walls = "barrier" }
steps = [{ frames = 1, moves = [{ solid = "tool", by = [0, -0.2] }] }, { frames = 2, moves = [{ solid = "tool", by = [0, -40] }] }]
"#;

/// A tool told to go far through a rigid block in a cavity is stopped by it: never a teleport. (On an open floor the block
/// slips away sideways, as nothing rubs.)
#[test]
fn an_instrument_is_stopped_by_what_gives_no_way() {
    // Behind barriers: in exact contact a rigid block gives way by their widths, and the tool touches nothing.
    let (model, run) = made(&PUSHED.replace("walls = \"barrier\"", "walls = \"barrier\", exact = false"));
    assert_eq!(run.refused, None);
    let parts: Vec<f64> = run.states.iter().flat_map(|s| &s.moved).map(|m| m.part).collect();
    assert_eq!(parts[0], 1.0);
    // Of 40, the tenth that was free; then what the barriers still give.
    assert!(parts[1] < 0.12 / 40.0 && parts[2] < 0.1 * parts[1], "{parts:?}");
    let last = &run.states[run.states.len() - 1];
    let tip = model.system.bodies.point(1, 0, &last.a).y;
    // Both barriers are shut but for a little: 1 and their widths, a hundredth each.
    assert!(tip > 1.0 && tip < 1.02, "{tip}");
    for state in &run.states {
        assert!(overlapping(&model.system.bodies, &state.a).is_empty());
    }
    // What the tool feels is what the block feels from it, and the floor bears both that and the weight.
    let felt = last.force_on(1);
    let floor = last.force_on_wall(0);
    assert!(felt.y > 0.0, "{felt:?}");
    assert!(
        (floor.y + felt.y + 1.0).abs() < 1e-6 * felt.norm(),
        "{floor:?} {felt:?}"
    );
}

#[test]
fn what_nothing_holds_has_no_equilibrium_and_the_start_is_kept() {
    let (_, run) = made(&PUSHED.replace(
        "normal = [0, 1], offset = 0 }",
        "normal = [0, 1], offset = 0, keeps = [] }",
    ));
    let refused = run.refused.unwrap();
    assert!(
        refused.contains("finding the first equilibrium") && refused.contains("no equilibrium"),
        "{refused}"
    );
    assert!(refused.contains("come to rest on"), "{refused}");
    assert_eq!(run.states.len(), 2);
    assert!(run.states[1].label.starts_with("NOT") && run.states[1].found.is_none());
}

/// Seen or not seen on its way, a search ends in an equilibrium.
#[test]
fn a_watched_search_shows_its_way() {
    let text = r#"
title = "a ring comes down"
units = { length = "mm", stress = "kPa" }
materials = [{ name = "m", law = "neo-hookean", young = 1, poisson = 0.3 }]
solids = [{ name = "ring", material = "m", weight = [0, -0.005], ring = { centre = [0, 1.005], radii = [0.7, 1], elements = [8, 1] } }]
walls = [{ name = "floor", normal = [0, 1], offset = 0 }]
search = { walls = "barrier", watch = 2 }
"#;
    let (_, run) = made(text);
    assert_eq!(run.refused, None);
    assert!(run.states.len() > 3, "{}", run.states.len());
    let middle = &run.states[1];
    assert!(middle.label == "after 2 steps" && middle.found.is_none());
    let last = &run.states[run.states.len() - 1];
    let weight = 0.005 * std::f64::consts::PI * (1.0 - 0.49);
    // Eight quadratic arcs of a circle: their area is the disc's to about 1e-3.
    assert!(
        (last.force_on(0).y / weight - 1.0).abs() < 3e-3,
        "{:?}",
        last.force_on(0)
    );
}

/// A block held along its foot and pulled at a corner, a plate hung on the other corner, a spring beside it.
#[test]
fn links_forces_and_held_nodes_balance() {
    let text = r#"
title = "held, pulled, hung"
units = { length = "mm", stress = "kPa" }
materials = [{ name = "m", law = "neo-hookean", young = 10, poisson = 0.3 }]
solids = [
    { name = "block", material = "m", weight = [0, -0.1], rectangle = { corner = [0, 0], size = [1, 1], elements = [2, 2] }, held = { low = [0, 0], high = [1, 0] } },
    { name = "plate", weight = [0, -0.2], polygon = { vertices = [[1, 0.5], [2, 0.5], [2, 1], [1, 1]] } },
]
links = [
    { solid = "plate", at = [1, 1], to = [1, 1], to_solid = "block" },
    { solid = "plate", at = [2, 1], to = [2.2, 1.5], spring = 0.05 },
]
forces = [
    { solid = "block", at = [0, 1], force = [-0.2, 0.1] },
    { solid = "plate", at = [2, 0.5], force = [0.03, 0] },
]
"#;
    let (model, run) = made(text);
    assert_eq!(run.refused, None);
    let last = &run.states[run.states.len() - 1];
    // Reported link forces settle to 1e-7 of the largest load.
    assert!(last.balance.iter().all(|b| *b < 1e-6), "{:?}", last.balance);
    let corner = |body: usize, near: Vector2<f64>| {
        let boundary = model.system.bodies.solid(body).boundary();
        let arcs = boundary.reference.iter().zip(&boundary.arcs);
        let found = arcs
            .flat_map(|(r, n)| r.iter().zip(n))
            .find(|(r, _)| (*r - near).norm() < 1e-12);
        model.system.bodies.point(body, *found.unwrap().1, &last.a)
    };
    let apart = corner(0, Vector2::new(1.0, 1.0)) - corner(1, Vector2::new(1.0, 1.0));
    // A hard link holds to 1e-9 of the largest solid.
    assert!(apart.norm() < 1e-9, "{apart:?}");
    assert_eq!(corner(0, Vector2::new(1.0, 0.0)), Vector2::new(1.0, 0.0));
    // The plate's weight and its pull are borne by the link and the spring.
    let on_plate = last.force_on(1);
    assert!((on_plate - Vector2::new(-0.03, 0.1)).norm() < 1e-7, "{on_plate:?}");
}

/// Only what is named keeps apart: the upper block falls through the middle one onto the lower one.
#[test]
fn pairs_that_are_not_named_pass_through_one_another() {
    let text = |pairs: &str| {
        format!(
            r#"
title = "three blocks"
units = {{ length = "mm", stress = "kPa" }}
solids = [
    {{ name = "lower", weight = [0, -1], polygon = {{ vertices = [[0, 0.01], [1, 0.01], [1, 1.01], [0, 1.01]] }} }},
    {{ name = "middle", weight = [0, -1], polygon = {{ vertices = [[0.1, 1.02], [0.9, 1.02], [0.9, 2], [0.1, 2]] }} }},
    {{ name = "upper", weight = [0, -1], polygon = {{ vertices = [[0.2, 2.01], [0.8, 2.01], [0.8, 3], [0.2, 3]] }} }},
]
walls = [
    {{ name = "floor", normal = [0, 1], offset = 0 }},
    {{ name = "left", normal = [1, 0], offset = -0.005 }},
    {{ name = "right", normal = [-1, 0], offset = -1.005 }},
]
contact = {{ widths = [1e-2, 1e-2]{pairs} }}
search = {{ walls = "barrier", exact = false }}
"#
        )
    };
    let height = |text: &str| {
        let (model, run) = made(text);
        assert_eq!(run.refused, None);
        assert!(run.uncertified().is_empty(), "{:?}", run.uncertified());
        model.system.bodies.point(2, 0, &run.states[run.states.len() - 1].a).y
    };
    let stacked = height(&text(""));
    let through = height(&text(", pairs = [[\"lower\", \"middle\"], [\"upper\", \"lower\"]]"));
    // Blocks of height 1, 0.98 and 0.99, and up to three barriers of 1e-2 below them.
    assert!((stacked - 1.98).abs() < 0.03, "{stacked}");
    assert!((through - 1.0).abs() < 0.03, "{through}");
}

/// The scene of the tool without its steps: a block that stands on a floor between walls.
fn standing() -> String {
    PUSHED.split("steps =").next().unwrap_or_default().to_owned()
}

/// The block stands on the floor itself, not on a barrier, and a moment has the lever of its point.
#[test]
fn a_state_ends_in_exact_contact_and_moments_have_their_lever() {
    let (model, run) = made(&standing());
    let last = &run.states[run.states.len() - 1];
    let measures = last.measures.unwrap();
    assert!(measures.exact && measures.fails().is_empty(), "{measures:?}");
    assert!(
        (last.force_on(0) - Vector2::new(0.0, 1.0)).norm() < 1e-6,
        "{:?}",
        last.force_on(0)
    );
    let about = model.centre(0, &last.a);
    let beside = about - Vector2::new(1.0, 0.0);
    let lever = last.moment_on(0, beside) - last.moment_on(0, about);
    assert!((lever - last.force_on(0).y).abs() < 1e-9);
}

#[test]
fn a_state_whose_certificate_fails_is_no_silent_answer() {
    let (_, mut run) = made(&standing());
    assert!(run.uncertified().is_empty(), "{:?}", run.uncertified());
    if let Some(measures) = &mut run.states[1].measures {
        (measures.falling, measures.exact) = (2, false);
    }
    let said = run.uncertified();
    assert!(said.len() == 1, "{said:?}");
    for word in ["at rest", "a saddle: 2", "barriers"] {
        assert!(said[0].contains(word), "{word}: {said:?}");
    }
}

#[test]
fn frames_may_end_behind_barriers() {
    let (_, run) = made(&PUSHED.replace("walls = \"barrier\"", "walls = \"barrier\", exact = false"));
    assert!(run.uncertified().is_empty());
    let measures = run.states[1].measures.unwrap();
    assert!(!measures.exact && measures.least_gap > 1e-4, "{measures:?}");
}
