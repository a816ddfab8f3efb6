//! Points of the surface as near to one another as something small that is to touch it asks for.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::field::{Field, is_clear, steepest};
use super::mesh::Mesh;
use super::parts::SurfacePoint;
use super::rule::{Depth, Rule, gauss};
use super::surface::faces_of;
use crate::space::gap::gap_of;
use crate::space::tree::Tree;

/// Halvings of a cube's sides at most, in search of places on its surface.
const MOST_HALVINGS: u32 = 5;
/// Cubes in which other places have an area that differs by more than this part of it keep their points.
const MOST_OTHER: f64 = 0.01;
/// Nor are areas believed that differ by more than this part: a surface on a face may be found twice.
const MOST_COARSE: f64 = 0.5;
/// Boxes in which places of the surface are told from none are no smaller than this part of a cube.
const FINEST: f64 = 16.0;

impl Mesh {
    /// Lays the points of the surface anew in cubes for which `spacing(low, high)` is a length, mm: of many places on it those that no one before is nearer to
    /// than that, so that no two points are nearer, and no place that was looked at is farther from one. These are at most half a spacing apart along the axes, but for where the surface is
    /// steep. Each point stands for the area that is nearer to it than to the others. Elements and unknowns stay as they are: the same surface is looked at, and
    /// pressed on, elsewhere. Points of a mesh as it is made integrate polynomials exactly, but some stand for next to no area, so that pressures at them settle
    /// slowly, and they leave gaps.
    ///
    /// `field` is that which the mesh was made with, `depth` how places are looked for. A cube keeps its points where no spacing is asked, where the 32nd of its side
    /// is too large for the spacing, and where another area is found, as where its surface lies on its face by rounding.
    /// [`SurfacePoint::gap`] is no less than those places are that were looked at; of cubes that keep their points it is told by area alone.
    /// A cube whose points were laid before may stand for other areas than its own, and then keeps them.
    pub fn lay_points(
        &mut self,
        field: &dyn Field,
        depth: Depth,
        spacing: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Option<f64>,
    ) {
        self.lay_points_by(field, |low, high| spacing(low, high).map(|spacing| (spacing, depth)));
    }

    /// The same where cubes differ in how places are looked for too: few Gauss points in many parts are as near to one another as many in few, and cost less
    /// where parts are small beside what the field resolves. Where fewer than four are asked, four are tried too before a cube keeps its points, whose own area may be what is off, and
    /// [`SurfacePoint::gap`] is then no less than any place of the surface in such a cube is from the nearest point.
    pub fn lay_points_by(
        &mut self,
        field: &dyn Field,
        spacing: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Option<(f64, Depth)>,
    ) {
        let mut old: Vec<Vec<SurfacePoint>> = vec![Vec::new(); self.cells.len()];
        self.surface.iter().for_each(|p| old[p.cell as usize].push(*p));
        let (mut kept, mut samples, mut coarse) = (Vec::new(), Vec::new(), Vec::new());
        for (number, points) in old.into_iter().enumerate() {
            let corners = self.grid.corners(&self.cells[number]);
            let wanted = spacing(&corners[0], &corners[1]);
            let wanted = wanted.filter(|(s, _)| s.is_finite() && *s > 0.0 && !points.is_empty());
            match wanted.map(|wanted| (wanted, laid(self, field, number, wanted, &points))) {
                Some(((spacing, _), Some(new))) => samples.extend(new.into_iter().map(|p| (p, spacing))),
                Some(((spacing, depth), None)) if is_few(depth) => {
                    coarse.push((corners, spacing));
                    kept.extend(points);
                }
                _ => kept.extend(points),
            }
        }
        // Points of other cubes are no reason to drop one where no spacing was asked.
        kept.extend(thinned(samples));
        // Later readers go through the points cube by cube.
        kept.sort_by_key(|p| p.cell);
        self.surface = kept;
        widen(&mut self.surface, field, &coarse);
    }
}

/// Places on the surface in a cube whose area is that of its points. With few Gauss points, which may miss a corner that the surface cuts off, four are tried too; and
/// where these find the same as the few, it is the cube's own points that are off.
fn laid(
    mesh: &Mesh,
    field: &dyn Field,
    number: usize,
    (spacing, depth): (f64, Depth),
    points: &[SurfacePoint],
) -> Option<Vec<SurfacePoint>> {
    let area = |points: &[SurfacePoint]| points.iter().map(|p| p.area).sum::<f64>();
    let is_within = |one: f64, part: f64, other: f64| (one - other).abs() <= part * other;
    let found = |points: usize| samples_of(mesh, field, number, (spacing, Depth { points, ..depth }));
    let (few, old) = (found(depth.points)?, area(points));
    if is_within(area(&few), MOST_OTHER, old) {
        return Some(few);
    }
    let four = found(Depth::default().points).filter(|_| is_few(depth))?;
    if is_within(area(&four), MOST_OTHER, old) {
        return Some(four);
    }
    let is_surer = is_within(area(&few), MOST_OTHER, area(&four)) && is_within(area(&four), MOST_COARSE, old);
    is_surer.then_some(four)
}

/// Whether places are looked for with fewer Gauss points than those of a mesh as it is made.
fn is_few(depth: Depth) -> bool {
    depth.points < Depth::default().points
}

