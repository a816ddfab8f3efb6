//! Touched points that were left out and lie a little off the bone, all of them: soft tissue under the tip in places, or a pose that lies
//! between the bone and that tissue.
//!
//! A pose to which two fifths of the points do not belong may fit the rest as well as the true one. What tells it is where those lie: a gross
//! error of a pointer (lifted, or its marker half hidden) may have any size, and a third of them at most is that small.

use super::parts::{Class, PointResult};
use super::trend::deviations_of_count;
use crate::points::Cloud;

/// A second surface among the points that were left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondSurface {
    /// Touched points that were left out.
    pub left_out: usize,
    /// Those of them that lie near the bone.
    pub points: usize,
    /// How near that is, mm.
    pub within_mm: f64,
    /// Mean of their distances, mm.
    pub mm: f64,
    /// How unlikely so many are by chance alone, as deviations of a normal number.
    pub deviations: f64,
}

/// Soft tissue under a tip is that thick at most; what lies further off is told from bone by other limits, mm.
const NEAR_MM: f64 = 5.0;
/// The greatest share of gross errors that happen to be so small.
const BY_CHANCE: f64 = 1.0 / 3.0;

/// Looks for it; `None` where none of them is near.
pub(super) fn second(cloud: &Cloud, each: &[PointResult]) -> Option<SecondSurface> {
    // why: echoes of an ultrasound probe often lie shortly before the bone, of a right pose too.
    let is_touched_out = |(i, point): &(usize, &PointResult)| {
        cloud.beams[*i].norm_squared() == 0.0 && matches!(point.class, Class::InFront | Class::Behind)
    };
    let out: Vec<f64> = each
        .iter()
        .enumerate()
        .filter(is_touched_out)
        .map(|(_, point)| point.residual_mm.abs())
        .collect();
    let near: Vec<f64> = out.iter().copied().filter(|mm| *mm < NEAR_MM).collect();
    (!near.is_empty()).then(|| SecondSurface {
        left_out: out.len(),
        points: near.len(),
        within_mm: NEAR_MM,
        mm: near.iter().sum::<f64>() / near.len() as f64,
        deviations: deviations_of_count(near.len(), out.len(), BY_CHANCE),
    })
}
