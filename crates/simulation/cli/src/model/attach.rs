//! What acts on single points: links and forces.

use nalgebra::Vector2;
use simulation::bodies::Bodies;
use simulation::constraint::{End, Link, nearest};
use simulation::solid::Cursor;
use simulation::system::System;

use super::force::Lever;
use crate::scene::raw::{Pair, RawForce, RawLink, RawScene};
use crate::scene::{Checked, invalid, named, pair, positive};

/// A point given for a boundary lies at most this part of the solid's size away from it.
const OFF: f64 = 0.02;
/// Stiffness of the terms that hold exact links, in stiffnesses of the solids: it decides how fast their forces settle.
const HOLD: f64 = 100.0;

/// The point of a solid's boundary next to a point of the reference configuration.
pub(super) fn cursor(key: &str, name: &str, bodies: &Bodies, body: usize, at: Pair) -> Checked<Cursor> {
    let point = pair(key, at)?;
    let boundary = bodies.solid(body).boundary();
    let feet = boundary.reference.iter().map(|arc| nearest(arc, point)).enumerate();
    let best = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
    let far = OFF * boundary.extent();
    match best {
        Some((arc, foot)) if foot.distance <= far => Ok(Cursor { arc, u: foot.u }),
        other => {
            let away = other.map_or(f64::INFINITY, |b| b.1.distance);
            let found = format!(
                "[{}, {}], which is {away} away from the boundary of solid {name:?}",
                at[0], at[1]
            );
            Err(invalid(
                key,
                found,
                format!("a point at most {far} away from it, in the reference configuration"),
            ))
        }
    }
}

fn body(scene: &RawScene, key: &str, name: &str) -> Checked<usize> {
    named(key, name, scene.solids.iter().map(|s| s.name.as_str()))
}

pub(super) fn links(scene: &RawScene, system: &System, stiffness: f64) -> Checked<Vec<Link>> {
    let each = scene.links.iter().enumerate();
    each.map(|(k, raw)| link(scene, system, stiffness, k, raw)).collect()
}

fn link(scene: &RawScene, system: &System, stiffness: f64, k: usize, raw: &RawLink) -> Checked<Link> {
    let key = |last: &str| format!("links.{k}.{last}");
    let on = |name: &str, solid_key: &str, at_key: &str, at: Pair| -> Checked<End> {
        let body = body(scene, &key(solid_key), name)?;
        let cursor = cursor(&key(at_key), name, &system.bodies, body, at)?;
        Ok(End::On { body, cursor })
    };
    let first = on(&raw.solid, "solid", "at", raw.at)?;
    let second = match &raw.to_solid {
        Some(name) => on(name, "to_solid", "to", raw.to)?,
        None => End::Fixed(pair(&key("to"), raw.to)?),
    };
    match raw.spring {
        Some(spring) => Ok(Link::soft([first, second], positive(&key("spring"), spring)?)),
        None => Ok(Link::hard([first, second], HOLD * stiffness)),
    }
}

/// Adds the forces to the system's loads; returns what is left of those on polygons, which turn.
pub(super) fn forces(scene: &RawScene, system: &mut System) -> Checked<Vec<Lever>> {
    let mut levers = Vec::new();
    for (k, raw) in scene.forces.iter().enumerate() {
        levers.extend(force(scene, system, k, raw)?);
    }
    Ok(levers)
}

fn force(scene: &RawScene, system: &mut System, k: usize, raw: &RawForce) -> Checked<Option<Lever>> {
    let body = body(scene, &format!("forces.{k}.solid"), &raw.solid)?;
    let cursor = cursor(&format!("forces.{k}.at"), &raw.solid, &system.bodies, body, raw.at)?;
    let force: Vector2<f64> = pair(&format!("forces.{k}.force"), raw.force)?;
    if scene.solids[body].polygon.is_some() {
        system.load(body, &[(0, force.x), (1, force.y)]);
        return Ok(Some(Lever { body, cursor, force }));
    }
    let solid = system.bodies.solid(body);
    let mut shares = Vec::new();
    cursor.rows(solid, &solid.initial(), &mut |parameter, by, _| {
        shares.push((parameter, by.dot(&force)))
    });
    system.load(body, &shares);
    Ok(None)
}
