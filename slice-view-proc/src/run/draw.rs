//! Drawing and handing over, local views first.
//!
//! A renderer that is slower than its poses passes poses over, by [`Stride`](crate::stride::Stride). Its global views have a stride of
//! their own, which is the first to grow: they show where the tube is in the body, which changes less than what lies before its tip.

use bus::clock;
use bus::message::{FrameStamp, FrameState, TissueShown, ToolPose};
use geometry::{Ct, Rigid, Tool};

use super::{RunError, SliceView};
use crate::accuracy::Accuracy;
use crate::output::Output;
use crate::overlay::Notice;
use crate::remarks::UNJUDGED;
use crate::render::Rendered;
use crate::reslice::Resampler;
use crate::shot::Shot;
use crate::tissue::Tissues;

/// No view is passed over for so long that its pose comes to have more than this part of the age at which it is stale.
const LONGEST_WAIT: f64 = 0.5;

/// What is drawn.
struct Drawing<'a> {
    sample: &'a ToolPose,
    pose: Option<Rigid<Ct, Tool>>,
    notice: Notice,
    /// When the sample was seen, on the session's clock.
    t_seen_ns: i64,
}

impl SliceView {
    /// Draws every view of this process.
    pub(super) fn draw(
        &mut self,
        sample: &ToolPose,
        pose: Option<Rigid<Ct, Tool>>,
        notice: Notice,
    ) -> Result<(), RunError> {
        self.process.counters.published += 1;
        let drawing = Drawing {
            sample,
            pose,
            notice,
            t_seen_ns: self.process.session.clock().now_ns(),
        };
        self.draw_some(&drawing, |_| true)
    }

    /// Draws the views of a pose: the global ones of the poses that their own stride takes, and of others where their image would else
    /// grow too old. A replay and simulated time are to give each image of each pose.
    pub(super) fn draw_live(&mut self, sample: &ToolPose, pose: Rigid<Ct, Tool>) -> Result<(), RunError> {
        self.process.counters.published += 1;
        let session = &self.process.session;
        let (t_seen_ns, is_ruled) = (session.clock().now_ns(), session.is_ruled());
        let is_taken = is_ruled || self.strides.global.takes(sample.seq);
        let (oldest_ns, next_ns) = (self.oldest_ns(), self.until_next_ns());
        for output in &mut self.outputs {
            // Until the next pose is here that is drawn, and this view drawn of it.
            let until_ns = next_ns.saturating_add(output.took_ns);
            let is_young = output
                .live_from_ns
                .is_some_and(|captured| (t_seen_ns - captured).saturating_add(until_ns) < oldest_ns);
            output.waits = !is_taken && output.may_wait() && is_young;
        }
        let drawing = Drawing {
            sample,
            pose: Some(pose),
            notice: Notice::Live,
            t_seen_ns,
        };
        self.draw_some(&drawing, |output| !output.waits)
    }

    /// No image is left standing for want of a rule beyond this age of its pose, ns.
    pub(super) fn oldest_ns(&self) -> i64 {
        clock::ns(self.process.scene.limits.stale.mul_f64(LONGEST_WAIT))
    }

    /// Hears what a person chose. Gives the moment whose choice an image shows: when its pose was captured, and now where it is old
    /// or has none.
    fn hear_choice(&mut self, drawing: &Drawing<'_>) -> Result<i64, RunError> {
        if let Some(why) = self.chosens.listen(&self.guides)? {
            bus::stderr_line!("slice-view-proc: error: {why}. Nothing of it is shown; further ones are only counted");
        }
        self.process.counters.refused += std::mem::take(&mut self.chosens.refused_since);
        Ok(match drawing.notice {
            Notice::Live | Notice::Requested => drawing.sample.t_capture_ns,
            Notice::Stale(_) | Notice::Lost(..) | Notice::Look => drawing.t_seen_ns,
        })
    }

