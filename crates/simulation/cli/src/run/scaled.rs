//! Scenes of very unlike stiffness, far from the origin, without a load, and crushed.

use std::path::Path;

use nalgebra::Vector2;

use super::{Run, run};
use crate::model::Model;
use crate::scene::Source;

fn made(text: &str) -> Run {
    let source = Source::parse(text.to_owned(), Path::new("s.toml")).unwrap();
    let mut model = Model::new(&source.scene).unwrap_or_else(|e| panic!("{e}"));
    run(&mut model, &source.scene.search, &mut |_| {})
}

/// The force on the first wall in the last state; every state is certified.
fn certified(what: &str, text: &str) -> f64 {
    let run = made(text);
    assert_eq!(run.refused, None, "{what}");
    assert!(run.uncertified().is_empty(), "{what}: {:?}", run.uncertified());
    run.states[run.states.len() - 1].force_on_wall(0).norm()
}

const HEAD: &str = "title = \"scaled\"\nunits = { length = \"mm\", stress = \"kPa\" }\n";

fn materials(ratio: f64) -> String {
    let one = |name: &str, young: f64| {
        format!("[[materials]]\nname = \"{name}\"\nlaw = \"neo-hookean\"\nyoung = {young:?}\npoisson = 0.3\n")
    };
    one("soft", 1.0) + &one("stiff", ratio)
}

fn wall(name: &str, normal: [i32; 2], offset: f64) -> String {
    format!("[[walls]]\nname = \"{name}\"\nnormal = {normal:?}\noffset = {offset:?}\n")
}

/// A rounded solid that rolls to rest on another, which is held at its foot, between two walls.
fn rounded(ratio: f64, [lower, upper]: [&str; 2], at: Vector2<f64>) -> String {
    let solid = |name: &str, material: &str, [x, y, a]: [f64; 3], turned: f64| {
        format!(
            "[[solids]]\nname = \"{name}\"\nmaterial = \"{material}\"\nweight = [0, -5e-3]\n\
             rounded = {{ centre = [{:?}, {:?}], half_axes = [{a:?}, 0.6], turned = {turned:?}, elements = [2, 2] }}\n",
            at.x + x,
            at.y + y
        )
    };
    HEAD.to_owned()
        + &materials(ratio)
        + &solid("lower", lower, [0.0, 0.51, 1.0], 0.0)
        + &format!("held = {{ low = [-1e9, -1e9], high = [1e9, {:?}] }}\n", at.y + 0.2)
        + &solid("upper", upper, [0.02, 1.76, 0.7], 0.1)
        + &wall("floor", [0, 1], at.y - 1.0)
        + &wall("left", [1, 0], at.x - 1.2)
        + &wall("right", [-1, 0], -at.x - 1.2)
        + "[contact]\n[search]\nwalls = \"barrier\"\n"
}

/// A block that lies flat on a wider one, on a floor; so many elements along each.
fn flat(ratio: f64, at: Vector2<f64>, [below, above]: [usize; 2]) -> String {
    let solid = |name: &str, material: &str, [x, y, size]: [f64; 3], across: usize| {
        format!(
            "[[solids]]\nname = \"{name}\"\nmaterial = \"{material}\"\nweight = [0, -0.01]\n\
             rectangle = {{ corner = [{:?}, {:?}], size = [{size:?}, 1], elements = [{across}, 2] }}\n",
            at.x + x,
            at.y + y
        )
    };
    HEAD.to_owned()
        + &materials(ratio)
        + &solid("lower", "stiff", [0.0, 0.005, 2.0], below)
        + &solid("upper", "soft", [0.5, 1.01, 1.0], above)
        + &wall("floor", [0, 1], at.y)
        + "[contact]\n[search]\nwalls = \"barrier\"\n"
}

/// Ratios of stiffness from 1 to 1e9, either solid the softer one.
#[test]
fn soft_and_stiff_solids_rest_on_one_another_at_ratios_up_to_1e9() {
    for ratio in [1.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9] {
        for order in [["stiff", "soft"], ["soft", "stiff"]] {
            certified(&format!("{order:?} {ratio}"), &rounded(ratio, order, Vector2::zeros()));
        }
    }
}

#[test]
fn tissue_lies_flat_on_bone() {
    // From 1e6 on what rounding leaves of the stiff solid's forces is more than 1e-8 of the weight.
    for ratio in [1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9] {
        for elements in [[2, 2], [3, 2], [2, 3], [4, 3], [4, 4], [3, 5], [7, 3]] {
            certified(
                &format!("{ratio} {elements:?}"),
                &flat(ratio, Vector2::zeros(), elements),
            );
        }
    }
}

