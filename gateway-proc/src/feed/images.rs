//! The images of the views, for the clients that want them and no faster than the scene says.

use std::sync::Arc;

use bus::message::Ages;
use bus::port::{Frame, FrameSubscriber};
use bus::topic::VIEW_FRAME;
use bus::{Bus, BusError};
use igtl::DeviceName;
use scene::{Plane, Scene};

use super::Times;
use crate::client::Known;
use crate::hall::Hall;
use crate::letter::Letter;
use crate::mailbox::{Mailbox, Slot, Wish};
use crate::origin::Origin;
use crate::picture::{self, GROWN_OLD, PictureError};
use crate::tell::{NOT_READY, refusal};

struct Source {
    view: usize,
    device: DeviceName,
    frames: FrameSubscriber,
    /// The newest image, while somebody wants it.
    held: Option<Frame>,
    next_ns: i64,
    /// When the image was handed over that was sent last, and whether it was sent as it is.
    sent: Option<(i64, bool)>,
    /// What covers the newest image that was held, once nobody wants it: for who wants one before another image comes.
    cover: Option<Arc<Letter>>,
}

/// All views that have a plane.
pub(super) struct Images {
    sources: Vec<Source>,
    ages: Ages,
    every_ns: i64,
    origin: Origin,
}

impl Images {
    pub(super) fn open(bus: &Bus, scene: &Scene, known: &Known) -> Result<Self, BusError> {
        let mut sources = Vec::new();
        for (view, (spec, device)) in scene.views.iter().zip(&known.views).enumerate() {
            // A surface has no plane, and nothing is measured on it.
            let Some(device) = device.filter(|_| spec.plane != Plane::Surface) else {
                continue;
            };
            sources.push(Source {
                view,
                device,
                frames: FrameSubscriber::open(bus, &VIEW_FRAME, &spec.name)?,
                held: None,
                next_ns: i64::MIN,
                sent: None,
                cover: None,
            });
        }
        let hz = scene.gateway.map_or(10.0, |spec| spec.images_hz);
        Ok(Self {
            sources,
            ages: Ages::of(&scene.limits),
            every_ns: (1e9 / hz) as i64,
            origin: known.origin,
        })
    }

    /// Sends what is wanted and due: `now_ns` on the session's clock, `steady_ns` on one that does not stand still. `why_not`: the run
    /// does not let images be shown.
    pub(super) fn step(
        &mut self,
        hall: &Hall,
        (now_ns, steady_ns): (i64, i64),
        why_not: Option<&str>,
        times: Times,
    ) -> Result<(), BusError> {
        let clients = hall.all();
        for source in &mut self.sources {
            let wanting: Vec<_> = clients
                .iter()
                .filter(|client| client.wished(source.view).is_any())
                .collect();
            if wanting.is_empty() {
                source.let_go((now_ns, self.ages), (self.origin, times));
                continue;
            }
            if steady_ns < source.next_ns && !source.must_be_covered((now_ns, self.ages), why_not)? {
                continue;
            }
            source.next_ns = steady_ns.saturating_add(self.every_ns);
            if let Some(newest) = source.frames.newest()? {
                source.held = Some(newest);
            }
            source.send(&wanting, (now_ns, self.ages), why_not, (self.origin, times));
        }
        Ok(())
    }
}

impl Source {
    /// Whether an image was sent that claims what is no longer true, and no newer one is to be had: its cover waits for no pace.
    fn must_be_covered(&mut self, (now_ns, ages): (i64, Ages), why_not: Option<&str>) -> Result<bool, BusError> {
        let was_true = matches!(self.sent, Some((_, true)));
        let Some(held) = self.held.as_ref().filter(|_| was_true) else {
            return Ok(false);
        };
        if why_not.is_some() {
            return Ok(true);
        }
        if picture::is_true(held, now_ns, ages) {
            return Ok(false);
        }
        if let Some(newest) = self.frames.newest()? {
            self.held = Some(newest);
        }
        Ok(!self
            .held
            .as_ref()
            .is_some_and(|held| picture::is_true(held, now_ns, ages)))
    }

    fn send(
        &mut self,
        wanting: &[&Arc<Mailbox>],
        (now_ns, ages): (i64, Ages),
        why_not: Option<&str>,
        (origin, times): (Origin, Times),
    ) {
        let Some(frame) = &self.held else {
            return match &self.cover {
                Some(cover) => self.give(
                    cover,
                    wanting.iter().filter(|client| client.wished(self.view).is_at_once()),
                ),
                None => self.refuse(wanting, "no image of this view has come yet"),
            };
        };
        let stamp = frame.header().stamp;
        let is_true = why_not.is_none() && picture::is_true(frame, now_ns, ages);
        let sending = (stamp.t_framed_ns, is_true);
        let is_news = self.sent != Some(sending);
        let to: Vec<_> = wanting
            .iter()
            .filter(|client| is_news || client.wished(self.view).is_at_once())
            .collect();
        if to.is_empty() {
            return;
        }
        let wall = times.stamp(stamp.t_capture_ns);
        match picture::letter(self.device, frame, (now_ns, ages), why_not, (origin, wall)) {
            Ok(letter) => {
                // An image that says LIVE is not sent once its pose is old; the cover that follows is.
                let is_live = is_true && stamp.state == 0;
                let letter = Arc::new(letter.until(times.until_ns(stamp.t_capture_ns).filter(|_| is_live)));
                self.give(&letter, to.into_iter());
                self.sent = Some(sending);
            }
            Err(error @ (PictureError::NoPlace | PictureError::Plane(_) | PictureError::TooLarge)) => {
                self.refuse(wanting, &error.to_string());
            }
        }
    }

    fn give<'a>(&self, letter: &Arc<Letter>, to: impl Iterator<Item = &'a &'a Arc<Mailbox>>) {
        for client in to {
            client.wish(Some(self.view), Wish::is_met);
            client.put(Slot::View(self.view), letter);
            client.ring();
        }
    }

    /// Nobody wants an image: its renderer may draw there again. A black one of its place is kept.
    fn let_go(&mut self, now: (i64, Ages), (origin, times): (Origin, Times)) {
        self.sent = None;
        let Some(frame) = self.held.take() else { return };
        let wall = times.stamp(frame.header().stamp.t_capture_ns);
        let cover = picture::letter(self.device, &frame, now, Some(GROWN_OLD), (origin, wall));
        self.cover = cover.ok().map(Arc::new);
    }

    /// Tells those who asked once; a stream begins when there is an image.
    fn refuse(&self, wanting: &[&Arc<Mailbox>], words: &str) {
        let letter = Arc::new(refusal(NOT_READY, &format!("{}: {words}", self.device)));
        for client in wanting.iter().filter(|client| client.wished(self.view).once) {
            client.wish(Some(self.view), Wish::is_met);
            client.say(&letter);
            client.ring();
        }
    }
}
