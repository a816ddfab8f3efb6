//! `result.json`: what was modelled, every state with its certificate, and why a run ended early.

use nalgebra::Vector2;
use serde::Serialize;
use simulation::equilibrium::Equilibrium;

use crate::model::{Maker, Model};
use crate::run::{Measures, Run, State};
use crate::scene::raw::RawScene;

/// Names the format.
const FORMAT: &str = "trocar-simulation";
const VERSION: u32 = 2;

/// The whole file.
#[derive(Debug, Serialize)]
pub(crate) struct Report<'a> {
    format: &'static str,
    version: u32,
    title: &'a str,
    /// Forces are of a unit of depth: stress times length.
    units: [&'a str; 2],
    unknowns: usize,
    free_unknowns: usize,
    solids: Vec<SolidRecord<'a>>,
    separated: Vec<SeparatedRecord<'a>>,
    states: Vec<StateRecord<'a>>,
    /// True where the certificate of every equilibrium holds, and the run came to its end.
    certified: bool,
    /// Why the run ended early; absent after a whole run.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<&'a str>,
    pictures: &'a [String],
}

#[derive(Debug, Serialize)]
struct SolidRecord<'a> {
    name: &'a str,
    kind: &'a str,
    parameters: usize,
}

#[derive(Debug, Serialize)]
struct SeparatedRecord<'a> {
    solid: &'a str,
    from: &'a str,
    depth: f64,
}

#[derive(Debug, Serialize)]
struct StateRecord<'a> {
    label: &'a str,
    /// Absent where no equilibrium was looked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    certificate: Option<Certificate>,
    steps: usize,
    milliseconds: f64,
    walls: Vec<WallRecord<'a>>,
    on_solids: Vec<OnSolid<'a>>,
    instruments: Vec<Instrument<'a>>,
    contacts: Vec<ContactRecord<'a>>,
    moved: Vec<MovedRecord<'a>>,
}

#[derive(Debug, Serialize)]
struct Certificate {
    /// True where every criterion holds.
    holds: bool,
    /// The criteria that do not, with numbers.
    fails: Vec<String>,
    /// `minimum`, or `saddle`.
    verdict: &'static str,
    /// Contact is exact; else it is that of barriers.
    exact: bool,
    energy: f64,
    /// The largest free force beside the largest load or reaction.
    free_force: f64,
    /// The largest load or reaction.
    load: f64,
    /// The least signed distance of true arcs to what they keep out of, a length; absent without contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    least_gap: Option<f64>,
    /// The largest force times gap beside the largest load times the largest solid.
    complementarity: f64,
    /// The last change of a constraint's force beside the largest load.
    force_change: f64,
    /// The largest violation of a constraint beside the largest solid.
    violation: f64,
    /// The largest of `on_solids[..].balance`.
    force_balance: f64,
    least_determinant: f64,
    /// Directions in which the energy falls: 0 at a minimum.
    falling: usize,
    /// Directions that leave it as it is.
    neutral: usize,
    searches: usize,
    evaluations: usize,
    factorisations: usize,
    projected: usize,
}

#[derive(Debug, Serialize)]
struct WallRecord<'a> {
    name: &'a str,
    offset: f64,
    force: [f64; 2],
}

#[derive(Debug, Serialize)]
struct OnSolid<'a> {
    name: &'a str,
    /// True for an instrument: this is what it feels.
    driven: bool,
    force: [f64; 2],
    balance: f64,
}

/// What an instrument feels.
#[derive(Debug, Serialize)]
struct Instrument<'a> {
    name: &'a str,
    force: [f64; 2],
    /// Of its contacts about `about`, counter-clockwise, force times length.
    moment: f64,
    /// The mean of its boundary's nodes, about which it is turned.
    about: [f64; 2],
}

#[derive(Debug, Serialize)]
struct ContactRecord<'a> {
    by: &'a str,
    on: &'a str,
    point: [f64; 2],
    force: [f64; 2],
    gap: f64,
}

#[derive(Debug, Serialize)]
struct MovedRecord<'a> {
    name: &'a str,
    asked: f64,
    part: f64,
    parts: usize,
}

fn pair(v: Vector2<f64>) -> [f64; 2] {
    [v.x, v.y]
}

