//! Keys for how images look. What holds then stands on the images themselves.

use egui::{Key, Ui};

use super::{Outcome, Wish};

/// What a key asks of the images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImagesKey {
    /// The window with this place in the list of names.
    Window(usize),
    /// A narrower window: more contrast.
    Narrower,
    /// A wider window.
    Wider,
    /// The window's centre goes down: the image becomes lighter.
    Lighter,
    /// The window's centre goes up.
    Darker,
    /// Local images show less, larger.
    Closer,
    /// Local images show more.
    Further,
    /// Organs as the examination has them, or where a model has them again.
    Organs,
    /// All as the scene says.
    Scene,
}

/// Each key, as it is printed on the keyboard, with or without Shift, and what it asks for.
pub(super) const KEYS: [(&str, Key, bool, ImagesKey); 16] = [
    ("1", Key::Num1, false, ImagesKey::Window(0)),
    ("2", Key::Num2, false, ImagesKey::Window(1)),
    ("3", Key::Num3, false, ImagesKey::Window(2)),
    ("4", Key::Num4, false, ImagesKey::Window(3)),
    ("5", Key::Num5, false, ImagesKey::Window(4)),
    ("[", Key::OpenBracket, false, ImagesKey::Narrower),
    ("]", Key::CloseBracket, false, ImagesKey::Wider),
    ("[", Key::OpenBracket, true, ImagesKey::Lighter),
    ("]", Key::CloseBracket, true, ImagesKey::Darker),
    ("+", Key::Plus, false, ImagesKey::Closer),
    ("+", Key::Plus, true, ImagesKey::Closer),
    // Where the plus needs Shift.
    ("+", Key::Equals, false, ImagesKey::Closer),
    ("+", Key::Equals, true, ImagesKey::Closer),
    ("-", Key::Minus, false, ImagesKey::Further),
    ("O", Key::O, false, ImagesKey::Organs),
    ("R", Key::R, false, ImagesKey::Scene),
];

/// What is asked for by the keys pressed now.
pub(super) fn keys(ui: &Ui, outcome: &mut Outcome) {
    let is_pressed = |key: Key, shift: bool| ui.input(|input| input.modifiers.shift == shift && input.key_pressed(key));
    let pressed = KEYS.into_iter().filter(|(_, key, shift, _)| is_pressed(*key, *shift));
    outcome.wishes.extend(pressed.map(|(.., asked)| Wish::Images(asked)));
}
