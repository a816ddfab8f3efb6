//! AVX2 in place: gathers of eight voxels, and runs of four.

use std::arch::x86_64::*;

use super::super::points::{self, UNIT};
use super::super::walk::BITS;
use super::*;

/// Along one axis: the bricks' steps, and the row's offsets.
struct Axis {
    lanes: __m256i,
    last_cell: __m256i,
    shift: __m128i,
    inner: __m256i,
    /// What a brick's border adds: `outer - side * inner`.
    jump: __m256i,
    low_bits: __m256i,
}

/// The terms of a voxel and of the next one, and the weight of the next.
struct Pair {
    near: __m256i,
    far: __m256i,
    weight: __m256,
}

impl Axis {
    #[target_feature(enable = "avx2")]
    fn new(cell: &Cell<'_>, lanes: &[[i32; LANES]; 3], a: usize) -> Self {
        let Steps {
            log2_side,
            outer,
            inner,
        } = cell.steps[a];
        let side = 1_u32 << log2_side;
        let offsets = lanes[a];
        let [l0, l1, l2, l3, l4, l5, l6, l7] = offsets;
        Self {
            lanes: _mm256_setr_epi32(l0, l1, l2, l3, l4, l5, l6, l7),
            last_cell: _mm256_set1_epi32(cell.last_cell[a]),
            shift: _mm_cvtsi32_si128(log2_side as i32),
            inner: _mm256_set1_epi32(inner as i32),
            jump: _mm256_set1_epi32(outer.wrapping_sub(side * inner) as i32),
            low_bits: _mm256_set1_epi32(side as i32 - 1),
        }
    }

    /// Voxel numbers and 24-bit fractions of a block.
    #[target_feature(enable = "avx2")]
    fn place(&self, whole: i32, part: i32) -> (__m256i, __m256i) {
        let moved = _mm256_add_epi32(_mm256_set1_epi32(part), self.lanes);
        let voxel = _mm256_add_epi32(_mm256_srai_epi32::<{ BITS as i32 }>(moved), _mm256_set1_epi32(whole));
        (voxel, _mm256_and_si256(moved, _mm256_set1_epi32((1 << BITS) - 1)))
    }

    #[target_feature(enable = "avx2")]
    fn term(&self, voxel: __m256i) -> __m256i {
        let brick = _mm256_srl_epi32(voxel, self.shift);
        _mm256_add_epi32(
            _mm256_mullo_epi32(voxel, self.inner),
            _mm256_mullo_epi32(brick, self.jump),
        )
    }

    #[target_feature(enable = "avx2")]
    fn pair(&self, whole: i32, part: i32) -> Pair {
        let (voxel, fraction) = self.place(whole, part);
        let voxel = _mm256_max_epi32(_mm256_setzero_si256(), _mm256_min_epi32(voxel, self.last_cell));
        let near = self.term(voxel);
        // The next voxel is one inner step on, or at a brick's border the jump as well.
        let border = _mm256_cmpeq_epi32(_mm256_and_si256(voxel, self.low_bits), self.low_bits);
        let far = _mm256_add_epi32(_mm256_add_epi32(near, self.inner), _mm256_and_si256(border, self.jump));
        let weight = _mm256_mul_ps(_mm256_cvtepi32_ps(fraction), _mm256_set1_ps(UNIT));
        Pair { near, far, weight }
    }
}

/// Values at eight offsets, each below `voxels.len() - 1`, times 65536.
#[target_feature(enable = "avx2")]
fn gather(voxels: &[i16], offsets: __m256i) -> __m256 {
    // SAFETY: the caller's offsets are at least 0 and below `len - 1`, so that the four bytes from twice the offset on
    // lie within the slice. The value is the lower half; above it comes its neighbour, which is shifted out.
    let words = unsafe { _mm256_i32gather_epi32::<2>(voxels.as_ptr().cast(), offsets) };
    _mm256_cvtepi32_ps(_mm256_slli_epi32::<16>(words))
}

#[target_feature(enable = "avx2")]
fn mix(a: __m256, b: __m256, w: __m256) -> __m256 {
    _mm256_add_ps(a, _mm256_mul_ps(_mm256_sub_ps(b, a), w))
}

/// Whether an offset reaches the last value of the slice.
#[target_feature(enable = "avx2")]
fn touches_end(voxels: &[i16], offsets: __m256i) -> bool {
    // A gather reads four bytes: at the last value two of them would lie beyond the slice.
    let limit = _mm256_set1_epi32(voxels.len() as i32 - 2);
    _mm256_movemask_epi8(_mm256_cmpgt_epi32(offsets, limit)) != 0
}

#[target_feature(enable = "avx2")]
pub(super) fn linear(cell: &Cell<'_>, walk: &Walk, first: usize, line: &mut [f32], exact: &Source<'_, i16>) {
    let Some(lanes) = &walk.lanes else { return };
    let axes: [Axis; 3] = [
        Axis::new(cell, lanes, 0),
        Axis::new(cell, lanes, 1),
        Axis::new(cell, lanes, 2),
    ];
    let (blocks, _) = line.as_chunks_mut::<LANES>();
    for (b, block) in (first..).zip(blocks) {
        let spot = walk.block(b);
        let x = axes[0].pair(spot.whole[0], spot.part[0]);
        let y = axes[1].pair(spot.whole[1], spot.part[1]);
        let z = axes[2].pair(spot.whole[2], spot.part[2]);
        let rows = [
            _mm256_add_epi32(y.near, z.near),
            _mm256_add_epi32(y.far, z.near),
            _mm256_add_epi32(y.near, z.far),
            _mm256_add_epi32(y.far, z.far),
        ];
        // Offsets grow along every axis: the far corner has the largest.
        if touches_end(cell.voxels, _mm256_add_epi32(x.far, rows[3])) {
            for (k, value) in block.iter_mut().enumerate() {
                *value = points::linear(exact, &walk.at(b * LANES + k));
            }
            continue;
        }
        let edge = |row: __m256i| {
            mix(
                gather(cell.voxels, _mm256_add_epi32(x.near, row)),
                gather(cell.voxels, _mm256_add_epi32(x.far, row)),
                x.weight,
            )
        };
        let near = mix(edge(rows[0]), edge(rows[1]), y.weight);
        let far = mix(edge(rows[2]), edge(rows[3]), y.weight);
        // Powers of two change no rounding: the shift by 16 bits in `gather` is undone once, at the end.
        let hu = _mm256_mul_ps(mix(near, far, z.weight), _mm256_set1_ps(1.0 / 65536.0));
        // SAFETY: the block has eight places.
        unsafe { _mm256_storeu_ps(block.as_mut_ptr(), hu) };
    }
}

