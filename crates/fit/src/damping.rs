//! How much steps are held back.

/// How damping changes, and where it ends.
#[derive(Debug, Clone, Copy)]
pub struct Damping {
    /// To begin with.
    pub start: f64,
    /// How it changes.
    pub rule: Rule,
    /// Beyond it no step leads down.
    pub most: f64,
    /// Whether singular equations are damped more, and not refused.
    pub singular: bool,
}

/// How damping changes from step to step.
#[derive(Debug, Clone, Copy)]
pub enum Rule {
    /// By constant factors.
    Factors {
        /// By so much after a step.
        fall: f64,
        /// But to no less than this.
        least: f64,
        /// By so much where a step leads up.
        rise: f64,
        /// But to no less than this.
        raised: f64,
    },
    /// By how well a step did what was expected of it (H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05,
    /// eq. 2.5, with a fall of at most 10), but to no less than `least`.
    Gained {
        /// The least damping.
        least: f64,
    },
}

/// Damping as it is now.
#[derive(Debug, Clone, Copy)]
pub struct Held {
    /// What a step is held back by.
    pub value: f64,
    /// By how much it rises next, of [`Rule::Gained`].
    rise: f64,
    rule: Rule,
}

impl Damping {
    /// Steps of Gauss and Newton: held back by a thousandth and more where one leads up. Singular equations are refused.
    pub const GAUSS_NEWTON: Self = Self {
        // Undamped until a step leads up: damping that stays slows the end down to linear convergence.
        start: 0.0,
        rule: Rule::Factors {
            fall: 0.1,
            least: 0.0,
            rise: 10.0,
            raised: 1e-3,
        },
        // Beyond the reciprocal of a double's rounding a step changes no digit of the state.
        most: 1e16,
        singular: false,
    };

    /// To begin with.
    pub fn held(&self) -> Held {
        Held {
            value: self.start,
            rise: 2.0,
            rule: self.rule,
        }
    }
}

impl Held {
    /// After a step that gained the share `ratio` of what was expected.
    pub fn lower(&mut self, ratio: f64) {
        match self.rule {
            Rule::Factors { fall, least, .. } => self.value = (self.value * fall).max(least),
            Rule::Gained { least } => {
                // 1 at a ratio of 1/2, 0 at 1. A step that is accepted as flat may have a ratio below 0, where the cube
                // has no bound: hence 2 at most.
                let factor = 1.0 - (2.0 * ratio - 1.0).powi(3);
                self.value = (self.value * factor.clamp(0.1, 2.0)).max(least);
                self.rise = 2.0;
            }
        }
    }

    /// After a step that led up, or none.
    pub fn raise(&mut self) {
        match self.rule {
            Rule::Factors { rise, raised, .. } => self.value = (self.value * rise).max(raised),
            Rule::Gained { .. } => {
                // A product with 0 would stay 0, and the iteration would try the same step for ever.
                self.value = (self.value * self.rise).max(f64::MIN_POSITIVE);
                // Each failure in a row doubles the factor, so that many orders of magnitude are crossed in a few
                // tries.
                self.rise *= 2.0;
            }
        }
    }
}
