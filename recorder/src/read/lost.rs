//! Which messages a damaged chunk held: its index still lists when each was captured, and the messages before and behind it
//! say which numbers are missing.

use std::collections::BTreeMap;
use std::fmt;

use mcap::records::{MessageIndex, MessageIndexEntry};

/// The messages of a chunk that cannot be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lost {
    /// By topic, as far as the chunk's index lists them.
    pub topics: Vec<LostTopic>,
    /// The first and the last capture by the chunk's own head, ns; `None` where that cannot be read, or is empty.
    pub span_ns: Option<(u64, u64)>,
}

/// The messages of one topic among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LostTopic {
    /// The topic; `channel N` where it was never declared.
    pub topic: String,
    /// How many.
    pub count: u64,
    /// The first and the last capture, ns.
    pub span_ns: (u64, u64),
    /// Which.
    pub numbers: Numbers,
}

/// The sequence numbers of messages that cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Exactly these, first and last: as many are missing between what is readable before and behind.
    Are(u32, u32),
    /// Behind this one, the last that was readable; `None`: nothing is before.
    Behind(Option<u32>),
    /// Between these two, which are readable; there the numbers are not consecutive.
    Between(u32, u32),
    /// Before this one, the first that is readable.
    Before(u32),
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Are(first, last) if first == last => write!(f, "number {first}, "),
            Self::Are(first, last) => write!(f, "numbers {first} to {last}, "),
            Self::Behind(Some(last)) => write!(f, "behind number {last}, "),
            Self::Behind(None) => Ok(()),
            Self::Between(last, next) => write!(f, "between numbers {last} and {next}, "),
            Self::Before(next) => write!(f, "before number {next}, "),
        }
    }
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let span = |(from, to)| format!("captured from {from} ns to {to} ns");
        let topic = |t: &LostTopic| format!("{} of {} ({}{})", t.count, t.topic, t.numbers, span(t.span_ns));
        match (&self.topics[..], self.span_ns) {
            ([], None) => Ok(()),
            ([], Some(between)) => write!(f, "; its messages, {}, are lost", span(between)),
            (topics, _) => {
                let topics: Vec<String> = topics.iter().map(topic).collect();
                write!(f, "; lost are {}", topics.join(", "))
            }
        }
    }
}

/// What is known of a damaged chunk while its neighbours are read.
#[derive(Debug, Default)]
pub(crate) struct Hurt {
    span_ns: Option<(u64, u64)>,
    /// By channel: how many, the first capture and the last.
    listed: BTreeMap<u16, (u64, u64, u64)>,
    /// The last number of a channel before the chunk, or chunks.
    before: BTreeMap<u16, u32>,
}

impl Hurt {
    /// Of a chunk record's body; `before` are the last numbers that were read.
    pub(crate) fn new(body: &[u8], before: &BTreeMap<u16, u32>) -> Self {
        let time = |at: usize| {
            let bytes = body.get(at..at + 8)?;
            Some(u64::from_le_bytes(bytes.try_into().ok()?))
        };
        let span = || Some((time(0)?, time(8)?));
        Self {
            span_ns: span().filter(|(from, to)| from <= to && *to > 0),
            listed: BTreeMap::new(),
            before: before.clone(),
        }
    }

    /// Takes note of an index record behind the chunk.
    pub(crate) fn list(&mut self, index: &MessageIndex) {
        for MessageIndexEntry { log_time, .. } in &index.records {
            let listed = self.listed.entry(index.channel_id).or_insert((0, *log_time, *log_time));
            *listed = (listed.0 + 1, listed.1.min(*log_time), listed.2.max(*log_time));
        }
    }
}

/// The messages of chunks that follow one another, now that it is known which numbers come next.
pub(crate) fn told(hurt: &[Hurt], next: &BTreeMap<u16, u32>, name: impl Fn(u16) -> String) -> Vec<Lost> {
    let total = |channel: u16| -> u64 {
        let counts = hurt.iter().filter_map(|hurt| hurt.listed.get(&channel));
        counts.map(|listed| listed.0).sum()
    };
    let numbers = |place: usize, channel: u16, count: u64| {
        let earlier: u64 = hurt[..place]
            .iter()
            .filter_map(|hurt| hurt.listed.get(&channel))
            .map(|l| l.0)
            .sum();
        // Messages that bear no numbers all have 0.
        let last = hurt[place]
            .before
            .get(&channel)
            .filter(|&&last| last > 0 || next.get(&channel) != Some(&0));
        match (last, next.get(&channel)) {
            (Some(&last), Some(&next)) => {
                let first = u64::from(last) + 1 + earlier;
                match u64::from(next) == u64::from(last) + 1 + total(channel) {
                    // Below `next`, which fits.
                    true => Numbers::Are(first as u32, (first + count - 1) as u32),
                    false => Numbers::Between(last, next),
                }
            }
            (last, None) => Numbers::Behind(last.copied().filter(|&last| last > 0)),
            (None, Some(0)) => Numbers::Behind(None),
            (None, Some(&next)) => Numbers::Before(next),
        }
    };
    let one = |(place, hurt): (usize, &Hurt)| Lost {
        topics: hurt
            .listed
            .iter()
            .map(|(&channel, &(count, from, to))| LostTopic {
                topic: name(channel),
                count,
                span_ns: (from, to),
                numbers: numbers(place, channel, count),
            })
            .collect(),
        span_ns: hurt.span_ns,
    };
    hurt.iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(channel_id: u16, times: &[u64]) -> MessageIndex {
        let entry = |&log_time: &u64| MessageIndexEntry { log_time, offset: 0 };
        MessageIndex {
            channel_id,
            records: times.iter().map(entry).collect(),
        }
    }

    fn hurt(before: u32, times: &[u64]) -> Hurt {
        let body = [&5_u64.to_le_bytes()[..], &9_u64.to_le_bytes()].concat();
        let mut hurt = Hurt::new(&body, &[(1, before)].into());
        hurt.list(&index(1, times));
        hurt
    }

    #[test]
    fn numbers_follow_from_the_neighbours_or_are_bounded_by_them() {
        let two = [hurt(4, &[5, 6]), hurt(4, &[7, 8, 9])];
        let words = |next: &[(u16, u32)]| -> Vec<String> {
            let lost = told(&two, &next.iter().copied().collect(), |channel| format!("/t{channel}"));
            lost.iter().map(ToString::to_string).collect()
        };
        assert_eq!(
            words(&[(1, 10)]),
            [
                "; lost are 2 of /t1 (numbers 5 to 6, captured from 5 ns to 6 ns)",
                "; lost are 3 of /t1 (numbers 7 to 9, captured from 7 ns to 9 ns)",
            ]
        );
        assert!(words(&[(1, 12)])[1].contains("3 of /t1 (between numbers 4 and 12, captured"));
        assert!(words(&[])[0].contains("2 of /t1 (behind number 4, captured"));
        // Of messages that bear no numbers.
        let unnumbered = told(&[hurt(0, &[5])], &[(1, 0)].into(), |_| "/log".to_owned());
        assert_eq!(
            unnumbered[0].to_string(),
            "; lost are 1 of /log (captured from 5 ns to 5 ns)"
        );
    }

    #[test]
    fn a_chunk_without_an_index_is_told_by_its_own_times() {
        let mut hurt = hurt(4, &[]);
        assert_eq!(told(&[hurt], &[].into(), |_| String::new())[0].span_ns, Some((5, 9)));
        hurt = Hurt::new(b"short", &BTreeMap::new());
        assert_eq!(told(&[hurt], &[].into(), |_| String::new())[0].to_string(), "");
    }
}
