//! One image of one sample with its stamp: the same in a run, in a replay and out of a recording.

use bus::message::{Chosen, FrameStamp, Images, TargetShown, TissueHeader, TissueShown, ToolPose};
use scene::Scene;

use crate::overlay::{Notice, covered_twice};
use crate::render::{RenderError, Rendered, Renderer};
use crate::reslice::Resampler;
use crate::tissue::{Answers, Tissues};

/// What an image is of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shot<'a> {
    /// The sample.
    pub(crate) sample: &'a ToolPose,
    /// Now, where a state may come late: not where time waits for images.
    pub(crate) now_ns: Option<i64>,
    pub(crate) scene: &'a Scene,
    /// How a person wants images to look.
    pub(crate) images: &'a Images,
    /// Where organs are, where any of the scene move.
    pub(crate) tissue: Option<&'a Answers>,
}

impl<'a> Shot<'a> {
    /// Draws `what` of it, with the tissue that is to be shown; its stamp, without volume, view and times.
    ///
    /// # Errors
    /// [`RenderError`]; organs that cannot be drawn leave the examination as it was taken, and the image says so.
    pub(crate) fn take(
        &self,
        renderer: &mut Renderer,
        what: &mut Rendered<'a>,
        resampler: &mut dyn Resampler,
    ) -> Result<FrameStamp, RenderError> {
        // Through a slab organs are not followed, nor where a person wishes to see the examination as it was taken.
        let is_rigid = renderer.view().sampling.slab.is_some() || self.images.at_rest;
        what.tissue = self.shown(what.notice, is_rigid);
        renderer.show(self.images);
        let mut why = match what.tissue.shown {
            TissueShown::Refused => what.tissue.errors.map_or("", TissueHeader::why).to_owned(),
            _ => String::new(),
        };
        match renderer.render(what, self.scene, resampler) {
            // Of the examination there is an image all the same.
            Err(refused @ (RenderError::Organs(_) | RenderError::Model(_))) => {
                why = refused.to_string();
                what.tissue = Tissues::refused();
                renderer.render(what, self.scene, resampler)?;
            }
            drawn => drop(drawn?),
        }
        // A folded model is told by its name in whatever keeps the stamp, as a refused pose is.
        let pixels = renderer.covered_twice();
        if why.is_empty() && pixels > 0 {
            why = covered_twice(pixels);
        }
        let shown = (&what.tissue, what.chosen);
        Ok(stamped(stamp_of(self.sample, what), self.tissue, shown).refused_because(&why))
    }

    /// What an image shows of the tissue; nothing is said where the scene moves none. `is_rigid` where organs are not followed.
    fn shown(&self, notice: Notice, is_rigid: bool) -> Tissues<'a> {
        if self.scene.tissue.is_none() {
            return Tissues::default();
        }
        let Some(tissue) = self.tissue.filter(|_| !is_rigid) else {
            return Tissues::rigid();
        };
        match notice {
            Notice::Lost(..) | Notice::Look => Tissues::rigid(),
            Notice::Requested => tissue.shown(self.sample, None),
            Notice::Live | Notice::Stale(_) => tissue.shown(self.sample, self.now_ns),
        }
    }
}

/// What the stamp of an image takes from its pose; volume, view and times are the caller's to add.
fn stamp_of(sample: &ToolPose, what: &Rendered<'_>) -> FrameStamp {
    FrameStamp {
        seq: sample.seq,
        t_device_ns: sample.t_device_ns,
        t_capture_ns: sample.t_capture_ns,
        t_publish_ns: sample.t_publish_ns,
        registration_id: sample.registration_id,
        state: what.notice.state().code(),
        on_request: u32::from(what.notice == Notice::Requested),
        replay: what.origin.code(),
        ..FrameStamp::default()
    }
}

/// What a stamp says of the tissue, and of where it has the chosen target.
fn stamped(
    stamp: FrameStamp,
    tissue: Option<&Answers>,
    (shown, chosen): (&Tissues<'_>, Option<&Chosen>),
) -> FrameStamp {
    let target = chosen.map(|chosen| shown.target(chosen.centre));
    let (place, whereabouts) = target.map_or(([0.0; 3], TargetShown::None), |(place, shown)| (place.mm(), shown));
    let (force_n, error) = shown.force_n.unwrap_or((-1.0, None));
    FrameStamp {
        force_n,
        force_95_n: error.unwrap_or(-1.0),
        target_mm: chosen.map_or([0.0; 3], |chosen| chosen.centre.mm()),
        target_shown_mm: place,
        target: whereabouts.code(),
        tissue: shown.shown.code(),
        tissue_seq: shown.seq,
        tissue_mesh: tissue.map_or(0, Answers::mesh),
        ..stamp
    }
}

#[cfg(test)]
mod tests;
