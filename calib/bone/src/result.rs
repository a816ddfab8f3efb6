//! What was taken from a CT.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use crate::component::Component;
use crate::islands::without_islands;
use crate::patch::Lost;
use crate::place::{Place, Sight, State};
use crate::scanner::Scanner;
use crate::shell::Shell;
use crate::sight::{Bare, Judged};

/// What was found of the scanner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScannerFound {
    /// Blur in the slice's plane and along its normal, deviations, mm.
    pub blur_mm: [f64; 2],
    /// Its own deviation, relative.
    pub blur_relative: [f64; 2],
    /// Whether it was told.
    pub is_told: bool,
    /// Excess kurtosis of the blur, and its deviation.
    pub kurtosis: [f64; 2],
    /// HU of cortex, and deviation of its mean.
    pub cortex_hu: [f64; 2],
    /// How much the cortex's HU differ from place to place, relative.
    pub cortex_spread: f64,
    /// Mean of the logarithm of the thickness, mm, and its deviation from place to place.
    pub log_thickness: [f64; 2],
    /// Deviation of a voxel, HU, what the model leaves included.
    pub noise_hu: f64,
    /// Correlation of neighbouring voxels along each axis.
    pub noise_neighbours: [f64; 3],
    /// Places that told of it; 0 where there were too few, and all is what is expected of voxels of this size.
    pub places: usize,
}

impl ScannerFound {
    pub(crate) fn new(scanner: &Scanner, is_told: bool) -> Self {
        let deviation = |k: usize| scanner.covariance[(k, k)].max(0.0).sqrt();
        Self {
            blur_mm: scanner.blur_mm,
            blur_relative: [deviation(0), deviation(1)],
            is_told,
            kurtosis: [scanner.kurtosis, deviation(3)],
            cortex_hu: [scanner.cortex_hu, scanner.cortex_hu * deviation(2)],
            cortex_spread: scanner.cortex_spread,
            log_thickness: scanner.log_thickness,
            noise_hu: scanner.noise.hu,
            noise_neighbours: scanner.noise.neighbours,
            places: scanner.places,
        }
    }
}

/// The surface of a bone.
#[derive(Debug, Clone, PartialEq)]
pub struct Bone {
    /// Its places.
    pub places: Vec<Place>,
    /// Triangles, anticlockwise seen from outside, where cortex is seen: the surface to register with.
    pub triangles: Vec<[u32; 3]>,
    /// Those where it is not and yet may be: bone to be looked at, not to register with. Empty where a surface without cortex was asked for.
    pub unseen: Vec<[u32; 3]>,
    /// What was left out as it has no cortex, the largest first.
    pub bare: Vec<Bare>,
    /// The scanner.
    pub scanner: ScannerFound,
    /// Corners of the threshold's outer surface.
    pub threshold_corners: usize,
    /// How many of them have no position, by the reason.
    pub lost: BTreeMap<Lost, usize>,
    /// Area of the threshold's outer surface, of what is left of it with cortex, and of what is left without, mm^2.
    pub area_mm2: [f64; 3],
    /// Triangles of cavities, left out.
    pub inner_triangles: usize,
    /// Share of the fitted places without cortex that is seen, those that were left out with it.
    pub without_cortex: f64,
    /// The body above the threshold.
    pub body: Component,
    /// The largest bodies of the region.
    pub listed: Vec<Component>,
    /// Voxels of metal about it.
    pub metal_voxels: u64,
}

impl Bone {
    /// The places that a registration hears: those with cortex, or all where nothing is marked.
    pub fn heard(&self) -> impl Iterator<Item = &Place> {
        let is_all = self.unseen.is_empty();
        self.places.iter().filter(move |p| is_all || p.sight == Sight::Cortex)
    }

    /// Root mean square deviation of a place by itself, mm.
    pub fn deviation_rms_mm(&self) -> f64 {
        rms(self.heard().map(|p| p.deviation_mm))
    }

    /// Root mean square deviation by what all places share, mm.
    pub fn shared_rms_mm(&self) -> f64 {
        rms(self.heard().map(|p| p.shared_mm))
    }

    /// Quantile of the places' whole deviation, mm.
    pub fn quantile_mm(&self, share: f64) -> f64 {
        fit::quantile(self.heard().map(Place::total_mm).collect(), share)
    }

