//! The model that a scene describes: solids, walls, links, forces and contact, and the state they start in.

mod attach;
mod force;
mod intrusion;
mod material;
mod separate;
mod shape;
mod solid;
mod start;
mod steps;
mod terms;
#[cfg(test)]
mod tests;

use nalgebra::Vector2;
use simulation::constraint::Link;
use simulation::system::System;

use crate::scene::raw::{RawLaw, RawOverlaps, RawScene, RawWalls};
use crate::scene::{Checked, finite, invalid, named, names, pair, positive, short_name, title, within};
use force::Lever;
pub(crate) use separate::Separated;
pub(crate) use steps::{Move, Moving, Step};
pub(crate) use terms::Maker;

/// The most of each table.
const MOST_SOLIDS: usize = 200;
const MOST_WALLS: usize = 32;
const MOST_ATTACHED: usize = 1000;
const MOST_PAIRS: usize = 1000;

/// The most numbers of all states of a run together: they are kept until the pictures are drawn.
const MOST_KEPT: usize = 50_000_000;

/// What a picture and a report say of a solid.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub(crate) name: String,
    /// In words.
    pub(crate) kind: String,
    /// It moves by the steps alone.
    pub(crate) driven: bool,
    /// Some of its nodes are held, or all.
    pub(crate) held: bool,
}

/// A half-plane `<x, normal> <= offset` that solids keep out of.
#[derive(Debug, Clone)]
pub(crate) struct Wall {
    pub(crate) name: String,
    /// Of length 1.
    pub(crate) normal: Vector2<f64>,
    pub(crate) offset: f64,
    /// The solids that it keeps out.
    pub(crate) keeps: Vec<usize>,
}

/// Contact of solids with solids.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    /// Distances over which solids push one another, at first and at last.
    pub(crate) widths: [f64; 2],
    /// Units of stress.
    pub(crate) stiffness: f64,
    pub(crate) overlaps: RawOverlaps,
}

/// What a scene describes.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) system: System,
    pub(crate) solids: Vec<Named>,
    pub(crate) walls: Vec<Wall>,
    pub(crate) links: Vec<Link>,
    pub(crate) levers: Vec<Lever>,
    pub(crate) touch: Option<Touch>,
    /// The pairs of solids that keep apart; `None`: every two.
    pub(crate) pairs: Option<Vec<[usize; 2]>>,
    pub(crate) how: RawWalls,
    pub(crate) steps: Vec<Step>,
    /// The law of some solid lets it be turned inside out.
    pub(crate) inverts: bool,
    /// The state it starts in.
    pub(crate) start: Vec<f64>,
    /// Force by length: the scale of what holds solids.
    pub(crate) stiffness: f64,
    /// The state that the scene gives, before anything was moved apart.
    pub(crate) placed: Vec<f64>,
    /// What had to be moved apart at the start.
    pub(crate) separated: Vec<Separated>,
}

impl Model {
    /// Makes the model of a scene.
    ///
    /// # Errors
    /// [`::scene::Invalid`] with the key of the first value that cannot be used.
    pub(crate) fn new(scene: &RawScene) -> Checked<Self> {
        title(&scene.title)?;
        short_name("units.length", &scene.units.length)?;
        short_name("units.stress", &scene.units.stress)?;
        within("solids", scene.solids.len(), 1..=MOST_SOLIDS)?;
        within("walls", scene.walls.len(), 0..=MOST_WALLS)?;
        within("links", scene.links.len(), 0..=MOST_ATTACHED)?;
        within("forces", scene.forces.len(), 0..=MOST_ATTACHED)?;
        within("search.most_steps", scene.search.most_steps, 1..=100_000)?;
        if let Some(watch) = scene.search.watch {
            within("search.watch", watch, 1..=100_000)?;
        }
        names("solids", scene.solids.iter().map(|s| s.name.as_str()))?;
        names("walls", scene.walls.iter().map(|w| w.name.as_str()))?;
        let materials = material::materials(&scene.materials)?;
        let mut system = System::new();
        let mut start = Vec::new();
        let solids = solid::solids(scene, &materials, &mut system, &mut start)?;
        let walls = walls(scene, &solids)?;
        let stiffness = stiffness(&system);
        let touch = scene.contact.as_ref().map(|raw| touch(raw, &system, stiffness));
        let mut model = Self {
            links: attach::links(scene, &system, stiffness)?,
            levers: attach::forces(scene, &mut system)?,
            touch: touch.transpose()?,
            pairs: pairs(scene, &solids)?,
            steps: steps::steps(scene, &solids, &walls)?,
            how: scene.search.walls,
            inverts: inverts(scene),
            solids,
            walls,
            system,
            placed: start.clone(),
            start,
            stiffness,
            separated: Vec::new(),
        };
        kept(&model)?;
        model.separate(scene.search.settle)?;
        Ok(model)
    }

    /// True where two solids keep apart.
    pub(crate) fn meets(&self, first: usize, second: usize) -> bool {
        let named = |pairs: &Vec<[usize; 2]>| pairs.contains(&[first, second]) || pairs.contains(&[second, first]);
        self.touch.is_some() && self.pairs.as_ref().map_or(first != second, named)
    }