    /// Draws and publishes the views that are `chosen`.
    fn draw_some(&mut self, drawing: &Drawing<'_>, chosen: impl Fn(&Output) -> bool) -> Result<(), RunError> {
        let chosen_ns = self.hear_choice(drawing)?;
        let Some(volume) = &self.volume else { return Ok(()) };
        let said = self.chosens.at(chosen_ns);
        let images = said.map(|said| said.images).unwrap_or_default();
        let (sample, t_seen_ns) = (drawing.sample, drawing.t_seen_ns);
        let is_held = drawing.notice == Notice::Requested;
        let clock = self.process.session.clock();
        // What was asked for says nothing of the present.
        let mut remarks = match is_held {
            true => Vec::new(),
            false => self.remarks.words(clock.now_ns()),
        };
        let shows_it = matches!(drawing.notice, Notice::Live | Notice::Stale(_) | Notice::Requested);
        let is_unjudged = shows_it && self.process.session.is_unjudged(sample.t_publish_ns);
        if is_unjudged && !remarks.contains(&UNJUDGED) {
            remarks.push(UNJUDGED);
        }
        let mut what = Rendered {
            volume: volume.view(),
            volume_name: &self.volume_name,
            marks: volume.header().marks(),
            pose: drawing.pose,
            accuracy: drawing.pose.map(|pose| Accuracy::of(sample, pose)),
            notice: drawing.notice,
            origin: self.origin,
            remarks: &remarks,
            chosen: said.and_then(|said| said.chosen.as_ref()),
            seq: sample.seq,
            registration_id: sample.registration_id,
            tissue: Tissues::default(),
        };
        let scene = &self.process.scene;
        let stale_ns = clock::ns(scene.limits.stale);
        let (mut are_all, mut lacks_state) = (true, false);
        for output in &mut self.outputs {
            if !chosen(output) {
                are_all = false;
                continue;
            }
            // An image that claims to be live must be handed over while its pose is young. A machine that was held up
            // in between draws it again, with its age.
            let began_ns = clock.now_ns();
            loop {
                let shot = Shot {
                    sample,
                    // A replay has the state of a pose with it, or has none.
                    now_ns: (!self.process.session.is_ruled()).then(|| clock.now_ns()),
                    scene,
                    images: &images,
                    tissue: self.tissue.as_ref().map(|tissue| &tissue.answers),
                };
                // Whoever asks for an image can ask for the same again, and is given the same.
                let resampler: &mut dyn Resampler = match is_held {
                    true => self.resampler.exact(),
                    false => &mut self.resampler,
                };
                let stamp = shot.take(&mut output.renderer, &mut what, resampler)?;
                let stamp = FrameStamp {
                    volume_hash: volume.hash().0,
                    view: output.index,
                    t_seen_ns,
                    t_rendered_ns: clock.now_ns(),
                    ..stamp
                };
                let latest_ns = match what.notice {
                    Notice::Live => sample.t_capture_ns.saturating_add(stale_ns),
                    _ => i64::MAX,
                };
                if let Some(sent) = output.send(stamp, clock, latest_ns)? {
                    self.stamps.send(sent)?;
                    let (renderer, seq) = (&output.renderer, sample.seq);
                    self.folded.count(renderer.covered_twice(), &renderer.view().name, seq);
                    break;
                }
                what.notice = Notice::Stale(clock.now_ns() - sample.t_capture_ns);
            }
            if !is_held {
                lacks_state |= what.tissue.shown == TissueShown::Late;
                output.waits = false;
                output.took_ns = clock.now_ns() - began_ns;
                output.live_from_ns = (what.notice == Notice::Live).then_some(sample.t_capture_ns);
            }
        }
        if !is_held {
            let state = what.notice.state();
            // Some views stale and others not: all are due at the next turn.
            let is_one = are_all || state == FrameState::Live;
            self.drawn = is_one.then_some((state, t_seen_ns));
            if let Some(tissue) = &mut self.tissue {
                tissue.lacked = lacks_state.then_some((sample.seq, sample.t_capture_ns));
            }
        }
        Ok(())
    }
}