    pub(crate) fn gather(
        shell: &Shell,
        states: &[State],
        scanner: ScannerFound,
        judged: Judged,
        (body, listed, metal_voxels): (Component, Vec<Component>, u64),
    ) -> Self {
        let mut lost: BTreeMap<Lost, usize> = BTreeMap::new();
        states
            .iter()
            .filter_map(|s| s.as_ref().err())
            .for_each(|why| *lost.entry(*why).or_default() += 1);
        let place = |i: u32| states[i as usize].as_ref().ok();
        let kept: Vec<[u32; 3]> = shell
            .triangles
            .iter()
            .filter(|t| is_sound(t, |i| place(i).map(|p| p.mm), |i| shell.corners[i as usize]))
            .copied()
            .collect();
        let at = |i: u32| place(i).map_or_else(|| shell.corners[i as usize], |p| p.mm);
        let area = |t: [Vector3<f64>; 3]| 0.5 * (t[1] - t[0]).cross(&(t[2] - t[0])).norm();
        let (kept, alone) = without_islands(balanced(kept), |t| area(t.map(at)));
        if alone > 0 {
            lost.insert(Lost::Island, alone);
        }
        let mut new_of = vec![u32::MAX; states.len()];
        let mut places = Vec::new();
        for corner in kept.iter().flatten() {
            let slot = &mut new_of[*corner as usize];
            if *slot == u32::MAX
                && let Some(p) = place(*corner)
            {
                *slot = places.len() as u32;
                places.push(*p);
            }
        }
        let triangles = kept.iter().map(|t| t.map(|i| new_of[i as usize]));
        let is_seen = |t: &[u32; 3]| judged.is_heard || t.iter().all(|i| places[*i as usize].sight == Sight::Cortex);
        let (triangles, mut unseen): (Vec<[u32; 3]>, Vec<[u32; 3]>) = triangles.partition(is_seen);
        // why: what is not seen leaves scraps between, which tell nothing of a pose, nor which side of them is the bone's.
        let (triangles, scraps) = hanging(triangles, |t| area(t.map(|i| places[i as usize].mm)));
        unseen.extend(scraps);
        if !judged.is_heard {
            let heard: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
            let others = (0..).zip(&mut places).filter(|(i, _)| !heard.contains(i));
            others
                .filter(|(_, place)| place.sight == Sight::Cortex)
                .for_each(|(_, place)| place.sight = Sight::Unseen);
        }
        let before = shell
            .triangles
            .iter()
            .map(|t| area(t.map(|i| shell.corners[i as usize])))
            .sum();
        let whole = |t: &[[u32; 3]]| t.iter().map(|t| area(t.map(|i| places[i as usize].mm))).sum();
        let (seen_mm2, unseen_mm2) = (whole(&triangles), whole(&unseen));
        Self {
            places,
            triangles,
            unseen,
            bare: judged.bare,
            scanner,
            threshold_corners: states.len(),
            lost,
            area_mm2: [before, seen_mm2, unseen_mm2],
            inner_triangles: shell.inner,
            without_cortex: judged.without_cortex,
            body,
            listed,
            metal_voxels,
        }
    }
}

/// The triangles that hang together as a surface, and the others.
fn hanging(triangles: Vec<[u32; 3]>, area: impl Fn(&[u32; 3]) -> f64) -> (Vec<[u32; 3]>, Vec<[u32; 3]>) {
    let (kept, _) = without_islands(balanced(triangles.clone()), area);
    let stays: BTreeSet<[u32; 3]> = kept.iter().copied().collect();
    let others = triangles.into_iter().filter(|t| !stays.contains(t)).collect();
    (kept, others)
}

/// Whether a triangle's corners all have a position, and it was not turned over by their moves.
fn is_sound(t: &[u32; 3], place: impl Fn(u32) -> Option<Vector3<f64>>, before: impl Fn(u32) -> Vector3<f64>) -> bool {
    let normal = |[a, b, c]: [Vector3<f64>; 3]| (b - a).cross(&(c - a));
    let (Some(a), Some(b), Some(c)) = (place(t[0]), place(t[1]), place(t[2])) else {
        return false;
    };
    normal([a, b, c]).dot(&normal(t.map(before))) > 0.0
}

/// Without triangles at edges along which, as others went, more than one too many goes one way.
fn balanced(mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    loop {
        let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * triangles.len());
        for (i, t) in (0..).zip(&triangles) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                edges.push((a.min(b), a.max(b), a < b, i));
            }
        }
        edges.sort_unstable();
        let mut drop = vec![false; triangles.len()];
        for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let up = group.iter().filter(|e| e.2).count();
            if up.abs_diff(group.len() - up) > 1 {
                group.iter().for_each(|e| drop[e.3 as usize] = true);
            }
        }
        if !drop.contains(&true) {
            return triangles;
        }
        let mut next = drop.iter();
        triangles.retain(|_| !next.next().is_some_and(|d| *d));
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(s, n), v| (s + v * v, n + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::hanging;

    /// Three triangles that were left between marked ones stood inside out, and the whole surface was refused for them.
    #[test]
    fn scraps_between_marked_triangles_are_no_surface() {
        let strip = |first: u32, count: u32| (0..count).map(move |i| [first + i, first + i + 1, first + i + 2]);
        // Each second one is turned, as the strip's neighbours are.
        let turned = |(i, t): (usize, [u32; 3])| if i % 2 == 0 { t } else { [t[1], t[0], t[2]] };
        let of = |first, count| strip(first, count).enumerate().map(turned);
        let (kept, scraps) = hanging(of(0, 200).chain(of(300, 3)).collect(), |_| 1.0);
        assert_eq!((kept.len(), scraps), (200, of(300, 3).collect()));
    }
}