impl<'a> Report<'a> {
    pub(crate) fn new(scene: &'a RawScene, model: &'a Model, run: &'a Run, pictures: &'a [String]) -> Self {
        let bodies = &model.system.bodies;
        let solid = |(k, s): (usize, &'a crate::model::Named)| SolidRecord {
            name: &s.name,
            kind: &s.kind,
            parameters: bodies.solid(k).parameters(),
        };
        let separated = model.separated.iter().map(|s| SeparatedRecord {
            solid: &s.solid,
            from: &s.from,
            depth: s.depth,
        });
        Self {
            format: FORMAT,
            version: VERSION,
            title: &scene.title,
            units: [&scene.units.length, &scene.units.stress],
            unknowns: bodies.size(),
            free_unknowns: model.free(),
            solids: model.solids.iter().enumerate().map(solid).collect(),
            separated: separated.collect(),
            states: run.states.iter().map(|s| record(model, s)).collect(),
            certified: run.refused.is_none() && run.uncertified().is_empty(),
            refused: run.refused.as_deref(),
            pictures,
        }
    }
}

fn record<'a>(model: &'a Model, state: &'a State) -> StateRecord<'a> {
    let walls = model.walls.iter().zip(&state.walls).enumerate();
    let on = model.solids.iter().enumerate().filter(|_| state.found.is_some());
    let certified = state.measures.as_ref().zip(state.found.as_ref());
    StateRecord {
        label: &state.label,
        certificate: certified.map(|(measures, found)| certificate(measures, found)),
        steps: state.iterations,
        milliseconds: state.milliseconds,
        walls: walls
            .map(|(k, (wall, offset))| WallRecord {
                name: &wall.name,
                offset: *offset,
                force: pair(state.force_on_wall(k)),
            })
            .collect(),
        on_solids: on
            .map(|(k, solid)| OnSolid {
                name: &solid.name,
                driven: solid.driven,
                force: pair(state.force_on(k)),
                balance: state.balance[k],
            })
            .collect(),
        instruments: instruments(model, state),
        contacts: state.contacts.iter().map(|c| contact(model, c)).collect(),
        moved: state
            .moved
            .iter()
            .map(|m| MovedRecord {
                name: &m.name,
                asked: m.asked,
                part: m.part,
                parts: m.parts,
            })
            .collect(),
    }
}

fn instruments<'a>(model: &'a Model, state: &State) -> Vec<Instrument<'a>> {
    let driven = model
        .solids
        .iter()
        .enumerate()
        .filter(|(_, s)| s.driven && state.found.is_some());
    let one = |(k, solid): (usize, &'a crate::model::Named)| {
        let about = model.centre(k, &state.a);
        Instrument {
            name: &solid.name,
            force: pair(state.force_on(k)),
            moment: state.moment_on(k, about),
            about: pair(about),
        }
    };
    driven.map(one).collect()
}

fn contact<'a>(model: &'a Model, contact: &crate::run::Contact) -> ContactRecord<'a> {
    ContactRecord {
        by: match contact.maker {
            Maker::Wall(k) => &model.walls[k].name,
            Maker::Link(_) => "link",
            Maker::Touch => "solid",
            Maker::Given => "force",
        },
        on: &model.solids[contact.solid].name,
        point: pair(contact.point),
        force: pair(contact.force),
        gap: contact.gap,
    }
}

fn certificate(measures: &Measures, found: &Equilibrium) -> Certificate {
    let minimum = &found.minimum;
    let fails = measures.fails();
    Certificate {
        holds: fails.is_empty(),
        fails,
        verdict: measures.verdict(),
        exact: measures.exact,
        energy: minimum.energy,
        free_force: measures.free_force,
        load: minimum.load,
        least_gap: measures.gap(),
        complementarity: measures.complementarity,
        force_change: measures.force_change,
        violation: measures.violation,
        force_balance: measures.force_balance,
        least_determinant: measures.least_determinant,
        falling: measures.falling,
        neutral: measures.neutral,
        searches: found.searches,
        evaluations: minimum.evaluations,
        factorisations: minimum.factorisations,
        projected: minimum.projected,
    }
}
