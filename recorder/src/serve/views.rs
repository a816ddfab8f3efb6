//! Small images of the views, and what they may claim.

use std::time::Duration;

use bus::clock;
use bus::message::{Ages, FrameState};
use bus::port::{Frame, FrameSubscriber};
use bus::topic::VIEW_FRAME;
use bus::{Bus, BusError};
use geometry::SlicePlane;
use scene::Scene;

use super::label::{Label, small_png};
use super::outlet::Outlet;
use crate::wire::proto::CompressedImage;
use crate::write::pose_log::{Entry, Take};

/// A view, and what was given out of it last.
struct View {
    name: String,
    frames: FrameSubscriber,
    newest: Option<Frame>,
    /// Which of all images that came here the newest is.
    came: u64,
    given: Option<Given>,
    next_ns: i64,
}

/// When an image was handed over, what it could claim when it was given out, and whether it was withheld.
type Given = (i64, Option<FrameState>, bool);

/// The views of a run.
pub(super) struct Views {
    views: Vec<View>,
    ages: Ages,
    every_ns: i64,
    came: u64,
}

/// What an image may claim at a time, and the sample that it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Claim {
    pub(super) seq: u64,
    pub(super) t_capture_ns: i64,
    /// `None` for a code that is not known.
    pub(super) state: Option<FrameState>,
}

impl Views {
    /// Subscribes to the views of `scene`.
    pub(super) fn open(bus: &Bus, scene: &Scene, every: Duration) -> Result<Self, BusError> {
        let views = scene.views.iter().map(|view| {
            Ok(View {
                name: view.name.clone(),
                frames: FrameSubscriber::open(bus, &VIEW_FRAME, &view.name)?,
                newest: None,
                came: 0,
                given: None,
                next_ns: i64::MIN,
            })
        });
        Ok(Self {
            views: views.collect::<Result<_, BusError>>()?,
            ages: Ages::of(&scene.limits),
            every_ns: clock::ns(every),
            came: 0,
        })
    }

    /// Takes the newest images, and gives out one that somebody looks at and that is due, if any is: poses wait while an image is made.
    /// `steady_ns` is of a clock that never stands still.
    pub(super) fn step(
        &mut self,
        (now_ns, steady_ns): (i64, i64),
        label: Label,
        outlet: &mut Outlet,
    ) -> Result<(), BusError> {
        for view in &mut self.views {
            if let Some(frame) = view.frames.newest()? {
                view.newest = Some(frame);
                self.came += 1;
                view.came = self.came;
            }
        }
        let due = self.views.iter_mut().zip(0..).filter_map(|(view, number)| {
            let frame = view.newest.as_ref()?;
            let state = frame.shown(now_ns, self.ages).state;
            let given = (frame.header().stamp.t_framed_ns, state, label.is_withheld);
            // An image that nobody looks at is not made.
            let is_due = is_due(view.given, given, steady_ns >= view.next_ns) && outlet.is_watched(number);
            is_due.then_some((view, number, given))
        });
        // The one that waits for the longest time.
        let Some((view, number, given)) = due.min_by_key(|(view, ..)| view.next_ns) else {
            return Ok(());
        };
        view.given = Some(given);
        view.next_ns = steady_ns.saturating_add(self.every_ns);
        let Some(frame) = &view.newest else { return Ok(()) };
        if let Some(png) = small_png(frame.header(), frame.shown(now_ns, self.ages), label) {
            let stamp = &frame.header().stamp;
            let image = &CompressedImage::png(stamp.t_framed_ns, &view.name, png);
            let (view, seq, t_ns) = (number, stamp.seq, stamp.t_framed_ns);
            outlet.put(now_ns, Entry::Image { view, seq, t_ns, image });
        }
        Ok(())
    }

    /// Gives out every image once more, for who comes late.
    pub(super) fn again(&mut self) {
        self.views.iter_mut().for_each(|view| view.given = None);
    }

