//! Solids that overlap at the start: moved apart if the scene asks for it, else refused with the pairs.

use ::scene::Invalid;
use nalgebra::Vector2;

use super::Model;
use super::intrusion::{Intrusion, Partner, intrusions};
use crate::scene::raw::{RawOverlaps, RawWalls};
use crate::scene::{Checked, invalid};

/// Rounds of moving pairs apart.
const MOST_ROUNDS: usize = 500;
/// Pairs that a refusal lists.
const MOST_NAMED: usize = 8;

/// A pair that was moved apart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Separated {
    pub(crate) solid: String,
    pub(crate) from: String,
    /// How deep it was.
    pub(crate) depth: f64,
    /// Its deepest point before, and the nearest point of the other boundary.
    pub(crate) at: [Vector2<f64>; 2],
}

impl Model {
    /// Moves overlapping solids apart, or refuses them. The state before is kept for pictures in `separated`.
    pub(super) fn separate(&mut self, settle: bool) -> Checked<()> {
        let overlaps = self.touch.map_or(RawOverlaps::Refuse, |touch| touch.overlaps);
        let found: Vec<Intrusion> = self.hurtful(settle);
        if found.is_empty() {
            return Ok(());
        }
        if overlaps == RawOverlaps::Refuse {
            return if settle {
                Err(self.refusal(&found, "overlap or touch"))
            } else {
                Ok(())
            };
        }
        self.separated = found.iter().map(|i| self.described(i)).collect();
        for _ in 0..MOST_ROUNDS {
            let left = self.hurtful(settle);
            if left.is_empty() {
                break;
            }
            for intrusion in left.iter().filter(|i| i.depth.is_finite()) {
                match overlaps {
                    RawOverlaps::Push => self.push(intrusion),
                    _ => self.shift(intrusion),
                }
            }
        }
        let left = self.hurtful(settle);
        if !left.is_empty() {
            return Err(self.refusal(
                &left,
                &format!("still overlap after {MOST_ROUNDS} rounds of moving them apart"),
            ));
        }
        Ok(())
    }

    /// Intrusions that the search cannot start from: exact walls push solids out by themselves.
    fn hurtful(&self, settle: bool) -> Vec<Intrusion> {
        let exact = settle && self.how == RawWalls::Exact;
        let all = intrusions(self, &self.start).into_iter();
        all.filter(|i| !(exact && matches!(i.into, Partner::Wall(_)))).collect()
    }

    fn partner(&self, into: Partner) -> &str {
        match into {
            Partner::Solid(k) => &self.solids[k].name,
            Partner::Wall(k) => &self.walls[k].name,
        }
    }

    fn described(&self, intrusion: &Intrusion) -> Separated {
        Separated {
            solid: self.solids[intrusion.solid].name.clone(),
            from: self.partner(intrusion.into).to_owned(),
            depth: intrusion.depth,
            at: [intrusion.at, intrusion.at + intrusion.way * intrusion.depth],
        }
    }

    fn refusal(&self, found: &[Intrusion], what: &str) -> Invalid {
        let pair = |i: &Intrusion| {
            let (solid, into) = (&self.solids[i.solid].name, self.partner(i.into));
            if i.depth.is_infinite() {
                return format!(
                    "{solid:?} and {into:?}, which lie in one another too closely, or too far away, to tell"
                );
            }
            let (x, y) = (i.at.x, i.at.y);
            if i.into == Partner::Solid(i.solid) {
                return format!("{solid:?} in itself by {:.3e} at ({x:.6}, {y:.6})", i.depth);
            }
            format!("{solid:?} in {into:?} by {:.3e} at ({x:.6}, {y:.6})", i.depth)
        };
        let pairs: Vec<String> = found.iter().take(MOST_NAMED).map(pair).collect();
        let more = if found.len() > MOST_NAMED { ", and more" } else { "" };
        let first = found.first().map_or(0, |i| i.solid);
        let found = format!("solids that {what}: {}{more}", pairs.join("; "));
        let allowed = "solids apart at the start, or contact.overlaps = \"move\" or \"push\"";
        invalid(format!("solids.{first}"), found, allowed)
    }

    /// How far beyond the contact they are moved: so that barriers begin with some room.
    fn margin(&self) -> f64 {
        0.5 * self.widths()[0]
    }

    /// Moves whole solids, as much of each as is free to move.
    fn shift(&mut self, intrusion: &Intrusion) {
        let other = match intrusion.into {
            Partner::Solid(other) => Some(other),
            Partner::Wall(_) => None,
        };
        let free = |k: usize| !self.solids[k].held;
        let shares = match other {
            None => [1.0, 0.0],
            Some(other) => match (free(intrusion.solid), free(other)) {
                (true, true) => [0.5, 0.5],
                (true, false) => [1.0, 0.0],
                (false, true) => [0.0, 1.0],
                (false, false) => [0.0, 0.0],
            },
        };
        let by = intrusion.way * (intrusion.depth + self.margin());
        let bodies = &self.system.bodies;
        let solid = bodies.solid(intrusion.solid);
        solid.translate(bodies.part_mut(intrusion.solid, &mut self.start), by * shares[0]);
        if let Some(other) = other {
            bodies
                .solid(other)
                .translate(bodies.part_mut(other, &mut self.start), by * -shares[1]);
        }
    }

    /// Changes the parameters by the least that takes the deepest points apart to first order: along the gradient of
    /// the constraint, as in figures 28 and 29 of the thesis.
    fn push(&mut self, intrusion: &Intrusion) {
        let bodies = &self.system.bodies;
        let mut rows: Vec<(usize, f64)> = Vec::new();
        let mut add = |body: usize, cursor: &simulation::solid::Cursor, way: Vector2<f64>| {
            let (first, part) = (bodies.offset(body), bodies.part(body, &self.start));
            cursor.rows(bodies.solid(body), part, &mut |parameter, by, _| {
                if !self.system.fixed[first + parameter] {
                    rows.push((first + parameter, by.dot(&way)));
                }
            });
        };
        add(intrusion.solid, &intrusion.cursor, intrusion.way);
        if let (Partner::Solid(other), Some(foot)) = (intrusion.into, &intrusion.foot) {
            add(other, foot, -intrusion.way);
        }
        let square: f64 = rows.iter().map(|r| r.1 * r.1).sum();
        if square > 0.0 {
            // A tenth of the margin beyond the contact, so that the rounds come to an end.
            let by = (intrusion.depth + 0.1 * self.margin()) / square;
            rows.iter().for_each(|(unknown, row)| self.start[*unknown] += row * by);
        }
    }
}
