//! One view of a renderer and the places its images go to.

use bus::clock::Clock;
use bus::message::{FrameHeader, FrameStamp, FrameState, ImagePlane};
use bus::port::FramePublisher;
use bus::topic::{HELD_FRAME, LOOK_FRAME, VIEW_FRAME};
use bus::{Bus, BusError};
use scene::{Extent, View, WindowLevel};

use crate::overlay::SMALLEST_WITH_WORDS;
use crate::render::Renderer;

/// One view and the places its images go to.
pub(crate) struct Output {
    /// In the scene's list of views.
    pub(crate) index: u32,
    pub(crate) renderer: Renderer,
    live: FramePublisher,
    held: FramePublisher,
    looks: FramePublisher,
    /// The pose that came last is not drawn in this view.
    pub(crate) waits: bool,
    /// How long its last drawing took, on the session's clock.
    pub(crate) took_ns: i64,
    /// When the pose of its last image was captured, where that image was live.
    pub(crate) live_from_ns: Option<i64>,
}

impl Output {
    /// Becomes the publisher of `view`, which is number `index` of the scene.
    pub(crate) fn open(bus: &Bus, index: usize, view: &View) -> Result<Self, BusError> {
        let bytes = view.size[0] as usize * view.size[1] as usize * 4;
        Ok(Self {
            index: index as u32,
            live: FramePublisher::open(bus, &VIEW_FRAME, &view.name, bytes)?,
            held: FramePublisher::open(bus, &HELD_FRAME, &view.name, bytes)?,
            looks: FramePublisher::open(bus, &LOOK_FRAME, &view.name, bytes)?,
            renderer: Renderer::new(view.clone()),
            waits: false,
            took_ns: 0,
            live_from_ns: None,
        })
    }

    /// Whether it gives way to other views where there is not time for all.
    pub(crate) fn may_wait(&self) -> bool {
        self.renderer.view().extent == Extent::Global
    }

    /// Gives viewers that come late the images drawn last: a replay stands still, and a pose that is held is drawn once.
    pub(crate) fn serve_late_joiners(&self) {
        self.live.serve_late_joiners();
        self.held.serve_late_joiners();
    }

    /// Hands over the image drawn last, to the topic that fits its stamp; `None` where that would be later than `latest_ns`.
    pub(crate) fn send(
        &self,
        stamp: FrameStamp,
        clock: &Clock,
        latest_ns: i64,
    ) -> Result<Option<FrameStamp>, BusError> {
        self.send_as(stamp, self.renderer.view().window, clock, latest_ns)
    }

    /// The same in another window of HU than the view's own.
    pub(crate) fn send_as(
        &self,
        stamp: FrameStamp,
        window: WindowLevel,
        clock: &Clock,
        latest_ns: i64,
    ) -> Result<Option<FrameStamp>, BusError> {
        let canvas = self.renderer.canvas();
        let header = FrameHeader {
            stamp,
            plane: ImagePlane::of(self.renderer.plane(), window),
            width: canvas.width(),
            height: canvas.height(),
        };
        let port = match stamp.frame_state() {
            Some(FrameState::Look) => &self.looks,
            _ if stamp.on_request == 1 => &self.held,
            _ => &self.live,
        };
        port.send(header, canvas.rgba(), clock, latest_ns)
    }
}

/// Which views are too small for words.
pub(crate) fn wordless(outputs: &[Output]) -> String {
    let views = outputs.iter().map(|output| output.renderer.view());
    let small = views.filter(|view| view.size.iter().any(|side| *side < SMALLEST_WITH_WORDS));
    let names: Vec<&str> = small.map(|view| view.name.as_str()).collect();
    match names.is_empty() {
        true => String::new(),
        false => format!("; no words below {SMALLEST_WITH_WORDS} pixels: {}", names.join(", ")),
    }
}
