//! Checks of triangles, one after another.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::topology::{Border, Sets, topology};
use super::{DIAGONAL_MM, Facts, MOST_TRIANGLES, OpenEnd, SurfaceError};

/// A surface that passed.
pub(super) struct Checked {
    pub(super) corners: Vec<Vector3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) caps: Vec<[Vector3<f64>; 3]>,
    pub(super) facts: Facts,
}

/// A part whose volume over its area to the power 3/2 is below this encloses nothing (of a ball it is 0.094, of a disc of a tenth of
/// its radius in thickness 0.02).
const SHEET: f64 = 0.003;
/// At most so many parts are looked into for others: the largest.
const MOST_CONTAINERS: usize = 64;
/// So many corners of a part tell whether it lies in another, by most of them: where both are open the border of the inner one may reach out.
const ASKED: usize = 9;

/// One connected part.
struct Part {
    triangles: Vec<[u32; 3]>,
    caps: Vec<[Vector3<f64>; 3]>,
    ends: Vec<OpenEnd>,
    bounds: [Vector3<f64>; 2],
    area: f64,
    /// mm^3, its open ends closed by cones.
    volume: f64,
}

pub(super) fn checked(corners_mm: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Checked, SurfaceError> {
    numbers(corners_mm, triangles)?;
    let (corners, mut welded) = weld(corners_mm, triangles);
    let before = welded.len();
    // Without such a triangle its two other edges, which are one edge in both directions, cancel: no hole is left.
    welded.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let collapsed = before - welded.len();
    if welded.is_empty() {
        return Err(SurfaceError::Count { found: 0 });
    }
    size(&bounds(&corners, &welded))?;
    let parts = parts(&corners, &welded)?;
    let (outer, inner) = without_inner(&corners, parts);
    for part in &outer {
        if part.volume < -SHEET * part.area.powf(1.5) {
            return Err(SurfaceError::InsideOut {
                triangles: part.triangles.len(),
                volume_ml: part.volume * 1e-3,
            });
        }
    }
    Ok(gathered(corners, &outer, &inner, collapsed))
}

fn gathered(corners: Vec<Vector3<f64>>, outer: &[Part], inner: &[Part], collapsed: usize) -> Checked {
    let triangles: Vec<[u32; 3]> = outer.iter().flat_map(|part| part.triangles.iter().copied()).collect();
    // Of the parts that are kept alone: an inner wall's border leads nowhere that a probe comes.
    let ends: Vec<OpenEnd> = outer.iter().flat_map(|part| part.ends.iter().copied()).collect();
    let [least, most] = bounds(&corners, &triangles);
    let facts = Facts {
        triangles: triangles.len(),
        collapsed,
        parts: outer.len(),
        inner_parts: inner.len(),
        inner_triangles: inner.iter().map(|part| part.triangles.len()).sum(),
        open_edges: ends.iter().map(|end| end.edges).sum(),
        open_ends: ends,
        area_mm2: outer.iter().map(|part| part.area).sum(),
        bounds_mm: [least.into(), most.into()],
        is_sheet: outer
            .iter()
            .any(|part| part.volume.abs() <= SHEET * part.area.powf(1.5)),
    };
    let caps = outer.iter().flat_map(|part| part.caps.iter().copied()).collect();
    Checked {
        corners,
        triangles,
        caps,
        facts,
    }
}

fn numbers(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), SurfaceError> {
    if triangles.is_empty() || triangles.len() > MOST_TRIANGLES {
        return Err(SurfaceError::Count { found: triangles.len() });
    }
    if let Some(corner) = corners.iter().position(|c| c.iter().any(|x| !x.is_finite())) {
        return Err(SurfaceError::NotFinite {
            corner,
            found: corners[corner],
        });
    }
    for (triangle, t) in triangles.iter().enumerate() {
        if let Some(found) = t.iter().find(|c| **c as usize >= corners.len()) {
            return Err(SurfaceError::NoCorner {
                triangle,
                found: *found,
                corners: corners.len(),
            });
        }
    }
    Ok(())
}

fn size([least, most]: &[Vector3<f64>; 2]) -> Result<(), SurfaceError> {
    let diagonal = (most - least).norm();
    if diagonal < DIAGONAL_MM[0] {
        return Err(SurfaceError::TooSmall { diagonal });
    }
    // An overflow of the difference is infinite and too large as well.
    if diagonal.is_nan() || diagonal > DIAGONAL_MM[1] {
        return Err(SurfaceError::TooLarge { diagonal });
    }
    Ok(())
}

/// Corners at one place become one: files of loose triangles have no topology else.
fn weld(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let mut places = HashMap::with_capacity(corners.len());
    let mut kept = Vec::new();
    let mut new_of = Vec::with_capacity(corners.len());
    for corner in corners {
        // Zero has two signs and is one place.
        let bits = corner.map(|x| (x + 0.0).to_bits());
        let next = kept.len() as u32;
        let place = *places.entry(bits).or_insert(next);
        if place == next {
            kept.push(Vector3::from(*corner));
        }
        new_of.push(place);
    }
    let triangles = triangles.iter().map(|t| t.map(|c| new_of[c as usize])).collect();
    (kept, triangles)
}

fn bounds(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> [Vector3<f64>; 2] {
    let mut bounds = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    for corner in triangles.iter().flatten() {
        let p = &corners[*corner as usize];
        bounds = [bounds[0].inf(p), bounds[1].sup(p)];
    }
    bounds
}

/// Cones over the borders, their ends, and the parts, largest first.
fn parts(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<Part>, SurfaceError> {
    let topology = topology(corners, triangles)?;
    let mut members: Vec<(u32, u32)> = topology.part.iter().zip(0..).map(|(part, i)| (*part, i)).collect();
    members.sort_unstable();
    let mut borders: Vec<(u32, Border)> = topology
        .borders
        .iter()
        .map(|border| (topology.part[border.triangle as usize], *border))
        .collect();
    // Stable: borders of one part stay in their order.
    borders.sort_by_key(|border| border.0);
    let mut parts = Vec::new();
    for group in members.chunk_by(|a, b| a.0 == b.0) {
        let first = borders.partition_point(|border| border.0 < group[0].0);
        let last = borders.partition_point(|border| border.0 <= group[0].0);
        let own: Vec<Border> = borders[first..last].iter().map(|border| border.1).collect();
        let triangles = group.iter().map(|(_, i)| triangles[*i as usize]).collect();
        parts.push(part(corners, triangles, &own));
    }
    parts.sort_by_key(|part| std::cmp::Reverse(part.triangles.len()));
    Ok(parts)
}

fn part(corners: &[Vector3<f64>], triangles: Vec<[u32; 3]>, borders: &[Border]) -> Part {
    let (caps, ends) = caps(corners, borders);
    let solid = triangles.iter().map(|t| t.map(|c| corners[c as usize]));
    let area = solid
        .clone()
        .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm())
        .sum();
    let bounds = bounds(corners, &triangles);
    // About the middle of the box, so that a part far from the origin loses no digits.
    let middle = (bounds[0] + bounds[1]) * 0.5;
    let volume = solid
        .chain(caps.iter().copied())
        .map(|[a, b, c]| (a - middle).dot(&(b - middle).cross(&(c - middle))) / 6.0)
        .sum();
    Part {
        triangles,
        caps,
        ends,
        bounds,
        area,
        volume,
    }
}

/// A cone over each connected piece of border: as a chain the border of triangles has no border, so that a cone over it closes the
/// surface however the border crosses itself.
fn caps(corners: &[Vector3<f64>], borders: &[Border]) -> (Vec<[Vector3<f64>; 3]>, Vec<OpenEnd>) {
    let mut names: Vec<u32> = borders.iter().flat_map(|border| [border.from, border.to]).collect();
    names.sort_unstable();
    names.dedup();
    let place = |corner: u32| names.partition_point(|c| *c < corner) as u32;
    let mut sets = Sets::new(names.len());
    for border in borders {
        sets.join(place(border.from), place(border.to));
    }
    let mut by_end: Vec<(u32, &Border)> = borders
        .iter()
        .map(|border| (sets.root(place(border.from)), border))
        .collect();
    by_end.sort_by_key(|border| border.0);
    let (mut caps, mut ends) = (Vec::new(), Vec::new());
    for group in by_end.chunk_by(|a, b| a.0 == b.0) {
        let at = |corner: u32| corners[corner as usize];
        let sum: Vector3<f64> = group.iter().map(|(_, border)| at(border.from)).sum();
        // Any apex closes the border; the mean of its corners makes the cone a lid and not a spike.
        let apex = sum / group.len() as f64;
        caps.extend(group.iter().map(|(_, border)| [at(border.to), at(border.from), apex]));
        ends.push(OpenEnd {
            edges: group.len(),
            length_mm: group
                .iter()
                .map(|(_, border)| (at(border.to) - at(border.from)).norm())
                .sum(),
            centre_mm: apex.into(),
        });
    }
    (caps, ends)
}

/// Parts that lie in none of the others, and those that do.
fn without_inner(corners: &[Vector3<f64>], parts: Vec<Part>) -> (Vec<Part>, Vec<Part>) {
    let holds = |container: &Part, p: &Vector3<f64>| {
        let within = (0..3).all(|k| container.bounds[0][k] <= p[k] && p[k] <= container.bounds[1][k]);
        let triangles = container.triangles.iter().map(|t| t.map(|c| corners[c as usize]));
        within && winding(triangles.chain(container.caps.iter().copied()), p).abs() > 0.5
    };
    let is_inner = |i: usize| {
        let triangles = &parts[i].triangles;
        let asked = triangles.iter().step_by(triangles.len().div_ceil(ASKED));
        let places: Vec<_> = asked.map(|t| corners[t[0] as usize]).collect();
        // Larger ones only: of two that touch, one is the bone.
        parts[..i.min(MOST_CONTAINERS)].iter().any(|container| {
            let held = places.iter().filter(|p| holds(container, p)).count();
            2 * held > places.len()
        })
    };
    let inner: Vec<bool> = (0..parts.len()).map(is_inner).collect();
    let (mut outer, mut inside) = (Vec::new(), Vec::new());
    for (part, is_inner) in parts.into_iter().zip(inner) {
        if is_inner { inside.push(part) } else { outer.push(part) }
    }
    (outer, inside)
}

/// The sum of the triangles' solid angles seen from `p`, over 4 pi.
pub(super) fn winding(triangles: impl Iterator<Item = [Vector3<f64>; 3]>, p: &Vector3<f64>) -> f64 {
    let angle = |[a, b, c]: [Vector3<f64>; 3]| {
        let (a, b, c) = (a - p, b - p, c - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}
