//! The deformation at a point.

use super::Lane;
use crate::law::x_minus_ln_1p;

/// One point of four cells, or four points of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point<W> {
    /// The displacement gradient, column by column.
    pub(super) g: [W; 9],
    /// `cof F - I`.
    pub(super) cofactor: [W; 9],
    /// `|F|^2 - 3 - 2 (J - 1)`.
    pub(super) q: W,
    /// `J - 1`.
    pub(super) x: W,
    pub(super) j: W,
    /// `ln J`, and `x - ln J`.
    pub(super) theta: W,
    pub(super) rest: W,
}

/// As in [`crate::space::law`]: nothing is formed as a difference of numbers near 1.
#[inline(always)]
pub(super) fn deformation<W: Lane>(proof: W::Proof, g: [W; 9]) -> Point<W> {
    // Columns of cof G are cross products of the columns of G.
    let minor = |a: usize, b: usize, c: usize, d: usize| g[a].times(g[b]).minus(g[c].times(g[d]));
    let small = [
        minor(4, 8, 5, 7),
        minor(5, 6, 3, 8),
        minor(3, 7, 4, 6),
        minor(7, 2, 8, 1),
        minor(8, 0, 6, 2),
        minor(6, 1, 7, 0),
        minor(1, 5, 2, 4),
        minor(2, 3, 0, 5),
        minor(0, 4, 1, 3),
    ];
    // `J - 1` by the three invariants: each keeps its own order of a small strain.
    let trace = g[0].plus(g[4]).plus(g[8]);
    let second = small[8].plus(small[0]).plus(small[4]);
    // The cofactors are there already: with them the determinant takes three products.
    let third = g[0]
        .times(small[0])
        .plus(g[1].times(small[1]))
        .plus(g[2].times(small[2]));
    let x = trace.plus(second).plus(third);
    let off = |entry: usize, turned: usize| small[entry].minus(g[turned]);
    let on = |entry: usize| small[entry].minus(g[entry]).plus(trace);
    // `cof F - I = cof G + (tr G) I - G^T`.
    let cofactor = [
        on(0),
        off(1, 3),
        off(2, 6),
        off(3, 1),
        on(4),
        off(5, 7),
        off(6, 2),
        off(7, 5),
        on(8),
    ];
    let two = W::splat(proof, 2.0);
    let (theta, rest) = logarithm(proof, x);
    Point {
        g,
        cofactor,
        q: squares(proof, &g).minus(two.times(third)),
        x,
        j: W::splat(proof, 1.0).plus(x),
        theta,
        rest,
    }
}

/// `|G|^2 - 2 (second invariant)`.
#[inline(always)]
fn squares<W: Lane>(proof: W::Proof, g: &[W; 9]) -> W {
    let sheared = |a: usize, b: usize| {
        let sum = g[a].plus(g[b]);
        sum.times(sum)
    };
    // As in the law: in plane strain what is left of the stretches is the square of this, without cancellation.
    let difference = g[0].minus(g[4]);
    let two = W::splat(proof, 2.0);
    let third = g[8].times(g[8].minus(two.times(g[0].plus(g[4]))));
    let stretches = difference.times(difference).plus(third);
    stretches.plus(sheared(1, 3).plus(sheared(5, 7)).plus(sheared(2, 6)))
}

/// Up to here the series below has all digits.
const SERIES_TO: f64 = 0.1;

/// `ln(1 + x)` and `x - ln(1 + x)`, to full relative precision near 0.
#[inline(always)]
fn logarithm<W: Lane>(proof: W::Proof, x: W) -> (W, W) {
    let one = |value: f64| W::splat(proof, value);
    // As in [`x_minus_ln_1p`]: ln(1 + x) = 2 artanh s with s = x / (2 + x), and x - 2 s = x s.
    let s = x.over(one(2.0).plus(x));
    let s2 = s.times(s);
    // Seven terms: up to the bound above the next one is below rounding.
    let mut series = one(1.0 / 15.0);
    for k in [13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = one(1.0 / k).plus(s2.times(series));
    }
    let rest = x.times(s).minus(one(2.0).times(s.times(s2)).times(series));
    let theta = x.minus(rest);
    let far = |x: f64| x.is_nan() || x.abs() > SERIES_TO;
    // Tissue hardly changes its volume: the series serves nearly always, and takes no call.
    let lanes = x.lanes();
    if !lanes.into_iter().any(far) {
        return (theta, rest);
    }
    let (mut theta, mut rest) = (theta.lanes(), rest.lanes());
    // Only the far lanes are replaced: the bits of a cell must not depend on those beside it.
    for (k, x) in lanes.into_iter().enumerate().filter(|(_, x)| far(*x)) {
        (theta[k], rest[k]) = (x.ln_1p(), x_minus_ln_1p(x));
    }
    (W::of(proof, theta), W::of(proof, rest))
}

/// `w (mu (F - cof F) + slope cof F)`.
#[inline(always)]
pub(super) fn stress<W: Lane>(proof: W::Proof, at: &Point<W>, mu: W, slope: W, weight: W) -> [W; 9] {
    let one = W::splat(proof, 1.0);
    let mut stress = at.g;
    for (entry, stress) in stress.iter_mut().enumerate() {
        let c = at.cofactor[entry];
        // Entries of the diagonal are 0, 4 and 8.
        let whole = if entry % 4 == 0 { c.plus(one) } else { c };
        // The I of F and that of cof F cancel in the first part, so that it is formed from their excesses.
        *stress = weight.times(stress.minus(c).times(mu).plus(whole.times(slope)));
    }
    stress
}