/// Where cubes kept their points though nearer ones were asked, their gaps are no less than places of the surface there are from the nearest point of all.
fn widen(points: &mut [SurfacePoint], field: &dyn Field, cubes: &[([Vector3<f64>; 2], f64)]) {
    if cubes.is_empty() {
        return;
    }
    let tree = Tree::new(points.iter().map(|p| p.at).collect());
    for (corners, spacing) in cubes {
        let finest = ((corners[1] - corners[0]).norm() / FINEST).max(0.5 * spacing);
        let mut waiting = vec![*corners];
        while let Some([low, high]) = waiting.pop() {
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low).norm());
            // Bounds hold for certain: no place of the surface is left out, wherever Gauss points see none.
            let [least, most] = field.bounds(&low, &high);
            if least > 0.0 || most < 0.0 || is_clear(field, &low, &high, &steepest(field, &low, &high)) {
                continue;
            }
            if half > 0.5 * finest {
                waiting.extend((0..8).map(|n| eighth(&low, &high, n)));
            } else if let Some((k, apart)) = tree.nearest_given(&middle) {
                points[k].gap = points[k].gap.max(apart + half);
            }
        }
    }
}

/// One of the eight parts of a box.
fn eighth(low: &Vector3<f64>, high: &Vector3<f64>, number: usize) -> [Vector3<f64>; 2] {
    let half = 0.5 * (high - low);
    let is_upper = Vector3::from([number % 2, number / 2 % 2, number / 4].map(|k| k as f64));
    let low = low + half.component_mul(&is_upper);
    [low, low + half]
}

/// Places on the surface in a cube, along the axes no farther apart than half the spacing; `None` where they would be too many.
fn samples_of(
    mesh: &Mesh,
    field: &dyn Field,
    number: usize,
    (spacing, depth): (f64, Depth),
) -> Option<Vec<SurfacePoint>> {
    let [low, high] = mesh.grid.corners(&mesh.cells[number]);
    let parts = (widest(depth.points) * (high.x - low.x) / (0.5 * spacing))
        .log2()
        .ceil()
        .max(0.0);
    if !(0.0..=f64::from(MOST_HALVINGS)).contains(&parts) {
        return None;
    }
    let count = 1_usize << parts as u32;
    // A whole cube has a surface where the mesh ends with the grid only.
    if field.bounds(&low, &high)[1] <= 0.0 {
        return Some(faces_of(mesh, number, count));
    }
    let side = (high - low) / count as f64;
    let (mut points, steepest) = (Vec::new(), steepest(field, &low, &high));
    for n in 0..count.pow(3) {
        let at = [n % count, n / count % count, n / count / count].map(|k| k as f64);
        let low = low + side.component_mul(&Vector3::from(at));
        // Most parts have no surface in them.
        if is_clear(field, &low, &(low + side), &steepest) {
            continue;
        }
        let rule = Rule::surface_of(field, &low, &(low + side), depth);
        points.extend(rule.iter().map(|s| SurfacePoint::of(number, s)));
    }
    Some(points)
}

/// How far neighbours of so many Gauss points, in parts side by side, are from one another, in sides of a part: 0.34 of four, 0.58 of two.
fn widest(points: usize) -> f64 {
    let points = gauss(points);
    let beside = points.first().map_or(1.0, |(at, _)| 2.0 * at);
    points
        .windows(2)
        .map(|two| (two[1].0 - two[0].0).abs())
        .fold(beside, f64::max)
}

/// Places in boxes as wide as the widest spacing: what is nearer to a place than that is in its box or beside it.
struct Boxes {
    side: f64,
    boxes: BTreeMap<[i64; 3], Vec<usize>>,
}

impl Boxes {
    fn key(&self, at: &Vector3<f64>) -> [i64; 3] {
        (at / self.side).map(|x| x.floor() as i64).into()
    }

    /// Numbers of places in a box and those beside it, its own first.
    fn around(&self, middle: [i64; 3]) -> impl Iterator<Item = usize> {
        let keys = (0..27).map(move |n| {
            // Number 13 is the middle: it goes first.
            let n = (n + 13) % 27;
            [0, 1, 2].map(|k| middle[k] + [n % 3, n / 3 % 3, n / 9][k] - 1)
        });
        keys.filter_map(|key| self.boxes.get(&key)).flatten().copied()
    }
}

/// Of places those that no one before is nearer to than their spacing, each with the area of all that are nearest to it.
fn thinned(samples: Vec<(SurfacePoint, f64)>) -> Vec<SurfacePoint> {
    let mut boxes = Boxes {
        side: samples.iter().map(|s| s.1).fold(0.0, f64::max),
        boxes: BTreeMap::new(),
    };
    let mut kept: Vec<SurfacePoint> = Vec::new();
    for (sample, spacing) in &samples {
        let key = boxes.key(&sample.at);
        if boxes.around(key).all(|k| (kept[k].at - sample.at).norm() >= *spacing) {
            boxes.boxes.entry(key).or_default().push(kept.len());
            kept.push(SurfacePoint {
                area: 0.0,
                gap: 0.0,
                ..*sample
            });
        }
    }
    // Only now all that are kept are known: an area goes to the nearest of them.
    let (mut areas, mut farthest) = (vec![0.0; kept.len()], vec![0.0_f64; kept.len()]);
    let (mut around, mut last) = (Vec::new(), None);
    for (sample, _) in &samples {
        let key = boxes.key(&sample.at);
        // Samples come cube by cube: the next is often in the same box.
        if last.replace(key) != Some(key) {
            around = boxes.around(key).collect();
        }
        let away = around.iter().map(|k| ((kept[*k].at - sample.at).norm(), *k));
        if let Some((apart, k)) = away.min_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1))) {
            areas[k] += sample.area;
            farthest[k] = farthest[k].max(apart);
        }
    }
    for (point, (area, farthest)) in kept.iter_mut().zip(areas.into_iter().zip(farthest)) {
        (point.area, point.gap) = (area, gap_of(area).max(farthest));
    }
    kept
}
