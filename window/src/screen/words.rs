//! Words in their rooms: never cut, never over one another, and in the accessibility tree (`tree`).
//!
//! A distance that has lost a digit is another distance. So each piece of text has a room of its own; where it is wider than that, its
//! type becomes smaller; and what is wider still at the smallest type is words and not numbers, and ends in an ellipsis.

use egui::{Align2, Color32, FontId, Rect, Role, Ui, vec2};

use super::tree;
use crate::colours;
use crate::model::Tone;
use crate::sizes::{SMALLEST_PART, Screen};
use picture::{Rgb, palette};

/// A piece of text where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// As it was to be said.
    pub text: String,
    /// As it is painted: shorter where it found no room.
    pub painted: String,
    /// What it may cover.
    pub room: Rect,
    /// What it covers.
    pub covers: Rect,
    /// Of its type, pixels.
    pub size: f32,
    /// Of the letters, and of what they stand on.
    pub colours: [Color32; 2],
}

/// All text of a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Words(pub Vec<Placed>);

/// How a piece of text is to stand.
#[derive(Debug, Clone, Copy)]
pub struct Type {
    /// Pixels.
    pub size: f32,
    /// Of the letters.
    pub colour: Color32,
    /// Of what they stand on.
    pub ground: Color32,
    /// Where in its room.
    pub align: Align2,
}

/// The red of alarms, brighter: words stand on it in black, with a contrast of 7.
const ALARM_BAND: Rgb = Rgb(0xff, 0x5c, 0x74);
/// The violet of replays, darker: words stand on it in white. No violet that is bright enough for black words is told apart from the
/// tube by a deuteranope.
const REPLAY_BAND: Rgb = Rgb(0x78, 0x28, 0xc8);

/// Stands for a name in letters that the type does not have.
pub(super) const UNREADABLE: &str = "NAME IN OTHER LETTERS";

impl Words {
    /// Puts `text` into `room`, and into the tree.
    pub fn put(&mut self, ui: &Ui, room: Rect, text: &str, how: Type) {
        self.put_as(ui, room, text, how, Role::Label);
    }

    /// The same for words that are more than a label: a state that is to be said when it changes.
    pub fn put_as(&mut self, ui: &Ui, room: Rect, text: &str, how: Type, role: Role) {
        if let Some(covers) = self.paint(ui, room, text, how) {
            tree::word(ui, room, covers, text, role);
        }
    }

    /// Puts `text` into `room` and leaves its name to whoever calls; returns what it covers.
    pub(super) fn paint(&mut self, ui: &Ui, room: Rect, text: &str, how: Type) -> Option<Rect> {
        if text.is_empty() {
            return None;
        }
        let layout = |text: &str, size: f32| {
            let font = FontId::monospace(size);
            ui.painter().layout_no_wrap(text.to_owned(), font, how.colour)
        };
        let mut size = how.size;
        let mut painted = text.to_owned();
        let mut galley = layout(text, size);
        // Once by the ratio, and then pixel by pixel: widths do not go exactly with the type's size.
        let smallest = (how.size * SMALLEST_PART).floor().max(1.0);
        while galley.size().x > room.width() && size > smallest {
            let ratio = room.width() / galley.size().x;
            size = (size * ratio).floor().clamp(smallest, (size - 1.0).max(smallest));
            galley = layout(text, size);
        }
        while galley.size().x > room.width() && !painted.is_empty() {
            painted = shorter(&painted);
            galley = layout(&painted, size);
        }
        let covers = how.align.align_size_within_rect(galley.size(), room);
        ui.painter().galley(covers.min, galley, how.colour);
        self.0.push(Placed {
            text: text.to_owned(),
            painted,
            room,
            covers,
            size,
            colours: [how.colour, how.ground],
        });
        Some(covers)
    }

    /// Whether the tree and the screen say `text` somewhere.
    pub fn say(&self, text: &str) -> bool {
        self.0.iter().any(|placed| placed.text.contains(text))
    }
}

/// One letter less, with an ellipsis at the end.
fn shorter(text: &str) -> String {
    let mut letters: Vec<char> = text.trim_end_matches('\u{2026}').chars().collect();
    letters.pop();
    match letters.is_empty() {
        true => String::new(),
        false => letters.into_iter().chain(['\u{2026}']).collect(),
    }
}

/// The colour of a tone.
pub fn colour(tone: Tone) -> Color32 {
    colours::of(match tone {
        Tone::Live => palette::TARGET,
        Tone::Quiet => palette::WORDS,
        Tone::Warning => palette::WARN,
        Tone::Alarm => ALARM_BAND,
        Tone::Replay => REPLAY_BAND,
    })
}

/// Whether the type has every letter of a name. Of those that it does not have it would make boxes, the same for every name.
pub(super) fn has_letters(ui: &Ui, name: &str, size: f32) -> bool {
    ui.fonts_mut(|fonts| fonts.has_glyphs(&FontId::monospace(size), name))
}

/// Words on a band of a tone.
pub(crate) const fn on_band(tone: Tone) -> Color32 {
    match tone {
        Tone::Replay => Color32::WHITE,
        Tone::Live | Tone::Quiet | Tone::Warning | Tone::Alarm => Color32::BLACK,
    }
}

/// A screen on which nothing could be read says so and nothing else.
pub fn too_small(ui: &Ui, screen: Screen, [least_width, least_height]: [u32; 2], words: &mut Words) {
    let [width, height] = screen.pixels;
    let room = Rect::from_min_size(egui::Pos2::ZERO, vec2(width as f32, height as f32));
    ui.painter().rect_filled(room, 0.0, colour(Tone::Alarm));
    let how = Type {
        size: 24.0,
        colour: on_band(Tone::Alarm),
        ground: colour(Tone::Alarm),
        align: Align2::CENTER_CENTER,
    };
    let (upper, lower) = room.split_top_bottom_at_fraction(0.5);
    let what = format!("SCREEN TOO SMALL: {width} x {height}");
    words.put_as(ui, upper, &what, how, tree::role(Tone::Alarm));
    words.put(
        ui,
        lower,
        &format!("at least {least_width} x {least_height} are needed"),
        how,
    );
}
