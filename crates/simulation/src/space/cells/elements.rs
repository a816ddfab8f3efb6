//! Elements of a mesh: whole cubes of one size share a table, all others have their own.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::fill::Filled;
use super::mesh::Mesh;
use super::parts::Element;
use super::settings::NoMesh;
use crate::space::element::{Point, Table};

/// Elements with their tables: one for each well-filled cube and the nearly empty ones that belong to it, whose dilatations
/// are functions of all of them, as a cube without free nodes of its own cannot answer to one of its own.
pub(super) fn elements(mesh: &Mesh, filled: &[Filled]) -> Result<(Vec<Element>, Vec<Table>), NoMesh> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, root) in mesh.ties.root.iter().enumerate() {
        groups.entry(*root).or_default().push(k);
    }
    let (mut elements, mut tables) = (Vec::new(), Vec::new());
    // A whole cube's table knows its side only, not its place.
    let mut shared: BTreeMap<i32, u32> = BTreeMap::new();
    for (root, members) in groups {
        let cell = mesh.cells[root];
        let refused = |why: String| NoMesh::Element {
            at: mesh.grid.place(cell.corner.map(|x| x + cell.span / 2)).into(),
            why,
        };
        // With nearly empty cubes to care for, or nodes that follow others, it has a table of its own.
        let regular = members.len() == 1 && filled[root].whole;
        let (nodes, known) = match regular.then(|| free_nodes(mesh, root)).flatten() {
            Some(nodes) => (nodes, shared.get(&cell.span).copied()),
            None => (nodes(mesh, &members), None),
        };
        let is_shared = regular && free_nodes(mesh, root).is_some();
        let table = match known {
            Some(table) => table,
            None => {
                let points = points(mesh, &members, filled, &nodes);
                let table = Table::new(nodes.len(), &points, mesh.dilatation()).map_err(|e| refused(e.to_string()))?;
                tables.push(table);
                tables.len() as u32 - 1
            }
        };
        if is_shared {
            shared.insert(cell.span, table);
        }
        elements.push(Element { nodes, table });
    }
    Ok((elements, tables))
}

/// The nodes of a cube all of which are free.
fn free_nodes(mesh: &Mesh, cell: usize) -> Option<Vec<u32>> {
    let one = |node: &u32| match mesh.ties.ties[*node as usize].as_slice() {
        [(free, weight)] if *weight == 1.0 => Some(*free),
        _ => None,
    };
    mesh.ties.of_cell[cell].iter().map(one).collect()
}

/// Free nodes of a group of cubes.
fn nodes(mesh: &Mesh, members: &[usize]) -> Vec<u32> {
    let ties = |k: &usize| mesh.ties.of_cell[*k].iter().flat_map(|n| &mesh.ties.ties[*n as usize]);
    let mut nodes: Vec<u32> = members.iter().flat_map(ties).map(|(free, _)| *free).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Points of a group of cubes.
fn points(mesh: &Mesh, members: &[usize], filled: &[Filled], nodes: &[u32]) -> Vec<Point> {
    // In the order of `nodes`, which for a shared table is that of the cube.
    let place: BTreeMap<u32, usize> = nodes.iter().enumerate().map(|(k, n)| (*n, k)).collect();
    let inside = members.iter().flat_map(|k| &mesh.points()[filled[*k].points.clone()]);
    inside
        .map(|inside| {
            let mut slopes = vec![Vector3::zeros(); nodes.len()];
            for (node, slope) in mesh.slopes(inside) {
                if let Some(k) = place.get(&node) {
                    slopes[*k] = slope;
                }
            }
            Point {
                weight: inside.volume,
                at: inside.at,
                slopes,
            }
        })
        .collect()
}
