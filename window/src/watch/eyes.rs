//! What the watcher sees and does on one connection to the screen.

use bus::clock::Clock;
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{Visibility, Window};

use super::cover::{Cover, Extent};
use super::error::ScreenError;
use super::find::{Found, find};
use super::judge::{Fault, Seen};
use super::screen::{Area, Screen};
use super::words;
use crate::code::{Grid, Unread};

/// The words of the cover are written anew after so long, ns: a number that changes faster is not read.
const WORDS_NS: i64 = 200_000_000;

/// One connection, what is known of the window, and the cover.
pub(super) struct Eyes {
    screen: Screen,
    known: Option<Window>,
    cover: Option<Cover>,
    /// The fault whose words stand on the cover, and since when, ns.
    said: Option<(Fault, i64)>,
}

/// One look: what was found, and when the pixels were asked for on the clock handed in, ns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glance {
    pub(super) seen: Seen,
    pub(super) t_ns: i64,
    /// What a cover would have to cover; `None` without a window.
    pub(super) extent: Option<Extent>,
}

impl Eyes {
    /// Opens `display`.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn open(display: &str) -> Result<Self, ScreenError> {
        Ok(Self {
            screen: Screen::open(display)?,
            known: None,
            cover: None,
            said: None,
        })
    }

    /// Looks for the window of the run with this key, and reads its cell.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn look(&mut self, key: u32, clock: &Clock) -> Result<Glance, ScreenError> {
        self.screen.measure()?;
        let found = find(&self.screen, self.known, key)?;
        self.known = found.map(|found| found.window);
        // Before the pixels are asked for: what is on the screen now is not older than what comes back.
        let t_ns = clock.now_ns();
        let Some(found) = found else {
            return Ok(Glance {
                seen: Seen::NoWindow,
                t_ns,
                extent: None,
            });
        };
        let seen = self.read(&found)?;
        let extent = Extent {
            area: found.area,
            hole: found.cell,
        };
        Ok(Glance {
            seen,
            t_ns,
            extent: Some(extent),
        })
    }

    fn read(&self, found: &Found) -> Result<Seen, ScreenError> {
        let pixels = match found.cell {
            Some(cell) => self.screen.pixels(cell)?,
            None => None,
        };
        let read = pixels.map_or(Err(Unread::Size), |pixels| {
            Grid::read(&pixels, found.place.square, found.place.key)
        });
        Ok(match read {
            Ok(code) => Seen::Code(found.life(), code),
            Err(why) => Seen::Unread(why),
        })
    }

    /// Sees to it that the cover is up, above all others, and says why.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn cover(&mut self, extent: Extent, fault: Fault, for_ns: i64, now_ns: i64) -> Result<(), ScreenError> {
        let covered = self.is_covered_by_others()?;
        let extent = on_screen(extent, self.screen.whole);
        let cover = match &mut self.cover {
            Some(cover) => {
                cover.move_to(&self.screen, extent)?;
                cover
            }
            none => none.insert(Cover::put_up(&self.screen, extent)?),
        };
        if covered {
            cover.raise(&self.screen)?;
        }
        let is_due = self
            .said
            .is_none_or(|(said, t_ns)| said != fault || now_ns - t_ns >= WORDS_NS);
        if is_due {
            cover.say(&self.screen, &words::headline(fault, for_ns), &words::reason(fault))?;
            self.said = Some((fault, now_ns));
        }
        Ok(())
    }

    /// Sees to it that there is no cover.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn uncover(&mut self) -> Result<(), ScreenError> {
        self.said = None;
        match self.cover.take() {
            Some(cover) => cover.take_down(&self.screen),
            None => Ok(()),
        }
    }

    /// Whether the server has said since the last call that something lies over the cover, or that its words have to be written again.
    fn is_covered_by_others(&mut self) -> Result<bool, ScreenError> {
        let mut covered = false;
        while let Some(event) = self.screen.connection.poll_for_event()? {
            match event {
                Event::VisibilityNotify(notice) => covered = notice.state != Visibility::UNOBSCURED,
                Event::Expose(_) => self.said = None,
                _ => {}
            }
        }
        Ok(covered)
    }
}

/// The part of the extent that lies on the screen; the whole screen where none does.
fn on_screen(extent: Extent, whole: Area) -> Extent {
    Extent {
        area: extent.area.within(whole).unwrap_or(whole),
        hole: extent.hole,
    }
}
