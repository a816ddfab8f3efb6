//! The request to change how images look.

use scene::WindowLevel;

use super::{Change, Command, CommandKind, ImagePlane, Images, ImagesError, ImagesWish};

/// Bits of [`Command::view`] of a request of [`CommandKind::Images`].
const FIELD: u32 = 1;
const SCENES_FIELD: u32 = 2;
const WINDOW: u32 = 4;
const SCENES_WINDOW: u32 = 8;
const AT_REST: u32 = 16;
const MOVED: u32 = 32;
const SCENES_ORGANS: u32 = 64;

impl Command {
    /// The request to change how images look.
    pub fn images(wish: ImagesWish) -> Self {
        let (field, number) = match wish.field_mm {
            Change::Keep => (0, 0.0),
            Change::Scene => (SCENES_FIELD, 0.0),
            Change::Set(mm) => (FIELD, mm),
        };
        let (window, plane) = match wish.window {
            Change::Keep => (0, ImagePlane::default()),
            Change::Scene => (SCENES_WINDOW, ImagePlane::default()),
            Change::Set(level) => (WINDOW, ImagePlane::of(None, level)),
        };
        let organs = match wish.at_rest {
            Change::Keep => 0,
            Change::Scene => SCENES_ORGANS,
            Change::Set(true) => AT_REST,
            Change::Set(false) => MOVED,
        };
        Self {
            view: field | window | organs,
            number,
            plane,
            ..Self::new(CommandKind::Images)
        }
    }

    /// What a request of [`CommandKind::Images`] wishes.
    ///
    /// # Errors
    /// [`ImagesError`] for numbers that no scene may say, and for a wish for nothing.
    pub fn images_wish(&self) -> Result<ImagesWish, ImagesError> {
        let has = |bit: u32| self.view & bit != 0;
        let wish = ImagesWish {
            field_mm: match (has(FIELD), has(SCENES_FIELD)) {
                (true, _) => Change::Set(self.number),
                (false, true) => Change::Scene,
                (false, false) => Change::Keep,
            },
            window: match (has(WINDOW), has(SCENES_WINDOW)) {
                (true, _) => Change::Set(WindowLevel {
                    centre_hu: self.plane.centre_hu,
                    width_hu: self.plane.width_hu,
                }),
                (false, true) => Change::Scene,
                (false, false) => Change::Keep,
            },
            at_rest: match (has(AT_REST), has(MOVED), has(SCENES_ORGANS)) {
                (true, ..) => Change::Set(true),
                (_, true, _) => Change::Set(false),
                (_, _, true) => Change::Scene,
                _ => Change::Keep,
            },
        };
        if wish == ImagesWish::default() {
            return Err(ImagesError::Nothing);
        }
        Images::default().with(wish).checked().map(|_| wish)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BONE: WindowLevel = WindowLevel {
        centre_hu: 400.0,
        width_hu: 2000.0,
    };

    #[test]
    fn wishes_come_back_and_change_what_they_name_alone() {
        let before = Images {
            field_mm: Some(60.0),
            window: None,
            at_rest: true,
        };
        for (field_mm, window, at_rest, after) in [
            (
                Change::Keep,
                Change::Set(BONE),
                Change::Keep,
                (Some(60.0), Some(BONE), true),
            ),
            (Change::Scene, Change::Keep, Change::Scene, (None, None, false)),
            (
                Change::Set(30.0),
                Change::Scene,
                Change::Set(false),
                (Some(30.0), None, false),
            ),
            (Change::Keep, Change::Keep, Change::Set(true), (Some(60.0), None, true)),
        ] {
            let wish = ImagesWish {
                field_mm,
                window,
                at_rest,
            };
            let heard = Command::images(wish).images_wish().unwrap();
            assert_eq!(heard, wish);
            let found = before.with(heard);
            assert_eq!((found.field_mm, found.window, found.at_rest), after);
        }
        let nothing = Command::images(ImagesWish::default()).images_wish();
        assert_eq!(nothing, Err(ImagesError::Nothing));
    }

    #[test]
    fn what_no_scene_may_say_is_refused_by_name() {
        let window = |centre_hu, width_hu| Change::Set(WindowLevel { centre_hu, width_hu });
        for bad in [f64::NAN, f64::INFINITY, 0.5, -1e6, 1e6] {
            let field = ImagesWish {
                field_mm: Change::Set(bad),
                ..ImagesWish::default()
            };
            let width = ImagesWish {
                window: window(40.0, bad),
                ..ImagesWish::default()
            };
            let centre = ImagesWish {
                window: window(if bad == 0.5 { 1e5 } else { bad }, 400.0),
                ..ImagesWish::default()
            };
            for (wish, what) in [(field, "field"), (width, "width"), (centre, "centre")] {
                let said = Command::images(wish).images_wish().unwrap_err().to_string();
                assert!(said.contains(what), "{bad}: {said}");
            }
        }
    }
}
