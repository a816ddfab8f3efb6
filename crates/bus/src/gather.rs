//! Images of one and the same pose, gathered from views that are drawn by several processes.
//!
//! Renderers pass poses over each by itself where they fall behind, so that the newest images of all views show different poses in many
//! moments on a busy machine. A viewer puts what comes into a [`Gather`] and shows what it says: the newest pose that all views have,
//! or, where there is none that is young enough, the newest image of each with a mark that says how far they differ.
//!
//! Pure: images, stamps and the time are handed in. Memory is bounded: of each view at most [`KEPT`] images are held.

use std::collections::VecDeque;

use crate::message::FrameStamp;

/// Images of a view that are held at most: that of the set shown, and two that gather.
pub const KEPT: usize = 3;

/// Which pose an image shows. A source that was started again counts from zero, so that the number alone does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PoseId {
    /// Sequence number of the pose.
    pub seq: u64,
    /// When it was captured, ns on the session's clock.
    pub t_capture_ns: i64,
}

impl PoseId {
    /// That of an image.
    pub fn of(stamp: &FrameStamp) -> Self {
        Self {
            seq: stamp.seq,
            t_capture_ns: stamp.t_capture_ns,
        }
    }
}

/// What is to be shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// All views show this pose.
    One(PoseId),
    /// The newest image of each view, which show different poses, or not all views have one: whoever shows them says so.
    Mixed {
        /// Between the least and the largest sequence number; at least 1 where two views show different poses.
        poses: u64,
        /// Views without any image.
        missing: usize,
    },
}

/// The images of all views that may yet be shown. `F` is an image, or whatever stands for one.
#[derive(Debug)]
pub struct Gather<F> {
    /// Of each view, in the order in which they came.
    views: Vec<VecDeque<(PoseId, F)>>,
    /// The pose that was shown last in all views.
    shown: Option<PoseId>,
}

impl<F> Gather<F> {
    /// For so many views.
    pub fn new(views: usize) -> Self {
        Self {
            views: (0..views).map(|_| VecDeque::with_capacity(KEPT + 1)).collect(),
            shown: None,
        }
    }

    /// An image of a view has come. Where there is no room, the oldest gives way, but not that of the set shown. An image of a view
    /// that there is not is dropped.
    pub fn put(&mut self, view: usize, pose: PoseId, frame: F) {
        let Some(held) = self.views.get_mut(view) else { return };
        // The same pose drawn again, as when an image has grown old: what was drawn later is true.
        held.retain(|(other, _)| *other != pose);
        held.push_back((pose, frame));
        if held.len() > KEPT {
            let oldest = held.iter().position(|(other, _)| Some(*other) != self.shown);
            oldest.and_then(|k| held.remove(k));
        }
    }

    /// What to show at `now_ns`; `stale_ns` is the age from which a pose counts as old.
    ///
    /// A pose that all views have is shown while it is younger than `stale_ns`, and for as long as no view has a later image: where
    /// everything stands still, the images themselves say that they are old.
    pub fn decide(&mut self, now_ns: i64, stale_ns: i64) -> Option<Set> {
        let newest = self.newest_of_all();
        let is_young = |pose: PoseId| now_ns.saturating_sub(pose.t_capture_ns) <= stale_ns;
        self.shown = newest.filter(|pose| is_young(*pose) || self.is_last(*pose));
        match self.shown {
            Some(pose) => Some(Set::One(pose)),
            None => self.mixed(),
        }
    }

    /// What [`Gather::decide`] said last, view by view; `None` where a view has no image.
    pub fn frames(&self) -> impl Iterator<Item = Option<&F>> {
        self.views.iter().map(|held| {
            let of_set = held.iter().find(|(pose, _)| Some(*pose) == self.shown);
            of_set.or(held.back()).map(|(_, frame)| frame)
        })
    }

    /// The pose that all views have and that came last to the first of them. By arrival, not by time: a replay may go back.
    fn newest_of_all(&self) -> Option<PoseId> {
        let (first, others) = self.views.split_first()?;
        let has = |held: &VecDeque<(PoseId, F)>, pose: PoseId| held.iter().any(|(other, _)| *other == pose);
        let mut poses = first.iter().rev().map(|(pose, _)| *pose);
        poses.find(|pose| others.iter().all(|held| has(held, *pose)))
    }

    /// Whether no view has a later image.
    fn is_last(&self, pose: PoseId) -> bool {
        self.views
            .iter()
            .all(|held| held.back().is_some_and(|(last, _)| *last == pose))
    }

    fn mixed(&self) -> Option<Set> {
        let last = || self.views.iter().filter_map(|held| Some(held.back()?.0));
        let (least, most) = (last().map(|pose| pose.seq).min()?, last().map(|pose| pose.seq).max()?);
        let first = last().next()?;
        Some(Set::Mixed {
            poses: (most - least).max(u64::from(last().any(|pose| pose != first))),
            missing: self.views.iter().filter(|held| held.is_empty()).count(),
        })
    }
}

#[cfg(test)]
mod tests;
