//! What uncertain numbers of the scene do: each is moved by its standard deviation up and down, and the state found again from the
//! one at hand.

use organs::plan::Uncertain;
use simulation::space::error::{Shift, Spread};

use super::{At, Base};
use crate::run::Stopwatch;

/// Where a number cannot be moved at once it is moved in so many parts.
const PARTS: [u32; 3] = [1, 2, 4];

/// The error of the model, to first order in its numbers.
#[derive(Debug)]
pub(in super::super) struct Moved {
    pub(in super::super) parameters: Vec<Parameter>,
    /// Keys of numbers that have no standard deviation and are taken as exact.
    pub(in super::super) exact: Vec<String>,
    /// Of each target; `None`: not known.
    pub(in super::super) targets: Vec<Option<Spread>>,
    pub(in super::super) force: Option<Spread>,
    /// The standard deviation of the size of the force, N.
    pub(in super::super) force_size: Option<f64>,
}

/// A number and what it does.
#[derive(Debug)]
pub(in super::super) struct Parameter {
    pub(in super::super) of: Uncertain,
    /// What moving it up, and down, changes.
    pub(in super::super) by: [Result<At, String>; 2],
    /// And the change of the size of the force.
    size: Option<[f64; 2]>,
}

pub(super) fn of(base: &Base<'_>, timed: &mut dyn FnMut(&str, Stopwatch)) -> Moved {
    let all = base.plan.uncertain();
    let count = 2 * all.len();
    let mut parameters = Vec::with_capacity(all.len());
    for (k, one) in all.into_iter().enumerate() {
        let mut by = Vec::with_capacity(2);
        for (which, to) in one.moved.into_iter().enumerate() {
            let began = Stopwatch::start();
            let found = moved(base, &one, to);
            let words = format!("of the model, {} of {count}, {} {to:.4e}", 2 * k + which + 1, one.name);
            timed(&super::said(&words, found.as_ref().err()), began);
            by.push(found);
        }
        let mut by = by.into_iter();
        if let (Some(up), Some(down)) = (by.next(), by.next()) {
            parameters.push(Parameter::new(one, [up, down], base));
        }
    }
    let targets = (0..base.at.targets.len()).map(|k| {
        let shifts: Vec<_> = parameters.iter().map(|p| p.shift(|at| at.targets[k])).collect();
        Spread::of(&shifts)
    });
    let forces: Vec<_> = parameters.iter().map(|p| p.shift(|at| at.force)).collect();
    let squares = parameters
        .iter()
        .map(|p| p.size.map(|[up, down]| (0.5 * (up - down)).powi(2)));
    let force_size = squares
        .sum::<Option<f64>>()
        .filter(|_| !parameters.is_empty())
        .map(f64::sqrt);
    Moved {
        targets: targets.collect(),
        force: Spread::of(&forces),
        force_size,
        exact: base.plan.taken_as_exact(),
        parameters,
    }
}

/// What changes when a number is moved to another value.
fn moved(base: &Base<'_>, one: &Uncertain, to: f64) -> Result<At, String> {
    let mut why = String::new();
    for parts in PARTS {
        match in_parts(base, one, to, parts) {
            Ok(at) => return Ok(at),
            Err(failed) => why = failed,
        }
    }
    Err(why)
}

fn in_parts(base: &Base<'_>, one: &Uncertain, to: f64, parts: u32) -> Result<At, String> {
    let (mut a, mut tubes) = (base.state.a.clone(), base.model.system.tubes.clone());
    let mut last = Err("no part".to_owned());
    for k in 1..=parts {
        let value = one.value + (to - one.value) * f64::from(k) / f64::from(parts);
        let plan = base
            .plan
            .with(one, value)
            .ok_or_else(|| format!("no material has {} {value}", one.key))?;
        let mut model = base.model.changed(&plan, base.labels).map_err(|why| why.to_string())?;
        model.system.tubes = tubes;
        last = Ok(base.settled(&mut model, &mut a, 1.0)?);
        tubes = model.system.tubes;
    }
    last
}

impl Parameter {
    fn new(of: Uncertain, by: [Result<At, String>; 2], base: &Base<'_>) -> Self {
        let size = |at: &At| (base.at.force + at.force).norm() - base.at.force.norm();
        let sizes = match &by {
            [Ok(up), Ok(down)] => Some([size(up), size(down)]),
            _ => None,
        };
        Self { of, by, size: sizes }
    }

    /// How something changes; `None` where a state was not found.
    pub(in super::super) fn shift(&self, what: impl Fn(&At) -> nalgebra::Vector3<f64>) -> Option<Shift> {
        match &self.by {
            [Ok(up), Ok(down)] => Some(Shift {
                by: [what(up), what(down)],
            }),
            _ => None,
        }
    }
}

impl Moved {
    /// Why a part is not known; empty where all is.
    pub(in super::super) fn not_known(&self) -> Vec<String> {
        if self.parameters.is_empty() {
            return vec!["no number of the scene has a standard deviation (young_spread, poisson_spread)".to_owned()];
        }
        let each = self
            .parameters
            .iter()
            .flat_map(|p| p.by.iter().zip(p.of.moved).map(move |(by, to)| (p, by, to)));
        let failed = each.filter_map(|(p, by, to)| by.as_ref().err().map(|why| format!("{} at {to}: {why}", p.of.key)));
        failed.collect()
    }
}
