//! Which part of a recording's time there was a pose, an old one, or none, and why.
//!
//! The clock is that of the captures. A moment counts by the newest sample that was published by then: valid and not older than the scene's
//! `stale_ms` is live, older is stale, older than `lost_ms` is lost; a sample without a pose is lost for its reason. Where numbers
//! are missing between two samples, what is older than `stale_ms` there is lost: whether they were never made or never recorded,
//! nobody knows. Where the file is damaged between them it is *not readable*. Each ns counts once, so that all times add up to the
//! recording's.

use std::collections::VecDeque;

use bus::message::{Ages, FrameState, Lost};
use serde::Serialize;

use super::columns::{Cell, Columns};

/// A line of the log may be written so much later than samples that were captured behind it, ns and pieces of time.
const LATE_NS: i64 = 10_000_000_000;
const LATE: usize = 8192;
/// The longest times without a pose that are named.
const NAMED: usize = 10;
/// The reasons of poses that are lost, and six more.
const COUNT: usize = 6 + Lost::ALL.len();

/// The reason that is none of the tracker's.
const MISSING: &str = "samples missing";

/// What lies between a sample and the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// They follow on each other.
    Nothing,
    /// Numbers are missing.
    Missing,
    /// A part of the file that cannot be read.
    Damage,
}

/// What a moment was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Before the first sample.
    NotYet,
    /// There was a pose, young enough.
    Live,
    /// There was an old one.
    Stale,
    /// There was none.
    Lost(Lost),
    /// There was none: samples are missing.
    Missing,
    /// The file is damaged there.
    NotReadable,
    /// The run was being ended.
    Ending,
}

impl State {
    fn place(self) -> usize {
        match self {
            Self::NotYet => 0,
            Self::Live => 1,
            Self::Stale => 2,
            Self::Missing => 3,
            Self::NotReadable => 4,
            Self::Ending => 5,
            Self::Lost(reason) => 5 + reason.code() as usize,
        }
    }

    /// All of them.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let reasons = Lost::ALL.into_iter().map(Self::Lost);
        [Self::NotYet, Self::Live, Self::Stale]
            .into_iter()
            .chain(reasons)
            .chain([Self::Missing, Self::NotReadable, Self::Ending])
    }

    /// Why there was no pose, where there was none.
    fn why_lost(self) -> Option<&'static str> {
        match self {
            Self::Lost(reason) => Some(reason.words()),
            Self::Missing => Some(MISSING),
            _ => None,
        }
    }

    /// In words.
    pub(super) fn words(self) -> String {
        match self {
            Self::NotYet => "no sample yet".to_owned(),
            Self::Live => "live".to_owned(),
            Self::Stale => "stale".to_owned(),
            Self::Lost(reason) => format!("lost: {}", reason.words()),
            Self::Missing => format!("lost: {MISSING}"),
            Self::NotReadable => "not readable".to_owned(),
            Self::Ending => "run ending".to_owned(),
        }
    }
}

/// The time of each state, ns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Shares([u64; COUNT]);

impl Shares {
    /// ns.
    pub(super) fn of(&self, state: State) -> u64 {
        self.0[state.place()]
    }

    fn add(&mut self, state: State, ns: u64) {
        self.0[state.place()] += ns;
    }
}

impl Cell for Shares {
    fn take(&mut self, later: Self) {
        self.0.iter_mut().zip(later.0).for_each(|(sum, ns)| *sum += ns);
    }
}

/// A time without a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct LostSpan {
    /// ns since the run's epoch.
    pub(super) from_ns: i64,
    /// ns since the run's epoch.
    pub(super) to_ns: i64,
    /// Why, at its beginning.
    pub(super) why: &'static str,
}

/// What was found.
#[derive(Debug, Clone, Default)]
pub(super) struct States {
    /// From when to when, ns.
    pub(super) span_ns: (i64, i64),
    /// The time of each state; all together are the span.
    pub(super) totals: Shares,
    /// The same over time.
    pub(super) columns: Columns<Shares>,
    /// How many times there was no pose.
    pub(super) lost_times: u64,
    /// The longest, the longest first.
    pub(super) longest: Vec<LostSpan>,
}

/// Follows the samples of a recording.
#[derive(Debug, Clone)]
pub(super) struct Timeline {
    ages: Ages,
    newest: Option<(i64, Option<Lost>)>,
    first_ns: i64,
    at_ns: i64,
    ending_ns: Option<i64>,
    /// Pieces of time that may still turn out to lie behind the end of the run.
    pending: VecDeque<(State, i64, i64)>,
    open: Option<LostSpan>,
    states: States,
}

impl Timeline {
    /// With the limits of a scene.
    pub(super) fn new(ages: Ages) -> Self {
        Self {
            ages,
            newest: None,
            first_ns: 0,
            at_ns: 0,
            ending_ns: None,
            pending: VecDeque::new(),
            open: None,
            states: States::default(),
        }
    }

