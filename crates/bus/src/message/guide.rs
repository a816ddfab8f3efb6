//! What is aimed at: the target that a person chose, the pose that she holds, and how she wishes to see the images.

use geometry::{Ct, Point};
use iceoryx2::prelude::ZeroCopySend;
use scene::WindowLevel;

use super::images::{Images, ImagesError};
use super::{field_text, text_field};
use crate::gather::PoseId;

/// No length of a plan is larger, mm: ten metres.
const MAX_MM: f64 = 1e4;

/// The chosen target with its entry and stop distance, the pose held, and how images look. Published by the pilot whenever it changes; in a replay it
/// comes out of the recording.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/Guide/2")]
pub struct Guide {
    /// When it was said, ns on the session's clock.
    pub t_ns: i64,
    /// Identifies the plan by its numbers: 64 bits of BLAKE3; 0 where nothing is chosen.
    pub plan_id: u64,
    /// The pose held, of meaning with [`Guide::HELD`].
    pub held_seq: u64,
    /// When the pose held was captured, ns on the session's clock.
    pub held_capture_ns: i64,
    /// Centre of the chosen target in the CT's frame, LPS, mm, of meaning with [`Guide::CHOSEN`].
    pub target_mm: [f64; 3],
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Where the tube is to enter, LPS, mm, of meaning with [`Guide::ENTRY`].
    pub entry_mm: [f64; 3],
    /// How far before the target's centre the tip is to stop, mm; 0 or more.
    pub stop_mm: f64,
    /// What the shorter side of local images shows, mm, of meaning with [`Guide::FIELD`]; else it is the scene's.
    pub field_mm: f64,
    /// The window's centre and width on all images, HU, of meaning with [`Guide::WINDOW`]; else it is the scene's.
    pub centre_hu: f64,
    /// See [`Guide::centre_hu`].
    pub width_hu: f64,
    /// Bits: [`Guide::CHOSEN`], [`Guide::ENTRY`], [`Guide::HELD`], [`Guide::FIELD`], [`Guide::WINDOW`].
    pub flags: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
    /// The target's name.
    pub name: [u8; Guide::NAME],
}

const _: () = assert!(size_of::<Guide>() == 128 + Guide::NAME);

impl Default for Guide {
    /// Nothing is chosen and nothing held, and images look as the scene says.
    fn default() -> Self {
        Self {
            t_ns: 0,
            plan_id: 0,
            held_seq: 0,
            held_capture_ns: 0,
            target_mm: [0.0; 3],
            radius_mm: 0.0,
            entry_mm: [0.0; 3],
            stop_mm: 0.0,
            field_mm: 0.0,
            centre_hu: 0.0,
            width_hu: 0.0,
            flags: 0,
            reserved: 0,
            name: [0; Self::NAME],
        }
    }
}

/// The target that a person chose.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// Its name.
    pub name: String,
    /// Its centre.
    pub centre: Point<Ct>,
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Where the tube is to enter.
    pub entry: Option<Point<Ct>>,
    /// How far before its centre the tip is to stop, mm.
    pub stop_mm: f64,
}

