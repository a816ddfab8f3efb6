//! Words in their rooms: never cut, never over one another, and in the accessibility tree.
//!
//! A distance that has lost a digit is another distance. So each piece of text has a room of its own; where it is wider than that, its
//! type becomes smaller; and what is wider still at the smallest type is words and not numbers, and ends in an ellipsis.

use egui::{Align2, Color32, FontId, Id, Rect, Role, Sense, Ui, WidgetInfo, vec2};

use crate::colours;
use crate::model::Tone;
use crate::sizes::{SMALLEST, Screen};
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

/// The red of alarms and the violet of replays, brighter: words stand on them in black, with a contrast of 7.
const ALARM_BAND: Rgb = Rgb(0xff, 0x6a, 0x7e);
const REPLAY_BAND: Rgb = Rgb(0xc7, 0x7a, 0xff);
/// The type becomes no smaller than this part of what is asked.
const SMALLEST_PART: f32 = 0.6;

impl Words {
    /// Puts `text` into `room`, and its name into the tree.
    pub fn put(&mut self, ui: &Ui, room: Rect, text: &str, how: Type) {
        if text.is_empty() {
            return;
        }
        let layout = |text: &str, size: f32| {
            let font = FontId::monospace(size);
            ui.painter().layout_no_wrap(text.to_owned(), font, how.colour)
        };
        let mut size = how.size;
        let mut painted = text.to_owned();
        let mut galley = layout(text, size);
        if galley.size().x > room.width() {
            size = (size * room.width() / galley.size().x)
                .max(how.size * SMALLEST_PART)
                .floor()
                .max(1.0);
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
        name(ui, covers, text, self.0.len());
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

/// Tells those who cannot see the screen, and tests, what stands there.
fn name(ui: &Ui, rect: Rect, text: &str, number: usize) {
    let response = ui.interact(rect, Id::unique(("words", number)), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
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

/// A screen on which nothing could be read says so and nothing else.
pub fn too_small(ui: &Ui, screen: Screen, words: &mut Words) {
    let [width, height] = screen.pixels;
    let room = Rect::from_min_size(egui::Pos2::ZERO, vec2(width as f32, height as f32));
    ui.painter().rect_filled(room, 0.0, colour(Tone::Alarm));
    let how = Type {
        size: 24.0,
        colour: colours::ON_BAND,
        ground: colour(Tone::Alarm),
        align: Align2::CENTER_CENTER,
    };
    let [least_width, least_height] = SMALLEST;
    let (upper, lower) = room.split_top_bottom_at_fraction(0.5);
    words.put(ui, upper, &format!("SCREEN TOO SMALL: {width} x {height}"), how);
    words.put(
        ui,
        lower,
        &format!("at least {least_width} x {least_height} are needed"),
        how,
    );
}
