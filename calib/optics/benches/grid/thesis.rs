//! The thesis's own way: its criterion with radii from the truth (5.3, 5.4), and the two directions of the grid.

use nalgebra::{Matrix3, Vector2, Vector3};
use optics::disc::{Chi, Probe};
use optics::grid::{Candidate, Lines, angular_correlation, principal_angles, signature};
use optics::image::Sums;

use crate::common::grid_series::{Drawn, PITCH, RADIUS, SIDE};

/// Directions count as found to so many degrees, at the grid's middle.
const NEAR_DEG: f64 = 5.0;
/// The most candidates that directions are looked for in.
const MOST: usize = 600;

pub(crate) struct Counted {
    /// Candidates, false ones, missed ones of 100.
    pub(crate) counts: [usize; 3],
    /// Whether the signature, and the angular correlation, gave both directions.
    pub(crate) directions: [bool; 2],
}

/// What the thesis's way makes of an image.
pub(crate) fn counted(drawn: &Drawn) -> Counted {
    let candidates = candidates(drawn);
    let near = (0.45 * drawn.least_pitch).max(1.5);
    let missed = drawn
        .centres
        .iter()
        .filter(|c| candidates.iter().all(|d| (d.at - **c).norm() > near));
    let missed = missed.count();
    let some = &candidates[..candidates.len().min(MOST)];
    let by_signature = principal_angles(&signature(some));
    let by_correlation = angular_correlation(some).map(|l: [Lines; 2]| l.map(|l| l.angle));
    Counted {
        counts: [
            candidates.len(),
            (candidates.len() + missed).saturating_sub(100),
            missed,
        ],
        directions: [by_signature, by_correlation].map(|a| a.is_some_and(|a| are_right(drawn, a))),
    }
}

/// 5.4: the criterion above its mean and five deviations, and the greatest within rmin; strongest first.
fn candidates(drawn: &Drawn) -> Vec<Candidate> {
    let [rmin, rmax] = radii(drawn);
    let (sums, probe) = (Sums::new(&drawn.image), Probe::new(rmin, rmax, 2.0).unwrap());
    let at = |i: usize| probe.at(&sums, i % SIDE, i / SIDE).map_or(0.0, |c: Chi| c.value.abs());
    let map: Vec<f64> = (0..SIDE * SIDE).map(at).collect();
    let n = map.len() as f64;
    let mean = map.iter().sum::<f64>() / n;
    let deviation = (map.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    let threshold = mean + 5.0 * deviation;
    let greatest = |i: usize| {
        let (x, y, r) = ((i % SIDE) as i32, (i / SIDE) as i32, rmin.ceil() as i32);
        (-r..=r).all(|dy| {
            (-r..=r).all(|dx| {
                let inside = f64::from(dx * dx + dy * dy) < rmin * rmin;
                let on = (0..SIDE as i32).contains(&(x + dx)) && (0..SIDE as i32).contains(&(y + dy));
                !inside || !on || map[((y + dy) * SIDE as i32 + x + dx) as usize] <= map[i]
            })
        })
    };
    let chosen = (0..map.len()).filter(|i| map[*i] > threshold && greatest(*i));
    let mut out: Vec<Candidate> = chosen
        .map(|i| Candidate {
            at: Vector2::new((i % SIDE) as f64, (i / SIDE) as f64),
            chi: map[i],
        })
        .collect();
    out.sort_by(|a, b| b.chi.total_cmp(&a.chi));
    out
}

fn moved(h: &Matrix3<f64>, x: f64, y: f64) -> Vector2<f64> {
    let q = h * Vector3::new(x, y, 1.0);
    Vector2::new(q.x / q.z, q.y / q.z)
}

/// rmin and rmax from the discs' true semi-axes at the middle: three quarters of the short one, the long one and a pixel.
fn radii(drawn: &Drawn) -> [f64; 2] {
    let middle = moved(&drawn.px_from_mm, 0.0, 0.0);
    let points = (0..64).map(|k| {
        let (s, c) = (f64::from(k) * std::f64::consts::TAU / 64.0).sin_cos();
        (moved(&drawn.px_from_mm, RADIUS * c, RADIUS * s) - middle).norm()
    });
    let [short, long] = points.fold([f64::MAX, 0.0], |[a, b], d| [d.min(a), d.max(b)]);
    [(0.75 * short).floor().max(1.0), (long + 1.0).ceil()]
}

/// Whether two angles are those of the grid's columns and rows at its middle.
fn are_right(drawn: &Drawn, angles: [f64; 2]) -> bool {
    let step = |x: f64, y: f64| {
        let d = moved(&drawn.px_from_mm, x, y) - moved(&drawn.px_from_mm, -x, -y);
        d.y.atan2(d.x)
    };
    let truth = [step(0.5 * PITCH, 0.0), step(0.0, 0.5 * PITCH)];
    let apart = |a: f64, b: f64| {
        let d = (a - b).to_degrees().rem_euclid(180.0);
        d.min(180.0 - d)
    };
    let both = |p: f64, q: f64| apart(p, truth[0]) < NEAR_DEG && apart(q, truth[1]) < NEAR_DEG;
    both(angles[0], angles[1]) || both(angles[1], angles[0])
}
