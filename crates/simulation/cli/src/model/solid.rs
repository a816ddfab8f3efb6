//! Solids of a scene, each with its place at the start.

use nalgebra::Vector2;
use simulation::law::Material;
use simulation::q9::Mesh;
use simulation::solid::{BadPolygon, Deformable, Global, Rigid};
use simulation::system::System;

use super::material::Form;
use super::shape::{Shape, shape};
use super::{Named, start};
use crate::scene::raw::{RawScene, RawSolid};
use crate::scene::{Checked, invalid, named, pair};

/// The most unknowns of a scene.
const MOST_UNKNOWNS: usize = 200_000;

/// Adds all solids to the system, and the parameters they start with to `all`.
pub(super) fn solids(scene: &RawScene, forms: &[Form], system: &mut System, all: &mut Vec<f64>) -> Checked<Vec<Named>> {
    let mut list = Vec::with_capacity(scene.solids.len());
    for (k, raw) in scene.solids.iter().enumerate() {
        let weight = pair(&format!("solids.{k}.weight"), raw.weight)?;
        let (body, kind) = match shape(k, raw)? {
            Shape::Polygon(vertices) => (
                rigid(k, raw, &vertices, weight, system, all)?,
                "rigid polygon".to_owned(),
            ),
            Shape::Mesh(mesh) => {
                let form = form(k, raw, forms)?;
                elastic(k, raw, mesh, form, weight, system, all)?
            }
        };
        if system.bodies.size() > MOST_UNKNOWNS {
            let found = format!("{} unknowns up to solid {:?}", system.bodies.size(), raw.name);
            return Err(invalid(
                format!("solids.{k}"),
                found,
                format!("at most {MOST_UNKNOWNS} in a scene"),
            ));
        }
        let held = hold(k, raw, system, body)?;
        list.push(Named {
            name: raw.name.clone(),
            kind,
            driven: raw.driven,
            held,
        });
    }
    Ok(list)
}

fn form<'a>(k: usize, raw: &RawSolid, forms: &'a [Form]) -> Checked<&'a Form> {
    let key = format!("solids.{k}.material");
    let Some(name) = &raw.material else {
        let found = format!("nothing for solid {:?}", raw.name);
        return Err(invalid(
            key,
            found,
            "the name of one of the materials: a mesh is elastic",
        ));
    };
    named(&key, name, forms.iter().map(|f| f.name.as_str())).map(|i| &forms[i])
}

fn rigid(
    k: usize,
    raw: &RawSolid,
    vertices: &[Vector2<f64>],
    weight: Vector2<f64>,
    system: &mut System,
    all: &mut Vec<f64>,
) -> Checked<usize> {
    for (key, there) in [
        ("material", raw.material.is_some()),
        ("global", raw.global.is_some()),
        ("held", raw.held.is_some()),
    ] {
        if there {
            let found = format!("a value for solid {:?}, a polygon", raw.name);
            return Err(invalid(
                format!("solids.{k}.{key}"),
                found,
                "no such key: polygons are rigid",
            ));
        }
    }
    let solid = Rigid::new(vertices, weight).map_err(|refused| {
        let place = match &refused {
            BadPolygon::NotFinite { vertex, .. } | BadPolygon::Repeated { vertex, .. } => format!(".{vertex}"),
            BadPolygon::Crossing { second, .. } => format!(".{second}"),
            _ => String::new(),
        };
        let found = format!("solid {:?}: {refused}", raw.name);
        let allowed = "vertices counter-clockwise whose sides do not cross or touch";
        invalid(format!("solids.{k}.polygon.vertices{place}"), found, allowed)
    })?;
    all.extend(start::polygon(k, raw, &solid)?);
    Ok(system.add(solid))
}

fn elastic(
    k: usize,
    raw: &RawSolid,
    mesh: Mesh,
    form: &Form,
    weight: Vector2<f64>,
    system: &mut System,
    all: &mut Vec<f64>,
) -> Checked<(usize, String)> {
    let mesh = if form.mixed { mesh.mixed() } else { mesh };
    let elements = mesh.elements.len();
    if raw.global.is_some() {
        let solid = global(k, raw, mesh, form.material, weight)?;
        all.extend(start::block(k, raw, &solid)?);
        return Ok((
            system.add(solid),
            format!("{elements} elements in a block of nine nodes"),
        ));
    }
    let solid = Deformable::new(mesh, form.material, weight)
        .map_err(|refused| invalid(format!("solids.{k}.material"), refused, "a material with mixed = true"))?;
    all.extend(start::mesh(k, raw, &solid)?);
    Ok((system.add(solid), format!("mesh of {elements} elements")))
}

fn global(k: usize, raw: &RawSolid, mesh: Mesh, material: Material, weight: Vector2<f64>) -> Checked<Global> {
    let key = format!("solids.{k}.global");
    let block = raw.global.map(|b| [b.low, b.high]).unwrap_or_default();
    let corners = [
        pair(&format!("{key}.low"), block[0])?,
        pair(&format!("{key}.high"), block[1])?,
    ];
    Global::new(mesh, material, weight, corners).map_err(|refused| {
        invalid(
            key,
            format!("solid {:?}: {refused}", raw.name),
            "a block round the whole solid",
        )
    })
}

/// Holds the nodes in the box, or all of a driven solid; true where anything is held.
fn hold(k: usize, raw: &RawSolid, system: &mut System, body: usize) -> Checked<bool> {
    let (first, solid) = (system.bodies.offset(body), system.bodies.solid(body));
    let count = solid.parameters();
    if raw.driven {
        system.fixed[first..first + count].fill(true);
    }
    let Some(region) = raw.held else {
        return Ok(raw.driven);
    };
    let key = format!("solids.{k}.held");
    let (low, high) = (
        pair(&format!("{key}.low"), region.low)?,
        pair(&format!("{key}.high"), region.high)?,
    );
    if raw.global.is_some() {
        let allowed = "no such key: no node of a solid in a block has unknowns of its own; use links";
        return Err(invalid(
            key,
            format!("a box for solid {:?}, in a block", raw.name),
            allowed,
        ));
    }
    // Slack for nodes that lie on the box's sides but for rounding.
    let slack = 1e-9 * solid.boundary().extent();
    let inside = |p: Vector2<f64>| (p - low).min() >= -slack && (high - p).min() >= -slack;
    let rest = vec![0.0; count];
    let nodes: Vec<usize> = (0..count / 2).filter(|n| inside(solid.point(&rest, *n))).collect();
    if nodes.is_empty() {
        let found = format!("a box without a node of solid {:?}", raw.name);
        return Err(invalid(
            key,
            found,
            "a box round some of its nodes, in the reference configuration",
        ));
    }
    system.clamp(body, &nodes);
    Ok(true)
}
