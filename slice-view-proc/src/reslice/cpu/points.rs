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
        sum += w[0][i] * sums[i];
    }
    sum
}

/// Catmull-Rom weights at a fraction, as in the reference.
#[inline(always)]
pub(super) fn cubic(part: i32) -> [f32; 4] {
    cubics([part; 1])[0]
}

/// [`cubic`] at several fractions, in lanes.
#[inline(always)]
pub(super) fn cubics<const M: usize>(parts: [i32; M]) -> [[f32; 4]; M] {
    let t = parts.map(|part| part as f32 * UNIT);
    let s = t.map(|t| 1.0 - t);
    let ends: [f32; M] = lanes(|a| -0.5 * t[a] * s[a] * s[a]);
    let near: [f32; M] = lanes(|a| 1.0 + t[a] * t[a] * (1.5 * t[a] - 2.5));
    let far: [f32; M] = lanes(|a| 1.0 + s[a] * s[a] * (1.5 * s[a] - 2.5));
    let last: [f32; M] = lanes(|a| -0.5 * s[a] * t[a] * t[a]);
    lanes(|a| [ends[a], near[a], far[a], last[a]])
}

/// Cubic B-spline weights at a fraction, as in the reference.
#[inline(always)]
pub(super) fn b_spline(part: i32) -> [f32; 4] {
    b_splines([part; 1])[0]
}

/// [`b_spline`] at several fractions, in lanes.
#[inline(always)]
pub(super) fn b_splines<const M: usize>(parts: [i32; M]) -> [[f32; 4]; M] {
    const SIXTH: f32 = 1.0 / 6.0;
    let t = parts.map(|part| part as f32 * UNIT);
    let s = t.map(|t| 1.0 - t);
    let first: [f32; M] = lanes(|a| s[a] * s[a] * s[a] * SIXTH);
    let near: [f32; M] = lanes(|a| 2.0 / 3.0 - t[a] * t[a] * (2.0 - t[a]) * 0.5);
    let far: [f32; M] = lanes(|a| 2.0 / 3.0 - s[a] * s[a] * (2.0 - s[a]) * 0.5);
    let last: [f32; M] = lanes(|a| t[a] * t[a] * t[a] * SIXTH);
    lanes(|a| [first[a], near[a], far[a], last[a]])
}

#[inline(always)]
fn lanes<T, const M: usize>(value: impl Fn(usize) -> T) -> [T; M] {
    std::array::from_fn(value)
}
