//! What is answered to who asks for the clock.

/// Two moments of the run's clock ([`bus::clock::far`]), and whose clock it is: another run behind the same address has another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClockAnswer {
    /// When the question was heard, ns on the run's clock.
    pub heard_ns: i64,
    /// When it was answered.
    pub answered_ns: i64,
    /// The run, as [`crate::protocol::Facts::run_id`].
    pub run: u64,
    /// Drawn anew by each sender.
    pub sender: u64,
}

impl ClockAnswer {
    /// Its bytes, little-endian.
    pub fn bytes(&self) -> Vec<u8> {
        let signed = [self.heard_ns, self.answered_ns].map(i64::to_le_bytes);
        let unsigned = [self.run, self.sender].map(u64::to_le_bytes);
        [signed.concat(), unsigned.concat()].concat()
    }

    /// The answer that `bytes` are; `None` where they are none.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (numbers, rest) = bytes.as_chunks::<8>();
        let [heard, answered, run, sender] = numbers else {
            return None;
        };
        rest.is_empty().then_some(Self {
            heard_ns: i64::from_le_bytes(*heard),
            answered_ns: i64::from_le_bytes(*answered),
            run: u64::from_le_bytes(*run),
            sender: u64::from_le_bytes(*sender),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_and_nothing_else_is_taken_for_one() {
        let answer = ClockAnswer {
            heard_ns: -1,
            answered_ns: i64::MAX,
            run: 7,
            sender: u64::MAX,
        };
        let bytes = answer.bytes();
        assert_eq!(ClockAnswer::read(&bytes), Some(answer));
        assert_eq!(ClockAnswer::read(&bytes[1..]), None);
        assert_eq!(ClockAnswer::read(&[bytes, vec![0]].concat()), None);
    }
}
