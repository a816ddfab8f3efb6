//! The clock of a replay as its replayer publishes it, or simulated time as the tracker does.

use iceoryx2::prelude::ZeroCopySend;

use crate::clock::{Law, LawError};

/// How the clock of a replay runs from now on, and where the replay stands. Read it through [`ClockLaw::law`].
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/ClockLaw/3")]
pub struct ClockLaw {
    /// What the clock shows at the anchor, ns on the clock of the run that was recorded.
    pub anchor_ns: i64,
    /// What CLOCK_MONOTONIC shows at the anchor, ns.
    pub anchor_monotonic_ns: i64,
    /// How fast the clock runs; 0 stands still.
    pub rate: f64,
    /// Counts the places where the replay went elsewhere instead of on: what was shown last says nothing of what comes.
    pub jumps: u64,
    /// The first moment of what is replayed, ns on the same clock as `anchor_ns`.
    pub first_ns: i64,
    /// The last one.
    pub last_ns: i64,
    /// The zero of the seconds that people name: the recording's first pose, also where the replay begins later.
    pub zero_ns: i64,
    /// Of poses that were published before it, on the same clock, nobody knows for how long their measurement had stood still: what came before
    /// them is not in the recording.
    pub judged_from_ns: i64,
    /// How many times the recording's own speed was asked for; infinite: each pose waits until the one before is drawn.
    pub speed: f64,
    /// Code of a [`ReplayState`].
    pub state: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<ClockLaw>() == 80 && align_of::<ClockLaw>() == 8);

/// What a replay does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplayState {
    /// Poses go out.
    Playing,
    /// The clock stands still until it is asked to go on.
    Paused,
    /// The last pose has gone out.
    Ended,
}

impl ReplayState {
    /// The code on the wire.
    pub const fn code(self) -> u32 {
        match self {
            Self::Playing => 0,
            Self::Paused => 1,
            Self::Ended => 2,
        }
    }

    /// In a word, for people.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Playing => "playing",
            Self::Paused => "paused",
            Self::Ended => "ended",
        }
    }
}

impl ClockLaw {
    /// The clock.
    ///
    /// # Errors
    /// [`LawError`].
    pub fn law(&self) -> Result<Law, LawError> {
        Law::new(self.anchor_ns, self.anchor_monotonic_ns, self.rate)
    }

    /// What the replay does; an unknown code counts as paused.
    pub fn replay_state(&self) -> ReplayState {
        match self.state {
            0 => ReplayState::Playing,
            2 => ReplayState::Ended,
            _ => ReplayState::Paused,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_come_back_by_their_code() {
        for state in [ReplayState::Playing, ReplayState::Paused, ReplayState::Ended] {
            let law = ClockLaw {
                state: state.code(),
                ..ClockLaw::default()
            };
            assert_eq!(law.replay_state(), state);
        }
        let unknown = ClockLaw {
            state: 9,
            ..ClockLaw::default()
        };
        assert_eq!(unknown.replay_state(), ReplayState::Paused);
    }
}
