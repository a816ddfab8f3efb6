//! AVX2 on patches: neighbours along x lie side by side, and no voxel needs a table.
//!
//! The operations are those of `points`, in the same order.

use std::arch::x86_64::*;
use std::ops::Range;

use super::super::patch::Patch;
use super::super::points::{UNIT, Weights};
use super::super::source::Value;
use super::super::walk::{BITS, LANES, Spot, Walk};

const TAPS: usize = 4;

/// What a row of points through a patch is read with.
struct Steps {
    lanes: [__m256i; 3],
    first: [i32; 3],
    row: usize,
    layer: usize,
    /// Row in the lower half of each number, layer in the upper.
    both: __m256i,
    /// The last offset that a point's first tap may have.
    last: __m256i,
}

impl Steps {
    /// `None` where the patch is smaller than one point's taps, or the walk has no blocks.
    #[target_feature(enable = "avx2")]
    fn new<P: Value + Default>(patch: &Patch<P>, walk: &Walk, taps: usize) -> Option<Self> {
        let [row, layer] = patch.steps();
        let span = (taps - 1) * (layer + row + 1) + 1;
        let last = i32::try_from(patch.values().len().checked_sub(span)?).ok()?;
        // The product of pairs below takes 16-bit factors with a sign.
        let both = i32::from(i16::try_from(row).ok()?) | i32::from(i16::try_from(layer).ok()?) << 16;
        let [x, y, z] = walk.lanes.as_ref()?;
        // SAFETY: each has eight places.
        let lanes = unsafe { [load(x), load(y), load(z)] };
        Some(Self {
            lanes,
            first: patch.first(),
            row,
            layer,
            both: _mm256_set1_epi32(both),
            last: _mm256_set1_epi32(last),
        })
    }

    /// Offsets of the first of a block's taps, which begin `before` voxels before the point, and 24-bit fractions.
    #[target_feature(enable = "avx2")]
    fn block(&self, spot: &Spot, before: i32) -> (__m256i, [__m256i; 3]) {
        let [x, y, z] = [
            _mm256_add_epi32(_mm256_set1_epi32(spot.part[0]), self.lanes[0]),
            _mm256_add_epi32(_mm256_set1_epi32(spot.part[1]), self.lanes[1]),
            _mm256_add_epi32(_mm256_set1_epi32(spot.part[2]), self.lanes[2]),
        ];
        let whole = |a: usize| spot.whole[a] - before - self.first[a];
        let start = whole(0) + whole(1) * self.row as i32 + whole(2) * self.layer as i32;
        // Whole voxels on: those along y in the lower halves, those along z in the upper.
        let on = _mm256_blend_epi16::<0b1010_1010>(
            _mm256_srai_epi32::<{ BITS as i32 }>(y),
            _mm256_srai_epi32::<{ BITS as i32 - 16 }>(z),
        );
        let on = _mm256_add_epi32(
            _mm256_madd_epi16(on, self.both),
            _mm256_srai_epi32::<{ BITS as i32 }>(x),
        );
        // Without a sign a negative offset is a large one: both kinds are held back, and belong to columns that are
        // thrown away.
        let offsets = _mm256_min_epu32(_mm256_add_epi32(on, _mm256_set1_epi32(start)), self.last);
        let mask = _mm256_set1_epi32((1 << BITS) - 1);
        let parts = [
            _mm256_and_si256(x, mask),
            _mm256_and_si256(y, mask),
            _mm256_and_si256(z, mask),
        ];
        (offsets, parts)
    }
}

#[target_feature(enable = "avx2")]
unsafe fn load(numbers: &[i32; LANES]) -> __m256i {
    // SAFETY: there are eight places.
    unsafe { _mm256_loadu_si256(numbers.as_ptr().cast()) }
}

#[target_feature(enable = "avx2")]
fn weight(part: __m256i) -> __m256 {
    _mm256_mul_ps(_mm256_cvtepi32_ps(part), _mm256_set1_ps(UNIT))
}

#[target_feature(enable = "avx2")]
fn mix(a: __m256, b: __m256, w: __m256) -> __m256 {
    _mm256_add_ps(a, _mm256_mul_ps(_mm256_sub_ps(b, a), w))
}

/// Draws the blocks that `columns` are in; what lies beside these is thrown away.
#[target_feature(enable = "avx2")]
fn blocks(columns: Range<usize>, line: &mut [f32], mut draw: impl FnMut(usize) -> __m256) {
    for b in columns.start / LANES..columns.end.div_ceil(LANES) {
        let drawn = draw(b);
        let (from, to) = ((b * LANES).max(columns.start), (b * LANES + LANES).min(columns.end));
        let place = &mut line[from - columns.start..to - columns.start];
        if let Some(eight) = place.first_chunk_mut::<LANES>() {
            // SAFETY: the block has eight places.
            unsafe { _mm256_storeu_ps(eight.as_mut_ptr(), drawn) };
        } else {
            let mut all = [0.0; LANES];
            // SAFETY: the array has eight places.
            unsafe { _mm256_storeu_ps(all.as_mut_ptr(), drawn) };
            place.copy_from_slice(&all[from - b * LANES..to - b * LANES]);
        }
    }
}

