//! A mesh: checked nodes and elements, and its boundary.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::mixed::Pressure;
use super::point::map;
use super::{Element, GAUSS, GaussPoint, NODES, Refused, SIDES};

/// A determinant of the reference map below this part of its mean folds the element.
const LEAST_DETERMINANT: f64 = 1e-6;

/// Three nodes of a side of the boundary, the solid on the left.
pub type Arc = [usize; 3];

/// A mesh of nine-node elements in its reference configuration.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Positions of the nodes in the reference configuration.
    pub nodes: Vec<Vector2<f64>>,
    /// The elements.
    pub elements: Vec<Element>,
    /// The sides that belong to one element only: outer contours run counter-clockwise, inner ones clockwise.
    pub boundary: Vec<Arc>,
}

impl Mesh {
    /// A mesh of these nodes, elements given by nine of them each.
    ///
    /// # Errors
    /// Every variant of [`Refused`] but `Shape`: missing, repeated and unused nodes, clockwise and folded elements,
    /// sides that more than two elements share.
    pub fn new(nodes: Vec<Vector2<f64>>, elements: &[[usize; NODES]]) -> Result<Self, Refused> {
        check_nodes(&nodes, elements)?;
        let place = |(k, ids): (usize, &[usize; NODES])| element(&nodes, k, *ids);
        let elements: Vec<Element> = elements.iter().enumerate().map(place).collect::<Result<_, _>>()?;
        let boundary = boundary(&elements)?;
        Ok(Self {
            nodes,
            elements,
            boundary,
        })
    }

    /// The same mesh with the pressures of the mixed form, for Poisson's ratios near 1/2.
    #[must_use]
    pub fn mixed(mut self) -> Self {
        for k in 0..self.elements.len() {
            let at = self.corners(k);
            let element = &mut self.elements[k];
            element.pressure = Pressure::new(&at, &element.points);
        }
        self
    }

    /// True where the elements carry pressures of their own.
    pub fn is_mixed(&self) -> bool {
        self.elements.iter().all(|e| e.pressure.is_some())
    }

    /// Reference positions of the nodes of element `k`.
    pub(crate) fn corners(&self, k: usize) -> [Vector2<f64>; NODES] {
        self.elements[k].nodes.map(|n| self.nodes[n])
    }

    /// Reference area.
    pub fn area(&self) -> f64 {
        let element = |e: &Element| e.points.iter().map(|p| p.weight).sum::<f64>();
        self.elements.iter().map(element).sum()
    }

    /// Nodes whose reference position satisfies `wanted`.
    pub fn nodes_where(&self, wanted: impl Fn(&Vector2<f64>) -> bool) -> Vec<usize> {
        (0..self.nodes.len()).filter(|n| wanted(&self.nodes[*n])).collect()
    }

    /// The forces `(degree of freedom, force)` of a dead load `traction` (per reference length) on the sides of the
    /// boundary all of whose nodes satisfy `wanted`.
    pub fn traction(&self, traction: Vector2<f64>, wanted: impl Fn(&Vector2<f64>) -> bool) -> Vec<(usize, f64)> {
        let mut forces = BTreeMap::new();
        let sides = self
            .boundary
            .iter()
            .filter(|arc| arc.iter().all(|n| wanted(&self.nodes[*n])));
        for arc in sides {
            for (u, weight) in GAUSS {
                let slopes = super::shape::line_slope(u);
                let tangent: Vector2<f64> = arc.iter().zip(slopes).map(|(n, s)| self.nodes[*n] * s).sum();
                for (n, value) in arc.iter().zip(super::shape::line(u)) {
                    let share = traction * (weight * value * tangent.norm());
                    *forces.entry(2 * n).or_insert(0.0) += share.x;
                    *forces.entry(2 * n + 1).or_insert(0.0) += share.y;
                }
            }
        }
        forces.into_iter().collect()
    }
}

