//! Solids in three dimensions against closed forms.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod block;
mod closed;
mod common;
mod contact;
mod determinant;
mod error;
mod extremes;
mod frames;
mod global;
mod labels;
mod locking;
mod manufactured;
mod meshes;
mod particles;
mod push;
mod refusals;
mod rules;
mod scales;
mod sphere;
mod stretched;
mod sums;
mod terms;

/// A number in `[0, 1)` from a state: the same ones in every run.
fn random(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// Seconds of this thread's processor.
pub(crate) fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
