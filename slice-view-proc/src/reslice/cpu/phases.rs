//! Weights of a windowed sinc from a table.
//!
//! 4096 phases of a voxel with straight lines between them: the weights' second derivative is below pi^2 in magnitude, so
//! they are off by at most pi^2 / 8 / 4096^2 = 7.4e-8, about one rounding of an f32 weight.

use scene::Filter;

use super::super::weights::weights;
use super::points::UNIT;
use super::walk::BITS;

// Half as many phases would have four times the error: five roundings of a weight.
const LOG2_PHASES: u32 = 12;

/// The weights of a filter with `N` taps at each phase.
#[derive(Debug, Clone)]
pub(super) struct Phases<const N: usize>(Vec<[f32; N]>);

impl<const N: usize> Phases<N> {
    pub(super) fn new(filter: Filter) -> Self {
        let phase = |i: u32| {
            let w = weights(filter, f64::from(i) / f64::from(1_u32 << LOG2_PHASES));
            std::array::from_fn(|k| w[k] as f32)
        };
        let mut phases: Vec<[f32; N]> = (0..1 << LOG2_PHASES).map(phase).collect();
        // At fraction 1 the taps stand one voxel further.
        let first = phases[0];
        phases.push(std::array::from_fn(|k| if k == 0 { 0.0 } else { first[k - 1] }));
        Self(phases)
    }

    /// The weights at a fraction.
    #[inline(always)]
    pub(super) fn at(&self, part: i32) -> [f32; N] {
        let phase = (part >> (BITS - LOG2_PHASES)) as usize;
        let between = (part & ((1 << (BITS - LOG2_PHASES)) - 1)) as f32 * (UNIT * (1 << LOG2_PHASES) as f32);
        let (low, high) = (&self.0[phase], &self.0[phase + 1]);
        std::array::from_fn(|k| low[k] + (high[k] - low[k]) * between)
    }
}
