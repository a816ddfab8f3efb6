//! Why there is no lag.

/// Why there is no lag.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LagError {
    /// An option is out of its range.
    #[error("{what} is {found}; {least} to {most} are allowed")]
    Option {
        /// Which.
        what: &'static str,
        /// What was given.
        found: f64,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
    /// A signal is too short or too long.
    #[error("the {signal}'s signal has {found} samples; 20 to 200000 are allowed")]
    Count {
        /// Which.
        signal: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A time that does not rise, or a number that is none.
    #[error("the {signal}'s signal, sample {index}: ({t_s} s, {value}); times must rise and all numbers be finite")]
    Sample {
        /// Which.
        signal: &'static str,
        /// The sample, from 0.
        index: usize,
        /// Its time.
        t_s: f64,
        /// Its value.
        value: f64,
    },
    /// The window is shorter than the time between samples.
    #[error(
        "the {signal}'s samples are {step_s:.3} s apart and the window is {window_s:.3} s: at least as much is needed"
    )]
    Window {
        /// Which.
        signal: &'static str,
        /// Median time between two.
        step_s: f64,
        /// What was given.
        window_s: f64,
    },
    /// Both signals have too little time in common.
    #[error(
        "only {found} images have poses within {most_s} s either way; at least {needed} are needed: are both clocks one?"
    )]
    Overlap {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
        /// The largest lag.
        most_s: f64,
    },
    /// The least is at the end of the range.
    #[error(
        "the signals fit best at the end of the range, {most_s} s: the lag lies beyond, or they have nothing to do with one another"
    )]
    Edge {
        /// The largest lag.
        most_s: f64,
    },
    /// A lag beyond the range fits better.
    #[error(
        "{found_s:.3} s fits better than {lag_s:.3} s, which is the best within {most_s} s either way: the lag lies beyond the range; widen it"
    )]
    Beyond {
        /// The best within the range.
        lag_s: f64,
        /// The one beyond it.
        found_s: f64,
        /// The largest lag.
        most_s: f64,
    },
    /// Both halves of the recording have a lag of their own.
    #[error(
        "the lag is {first_s:.3} s in the first half of the recording and {second_s:.3} s in the second, {deviations:.1} deviations apart: one of the clocks goes faster than the other, or was set; one lag does not hold for both"
    )]
    Drifts {
        /// Of the first half.
        first_s: f64,
        /// Of the second.
        second_s: f64,
        /// Their difference in its deviation.
        deviations: f64,
    },
    /// Another lag fits as well.
    #[error(
        "{lag_s:.3} s and {other_s:.3} s fit nearly as well: the motion repeats itself; move at changing speed, or narrow the range"
    )]
    Ambiguous {
        /// The best.
        lag_s: f64,
        /// The other.
        other_s: f64,
    },
    /// The signals are not alike.
    #[error(
        "the correlation of both signals is {correlation:.3}; at least {least} is accepted: they do not show one motion"
    )]
    Unlike {
        /// What was found.
        correlation: f64,
        /// What is accepted.
        least: f64,
    },
    /// The motion says too little.
    #[error(
        "the lag is {lag_s:.3} s to {sigma_s:.3} s only; at most {most_s} s is accepted: the motion is too slow, too steady or too short; turn \
         round often"
    )]
    Blunt {
        /// What was found.
        lag_s: f64,
        /// Its deviation.
        sigma_s: f64,
        /// What is accepted.
        most_s: f64,
    },
}
