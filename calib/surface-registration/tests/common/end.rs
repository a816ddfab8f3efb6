//! Bones that a CT shows up to a plane, and points of them on both sides of it.

use std::f64::consts::TAU;

use chance::Chance;
use geometry::{Ct, Point, Rigid, Vector};
use nalgebra::Vector3;

use super::draw::{Drawn, Source, Sweep, is_in, point};
use super::oracle::Triangles;

type V = Vector3<f64>;

/// Where the CT ends: what is known lies below `at_mm` along `axis`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    pub(crate) axis: [f64; 3],
    pub(crate) at_mm: f64,
}

impl End {
    /// By how much a place lies beyond it, mm.
    pub(crate) fn beyond_mm(&self, p: &V) -> f64 {
        V::from(self.axis).dot(p) - self.at_mm
    }
}

/// A bone that goes on behind its end.
pub(crate) struct Cut {
    pub(crate) end: End,
    /// What the CT shows.
    pub(crate) shown: Triangles,
    /// What points are drawn from.
    known: Source,
    beyond: Source,
    pub(crate) targets: Vec<Point<Ct>>,
}

fn filtered((corners, triangles): &Triangles, keep: impl Fn(&[V; 3]) -> bool) -> Triangles {
    let kept = triangles
        .iter()
        .filter(|t| keep(&t.map(|i| V::from(corners[i as usize]))));
    (corners.clone(), kept.copied().collect())
}

impl Cut {
    /// Points are drawn from the triangles of `regions` ([`is_in`]) that lie within `reach_mm` of the end on either side.
    pub(crate) fn new(bone: &Triangles, end: End, regions: u8, reach_mm: [f64; 2], targets: Vec<Point<Ct>>) -> Self {
        let most = |t: &[V; 3]| t.iter().map(|p| end.beyond_mm(p)).fold(f64::NEG_INFINITY, f64::max);
        let is_touched = |t: &[V; 3]| {
            let n = (t[1] - t[0]).cross(&(t[2] - t[0]));
            n.try_normalize(0.0)
                .is_some_and(|n| is_in(regions, &((t[0] + t[1] + t[2]) / 3.0), &n))
        };
        Self {
            end,
            shown: filtered(bone, |t| most(t) < 0.0),
            known: Source::new(&filtered(bone, |t| {
                is_touched(t) && (-reach_mm[0]..0.0).contains(&most(t))
            })),
            // Of the triangles that the end goes through none is shown.
            beyond: Source::new(&filtered(bone, |t| {
                is_touched(t) && (0.0..reach_mm[1]).contains(&most(t))
            })),
            targets,
        }
    }

    /// Points of which about `share` lie beyond the end.
    pub(crate) fn draw(&self, sweep: &Sweep, share: f64, seed: u64) -> Drawn {
        let (mut drawn, beyond) = (self.known.draw(sweep, seed), self.beyond.draw(sweep, seed));
        for i in 0..drawn.points.len() {
            if Chance::new(seed, (1 << 46) + i as u64).uniform(0) < share {
                drawn.points[i] = beyond.points[i];
                drawn.is_outlier[i] = beyond.is_outlier[i];
                drawn.exact[i] = beyond.exact[i];
            }
        }
        drawn
    }

    /// The truth, shifted along the axis by so much.
    pub(crate) fn slid(&self, drawn: &Drawn, mm: f64) -> Drawn {
        let [x, y, z] = self.end.axis.map(|a| a * mm);
        let slide: Rigid<Ct, Ct> = Rigid::from_parts(geometry::rotation::Rotation::IDENTITY, Vector::new(x, y, z));
        Drawn {
            points: drawn.points.clone(),
            is_outlier: drawn.is_outlier.clone(),
            ct_from_tracker: slide * drawn.ct_from_tracker,
            exact: drawn.exact.clone(),
        }
    }
}

