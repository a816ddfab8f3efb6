//! A motion that is listened to: where the instrument was, where it is, and which directions are still to be reached.
//!
//! A pivoting is seen along the shaft from the handle. Each direction has a cell on the ring outside, which fills as the motion reaches that
//! way and has the colour of targets once it reaches far enough; a spinning has such cells to both sides of where it began. A ring that is
//! full is a motion that is enough: what calib tells of a sector is never more than what its gate is on.

use std::f64::consts::TAU;

use bus::message::{StepMotion, StepMotionKind, Steps};
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Ui, vec2};
use picture::palette;

use crate::colours;
use crate::model::Tone;
use crate::screen::lines::Lines;
use crate::screen::words::Words;
use crate::sizes::Sizes;

/// Of the picture's radius: what is needed, and the ring of what is reached.
const NEEDED: f64 = 0.64;
const RING: [f64; 2] = [0.84, 1.0];
/// A direction that is not reached fills at most so much of its cell.
const MOST_UNREACHED: f64 = 0.8;
/// Of a cell's width, what is left free at each side.
const GAP: f64 = 0.06;
/// An arc up to this is drawn straight: that of a sector.
const STRAIGHT: f64 = 0.27;
/// Where the instrument was: of the tube's colour, dark enough for what lies over it.
const WAS: f32 = 0.45;
/// Below so many lines there is no picture, and words alone.
const LEAST_LINES: f32 = 5.0;
/// Cells of a spinning, 5 degrees each.
const TURN: f64 = TAU / StepMotion::TURN_CELLS as f64;
/// Cells of its ring to each side: half a turn in all, which is what is asked for.
const SIDE_CELLS: usize = StepMotion::TURN_CELLS / 4;

/// Whether there was a motion to show.
pub(super) fn show(ui: &Ui, told: &Steps, room: Rect, (sizes, words): (&Sizes, &mut Words)) -> bool {
    let motion = &told.motion;
    let Some(kind) = motion.kind() else { return false };
    let side = room.height().min(0.5 * room.width());
    let text = match side > LEAST_LINES * sizes.plain {
        true => {
            let square = Rect::from_min_size(room.min, vec2(side, side)).shrink(sizes.gap);
            let drawing = Drawing {
                painter: ui.painter(),
                middle: square.center(),
                radius: 0.5 * f64::from(square.width()),
                line: sizes.line,
            };
            match kind {
                StepMotionKind::Pivot => drawing.pivot(motion),
                StepMotionKind::Spin => drawing.spin(motion),
            }
            room.with_min_x(room.left() + side + sizes.gap)
        }
        false => room,
    };
    let mut lines = Lines::new(ui, text, (sizes, words)).or_by("`pilot steps` says them");
    for line in said(motion, kind) {
        lines.put_all(&line, Tone::Quiet);
    }
    lines.put_waiting();
    true
}

/// What the picture shows, in words. Angles are cut and not rounded: what lacks a little is not said to be reached.
fn said(motion: &StepMotion, kind: StepMotionKind) -> Vec<String> {
    let cut = |rad: f64| (rad.to_degrees() * 10.0).floor() / 10.0;
    let needed = motion.needed_rad.to_degrees();
    let reached = match motion.reached_rad.is_finite() && motion.needed_rad.is_finite() {
        true => format!("{:.1} of {needed:.1} degrees", cut(motion.reached_rad)),
        false => "not known".to_owned(),
    };
    let count = (0..StepMotion::SECTORS).filter(|k| motion.is_reached(*k)).count();
    match kind {
        StepMotionKind::Pivot => {
            let sides = match motion.is_complete() {
                true => "WIDE ENOUGH to every side".to_owned(),
                false => format!("{count} of {} sides reached", StepMotion::SECTORS),
            };
            let up = ["x", "y", "z"].get(motion.up as usize).copied().unwrap_or("?");
            vec![
                format!("cone {reached}"),
                sides,
                format!("seen along the shaft from the handle; up: the marker's {up} axis"),
            ]
        }
        StepMotionKind::Spin => {
            let enough = match motion.is_complete() {
                true => "TURNED ENOUGH to both sides",
                false => "turn it further to both sides",
            };
            vec![
                format!("turn {reached}"),
                enough.to_owned(),
                "seen along the shaft from the handle".to_owned(),
            ]
        }
    }
}

/// Of a cell of the ring: how much of it is full, 0 to 1. It is 1 only of what is reached.
fn filled(motion: &StepMotion, sector: usize) -> f64 {
    if motion.is_reached(sector) {
        return 1.0;
    }
    let share = motion
        .reach_rad
        .get(sector)
        .map_or(0.0, |reach| reach / motion.needed_rad);
    // What is not a number is nothing.
    if share > 0.0 { share.min(MOST_UNREACHED) } else { 0.0 }
}

/// Whether the `k`th cell from the middle of a spinning's ring is reached, of `SIDE_CELLS` on each side: all are where the turn is enough.
fn is_turned(motion: &StepMotion, k: usize) -> bool {
    let part = ((k + 1) as f64 / SIDE_CELLS as f64).min(1.0);
    motion.reach_rad.iter().all(|reach| *reach >= part * motion.needed_rad)
}

