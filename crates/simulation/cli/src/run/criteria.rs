//! What certifies a state: one set of criteria for every scene and unit.

use nalgebra::Vector2;
use simulation::constraint::intersections;

use super::contact::Contact;
use super::found::Found;
use crate::model::{Maker, Model};

/// The largest free force, in largest loads or reactions.
const FREE_FORCE: f64 = 1e-8;
/// The last change of a force of a link or a wall, in the same.
const FORCE_CHANGE: f64 = 1e-7;
/// The largest violation of a link, in sizes of the largest solid.
const VIOLATION: f64 = 1e-9;
/// The largest force times gap, see [`work`], in sizes of the largest solid.
const COMPLEMENTARITY: f64 = 1e-8;
/// What weight, loads and contacts leave over on a solid, in its largest force.
pub(super) const BALANCE: f64 = 1e-6;
/// Below zero by this part of the largest solid, a gap is rounding: exact contact leaves arcs 1e-13 deep between its rows.
const DEPTH: f64 = 1e-12;
/// Boundaries count as touching within this part of it, and may up to twice that: what is found deeper is an overlap.
const CONTACT: f64 = 0.5 * DEPTH;

/// The numbers of a certificate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measures {
    /// Exact contact was wanted: else gaps and complementarity are those of barriers.
    pub(crate) wanted_exact: bool,
    pub(crate) exact: bool,
    pub(crate) free_force: f64,
    pub(crate) force_change: f64,
    pub(crate) violation: f64,
    pub(crate) complementarity: f64,
    /// The least signed distance of true arcs to what they keep out of, a length; infinite without contact.
    pub(crate) least_gap: f64,
    /// The same in sizes of the largest solid.
    pub(crate) relative_gap: f64,
    /// Where a solid lies deepest in another; `None` where all are proved apart.
    pub(crate) deepest: Option<[f64; 2]>,
    /// Pairs of solids that could not be proved apart.
    pub(crate) undecided: usize,
    pub(crate) force_balance: f64,
    pub(crate) least_determinant: f64,
    pub(crate) falling: usize,
    pub(crate) neutral: usize,
}

impl Measures {
    pub(super) fn of(model: &Model, a: &[f64], found: &Found, contacts: &[Contact], balance: &[f64]) -> Self {
        let (equilibrium, minimum) = (&found.equilibrium, &found.equilibrium.minimum);
        let forces = scale(minimum.load, minimum.rounding);
        let load = if minimum.load > 0.0 { minimum.load } else { forces };
        let extent = model.system.bodies.extent();
        let is_touch = |c: &&Contact| matches!(c.maker, Maker::Wall(_) | Maker::Touch);
        let touching: Vec<&Contact> = contacts.iter().filter(is_touch).collect();
        let mut least = touching.iter().map(|c| c.gap).fold(walls(model, a), f64::min);
        // Behind barriers no depth is allowed but rounding.
        let contact = if found.wanted_exact { CONTACT * extent } else { 0.0 };
        let lie = intersections(&model.system.bodies, a, &|i, j| model.meets(i, j), &|_, _| contact);
        let deep = lie.overlaps.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
        least = deep.map_or(least, |deep| least.min(-deep.depth));
        Self {
            wanted_exact: found.wanted_exact,
            exact: equilibrium.exact,
            free_force: minimum.residual / forces,
            force_change: equilibrium.force_change / forces,
            violation: equilibrium.violation / extent,
            complementarity: work(&touching, load) / extent,
            least_gap: least,
            relative_gap: least / extent,
            deepest: deep.map(|deep| [deep.x, deep.y]),
            undecided: lie.undecided.len(),
            force_balance: balance.iter().copied().fold(0.0, f64::max),
            least_determinant: minimum.least_determinant,
            falling: minimum.stability.falling,
            neutral: minimum.stability.neutral,
        }
    }

    /// The criteria that do not hold, in words with numbers; none where the state is certified.
    pub(crate) fn fails(&self) -> Vec<String> {
        let mut fails = Vec::new();
        let mut most = |what: &str, found: f64, allowed: f64| {
            if found.is_nan() || found > allowed {
                fails.push(format!("{what} {found:.1e}, at most {allowed:.0e}"));
            }
        };
        most("free force beside the largest load", self.free_force, FREE_FORCE);
        most("change of a force beside it", self.force_change, FORCE_CHANGE);
        most("violation beside the largest solid", self.violation, VIOLATION);
        most("force left over on a solid", self.force_balance, BALANCE);
        if self.wanted_exact {
            most("force times gap", self.complementarity, COMPLEMENTARITY);
            most(
                "depth in one another beside the largest solid",
                -self.relative_gap,
                DEPTH,
            );
            if !self.exact {
                fails.push("contact is that of barriers: the exact equations were not solved".to_owned());
            }
        } else if self.least_gap < 0.0 {
            fails.push(format!("solids lie {:.1e} deep in one another", -self.least_gap));
        }
        if let Some([x, y]) = self.deepest {
            fails.push(format!("solids lie in one another, deepest at ({x:.6}, {y:.6})"));
        }
        if self.undecided > 0 {
            fails.push(format!("{} pairs of solids could not be proved apart", self.undecided));
        }
        if self.least_determinant.is_nan() || self.least_determinant <= 0.0 {
            fails.push(format!("turned inside out: det F {:.1e}", self.least_determinant));
        }
        if self.falling > 0 {
            fails.push(format!("a saddle: {} directions of falling energy", self.falling));
        }
        fails
    }

