//! From the poses that came to the one that is drawn, where poses are of the present: see [`crate::stride`].

use bus::clock;
use bus::message::{FrameState, ToolPose, Tracked};
use bus::port::Subscriber;

use super::{RunError, SliceView};
use crate::output::Output;
use crate::stride::{Drew, Stride, choose};

/// Poses that wait at most; where more come, the oldest give way.
pub(super) const ROOM: usize = 16;
/// Poses drawn in one turn, so that requests and signs of life have theirs.
const A_TURN: usize = 4;

/// Which poses are drawn.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Strides {
    /// In any view.
    pub(super) local: Stride,
    /// In the global views too.
    pub(super) global: Stride,
}

impl SliceView {
    /// Draws of what has come what the stride takes; where nothing came, lets the images grow old.
    pub(super) fn follow(&mut self, poses: &Subscriber<ToolPose>) -> Result<(), RunError> {
        self.process.session.follow()?;
        // Another machine's clock: until it is known nobody can say how old a pose is.
        if !self.process.session.is_known() {
            return self.age();
        }
        for _ in 0..A_TURN {
            let came = self.take_all(poses)?;
            let drew = match self.last {
                Some((_, Tracked::Valid(_))) if self.tissue.is_some() => self.draw_answered()?,
                Some((_, Tracked::Valid(_))) => self.draw_chosen()?,
                // Whatever is lost is told at once.
                Some((sample, lost)) if came => {
                    self.pass_over(self.pending.len());
                    self.draw_now(&sample, lost)?;
                    true
                }
                _ => false,
            };
            if !drew {
                return self.age();
            }
        }
        Ok(())
    }

    /// Takes all that came off the bus, in its order; whether anything did.
    fn take_all(&mut self, poses: &Subscriber<ToolPose>) -> Result<bool, RunError> {
        let mut came = false;
        while let Some(sample) = poses.next()? {
            came = true;
            if let Tracked::Valid(pose) = self.take(sample) {
                if self.pending.len() == ROOM {
                    self.pass_over(1);
                }
                self.pending.push_back((sample, pose));
            }
        }
        Ok(came)
    }

    /// Draws the pose that is chosen of those that wait; whether there was one.
    fn draw_chosen(&mut self) -> Result<bool, RunError> {
        let Some(place) = self.chosen() else {
            return self.draw_overdue();
        };
        let taken = self.pending.iter().take(place);
        let behind = taken.filter(|(sample, _)| self.strides.local.takes(sample.seq)).count() > 0;
        self.pass_over(place);
        let Some((sample, pose)) = self.pending.pop_front() else {
            return Ok(false);
        };
        self.draw_now(&sample, Tracked::Valid(pose))?;
        self.learn(sample.seq, behind);
        Ok(true)
    }

    /// Draws the last pose again where no other waits and some view would grow too old that was passed over for it; whether there
    /// was one.
    pub(super) fn draw_overdue(&mut self) -> Result<bool, RunError> {
        let was_passed = self.pending.is_empty() && self.outputs.iter().any(|output| output.waits);
        match self.last.filter(|_| was_passed && self.is_overdue()) {
            Some((sample, tracked)) => self.draw_now(&sample, tracked).map(|()| true),
            None => Ok(false),
        }
    }

    /// The place of the pose to be drawn now.
    fn chosen(&self) -> Option<usize> {
        let newest = self.pending.len().checked_sub(1)?;
        // What was lost or old is shown again at once.
        if !matches!(self.drawn, Some((FrameState::Live, _))) || self.is_overdue() {
            return Some(newest);
        }
        let seqs = self.pending.iter().map(|(sample, _)| sample.seq);
        let place = choose(seqs, self.strides.local)?;
        // One that has waited too long itself is none that makes the image younger.
        let is_young = |(sample, _): &(ToolPose, _)| self.age_ns(sample) < self.oldest_ns();
        let is_chosen_young = self.pending.get(place).is_some_and(is_young);
        Some(if is_chosen_young { place } else { newest })
    }

    /// Whether an image would grow too old before the next pose is drawn.
    fn is_overdue(&self) -> bool {
        let now_ns = self.process.session.clock().now_ns();
        let is_old = |output: &Output| {
            let from_ns = output.live_from_ns.unwrap_or(i64::MIN);
            now_ns.saturating_sub(from_ns).saturating_add(output.took_ns) >= self.oldest_ns()
        };
        self.outputs.iter().any(is_old)
    }

    /// About when the next pose comes that is drawn, ns from one that is.
    pub(super) fn until_next_ns(&self) -> i64 {
        let every = i64::try_from(self.strides.local.every()).unwrap_or(i64::MAX);
        self.interval_ns.saturating_mul(every)
    }

    /// The oldest that wait are not drawn.
    pub(super) fn pass_over(&mut self, count: usize) {
        self.pending.drain(..count.min(self.pending.len()));
        self.process.counters.dropped += count as u64;
    }

    /// What this drawing says of the strides: that of local views by their cost alone, that of global ones by the cost of all.
    fn learn(&mut self, seq: u64, behind: bool) {
        let took = |is_counted: fn(&Output) -> bool| -> i64 {
            let counted = self.outputs.iter().filter(|output| is_counted(output));
            counted.map(|output| output.took_ns).fold(0, i64::saturating_add)
        };
        let (local_ns, all_ns) = (took(|output| !output.may_wait()), took(|_| true));
        let drew = Drew {
            took_ns: local_ns,
            interval_ns: self.interval_ns,
            behind,
            oldest_ns: clock::ns(self.process.scene.limits.stale) / 2,
        };
        self.strides.local.drew(drew);
        if self.strides.global.takes(seq) {
            self.strides.global.drew(Drew {
                took_ns: all_ns,
                ..drew
            });
        }
    }
}
