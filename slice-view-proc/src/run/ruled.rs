//! Poses that are of no present: of a replay, and in simulated time. Each is drawn in all views.

use bus::clock;
use bus::continuity::Continuity;
use bus::message::{ToolPose, Tracked};

use super::{AGEING, Inlets, RunError, SliceView, follow};
use crate::remarks::Remarks;

impl SliceView {
    /// Takes what came, in its order, and draws the newest of it; where nothing came, lets the images grow old.
    pub(super) fn follow_ruled(&mut self, inlets: &Inlets) -> Result<(), RunError> {
        self.came.clear();
        while self.came.len() < follow::ROOM
            && let Some(pose) = inlets.poses.next()?
        {
            self.came.push(pose);
        }
        // After the poses were taken: their replayer has said before them what time it is.
        let jumped = self.process.session.follow()?;
        if jumped {
            self.forget();
        }
        let mut newest = None;
        for k in 0..self.came.len() {
            let sample = self.came[k];
            if jumped && self.process.session.is_yet_to_come(sample.t_publish_ns) {
                continue;
            }
            // See `recorder::replay::lead`.
            if self
                .places
                .is_before_the_place(&self.process.session, sample.t_publish_ns)
            {
                self.lead(&sample);
                continue;
            }
            self.places.came();
            newest = Some((sample, self.take(sample)));
        }
        if newest.is_some() {
            // A replay sends the state of a pose before the pose: it may have come since this turn began.
            self.hear_tissue(inlets.states.as_ref())?;
        }
        match self.settled(newest) {
            Some((sample, tracked)) => self.draw_now(&sample, tracked),
            // What is shown grows no older: its time stands still.
            None if self.awaited.is_some() => Ok(()),
            None => match self.answered_late() {
                Some((sample, tracked)) => self.draw_now(&sample, tracked),
                None => self.age(),
            },
        }
    }

    /// A replay went elsewhere: what was shown last is neither old nor the one before what comes.
    fn forget(&mut self) {
        self.continuity = Continuity::default();
        self.places.jumped();
        self.remarks = Remarks::default();
        self.last = None;
        self.last_valid = None;
        self.pending.clear();
        self.awaited = None;
        self.quiet_until_ns = self.process.clock().now_ns() + clock::ns(AGEING);
    }

    /// Takes note of a sample from before the place that a replay went to: what comes is judged beside it, and it is not drawn. Where
    /// nothing comes, what it was then is what there is.
    fn lead(&mut self, sample: &ToolPose) {
        let Ok(tracked) = sample.tracked() else { return };
        let frozen_ns = self.process.scene.frozen().map(clock::ns);
        let judged = self.continuity.lead(sample, tracked, frozen_ns);
        self.remarks.led();
        self.last = Some((*sample, judged.tracked));
        self.last_valid = match judged.tracked {
            Tracked::Valid(pose) => Some((pose, sample.t_capture_ns)),
            Tracked::Lost(_) => None,
        };
        self.drawn = None;
        self.quiet_until_ns = self.process.clock().now_ns() + clock::ns(AGEING);
    }
}
