//! Time stamps that can be believed.

/// Lets each frame pass once, in order, and none from the future.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stamps {
    last_ns: Option<i64>,
}

/// A frame is this far ahead of the clock at most, ns: what two readings of one clock differ by.
const FUTURE_NS: i64 = 5_000_000;

/// Why a frame is not used. The next one may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StampError {
    /// The same time again.
    #[error("frame of {t_ns} ns came again")]
    Repeated {
        /// Its time on the localizer's clock, ns.
        t_ns: i64,
    },
    /// Older than one that came before it.
    #[error("frame of {t_ns} ns came after one of {last_ns} ns")]
    Backwards {
        /// Its time on the localizer's clock, ns.
        t_ns: i64,
        /// That of the newest before.
        last_ns: i64,
    },
    /// Captured later than now: it would never grow old.
    #[error("frame captured {ahead_ns} ns in the future, at most {FUTURE_NS} ns are allowed")]
    Future {
        /// How far ahead of the run's clock.
        ahead_ns: i64,
    },
}

impl Stamps {
    /// Admits a frame of `t_device_ns` on the localizer's clock, captured at `t_capture_ns` on the run's, where it is
    /// `now_ns`.
    ///
    /// # Errors
    /// Each variant of [`StampError`]; what was admitted before stays.
    pub fn admit(&mut self, t_device_ns: i64, t_capture_ns: i64, now_ns: i64) -> Result<(), StampError> {
        let ahead_ns = t_capture_ns.saturating_sub(now_ns);
        if ahead_ns > FUTURE_NS {
            return Err(StampError::Future { ahead_ns });
        }
        match self.last_ns {
            Some(last_ns) if t_device_ns == last_ns => return Err(StampError::Repeated { t_ns: t_device_ns }),
            Some(last_ns) if t_device_ns < last_ns => {
                return Err(StampError::Backwards {
                    t_ns: t_device_ns,
                    last_ns,
                });
            }
            _ => {}
        }
        self.last_ns = Some(t_device_ns);
        Ok(())
    }

    /// The source was silent for so long that its clock may have begun anew: the next frame is the first.
    pub fn forget(&mut self) {
        self.last_ns = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_pass_once_in_order_and_not_from_the_future() {
        let mut stamps = Stamps::default();
        assert_eq!(stamps.admit(10, 100, 100), Ok(()));
        assert_eq!(stamps.admit(10, 100, 100), Err(StampError::Repeated { t_ns: 10 }));
        assert_eq!(
            stamps.admit(9, 100, 100),
            Err(StampError::Backwards { t_ns: 9, last_ns: 10 })
        );
        let ahead_ns = FUTURE_NS + 1;
        assert_eq!(
            stamps.admit(11, 100 + ahead_ns, 100),
            Err(StampError::Future { ahead_ns })
        );
        assert!(stamps.admit(11, i64::MAX, i64::MIN).is_err());
        assert_eq!(stamps.admit(11, 100 + FUTURE_NS, 100), Ok(()));
        stamps.forget();
        assert_eq!(stamps.admit(3, 200, 200), Ok(()));
    }
}
