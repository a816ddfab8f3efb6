//! What `simulate check` says: all that a scene models, and so all that it does not.

use std::fmt::Write;

use crate::model::{Model, Move};
use crate::scene::raw::{RawOverlaps, RawScene, RawWalls};

/// The model in words.
pub(crate) fn described(scene: &RawScene, model: &Model) -> String {
    let mut text = format!("{}\n", scene.title);
    let line = |text: &mut String, words: String| {
        // A String takes all that is written to it.
        let _ = writeln!(text, "{words}");
    };
    let bodies = &model.system.bodies;
    line(
        &mut text,
        format!(
            "lengths in {}, stresses in {}; plane strain, no friction",
            scene.units.length, scene.units.stress
        ),
    );
    line(
        &mut text,
        format!("unknowns   {}, of which {} free", bodies.size(), model.free()),
    );
    for (k, solid) in model.solids.iter().enumerate() {
        let held = match (solid.driven, solid.held) {
            (true, _) => ", driven by the steps",
            (_, true) => ", held",
            _ => "",
        };
        let count = bodies.solid(k).parameters();
        line(
            &mut text,
            format!("solid      {}: {}, {count} parameters{held}", solid.name, solid.kind),
        );
    }
    for wall in &model.walls {
        let names: Vec<&str> = wall.keeps.iter().map(|k| model.solids[*k].name.as_str()).collect();
        let how = match model.how {
            RawWalls::Exact => "exact",
            RawWalls::Barrier => "barrier",
            RawWalls::BarrierThenExact => "barrier, then exact",
        };
        let (x, y) = (wall.normal.x, wall.normal.y);
        line(
            &mut text,
            format!(
                "wall       {}: out of {x} x + {y} y <= {} ({how}), for {}",
                wall.name,
                wall.offset,
                names.join(", ")
            ),
        );
    }
    if !scene.links.is_empty() || !scene.forces.is_empty() {
        line(
            &mut text,
            format!("links      {}, forces {}", scene.links.len(), scene.forces.len()),
        );
    }
    line(&mut text, contact(model));
    for pair in &model.separated {
        line(
            &mut text,
            format!(
                "moved      {} out of {}, {:.3e} deep",
                pair.solid, pair.from, pair.depth
            ),
        );
    }
    for (k, step) in model.steps.iter().enumerate() {
        line(
            &mut text,
            format!("step {k}     {} frames: {}", step.frames, moves(model, &step.moves)),
        );
    }
    if !scene.search.settle {
        line(
            &mut text,
            "search     none: states are shown as they are placed".to_owned(),
        );
    }
    text
}

fn contact(model: &Model) -> String {
    match model.touch {
        None => "contact    none: solids pass through one another".to_owned(),
        Some(touch) => {
            let overlaps = match touch.overlaps {
                RawOverlaps::Refuse => "refused",
                RawOverlaps::Move => "moved apart",
                RawOverlaps::Push => "pushed apart",
            };
            let [first, last] = touch.widths;
            format!(
                "contact    of all solids, over {first:.3e} at first and {last:.3e} at last; overlaps at the start {overlaps}"
            )
        }
    }
}

fn moves(model: &Model, moves: &[Move]) -> String {
    let one = |m: &Move| match m {
        Move::Wall { wall, advance } => format!("wall {} by {advance}", model.walls[*wall].name),
        Move::Solid { solid, moving } => {
            let (name, by) = (&model.solids[*solid].name, moving.by);
            format!("solid {name} by ({}, {}), turned by {} rad", by.x, by.y, moving.turned)
        }
    };
    let words: Vec<String> = moves.iter().map(one).collect();
    if words.is_empty() {
        "nothing moves".to_owned()
    } else {
        words.join("; ")
    }
}
