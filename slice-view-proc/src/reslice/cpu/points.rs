//! The filters at one point, in f32, in portable code.
//!
//! No product is fused with a sum, and sums have a fixed order: the same bits on every machine. The vector code beside
//! this file does the same operations in the same order and is tested to give the same bits.

use super::source::{Source, Value};
use super::walk::{BITS, Spot};

/// 2^-24: from a fraction to a weight.
pub(super) const UNIT: f32 = 1.0 / (1 << BITS) as f32;

#[inline(always)]
fn fraction(spot: &Spot) -> [f32; 3] {
    spot.part.map(|part| part as f32 * UNIT)
}

/// The nearest voxel; in the middle between two, the later one.
#[inline(always)]
pub(super) fn nearest<V: Value>(source: &Source<'_, V>, spot: &Spot) -> f32 {
    let [x, y, z] = std::array::from_fn(|a| {
        let up = spot.part[a] >> (BITS - 1);
        source.terms::<1>(a, spot.whole[a] + up)[0]
    });
    source.values[x + y + z].hu()
}

/// Seven nested `a + (b - a) w`: along x, then y, then z.
#[inline(always)]
pub(super) fn linear<V: Value>(source: &Source<'_, V>, spot: &Spot) -> f32 {
    let [wx, wy, wz] = fraction(spot);
    let [x, y, z]: [[usize; 2]; 3] = std::array::from_fn(|a| source.terms(a, spot.whole[a]));
    let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
    let value = |o: usize| source.values[o].hu();
    let edge = |yz: usize| mix(value(x[0] + yz), value(x[1] + yz), wx);
    let near = mix(edge(y[0] + z[0]), edge(y[1] + z[0]), wy);
    let far = mix(edge(y[0] + z[1]), edge(y[1] + z[1]), wy);
    mix(near, far, wz)
}

/// A product of `N` weights an axis: sums along y, then z, then x.
#[inline(always)]
pub(super) fn convolved<const N: usize, V: Value>(source: &Source<'_, V>, spot: &Spot, w: &[[f32; N]; 3]) -> f32 {
    let first = 1 - N as i32 / 2;
    let [x, y, z]: [[usize; N]; 3] = std::array::from_fn(|a| source.terms(a, spot.whole[a] + first));
    // In rows, or within a brick: one slice then needs one check of its bounds.
    let in_one_piece = x[N - 1] == x[0] + N - 1;
    let mut sums = [0.0; N];
    for k in 0..N {
        let mut layer = [0.0; N];
        for j in 0..N {
            let offset = y[j] + z[k];
            let run: [f32; N] = if in_one_piece {
                let run = &source.values[x[0] + offset..][..N];
                std::array::from_fn(|i| run[i].hu())
            } else {
                std::array::from_fn(|i| source.values[x[i] + offset].hu())
            };
            for i in 0..N {
                layer[i] += w[1][j] * run[i];
            }
        }
        for i in 0..N {
            sums[i] += w[2][k] * layer[i];
        }
    }
    let mut sum = 0.0;
    for i in 0..N {
        // Along x last: until then a sum is as wide as a run of voxels, which vector code adds up at once.
        sum += w[0][i] * sums[i];
    }
    sum
}

/// The weights of a filter with four taps, as in the reference.
pub(super) trait Weights {
    /// At several fractions, all first weights first.
    fn lanes<const M: usize>(t: [f32; M]) -> [[f32; M]; 4];

    /// At several fractions.
    #[inline(always)]
    fn at<const M: usize>(parts: [i32; M]) -> [[f32; 4]; M] {
        let weights = Self::lanes(parts.map(|part| part as f32 * UNIT));
        lanes(|a| weights.map(|weight| weight[a]))
    }
}

/// Catmull-Rom.
pub(super) struct CatmullRom;

impl Weights for CatmullRom {
    #[inline(always)]
    fn lanes<const M: usize>(t: [f32; M]) -> [[f32; M]; 4] {
        let s = t.map(|t| 1.0 - t);
        [
            lanes(|a| -0.5 * t[a] * s[a] * s[a]),
            lanes(|a| 1.0 + t[a] * t[a] * (1.5 * t[a] - 2.5)),
            lanes(|a| 1.0 + s[a] * s[a] * (1.5 * s[a] - 2.5)),
            lanes(|a| -0.5 * s[a] * t[a] * t[a]),
        ]
    }
}

/// The cubic B-spline.
pub(super) struct CubicSpline;

impl Weights for CubicSpline {
    #[inline(always)]
    fn lanes<const M: usize>(t: [f32; M]) -> [[f32; M]; 4] {
        const SIXTH: f32 = 1.0 / 6.0;
        let s = t.map(|t| 1.0 - t);
        [
            lanes(|a| s[a] * s[a] * s[a] * SIXTH),
            lanes(|a| 2.0 / 3.0 - t[a] * t[a] * (2.0 - t[a]) * 0.5),
            lanes(|a| 2.0 / 3.0 - s[a] * s[a] * (2.0 - s[a]) * 0.5),
            lanes(|a| t[a] * t[a] * t[a] * SIXTH),
        ]
    }
}

#[inline(always)]
fn lanes<T, const M: usize>(value: impl Fn(usize) -> T) -> [T; M] {
    std::array::from_fn(value)
}