/// Offsets from none to 1e3 sizes: the same forces.
#[test]
fn a_scene_a_thousand_sizes_away_is_the_same() {
    let places = [0.0, 1.0, 10.0, 30.0, 100.0, 300.0, 1000.0, -1000.0];
    let scene = |kind: usize, far: f64| match kind {
        0 => rounded(1.0, ["soft", "soft"], Vector2::new(far, 0.7 * far)),
        _ => flat(1.0, Vector2::new(far, 0.7 * far), [4, 3]),
    };
    for kind in 0..2 {
        let forces: Vec<f64> = places
            .iter()
            .map(|far| certified(&format!("{kind} {far}"), &scene(kind, *far)))
            .collect();
        for (far, force) in places.iter().zip(&forces) {
            // The floor bears what it bore, to the balance of forces of a certificate.
            assert!(
                (force - forces[0]).abs() <= 2e-6 * forces[0],
                "{far}: {force} {}",
                forces[0]
            );
        }
    }
}

/// Walls that only press, and that only touch: there is no load to measure forces by.
#[test]
fn walls_without_a_load_converge() {
    let block = |y: f64, walls: &str, how: &str| {
        HEAD.to_owned()
            + &materials(1.0)
            + &format!(
                "[[solids]]\nname = \"block\"\nmaterial = \"soft\"\nrectangle = {{ corner = [0, {y:?}], size = [1, 1], elements = [2, 2] }}\n"
            )
            + &wall("floor", [0, 1], 0.0)
            + walls
            + &format!("[search]\nwalls = \"{how}\"\n")
    };
    for (down, by) in [(-0.95, 0.05), (-0.7, 0.3), (-0.9999, 1e-4)] {
        let force = certified(&format!("{down}"), &block(0.0, &wall("top", [0, -1], down), "exact"));
        // Pressed by a strain to a stress of E / (1 - nu^2) times it, to second order.
        let expected = by / 0.91;
        assert!(
            (force / expected - 1.0).abs() < 3.0 * by + 1e-3,
            "{down}: {force} {expected}"
        );
    }
    for (y, how) in [
        (0.0, "exact"),
        (0.1, "exact"),
        (-0.05, "exact"),
        (0.01, "barrier"),
        (0.003, "barrier"),
        (0.003, "barrier-then-exact"),
    ] {
        certified(&format!("{y} {how}"), &block(y, "", how));
    }
}

/// Forces times gaps were measured by the weight alone: pressed a thousand times harder nothing was certified.
#[test]
fn walls_may_press_by_any_multiple_of_the_weight() {
    for weight in [1e-2, 1e-4, 1e-6, 1e-8, 1e-12] {
        for how in ["exact", "barrier"] {
            let text = HEAD.to_owned()
                + &materials(1.0)
                + &format!(
                    "[[solids]]\nname = \"block\"\nmaterial = \"soft\"\nweight = [0, {:?}]\n\
                     rectangle = {{ corner = [0, 4e-3], size = [1, 1], elements = [2, 2] }}\n",
                    -weight
                )
                + &wall("floor", [0, 1], 0.0)
                + &wall("top", [0, -1], -1.008)
                + &format!("[search]\nwalls = \"{how}\"\n")
                + "[[steps]]\nframes = 2\nmoves = [{ wall = \"top\", advance = 0.027 }]\n";
            certified(&format!("{how} {weight:e}"), &text);
        }
    }
}

/// What is proposed is not in use already.
#[test]
fn a_crushed_neo_hookean_solid_is_not_told_to_use_a_neo_hookean_law() {
    let crushed = |law: &str| {
        let text = HEAD.to_owned()
            + &materials(1.0).replace("neo-hookean", law)
            + "[[solids]]\nname = \"block\"\nmaterial = \"soft\"\nweight = [3, -900]\n\
               rectangle = { corner = [0, 0.01], size = [1, 4], elements = [2, 6] }\n"
            + &wall("floor", [0, 1], 0.0)
            + &wall("right", [-1, 0], -1.5)
            + "[search]\nwalls = \"barrier\"\nmost_steps = 40\n";
        made(&text).refused.unwrap_or_default()
    };
    let neo = crushed("neo-hookean");
    assert!(neo.contains("no convergence") && !neo.contains("law"), "{neo}");
    for law in ["st-venant-kirchhoff", "stable-neo-hookean"] {
        let other = crushed(law);
        assert!(
            other.contains("use law = \"neo-hookean\"") || other.contains("Use law = \"neo-hookean\""),
            "{other}"
        );
    }
}
