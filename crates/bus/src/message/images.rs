//! What a person chose of how images look: the field of local ones and the window of HU of all.

use std::ops::RangeInclusive;

use scene::WindowLevel;

/// Most HU of a window's centre either way, and of its width: those of a scene.
pub(super) const CENTRE_HU: RangeInclusive<f64> = -32_768.0..=32_767.0;
pub(super) const WIDTH_HU: RangeInclusive<f64> = 1.0..=65_536.0;
/// What the shorter side of an image may show, mm: as a scene's local views.
pub(super) const FIELD_MM: RangeInclusive<f64> = 1.0..=2000.0;

/// What holds in the place of the scene's; `None`: the scene's does.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub struct Images {
    /// What the shorter side of each local image shows, mm.
    pub field_mm: Option<f64>,
    /// How HU become grey, on all images.
    pub window: Option<WindowLevel>,
    /// Organs are shown as the examination has them, also where a model moves them.
    pub at_rest: bool,
}

/// A wish about one of the two.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub enum Change<T> {
    /// It stays as it is.
    #[default]
    Keep,
    /// What the scene says holds again.
    Scene,
    /// This holds.
    Set(T),
}

/// What a person wishes to see changed.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub struct ImagesWish {
    /// Of the field of local images, mm.
    pub field_mm: Change<f64>,
    /// Of the window of HU.
    pub window: Change<WindowLevel>,
    /// Of whether organs are shown as the examination has them.
    pub at_rest: Change<bool>,
}

/// Why a choice is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImagesError {
    /// A number is none, or beyond what a scene may say.
    #[error("the images: {what} is {found}, expected {expected}")]
    Number {
        /// Which.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// A request that changes nothing.
    #[error("the images: neither a field, nor a window, nor where organs are shown is asked for")]
    Nothing,
}

impl<T> Change<T> {
    /// What holds after it where `before` held.
    fn after(self, before: Option<T>) -> Option<T> {
        match self {
            Self::Keep => before,
            Self::Scene => None,
            Self::Set(value) => Some(value),
        }
    }
}

impl Images {
    /// The same with what is wished.
    #[must_use]
    pub fn with(self, wish: ImagesWish) -> Self {
        Self {
            field_mm: wish.field_mm.after(self.field_mm),
            window: wish.window.after(self.window),
            at_rest: wish.at_rest.after(Some(self.at_rest)).unwrap_or_default(),
        }
    }

    /// The same, where a scene could say it.
    ///
    /// # Errors
    /// [`ImagesError::Number`], by the name of the number.
    pub fn checked(self) -> Result<Self, ImagesError> {
        if let Some(field_mm) = self.field_mm {
            within("field", field_mm, FIELD_MM, "1 to 2000 mm")?;
        }
        if let Some(window) = self.window {
            within("window's centre", window.centre_hu, CENTRE_HU, "-32768 to 32767 HU")?;
            within("window's width", window.width_hu, WIDTH_HU, "1 to 65536 HU")?;
        }
        Ok(self)
    }

    /// In words; empty where all is the scene's.
    pub fn words(&self) -> String {
        let window = self.window.map(|w| format!("W {} C {}", w.width_hu, w.centre_hu));
        let field = self.field_mm.map(|mm| format!("field {mm} mm"));
        let organs = self.at_rest.then(|| "organs at rest".to_owned());
        let all = window.into_iter().chain(field).chain(organs);
        all.collect::<Vec<_>>().join(", ")
    }
}

fn within(
    what: &'static str,
    found: f64,
    range: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), ImagesError> {
    match range.contains(&found) {
        true => Ok(()),
        false => Err(ImagesError::Number { what, found, expected }),
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
    fn a_choice_has_words_and_the_scenes_has_none() {
        let mut images = Images::default();
        assert_eq!(images.words(), "");
        images.window = Some(BONE);
        images.field_mm = Some(62.5);
        images.at_rest = true;
        assert_eq!(images.words(), "W 2000 C 400, field 62.5 mm, organs at rest");
    }
}
