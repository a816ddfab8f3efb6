//! Points of surfaces that may touch a tube or bone, as functions of the unknowns of the nodes that move them.

use std::ops::Range;

use nalgebra::Vector3;

use super::around::Around;
use super::norm;
use super::settings::NoFrames;
use crate::space::system::System;
use crate::space::term::ObstacleContact;
use crate::space::tube::Distance;

/// A point: its solid and number there, its place, area and half of the way to the next in the reference configuration, where its nodes begin, what it may touch, and
/// the pressure there at the start.
#[derive(Debug, Clone, Copy)]
struct Touch {
    body: usize,
    point: usize,
    at: Vector3<f64>,
    area: f64,
    gap: f64,
    first: usize,
    with: usize,
    pressure: f64,
}

/// Whether any unknown of the nodes that move a point is free: contact moves no others, and no pressure on them ends.
pub(super) fn is_moved(system: &System, body: usize, point: usize) -> bool {
    let (solid, offset) = (system.bodies.solid(body), system.bodies.offset(body));
    let free = |node: &u32| {
        system.fixed[offset + 3 * *node as usize..][..3]
            .iter()
            .any(|fixed| !fixed)
    };
    let row = solid.combination(point);
    row.is_none_or(|row| row.iter().any(|(node, weight)| *weight != 0.0 && free(node)))
}

/// Points and the nodes that move them: `at + sum of weights times displacements`.
#[derive(Debug, Clone, Default)]
pub(super) struct Touches {
    /// The first unknown of each node; those after it are the next two.
    nodes: Vec<usize>,
    /// 1, or 0 where it is held, of each unknown of the nodes.
    free: Vec<f64>,
    points: Vec<Touch>,
    /// Number of a node among the nodes, and its weight.
    rows: Vec<(u32, f64)>,
    /// Of each solid of the system, which of the nodes' unknowns are its own.
    parts: Vec<Range<usize>>,
}

impl Touches {
    /// Points of some solids for which `wanted(solid, reference place, normal)` holds, which may touch the tube, and those of contacts with bones: of
    /// both those that move.
    pub(super) fn new(
        system: &System,
        pressed: &[usize],
        wanted: impl Fn(usize, &Vector3<f64>, &Vector3<f64>) -> bool,
        bones: &[ObstacleContact],
    ) -> Result<Self, NoFrames> {
        let mut found = Self::default();
        // Nodes by their first unknown among all, until all are known.
        let mut global = Vec::new();
        for body in pressed {
            let solid = system.bodies.solid(*body);
            let all = (0..solid.points()).filter(|point| {
                let (at, normal, _) = solid.reference(*point);
                wanted(*body, &at, &normal) && is_moved(system, *body, *point)
            });
            for point in all {
                found.add_point(system, [*body, point, 0], 0.0, &mut global)?;
            }
        }
        if found.points.is_empty() {
            let body = pressed.first().copied().unwrap_or(0);
            return Err(NoFrames::NoPoint { body });
        }
        for (number, bone) in bones.iter().enumerate() {
            for (point, pressure) in bone.points().filter(|(p, _)| is_moved(system, bone.body(), *p)) {
                found.add_point(system, [bone.body(), point, number + 1], pressure, &mut global)?;
            }
        }
        found.nodes = global.iter().map(|(node, _)| *node).collect();
        found.nodes.sort_unstable();
        found.nodes.dedup();
        let number = |node: &usize| found.nodes.partition_point(|n| n < node) as u32;
        found.rows = global.iter().map(|(node, weight)| (number(node), *weight)).collect();
        let each = found.nodes.iter().flat_map(|n| *n..n + 3);
        found.free = each.map(|i| if system.fixed[i] { 0.0 } else { 1.0 }).collect();
        // Ascending, so that those of a solid lie together.
        let before = |unknown: usize| 3 * found.nodes.partition_point(|n| *n < unknown);
        let ends = (0..system.bodies.len()).map(|body| {
            let next = body + 1;
            let end = if next < system.bodies.len() {
                system.bodies.offset(next)
            } else {
                system.bodies.size()
            };
            before(system.bodies.offset(body))..before(end)
        });
        found.parts = ends.collect();
        Ok(found)
    }

    fn add_point(
        &mut self,
        system: &System,
        [body, point, with]: [usize; 3],
        pressure: f64,
        global: &mut Vec<(usize, f64)>,
    ) -> Result<(), NoFrames> {
        let (solid, offset) = (system.bodies.solid(body), system.bodies.offset(body));
        let (at, _, area) = solid.reference(point);
        let row = solid.combination(point).ok_or(NoFrames::NotNodal { body, point })?;
        let first = global.len();
        // Weights of zero would name nodes that nothing moves.
        let moving = row.iter().filter(|(_, weight)| *weight != 0.0);
        global.extend(moving.map(|(node, weight)| (offset + 3 * *node as usize, *weight)));
        self.points.push(Touch {
            body,
            point,
            at,
            area,
            gap: solid.gap(point),
            first,
            with,
            pressure,
        });
        Ok(())
    }

