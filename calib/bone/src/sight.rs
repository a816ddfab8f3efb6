//! Where cortex is seen: the bone's own surface, and what may be a vessel with contrast medium beside it.
//!
//! Each place has a gain, by how much cortex explains its voxels better than a layer of contrast medium does ([`crate::contrast`]). That of one place is noise where
//! cortex is thin, so the middle one of those around it counts.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use crate::contrast::Contrast;
use crate::islands::pieces;
use crate::place::{Place, Sight, State};
use crate::quadric::Adjacent;

/// Cortex is seen where it explains the voxels better by so much.
const SEEN: f64 = 0.5;
/// There is none where contrast medium explains them better, on a piece of at least so many mm^2.
const BARE: f64 = 0.0;
const LEAST_MM2: f64 = 100.0;
/// And where that is thicker than any cortex is so weak, mm.
const LEAST_MM: f64 = 5.0;

/// A piece of the surface that has no cortex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bare {
    /// Triangles.
    pub triangles: usize,
    /// Its area, mm^2.
    pub area_mm2: f64,
    /// Mean of its corners, mm (left, posterior, superior).
    pub centre_mm: [f64; 3],
    /// HU of the contrast medium behind its surface, the middle one of its corners.
    pub hu: f64,
}

/// What was judged of a whole surface.
pub(crate) struct Judged {
    pub(crate) bare: Vec<Bare>,
    /// Share of the fitted places without cortex that is seen.
    pub(crate) without_cortex: f64,
    /// Whether a person wants what has no cortex all the same.
    pub(crate) is_heard: bool,
}

/// Judges each corner by those within `reach_mm`; and tells of the pieces that have no cortex.
pub(crate) fn sights(
    states: &[State],
    triangles: &[[u32; 3]],
    adjacent: &Adjacent,
    reach_mm: f64,
) -> (Vec<Sight>, Vec<Bare>) {
    let place = |i: u32| states[i as usize].as_ref().ok();
    let corners: Vec<Vector3<f64>> = states
        .iter()
        .map(|s| s.as_ref().map_or_else(|_| Vector3::repeat(f64::NAN), |p| p.mm))
        .collect();
    let mut found = Vec::new();
    let mut middle = |i: usize| {
        place(i as u32)?;
        // Neighbours share voxels: within two of them nothing more is known, and beyond lies another place.
        adjacent.around(&corners, i, reach_mm, &mut found);
        let of = |gain: fn(&Contrast) -> f64| {
            ::fit::median(
                found
                    .iter()
                    .filter_map(|k| place(*k))
                    .map(|p| gain(&p.contrast))
                    .collect(),
            )
        };
        Some([of(|c| c.by_voxels), of(|c| c.by_all), of(|c| c.mm)])
    };
    let mut of: Vec<Sight> = (0..states.len()).map(|i| by(middle(i))).collect();
    let bare = told(&mut of, states, triangles);
    (of, bare)
}

/// By the middle gain by the voxels, by all that is known, and thickness of the contrast medium, mm.
fn by(gain: Option<[f64; 3]>) -> Sight {
    match gain {
        Some([_, all, _]) if all >= SEEN => Sight::Cortex,
        // That what is known of cortex is against it is not enough, nor that a thin layer fits: bone of a weak cortex would go.
        Some([voxels, all, mm]) if voxels < BARE && all < BARE && mm > LEAST_MM => Sight::Bare,
        Some(_) => Sight::Unseen,
        // It is lost for another reason, which is told.
        None => Sight::Cortex,
    }
}

/// The pieces without cortex, which hang together by edges; small ones are in doubt.
fn told(of: &mut [Sight], states: &[State], triangles: &[[u32; 3]]) -> Vec<Bare> {
    let place = |i: &u32| states[*i as usize].as_ref().ok();
    let is_bare = |i: &u32| of[*i as usize] == Sight::Bare;
    let is_of = |t: &&[u32; 3]| t.iter().all(|i| place(i).is_some()) && t.iter().any(is_bare);
    let bare: Vec<[u32; 3]> = triangles.iter().filter(is_of).copied().collect();
    let mut by_piece: BTreeMap<usize, Vec<[u32; 3]>> = BTreeMap::new();
    for (triangle, piece) in bare.iter().zip(pieces(&bare)) {
        by_piece.entry(piece).or_default().push(*triangle);
    }
    // Small pieces are what noise leaves of a thin cortex.
    let (mut large, mut told) = (vec![false; of.len()], Vec::new());
    for piece in by_piece.values() {
        let corners: BTreeSet<u32> = piece.iter().flatten().copied().filter(is_bare).collect();
        let places: Vec<&Place> = corners.iter().filter_map(place).collect();
        let area = piece
            .iter()
            .map(|t| area(t.map(|i| place(&i).map_or_else(Vector3::zeros, |p| p.mm))))
            .sum();
        if area < LEAST_MM2 {
            continue;
        }
        corners.iter().for_each(|i| large[*i as usize] = true);
        let middle: Vector3<f64> = places.iter().map(|p| p.mm).sum::<Vector3<f64>>() / places.len().max(1) as f64;
        told.push(Bare {
            triangles: piece.len(),
            area_mm2: area,
            centre_mm: middle.into(),
            hu: ::fit::median(places.iter().map(|p| p.contrast.hu).collect()),
        });
    }
    for (sight, _) in of
        .iter_mut()
        .zip(large)
        .filter(|(sight, is_large)| **sight == Sight::Bare && !is_large)
    {
        *sight = Sight::Unseen;
    }
    told.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
    told
}

fn area([a, b, c]: [Vector3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}