    /// What the newest image of the present may claim.
    pub(super) fn claim(&self, now_ns: i64) -> Option<Claim> {
        of_the_present(self.views.iter().filter_map(|view| {
            let frame = view.newest.as_ref()?;
            let stamp = &frame.header().stamp;
            let claim = Claim {
                seq: stamp.seq,
                t_capture_ns: stamp.t_capture_ns,
                state: frame.shown(now_ns, self.ages).state,
            };
            Some((view.came, claim))
        }))
    }

    /// Where the slices lie whose images may claim a pose.
    pub(super) fn planes(&self, now_ns: i64) -> Vec<(String, SlicePlane)> {
        let plane = |view: &View| {
            let frame = view.newest.as_ref()?;
            let state = frame.shown(now_ns, self.ages).state?;
            let is_claimed = matches!(state, FrameState::Live | FrameState::Stale);
            let plane = frame.header().slice_plane().ok().flatten()?;
            is_claimed.then(|| (view.name.clone(), plane))
        };
        self.views.iter().filter_map(plane).collect()
    }
}

/// Whether an image is to be given out where `before` was given out last: it is another and the time has come, or it may claim something
/// else, which is told at once.
fn is_due(before: Option<Given>, now: Given, is_time: bool) -> bool {
    before.is_none_or(|before| before != now && (is_time || (before.1, before.2) != (now.1, now.2)))
}

/// Of claims and when they came. That order counts, and not that of the stamps: a replay that goes back shows images that are older than
/// those before. Images of a pose or a plane that somebody asked for say nothing of the present.
fn of_the_present(claims: impl Iterator<Item = (u64, Claim)>) -> Option<Claim> {
    let asked = |claim: &Claim| matches!(claim.state, Some(FrameState::Requested | FrameState::Look));
    let of_the_present = claims.filter(|(_, claim)| !asked(claim));
    of_the_present.max_by_key(|(came, _)| *came).map(|(_, claim)| claim)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(seq: u64, state: FrameState) -> Claim {
        Claim {
            seq,
            t_capture_ns: seq.cast_signed() * 1000,
            state: Some(state),
        }
    }

    /// With `--every 10s` an image looked live for as long behind its last pose.
    #[test]
    fn what_an_image_may_not_claim_any_more_is_told_at_once() {
        let live = (1000, Some(FrameState::Live), false);
        let newer = (2000, live.1, live.2);
        let changes = [
            (1000, Some(FrameState::Stale), false),
            (2000, Some(FrameState::Lost(bus::message::Lost::Silent)), false),
            (1000, None, false),
            (1000, Some(FrameState::Live), true),
        ];
        for is_time in [false, true] {
            assert!(is_due(None, live, is_time));
            assert!(!is_due(Some(live), live, is_time));
            assert_eq!(is_due(Some(live), newer, is_time), is_time);
            assert!(changes.iter().all(|change| is_due(Some(live), *change, is_time)));
        }
    }

    /// Whoever looked at a plane of his own in one view took the tool away from all: its images are newer than those of the tool.
    #[test]
    fn an_image_that_somebody_asked_for_takes_no_tool_away() {
        let live = claim(7, FrameState::Live);
        for asked in [FrameState::Look, FrameState::Requested] {
            assert_eq!(
                of_the_present([(1, live), (2, claim(9, asked))].into_iter()),
                Some(live)
            );
            assert_eq!(of_the_present([(2, claim(9, asked))].into_iter()), None);
        }
    }

    /// An image of before a replay went back has the later stamp, and counted as the newest until its view drew another.
    #[test]
    fn the_newest_image_is_the_one_that_came_last_whatever_its_stamp() {
        let (before, after) = (claim(900, FrameState::Live), claim(3, FrameState::Live));
        assert_eq!(of_the_present([(5, before), (6, after)].into_iter()), Some(after));
    }
}