#[target_feature(enable = "avx2")]
pub(super) fn nearest(cell: &Cell<'_>, walk: &Walk, first: usize, line: &mut [f32], exact: &Source<'_, i16>) {
    let Some(lanes) = &walk.lanes else { return };
    let axes: [Axis; 3] = [
        Axis::new(cell, lanes, 0),
        Axis::new(cell, lanes, 1),
        Axis::new(cell, lanes, 2),
    ];
    let (blocks, _) = line.as_chunks_mut::<LANES>();
    for (b, block) in (first..).zip(blocks) {
        let spot = walk.block(b);
        let mut offset = _mm256_setzero_si256();
        for (a, axis) in axes.iter().enumerate() {
            let (voxel, fraction) = axis.place(spot.whole[a], spot.part[a]);
            let voxel = _mm256_add_epi32(voxel, _mm256_srli_epi32::<{ BITS as i32 - 1 }>(fraction));
            let last = _mm256_add_epi32(axis.last_cell, _mm256_set1_epi32(1));
            // Blocks lie in the interior, so that this changes nothing drawn: it makes the read safe whatever the
            // positions.
            let voxel = _mm256_max_epi32(_mm256_setzero_si256(), _mm256_min_epi32(voxel, last));
            offset = _mm256_add_epi32(offset, axis.term(voxel));
        }
        if touches_end(cell.voxels, offset) {
            for (k, value) in block.iter_mut().enumerate() {
                *value = points::nearest(exact, &walk.at(b * LANES + k));
            }
            continue;
        }
        let hu = _mm256_mul_ps(gather(cell.voxels, offset), _mm256_set1_ps(1.0 / 65536.0));
        // SAFETY: the block has eight places.
        unsafe { _mm256_storeu_ps(block.as_mut_ptr(), hu) };
    }
}

/// Picks four values from a place on out of eight.
const PICK: [[i32; LANES]; RUN] = [
    [0, 1, 2, 3, 0, 0, 0, 0],
    [1, 2, 3, 4, 0, 0, 0, 0],
    [2, 3, 4, 5, 0, 0, 0, 0],
    [3, 4, 5, 6, 0, 0, 0, 0],
];

/// Four values from each of two places, of which four are there.
#[target_feature(enable = "avx2")]
unsafe fn two_runs<V: Run>(values: &[V], a: usize, b: usize) -> __m256 {
    // SAFETY: the caller's places have four values each.
    unsafe {
        let (a, b) = (values.as_ptr().add(a), values.as_ptr().add(b));
        if V::IS_SHORT {
            let shorts = _mm_unpacklo_epi64(_mm_loadl_epi64(a.cast()), _mm_loadl_epi64(b.cast()));
            _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(shorts))
        } else {
            _mm256_loadu2_m128(b.cast(), a.cast())
        }
    }
}

#[target_feature(enable = "avx2")]
pub(super) fn runs<V: Run>(
    runs: &Runs<'_, V>,
    walk: &Walk,
    columns: Range<usize>,
    line: &mut [f32],
    weights: impl Fn([i32; 3]) -> [[f32; RUN]; 3],
) {
    walk.each(columns, line, |spot| {
        let w = weights(spot.part);
        let Some(p) = runs.places(&spot) else {
            return points::convolved(&runs.source, &spot, &w);
        };
        let mut sums = _mm256_setzero_ps();
        for (z, weight_z) in p.z.iter().zip(w[2]) {
            let mut layer = _mm256_setzero_ps();
            for (y, weight_y) in p.y.iter().zip(w[1]) {
                // SAFETY: `Places` has checked every sum of its terms.
                let run = unsafe { two_runs(runs.source.values, p.x[0] + y + z, p.x[1] + y + z) };
                layer = _mm256_add_ps(layer, _mm256_mul_ps(_mm256_set1_ps(weight_y), run));
            }
            sums = _mm256_add_ps(sums, _mm256_mul_ps(_mm256_set1_ps(weight_z), layer));
        }
        // SAFETY: a row of the table has eight places.
        let pick = unsafe { _mm256_loadu_si256(PICK[p.skip].as_ptr().cast()) };
        let four = _mm256_castps256_ps128(_mm256_permutevar8x32_ps(sums, pick));
        let mut products = [0.0; RUN];
        // SAFETY: both have four places.
        unsafe {
            let four = _mm_mul_ps(_mm_loadu_ps(w[0].as_ptr()), four);
            _mm_storeu_ps(products.as_mut_ptr(), four);
        }
        // One after the other, in the order of `convolved`: pairwise sums would round differently.
        products.iter().fold(0.0, |sum, product| sum + product)
    });
}
