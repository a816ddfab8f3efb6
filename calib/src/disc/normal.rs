//! The normal distribution from a table: the inner loop of every model of a blurred edge.

use std::sync::LazyLock;

/// Nodes per unit.
const DENSITY: f64 = 128.0;
/// Beyond it the distribution is 0 or 1 to 1e-9.
const REACH: f64 = 6.0;

/// Distribution and density at the nodes.
static TABLE: LazyLock<Vec<[f64; 2]>> = LazyLock::new(table);

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt()
}

fn table() -> Vec<[f64; 2]> {
    let nodes = (2.0 * REACH * DENSITY) as usize;
    let mut below = 9.865_876_450_376_98e-10;
    let h = 1.0 / DENSITY;
    (0..=nodes)
        .map(|k| {
            let x = k as f64 * h - REACH;
            let here = [below, density(x)];
            // Boole's rule: an error of h^7 / 2e6 per step.
            let inner = 32.0 * density(x + 0.25 * h) + 12.0 * density(x + 0.5 * h) + 32.0 * density(x + 0.75 * h);
            below += h / 90.0 * (7.0 * density(x) + inner + 7.0 * density(x + h));
            here
        })
        .collect()
}

/// The table, taken once by a loop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normal(&'static [[f64; 2]]);

impl Normal {
    pub(crate) fn new() -> Self {
        Self(&TABLE)
    }

    /// The density at `x`, to 1e-8.
    #[inline]
    pub(crate) fn density(self, x: f64) -> f64 {
        if x.abs() >= REACH {
            return 0.0;
        }
        let k = ((x + REACH) * DENSITY + 0.5) as usize;
        let Some([_, f]) = self.0.get(k) else { return 0.0 };
        let a = k as f64 / DENSITY - REACH;
        let d = x - a;
        f * (1.0 + d * (0.5 * d * (a * a - 1.0) - a))
    }

    /// The distribution at `x`, to 1e-8.
    #[inline]
    pub(crate) fn below(self, x: f64) -> f64 {
        if x.abs() >= REACH {
            return if x > 0.0 { 1.0 } else { 0.0 };
        }
        let k = ((x + REACH) * DENSITY + 0.5) as usize;
        let Some([below, f]) = self.0.get(k) else { return 1.0 };
        let a = k as f64 / DENSITY - REACH;
        let d = x - a;
        below + f * d * (1.0 - 0.5 * a * d)
    }

    /// Distribution and density at `x`, to 1e-8: Taylor polynomials of degree 2 from the nearest node.
    #[inline]
    pub(crate) fn at(self, x: f64) -> [f64; 2] {
        if x.abs() >= REACH {
            return [if x > 0.0 { 1.0 } else { 0.0 }, 0.0];
        }
        let place = (x + REACH) * DENSITY + 0.5;
        let k = place as usize;
        let Some([below, f]) = self.0.get(k) else {
            return [1.0, 0.0];
        };
        let a = k as f64 / DENSITY - REACH;
        let d = x - a;
        let value = below + f * d * (1.0 - 0.5 * a * d);
        [value, f * (1.0 + d * (0.5 * d * (a * a - 1.0) - a))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_known_values() {
        let normal = Normal::new();
        for (x, known) in [
            (0.0, 0.5),
            (1.0, 0.841_344_746_068_542_9),
            (-1.96, 0.024_997_895_148_220_43),
            (3.3, 0.999_516_575_857_616_2),
        ] {
            // The next terms: half a step of 1/128 to the third, by 6, and derivatives up to 0.4 and 1.4.
            assert!((normal.at(x)[0] - known).abs() < 5e-9, "{x}");
            assert!((normal.at(x)[1] - density(x)).abs() < 2e-8, "{x}");
            assert_eq!(normal.at(x)[1], normal.density(x), "{x}");
        }
        assert_eq!(normal.at(40.0), [1.0, 0.0]);
    }
}
