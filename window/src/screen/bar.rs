//! The band at the top: whose examination, the state, what it rests on, recorded or not, and room for the coded cell.

use egui::{Align2, Color32, Pos2, Rect, Role, Stroke, Ui, pos2, vec2};

use super::tree;
use super::words::{Type, UNREADABLE, Words, colour, has_letters, on_band};
use crate::colours;
use crate::model::{Model, ScreenState, Tone};
use crate::sizes::{ADVANCE, LINE, Sizes};

/// Of the band's width: identity, state, recording. The coded cell takes what is left.
const PARTS: [f32; 3] = [0.29, 0.43, 0.22];

/// What a tone looks like beside its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// A filled disc.
    Disc,
    /// A ring.
    Ring,
    /// A filled triangle, its point above.
    Triangle,
    /// A cross.
    Cross,
    /// Two triangles, one behind the other, as on the keys of a player.
    Forward,
}

impl Shown {
    /// Of a tone: each has its own.
    pub const fn of(tone: Tone) -> Self {
        match tone {
            Tone::Live => Self::Disc,
            Tone::Quiet => Self::Ring,
            Tone::Warning => Self::Triangle,
            Tone::Alarm => Self::Cross,
            Tone::Replay => Self::Forward,
        }
    }
}

/// What the band shows.
pub(crate) struct Band<'a> {
    pub(crate) model: &'a Model,
    pub(crate) sizes: &'a Sizes,
    /// Why the last wish was refused, or what was done.
    pub(crate) note: (&'a str, Tone),
}

impl Band<'_> {
    /// Lays out the band; returns the room of the coded cell.
    pub(crate) fn show(&self, ui: &Ui, words: &mut Words) -> Rect {
        let Self { model, sizes, note } = *self;
        let [left, middle, right] = parts(sizes);
        identity(ui, model, left, sizes, words);
        state(ui, &model.state, middle, sizes, words);
        recording(ui, model, right, (sizes, note), words);
        Rect::from_min_max(pos2(right.right() + sizes.gap, sizes.top.top()), sizes.top.max).shrink(sizes.gap)
    }
}

fn parts(sizes: &Sizes) -> [Rect; 3] {
    let mut left = sizes.top.left();
    PARTS.map(|part| {
        let width = part * sizes.top.width();
        let rect = Rect::from_min_size(pos2(left, sizes.top.top()), vec2(width, sizes.top.height()));
        left += width;
        rect.shrink2(vec2(sizes.gap, 2.0))
    })
}

/// The lines of a part, from the top.
fn line(part: Rect, number: usize, of: usize) -> Rect {
    let height = part.height() / of as f32;
    let top = part.top() + height * number as f32;
    Rect::from_min_size(pos2(part.left(), top), vec2(part.width(), height))
}

fn plain(sizes: &Sizes, colour: Color32) -> Type {
    Type {
        size: sizes.plain,
        colour,
        ground: colours::GROUND,
        align: Align2::LEFT_CENTER,
    }
}

fn identity(ui: &Ui, model: &Model, part: Rect, sizes: &Sizes, words: &mut Words) {
    let facts = &model.facts;
    let lines = [
        readable(ui, &facts.identity, facts.identity_tone, sizes),
        (facts.volume.as_str(), Tone::Quiet),
        (facts.registration.as_str(), Tone::Quiet),
    ];
    for (k, (text, tone)) in lines.into_iter().enumerate() {
        words_in_tone(ui, line(part, k, lines.len()), text, tone, sizes, words);
    }
}

fn readable<'a>(ui: &Ui, name: &'a str, tone: Tone, sizes: &Sizes) -> (&'a str, Tone) {
    match has_letters(ui, name, sizes.plain) {
        true => (name, tone),
        false => (UNREADABLE, Tone::Warning),
    }
}

/// Whether words of a tone stand on a band of its colour: in black or white, as these have the contrast that reading takes.
const fn has_band(tone: Tone) -> bool {
    matches!(tone, Tone::Warning | Tone::Alarm | Tone::Replay)
}

/// Words of a tone, alarms, warnings and replays on a band.
fn words_in_tone(ui: &Ui, room: Rect, text: &str, tone: Tone, sizes: &Sizes, words: &mut Words) {
    let has_band = has_band(tone);
    let ground = if has_band { colour(tone) } else { colours::GROUND };
    if has_band && !text.is_empty() {
        ui.painter().rect_filled(room, 3.0, ground);
    }
    let ink = if has_band { on_band(tone) } else { colour(Tone::Quiet) };
    let how = Type {
        ground,
        ..plain(sizes, ink)
    };
    let role = if has_band { tree::role(tone) } else { Role::Label };
    words.put_as(ui, room.shrink2(vec2(sizes.gap, 0.0)), text, how, role);
}

