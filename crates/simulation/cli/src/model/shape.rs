//! Shapes of solids, as meshes and polygons, bounded before they are made.

use nalgebra::Vector2;
use simulation::q9::{Mesh, Refused, blob, rectangle, ring};

use crate::scene::raw::RawSolid;
use crate::scene::{Checked, finite, invalid, pair, within};

/// The most elements and vertices of one solid.
const MOST_ELEMENTS: usize = 20_000;
const MOST_VERTICES: usize = 2000;

/// What a solid is made of.
pub(super) enum Shape {
    Mesh(Mesh),
    Polygon(Vec<Vector2<f64>>),
}

/// The one shape of a solid.
pub(super) fn shape(k: usize, raw: &RawSolid) -> Checked<Shape> {
    let given = [
        ("rectangle", raw.rectangle.is_some()),
        ("ring", raw.ring.is_some()),
        ("rounded", raw.rounded.is_some()),
        ("polygon", raw.polygon.is_some()),
        ("mesh", raw.mesh.is_some()),
    ];
    let names: Vec<&str> = given.iter().filter(|g| g.1).map(|g| g.0).collect();
    if names.len() != 1 {
        let found = format!(
            "solid {:?} with {}",
            raw.name,
            if names.is_empty() {
                "no shape".to_owned()
            } else {
                names.join(" and ")
            }
        );
        let allowed = "one of rectangle, ring, rounded, polygon, mesh";
        return Err(invalid(format!("solids.{k}"), found, allowed));
    }
    let key = |last: &str| format!("solids.{k}.{last}");
    if let Some(polygon) = &raw.polygon {
        return self::polygon(k, raw, &polygon.vertices).map(Shape::Polygon);
    }
    generated(k, raw)
        .or_else(|| raw.mesh.as_ref().map(|mesh| explicit(k, raw, mesh)))
        .unwrap_or_else(|| Err(invalid(key("mesh"), "nothing", "a shape")))
        .map(Shape::Mesh)
}

/// The meshes that a rule makes; `None` for another shape.
fn generated(k: usize, raw: &RawSolid) -> Option<Checked<Mesh>> {
    let key = |last: &str| format!("solids.{k}.{last}");
    let refuse = |last: &str, refused: Refused| {
        let found = format!("solid {:?}: {refused}", raw.name);
        invalid(
            key(last),
            found,
            "sizes above 0, at least 1 element each way (3 round a ring)",
        )
    };
    if let Some(r) = &raw.rectangle {
        return Some((|| {
            let elements = elements(&key("rectangle.elements"), r.elements)?;
            let (corner, size) = (
                pair(&key("rectangle.corner"), r.corner)?,
                pair(&key("rectangle.size"), r.size)?,
            );
            rectangle(corner, size, elements).map_err(|e| refuse("rectangle", e))
        })());
    }
    if let Some(r) = &raw.ring {
        return Some((|| {
            let elements = elements(&key("ring.elements"), r.elements)?;
            let centre = pair(&key("ring.centre"), r.centre)?;
            pair(&key("ring.radii"), r.radii)?;
            ring(centre, r.radii, elements).map_err(|e| refuse("ring", e))
        })());
    }
    raw.rounded.as_ref().map(|r| {
        let elements = elements(&key("rounded.elements"), r.elements)?;
        let centre = pair(&key("rounded.centre"), r.centre)?;
        pair(&key("rounded.half_axes"), r.half_axes)?;
        let angle = finite(&key("rounded.turned"), r.turned)?;
        blob(centre, r.half_axes, angle, elements).map_err(|e| refuse("rounded", e))
    })
}

/// Counts of elements, small enough to be made.
fn elements(key: &str, [across, along]: [usize; 2]) -> Checked<[usize; 2]> {
    within(&format!("{key}.0"), across, 1..=MOST_ELEMENTS)?;
    within(&format!("{key}.1"), along, 1..=MOST_ELEMENTS)?;
    let total = across.saturating_mul(along);
    let good = total <= MOST_ELEMENTS;
    let found = || format!("{across} x {along} = {total} elements");
    good.then_some([across, along])
        .ok_or_else(|| invalid(key, found(), format!("at most {MOST_ELEMENTS} in a solid")))
}

fn polygon(k: usize, raw: &RawSolid, vertices: &[[f64; 2]]) -> Checked<Vec<Vector2<f64>>> {
    let key = format!("solids.{k}.polygon.vertices");
    if vertices.len() > MOST_VERTICES {
        let found = format!("solid {:?}: {} vertices", raw.name, vertices.len());
        return Err(invalid(key, found, format!("3 to {MOST_VERTICES}")));
    }
    let point = |(i, v): (usize, &[f64; 2])| pair(&format!("{key}.{i}"), *v);
    vertices.iter().enumerate().map(point).collect()
}

fn explicit(k: usize, raw: &RawSolid, mesh: &crate::scene::raw::RawMesh) -> Checked<Mesh> {
    let key = |last: String| format!("solids.{k}.mesh.{last}");
    within(&key("elements".into()), mesh.elements.len(), 1..=MOST_ELEMENTS)?;
    let node = |(i, x): (usize, &[f64; 2])| pair(&key(format!("nodes.{i}")), *x);
    let nodes = mesh.nodes.iter().enumerate().map(node).collect::<Checked<Vec<_>>>()?;
    Mesh::new(nodes, &mesh.elements).map_err(|refused| {
        let (place, allowed) = match &refused {
            Refused::MissingNode { element, nodes, .. } => (
                format!("elements.{element}"),
                format!("nodes 0 to {}", nodes.saturating_sub(1)),
            ),
            Refused::RepeatedNode { element, .. } => (format!("elements.{element}"), "nine different nodes".into()),
            Refused::Clockwise { element, .. } | Refused::Folded { element, .. } => (
                format!("elements.{element}"),
                "nine nodes row by row, counter-clockwise, middle nodes near the middles".into(),
            ),
            Refused::NotFinite { node, .. } => (format!("nodes.{node}"), "finite numbers".into()),
            Refused::UnusedNode { node } => (format!("nodes.{node}"), "nodes that an element names".into()),
            _ => ("elements".into(), "elements that share whole sides, two at most".into()),
        };
        invalid(key(place), format!("solid {:?}: {refused}", raw.name), allowed)
    })
}
