//! Seeds where nothing is known: two measured points laid on two places of the surface that are as far apart (pairs of points with
//! normals, Drost et al. 2010).
//!
//! For each pair of measured points all pairs of places are looked at whose distance agrees and, where the points have beams, whose
//! normals can lie against them. A pair of places gives a pose, but for the roll about the line through them: it is the one that lays
//! the beams on the normals, and without beams drawn at random.

use chance::Chance;
use nalgebra::{Matrix3, Vector3};

use super::Effort;
use crate::points::Cloud;
use crate::solve::State;

/// A place of the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) place: Vector3<f64>,
    pub(crate) normal: Vector3<f64>,
}

/// The cloud and all pairs of places, in the order of their distance.
pub(crate) struct Pairs<'a> {
    cloud: &'a Cloud,
    spots: Vec<Spot>,
    /// By bins of distance.
    table: Vec<(u32, u32)>,
    first: Vec<u32>,
    bin_mm: f64,
}

/// The share of the points' diameter that the points of a pair are apart, at least: the further, the better a pose is held.
const LEAST_SHARE: f64 = 0.35;
/// Cosine of the angle that beam and normal may differ by, against the roll that lays them best on one another.
const LEAST_COSINE: f64 = 0.6;

impl<'a> Pairs<'a> {
    pub(crate) fn new(cloud: &'a Cloud, spots: Vec<Spot>, spacing_mm: f64) -> Self {
        let bin_mm = (0.5 * spacing_mm).max(1.0);
        let n = spots.len();
        let bin = |i: usize, j: usize| ((spots[i].place - spots[j].place).norm() / bin_mm) as usize;
        let mut counts: Vec<u32> = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let b = bin(i, j);
                if b + 1 >= counts.len() {
                    counts.resize(b + 2, 0);
                }
                counts[b + 1] += u32::from(i != j);
            }
        }
        // Sorted by counting: a million pairs, and their order within a bin does not matter.
        for b in 1..counts.len() {
            counts[b] += counts[b - 1];
        }
        let first = counts.clone();
        let mut table = vec![(0, 0); first.last().map_or(0, |n| *n as usize)];
        for i in 0..n {
            for j in 0..n {
                if i != j {
                    let place = &mut counts[bin(i, j)];
                    table[*place as usize] = (i as u32, j as u32);
                    *place += 1;
                }
            }
        }
        Self {
            cloud,
            spots,
            table,
            first,
            bin_mm,
        }
    }

    pub(super) fn each(&self, effort: &Effort, take: &mut dyn FnMut(State)) {
        let n = self.cloud.len() as f64;
        let pick = |u: f64| ((u * n) as usize).min(self.cloud.len() - 1);
        let least = 2.0 * self.cloud.radius_mm * LEAST_SHARE;
        let (mut made, mut draw) = (0, 0);
        // Of points in a heap of which none lies far from another there may be no such pair at all.
        while made < effort.pairs && draw < 100 * effort.pairs as u64 {
            let chance = Chance::new(effort.seed ^ 0x7061_6972, draw);
            draw += 1;
            let (i, j) = (pick(chance.uniform(0)), pick(chance.uniform(1)));
            if i == j || (self.cloud.places[i] - self.cloud.places[j]).norm() < least {
                continue;
            }
            made += 1;
            self.laid(i, j, chance, take);
        }
    }

    /// All poses that lay the points i and j on places.
    fn laid(&self, i: usize, j: usize, chance: Chance, take: &mut dyn FnMut(State)) {
        let cloud = self.cloud;
        let way = cloud.places[j] - cloud.places[i];
        let middle = (cloud.places[i] + cloud.places[j]) * 0.5;
        let length = way.norm();
        let bin = (length / self.bin_mm - 0.5).max(0.0) as usize;
        let last = (bin + 2).min(self.first.len() - 1);
        if bin >= last {
            return;
        }
        // Two bins about the length: places are half a spacing off the points that are laid on them, each.
        let along = way / length;
        let from = Frame3::of(along, cloud.beams[i], cloud.beams[j]);
        for (place, (a, b)) in self.table[self.first[bin] as usize..self.first[last] as usize]
            .iter()
            .enumerate()
        {
            let (a, b) = (&self.spots[*a as usize], &self.spots[*b as usize]);
            let Some(to_along) = (b.place - a.place).try_normalize(1e-9) else {
                continue;
            };
            let Some(turn) = from.onto(to_along, [-a.normal, -b.normal], || {
                std::f64::consts::TAU * chance.uniform(100 + place as u64)
            }) else {
                continue;
            };
            take(State {
                turn,
                shift: (a.place + b.place) * 0.5 - turn * middle,
                scale: 0.0,
                offset: 0.0,
            });
        }
    }
}

/// A direction with two more, by their parts along it and across.
struct Frame3 {
    along: Vector3<f64>,
    x: Vector3<f64>,
    y: Vector3<f64>,
    /// Of the two beams: along, x, y; `None` without beams.
    beams: Option<[[f64; 3]; 2]>,
}

impl Frame3 {
    fn of(along: Vector3<f64>, first: Vector3<f64>, second: Vector3<f64>) -> Self {
        let (x, y) = across(&along);
        let parts = |b: Vector3<f64>| [b.dot(&along), b.dot(&x), b.dot(&y)];
        let has_beams = first.norm_squared() > 0.0 && second.norm_squared() > 0.0;
        Self {
            along,
            x,
            y,
            beams: has_beams.then(|| [parts(first), parts(second)]),
        }
    }

    /// The rotation that takes this direction to `to` and the beams as near to `want` as they come; `None` where that is not near.
    fn onto(&self, to: Vector3<f64>, want: [Vector3<f64>; 2], roll: impl Fn() -> f64) -> Option<Matrix3<f64>> {
        let (tx, ty) = across(&to);
        let (sin, cos) = match &self.beams {
            None => roll().sin_cos(),
            Some(beams) => {
                let (mut c, mut s) = (0.0, 0.0);
                let mut fixed = [0.0; 2];
                let mut sums = [[0.0; 2]; 2];
                for k in 0..2 {
                    let [l, x, y] = beams[k];
                    let (wl, wx, wy) = (want[k].dot(&to), want[k].dot(&tx), want[k].dot(&ty));
                    fixed[k] = l * wl;
                    // Turned by f: x' = x cos f - y sin f, y' = x sin f + y cos f.
                    sums[k] = [x * wx + y * wy, x * wy - y * wx];
                    c += sums[k][0];
                    s += sums[k][1];
                }
                let length = (c * c + s * s).sqrt();
                if length < 1e-9 {
                    return None;
                }
                let (cos, sin) = (c / length, s / length);
                if (0..2).any(|k| fixed[k] + sums[k][0] * cos + sums[k][1] * sin < LEAST_COSINE) {
                    return None;
                }
                (sin, cos)
            }
        };
        let (rx, ry) = (tx * cos + ty * sin, ty * cos - tx * sin);
        Some(to * self.along.transpose() + rx * self.x.transpose() + ry * self.y.transpose())
    }
}

/// Two directions across a third one, the three of them right-handed: (x, y, along).
fn across(along: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    // Duff et al. 2017: continuous but at one direction, without a root.
    let sign = 1.0_f64.copysign(along.z);
    let a = -1.0 / (sign + along.z);
    let b = along.x * along.y * a;
    let x = Vector3::new(1.0 + sign * along.x * along.x * a, sign * b, -sign * along.x);
    (x, Vector3::new(b, sign + along.y * along.y * a, -along.y))
}