    /// Whether there has been a sample.
    pub(super) fn has_begun(&self) -> bool {
        self.newest.is_some()
    }

    /// Takes the scene's limits; of effect before the first sample only.
    pub(super) fn limits(&mut self, ages: Ages) {
        if !self.has_begun() {
            self.ages = ages;
        }
    }

    /// From here on the run was being ended.
    pub(super) fn ends(&mut self, t_ns: i64) {
        self.ending_ns.get_or_insert(t_ns);
    }

    /// A sample of `t_ns` that was published at `known_ns`: why it has no pose, and what lies between it and the one before.
    pub(super) fn sample(&mut self, [t_ns, known_ns]: [i64; 2], lost: Option<Lost>, between: Between) {
        // Nobody waits for pieces of time longer than for late lines of the log.
        let known_ns = known_ns.clamp(t_ns, t_ns.saturating_add(LATE_NS / 2));
        if !self.has_begun() {
            (self.first_ns, self.at_ns) = (known_ns, known_ns);
        }
        self.account(known_ns, between);
        self.newest = Some((t_ns, lost));
    }

    /// The recording goes from `from_ns` to `to_ns`; `last` lies behind its last sample.
    pub(super) fn finish(mut self, from_ns: i64, to_ns: i64, last: Between) -> States {
        if !self.has_begun() {
            self.put(State::NotYet, from_ns, to_ns);
        } else {
            self.account(to_ns, last);
            // What was published behind the last capture is of no moment of the recording.
            self.pending.retain_mut(|(_, from, end_ns)| {
                *end_ns = (*end_ns).min(to_ns);
                *from < *end_ns
            });
            while !self.pending.is_empty() {
                self.put_oldest();
            }
            let first_ns = self.first_ns.min(to_ns);
            self.put(State::NotYet, from_ns, first_ns);
        }
        self.close();
        self.states.span_ns = (from_ns, to_ns);
        self.states
    }

    fn account(&mut self, to_ns: i64, between: Between) {
        let Some((t_ns, lost)) = self.newest else { return };
        let or_unknown = |state| match between {
            Between::Nothing => state,
            Between::Missing => State::Missing,
            Between::Damage => State::NotReadable,
        };
        let fresh = lost.map_or(State::Live, State::Lost);
        let aged = lost.map_or(State::Stale, State::Lost);
        let ends = [
            (t_ns.saturating_add(self.ages.stale_ns), fresh),
            (t_ns.saturating_add(self.ages.lost_ns), or_unknown(aged)),
            (i64::MAX, or_unknown(State::Lost(Lost::Silent))),
        ];
        debug_assert!(matches!(self.ages.state(i64::MAX), FrameState::Lost(Lost::Silent)));
        for (end_ns, state) in ends {
            let end_ns = end_ns.min(to_ns);
            if end_ns > self.at_ns {
                let from_ns = std::mem::replace(&mut self.at_ns, end_ns);
                self.hold(state, from_ns, end_ns);
            }
        }
    }

    fn hold(&mut self, state: State, from_ns: i64, to_ns: i64) {
        match self.pending.back_mut() {
            Some((last, _, end_ns)) if *last == state => *end_ns = to_ns,
            _ => self.pending.push_back((state, from_ns, to_ns)),
        }
        let is_old = |end_ns: i64| end_ns < to_ns.saturating_sub(LATE_NS);
        while self.pending.len() > LATE || self.pending.front().is_some_and(|&(.., end_ns)| is_old(end_ns)) {
            self.put_oldest();
        }
    }

    fn put_oldest(&mut self) {
        if let Some((state, from_ns, to_ns)) = self.pending.pop_front() {
            self.put(state, from_ns, to_ns);
        }
    }

    fn put(&mut self, state: State, from_ns: i64, to_ns: i64) {
        let parting_ns = self.ending_ns.map_or(to_ns, |t_ns| t_ns.clamp(from_ns, to_ns));
        for (state, from_ns, to_ns) in [(state, from_ns, parting_ns), (State::Ending, parting_ns, to_ns)] {
            if to_ns <= from_ns {
                continue;
            }
            self.states.totals.add(state, (to_ns - from_ns).unsigned_abs());
            self.states
                .columns
                .along(from_ns, to_ns, |column, ns| column.add(state, ns));
            match (state.why_lost(), &mut self.open) {
                (Some(_), Some(open)) => open.to_ns = to_ns,
                (Some(why), None) => self.open = Some(LostSpan { from_ns, to_ns, why }),
                _ => self.close(),
            }
        }
    }

    fn close(&mut self) {
        let Some(span) = self.open.take() else { return };
        let length = |span: &LostSpan| span.to_ns - span.from_ns;
        let longest = &mut self.states.longest;
        let place = longest.partition_point(|other| length(other) >= length(&span));
        longest.insert(place, span);
        longest.truncate(NAMED);
        self.states.lost_times += 1;
    }
}

#[cfg(test)]
mod tests;
