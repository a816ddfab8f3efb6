//! What `simulate check` says: all that a scene models, and so all that it does not.

use std::fmt::Write;

use crate::model::{Model, Move};
use crate::run::{Measures, Run};
use crate::scene::raw::{RawOverlaps, RawScene, RawWalls};

/// What the certificates of a whole run say together: the worst of each number.
pub(crate) fn certified(run: &Run) -> String {
    let all: Vec<&Measures> = run.states.iter().filter_map(|s| s.measures.as_ref()).collect();
    if all.is_empty() {
        return format!("{} states as they are placed", run.states.len());
    }
    let most = |number: fn(&Measures) -> f64| all.iter().map(|m| number(m)).fold(0.0, f64::max);
    let least = |number: fn(&Measures) -> f64| all.iter().map(|m| number(m)).fold(f64::INFINITY, f64::min);
    let gap = least(|m| m.least_gap);
    let gaps = if gap.is_finite() {
        format!(
            ", gaps from {gap:.1e}, force times gap up to {:.1e}",
            most(|m| m.complementarity)
        )
    } else {
        String::new()
    };
    let barriers = all.iter().filter(|m| !m.exact).count();
    let how = match barriers {
        0 => "all certified".to_owned(),
        n => format!("all certified, {n} of them behind barriers"),
    };
    format!(
        "{} equilibria, {how}: free force up to {:.1e} of the load{gaps}, force balance to {:.1e}, least det F {:.3}",
        all.len(),
        most(|m| m.free_force),
        most(|m| m.force_balance),
        least(|m| m.least_determinant),
    )
}

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
            let whose = pairs(model);
            format!(
                "contact    of {whose}, over {first:.3e} at first and {last:.3e} at last; overlaps at the start {overlaps}"
            )
        }
    }
}

/// The solids that keep apart.
fn pairs(model: &Model) -> String {
    let name = |k: usize| model.solids[k].name.as_str();
    let pair = |[i, j]: &[usize; 2]| {
        if i == j {
            format!("{} with itself", name(*i))
        } else {
            format!("{} and {}", name(*i), name(*j))
        }
    };
    match &model.pairs {
        None => "all solids".to_owned(),
        Some(named) => named.iter().map(pair).collect::<Vec<_>>().join(", "),
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
