//! The stroke: from state to state, each in equilibrium, each with the numbers that it rests on.

mod parts;
mod search;

use nalgebra::Vector3;
use organs::{Labels, Model, Plan};
use simulation::control::{Newton, Potential, Settings};
use simulation::space::equilibrium::{Equilibrium, NoEquilibrium};
use simulation::sparse::Dissection;

use super::tissue::{self, Between};
use crate::output::OutputError;
use crate::run::Stopwatch;
use parts::Parts;
use search::Search;

/// The largest free force over the largest load.
pub(super) const TOLERANCE: f64 = 1e-8;

/// A part of a step is no shorter than this part of a voxel's least side, as nearer than that nothing is known of an organ's shape; but steps
/// that are short themselves are halved four times too.
const LEAST_OF_VOXEL: f64 = 1.0 / 32.0;
const LEAST_OF_STEP: f64 = 1.0 / 16.0;

/// What the tissue does to the tube, in the patient's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OnTube {
    /// N.
    pub(super) force: Vector3<f64>,
    /// N mm, about the tip.
    pub(super) moment: Vector3<f64>,
    /// Points of surfaces that press.
    pub(super) points: usize,
    /// The area that they stand for, before the deformation, mm^2.
    pub(super) area: f64,
    /// The deepest point in the tube, mm.
    pub(super) depth: f64,
}

/// A state of the run.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) label: String,
    /// How far the tip has gone from where it first touches, mm.
    pub(super) stroke: f64,
    pub(super) a: Vec<f64>,
    /// Absent where the forces do not balance.
    pub(super) found: Option<Equilibrium>,
    pub(super) on_tube: OnTube,
    /// What organs do to what is rigid and keeps them out, of each contact of the scene; moments about the first voxel's middle.
    pub(super) on_rigid: Vec<OnTube>,
    /// What tube, obstacles, springs and held nodes leave over on the organs, beside the force on the tube.
    pub(super) balance: f64,
    /// The deepest place of a surface in the tube, between its points too.
    pub(super) between: Between,
    /// Area of surfaces, before the deformation, that lies in what the scene names rigid, mm^2.
    pub(super) in_rigid: f64,
    /// Parts that the step was made in.
    pub(super) parts: usize,
    pub(super) seconds: f64,
}

/// What a run found.
#[derive(Debug, Default)]
pub(super) struct Run {
    pub(super) states: Vec<State>,
    /// Why it ended early.
    pub(super) refused: Option<String>,
}

/// Keeps what was found so far.
pub(super) type Keep<'a> = dyn FnMut(&Model, &Run) -> Result<(), OutputError> + 'a;

/// Runs a model; `tell` gets a line for each state, and `keep` the run after each.
///
/// # Errors
/// What `keep` says.
pub(super) fn run(
    model: &mut Model,
    plan: &Plan,
    labels: &Labels,
    tell: &mut dyn FnMut(&str),
    keep: &mut Keep<'_>,
) -> Result<Run, OutputError> {
    let mut run = Run::default();
    run.refused = strokes(model, plan, labels, &mut run, tell, keep)?.err();
    Ok(run)
}

/// Newton's method for a model, with so much left of the load.
pub(super) fn newton(model: &Model, plan: &Plan, tolerance: f64) -> Result<Newton, String> {
    let order = Dissection::by_places(&model.system.places(), &[]);
    let order = order.map_err(|why| format!("the order of elimination: {why}"))?;
    let control = Settings {
        most_iterations: plan.most_steps,
        tolerance,
        ..Settings::default()
    };
    Ok(Newton::ordered_by(control, order))
}

fn strokes(
    model: &mut Model,
    plan: &Plan,
    labels: &Labels,
    run: &mut Run,
    tell: &mut dyn FnMut(&str),
    keep: &mut Keep<'_>,
) -> Result<Result<(), String>, OutputError> {
    let newton = match newton(model, plan, TOLERANCE) {
        Ok(newton) => newton,
        Err(why) => return Ok(Err(why)),
    };
    let least = (LEAST_OF_VOXEL * labels.spacing.min()).min(LEAST_OF_STEP * model.way.step);
    let parts = Parts::new(least, model.way.step);
    let mut search = Search::new(newton, model.system.initial(), parts);
    let strokes = model.way.strokes();
    for (k, stroke) in strokes.iter().enumerate() {
        let began = Stopwatch::start();
        let made = search.to(model, *stroke);
        let mut state = State::of(model, plan, labels, &search, made.as_ref().ok());
        state.seconds = 1e-3 * began.ms();
        let ended = match made {
            Ok(_) => tissue::refused(&state.between, model.way.radius, labels),
            Err(why) => Some(ended(&why, &search, &tissue::described(model, labels, &state.a))),
        };
        match ended {
            None => {
                state.label = format!("state {k} of {}", strokes.len() - 1);
                tell(&state.line(model));
                run.states.push(state);
                keep(model, run)?;
            }
            Some(why) => {
                state.label = format!("NOT an equilibrium, on the way to state {k}");
                state.found = None;
                run.states.push(state);
                return Ok(Err(format!(
                    "state {k} of {}, {stroke} mm along the stroke: {why}",
                    strokes.len() - 1
                )));
            }
        }
    }
    Ok(Ok(()))
}

/// Why a search ended, how far the one before came, and what the tissue is like where this one stopped.
fn ended(why: &NoEquilibrium, search: &Search, tissue: &str) -> String {
    format!(
        "{}. The last equilibrium is {:.3} mm along the stroke, and no part of {:.3} mm or more leads on. Where the search ended, at {:.3} mm: {}",
        advice(why),
        search.done,
        search.parts.least(),
        search.stroke,
        tissue.trim_end()
    )
}

