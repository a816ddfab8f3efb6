//! What is fitted, and what came of it.

/// A sum of squares, and steps towards where it is least.
pub trait Problem {
    /// The numbers that are sought.
    type State;
    /// What is known where a state is, beside its cost: normal equations for the most part.
    type At;

    /// The sum of squares, and what is had together with it; `None` where the state is impossible.
    fn look(&self, state: &Self::State) -> Option<(f64, Self::At)>;

    /// Computes what a step needs and [`Problem::look`] left out, once at each state that steps are made from, after so many
    /// of them. `false` where that cannot be.
    fn prepare(&self, _state: &Self::State, _at: &mut Self::At, _steps: usize) -> bool {
        true
    }

    /// The step that is held back by `damping`; `None` where its equations are singular or it leads to no state.
    fn step(&self, state: &Self::State, at: &Self::At, damping: f64) -> Option<Step<Self::State>>;

    /// Whether a step is so small that it ends the iteration where it leads, without a look at the cost there. A step that is held
    /// back much is short however far the end is: a problem that takes no account of `damping` calls that an end too.
    fn is_last(&self, _step: &Step<Self::State>, _at: &Self::At, _damping: f64) -> bool {
        false
    }

    /// Whether a step that did not lower the cost is so small that the cost is flat here.
    fn is_flat(&self, _step: &Step<Self::State>, _damping: f64) -> bool {
        false
    }

    /// Whether the iteration ends after a step that was made.
    fn is_settled(&self, _made: &Made<'_, Self::State, Self::At>) -> bool {
        false
    }
}

/// A step that may be made.
#[derive(Debug, Clone)]
pub struct Step<S> {
    /// Where it leads.
    pub to: S,
    /// How long it is, in the problem's own measure.
    pub length: f64,
    /// By how much the cost would fall were the problem linear; only [`crate::Rule::Gained`] and the problem itself look at it.
    pub gain: f64,
}

/// A step that was made.
#[derive(Debug)]
pub struct Made<'a, S, A> {
    /// Where it led.
    pub state: &'a S,
    /// What is known there.
    pub at: &'a A,
    /// Its length.
    pub length: f64,
    /// The cost before.
    pub from: f64,
    /// The cost after.
    pub to: f64,
    /// By how much the step was held back.
    pub damping: f64,
}

/// Why an iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// By [`Problem::is_settled`].
    Settled,
    /// By [`Problem::is_last`]: `at` and `cost` are those of the state before.
    Last,
    /// No step lowers the cost, by [`Problem::is_flat`].
    Flat,
    /// None does up to the greatest damping.
    Nowhere,
    /// The equations are singular.
    Singular,
    /// Steps or tries ran out.
    OutOfSteps,
}

/// Where an iteration ended.
#[derive(Debug, Clone)]
pub struct Outcome<S, A> {
    /// The numbers.
    pub state: S,
    /// What is known there.
    pub at: A,
    /// What was known where the last step was made from; `None` where none was, and of [`End::Last`], whose `at` is that.
    pub before: Option<A>,
    /// The sum of squares.
    pub cost: f64,
    /// Why it ended there.
    pub end: End,
    /// Steps that were made, the last with them.
    pub steps: usize,
    /// Length of the last step made; infinite where none was.
    pub length: f64,
    /// Expected gain of the last step made; infinite where none was.
    pub gain: f64,
}
