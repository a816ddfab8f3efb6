//! A button.

use egui::Key;

use super::Wish;

/// A button: its word, its key as it is printed on the keyboard, the key, and what it does.
pub(super) struct Button {
    pub(super) word: String,
    pub(super) key: &'static str,
    pub(super) pressed: Key,
    pub(super) wish: Wish,
    /// Whether it does that now.
    pub(super) is_enabled: bool,
}

/// One that does something now.
pub(super) fn button(word: impl Into<String>, key: &'static str, pressed: Key, wish: Wish) -> Button {
    Button {
        word: word.into(),
        key,
        pressed,
        wish,
        is_enabled: true,
    }
}

impl Button {
    /// The same, doing nothing unless `is_enabled`.
    pub(super) fn enabled(self, is_enabled: bool) -> Self {
        Self { is_enabled, ..self }
    }
}