/// The reason, with what a person can do about it.
fn advice(why: &NoEquilibrium) -> String {
    let what = match why {
        NoEquilibrium::TooDeep { .. } => "Use a smaller tube.step",
        NoEquilibrium::TooCoarse { .. } | NoEquilibrium::Through { .. } => {
            "Use smaller cubes at the tube: organs.cubes, levels and within"
        }
        NoEquilibrium::Search { .. } => {
            "Use a smaller tube.step or stroke, smaller cubes at the tube, or raise search.most_steps"
        }
        NoEquilibrium::Unproved(_) => {
            "Use a shorter tube.stroke, a smaller ball of the contact, or smaller cubes at it"
        }
        _ => "Use a smaller tube.step or stroke, or smaller cubes at the tube",
    };
    format!("{why}. {what}")
}

impl Run {
    /// Labels of the equilibria that are no minima, or not known to be.
    pub(super) fn saddles(&self) -> Vec<&str> {
        let wrong = |state: &&State| state.found.is_some_and(|found| !is_minimum(&found));
        self.states.iter().filter(wrong).map(|s| s.label.as_str()).collect()
    }
}

impl State {
    fn of(model: &Model, plan: &Plan, labels: &Labels, search: &Search, found: Option<&(Equilibrium, usize)>) -> Self {
        let a = search.a.clone();
        let (system, stroke) = (&model.system, search.stroke);
        let tip = model.way.tip(model.free + stroke);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let (mut points, mut area, mut depth) = (0, 0.0, 0.0_f64);
        for contact in &system.tubes {
            let on = contact.force(&system.bodies, &a);
            let origin = contact.tube().pose().translation.vector;
            force += on.force;
            moment += on.moment + (origin - tip).cross(&on.force);
            points += on.points;
            area += on.area;
            depth = depth.max(on.depth);
        }
        let balance = balance(model, &a, &force);
        // By pressures that the next state changes.
        let on_rigid = system.obstacles.iter().map(|obstacle| {
            let on = obstacle.force(&system.bodies, &a);
            OnTube {
                force: labels.turned(&on.force),
                moment: labels.turned(&on.moment),
                points: on.points,
                area: on.area,
                depth: on.depth,
            }
        });
        let on_rigid = on_rigid.collect();
        Self {
            label: String::new(),
            stroke,
            found: found.map(|f| f.0),
            on_tube: OnTube {
                force: labels.turned(&force),
                moment: labels.turned(&moment),
                points,
                area,
                depth,
            },
            on_rigid,
            balance,
            between: tissue::between(model, &a),
            in_rigid: in_rigid(model, plan, labels, &a),
            parts: found.map_or(0, |f| f.1),
            seconds: 0.0,
            a,
        }
    }

    /// A line about it.
    fn line(&self, model: &Model) -> String {
        let Some(found) = &self.found else {
            return self.label.clone();
        };
        let falling = stability(found);
        let targets = model.targets.iter().map(|target| {
            let by = target.moved(&model.system.bodies, &self.a).norm();
            format!("; {} moved {by:.2} mm", target.name)
        });
        let targets: String = targets.collect();
        format!(
            "{}: {:.2} mm, force {:.4} N, residual {:.1e} of the load, {falling}, depth of points {:.1e} mm, between them {:.2} mm, least det F {:.3}, balance {:.1e}; {} parts, {} rounds, {} steps, {:.2} s{targets}",
            self.label,
            self.stroke,
            self.on_tube.force.norm(),
            beside(found.residual, found.load),
            found.depth,
            self.between.depth,
            found.least_determinant,
            self.balance,
            self.parts,
            found.rounds,
            found.iterations,
            self.seconds
        )
    }
}

/// True where the energy falls in no direction.
pub(super) fn is_minimum(found: &Equilibrium) -> bool {
    found.falling == Some(0)
}

/// What is known of a state's stability, in words.
pub(super) fn stability(found: &Equilibrium) -> &'static str {
    match found.falling {
        Some(0) => "a minimum",
        Some(_) => "a SADDLE",
        None => "stability not known",
    }
}

/// A ratio; 0 where there is nothing.
pub(super) fn beside(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// The sum of all outer forces on the organs, obstacles' among them, beside that of the tube: forces inside an organ sum to nothing.
fn balance(model: &Model, a: &[f64], on_tube: &Vector3<f64>) -> f64 {
    let system = &model.system;
    let mut sum = -on_tube;
    for obstacle in &system.obstacles {
        sum -= obstacle.force(&system.bodies, a).force;
    }
    for springs in &model.springs {
        sum += springs.reaction_about(&system.bodies, a, &Vector3::zeros())[0];
    }
    // What a held node does not balance is what holds it.
    let mut gradient = vec![0.0; a.len()];
    if system.gradient(a, &mut gradient).is_none() {
        return f64::NAN;
    }
    for (k, (force, _)) in gradient
        .iter()
        .zip(&system.fixed)
        .enumerate()
        .filter(|(_, (_, fixed))| **fixed)
    {
        sum[k % 3] += force;
    }
    beside(sum.norm(), on_tube.norm())
}

/// Area of the surfaces that lies in rigid labels.
fn in_rigid(model: &Model, plan: &Plan, labels: &Labels, a: &[f64]) -> f64 {
    let rigid: Vec<u16> = plan.rigid.iter().flat_map(|r| r.labels.iter().copied()).collect();
    let bodies = &model.system.bodies;
    let mut area = 0.0;
    for body in 0..bodies.len() {
        let (solid, part) = (bodies.solid(body), bodies.part(body, a));
        for point in 0..solid.points() {
            let label = labels.at(&solid.point(part, point));
            if label != 0 && rigid.contains(&label) {
                area += solid.reference(point).2;
            }
        }
    }
    area
}
