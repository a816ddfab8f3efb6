//! Lines of words beside the images, one after another.

use egui::{Align2, Rect, Ui, vec2};

use crate::colours;
use crate::model::Tone;
use crate::screen::tree;
use crate::screen::words::{Type, Words, colour, on_band};
use crate::sizes::{ADVANCE, Sizes};

/// Puts one line after another.
pub(super) struct Lines<'a, 'w> {
    pub(super) ui: &'a Ui,
    room: Rect,
    pub(super) sizes: &'a Sizes,
    pub(super) words: &'w mut Words,
    /// What is to be said below, the most important first.
    waiting: Vec<(String, Tone)>,
}

impl<'a, 'w> Lines<'a, 'w> {
    pub(super) fn new(ui: &'a Ui, room: Rect, (sizes, words): (&'a Sizes, &'w mut Words)) -> Self {
        Self {
            ui,
            room,
            sizes,
            words,
            waiting: Vec::new(),
        }
    }

    fn height(&self) -> f32 {
        1.3 * self.sizes.plain
    }

    /// The next line, while there is room for one.
    pub(super) fn next(&mut self) -> Option<Rect> {
        let height = self.height();
        if self.room.height() < height {
            return None;
        }
        let line = Rect::from_min_size(self.room.min, vec2(self.room.width(), height));
        self.room.min.y += height;
        Some(line)
    }

    /// How many lines there is room for.
    pub(super) fn left(&self) -> usize {
        (self.room.height() / self.height()).floor() as usize
    }

    /// Words over up to three lines.
    pub(super) fn put_wrapped(&mut self, text: &str, tone: Tone) {
        let columns = (self.room.width() / (ADVANCE * self.sizes.plain)) as usize;
        let letters: Vec<char> = text.chars().collect();
        for part in letters.chunks(columns.saturating_sub(2).max(1)).take(3) {
            self.put_now(&part.iter().collect::<String>(), tone);
        }
    }

    pub(super) fn put_now(&mut self, text: &str, tone: Tone) {
        let Some(line) = self.next() else { return };
        self.put_in(line, text, tone, Align2::LEFT_CENTER);
    }

    /// Says this below what is there already, as far as there is room.
    pub(super) fn put(&mut self, text: &str, tone: Tone) {
        self.waiting.push((text.to_owned(), tone));
    }

    /// What waits, and how much of it found no room: nothing is left out in silence.
    pub(super) fn put_waiting(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        let room = self.left();
        let shown = if waiting.len() <= room {
            room
        } else {
            room.saturating_sub(1)
        };
        for (text, tone) in waiting.iter().take(shown) {
            self.put_now(text, *tone);
        }
        if waiting.len() > shown {
            let text = format!("{} MORE LINES: `pilot plan` says them", waiting.len() - shown);
            self.put_now(&text, Tone::Alarm);
        }
    }

    /// Words in a part of a line; warnings and alarms on a band.
    fn put_in(&mut self, room: Rect, text: &str, tone: Tone, align: Align2) {
        let has_band = matches!(tone, Tone::Warning | Tone::Alarm);
        let ground = if has_band { colour(tone) } else { colours::GROUND };
        if has_band {
            self.ui.painter().rect_filled(room, 3.0, ground);
        }
        let how = Type {
            size: self.sizes.plain,
            colour: if has_band { on_band(tone) } else { colour(Tone::Quiet) },
            ground,
            align,
        };
        let role = if has_band { tree::role(tone) } else { egui::Role::Label };
        let inner = room.shrink2(vec2(self.sizes.gap, 0.0));
        self.words.put_as(self.ui, inner, text, how, role);
    }
}