/// A tube about z from -100 to 100 mm whose radius follows a formula.
fn tube(radius: impl Fn(f64, f64) -> f64) -> Triangles {
    let (around, along) = (72_u32, 100_u32);
    let corner = |row: u32, k: u32| {
        let (azimuth, z) = (
            TAU * f64::from(k) / f64::from(around),
            200.0 * f64::from(row) / f64::from(along) - 100.0,
        );
        let r = radius(azimuth, z);
        [r * azimuth.cos(), r * azimuth.sin(), z]
    };
    let corners = (0..=along).flat_map(|row| (0..around).map(move |k| (row, k)));
    let number = |row: u32, k: u32| row * around + k % around;
    let cells = (0..along).flat_map(|row| (0..around).map(move |k| (row, k)));
    let triangles = cells.flat_map(|(row, k)| {
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| number(row + i, k + j));
        [[a, b, c], [b, d, c]]
    });
    (corners.map(|(row, k)| corner(row, k)).collect(), triangles.collect())
}

/// A tube whose radius hardly holds it along z: by a wave of 1 mm over 75 mm.
pub(crate) fn weak() -> Triangles {
    tube(|azimuth, z| 40.0 + 3.0 * (3.0 * azimuth).cos() + 2.0 * (azimuth - 0.4).sin().powi(3) + (z / 12.0).sin())
}

/// A shaft that hardly changes along itself towards its end at z = 40, with a flare at its lower end.
pub(crate) fn shaft() -> Triangles {
    tube(|azimuth, z| {
        let flare = ((-40.0 - z) / 20.0).exp().min(3.0);
        15.0 + 1.5 * (2.0 * azimuth + 0.005 * z).cos()
            + 2.0 * (azimuth - 0.4).sin().powi(3)
            + flare * (3.0 + 2.0 * (azimuth + 1.0).cos())
            - 0.01 * z
    })
}

/// A column whose levels, 30 mm high, differ by little.
pub(crate) fn column() -> Triangles {
    tube(|azimuth, z| {
        let wave = (TAU * z / 30.0).cos();
        20.0 + 3.0 * (3.0 * azimuth).cos() + (3.0 + 0.01 * z) * wave + 4.0 * (azimuth - 1.05).sin().powi(3) + 0.01 * z
    })
}

/// Targets about the axis of a tube.
pub(crate) fn about_axis() -> Vec<Point<Ct>> {
    [[10.0, 0.0, 0.0], [-10.0, 10.0, 20.0], [0.0, -15.0, -30.0]]
        .map(|p| point(V::from(p)))
        .to_vec()
}

/// Points of a bone that is by so much longer along each axis about the middle of the points than the one shown.
pub(crate) fn stretched(drawn: &mut Drawn, by: [f64; 3]) {
    let middle = drawn.exact.iter().map(|p| V::from(p.mm())).sum::<V>() / drawn.exact.len() as f64;
    let pose = drawn.ct_from_tracker;
    for p in &mut drawn.points {
        let there = V::from((pose * p.place).mm()) - middle;
        p.place = pose.inverse() * point(middle + there.component_mul(&V::from(by)));
    }
}

/// The points within `reach_mm` of the end become echoes, this share of them.
pub(crate) fn echoes_at_end(drawn: &mut Drawn, end: &End, reach_mm: [f64; 2], share: f64, seed: u64) {
    for i in 0..drawn.points.len() {
        let c = Chance::new(seed, (1 << 47) + i as u64);
        let off = end.beyond_mm(&V::from(drawn.exact[i].mm()));
        if drawn.is_outlier[i] || !(-reach_mm[0]..reach_mm[1]).contains(&off) || c.uniform(0) > share {
            continue;
        }
        if let Some(beam) = drawn.points[i].beam {
            let nearer = V::from(beam.direction.components()) * (3.0 + 9.0 * c.uniform(1));
            let p = V::from(drawn.points[i].place.mm()) - nearer;
            drawn.points[i].place = Point::new(p.x, p.y, p.z);
            drawn.is_outlier[i] = true;
        }
    }
}
