//! The three errors in `result.json`. What is not known is words or `null`, never 0.

use nalgebra::{Matrix3, Vector3};
use organs::Model;
use serde::Serialize;
use simulation::space::error::{SAFETY, Spread};

use super::super::errors::{Algebraic, Errors, Finer, Moved, Parameter, REACH, Said};
use super::triple;

/// The errors, or words that say why there are none.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(in super::super) enum ErrorsRecord<'a> {
    Words(String),
    Found(Box<Parts<'a>>),
}

/// A part, or why it is not known.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Known<T> {
    Known(T),
    NotKnown { not_known: String },
}

/// Algebraic, of the mesh, of the model: three kinds, no sum.
#[derive(Debug, Serialize)]
pub(in super::super) struct Parts<'a> {
    of: &'a str,
    words: &'static str,
    algebraic: Known<AlgebraicRecord<'a>>,
    discretisation: Known<MeshRecord<'a>>,
    model: ModelRecord<'a>,
}

#[derive(Debug, Serialize)]
struct AlgebraicRecord<'a> {
    words: &'static str,
    /// N.
    largest_free_force: f64,
    targets: Vec<AlgebraicAt<'a>>,
    /// N; null where the search did not go on.
    force: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    not_known: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct AlgebraicAt<'a> {
    name: &'a str,
    by_residual: f64,
    by_going_on: Option<f64>,
}

#[derive(Debug, Serialize)]
struct MeshRecord<'a> {
    words: &'static str,
    factor: f64,
    unknowns: usize,
    unsettled: f64,
    targets: Vec<ChangeRecord<'a>>,
    force: ChangeRecord<'a>,
    /// Of all places of the organ that is pressed, nearer to the tip than `reach` and farther.
    reach: f64,
    near: Option<f64>,
    elsewhere: Option<f64>,
    jumps: Vec<JumpsRecord<'a>>,
}

#[derive(Debug, Serialize)]
struct ChangeRecord<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    change: [f64; 3],
    stated: Option<f64>,
}

#[derive(Debug, Serialize)]
struct JumpsRecord<'a> {
    organ: &'a str,
    cubes: Option<usize>,
    cubes_with_half: Option<usize>,
    worst_at: Option<[f64; 3]>,
}

#[derive(Debug, Serialize)]
struct ModelRecord<'a> {
    words: &'static str,
    not_varied: &'static str,
    taken_as_exact: &'a [String],
    parameters: Vec<ParameterRecord<'a>>,
    targets: Vec<Option<SpreadRecord<'a>>>,
    force: Option<SpreadRecord<'a>>,
    /// Standard deviation of the size of the force, N.
    force_size_deviation: Option<f64>,
    /// Why there is a null above.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    not_known: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ParameterRecord<'a> {
    key: &'a str,
    name: &'a str,
    value: f64,
    /// A standard deviation up, and down.
    moved_to: [f64; 2],
    targets: Vec<Option<ShiftRecord<'a>>>,
    force: Option<ShiftRecord<'a>>,
}

#[derive(Debug, Serialize)]
struct ShiftRecord<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    /// For a standard deviation up, to first order.
    by: [f64; 3],
    departure: f64,
}

#[derive(Debug, Serialize)]
struct SpreadRecord<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    covariance: [[f64; 3]; 3],
    /// The root of its trace.
    deviation: f64,
    /// Of the ellipsoid that holds 95 %.
    half_axes: [f64; 3],
    directions: [[f64; 3]; 3],
    departure: f64,
    linear: bool,
}

const WORDS: &str = "three kinds of error that are never added up; displacements of targets in mm, forces on the tube in N; null: not known";
const ALGEBRAIC: &str = "what the search left over. by_residual: no signs of the free forces move the target farther, to first order; by_going_on: what a hundredth of all tolerances changed, contact too";
const MESH: &str =
    "an estimate, no bound: factor times the change to cubes half as large; below order 1 it would be too small";
const MODEL: &str = "a linearisation: independent numbers, each moved by its standard deviation up and down (young: of its logarithm) and the state found again; departure is how far the mean of the two is from the state, linear is false where it is above a quarter of the deviation and above the algebraic error";
const NOT_VARIED: &str = "the forms of the laws, where and how far attachments hold, the label map and its smoothing, the tube's way, and what not_modelled names";

/// What is said of errors.
pub(in super::super) fn record<'a>(said: &'a Said, model: &'a Model) -> ErrorsRecord<'a> {
    match said {
        Said::NotAsked => ErrorsRecord::Words("not asked for".to_owned()),
        Said::NotYet => ErrorsRecord::Words("not looked for yet".to_owned()),
        Said::NotKnown(why) => ErrorsRecord::Words(format!("not known: {why}")),
        Said::Found(errors) => ErrorsRecord::Found(Box::new(parts(errors, model))),
    }
}

