//! Organs that move: an image waits for the state of its pose, as long as that may be late.
//!
//! In simulated time, and where a replay has states made again, images wait until the state is there; a replay sends the state that
//! it has of a pose before the pose.

use std::time::Duration;

use bus::BusError;
use bus::clock::{self, monotonic_ns};
use bus::message::{ToolPose, Tracked};
use bus::process::Process;
use scene::Plane;

use super::{RunError, SliceView};
use crate::tissue::{States, Tissue};

/// Where time waits for images, a model that has died is waited for so long, on the machine's clock.
const PATIENCE: Duration = Duration::from_secs(10);

/// A pose whose state is being made, in a run whose time waits for it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Awaited {
    sample: ToolPose,
    tracked: Tracked,
    until_ns: i64,
}

/// Images on which tissue lies over itself: the model has folded.
#[derive(Debug, Default)]
pub(super) struct Folded {
    images: u64,
    /// Pixels of the worst one.
    most: usize,
}

impl Folded {
    /// Counts an image, handed over with so many such pixels. The first is told; how many there are since, the status says.
    pub(super) fn count(&mut self, pixels: usize, view: &str, seq: u64) {
        if pixels == 0 {
            return;
        }
        if self.images == 0 {
            bus::stderr_line!(
                "slice-view-proc: warning: {view}, pose {seq}: two places of the tissue claim {pixels} pixels: the model has folded. The image says so; \
                 further ones are only counted"
            );
        }
        self.images += 1;
        self.most = self.most.max(pixels);
    }

    /// For the status and the report.
    pub(super) fn note(&self) -> String {
        match self.images {
            0 => String::new(),
            images => format!(
                "; tissue covered twice on {images} images, {} pixels at most",
                self.most
            ),
        }
    }
}

/// What becomes of the states in the views of a direction; `None` where no organ of the scene moves.
///
/// # Errors
/// [`BusError::Open`].
pub(super) fn open(process: &Process, plane: Plane) -> Result<Option<Tissue>, BusError> {
    let spec = process.scene.tissue.as_ref();
    let spec = spec.filter(|_| plane != Plane::Surface);
    let open = |spec: &scene::TissueSpec| Tissue::open(&process.bus, spec);
    spec.map(open).transpose()
}

impl SliceView {
    /// Takes what came of the tissue. What is refused is told once, and nothing is shown of it.
    pub(super) fn hear_tissue(&mut self, states: Option<&States>) -> Result<(), RunError> {
        let now_ns = self.process.session.clock().now_ns();
        let (Some(states), Some(tissue), Some(volume)) = (states, &mut self.tissue, &self.volume) else {
            return Ok(());
        };
        let before = tissue.refused;
        if let Some(why) = tissue.listen(states, &volume.hash().0, now_ns)? {
            bus::stderr_line!(
                "slice-view-proc: error: {why}. Organs are shown at rest, and images say so; further ones are only counted"
            );
        }
        self.process.counters.refused += tissue.refused - before;
        Ok(())
    }

    /// The pose to be drawn now where time waits for images: `newest`, or the one that was waited for, once its state is there. `None`:
    /// none yet.
    pub(super) fn settled(&mut self, newest: Option<(ToolPose, Tracked)>) -> Option<(ToolPose, Tracked)> {
        let began = newest.map(|(sample, tracked)| Awaited {
            sample,
            tracked,
            until_ns: monotonic_ns().saturating_add(clock::ns(PATIENCE)),
        });
        let awaited = began.or(self.awaited.take())?;
        let Awaited {
            sample,
            tracked,
            until_ns,
        } = awaited;
        let run = &self.process.run;
        let is_made_now = run.simulated_time || run.replay.as_ref().is_some_and(|replay| replay.tissue_again);
        let is_made_now = is_made_now && matches!(tracked, Tracked::Valid(_));
        let Some(tissue) = self
            .tissue
            .as_mut()
            .filter(|tissue| is_made_now && !tissue.answers.has(&sample))
        else {
            return Some((sample, tracked));
        };
        // A model that did not answer is waited for again once it has answered.
        tissue.behind |= monotonic_ns() >= until_ns;
        let waits = !tissue.behind;
        self.awaited = waits.then_some(awaited);
        (!waits).then_some((sample, tracked))
    }

    /// What is shown without the state of its pose, where that has come since.
    pub(super) fn answered_late(&self) -> Option<(ToolPose, Tracked)> {
        let (tissue, (sample, tracked)) = (self.tissue.as_ref()?, self.last?);
        let is_late = tissue.lacked.is_some_and(|of| of == (sample.seq, sample.t_capture_ns));
        (is_late && tissue.answers.has(&sample)).then_some((sample, tracked))
    }

    /// Draws the newest pose that is answered, or the newest of all where states are late; whether there was one.
    pub(super) fn draw_answered(&mut self) -> Result<bool, RunError> {
        let Some(place) = self.answered() else {
            return self.draw_overdue();
        };
        self.pass_over(place);
        let Some((sample, pose)) = self.pending.pop_front() else {
            return Ok(false);
        };
        self.draw_now(&sample, Tracked::Valid(pose))?;
        Ok(true)
    }

    /// The place of that pose among those that wait.
    fn answered(&mut self) -> Option<usize> {
        let now_ns = self.process.session.clock().now_ns();
        let tissue = self.tissue.as_mut()?;
        let newest = self.pending.len().checked_sub(1)?;
        let has = |(sample, _): &(ToolPose, _)| tissue.answers.has(sample);
        if let Some(place) = self.pending.iter().rposition(has) {
            return Some(place);
        }
        // By the pose that waits longest: what is shown may be old because poses are rare.
        let is_late = |(sample, _): &(ToolPose, _)| now_ns.saturating_sub(sample.t_capture_ns) > tissue.late_ns;
        let is_late = self.pending.front().is_some_and(is_late);
        tissue.behind |= is_late;
        tissue.behind.then_some(newest)
    }
}
