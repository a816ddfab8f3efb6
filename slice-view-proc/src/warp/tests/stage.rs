//! Meshes that a formula moves, and planes through them.

use std::collections::BTreeMap;

use chance::SplitMix64;
use geometry::{Point, SlicePlane, Vector};

use crate::warp::quadratic::{at, weights};
use crate::warp::{Cube, Organ, Region, Shape, Warp, Warped};

pub(super) type Field = fn([f64; 3]) -> [f64; 3];

/// Cubes with their nodes' places at rest and now.
pub(super) struct Mesh {
    pub(super) cubes: Vec<Cube>,
    pub(super) now: Vec<[f64; 3]>,
}

impl Mesh {
    /// Cubes by lowest corner and side, larger ones first: nodes on a larger one's face follow that face.
    pub(super) fn new(cubes: &[([f64; 3], f64)], field: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        let mut mesh = Self {
            cubes: Vec::new(),
            now: Vec::new(),
        };
        let mut numbers: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        for (low, side) in cubes {
            let nodes = std::array::from_fn(|k| {
                let place = [0, 1, 2].map(|a| low[a] + side * [k % 3, k / 3 % 3, k / 9][a] as f64 / 2.0);
                let key = place.map(|x| (x * 1024.0).round() as i64);
                *numbers.entry(key).or_insert_with(|| {
                    let now = mesh.on_larger(place, *side).unwrap_or_else(|| field(place));
                    mesh.now.push(now);
                    mesh.now.len() as u32 - 1
                })
            });
            mesh.cubes.push(Cube {
                low: *low,
                side: *side,
                nodes,
            });
        }
        mesh
    }

    fn on_larger(&self, place: [f64; 3], side: f64) -> Option<[f64; 3]> {
        let larger = self.cubes.iter().filter(|cube| cube.side > side);
        larger.filter_map(|cube| self.map(cube, place)).next()
    }

    fn map(&self, cube: &Cube, place: [f64; 3]) -> Option<[f64; 3]> {
        let part = [0, 1, 2].map(|a| (place[a] - cube.low[a]) / cube.side);
        let within = part.iter().all(|t| (-1e-9..=1.0 + 1e-9).contains(t));
        within.then(|| at(&cube.nodes.map(|n| self.now[n as usize]), &part.map(weights)))
    }

    /// Where the cubes' quadratic maps take a place at rest; by the nearest cube outside of all.
    pub(super) fn moved(&self, place: [f64; 3]) -> [f64; 3] {
        let found = self.cubes.iter().find_map(|cube| self.map(cube, place));
        found.unwrap_or([f64::NAN; 3])
    }

    pub(super) fn places(&self) -> Vec<[f32; 3]> {
        self.now.iter().map(|place| place.map(|x| x as f32)).collect()
    }

    pub(super) fn shape(&self, region: Region, piece_mm: f64) -> Shape {
        Shape::new(&self.cubes, self.now.len(), region, piece_mm).unwrap()
    }
}

/// `count` cubes an axis from `low` on.
pub(super) fn block(low: [f64; 3], side: f64, count: usize) -> Vec<([f64; 3], f64)> {
    let place = |k: usize| [k % count, k / count % count, k / (count * count)];
    (0..count.pow(3))
        .map(|k| (std::array::from_fn(|a| low[a] + side * place(k)[a] as f64), side))
        .collect()
}

/// A block of 4 x 4 x 4 cubes of 10 mm about the origin, whose middle 8 are divided into 64.
pub(super) fn graded() -> Vec<([f64; 3], f64)> {
    let is_middle = |low: &[f64; 3]| low.iter().all(|x| (-10.0..10.0).contains(x));
    let mut cubes = block([-20.0; 3], 10.0, 4);
    cubes.retain(|(low, _)| !is_middle(low));
    cubes.extend(block([-10.0; 3], 5.0, 4));
    cubes
}

/// The region where a function is negative, in a box about `centre`.
pub(super) fn region(centre: [f64; 3], half: f64, step: f64, value: impl Fn([f64; 3]) -> f64) -> Region {
    let count = (2.0 * half / step).ceil() as usize + 1;
    let place = |k: usize| [k % count, k / count % count, k / (count * count)];
    let origin = centre.map(|x| x - half);
    let at = |k: usize| value(std::array::from_fn(|a| origin[a] + step * place(k)[a] as f64)) as f32;
    Region::new(origin, step, [count as u32; 3], (0..count.pow(3)).map(at).collect()).unwrap()
}

/// A box about `centre`.
pub(super) fn in_box(centre: [f64; 3], half: f64) -> Region {
    region(centre, half + 2.0, 1.0, move |x| {
        (0..3)
            .map(|a| (x[a] - centre[a]).abs() - half)
            .fold(f64::NEG_INFINITY, f64::max)
    })
}

pub(super) fn plane(centre: [f64; 3], axes: [[f64; 3]; 2], pixel_mm: f64, size: [u32; 2]) -> SlicePlane {
    let [x, y, z] = centre;
    let axes = axes.map(|[x, y, z]| Vector::new(x, y, z).direction().unwrap());
    SlicePlane::centred(Point::new(x, y, z), axes, pixel_mm, size).unwrap()
}

/// Two unit vectors at a right angle.
pub(super) fn axes(rng: &mut SplitMix64) -> [[f64; 3]; 2] {
    let mut one = || [0; 3].map(|_| rng.around(0.0, 1.0));
    let (a, b) = (one(), one());
    let dot = |p: [f64; 3], q: [f64; 3]| (0..3).map(|k| p[k] * q[k]).sum::<f64>();
    let unit = |p: [f64; 3]| p.map(|x| x / dot(p, p).sqrt());
    let a = unit(a);
    let along = dot(a, b);
    [a, unit(std::array::from_fn(|k| b[k] - along * a[k]))]
}

pub(super) fn draw<'a>(warp: &'a mut Warp, plane: &SlicePlane, shape: &Shape, mesh: &Mesh) -> &'a Warped {
    let places = mesh.places();
    warp.draw(plane, &[Organ { shape, places: &places }]).unwrap()
}

/// The place of pixel `k`.
pub(super) fn place(plane: &SlicePlane, k: usize) -> [f64; 3] {
    let width = plane.size()[0] as usize;
    plane.point((k % width) as f64, (k / width) as f64).mm()
}

pub(super) fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
}

/// The place at rest that a field takes to `now`: Newton's method from `from`, by differences.
pub(super) fn inverse(field: impl Fn([f64; 3]) -> [f64; 3], now: [f64; 3], from: [f64; 3]) -> Option<[f64; 3]> {
    let mut x = nalgebra::Vector3::from(from);
    for _ in 0..50 {
        let found = nalgebra::Vector3::from(field(x.into()));
        let off = nalgebra::Vector3::from(now) - found;
        if off.norm() < 1e-10 {
            return Some(x.into());
        }
        let step = 1e-5;
        let column = |a: usize| {
            let mut beside = x;
            beside[a] += step;
            (nalgebra::Vector3::from(field(beside.into())) - found) / step
        };
        let slope = nalgebra::Matrix3::from_columns(&[column(0), column(1), column(2)]);
        x += slope.lu().solve(&off)?;
    }
    None
}