    /// Minimum or saddle.
    pub(crate) fn verdict(&self) -> &'static str {
        match (self.falling, self.neutral) {
            (0, 0) => "minimum",
            (0, _) => "minimum, with neutral directions",
            _ => "saddle",
        }
    }

    /// The least gap where there is contact.
    pub(crate) fn gap(&self) -> Option<f64> {
        self.least_gap.is_finite().then_some(self.least_gap)
    }

    /// For a line of text.
    pub(super) fn words(&self) -> String {
        let gap = self.gap().map_or(String::new(), |gap| {
            let how = if self.exact { "" } else { " behind barriers" };
            format!(
                ", gaps from {gap:.1e}{how}, force times gap {:.1e}",
                self.complementarity
            )
        });
        format!(
            "free force {:.1e}{gap}, least det F {:.3}, {}",
            self.free_force,
            self.least_determinant,
            self.verdict()
        )
    }
}

/// The largest force times gap beside the largest load, or beside that force where it is more: what walls press harder than the loads may
/// be off by so much of a size, and what bears less by no more than before.
fn work(touching: &[&Contact], load: f64) -> f64 {
    let each = touching.iter().map(|c| {
        let force = c.force.norm();
        force * c.gap.abs() / force.max(load)
    });
    each.fold(0.0, f64::max)
}

/// What forces are measured by: the largest load or reaction, or where rounding leaves more than its part of that, so much that this is the part.
fn scale(load: f64, rounding: f64) -> f64 {
    let scale = load.max(rounding / FREE_FORCE);
    if scale > 0.0 { scale } else { 1.0 }
}

/// The least height of an arc over a wall that keeps it out.
fn walls(model: &Model, a: &[f64]) -> f64 {
    let bodies = &model.system.bodies;
    let height = |wall: &crate::model::Wall, body: usize| {
        let each = bodies.solid(body).boundary().arcs.iter();
        let over = |arc: &[usize; 3]| lowest(arc.map(|n| bodies.point(body, n, a)), wall.normal) - wall.offset;
        each.map(over).fold(f64::INFINITY, f64::min)
    };
    let all = model.walls.iter().flat_map(|w| w.keeps.iter().map(move |k| (w, *k)));
    all.map(|(wall, body)| height(wall, body)).fold(f64::INFINITY, f64::min)
}

/// The least height of a quadratic arc along a direction.
fn lowest(points: [Vector2<f64>; 3], normal: Vector2<f64>) -> f64 {
    let [low, middle, high] = points.map(|p| p.dot(&normal));
    let (slope, bend) = (0.5 * (high - low), high + low - 2.0 * middle);
    if bend > 0.0 && slope.abs() < bend {
        return middle - 0.5 * slope * slope / bend;
    }
    low.min(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Measures = Measures {
        wanted_exact: true,
        exact: true,
        free_force: 1e-9,
        force_change: 0.0,
        violation: 0.0,
        complementarity: 1e-10,
        least_gap: 1e-11,
        relative_gap: 1e-11,
        deepest: None,
        undecided: 0,
        force_balance: 1e-8,
        least_determinant: 0.5,
        falling: 0,
        neutral: 1,
    };

    /// A block squeezed by walls at its sides with 1e5 times its weight, which hangs above the floor that is to bear it.
    #[test]
    fn a_hard_press_does_not_hide_a_contact_that_stands_off() {
        let contact = |force: f64, gap: f64| Contact {
            maker: Maker::Touch,
            solid: 0,
            point: Vector2::zeros(),
            force: Vector2::new(0.0, force),
            gap,
        };
        let (side, floor, near) = (contact(0.1, 1e-11), contact(1e-6, 1e-4), contact(1e-6, 1e-9));
        assert!(work(&[&side, &near], 1e-6) <= COMPLEMENTARITY);
        assert!(work(&[&side, &floor], 1e-6) > COMPLEMENTARITY);
    }

    #[test]
    fn each_criterion_fails_alone_and_by_name() {
        assert!(GOOD.fails().is_empty());
        let one = |measures: Measures, word: &str| {
            let fails = measures.fails();
            assert!(fails.len() == 1 && fails[0].contains(word), "{fails:?}");
        };
        one(
            Measures {
                free_force: 2e-8,
                ..GOOD
            },
            "2.0e-8",
        );
        one(
            Measures {
                free_force: f64::NAN,
                ..GOOD
            },
            "free force",
        );
        one(
            Measures {
                complementarity: 2e-8,
                ..GOOD
            },
            "force times gap",
        );
        one(
            Measures {
                relative_gap: -2e-12,
                ..GOOD
            },
            "depth",
        );
        one(
            Measures {
                force_balance: 2e-6,
                ..GOOD
            },
            "left over",
        );
        one(
            Measures {
                deepest: Some([0.5, 0.25]),
                ..GOOD
            },
            "in one another, deepest at (0.500000, 0.250000)",
        );
        one(Measures { undecided: 2, ..GOOD }, "2 pairs");
        one(Measures { exact: false, ..GOOD }, "barriers");
        one(Measures { falling: 1, ..GOOD }, "saddle");
        one(
            Measures {
                least_determinant: 0.0,
                ..GOOD
            },
            "inside out",
        );
        one(
            Measures {
                violation: 2e-9,
                ..GOOD
            },
            "violation",
        );
        one(
            Measures {
                force_change: 2e-7,
                ..GOOD
            },
            "change",
        );
        // Behind barriers, where nothing else was asked for, gaps are wide.
        let behind = Measures {
            wanted_exact: false,
            exact: false,
            complementarity: 1e-3,
            ..GOOD
        };
        assert!(behind.fails().is_empty());
        one(
            Measures {
                least_gap: -1e-9,
                ..behind
            },
            "deep",
        );
    }
}
