//! AVX2 along a row: eight columns from eight neighbouring values and a permutation, once for each tap.

use std::arch::x86_64::*;

use super::super::aligned::Columns;
use super::super::walk::LANES;

/// [`Columns::draw`] where no column is further behind than a block is long.
#[target_feature(enable = "avx2")]
pub(super) fn along<const N: usize>(columns: &Columns, values: &[f32], line: &mut [f32]) {
    let (behind, _) = columns.behind.as_chunks::<LANES>();
    let (weights, _) = columns.weights.as_chunks::<LANES>();
    for (b, (first, behind)) in columns.blocks.iter().zip(behind).enumerate() {
        // SAFETY: there are eight numbers.
        let behind = unsafe { _mm256_loadu_si256(behind.as_ptr().cast()) };
        let mut sum = _mm256_setzero_ps();
        for k in 0..N {
            let near = &values[*first as usize + k..][..LANES];
            let weights = &weights[k * columns.blocks.len() + b];
            // SAFETY: there are eight of each.
            let (near, weights) = unsafe { (_mm256_loadu_ps(near.as_ptr()), _mm256_loadu_ps(weights.as_ptr())) };
            // The portable code's order: a product and a sum for each tap, from zero on.
            let taken = _mm256_permutevar8x32_ps(near, behind);
            sum = _mm256_add_ps(sum, _mm256_mul_ps(weights, taken));
        }
        let pixels = &mut line[b * LANES..];
        match pixels.first_chunk_mut::<LANES>() {
            // SAFETY: there are eight places.
            Some(pixels) => unsafe { _mm256_storeu_ps(pixels.as_mut_ptr(), sum) },
            None => {
                let mut all = [0.0; LANES];
                // SAFETY: the same.
                unsafe { _mm256_storeu_ps(all.as_mut_ptr(), sum) };
                pixels.copy_from_slice(&all[..pixels.len()]);
            }
        }
    }
}