fn state(ui: &Ui, state: &ScreenState, part: Rect, sizes: &Sizes, words: &mut Words) {
    let (ground, ink) = match has_band(state.tone) {
        true => (colour(state.tone), on_band(state.tone)),
        false => (colours::CELL, colour(Tone::Quiet)),
    };
    ui.painter().rect_filled(part, 6.0, ground);
    let (large, below) = part.split_top_bottom_at_y(part.bottom() - LINE * sizes.plain);
    let side = 0.8 * sizes.critical;
    let middle = pos2(part.left() + sizes.gap + side / 2.0, large.center().y);
    shape(ui, middle, side / 2.0, Shown::of(state.tone), ink);
    let (before, marked) = large.split_left_right_at_x(large.right() - marks_width(state, sizes));
    let room = before.with_min_x(part.left() + side + 2.0 * sizes.gap);
    let how = |size, align| Type {
        size,
        colour: ink,
        ground,
        align,
    };
    words.put_as(
        ui,
        room.shrink2(vec2(sizes.gap, 0.0)),
        &state.word,
        how(sizes.critical, Align2::LEFT_CENTER),
        tree::role(state.tone),
    );
    let age = state.age_ms.map(|ms| format!("{ms:.0} ms")).unwrap_or_default();
    let plain = how(sizes.plain, Align2::LEFT_CENTER);
    let width = |text: &str| text.chars().count() as f32 * ADVANCE * sizes.plain;
    let below = below.shrink2(vec2(sizes.gap, 0.0));
    // An age is a number: a reason of any length leaves it its room.
    let after = if age.is_empty() {
        0.0
    } else {
        width(&age) + width("   ")
    };
    let (aged, reason) = below.split_left_right_at_x(below.left() + after);
    words.put(ui, aged, &age, plain);
    words.put(ui, reason, &state.detail, plain);
    for (k, mark) in state.marks.iter().enumerate() {
        words.put(ui, line(marked, k, state.marks.len()), mark, plain);
    }
}

/// Marks stand one above the other beside the state, where no reason of any length takes their room.
fn marks_width(state: &ScreenState, sizes: &Sizes) -> f32 {
    let letters = state.marks.iter().map(|mark| mark.chars().count()).max().unwrap_or(0);
    letters as f32 * ADVANCE * sizes.plain + 2.0 * sizes.gap
}

fn recording(ui: &Ui, model: &Model, part: Rect, (sizes, note): (&Sizes, (&str, Tone)), words: &mut Words) {
    let facts = &model.facts;
    words_in_tone(
        ui,
        line(part, 0, 3),
        &facts.recording,
        facts.recording_tone,
        sizes,
        words,
    );
    let tone = if model.state.is_mixed {
        Tone::Warning
    } else {
        Tone::Quiet
    };
    words_in_tone(ui, line(part, 1, 3), &model.state.set, tone, sizes, words);
    let reach = match sizes.critical_from_mm {
        mm if mm < 1990.0 => format!("READABLE TO {:.1} m", mm / 1000.0),
        _ => String::new(),
    };
    let (last, tone) = match facts.is_unwatched {
        _ if !note.0.is_empty() => note,
        true => ("NOT WATCHED", Tone::Warning),
        false => (reach.as_str(), Tone::Quiet),
    };
    words_in_tone(ui, line(part, 2, 3), last, tone, sizes, words);
}

fn shape(ui: &Ui, middle: Pos2, radius: f32, shown: Shown, ink: Color32) {
    let painter = ui.painter();
    let at = |x: f32, y: f32| middle + radius * vec2(x, y);
    let wide = Stroke::new(0.28 * radius, ink);
    let filled = |points: Vec<Pos2>| {
        painter.add(egui::Shape::convex_polygon(points, ink, Stroke::NONE));
    };
    match shown {
        Shown::Disc => {
            painter.circle_filled(middle, 0.8 * radius, ink);
        }
        Shown::Ring => {
            painter.circle_stroke(middle, 0.7 * radius, wide);
        }
        Shown::Triangle => filled(vec![at(0.0, -0.9), at(0.95, 0.8), at(-0.95, 0.8)]),
        Shown::Cross => {
            painter.line_segment([at(-0.75, -0.75), at(0.75, 0.75)], wide);
            painter.line_segment([at(-0.75, 0.75), at(0.75, -0.75)], wide);
        }
        Shown::Forward => {
            filled(vec![at(-0.9, -0.8), at(0.0, 0.0), at(-0.9, 0.8)]);
            filled(vec![at(0.0, -0.8), at(0.9, 0.0), at(0.0, 0.8)]);
        }
    }
}
