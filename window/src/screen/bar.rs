//! The band at the top: whose examination, the state, what it rests on, recorded or not, and room for the coded cell.

use egui::{Align2, Color32, Pos2, Rect, Stroke, Ui, pos2, vec2};

use super::words::{Type, Words, colour};
use crate::colours;
use crate::model::{Model, ScreenState, Tone};
use crate::sizes::Sizes;

/// Of the band's width: identity, state, recording. The coded cell takes what is left.
const PARTS: [f32; 3] = [0.31, 0.37, 0.26];

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

/// Lays out the band; returns the room of the coded cell.
pub(super) fn show(ui: &Ui, model: &Model, (sizes, note): (&Sizes, &str), words: &mut Words) -> Rect {
    let [left, middle, right] = parts(sizes);
    identity(ui, model, left, sizes, words);
    state(ui, &model.state, middle, sizes, words);
    recording(ui, model, right, (sizes, note), words);
    Rect::from_min_max(pos2(right.right() + sizes.gap, sizes.top.top()), sizes.top.max).shrink(sizes.gap)
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
        (&facts.identity, facts.identity_tone),
        (&facts.volume, Tone::Quiet),
        (&facts.registration, Tone::Quiet),
    ];
    for (k, (text, tone)) in lines.into_iter().enumerate() {
        words_in_tone(ui, line(part, k, lines.len()), text, tone, sizes, words);
    }
}

/// Words of a tone: alarms, warnings and replays on a band of their colour, as black on it has the contrast that reading takes.
fn words_in_tone(ui: &Ui, room: Rect, text: &str, tone: Tone, sizes: &Sizes, words: &mut Words) {
    let on_band = matches!(tone, Tone::Warning | Tone::Alarm | Tone::Replay);
    let ground = if on_band { colour(tone) } else { colours::GROUND };
    if on_band && !text.is_empty() {
        ui.painter().rect_filled(room, 3.0, ground);
    }
    let ink = if on_band { colours::ON_BAND } else { colour(Tone::Quiet) };
    let how = Type {
        ground,
        ..plain(sizes, ink)
    };
    words.put(ui, room.shrink2(vec2(sizes.gap, 0.0)), text, how);
}

fn state(ui: &Ui, state: &ScreenState, part: Rect, sizes: &Sizes, words: &mut Words) {
    let filled = matches!(state.tone, Tone::Warning | Tone::Alarm | Tone::Replay);
    let (ground, ink) = match filled {
        true => (colour(state.tone), colours::ON_BAND),
        false => (colours::CELL, colour(Tone::Quiet)),
    };
    ui.painter().rect_filled(part, 6.0, ground);
    let large = Rect::from_min_size(part.min, vec2(part.width(), 1.02 * sizes.critical));
    let below = Rect::from_min_max(pos2(part.left(), large.bottom()), part.max);
    let side = 0.8 * sizes.critical;
    let middle = pos2(part.left() + sizes.gap + side / 2.0, large.center().y);
    shape(ui, middle, side / 2.0, Shown::of(state.tone), ink);
    let room = Rect::from_min_max(pos2(part.left() + side + 2.0 * sizes.gap, large.top()), large.max);
    let how = |size, align| Type {
        size,
        colour: ink,
        ground,
        align,
    };
    words.put(
        ui,
        room.shrink2(vec2(sizes.gap, 0.0)),
        &state.word,
        how(sizes.critical, Align2::LEFT_CENTER),
    );
    let age = state.age_ms.map(|ms| format!("{ms:.0} ms")).unwrap_or_default();
    let mut second: Vec<&str> = vec![&state.detail, &age];
    second.extend(&state.marks);
    second.retain(|text| !text.is_empty());
    words.put(
        ui,
        below.shrink2(vec2(sizes.gap, 0.0)),
        &second.join("   "),
        how(sizes.plain, Align2::LEFT_CENTER),
    );
}

fn recording(ui: &Ui, model: &Model, part: Rect, (sizes, note): (&Sizes, &str), words: &mut Words) {
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
        _ if !note.is_empty() => (note, Tone::Warning),
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
