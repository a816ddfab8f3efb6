//! What is read of the recording beside the replay, and what of it cannot be read.

use std::time::Duration;

use bus::BusError;
use bus::clock;

use super::Replayer;
use crate::replay::bar::Bar;
use crate::replay::heads::Heads;
use crate::report::basis::Limits;

/// What is only read beside the replay begins when the first pose has gone out, or this long after the start.
const BESIDE: Duration = Duration::from_millis(500);

/// What reads the recording beside the replay.
pub(super) struct Reading {
    pub(super) heads: Heads,
    /// Where a window shows a bar.
    pub(super) bar: Option<Bar>,
}

impl Replayer<'_> {
    /// Begins to read beside the replay, once the first image waits for nothing of it.
    pub(super) fn read_beside(&mut self, now_ns: i64, limits: Limits) {
        if self.beside.is_some() || (self.published == 0 && now_ns - self.began_ns < clock::ns(BESIDE)) {
            return;
        }
        let recording = &self.options.recording;
        self.beside = Some(Reading {
            heads: Heads::begin(recording),
            bar: self.timelines.is_some().then(|| Bar::begin(recording, limits)),
        });
    }

    pub(super) fn tell_timeline(&mut self) -> Result<(), BusError> {
        let (Some(timelines), Some(Reading { bar: Some(bar), .. })) = (&self.timelines, &self.beside) else {
            return Ok(());
        };
        timelines.serve_late_joiners();
        bar.news().map_or(Ok(()), |timeline| timelines.send(*timeline))
    }

    /// Says once what cannot be read of the recording.
    pub(super) fn say_unread(&mut self) {
        let unread = self.unread();
        if unread.len() == self.said.len() {
            return;
        }
        for words in unread.iter().filter(|words| !self.said.contains(words)) {
            bus::stderr_line!("replay: {}, {words}: left out", self.options.recording.display());
        }
        self.said = unread;
    }

    /// What cannot be read of the recording, in words.
    pub(super) fn unread(&self) -> Vec<String> {
        let heads = self.beside.as_ref().map(|beside| beside.heads.found());
        [self.tape.unread(), self.unread.clone(), heads.unwrap_or_default()].concat()
    }
}
