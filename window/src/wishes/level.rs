//! The window of the images while it is dragged: many steps become few requests, one at a time, each with the whole of what is wished.

use bus::message::{Change, Command, ImagesWish};
use bus::port::{CommandClient, Pending};
use scene::WindowLevel;

/// Between two requests, ns: each is a line in the run's log.
const BETWEEN_NS: i64 = 66_000_000;
/// So long after the last step a drag goes on from what was wished, as what holds may not have been told yet, ns.
const GOES_ON_NS: i64 = 500_000_000;
/// What windows are dragged to, HU: centre and width.
const CENTRE_HU: [f64; 2] = [-2000.0, 4000.0];
const WIDTH_HU: [f64; 2] = [1.0, 8000.0];

/// What is wished, and what was asked for.
#[derive(Debug, Default)]
pub(super) struct Level {
    wished: Option<WindowLevel>,
    asked: Option<WindowLevel>,
    /// It was dragged since the last turn.
    is_moved: bool,
    moved_ns: i64,
    asked_ns: Option<i64>,
}

/// The request that is not answered yet.
pub(super) type Open = Option<Pending>;

impl Level {
    /// A step of a drag: so many HU wider, and so many up, from what was wished before, or from what holds.
    pub(super) fn drag(&mut self, holds: WindowLevel, [wider_hu, up_hu]: [i32; 2]) {
        let WindowLevel { centre_hu, width_hu } = self.wished.unwrap_or(holds);
        self.wished = Some(WindowLevel {
            centre_hu: (centre_hu + f64::from(up_hu)).clamp(CENTRE_HU[0], CENTRE_HU[1]),
            width_hu: (width_hu + f64::from(wider_hu)).clamp(WIDTH_HU[0], WIDTH_HU[1]),
        });
        self.is_moved = true;
    }

    /// Another wish about the images goes before: what is not asked for yet is not asked for any more.
    pub(super) fn forget(&mut self) {
        *self = Self {
            asked_ns: self.asked_ns,
            ..Self::default()
        };
    }

    /// What is to be asked for now, where nothing is without an answer.
    fn next(&mut self, now_ns: i64) -> Option<WindowLevel> {
        if std::mem::take(&mut self.is_moved) {
            self.moved_ns = now_ns;
        }
        let wished = self.wished?;
        if self.asked == Some(wished) {
            if now_ns.saturating_sub(self.moved_ns) >= GOES_ON_NS {
                (self.wished, self.asked) = (None, None);
            }
            return None;
        }
        if self
            .asked_ns
            .is_some_and(|at_ns| now_ns.saturating_sub(at_ns) < BETWEEN_NS)
        {
            return None;
        }
        (self.asked, self.asked_ns) = (Some(wished), Some(now_ns));
        Some(wished)
    }

    /// Takes the answer that has come, and asks for what is wished.
    ///
    /// # Errors
    /// In words, why it was refused or has no answer.
    pub(super) fn turn(
        &mut self,
        (pilot, open): (&CommandClient, &mut Open),
        now_ns: i64,
        patience_ns: i64,
    ) -> Result<(), String> {
        if let Some(pending) = open {
            let answer = match pending.reply() {
                Ok(None) if pending.waited_ns() <= patience_ns => return Ok(()),
                Ok(Some(reply)) if !reply.refused => Ok(()),
                Ok(Some(reply)) => Err(reply.text),
                Ok(None) => Err(pending.no_answer().to_string()),
                Err(error) => Err(error.to_string()),
            };
            *open = None;
            if answer.is_err() {
                self.forget();
                return answer;
            }
        }
        let Some(window) = self.next(now_ns) else { return Ok(()) };
        let wish = ImagesWish {
            window: Change::Set(window),
            ..ImagesWish::default()
        };
        *open = Some(super::send(pilot, Command::images(wish))?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BONE: WindowLevel = WindowLevel {
        centre_hu: 400.0,
        width_hu: 1800.0,
    };

    /// However many steps come, no more is asked for than one request in each span, and the last has all of them.
    #[test]
    fn many_steps_are_few_requests_and_lose_nothing() {
        let mut level = Level::default();
        let mut asked = Vec::new();
        for step in 0..200_i64 {
            level.drag(BONE, [2, -1]);
            asked.extend(level.next(5_000_000 * step));
        }
        let last = (200..400).filter_map(|step| level.next(5_000_000 * step));
        asked.extend(last);
        assert!((12..20).contains(&asked.len()), "{}", asked.len());
        let last = asked.last().unwrap();
        assert_eq!((last.width_hu, last.centre_hu), (2200.0, 200.0));
        // Once it has stood still, the next drag begins from what holds then.
        let abdomen = WindowLevel {
            centre_hu: 40.0,
            width_hu: 400.0,
        };
        level.drag(abdomen, [10, 0]);
        let next = level.next(9_000_000_000).unwrap();
        assert_eq!((next.width_hu, next.centre_hu), (410.0, 40.0));
    }

    #[test]
    fn a_drag_ends_where_windows_do_and_another_wish_ends_a_drag() {
        let mut level = Level::default();
        level.drag(BONE, [i32::MAX, i32::MIN]);
        let far = level.next(0).unwrap();
        assert_eq!((far.width_hu, far.centre_hu), (8000.0, -2000.0));
        level.drag(BONE, [i32::MIN, 0]);
        level.forget();
        assert_eq!(level.next(1_000_000_000), None);
    }
}
