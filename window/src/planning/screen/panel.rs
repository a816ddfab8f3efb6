//! Beside the images: what is to be done, the targets, the selected way in numbers, what speaks against the plan.

use egui::{Align2, Id, Rect, Sense, Ui, pos2, vec2};
use geometry::{Ct, Point};
use guidance::plan::{Concern, Measure, Target, Trajectory};
use picture::palette;

use super::super::camera::{Cut, PRESETS};
use super::super::desk::{Desk, Mode};
use super::{Known, chart, structures};
use crate::colours;
use crate::model::Tone;
use crate::screen::lines::Lines;
use crate::screen::words::{Type, Words};
use crate::sizes::Sizes;

/// Parts of the panel's width: a target's name, its place, its diameter, the depth of its way.
const COLUMNS: [f32; 4] = [0.34, 0.36, 0.14, 0.16];
/// Lines of targets at most; the selected one is among them.
const MOST_TARGETS: usize = 8;
/// So many lines are left for what is to be said of the selected one.
const FOR_THE_WAY: usize = 9;
/// Of the panel's height, the chart's.
const CHART: f32 = 0.24;

/// What is beside the images.
pub(super) struct Panel<'a> {
    pub(super) known: &'a Known<'a>,
    /// What the pointer is on.
    pub(super) pointed: Option<(Cut, Point<Ct>)>,
}

impl Panel<'_> {
    pub(super) fn show(&self, ui: &Ui, desk: &mut Desk, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
        let (upper, lower) = room.split_top_bottom_at_fraction(1.0 - CHART);
        let mut lines = Lines::new(ui, upper, (sizes, words));
        let plan = desk.shown(self.known.plan);
        self.head(desk, &mut lines);
        self.targets(desk, &plan.targets, &mut lines);
        if let Some(target) = desk.target(&plan) {
            way(target, &mut lines);
            structures::show(self.known, &mut lines);
        }
        self.against(&mut lines);
        for (k, measure) in plan.measures.iter().enumerate() {
            measured(k + 1, measure, &mut lines);
        }
        // Last: of what finds no room the notes are the least.
        if !plan.notes.trim().is_empty() {
            let notes = plan.notes.replace(char::is_control, " ");
            lines.put_all(&format!("notes: {}", notes.trim()), Tone::Quiet);
        }
        lines.put_waiting();
        let way = desk.way(&plan);
        chart::show(ui, self.known, way.as_ref(), lower, (sizes, words));
    }

    /// What is to be done next, what the pointer is on, the window.
    fn head(&self, desk: &Desk, lines: &mut Lines<'_, '_>) {
        // In the band above it may be cut.
        lines.put_wrapped(&desk.note, Tone::Warning);
        let plan = self.known.plan;
        let state = match &plan.confirmed {
            Some(confirmed) => format!("CONFIRMED by {}: read-only", confirmed.by),
            None if self.known.is_writing => "the plan is being written".to_owned(),
            None => format!("plan {:016x}, not confirmed", self.known.file_id),
        };
        lines.put_now(&state, Tone::Quiet);
        match &desk.typing {
            Some(typing) => {
                lines.put_now(typing.question(), Tone::Quiet);
                lines.put_now(&format!("{}_", typing.text), Tone::Warning);
            }
            None => lines.put_now(&doing(&desk.mode, self.known), Tone::Quiet),
        }
        let window = desk.camera.window;
        let preset = PRESETS
            .iter()
            .find(|(_, preset)| *preset == window)
            .map_or("", |(name, _)| name);
        let pointed = self.pointed.map_or(String::new(), |(_, p)| {
            let hu = (self.known.hu)(p).map_or("outside the CT".to_owned(), |hu| format!("{hu} HU"));
            format!("{}  {hu}    ", p.in_words(1))
        });
        let level = format!(
            "{pointed}window {:.0} / {:.0} {preset}",
            window.centre_hu, window.width_hu
        );
        lines.put_now(&level, Tone::Quiet);
    }

    fn targets(&self, desk: &mut Desk, targets: &[Target], lines: &mut Lines<'_, '_>) {
        if targets.is_empty() {
            lines.put_now("no target yet: T sets one under the pointer", Tone::Quiet);
            return;
        }
        row(lines, ["target", "centre", "mm", "depth"].map(str::to_owned), false);
        let place = targets
            .iter()
            .position(|target| desk.selected.as_ref() == Some(&target.name));
        let most = lines.left().saturating_sub(FOR_THE_WAY).clamp(1, MOST_TARGETS);
        let first = place.unwrap_or(0).saturating_sub(most - 1);
        for target in targets.iter().skip(first).take(most) {
            let depth = Trajectory::of(target).map_or("-".to_owned(), |way| format!("{:.1}", way.depth_mm));
            let is_selected = desk.selected.as_ref() == Some(&target.name);
            let cells = [
                target.name.clone(),
                target.centre.in_words(1),
                format!("{:.1}", target.diameter_mm),
                depth,
            ];
            if row(lines, cells, is_selected) {
                desk.select(target);
            }
        }
        if targets.len() > most {
            lines.put_now(&format!("{} targets; Tab goes on", targets.len()), Tone::Quiet);
        }
    }

    fn against(&self, lines: &mut Lines<'_, '_>) {
        for concern in self.known.concerns {
            // A target without an entry says so in its own line.
            if !matches!(concern, Concern::NoEntry { .. }) {
                lines.put(&concern.to_string(), Tone::Warning);
            }
        }
    }
}

