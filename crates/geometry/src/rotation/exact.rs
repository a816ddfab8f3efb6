//! Sums and products with their rounding errors, and norms that neither overflow nor underflow.
//!
//! Without fused multiply-add: what is compiled for any x86-64 would call a library function for each.

/// a + b and its exact rounding error (Knuth).
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let t = sum - a;
    (sum, (a - (sum - t)) + (b - t))
}

/// The two halves of `a`, of 26 bits each (Veltkamp); abs(a) < 2^996.
#[inline]
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2^27 + 1
    let high = c - (c - a);
    (high, a - high)
}

/// a b and its rounding error (Dekker), exact while the product is between 2^-968 and 2^1020.
#[inline]
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, al * bl - (((product - ah * bh) - al * bh) - ah * bl))
}

/// The multiple of 2^-26 nearest to a number, abs(a) <= 2. Products of two such multiples, and sums of a few that stay
/// below 2, are exact: the cheapest way to a scalar product of quaternions that are unit.
#[inline]
pub(crate) fn coarse(a: f64) -> f64 {
    const GRID: f64 = 100_663_296.0; // 1.5 2^26, whose ulp is 2^-26
    (a + GRID) - GRID
}

/// The number as such a multiple and the rest.
#[inline]
pub(crate) fn fixed(a: f64) -> (f64, f64) {
    let high = coarse(a);
    (high, a - high)
}

/// The sum of four numbers, in pairs.
#[inline]
pub(crate) fn sum([a, b, c, d]: [f64; 4]) -> f64 {
    (a + b) + (c + d)
}

/// a b as a multiple of 2^-52 and the rest, of numbers from [`fixed`]; the rest to 2^-79 of 1 and to an ulp of itself.
#[inline]
pub(crate) fn fixed_product(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 * b.0, a.0 * b.1 + a.1 * (b.0 + b.1))
}

/// The scalar product as a sum of two numbers, to about 2^-104 of the sum of the absolute products (Ogita, Rump, Oishi).
#[inline]
pub(crate) fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> (f64, f64) {
    let (mut high, mut low) = (0.0, 0.0);
    for i in 0..N {
        let (p, e) = two_product(a[i], b[i]);
        let (sum, d) = two_sum(high, p);
        high = sum;
        low += d + e;
    }
    two_sum(high, low)
}

/// The Euclidean norm as a sum of two numbers, to about 2^-103; the largest component between 2^-400 and 2^400.
#[inline]
pub(crate) fn norm<const N: usize>(v: [f64; N]) -> (f64, f64) {
    let (square, rest) = dot(v, v);
    if square == 0.0 {
        return (0.0, 0.0);
    }
    let root = square.sqrt();
    // One step of Newton for the root, with what the square lacks known exactly: root + (v.v - root^2) / (2 root).
    let (p, e) = two_product(root, root);
    (root, (((square - p) - e) + rest) / (2.0 * root))
}

/// The largest absolute component; the components are finite.
#[inline]
pub(crate) fn largest<const N: usize>(v: [f64; N]) -> f64 {
    // `f64::max` passes over NaN: callers have refused it.
    v.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// 2^600 and 2^-600, and the largest and smallest component that needs no scaling by them.
const SCALE: f64 = f64::from_bits((1023 + 600) << 52);
pub(crate) const TINY_UNIT: f64 = f64::from_bits((1023 - 600) << 52);
pub(crate) const BIG: f64 = f64::from_bits((1023 + 400) << 52);
const SMALL: f64 = f64::from_bits((1023 - 400) << 52);

/// The vector divided by its norm, to 1 ulp in each component, or `None` for the zero vector; the components are finite.
pub(crate) fn unit<const N: usize>(v: [f64; N]) -> Option<[f64; N]> {
    let most = largest(v);
    if most == 0.0 {
        None
    } else if most < SMALL {
        Some(divided(v.map(|x| x * SCALE)))
    } else if most > BIG {
        Some(divided_big(v))
    } else {
        Some(divided(v))
    }
}

/// v / abs(v), the largest component between 2^-500 and 2^400.
#[inline]
fn divided<const N: usize>(v: [f64; N]) -> [f64; N] {
    let (n, rest) = norm(v);
    let relative = rest / n;
    v.map(|x| {
        // First order in the norm's rest: x / (n + rest) = (x / n) (1 - rest / n).
        let y = x / n;
        y - y * relative
    })
}

/// v / abs(v) where squares would overflow. Divides first: scaling first would lose small components.
fn divided_big<const N: usize>(v: [f64; N]) -> [f64; N] {
    // Components that vanish by the scaling are 2^-600 of the largest or less, and say nothing of the norm.
    let (n, rest) = norm(v.map(|x| x / SCALE));
    let relative = rest / n;
    v.map(|x| {
        let y = x / n;
        (y - y * relative) / SCALE
    })
}

/// The norm, to 1 ulp, wherever it is representable; the components are finite.
pub(crate) fn length<const N: usize>(v: [f64; N]) -> f64 {
    let most = largest(v);
    if most < SMALL {
        norm(v.map(|x| x * SCALE)).0 / SCALE
    } else if most > BIG {
        norm(v.map(|x| x / SCALE)).0 * SCALE
    } else {
        norm(v).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_and_sums_are_exact() {
        let a = 1.0 + f64::EPSILON;
        assert_eq!(
            two_product(a, a),
            (1.0 + 2.0 * f64::EPSILON, f64::EPSILON * f64::EPSILON)
        );
        assert_eq!(two_sum(1.0, 1e-30), (1.0, 1e-30));
        assert_eq!(dot([1e16, 1.0, -1e16], [1.0, 1.0, 1.0]), (1.0, 0.0));
    }

    #[test]
    fn unit_vectors_at_every_scale() {
        for exponent in [-1074, -1000, -500, -400, -1, 0, 300, 401, 1020] {
            let s = 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2);
            assert_eq!(unit([4.0 * s, 3.0 * s, 0.0]), Some([0.8, 0.6, 0.0]), "{exponent}");
            assert_eq!(length([4.0 * s, 3.0 * s, 0.0]), 5.0 * s, "{exponent}");
        }
        assert_eq!(unit([0.0; 3]), None);
        assert_eq!(unit([f64::MAX, 1e-300]), Some([1.0, 0.0]));
        // 2^-1072 beside 2^-500: a ratio that is representable.
        let small = unit([f64::from_bits(4), 2f64.powi(-500)]).unwrap();
        assert_eq!(small[0], 2f64.powi(-572));
    }
}
