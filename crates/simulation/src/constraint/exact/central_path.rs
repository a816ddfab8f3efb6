//! What force times gap a row aims at.
//!
//! Without an end to its range, the logarithm of an interior method pushes on every gap, and on those alone that have a row: a solid that
//! is free to roll or slide is driven to where rows are missing. Here it ends, twice differentiable, where rows begin:
//! `b(x) = -ln x + 2 x - x^2 / 2 - 3/2` for the gap `x` over the depth of the rows, below 1, so that `- x b'(x) = (1 - x)^2`.

/// A gap beyond this part of the depth has the force that the aim gives it, and none of its own.
const FAR_DEPTHS: f64 = 0.5;

/// The aim of all rows, and how deep they go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Aim {
    /// Force times gap where gaps are small.
    pub(super) work: f64,
    /// From this gap on nothing.
    pub(super) depth: f64,
}

impl Aim {
    /// That of a row with a force: one that is loaded keeps the least gap, or rounding would be all that is left of it.
    pub(super) fn of(&self, force: f64, least: f64) -> Self {
        Self {
            work: self.work.max(force * least),
            ..*self
        }
    }

    /// The part of the whole aim that a gap has, from 1 to 0.
    pub(super) fn part(&self, gap: f64) -> f64 {
        let y = 1.0 - gap / self.depth;
        if y > 0.0 { y * y } else { 0.0 }
    }

    /// Its derivative by the gap.
    fn slope(&self, gap: f64) -> f64 {
        let y = 1.0 - gap / self.depth;
        if y > 0.0 { -2.0 * y / self.depth } else { 0.0 }
    }

    /// The force at a gap.
    pub(super) fn force(&self, gap: f64) -> f64 {
        self.work * self.part(gap) / gap
    }

    /// How a force falls with its gap in a Newton step on `force gap = aim`.
    pub(super) fn stiffness(&self, force: f64, gap: f64) -> f64 {
        // From `d(p s) = w part'(s) ds`.
        (force - self.work * self.slope(gap)) / gap
    }

    /// The energy of which the force is the slope.
    pub(super) fn energy(&self, gap: f64) -> f64 {
        let x = gap / self.depth;
        if x < 1.0 {
            // `b`, `b'` and `b''` vanish at 1: what is beyond joins on twice differentiable.
            self.work * (-x.ln() + 2.0 * x - 0.5 * x * x - 1.5)
        } else {
            0.0
        }
    }

    /// True for a gap that has no force of its own.
    pub(super) fn far(&self, gap: f64) -> bool {
        gap > FAR_DEPTHS * self.depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_slopes_and_end_at_the_depth() {
        let aim = Aim { work: 0.3, depth: 2.0 };
        let h = 1e-6;
        for gap in [0.01, 0.4, 1.3, 1.999] {
            let slope = (aim.energy(gap + h) - aim.energy(gap - h)) / (2.0 * h);
            // h^2 / 6 times a third derivative of 2 work / gap^3, and rounding over h.
            assert!((slope + aim.force(gap)).abs() < 1e-6, "{gap}");
            // On the solution the linear law's slope is the force's own.
            let force = aim.force(gap);
            let change = (aim.force(gap + h) - aim.force(gap - h)) / (2.0 * h);
            assert!(
                (aim.stiffness(force, gap) + change).abs() < 1e-5 * change.abs().max(1.0),
                "{gap}"
            );
        }
        assert_eq!([aim.force(2.0), aim.energy(2.5), aim.stiffness(0.0, 3.0)], [0.0; 3]);
    }
}
