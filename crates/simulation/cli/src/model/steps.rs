//! What moves, and by how much.

use nalgebra::Vector2;

use super::{Named, Wall};
use crate::scene::raw::{RawMove, RawScene};
use crate::scene::{Checked, finite, invalid, named, pair, within};

/// The most steps, and the most frames of all of them.
const MOST_STEPS: usize = 100;
const MOST_FRAMES: usize = 5000;

/// Frames in which the same moves.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(crate) frames: usize,
    pub(crate) moves: Vec<Move>,
}

/// A move of a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Move {
    /// A wall advances along its normal.
    Wall { wall: usize, advance: f64 },
    /// A driven solid is moved, and turned about its centre, radians.
    Solid { solid: usize, moving: Moving },
}

/// A rigid motion of a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving {
    pub(crate) by: Vector2<f64>,
    pub(crate) turned: f64,
}

pub(super) fn steps(scene: &RawScene, solids: &[Named], walls: &[Wall]) -> Checked<Vec<Step>> {
    within("steps", scene.steps.len(), 0..=MOST_STEPS)?;
    let mut frames = 0;
    let mut steps = Vec::with_capacity(scene.steps.len());
    for (k, raw) in scene.steps.iter().enumerate() {
        within(&format!("steps.{k}.frames"), raw.frames, 1..=MOST_FRAMES)?;
        frames += raw.frames;
        within("steps", frames, 0..=MOST_FRAMES).map_err(|_| {
            invalid(
                format!("steps.{k}.frames"),
                format!("{frames} frames up to here"),
                format!("at most {MOST_FRAMES}"),
            )
        })?;
        if !scene.search.settle {
            let allowed = "no steps where search.settle is false: nothing would follow";
            return Err(invalid(format!("steps.{k}"), "a step", allowed));
        }
        let each = raw.moves.iter().enumerate();
        let moves = each.map(|(i, m)| one(&format!("steps.{k}.moves.{i}"), m, solids, walls));
        steps.push(Step {
            frames: raw.frames,
            moves: moves.collect::<Checked<_>>()?,
        });
    }
    Ok(steps)
}

fn one(key: &str, raw: &RawMove, solids: &[Named], walls: &[Wall]) -> Checked<Move> {
    match (&raw.wall, raw.advance, &raw.solid, raw.by) {
        (Some(name), Some(advance), None, None) if raw.turned == 0.0 => {
            let wall = named(&format!("{key}.wall"), name, walls.iter().map(|w| w.name.as_str()))?;
            let advance = finite(&format!("{key}.advance"), advance)?;
            Ok(Move::Wall { wall, advance })
        }
        (None, None, Some(name), by) => {
            let solid = named(&format!("{key}.solid"), name, solids.iter().map(|s| s.name.as_str()))?;
            if !solids[solid].driven {
                let found = format!("{name:?}, which is not driven");
                return Err(invalid(format!("{key}.solid"), found, "a solid with driven = true"));
            }
            let by = pair(&format!("{key}.by"), by.unwrap_or_default())?;
            let turned = finite(&format!("{key}.turned"), raw.turned)?;
            Ok(Move::Solid {
                solid,
                moving: Moving { by, turned },
            })
        }
        _ => Err(invalid(
            key,
            "another set of keys",
            "{ wall, advance }, or { solid, by, turned } of which the last two may be absent",
        )),
    }
}
