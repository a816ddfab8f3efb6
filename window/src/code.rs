//! The coded cell: black and white squares in a corner of the window by which another process knows, from the pixels of the
//! screen alone, which picture is on the glass and how old it may be.
//!
//! A [`Code`] has the number of the picture, when the oldest pose in it was captured, and what the picture says of itself. It is
//! laid out as a [`Grid`] of squares with a check sum that depends on the run, so that the window of another run does not
//! pass for this one. Where the cell lies is said by a [`Place`], a property of the window.
//!
//! What the cell proves: these squares are on the screen, they were painted for that picture, and nothing lies over them. It proves
//! nothing of the pixels beside it: the window paints both of one and the same model, or the code is worth nothing.

mod check_sum;
mod grid;
mod place;

pub use grid::{COLUMNS, Grid, ROWS, SQUARE_PX, Unread};
pub use place::{PROPERTY, Place, PlaceError};

/// How the bits lie; another layout is another version.
pub const VERSION: u32 = 1;

/// What the picture says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// No image is shown.
    Nothing,
    /// At least one image is shown as what is there now.
    Live,
    /// Images are shown, and the screen says itself that none is live: old, lost, held.
    NotLive,
    /// A replay, which the screen calls so.
    Replay,
}

impl Shown {
    /// Any two differ in two bits.
    const ALL: [(Self, u64); 4] = [
        (Self::Nothing, 0b0011),
        (Self::Live, 0b0101),
        (Self::NotLive, 0b1010),
        (Self::Replay, 0b1100),
    ];

    fn bits(self) -> u64 {
        Self::ALL
            .iter()
            .find(|(shown, _)| *shown == self)
            .map_or(0, |&(_, bits)| bits)
    }

    fn of_bits(bits: u64) -> Option<Self> {
        Self::ALL.iter().find(|(_, own)| *own == bits).map(|&(shown, _)| shown)
    }
}

/// What the cell of one picture says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    seq: u32,
    capture_ms: u32,
    shown: Shown,
}

/// Bits of the picture's number.
const SEQ_BITS: u32 = 24;
const SEQ_MASK: u32 = (1 << SEQ_BITS) - 1;

impl Code {
    /// The code of picture number `seq`, whose oldest pose was captured at `t_capture_ns` on the clock by which poses are aged.
    /// The number begins anew after 2^24 (three days at 60 a second), the time, rounded down to ms, after 2^32 ms (49 days). Where
    /// no pose is shown the time says nothing.
    pub const fn new(seq: u64, t_capture_ns: i64, shown: Shown) -> Self {
        Self {
            seq: (seq & SEQ_MASK as u64) as u32,
            // The lowest 32 bits, of negative stamps too.
            capture_ms: t_capture_ns.div_euclid(1_000_000) as u32,
            shown,
        }
    }

    /// The picture's number, 24 bits.
    pub const fn seq(self) -> u32 {
        self.seq
    }

    /// What the picture says of itself.
    pub const fn shown(self) -> Shown {
        self.shown
    }

    /// How old the oldest pose shown is at `now_ns`, ms: less than 2 ms too old, never too young. Negative for a capture that is yet
    /// to come. Unambiguous up to 24 days.
    pub const fn age_ms(self, now_ns: i64) -> i64 {
        let now_ms = now_ns.saturating_add(999_999).div_euclid(1_000_000) as u32;
        now_ms.wrapping_sub(self.capture_ms) as i32 as i64
    }

    /// Whether this picture was painted behind `other` in one life of a window.
    pub const fn is_behind(self, other: Self) -> bool {
        let ahead = self.seq.wrapping_sub(other.seq) & SEQ_MASK;
        ahead != 0 && ahead < 1 << (SEQ_BITS - 1)
    }

    /// All of it in one number, as a sign of life carries it (`Heartbeat::painted`).
    pub fn word(self) -> u64 {
        let head = (u64::from(VERSION) << 4 | self.shown.bits()) << SEQ_BITS;
        (head | u64::from(self.seq)) << 32 | u64::from(self.capture_ms)
    }

    /// The code of such a number; `None` for another version or a state that there is not.
    pub fn of_word(word: u64) -> Option<Self> {
        let shown = Shown::of_bits(word >> 56 & 0xf)?;
        let code = Self {
            seq: (word >> 32) as u32 & SEQ_MASK,
            capture_ms: word as u32,
            shown,
        };
        (word >> 60 == u64::from(VERSION)).then_some(code)
    }

    /// The squares, for the run with this [`key`].
    pub fn grid(self, key: u32) -> Grid {
        Grid::of(self.word(), key)
    }
}

/// What tells the cells of one run from those of another: from the run's epoch, ns of CLOCK_MONOTONIC.
pub fn key(epoch_ns: i64) -> u32 {
    check_sum::of(&epoch_ns.to_be_bytes())
}

#[cfg(test)]
mod tests;
