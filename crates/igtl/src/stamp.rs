//! Stamps: seconds since 1970 (UTC, by the sender's clock) with a binary fraction, and what may be wrong with them.

/// A time of the sender: the upper 32 bits are seconds, the lower 32 their fraction in steps of 2^-32 s (233 ps). 0
/// means that there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Stamp(pub u64);

const NS: u64 = 1_000_000_000;

impl Stamp {
    /// No time.
    pub const NONE: Self = Self(0);

    /// Of nanoseconds since 1970; `None` after February 2106, where 32 bits of seconds end. [`Stamp::ns`] gives `ns`
    /// back exactly.
    pub fn of_ns(ns: u64) -> Option<Self> {
        let seconds = u32::try_from(ns / NS).ok()?;
        // Rounded up, a step of the fraction being shorter than a nanosecond: rounding down on the way back meets the
        // same one.
        let fraction = ((ns % NS) << 32).div_ceil(NS);
        Some(Self((u64::from(seconds) << 32) | fraction))
    }

    /// Whole seconds.
    pub const fn seconds(self) -> u64 {
        self.0 >> 32
    }

    /// The fraction in steps of 2^-32 s.
    pub const fn fraction(self) -> u64 {
        self.0 & 0xffff_ffff
    }

    /// Nanoseconds since 1970, rounded down.
    pub const fn ns(self) -> u64 {
        self.seconds() * NS + ((self.fraction() * NS) >> 32)
    }
}

/// Why a stamp is not to be believed. Such a message is well-formed: its time of arrival is all that is known of its
/// time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StampError {
    /// The sender states none.
    #[error("no stamp (0)")]
    None,
    /// No seconds: a clock that counts from its start, or from nowhere.
    #[error("a stamp of {fraction_ns} ns without seconds")]
    FractionOnly {
        /// The fraction.
        fraction_ns: u64,
    },
    /// The same as before: a sender that packs a message once and sends it again.
    #[error("stamp {ns} ns is that of the message before")]
    Repeated {
        /// The stamp.
        ns: u64,
    },
    /// Earlier than the one before: the sender's clock was set back, or messages of two clocks share a name.
    #[error("the stamp is {by_ns} ns earlier than that of the message before")]
    Back {
        /// By how much.
        by_ns: u64,
    },
    /// Later than now, by more than is allowed.
    #[error("the stamp is {by_ns} ns ahead; allowed are {allowed_ns} ns")]
    Ahead {
        /// By how much.
        by_ns: u64,
        /// The bound.
        allowed_ns: u64,
    },
    /// Earlier than now by more than is allowed: clocks that were never compared, or a unit that is not the second.
    #[error("the stamp is {by_ns} ns old; allowed are {allowed_ns} ns")]
    Old {
        /// By how much.
        by_ns: u64,
        /// The bound.
        allowed_ns: u64,
    },
}

/// Compares the stamps of one device, one after the other.
#[derive(Debug, Clone, Copy, Default)]
pub struct StampWatch {
    last: Option<Stamp>,
}

impl StampWatch {
    /// Judges the next stamp by the one before alone; the least that a peer's clock must do.
    ///
    /// # Errors
    /// [`StampError::None`], [`StampError::FractionOnly`], [`StampError::Repeated`], [`StampError::Back`].
    pub fn judge(&mut self, stamp: Stamp) -> Result<(), StampError> {
        let last = self.last.replace(stamp);
        if stamp == Stamp::NONE {
            return Err(StampError::None);
        }
        if stamp.seconds() == 0 {
            return Err(StampError::FractionOnly {
                fraction_ns: stamp.ns(),
            });
        }
        match last {
            Some(last) if last == stamp => Err(StampError::Repeated { ns: stamp.ns() }),
            Some(last) if last > stamp => Err(StampError::Back {
                by_ns: last.ns() - stamp.ns(),
            }),
            _ => Ok(()),
        }
    }

    /// The same, and by a clock of our own that is said to show the same time: `now_ns` since 1970.
    ///
    /// # Errors
    /// Those of [`StampWatch::judge`], [`StampError::Ahead`], [`StampError::Old`].
    pub fn judge_at(&mut self, stamp: Stamp, now_ns: u64, allowed_ns: u64) -> Result<(), StampError> {
        self.judge(stamp)?;
        let (ahead, old) = (stamp.ns().saturating_sub(now_ns), now_ns.saturating_sub(stamp.ns()));
        if ahead > allowed_ns {
            return Err(StampError::Ahead {
                by_ns: ahead,
                allowed_ns,
            });
        }
        if old > allowed_ns {
            return Err(StampError::Old { by_ns: old, allowed_ns });
        }
        Ok(())
    }
}
