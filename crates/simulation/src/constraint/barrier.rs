//! The barrier that keeps solids apart.

/// `B(x) = -(x - 1)^2 ln x` for `0 < x < 1` (Li et al. 2020), zero from 1 on, with two derivatives. `None` at `x <= 0`.
///
/// Twice differentiable at 1, and infinite at 0: a line search that lowers the energy never reaches it.
pub fn barrier(x: f64) -> Option<[f64; 3]> {
    // A NaN fails both comparisons below and would come out as an energy.
    if x.is_nan() || x <= 0.0 {
        return None;
    }
    // Near 1 the logarithm is `x - 1`, so that `B` is `-(x - 1)^3` there: all three vanish.
    if x >= 1.0 {
        return Some([0.0; 3]);
    }
    let (y, log) = (x - 1.0, x.ln());
    let first = -2.0 * y * log - y * y / x;
    // All three terms are above zero below 1: `B` is convex.
    let second = -2.0 * log - 4.0 * y / x + y * y / (x * x);
    Some([-y * y * log, first, second])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_and_limits() {
        let h = 1e-6;
        for x in [0.05, 0.3, 0.7, 0.99] {
            let (plus, minus, at) = (barrier(x + h).unwrap(), barrier(x - h).unwrap(), barrier(x).unwrap());
            // h^2 times third derivatives below 1e5.
            assert!(((plus[0] - minus[0]) / (2.0 * h) - at[1]).abs() < 1e-6);
            assert!(((plus[1] - minus[1]) / (2.0 * h) - at[2]).abs() < 1e-6);
            assert!(at[0] > 0.0 && at[1] < 0.0 && at[2] > 0.0);
        }
        assert_eq!(barrier(1.0), Some([0.0; 3]));
        assert_eq!(barrier(0.0), None);
        assert_eq!(barrier(f64::NAN), None);
        let near = barrier(1.0 - 1e-8).unwrap();
        assert!(near.iter().all(|v| v.abs() < 1e-6), "{near:?}");
    }
}