fn check_nodes(nodes: &[Vector2<f64>], elements: &[[usize; NODES]]) -> Result<(), Refused> {
    if elements.is_empty() {
        return Err(Refused::Empty);
    }
    if let Some(node) = nodes.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
        let (x, y) = (nodes[node].x, nodes[node].y);
        return Err(Refused::NotFinite { node, x, y });
    }
    // The last element that named each node: a second time in the same one is seen without a set.
    let mut used = vec![usize::MAX; nodes.len()];
    for (element, ids) in elements.iter().enumerate() {
        for &node in ids {
            let nodes = used.len();
            let last = used
                .get_mut(node)
                .ok_or(Refused::MissingNode { element, node, nodes })?;
            if *last == element {
                return Err(Refused::RepeatedNode { element, node });
            }
            *last = element;
        }
    }
    match used.iter().position(|u| *u == usize::MAX) {
        Some(node) => Err(Refused::UnusedNode { node }),
        None => Ok(()),
    }
}

fn element(nodes: &[Vector2<f64>], index: usize, ids: [usize; NODES]) -> Result<Element, Refused> {
    let at = ids.map(|n| nodes[n]);
    check_map(&at, index)?;
    let mut points = Vec::with_capacity(9);
    for k in 0..9 {
        let ((u, a), (v, b)) = (GAUSS[k % 3], GAUSS[k / 3]);
        points.extend(GaussPoint::of(&at, [u, v], a * b));
    }
    Ok(Element::of_points(ids, points))
}

/// The determinant of the map must be positive at the Gauss points, and at the nodes, where quarter points fold first.
fn check_map(at: &[Vector2<f64>; NODES], element: usize) -> Result<(), Refused> {
    let determinant = |u: f64, v: f64| map(at, u, v).determinant();
    let gauss = (0..9).map(|k| (GAUSS[k % 3], GAUSS[k / 3]));
    let area: f64 = gauss.clone().map(|((u, a), (v, b))| a * b * determinant(u, v)).sum();
    let nodes = (0..9).map(|k| ((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0));
    let places = nodes.chain(gauss.map(|((u, _), (v, _))| (u, v)));
    let values: Vec<_> = places.map(|(u, v)| (u, v, determinant(u, v))).collect();
    // Turned over everywhere is a matter of numbering, anywhere else a fold.
    if values.iter().all(|v| v.2 < 0.0) {
        return Err(Refused::Clockwise { element, area });
    }
    // The square of local coordinates has the area 4.
    let mean = 0.25 * area;
    let least = values.iter().min_by(|a, b| a.2.total_cmp(&b.2));
    match least {
        Some(&(u, v, determinant)) if determinant.is_nan() || determinant <= LEAST_DETERMINANT * mean.abs() => {
            Err(Refused::Folded {
                element,
                u,
                v,
                determinant,
                mean,
            })
        }
        _ => Ok(()),
    }
}

/// Sides named once, in the direction that keeps the solid on the left.
fn boundary(elements: &[Element]) -> Result<Vec<Arc>, Refused> {
    // Sorted: arcs come in the same order in every run.
    let mut sides: BTreeMap<[usize; 2], Vec<Arc>> = BTreeMap::new();
    for element in elements {
        for side in SIDES {
            let arc = side.map(|n| element.nodes[n]);
            // Two neighbours name a side in opposite directions: its ends in order are one key for both.
            let key = [arc[0].min(arc[2]), arc[0].max(arc[2])];
            sides.entry(key).or_default().push(arc);
        }
    }
    let mut boundary = Vec::new();
    for arcs in sides.values() {
        match arcs.as_slice() {
            [one] => boundary.push(*one),
            // Opposite directions, so that the elements lie on either side, and the same middle: else there is a gap.
            [a, b] if a[0] == b[2] && a[1] == b[1] => {}
            more => {
                return Err(Refused::Side {
                    side: more[0],
                    count: more.len(),
                });
            }
        }
    }
    Ok(boundary)
}
