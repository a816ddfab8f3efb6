//! When a search stops, and what it may do.

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The most steps.
    pub most_iterations: usize,
    /// The largest free force over the largest load: the one criterion, for every system and unit.
    pub tolerance: f64,
    /// The first limit of a parameter's change in a step, in sizes of the largest solid; it adapts.
    pub first_radius: f64,
    /// At a saddle, go on along a direction in which the energy falls.
    pub leave_saddles: bool,
    /// The state is only on the way to another: neither its stability is asked for, nor is a saddle left at its end.
    pub provisional: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            most_iterations: 400,
            tolerance: 1e-8,
            first_radius: 1.0,
            leave_saddles: true,
            provisional: false,
        }
    }
}