    /// How many points.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The pressures that contacts with bones had, as a first guess; none at the tube.
    pub(super) fn pressures(&self) -> Vec<f64> {
        self.points.iter().map(|point| point.pressure).collect()
    }

    /// How many unknowns the nodes have, which vectors here are of.
    pub(super) fn unknowns(&self) -> usize {
        3 * self.nodes.len()
    }

    /// The length of a vector of these unknowns, of each solid of the system apart.
    pub(super) fn lengths(&self, v: &[f64]) -> Vec<f64> {
        self.parts.iter().map(|part| norm(&v[part.clone()])).collect()
    }

    /// These unknowns among all.
    pub(super) fn take(&self, a: &[f64], v: &mut Vec<f64>) {
        v.clear();
        self.nodes.iter().for_each(|n| v.extend_from_slice(&a[*n..n + 3]));
    }

    /// Adds a vector of these unknowns to one of all.
    pub(super) fn add(&self, v: &[f64], all: &mut [f64]) {
        for (n, v) in self.nodes.iter().zip(v.chunks_exact(3)) {
            all[*n..n + 3].iter_mut().zip(v).for_each(|(a, v)| *a += v);
        }
    }

    /// Half of the way from a point to the next at rest, mm.
    pub(super) fn gap(&self, point: usize) -> f64 {
        self.points[point].gap
    }

    /// How much the surface is stretched at a point at most.
    pub(super) fn stretch(&self, point: usize, system: &System, a: &[f64]) -> f64 {
        let Touch { body, point, .. } = self.points[point];
        system.bodies.solid(body).stretch(system.bodies.part(body, a), point)
    }

    /// Where a point is in the reference configuration.
    pub(super) fn at_rest(&self, point: usize) -> Vector3<f64> {
        self.points[point].at
    }

    /// Area of a point, mm^2.
    pub(super) fn area(&self, point: usize) -> f64 {
        self.points[point].area
    }

    /// The nodes that move points, and their weights.
    pub(super) fn row(&self, point: usize) -> &[(u32, f64)] {
        let end = self.points.get(point + 1).map_or(self.rows.len(), |next| next.first);
        &self.rows[self.points[point].first..end]
    }

    /// Where a point is.
    pub(super) fn at(&self, point: usize, v: &[f64]) -> Vector3<f64> {
        self.points[point].at + self.displacement(point, v)
    }

    /// The unknowns here of the solid that a point is of.
    pub(super) fn part(&self, point: usize) -> std::ops::Range<usize> {
        self.parts[self.points[point].body].clone()
    }

    /// How far a point is moved, by the unknowns of its own solid alone.
    pub(super) fn displacement_in(&self, point: usize, own: &[f64]) -> Vector3<f64> {
        let first = self.part(point).start;
        let mut at = Vector3::zeros();
        for (node, weight) in self.row(point) {
            let begin = 3 * *node as usize - first;
            at += Vector3::from_column_slice(&own[begin..begin + 3]) * *weight;
        }
        at
    }

    /// How far it is moved.
    pub(super) fn displacement(&self, point: usize, v: &[f64]) -> Vector3<f64> {
        let mut at = Vector3::zeros();
        for (node, weight) in self.row(point) {
            let u = &v[3 * *node as usize..3 * *node as usize + 3];
            (0..3).for_each(|k| at[k] += weight * u[k]);
        }
        at
    }

    /// What it may touch, by the number that [`Around`] has for that.
    pub(super) fn with(&self, point: usize) -> usize {
        self.points[point].with
    }

    /// Its distance to that.
    pub(super) fn distance(&self, point: usize, v: &[f64], around: &Around<'_>) -> Distance {
        around.distance(self.with(point), &self.at(point, v))
    }

    /// The same, left out where it is certainly above `most`.
    pub(super) fn within(&self, point: usize, v: &[f64], around: &Around<'_>, most: f64) -> Option<Distance> {
        around.within(self.with(point), &self.at(point, v), most)
    }

    /// Adds forces on some of the points, three each.
    pub(super) fn push_all(&self, points: &[usize], each: &[f64], forces: &mut [f64]) {
        for (point, force) in points.iter().zip(each.chunks_exact(3)) {
            // Most do not press.
            if force.iter().any(|f| *f != 0.0) {
                self.push(*point, &Vector3::from_column_slice(force), forces);
            }
        }
    }

    /// The free unknowns of all that are summed in a component of its place, with their weights.
    pub(super) fn combination(&self, point: usize, component: usize) -> impl Iterator<Item = (u32, f64)> {
        let each = self.row(point).iter().map(move |(node, weight)| {
            let k = 3 * *node as usize + component;
            ((self.nodes[*node as usize] + component) as u32, weight * self.free[k])
        });
        each.filter(|(_, weight)| *weight != 0.0)
    }

    /// Adds a force on a point to those on its free unknowns.
    pub(super) fn push(&self, point: usize, force: &Vector3<f64>, forces: &mut [f64]) {
        for (node, weight) in self.row(point) {
            let first = 3 * *node as usize;
            (0..3).for_each(|k| forces[first + k] += weight * force[k] * self.free[first + k]);
        }
    }
}
