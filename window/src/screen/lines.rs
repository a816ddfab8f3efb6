//! Lines of words beside the images, one after another.

use egui::{Align2, Rect, Ui, vec2};

use super::tree;
use super::words::{Type, Words, colour, on_band};
use crate::colours;
use crate::model::Tone;
use crate::sizes::{ADVANCE, Sizes};

/// Puts one line after another.
pub(crate) struct Lines<'a, 'w> {
    pub(crate) ui: &'a Ui,
    room: Rect,
    pub(crate) sizes: &'a Sizes,
    pub(crate) words: &'w mut Words,
    /// What is to be said below, the most important first.
    waiting: Vec<(String, Tone)>,
    /// Where the rest is said that finds no room.
    elsewhere: &'static str,
}

impl<'a, 'w> Lines<'a, 'w> {
    pub(crate) fn new(ui: &'a Ui, room: Rect, (sizes, words): (&'a Sizes, &'w mut Words)) -> Self {
        Self {
            ui,
            room,
            sizes,
            words,
            waiting: Vec::new(),
            elsewhere: "`pilot plan` says them",
        }
    }

    /// What finds no room is said by this command.
    pub(crate) const fn or_by(mut self, elsewhere: &'static str) -> Self {
        self.elsewhere = elsewhere;
        self
    }

    fn height(&self) -> f32 {
        1.3 * self.sizes.plain
    }

    /// The next line, while there is room for one.
    pub(crate) fn next(&mut self) -> Option<Rect> {
        let height = self.height();
        if self.room.height() < height {
            return None;
        }
        let line = Rect::from_min_size(self.room.min, vec2(self.room.width(), height));
        self.room.min.y += height;
        Some(line)
    }

    /// What is left of the room, below all lines.
    pub(crate) const fn rest(&self) -> Rect {
        self.room
    }

    /// How many lines there is room for.
    pub(crate) fn left(&self) -> usize {
        (self.room.height() / self.height()).floor() as usize
    }

    /// Words over up to three lines.
    pub(crate) fn put_wrapped(&mut self, text: &str, tone: Tone) {
        let columns = self.columns();
        for part in wrapped(text, columns).into_iter().take(3) {
            self.put_now(part, tone);
        }
    }

    pub(crate) fn put_now(&mut self, text: &str, tone: Tone) {
        let Some(line) = self.next() else { return };
        self.put_in(line, text, tone, Align2::LEFT_CENTER);
    }

    /// Says this below what is there already, as far as there is room.
    pub(crate) fn put(&mut self, text: &str, tone: Tone) {
        self.waiting.push((text.to_owned(), tone));
    }

    /// The same over as many lines as it takes.
    pub(crate) fn put_all(&mut self, text: &str, tone: Tone) {
        let columns = self.columns();
        let lines = wrapped(text, columns).into_iter().map(|line| (line.to_owned(), tone));
        self.waiting.extend(lines);
    }

    /// Letters in a line.
    fn columns(&self) -> usize {
        let columns = (self.room.width() / (ADVANCE * self.sizes.plain)) as usize;
        columns.saturating_sub(2).max(1)
    }

    /// What waits, and how much of it found no room: nothing is left out in silence.
    pub(crate) fn put_waiting(&mut self) {
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
            let text = format!("{} MORE LINES: {}", waiting.len() - shown, self.elsewhere);
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

/// Text in lines of up to so many letters, broken between words where that can be.
pub(crate) fn wrapped(text: &str, columns: usize) -> Vec<&str> {
    let (mut lines, mut rest) = (Vec::new(), text.trim());
    while !rest.is_empty() {
        let most = rest.char_indices().nth(columns).map_or(rest.len(), |(at, _)| at);
        let end = match most == rest.len() {
            true => most,
            // A word that is longer than a line is broken.
            false if rest[most..].starts_with(' ') => most,
            false => rest[..most].rfind(' ').filter(|at| *at > 0).unwrap_or(most),
        };
        lines.push(rest[..end].trim_end());
        rest = rest[end..].trim_start();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn lines_break_between_words_and_lose_no_letter() {
        assert_eq!(wrapped("to be or not", 5), ["to be", "or", "not"]);
        assert_eq!(wrapped("abcdefgh ij", 4), ["abcd", "efgh", "ij"]);
        assert_eq!(wrapped("äöü ßéè", 3), ["äöü", "ßéè"]);
        assert!(wrapped("   ", 3).is_empty());
        for columns in 1..20 {
            let text = "a bb ccc dddd eeeee ffffff";
            let lines = wrapped(text, columns);
            assert!(
                lines.iter().all(|line| line.chars().count() <= columns),
                "{columns}: {lines:?}"
            );
            assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        }
    }
}