fn parts<'a>(errors: &'a Errors, model: &'a Model) -> Parts<'a> {
    fn known<A, B>(found: &Result<A, String>, record: impl FnOnce(&A) -> B) -> Known<B> {
        match found {
            Ok(found) => Known::Known(record(found)),
            Err(why) => Known::NotKnown { not_known: why.clone() },
        }
    }
    let algebraic = match &errors.algebraic {
        Ok(found) => Known::Known(algebraic(found, model)),
        Err(why) => Known::NotKnown { not_known: why.clone() },
    };
    Parts {
        of: &errors.of,
        words: WORDS,
        algebraic,
        discretisation: known(&errors.finer, |found| mesh(found, model)),
        model: spread(errors, model),
    }
}

fn algebraic<'a>(found: &'a Algebraic, model: &'a Model) -> AlgebraicRecord<'a> {
    let further = found.further.as_ref();
    let targets = model.targets.iter().zip(&found.bounds).enumerate();
    AlgebraicRecord {
        words: ALGEBRAIC,
        largest_free_force: found.residual,
        targets: targets
            .map(|(k, (target, bound))| AlgebraicAt {
                name: &target.name,
                by_residual: *bound,
                by_going_on: further.ok().map(|at| at.targets[k].norm()),
            })
            .collect(),
        force: further.ok().map(|at| at.force.norm()),
        not_known: further.err().map(String::as_str),
    }
}

fn mesh<'a>(found: &Finer, model: &'a Model) -> MeshRecord<'a> {
    let change = |name: Option<&'a str>, by: &Vector3<f64>| ChangeRecord {
        name,
        change: triple(by),
        stated: finite(Finer::stated(by)),
    };
    let targets = model.targets.iter().zip(&found.by.targets);
    let jumps = model.bodies.iter().zip(&found.worst).map(|(body, worst)| JumpsRecord {
        organ: &body.name,
        cubes: worst.map(|w| w.of),
        cubes_with_half: worst.map(|w| w.cubes),
        worst_at: worst.map(|w| triple(&w.at)),
    });
    MeshRecord {
        words: MESH,
        factor: SAFETY,
        unknowns: found.unknowns,
        unsettled: found.left,
        targets: targets.map(|(target, by)| change(Some(&target.name), by)).collect(),
        force: change(None, &found.by.force),
        reach: REACH,
        near: found.stated.and_then(|s| finite(s.near)),
        elsewhere: found.stated.and_then(|s| finite(s.elsewhere)),
        jumps: jumps.collect(),
    }
}

fn spread<'a>(errors: &'a Errors, model: &'a Model) -> ModelRecord<'a> {
    let found: &Moved = &errors.model;
    let targets = model.targets.iter().zip(&found.targets).enumerate();
    ModelRecord {
        words: MODEL,
        not_varied: NOT_VARIED,
        taken_as_exact: &found.exact,
        parameters: found.parameters.iter().map(|p| parameter(p, model)).collect(),
        targets: targets
            .map(|(k, (target, spread))| {
                let noise = errors.left_over(Some(k)).unwrap_or(0.0);
                spread.as_ref().map(|s| ellipsoid(Some(&target.name), s, noise))
            })
            .collect(),
        force: found
            .force
            .as_ref()
            .map(|s| ellipsoid(None, s, errors.left_over(None).unwrap_or(0.0))),
        force_size_deviation: found.force_size,
        not_known: found.not_known(),
    }
}

fn parameter<'a>(found: &'a Parameter, model: &'a Model) -> ParameterRecord<'a> {
    let shift = |name: Option<&'a str>, shift: Option<simulation::space::error::Shift>| {
        shift.map(|shift| ShiftRecord {
            name,
            by: triple(&shift.half()),
            departure: shift.departure(),
        })
    };
    let targets = model.targets.iter().enumerate();
    ParameterRecord {
        key: &found.of.key,
        name: &found.of.name,
        value: found.of.value,
        moved_to: found.of.moved,
        targets: targets
            .map(|(k, target)| shift(Some(&target.name), found.shift(|at| at.targets[k])))
            .collect(),
        force: shift(None, found.shift(|at| at.force)),
    }
}

fn ellipsoid<'a>(name: Option<&'a str>, spread: &Spread, noise: f64) -> SpreadRecord<'a> {
    let axes = spread.ellipsoid();
    let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|r| [0, 1, 2].map(|c| m[(r, c)]));
    SpreadRecord {
        name,
        covariance: rows(&spread.covariance),
        deviation: spread.deviation(),
        half_axes: axes.map(|a| a.0),
        directions: axes.map(|a| triple(&a.1)),
        departure: spread.departure,
        linear: spread.is_linear(noise),
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