struct Drawing<'a> {
    painter: &'a Painter,
    middle: Pos2,
    radius: f64,
    line: f32,
}

impl Drawing<'_> {
    /// At an angle from the right to the top, at a part of the radius.
    fn at(&self, angle: f64, part: f64) -> Pos2 {
        let reach = part * self.radius;
        self.middle + vec2((reach * angle.cos()) as f32, (-reach * angle.sin()) as f32)
    }

    fn circle(&self, part: f64, wide: f32, colour: Color32) {
        let radius = (part * self.radius) as f32;
        self.painter
            .circle_stroke(self.middle, radius, Stroke::new(wide * self.line, colour));
    }

    /// A part of a ring between two angles and two parts of the radius, in pieces that are as good as straight.
    fn ring(&self, [from, to]: [f64; 2], [inner, outer]: [f64; 2], colour: Color32) {
        let pieces = ((to - from) / STRAIGHT).ceil().clamp(1.0, 64.0);
        let angle = |k: f64| from + (to - from) * k / pieces;
        for k in 0..pieces as usize {
            let [a, b] = [angle(k as f64), angle(k as f64 + 1.0)];
            let corners = [(a, inner), (a, outer), (b, outer), (b, inner)];
            let corners = corners.map(|(angle, part)| self.at(angle, part)).to_vec();
            self.painter.add(Shape::convex_polygon(corners, colour, Stroke::NONE));
        }
    }

    /// A cell of what is needed: hollow, and full as far as it is reached.
    fn cell(&self, angles: [f64; 2], share: f64, is_reached: bool) {
        let wide = angles[1] - angles[0];
        let angles = [angles[0] + GAP * wide, angles[1] - GAP * wide];
        self.ring(angles, RING, colours::BUTTON);
        let [inner, outer] = RING;
        let colour = if is_reached { palette::TARGET } else { palette::QUIET };
        if share > 0.0 {
            self.ring(angles, [inner, inner + share * (outer - inner)], colours::of(colour));
        }
    }

    fn was(&self, angles: [f64; 2], parts: [f64; 2]) {
        // Opaque: cells that touch would be lighter where they do.
        let [r, g, b, _] = colours::of(palette::TUBE).to_array();
        let dark = |level: u8| (WAS * f32::from(level)) as u8;
        self.ring(angles, parts, Color32::from_rgb(dark(r), dark(g), dark(b)));
    }

    fn pivot(&self, motion: &StepMotion) {
        let radius = (0.8 * self.radius) as f32;
        self.painter.circle_filled(self.middle, radius, colours::CELL);
        let (wide, step) = (TAU / StepMotion::SECTORS as f64, 0.25 * NEEDED);
        for sector in 0..StepMotion::SECTORS {
            let about = wide * sector as f64;
            let angles = [about - 0.5 * wide, about + 0.5 * wide];
            for ring in 0..StepMotion::RINGS {
                if motion.was_in(ring * StepMotion::SECTORS + sector) {
                    self.was(angles, [step * ring as f64, step * (ring + 1) as f64]);
                }
            }
            self.cell(angles, filled(motion, sector), motion.is_reached(sector));
        }
        self.circle(NEEDED, 2.0, colours::of(palette::WORDS));
        let [x, y] = motion.now_rad;
        let (far, angle) = (x.hypot(y) / motion.needed_rad, y.atan2(x));
        if far.is_finite() {
            self.now(self.at(angle, NEEDED * far.min(1.25)));
        }
    }

    fn spin(&self, motion: &StepMotion) {
        let radius = (0.8 * self.radius) as f32;
        self.painter.circle_filled(self.middle, radius, colours::CELL);
        // No turn is at the top.
        let top = 0.25 * TAU;
        for cell in (0..StepMotion::TURN_CELLS).filter(|cell| motion.was_in(*cell)) {
            let from = top - 0.5 * TAU + TURN * cell as f64;
            self.was([from, from + TURN], [0.3, NEEDED]);
        }
        for k in 0..SIDE_CELLS {
            let (is_reached, from) = (is_turned(motion, k), TURN * k as f64);
            let share = f64::from(u8::from(is_reached));
            for angles in [[top + from, top + from + TURN], [top - from - TURN, top - from]] {
                self.cell(angles, share, is_reached);
            }
        }
        self.circle(NEEDED, 1.0, colours::LINE);
        let [turn, _] = motion.now_rad;
        if turn.is_finite() {
            self.now(self.at(top + turn, NEEDED));
        }
    }

    /// Where the instrument is.
    fn now(&self, at: Pos2) {
        let radius = (0.05 * self.radius).max(2.0) as f32;
        self.painter
            .circle_filled(at, radius + 1.5 * self.line, colours::of(palette::RIM));
        self.painter.circle_filled(at, radius, colours::of(palette::TIP));
    }
}

#[cfg(test)]
mod tests;
