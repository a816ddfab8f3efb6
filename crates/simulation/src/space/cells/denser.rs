//! Points of the surface as near to one another as something small that is to touch it asks for.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::field::{Field, is_clear, steepest};
use super::mesh::Mesh;
use super::parts::SurfacePoint;
use super::rule::{Depth, Rule};
use super::surface::faces_of;

/// Halvings of a cube's sides at most, in search of places on its surface.
const MOST_HALVINGS: u32 = 5;
/// Cubes in which other places have an area that differs by more than this part of it keep their points.
const MOST_OTHER: f64 = 0.01;

impl Mesh {
    /// Lays the points of the surface anew in cubes for which `spacing(low, high)` is a length, mm: of many places on it those that no one before is nearer to
    /// than that, so that no two points are nearer, and no place that was looked at is farther from one. These are at most half a spacing apart along the axes, but for where the surface is
    /// steep. Each point stands for the area that is nearer to it than to the others. Elements and unknowns stay as they are: the same surface is looked at, and
    /// pressed on, elsewhere. Points of a mesh as it is made integrate polynomials exactly, but some stand for next to no area, so that pressures at them settle
    /// slowly, and they leave gaps.
    ///
    /// `field` and `depth` are those that the mesh was made with. A cube keeps its points where no spacing is asked, where the 32nd of its side is too large for
    /// the spacing, and where another area is found, as where its surface lies on its face by rounding.
    pub fn lay_points(
        &mut self,
        field: &dyn Field,
        depth: Depth,
        spacing: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Option<f64>,
    ) {
        let mut old: Vec<Vec<SurfacePoint>> = vec![Vec::new(); self.cells.len()];
        self.surface.iter().for_each(|p| old[p.cell as usize].push(*p));
        let (mut kept, mut samples) = (Vec::new(), Vec::new());
        for (number, points) in old.into_iter().enumerate() {
            let [low, high] = self.grid.corners(&self.cells[number]);
            let wanted = spacing(&low, &high).filter(|s| s.is_finite() && *s > 0.0 && !points.is_empty());
            let new = wanted.and_then(|spacing| Some((spacing, samples_of(self, field, depth, number, spacing)?)));
            let area = |points: &[SurfacePoint]| points.iter().map(|p| p.area).sum::<f64>();
            match new {
                Some((spacing, new)) if (area(&new) - area(&points)).abs() <= MOST_OTHER * area(&points) => {
                    samples.extend(new.into_iter().map(|p| (p, spacing)));
                }
                _ => kept.extend(points),
            }
        }
        // Points of other cubes are no reason to drop one where no spacing was asked.
        kept.extend(thinned(samples));
        // Later readers go through the points cube by cube.
        kept.sort_by_key(|p| p.cell);
        self.surface = kept;
    }
}

/// Places on the surface in a cube, along the axes no farther apart than half the spacing; `None` where they would be too many.
fn samples_of(mesh: &Mesh, field: &dyn Field, depth: Depth, number: usize, spacing: f64) -> Option<Vec<SurfacePoint>> {
    let [low, high] = mesh.grid.corners(&mesh.cells[number]);
    // Of four Gauss points no two that are neighbours are farther apart than 0.34 of the part.
    let parts = (0.34 * (high.x - low.x) / (0.5 * spacing)).log2().ceil().max(0.0);
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

/// Of places those that no one before is nearer to than their spacing, each with the area of all that are nearest to it.
fn thinned(samples: Vec<(SurfacePoint, f64)>) -> Vec<SurfacePoint> {
    let widest = samples.iter().map(|s| s.1).fold(0.0, f64::max);
    let key = |at: &Vector3<f64>| -> [i64; 3] { (at / widest).map(|x| x.floor() as i64).into() };
    let mut boxes: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    let mut kept: Vec<SurfacePoint> = Vec::new();
    let nearest = |boxes: &BTreeMap<[i64; 3], Vec<usize>>, kept: &[SurfacePoint], at: &Vector3<f64>| {
        let middle = key(at);
        let around = (0..27).map(|n| [0, 1, 2].map(|k| middle[k] + [n % 3, n / 3 % 3, n / 9][k] - 1));
        let near = around.filter_map(|key| boxes.get(&key)).flatten();
        let away = near.map(|k| ((kept[*k].at - at).norm(), *k));
        away.min_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)))
    };
    for (sample, spacing) in &samples {
        if nearest(&boxes, &kept, &sample.at).is_none_or(|(away, _)| away >= *spacing) {
            boxes.entry(key(&sample.at)).or_default().push(kept.len());
            kept.push(SurfacePoint { area: 0.0, ..*sample });
        }
    }
    // Only now all that are kept are known: an area goes to the nearest of them.
    for (sample, _) in &samples {
        if let Some((_, k)) = nearest(&boxes, &kept, &sample.at) {
            kept[k].area += sample.area;
        }
    }
    kept
}