/// A line of the table; whether it was touched.
fn row(lines: &mut Lines<'_, '_>, cells: [String; 4], is_selected: bool) -> bool {
    let Some(line) = lines.next() else { return false };
    if is_selected {
        lines.ui.painter().rect_filled(line, 2.0, colours::BUTTON);
    }
    let mut left = line.left();
    for (k, (text, part)) in cells.iter().zip(COLUMNS).enumerate() {
        let room = Rect::from_min_size(pos2(left, line.top()), vec2(part * line.width(), line.height()));
        left += part * line.width();
        let align = if k < 2 {
            Align2::LEFT_CENTER
        } else {
            Align2::RIGHT_CENTER
        };
        let how = Type {
            size: lines.sizes.plain,
            colour: colours::of(palette::WORDS),
            ground: if is_selected { colours::BUTTON } else { colours::GROUND },
            align,
        };
        let inner = room.shrink2(vec2(lines.sizes.gap, 0.0));
        lines.words.put(lines.ui, inner, text, how);
    }
    let response = lines
        .ui
        .interact(line, Id::unique(("row", line.top().to_bits())), Sense::click());
    response.clicked()
}

fn doing(mode: &Mode, known: &Known<'_>) -> String {
    match mode {
        Mode::Point if known.plan.confirmed.is_some() => "the plan is looked at; nothing of it changes".to_owned(),
        Mode::Point => match known.depth[0] {
            1 => "1 change can be taken back".to_owned(),
            count => format!("{count} changes can be taken back"),
        },
        Mode::Level => "dragging changes the window; W ends it".to_owned(),
        Mode::Measure(points, count) => {
            let what = if *count == 2 { "distance" } else { "angle" };
            format!("{what}: point {} of {count}; Esc gives it up", points.len() + 1)
        }
    }
}

/// The numbers of the selected way.
fn way(target: &Target, lines: &mut Lines<'_, '_>) {
    let Some(way) = Trajectory::of(target) else {
        lines.put(
            &format!("{}: no entry; E sets it under the pointer", target.name),
            Tone::Quiet,
        );
        return;
    };
    let entry = way.entry.in_words(1);
    lines.put(
        &format!("entry {entry}, stops {:.1} mm before the centre", target.stop_mm),
        Tone::Quiet,
    );
    let to = |rad: f64, sides: [&str; 2]| {
        let side = if rad < 0.0 { sides[1] } else { sides[0] };
        format!("{:.1}\u{b0} to the {side}", rad.abs().to_degrees())
    };
    let head = to(way.to_head_rad(), ["head", "feet"]);
    let left = way
        .to_left_rad()
        .map_or("along the body".to_owned(), |rad| to(rad, ["left", "right"]));
    lines.put(
        &format!("{:.1} mm deep, {head}, {left} from straight back", way.depth_mm),
        Tone::Quiet,
    );
}

fn measured(number: usize, measure: &Measure, lines: &mut Lines<'_, '_>) {
    let text = match (measure.distance_mm(), measure.angle_rad()) {
        (Some(mm), _) => format!("distance {number}: {mm:.1} mm"),
        (None, Some(rad)) => format!("angle {number}: {:.1}\u{b0}", rad.to_degrees()),
        (None, None) => format!("angle {number}: two of its points lie together"),
    };
    lines.put(&text, Tone::Quiet);
}
