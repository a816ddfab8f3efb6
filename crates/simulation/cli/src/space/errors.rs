//! Errors of the last state in three parts that are never added up: algebraic, of the mesh, of the model.
//!
//! What could not be found is said to be not known, with the reason, and is never zero.

mod algebraic;
mod finer;
mod spread;

use nalgebra::Vector3;
use organs::{Labels, Model, Plan};
use simulation::space::equilibrium::{Tolerance, settle};

use super::run::{self, Run, State, is_minimum};
use crate::run::Stopwatch;
pub(super) use algebraic::Algebraic;
pub(super) use finer::{Finer, REACH};
pub(super) use spread::{Moved, Parameter};

/// What is known of the errors of a run.
#[derive(Debug)]
pub(super) enum Said {
    /// Nobody asked.
    NotAsked,
    /// The run is not that far.
    NotYet,
    /// There is no state to have them.
    NotKnown(String),
    /// Of the last state.
    Found(Box<Errors>),
}

/// The errors of the last state.
#[derive(Debug)]
pub(super) struct Errors {
    /// Of which state.
    pub(super) of: String,
    pub(super) algebraic: Result<Algebraic, String>,
    pub(super) finer: Result<Finer, String>,
    pub(super) model: Moved,
}

impl Errors {
    /// The algebraic error of a target or of the force, the larger of both; `None` where either is not known: free forces say nothing of
    /// what pressures still lack.
    pub(super) fn left_over(&self, target: Option<usize>) -> Option<f64> {
        let found = self.algebraic.as_ref().ok()?;
        let further = found.further.as_ref().ok()?.at(target).norm();
        let bound = target.and_then(|k| found.bounds.get(k).copied());
        Some(bound.map_or(further, |bound| further.max(bound)))
    }
}

/// Displacements of all targets, mm, and the force on the tube, N, or differences of them; in the patient's axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct At {
    pub(super) targets: Vec<Vector3<f64>>,
    pub(super) force: Vector3<f64>,
}

impl At {
    /// Of a state.
    fn of(model: &Model, labels: &Labels, a: &[f64]) -> Self {
        let bodies = &model.system.bodies;
        let force = model.system.tubes.iter().map(|tube| tube.force(bodies, a).force).sum();
        Self {
            targets: displacements(model, labels, a),
            force: labels.turned(&force),
        }
    }

    /// That of a target, or the force.
    pub(super) fn at(&self, target: Option<usize>) -> Vector3<f64> {
        target.and_then(|k| self.targets.get(k)).copied().unwrap_or(self.force)
    }

    fn minus(&self, other: &Self) -> Self {
        let each = self.targets.iter().zip(&other.targets);
        Self {
            targets: each.map(|(one, other)| one - other).collect(),
            force: self.force - other.force,
        }
    }
}

fn displacements(model: &Model, labels: &Labels, a: &[f64]) -> Vec<Vector3<f64>> {
    let bodies = &model.system.bodies;
    let each = model
        .targets
        .iter()
        .map(|target| labels.turned(&target.moved(bodies, a)));
    each.collect()
}

/// The state that errors are of, with what it gives.
struct Base<'a> {
    plan: &'a Plan,
    labels: &'a Labels,
    /// Its tubes are where they are in that state, with its pressures.
    model: &'a Model,
    state: &'a State,
    at: At,
}

impl Base<'_> {
    /// Goes on to the state of a model like the base's from `a`, and gives what that has beside the base.
    fn settled(&self, model: &mut Model, a: &mut Vec<f64>, tight: f64) -> Result<At, String> {
        let mut newton = run::newton(model, self.plan, tight * run::TOLERANCE)?;
        let usual = Tolerance::default();
        let tolerance = Tolerance {
            change: tight * usual.change,
            depth: tight * usual.depth,
        };
        let found = settle(&mut model.system, &mut newton, a, &tolerance).map_err(|why| why.to_string())?;
        if !is_minimum(&found) {
            return Err("the state found is no minimum, or not known to be one".to_owned());
        }
        Ok(At::of(model, self.labels, a).minus(&self.at))
    }
}

/// The errors of the last state of a whole run; `tell` gets a line for each part.
pub(super) fn of(run: &Run, plan: &Plan, labels: &Labels, model: &Model, tell: &mut dyn FnMut(&str)) -> Said {
    with_mesh(run, plan, labels, model, tell, finer::of)
}

/// Without that of the mesh, which takes longer than all others together.
#[cfg(test)]
pub(super) fn of_numbers(run: &Run, plan: &Plan, labels: &Labels, model: &Model) -> Said {
    let no_mesh = |_: &Base<'_>| Err("not looked for".to_owned());
    with_mesh(run, plan, labels, model, &mut |line| println!("{line}"), no_mesh)
}

fn with_mesh(
    run: &Run,
    plan: &Plan,
    labels: &Labels,
    model: &Model,
    tell: &mut dyn FnMut(&str),
    mesh: impl FnOnce(&Base<'_>) -> Result<Finer, String>,
) -> Said {
    let state = match (&run.refused, run.states.last()) {
        (None, Some(state)) if state.found.is_some_and(|found| is_minimum(&found)) => state,
        (None, Some(_)) => return Said::NotKnown("the last state is no minimum, or not known to be one".to_owned()),
        _ => return Said::NotKnown("the run ended early".to_owned()),
    };
    let base = Base {
        plan,
        labels,
        model,
        state,
        at: At::of(model, labels, &state.a),
    };
    let mut timed = |what: &str, began: Stopwatch| tell(&format!("errors: {what}, {:.1} s", 1e-3 * began.ms()));
    let began = Stopwatch::start();
    let algebraic = algebraic::of(&base);
    timed(&said("algebraic", algebraic.as_ref().err()), began);
    let began = Stopwatch::start();
    let finer = mesh(&base);
    timed(
        &said("of the mesh, by cubes half as large", finer.as_ref().err()),
        began,
    );
    let model = spread::of(&base, &mut timed);
    Said::Found(Box::new(Errors {
        of: state.label.clone(),
        algebraic,
        finer,
        model,
    }))
}

fn said(part: &str, why: Option<&String>) -> String {
    why.map_or_else(|| part.to_owned(), |why| format!("{part}: NOT KNOWN: {why}"))
}
