//! AVX2 across a plane: four voxels at a time, side by side or a row of a brick apart.
//!
//! Sums begin at zero and go over the layers in order, as in the portable code.

use std::arch::x86_64::*;

use super::super::aligned::QUAD;
use super::super::runs::Run;

/// Values read at once where they are a row of a brick apart.
const SPREAD: usize = 16;

/// [`super::Vector::across`].
#[target_feature(enable = "avx2")]
pub(super) fn across<V: Run, const N: usize, const STEP: usize>(
    values: &[V],
    (weights, layers): ([f32; N], [usize; N]),
    terms: &[u32],
    sums: &mut [f32],
    mut rest: impl FnMut(usize, &mut [f32]),
) {
    let (deepest, span) = (
        layers.into_iter().fold(0, usize::max),
        if STEP == 1 { QUAD } else { SPREAD },
    );
    // Every read from a term below this lies within the values; a term that marks no place is above.
    let end = (values.len() + 1).saturating_sub(deepest + span);
    let weights = weights.map(|weight| _mm_set1_ps(weight));
    for (i, term) in terms.iter().enumerate() {
        let at = *term as usize;
        if at >= end {
            rest(i, sums);
            continue;
        }
        let mut sum = _mm_setzero_ps();
        for (weight, layer) in weights.iter().zip(layers) {
            // SAFETY: at < end, so that at + layer + span is at most the number of values.
            let read = unsafe { quad::<V, STEP>(values.as_ptr().add(at + layer)) };
            sum = _mm_add_ps(sum, _mm_mul_ps(*weight, read));
        }
        store(sum, &mut sums[i * QUAD..]);
    }
}

#[target_feature(enable = "avx2")]
fn store(four: __m128, places: &mut [f32]) {
    let places = &mut places[..QUAD];
    // SAFETY: there are four places.
    unsafe { _mm_storeu_ps(places.as_mut_ptr(), four) };
}

/// Four values from `first` on.
///
/// # Safety
/// There must be 4 values, or 16 where the step is not 1.
#[target_feature(enable = "avx2")]
unsafe fn quad<V: Run, const STEP: usize>(first: *const V) -> __m128 {
    // SAFETY: the caller's; a value is an i16 or an f32, as `IS_SHORT` says.
    unsafe {
        match (V::IS_SHORT, STEP) {
            (true, 1) => _mm_cvtepi32_ps(_mm_cvtepi16_epi32(_mm_loadl_epi64(first.cast()))),
            (true, _) => {
                // Values four apart lie in every second pair of shorts.
                let even = _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6);
                let halves = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(first.cast()), even);
                // Up and down by 16 bits: only the lower half, with its sign.
                let firsts = _mm_slli_epi32::<16>(_mm256_castsi256_si128(halves));
                _mm_cvtepi32_ps(_mm_srai_epi32::<16>(firsts))
            }
            (false, 1) => _mm_loadu_ps(first.cast()),
            (false, _) => {
                let first: *const f32 = first.cast();
                _mm_setr_ps(*first, *first.add(4), *first.add(8), *first.add(12))
            }
        }
    }
}