    /// The mean of the nodes of a boundary, about which an instrument is turned.
    pub(crate) fn centre(&self, body: usize, a: &[f64]) -> Vector2<f64> {
        let bodies = &self.system.bodies;
        let nodes = &bodies.solid(body).boundary().nodes;
        nodes.iter().map(|n| bodies.point(body, *n, a)).sum::<Vector2<f64>>() / nodes.len() as f64
    }

    /// Unknowns that may change.
    pub(crate) fn free(&self) -> usize {
        self.system.fixed.iter().filter(|fixed| !**fixed).count()
    }
}

/// True where a law in use has an energy for what is turned inside out.
fn inverts(scene: &RawScene) -> bool {
    let used = |name: &str| scene.solids.iter().any(|s| s.material.as_deref() == Some(name));
    let forbids = |law: RawLaw| matches!(law, RawLaw::NeoHookean | RawLaw::Ogden);
    scene.materials.iter().any(|m| used(&m.name) && !forbids(m.law))
}

/// The states of all frames fit into memory.
fn kept(model: &Model) -> Checked<()> {
    let frames: usize = model.steps.iter().map(|s| s.frames).sum();
    let numbers = frames.saturating_mul(model.system.bodies.size());
    let good = numbers <= MOST_KEPT;
    let found = || format!("{frames} frames of {} unknowns", model.system.bodies.size());
    good.then_some(()).ok_or_else(|| {
        invalid(
            "steps",
            found(),
            format!("at most {MOST_KEPT} numbers in all states together"),
        )
    })
}

/// The largest stiffness of a solid; without one, so much that the weight of all dents it by a tenth of the size.
fn stiffness(system: &System) -> f64 {
    let elastic = system.bodies.stiffness_scale();
    if elastic > 0.0 {
        return elastic;
    }
    let weight = |body: usize| {
        let solid = system.bodies.solid(body);
        let mut forces = vec![0.0; solid.parameters()];
        solid.weight(&mut forces);
        forces.iter().map(|f| f.abs()).sum::<f64>()
    };
    let total: f64 = (0..system.bodies.len()).map(weight).sum();
    let scale = 10.0 * total / system.bodies.extent();
    if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
}

fn walls(scene: &RawScene, solids: &[Named]) -> Checked<Vec<Wall>> {
    let wall = |(k, raw): (usize, &crate::scene::raw::RawWall)| {
        let key = |last: &str| format!("walls.{k}.{last}");
        let normal = pair(&key("normal"), raw.normal)?;
        let normal = normal
            .try_normalize(0.0)
            .ok_or_else(|| invalid(key("normal"), "[0, 0]", "a direction: the side that solids are on"))?;
        let free = || (0..solids.len()).filter(|s| !solids[*s].driven).collect();
        let all = |list: &Vec<String>| -> Checked<Vec<usize>> {
            let one = |(i, name): (usize, &String)| {
                named(
                    &format!("walls.{k}.keeps.{i}"),
                    name,
                    solids.iter().map(|s| s.name.as_str()),
                )
            };
            list.iter().enumerate().map(one).collect()
        };
        Ok(Wall {
            name: raw.name.clone(),
            normal,
            offset: finite(&key("offset"), raw.offset)?,
            keeps: raw.keeps.as_ref().map_or_else(|| Ok(free()), all)?,
        })
    };
    scene.walls.iter().enumerate().map(wall).collect()
}

/// The pairs that `[contact]` names.
fn pairs(scene: &RawScene, solids: &[Named]) -> Checked<Option<Vec<[usize; 2]>>> {
    let Some(all) = scene.contact.as_ref().and_then(|raw| raw.pairs.as_ref()) else {
        return Ok(None);
    };
    within("contact.pairs", all.len(), 1..=MOST_PAIRS)?;
    let solid = |key: String, name: &str| named(&key, name, solids.iter().map(|s| s.name.as_str()));
    let pair = |(k, names): (usize, &[String; 2])| -> Checked<[usize; 2]> {
        Ok([
            solid(format!("contact.pairs.{k}.0"), &names[0])?,
            solid(format!("contact.pairs.{k}.1"), &names[1])?,
        ])
    };
    all.iter().enumerate().map(pair).collect::<Checked<_>>().map(Some)
}

fn touch(raw: &crate::scene::raw::RawContact, system: &System, stiffness: f64) -> Checked<Touch> {
    let extent = system.bodies.extent();
    let widths = raw.widths.unwrap_or([1e-2 * extent, 1e-3 * extent]);
    positive("contact.widths.0", widths[0])?;
    positive("contact.widths.1", widths[1])?;
    if widths[1] > widths[0] || widths[0] > extent {
        let found = format!("[{}, {}]", widths[0], widths[1]);
        let allowed = format!("the first, then a smaller one; at most {extent}, the size of the largest solid");
        return Err(invalid("contact.widths", found, allowed));
    }
    Ok(Touch {
        widths,
        stiffness: positive("contact.stiffness", raw.stiffness.unwrap_or(0.1 * stiffness))?,
        overlaps: raw.overlaps,
    })
}
