//! Asking renderers for planes, and taking their images: one request at a time of each, always for the newest wish.

use std::rc::Rc;

use bus::message::{Command, FrameHeader, ImagePlane};
use bus::port::{CommandClient, Frame, FrameSubscriber, Pending};
use bus::topic::LOOK_FRAME;
use bus::wake::Waits;
use bus::{Bus, BusError};
use scene::Scene;

use super::camera::CUTS;

/// A renderer that has not answered for so long may have died: it is asked again.
const PATIENCE_NS: i64 = 1_000_000_000;
/// A renderer that refused, or could not be asked, is asked again after so long.
const PAUSE_NS: i64 = 500_000_000;
/// Places and directions of one plane differ by roundings at most, mm.
const SAME_MM: f64 = 1e-6;

/// The image of one cut.
#[derive(Debug)]
struct Look {
    /// Which view of the scene draws it.
    view: u32,
    renderer: CommandClient,
    frames: FrameSubscriber,
    wanted: Option<ImagePlane>,
    asked: Option<(ImagePlane, Pending)>,
    /// What was asked for last and before: images of these are shown.
    known: [Option<ImagePlane>; 2],
    /// Nothing is asked for before, ns on the run's clock.
    pause_until_ns: i64,
    shown: Option<Rc<Frame>>,
}

/// The images of the planning screen.
#[derive(Debug)]
pub(crate) struct Looks(Vec<Look>);

impl Looks {
    /// Of a planning scene, whose views are one for each cut.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub(crate) fn open(bus: &Bus, scene: &Scene) -> Result<Self, BusError> {
        let views = scene.views.iter().take(CUTS.len()).zip(0..);
        let looks = views.map(|(view, index)| {
            Ok(Look {
                view: index,
                renderer: CommandClient::open(bus, &view.plane.process())?,
                frames: FrameSubscriber::open_waking_on(bus, &LOOK_FRAME, &view.name)?,
                wanted: None,
                asked: None,
                known: [None; 2],
                pause_until_ns: 0,
                shown: None,
            })
        });
        looks.collect::<Result<_, _>>().map(Self)
    }

    /// Wakes for images.
    pub(crate) fn waits<'a>(&'a self, waits: Waits<'a>) -> Waits<'a> {
        self.0.iter().map(|look| &look.frames).fold(waits, Waits::frames)
    }

    /// This plane is to be seen in the image of a cut; `None`: none.
    pub(crate) fn want(&mut self, cut: usize, plane: Option<ImagePlane>) {
        if let Some(look) = self.0.get_mut(cut) {
            look.wanted = plane;
            if plane.is_none() {
                // The same plane may be wanted again.
                (look.shown, look.known) = (None, [None; 2]);
            }
        }
    }

    /// Takes answers and images, and asks for what is wanted and was not asked for. Whether an image came.
    ///
    /// # Errors
    /// [`BusError::Transfer`]; in words, what a renderer refused.
    pub(crate) fn turn(&mut self, now_ns: i64) -> Result<(bool, Option<String>), BusError> {
        let (mut came, mut refused) = (false, None);
        for look in &mut self.0 {
            came |= look.take()?;
            let mut answer = look.hear();
            if answer.is_ok() && look.asked.is_none() && now_ns >= look.pause_until_ns {
                answer = look.ask();
            }
            if let Err(why) = answer {
                look.pause_until_ns = now_ns + PAUSE_NS;
                refused = Some(why);
            }
        }
        Ok((came, refused))
    }

    /// Whether a renderer is drawing what was asked for.
    pub(crate) fn is_awaited(&self) -> bool {
        self.0.iter().any(|look| look.asked.is_some())
    }

    /// The image of a cut.
    pub(crate) fn frame(&self, cut: usize) -> Option<&Rc<Frame>> {
        self.0.get(cut)?.shown.as_ref()
    }

    /// The head of the image of a cut, and whether it shows the plane that is wanted.
    pub(crate) fn header(&self, cut: usize) -> Option<(FrameHeader, bool)> {
        let look = self.0.get(cut)?;
        let header = *look.shown.as_ref()?.header();
        Some((
            header,
            look.wanted.is_some_and(|wanted| is_same(&wanted, &header.plane)),
        ))
    }
}

impl Look {
    fn take(&mut self) -> Result<bool, BusError> {
        let Some(frame) = self.frames.newest()? else {
            return Ok(false);
        };
        // Somebody else may ask for planes of this view too.
        let is_known = |known: &ImagePlane| is_same(known, &frame.header().plane);
        if !self.known.iter().flatten().any(is_known) || self.wanted.is_none() {
            return Ok(false);
        }
        self.shown = Some(Rc::new(frame));
        Ok(true)
    }

    fn hear(&mut self) -> Result<(), String> {
        let Some((_, pending)) = &self.asked else { return Ok(()) };
        let answer = match pending.reply() {
            Ok(None) if pending.waited_ns() <= PATIENCE_NS => return Ok(()),
            Ok(None) => Err(pending.no_answer().to_string()),
            Ok(Some(reply)) if reply.refused => Err(reply.text),
            Ok(Some(_)) => Ok(()),
            Err(error) => Err(error.to_string()),
        };
        self.asked = None;
        // It is asked for again, of the renderer that follows on this one.
        if answer.is_err() {
            self.known = [None; 2];
        }
        answer
    }

    fn ask(&mut self) -> Result<(), String> {
        let Some(wanted) = self.wanted.filter(|wanted| self.known[0] != Some(*wanted)) else {
            return Ok(());
        };
        let pending = self.renderer.send(Command::look(self.view, wanted));
        let pending = pending.map_err(|error| error.to_string())?;
        self.known = [Some(wanted), self.known[0]];
        self.asked = Some((wanted, pending));
        Ok(())
    }
}

/// Whether an image shows the plane that was asked for.
fn is_same(asked: &ImagePlane, shown: &ImagePlane) -> bool {
    let near = |a: [f64; 3], b: [f64; 3], within: f64| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within);
    // Over an image of a metre a direction that is off by this moves its far side by as much as its origin.
    near(asked.origin_mm, shown.origin_mm, SAME_MM)
        && near(asked.right, shown.right, SAME_MM / 1000.0)
        && near(asked.down, shown.down, SAME_MM / 1000.0)
        && (asked.pixel_mm - shown.pixel_mm).abs() <= SAME_MM / 1000.0
        && (asked.centre_hu, asked.width_hu) == (shown.centre_hu, shown.width_hu)
}