/// Why a guide was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GuideError {
    /// A number is none, or out of its range.
    #[error("the guide on the bus: {what} is {found}, expected {expected}")]
    Number {
        /// Which.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// Images cannot look like that.
    #[error("the guide on the bus: {0}")]
    Images(#[from] ImagesError),
}

impl Guide {
    /// Most bytes of a target's name.
    pub const NAME: usize = 64;
    /// A target is chosen.
    pub const CHOSEN: u32 = 1;
    /// There is an entry.
    pub const ENTRY: u32 = 2;
    /// A pose is held.
    pub const HELD: u32 = 4;
    /// Local images have a field of their own.
    pub const FIELD: u32 = 8;
    /// Images have a window of their own.
    pub const WINDOW: u32 = 16;
    /// Organs are shown as the examination has them.
    pub const AT_REST: u32 = 32;

    /// The same with another target, or with none.
    #[must_use]
    pub fn choosing(self, chosen: Option<&Chosen>, plan_id: u64) -> Self {
        let kept = Self {
            t_ns: self.t_ns,
            held_seq: self.held_seq,
            held_capture_ns: self.held_capture_ns,
            field_mm: self.field_mm,
            centre_hu: self.centre_hu,
            width_hu: self.width_hu,
            flags: self.flags & (Self::HELD | Self::FIELD | Self::WINDOW | Self::AT_REST),
            ..Self::default()
        };
        let Some(chosen) = chosen else { return kept };
        let entry = match chosen.entry {
            Some(_) => Self::ENTRY,
            None => 0,
        };
        Self {
            plan_id,
            target_mm: chosen.centre.mm(),
            radius_mm: chosen.radius_mm,
            entry_mm: chosen.entry.map(Point::mm).unwrap_or_default(),
            stop_mm: chosen.stop_mm,
            flags: kept.flags | Self::CHOSEN | entry,
            name: text_field(&chosen.name),
            ..kept
        }
    }

    /// The same with this pose held, or with none.
    #[must_use]
    pub fn holding(self, held: Option<PoseId>) -> Self {
        let flags = self.flags & !Self::HELD;
        Self {
            held_seq: held.map_or(0, |pose| pose.seq),
            held_capture_ns: held.map_or(0, |pose| pose.t_capture_ns),
            flags: if held.is_some() { flags | Self::HELD } else { flags },
            ..self
        }
    }

    /// The same with images that look like this.
    #[must_use]
    pub fn showing(self, images: &Images) -> Self {
        let has = |is_there: bool, bit: u32| if is_there { bit } else { 0 };
        let window = images.window.unwrap_or(WindowLevel {
            centre_hu: 0.0,
            width_hu: 0.0,
        });
        Self {
            field_mm: images.field_mm.unwrap_or_default(),
            centre_hu: window.centre_hu,
            width_hu: window.width_hu,
            flags: self.flags & !(Self::FIELD | Self::WINDOW | Self::AT_REST)
                | has(images.field_mm.is_some(), Self::FIELD)
                | has(images.window.is_some(), Self::WINDOW)
                | has(images.at_rest, Self::AT_REST),
            ..self
        }
    }

    /// How images look.
    ///
    /// # Errors
    /// [`GuideError::Images`] for numbers that no scene may say.
    pub fn images(&self) -> Result<Images, GuideError> {
        let has = |bit: u32| self.flags & bit != 0;
        let window = WindowLevel {
            centre_hu: self.centre_hu,
            width_hu: self.width_hu,
        };
        let images = Images {
            field_mm: has(Self::FIELD).then_some(self.field_mm),
            window: has(Self::WINDOW).then_some(window),
            at_rest: has(Self::AT_REST),
        };
        Ok(images.checked()?)
    }

    /// The pose that is held.
    pub fn held(&self) -> Option<PoseId> {
        (self.flags & Self::HELD != 0).then_some(PoseId {
            seq: self.held_seq,
            t_capture_ns: self.held_capture_ns,
        })
    }

    /// The chosen target: the door from the bus to geometry. `None` where nobody chose one.
    ///
    /// # Errors
    /// [`GuideError`] for numbers that are no plan.
    pub fn chosen(&self) -> Result<Option<Chosen>, GuideError> {
        if self.flags & Self::CHOSEN == 0 {
            return Ok(None);
        }
        let entry = match self.flags & Self::ENTRY {
            0 => None,
            _ => Some(point("entry", self.entry_mm)?),
        };
        Ok(Some(Chosen {
            name: field_text(&self.name).replace(char::is_control, " "),
            centre: point("target", self.target_mm)?,
            radius_mm: within("radius", self.radius_mm, "more than 0 to 10000 mm", f64::MIN_POSITIVE)?,
            entry,
            stop_mm: within("stop distance", self.stop_mm, "0 to 10000 mm", 0.0)?,
        }))
    }
}

fn within(what: &'static str, found: f64, expected: &'static str, least: f64) -> Result<f64, GuideError> {
    match (least..=MAX_MM).contains(&found) {
        true => Ok(found),
        false => Err(GuideError::Number { what, found, expected }),
    }
}

fn point(what: &'static str, mm: [f64; 3]) -> Result<Point<Ct>, GuideError> {
    for found in mm {
        within(what, found, "-10000 to 10000 mm", -MAX_MM)?;
    }
    Ok(Point::new(mm[0], mm[1], mm[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen() -> Chosen {
        Chosen {
            name: "para-aortic-left".to_owned(),
            centre: Point::new(33.0, 4.0, -50.5),
            radius_mm: 2.5,
            entry: Some(Point::new(1.0, 2.0, 3.0)),
            stop_mm: 5.0,
        }
    }

    #[test]
    fn what_was_chosen_and_held_comes_back_and_one_does_not_change_the_other() {
        let pose = PoseId {
            seq: 7,
            t_capture_ns: -3,
        };
        let guide = Guide::default().choosing(Some(&chosen()), 99);
        assert_eq!((guide.chosen(), guide.held()), (Ok(Some(chosen())), None));
        let held = guide.holding(Some(pose));
        assert_eq!((held.chosen(), held.held()), (Ok(Some(chosen())), Some(pose)));
        let none = held.choosing(None, 99);
        assert_eq!((none.chosen(), none.held(), none.plan_id), (Ok(None), Some(pose), 0));
        assert_eq!(held.holding(None), guide);
        let free = Chosen {
            entry: None,
            ..chosen()
        };
        let changed = held.choosing(Some(&free), 1);
        assert_eq!((changed.chosen(), changed.held()), (Ok(Some(free)), Some(pose)));
    }

    #[test]
    fn how_images_look_changes_with_nothing_else() {
        let images = Images {
            field_mm: Some(60.0),
            window: Some(WindowLevel {
                centre_hu: 400.0,
                width_hu: 2000.0,
            }),
            at_rest: true,
        };
        let guide = Guide::default().showing(&images);
        assert_eq!(guide.images(), Ok(images));
        let chosen = guide.choosing(Some(&chosen()), 1).choosing(None, 0).holding(None);
        assert_eq!(chosen.images(), Ok(images));
        assert_eq!(chosen.showing(&Images::default()).images(), Ok(Images::default()));
        for bad in [f64::NAN, 0.0, 1e9] {
            assert!(Guide { field_mm: bad, ..guide }.images().is_err());
            assert!(Guide { width_hu: bad, ..guide }.images().is_err());
            // What is not of meaning is not looked at.
            let free = Guide {
                field_mm: bad,
                flags: Guide::WINDOW,
                ..guide
            };
            assert!(free.images().is_ok());
        }
    }

    #[test]
    fn numbers_that_are_no_plan_are_refused_by_name() {
        let good = Guide::default().choosing(Some(&chosen()), 1);
        for bad in [f64::NAN, f64::INFINITY, -1e5] {
            for (guide, what) in [
                (
                    Guide {
                        target_mm: [0.0, bad, 0.0],
                        ..good
                    },
                    "target",
                ),
                (
                    Guide {
                        entry_mm: [0.0, 0.0, bad],
                        ..good
                    },
                    "entry",
                ),
                (Guide { radius_mm: bad, ..good }, "radius"),
                (Guide { stop_mm: bad, ..good }, "stop distance"),
            ] {
                let said = guide.chosen().unwrap_err().to_string();
                assert!(said.contains(what), "{said}");
            }
        }
        assert!(Guide { radius_mm: 0.0, ..good }.chosen().is_err());
        // What is not of meaning is not looked at.
        let free = Guide {
            entry_mm: [f64::NAN; 3],
            flags: Guide::CHOSEN,
            ..good
        };
        assert!(free.chosen().is_ok());
    }
}
