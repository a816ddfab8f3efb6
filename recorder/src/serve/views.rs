//! Small images of the views, and what they may claim.

use std::time::Duration;

use bus::clock;
use bus::message::{Ages, FrameStamp, FrameState};
use bus::port::{Frame, FrameSubscriber};
use bus::topic::VIEW_FRAME;
use bus::{Bus, BusError};
use geometry::SlicePlane;
use picture::palette::{ALARM, RIM, WARN};
use picture::{Anchor, Canvas, encode_png};
use scene::Scene;

use super::NOTICE;
use super::outlet::Outlet;
use crate::wire::proto::CompressedImage;
use crate::write::pose_log::{Entry, Take};
use crate::write::record::thumbnails::shrunk;

/// Height of the line under each image, pixels.
const LINE: u32 = 16;

/// A view, and what was given out of it last.
struct View {
    name: String,
    frames: FrameSubscriber,
    newest: Option<Frame>,
    /// When its image was handed over, and what it could claim when it was given out.
    given: Option<(i64, Option<FrameState>)>,
}

/// The views of a run.
pub(super) struct Views {
    views: Vec<View>,
    ages: Ages,
    every_ns: i64,
    next_ns: i64,
}

/// What an image may claim at a time.
pub(super) struct Claim {
    pub(super) stamp: FrameStamp,
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
                given: None,
            })
        });
        Ok(Self {
            views: views.collect::<Result<_, BusError>>()?,
            ages: Ages::of(&scene.limits),
            every_ns: clock::ns(every),
            next_ns: i64::MIN,
        })
    }

    /// Gives out each image that is new or may claim less than when it was given out; `steady_ns` is of a clock that never stands still.
    pub(super) fn step(&mut self, now_ns: i64, steady_ns: i64, outlet: &mut Outlet) -> Result<(), BusError> {
        for view in &mut self.views {
            if let Some(frame) = view.frames.newest()? {
                view.newest = Some(frame);
            }
        }
        if steady_ns < self.next_ns {
            return Ok(());
        }
        self.next_ns = steady_ns + self.every_ns;
        for (view, number) in self.views.iter_mut().zip(0..) {
            let Some(frame) = &view.newest else { continue };
            let stamp = &frame.header().stamp;
            let state = frame.shown(now_ns, self.ages).state;
            let given = Some((stamp.t_framed_ns, state));
            if view.given == given {
                continue;
            }
            view.given = given;
            let Some(png) = small_png(frame, now_ns, self.ages) else {
                continue;
            };
            let image = &CompressedImage::png(stamp.t_framed_ns, &view.name, png);
            let (view, seq, t_ns) = (number, stamp.seq, stamp.t_framed_ns);
            outlet.put(now_ns, Entry::Image { view, seq, t_ns, image });
        }
        Ok(())
    }

    /// What the image of the newest pose may claim.
    pub(super) fn claim(&self, now_ns: i64) -> Option<Claim> {
        let frames = self.views.iter().filter_map(|view| view.newest.as_ref());
        let newest = frames.max_by_key(|frame| (frame.header().stamp.t_framed_ns, frame.header().stamp.seq))?;
        Some(Claim {
            stamp: newest.header().stamp,
            state: newest.shown(now_ns, self.ages).state,
        })
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

/// A small copy with a line under it; an image that may not claim any more what stands on it is dimmed.
fn small_png(frame: &Frame, now_ns: i64, ages: Ages) -> Option<Vec<u8>> {
    let header = frame.header();
    let shown = frame.shown(now_ns, ages);
    let (width, height, rgba) = shrunk(header.width, header.height, shown.rgba);
    if width == 0 || height == 0 {
        return None;
    }
    let mut canvas = Canvas::new(width, height + LINE);
    canvas.paste(&rgba, width, 0, 0);
    let is_changed = shown.state != header.stamp.frame_state();
    if is_changed {
        canvas.dim(96);
    }
    let (words, colour) = match is_changed {
        true => (format!("{NOTICE}: OLD"), ALARM),
        false => (NOTICE.to_owned(), WARN),
    };
    let top = f64::from(height);
    canvas.fill([0.0, top], [f64::from(width), f64::from(LINE)], RIM, 255);
    canvas.text(
        [f64::from(width) / 2.0, top + f64::from(LINE) / 2.0],
        &words,
        11.0,
        colour,
        Anchor::Centre,
    );
    encode_png(&canvas, &header.stamp.texts()).ok()
}
