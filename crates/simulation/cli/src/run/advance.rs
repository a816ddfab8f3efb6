//! A frame: walls and instruments go as far as they are told, or as far as contact lets them.
//!
//! An instrument is never put anywhere: it goes along its way by parts that the bound of the motion proves free of contact,
//! and after each part everything else comes to rest. So do walls behind a barrier. Exact walls are half-planes: nothing
//! can be on their other side, and they push out what they meet.

use simulation::control::Potential;

use super::State;
use super::found::Found;
use super::moved::Moved;
use super::settle::Searcher;
use crate::model::{Model, Move, Moving};

/// Parts of a frame, at most.
const MOST_PARTS: usize = 200;
/// Of the way that is proved free, this much is gone in one part: what is met has room to give way.
const USED: f64 = 0.5;
/// After this many parts in a row below this part of the frame, the way counts as blocked.
const BLOCKED: (usize, f64) = (4, 1e-3);
/// Halvings of a part whose equilibrium is not found.
const MOST_HALVINGS: usize = 6;

impl Searcher {
    /// One frame. `a` is the state before, and after it.
    pub(super) fn frame(
        &mut self,
        model: &mut Model,
        a: &mut Vec<f64>,
        moves: &[Move],
        label: &str,
    ) -> Result<State, String> {
        let (mut gone, mut slow, mut sum, mut parts) = (0.0_f64, 0, (0, 0.0), 0);
        let mut last: Option<Found> = None;
        for _ in 0..MOST_PARTS {
            let (part, found) = self.part(model, a, moves, 1.0 - gone)?;
            gone = if part >= 1.0 - gone { 1.0 } else { gone + part };
            sum = (sum.0 + found.iterations, sum.1 + found.milliseconds);
            last = Some(found);
            parts += 1;
            slow = if part < BLOCKED.1 { slow + 1 } else { 0 };
            if gone >= 1.0 || slow >= BLOCKED.0 {
                break;
            }
        }
        let mut found = last.ok_or("nothing moved")?;
        (found.iterations, found.milliseconds) = sum;
        let mut state = self.finish(model, label, a, found);
        state.moved = moves.iter().map(|m| moved(model, m, gone, parts)).collect();
        Ok(state)
    }

    /// Goes a part of the frame, at most `left`, that is free of contact, and lets everything come to rest.
    fn part(&mut self, model: &mut Model, a: &mut Vec<f64>, moves: &[Move], left: f64) -> Result<(f64, Found), String> {
        model.constrain(false);
        let step = driven(model, a, moves);
        let mut part = left * self.free(model, a, &step, moves, left);
        let mut refused = String::new();
        for _ in 0..=MOST_HALVINGS {
            let before = (a.clone(), model.walls.clone());
            a.iter_mut().zip(&step).for_each(|(a, s)| *a += part * s);
            for m in moves {
                if let Move::Wall { wall, advance } = m {
                    model.walls[*wall].offset += part * advance;
                }
            }
            match self.next(model, a) {
                Ok(found) => return Ok((part, found)),
                Err(why) => refused = why,
            }
            (*a, model.walls) = before;
            part *= 0.5;
        }
        Err(format!("after {MOST_HALVINGS} halvings of the move: {refused}"))
    }

    /// The part of `left` of the moves, at most 1, that is free: 1 where all of it is.
    fn free(&self, model: &Model, a: &[f64], step: &[f64], moves: &[Move], left: f64) -> f64 {
        let whole: Vec<f64> = step.iter().map(|s| left * s).collect();
        let reach = model.system.reach(a, &whole);
        let mut part = if reach < 1.0 { USED * reach } else { 1.0 };
        for m in moves {
            if let Move::Wall { wall, advance } = m {
                let room = model.room(*wall, a);
                if left * advance > room {
                    part = part.min(room / (left * advance));
                }
            }
        }
        part
    }
}

/// The change of the parameters of all driven solids in a whole frame.
fn driven(model: &Model, a: &[f64], moves: &[Move]) -> Vec<f64> {
    let mut step = vec![0.0; a.len()];
    let bodies = &model.system.bodies;
    for m in moves {
        let Move::Solid {
            solid,
            moving: Moving { by, turned },
        } = m
        else {
            continue;
        };
        let body = bodies.solid(*solid);
        let mut part = bodies.part(*solid, a).to_vec();
        let before = part.clone();
        body.rotate(&mut part, *turned, model.centre(*solid, a));
        body.translate(&mut part, *by);
        for (s, (after, before)) in bodies
            .part_mut(*solid, &mut step)
            .iter_mut()
            .zip(part.iter().zip(before))
        {
            *s += after - before;
        }
    }
    step
}

fn moved(model: &Model, m: &Move, part: f64, parts: usize) -> Moved {
    match m {
        Move::Wall { wall, advance } => Moved {
            name: model.walls[*wall].name.clone(),
            asked: *advance,
            part,
            parts,
        },
        Move::Solid { solid, moving } => Moved {
            name: model.solids[*solid].name.clone(),
            asked: moving.by.norm().max(moving.turned.abs()),
            part,
            parts,
        },
    }
}
