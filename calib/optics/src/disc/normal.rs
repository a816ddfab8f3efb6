//! The normal distribution from a table: the inner loop of every model of a blurred edge.

use std::sync::LazyLock;

/// Nodes per unit.
const NODES_PER_UNIT: f64 = 128.0;
/// Beyond it the distribution is 0 or 1 to 1e-9.
const TABLE_REACH: f64 = 6.0;

/// Nodes of the table, and room behind them up to a power of 2, so that no place in it needs a check.
const TABLE_NODES: usize = (2.0 * TABLE_REACH * NODES_PER_UNIT) as usize;
const TABLE_ROOM: usize = 2048;
/// Added to a number below 2^51 it leaves the nearest whole number in the lowest bits; with the place of 0 in the table.
const TO_WHOLE: f64 = (3_u64 << 51) as f64 + TABLE_REACH * NODES_PER_UNIT;

/// Distribution and density at the nodes.
static TABLE: LazyLock<Box<[[f64; 2]; TABLE_ROOM]>> = LazyLock::new(table);

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt()
}

fn table() -> Box<[[f64; 2]; TABLE_ROOM]> {
    let mut table = Box::new([[1.0, 0.0]; TABLE_ROOM]);
    // Phi(-6), where the table begins.
    let mut below = 9.865_876_450_376_98e-10;
    let h = 1.0 / NODES_PER_UNIT;
    for (k, node) in table[..TABLE_NODES].iter_mut().enumerate() {
        let x = k as f64 * h - TABLE_REACH;
        *node = [below, density(x)];
        // Boole's rule: an error of h^7 / 2e6 per step.
        let inner = 32.0 * density(x + 0.25 * h) + 12.0 * density(x + 0.5 * h) + 32.0 * density(x + 0.75 * h);
        below += h / 90.0 * (7.0 * density(x) + inner + 7.0 * density(x + h));
    }
    // Everything beyond the ends counts as there: all or nothing.
    table[0] = [0.0; 2];
    table
}

/// The table, taken once by a loop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normal(&'static [[f64; 2]; TABLE_ROOM]);

impl Normal {
    pub(crate) fn new() -> Self {
        Self(&TABLE)
    }

    /// The nearest node, what it holds, and how far `x` is from it.
    #[inline]
    fn near(self, x: f64) -> (f64, [f64; 2], f64) {
        let x = x.clamp(-TABLE_REACH, TABLE_REACH);
        let whole = x * NODES_PER_UNIT + TO_WHOLE;
        let a = (whole - TO_WHOLE) / NODES_PER_UNIT;
        (a, self.0[whole.to_bits() as usize % TABLE_ROOM], x - a)
    }

    /// The density at `x`, to 1e-8.
    #[inline]
    pub(crate) fn density(self, x: f64) -> f64 {
        let (a, [_, f], d) = self.near(x);
        f * (1.0 + d * (0.5 * d * (a * a - 1.0) - a))
    }

    /// Distribution and density at `x`, to 1e-8: Taylor polynomials of degree 2 from the nearest node.
    #[inline]
    pub(crate) fn at(self, x: f64) -> [f64; 2] {
        let (a, [below, f], d) = self.near(x);
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
        assert_eq!([normal.at(40.0), normal.at(-40.0)], [[1.0, 0.0], [0.0, 0.0]]);
        assert!(normal.at(f64::NAN)[0].is_nan());
    }
}