/// [`super::super::points::linear`].
#[target_feature(enable = "avx2")]
pub(super) fn linear(patch: &Patch<i16>, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
    let Some(steps) = Steps::new(patch, walk, 2) else {
        return;
    };
    let row = _mm256_set1_epi32(steps.row as i32);
    let layer = _mm256_set1_epi32(steps.layer as i32);
    let values = patch.values();
    blocks(columns, line, |b| {
        let (at, [x, y, z]) = steps.block(&walk.block(b), 0);
        let (x, y, z) = (weight(x), weight(y), weight(z));
        let edge = |at: __m256i| {
            // SAFETY: `Steps` has limited the offsets: a row and a layer on there are two values, the four bytes read here.
            let pair = unsafe { _mm256_i32gather_epi32::<2>(values.as_ptr().cast(), at) };
            // Both times 65536.
            let near = _mm256_cvtepi32_ps(_mm256_slli_epi32::<16>(pair));
            let far = _mm256_cvtepi32_ps(_mm256_and_si256(pair, _mm256_set1_epi32(-65536)));
            mix(near, far, x)
        };
        let next = _mm256_add_epi32(at, layer);
        let near = mix(edge(at), edge(_mm256_add_epi32(at, row)), y);
        let far = mix(edge(next), edge(_mm256_add_epi32(next, row)), y);
        _mm256_mul_ps(mix(near, far, z), _mm256_set1_ps(1.0 / 65536.0))
    });
}

/// [`super::super::points::convolved`] with four taps.
#[target_feature(enable = "avx2")]
pub(super) fn four_taps<W: Weights>(patch: &Patch<f32>, walk: &Walk, columns: Range<usize>, line: &mut [f32]) {
    let Some(steps) = Steps::new(patch, walk, TAPS) else {
        return;
    };
    let values = patch.values();
    blocks(columns, line, |b| {
        let (at, parts) = steps.block(&walk.block(b), 1);
        let (mut offsets, mut fractions) = ([0_u32; LANES], [[0.0; LANES]; 3]);
        // SAFETY: all arrays have eight places.
        unsafe {
            _mm256_storeu_si256(offsets.as_mut_ptr().cast(), at);
            _mm256_storeu_ps(fractions[0].as_mut_ptr(), weight(parts[0]));
            _mm256_storeu_ps(fractions[1].as_mut_ptr(), weight(parts[1]));
            _mm256_storeu_ps(fractions[2].as_mut_ptr(), weight(parts[2]));
        }
        let [x, y, z] = fractions;
        let (x, y, z) = (all(&W::lanes(x)), all(&W::lanes(y)), all(&W::lanes(z)));
        // From one weight of eight points to four weights of a point, in both halves.
        let x = turned(x);
        let mut products = [_mm256_setzero_ps(); TAPS];
        for i in 0..TAPS {
            // Points i and i + 4 together.
            let [near, far] = [offsets[i] as usize, offsets[i + TAPS] as usize];
            let lane = _mm256_set1_epi32(i as i32);
            let y = of_lane(&y, lane);
            let z = of_lane(&z, lane);
            let mut sums = _mm256_setzero_ps();
            for (k, z) in z.iter().enumerate() {
                let mut sum = _mm256_setzero_ps();
                for (j, y) in y.iter().enumerate() {
                    let on = k * steps.layer + j * steps.row;
                    // SAFETY: `Steps` has limited the offsets: three layers and three rows on there are four values.
                    let run =
                        unsafe { _mm256_loadu2_m128(values.as_ptr().add(far + on), values.as_ptr().add(near + on)) };
                    sum = _mm256_add_ps(sum, _mm256_mul_ps(*y, run));
                }
                sums = _mm256_add_ps(sums, _mm256_mul_ps(*z, sum));
            }
            products[i] = _mm256_mul_ps(x[i], sums);
        }
        let [a, b, c, d] = turned(products);
        let zero = _mm256_setzero_ps();
        _mm256_add_ps(_mm256_add_ps(_mm256_add_ps(_mm256_add_ps(zero, a), b), c), d)
    });
}

#[target_feature(enable = "avx2")]
fn all(weights: &[[f32; LANES]; TAPS]) -> [__m256; TAPS] {
    let [a, b, c, d] = weights;
    // SAFETY: each has eight places.
    unsafe {
        [
            _mm256_loadu_ps(a.as_ptr()),
            _mm256_loadu_ps(b.as_ptr()),
            _mm256_loadu_ps(c.as_ptr()),
            _mm256_loadu_ps(d.as_ptr()),
        ]
    }
}

/// In both halves, one number four times.
#[target_feature(enable = "avx2")]
fn of_lane(weights: &[__m256; TAPS], lane: __m256i) -> [__m256; TAPS] {
    let [a, b, c, d] = *weights;
    [
        _mm256_permutevar_ps(a, lane),
        _mm256_permutevar_ps(b, lane),
        _mm256_permutevar_ps(c, lane),
        _mm256_permutevar_ps(d, lane),
    ]
}

/// In both halves, four by four, rows and columns exchanged.
#[target_feature(enable = "avx2")]
fn turned([a, b, c, d]: [__m256; TAPS]) -> [__m256; TAPS] {
    let (ab, ab_high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
    let (cd, cd_high) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
    [
        _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
        _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
        _mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
        _mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
    ]
}
