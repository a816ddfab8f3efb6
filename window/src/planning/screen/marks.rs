//! Lines over an image of the planning screen, all with a dark rim, so that they are seen on bone and on air.

use egui::{Color32, Painter, Pos2, Shape, Stroke, vec2};
use geometry::{Ct, Point};
use guidance::plan::{Target, Trajectory};
use picture::palette;

use super::super::placed::Placed;
use crate::colours;

/// What lies further from the plane is not drawn, or dashed, mm.
pub(super) const NEAR_MM: f64 = 10.0;
/// Points of a circle.
const ROUND: usize = 48;

/// Draws on one image.
pub(super) struct Pen<'a> {
    pub(super) painter: &'a Painter,
    pub(super) placed: &'a Placed,
    /// Of a thin line, pixels.
    pub(super) width: f32,
}

impl Pen<'_> {
    fn line(&self, points: &[Pos2], colour: Color32, is_dashed: bool) {
        self.line_of(points, colour, is_dashed.then_some(6.0 * self.width));
    }

    /// With dashes of this length, pixels.
    fn line_of(&self, points: &[Pos2], colour: Color32, dash: Option<f32>) {
        let (rim, line) = (
            Stroke::new(3.2 * self.width, Color32::BLACK),
            Stroke::new(1.6 * self.width, colour),
        );
        for stroke in [rim, line] {
            match dash {
                Some(dash) => self.painter.extend(Shape::dashed_line(points, stroke, dash, dash)),
                None => drop(self.painter.add(Shape::line(points.to_vec(), stroke))),
            }
        }
    }

    fn circle(&self, at: Pos2, radius: f32, colour: Color32, is_dashed: bool) {
        let angle = |k: usize| std::f32::consts::TAU * k as f32 / ROUND as f32;
        let points: Vec<Pos2> = (0..=ROUND)
            .map(|k| at + radius * vec2(angle(k).cos(), angle(k).sin()))
            .collect();
        // Eight dashes at least: a small ring of long ones is no ring.
        let dash = (6.0 * self.width).min(std::f32::consts::TAU * radius / 16.0);
        self.line_of(&points, colour, is_dashed.then_some(dash));
    }

    /// Where the other slices cut this one: a cross with an open middle.
    pub(super) fn cross(&self, cursor: Point<Ct>) {
        let (at, _) = self.placed.on_screen(cursor);
        let rect = self.placed.rect;
        let gap = 8.0 * self.width;
        let stroke = Stroke::new(self.width, colours::LINE);
        for [from, to] in [
            [Pos2::new(rect.left(), at.y), at - vec2(gap, 0.0)],
            [at + vec2(gap, 0.0), Pos2::new(rect.right(), at.y)],
            [Pos2::new(at.x, rect.top()), at - vec2(0.0, gap)],
            [at + vec2(0.0, gap), Pos2::new(at.x, rect.bottom())],
        ] {
            self.painter.line_segment([from, to], stroke);
        }
    }

    /// A target: its cut with the plane, or dashed the outline of one nearby; the selected one with a second ring.
    pub(super) fn target(&self, target: &Target, is_selected: bool) {
        let (at, depth_mm) = self.placed.on_screen(target.centre);
        if depth_mm.abs() <= NEAR_MM {
            let radius_mm = target.diameter_mm / 2.0;
            let cut_sq = radius_mm * radius_mm - depth_mm * depth_mm;
            let is_cut = cut_sq > 0.0;
            let radius = self.placed.px(if is_cut { cut_sq.sqrt() } else { radius_mm });
            let radius = radius.max(3.0 * self.width);
            let colour = colours::of(palette::TARGET);
            self.circle(at, radius, colour, !is_cut);
            if is_selected {
                self.circle(at, radius + 5.0 * self.width, colour, !is_cut);
            }
        }
        if let Some(entry) = target.entry {
            self.entry(entry);
        }
    }

    /// An entry: a square on its corner.
    fn entry(&self, entry: Point<Ct>) {
        let (at, depth_mm) = self.placed.on_screen(entry);
        if depth_mm.abs() > NEAR_MM {
            return;
        }
        let reach = 7.0 * self.width;
        let corners = [
            vec2(reach, 0.0),
            vec2(0.0, reach),
            vec2(-reach, 0.0),
            vec2(0.0, -reach),
            vec2(reach, 0.0),
        ];
        let points = corners.map(|by| at + by);
        self.line(&points, colours::of(palette::TIP), depth_mm.abs() > 1.0);
    }

    /// A way: its line, and the walls of the tube about it where a radius is given. Dashed where it lies off the plane.
    pub(super) fn way(&self, way: &Trajectory, radius_mm: Option<f64>) {
        let [(from, from_mm), (to, to_mm)] = [way.entry, way.stop].map(|p| self.placed.on_screen(p));
        let off_mm = radius_mm.unwrap_or(1.0);
        let is_off = from_mm.abs() > off_mm || to_mm.abs() > off_mm;
        let colour = colours::of(palette::TUBE);
        self.line(&[from, to], colour, is_off);
        let (Some(radius_mm), length) = (radius_mm, (to - from).length()) else {
            return;
        };
        if is_off || length < 1.0 {
            return;
        }
        // In the plane the tube is as wide as it is.
        let beside = vec2(-(to - from).y, (to - from).x) / length * self.placed.px(radius_mm);
        for by in [beside, -beside] {
            self.painter
                .line_segment([from + by, to + by], Stroke::new(self.width, colour));
        }
    }

    /// The points of a distance or an angle, joined; dashed where they lie off the plane.
    pub(super) fn measure(&self, points: &[Point<Ct>]) {
        let places: Vec<(Pos2, f64)> = points.iter().map(|p| self.placed.on_screen(*p)).collect();
        if places.iter().all(|(_, depth_mm)| depth_mm.abs() > NEAR_MM) {
            return;
        }
        let is_off = places.iter().any(|(_, depth_mm)| depth_mm.abs() > 1.0);
        let at: Vec<Pos2> = places.iter().map(|(at, _)| *at).collect();
        let colour = colours::of(palette::WORDS);
        self.line(&at, colour, is_off);
        for p in at {
            self.circle(p, 2.5 * self.width, colour, false);
        }
    }
}
