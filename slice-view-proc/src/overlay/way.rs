//! The way ahead: the tube's axis continued beyond the tip, and the line of the plan from the entry to the chosen target.
//!
//! One rule says how much of a line is drawn, as its image lies over anatomy that is not its own where it is off the plane: up to the
//! tube's radius from the plane it is solid (the tube, were it there, would be cut by the plane), up to [`NEAR_PLANE_MM`] dashed, and
//! beyond it is not drawn. The tube itself is drawn at every depth: it is there.

use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool};
use picture::{Canvas, DASHED, Dashes, palette};

use super::shapes::NEAR_PLANE_MM;
use super::{Notice, Overlay};

/// From tick to tick of the path, mm; where these have no room, five times as much.
const TICKS_MM: [f64; 2] = [10.0, 50.0];
/// The least room between two ticks, pixels, also of 512; and half their length, pixels of 512.
const TICK_ROOM: f64 = 6.0;
const TICK: f64 = 3.0;
/// Half the bar at which the tip is to stop, and from the middle to the corners of the mark at the entry, pixels of 512.
const STOP: f64 = 6.0;
const ENTRY: f64 = 5.0;
/// A bar across a line needs the line to have a direction on the image: this part of its length.
const LEAST_FLAT: f64 = 0.1;

/// A straight line through the patient as the image shows it; places on it are mm from its beginning.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// The pixel and the depth of its beginning, and what they change by along one mm.
    at: [f64; 2],
    depth: f64,
    step: [f64; 2],
    sink: f64,
}

/// A part of a line: from and to, mm, and whether it is dashed.
pub(super) type Stretch = ([f64; 2], bool);

impl Way {
    pub(super) fn of(plane: &SlicePlane, from: Point<Ct>, along: Direction<Ct>) -> Self {
        let at = plane.project(from);
        Self {
            at: [at.x, at.y],
            depth: at.depth_mm,
            step: [plane.right(), plane.down()].map(|axis| along.dot(axis) / plane.pixel_mm()),
            sink: along.dot(plane.into_screen()),
        }
    }

    /// The pixel at `t`.
    pub(super) fn pixel(&self, t: f64) -> [f64; 2] {
        [self.at[0] + t * self.step[0], self.at[1] + t * self.step[1]]
    }

    fn depth(&self, t: f64) -> f64 {
        self.depth + t * self.sink
    }

    /// How many pixels one mm takes.
    fn pixels(&self) -> f64 {
        self.step[0].hypot(self.step[1])
    }

    /// What of `range` is drawn on an image of `size` pixels.
    pub(super) fn stretches(&self, range: [f64; 2], size: [u32; 2], solid_mm: f64) -> Vec<Stretch> {
        let seen = [0, 1].map(|i| within(self.at[i], self.step[i], [-0.5, f64::from(size[i]) - 0.5]));
        let near = |mm: f64| within(self.depth, self.sink, [-mm, mm]);
        let common = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        let drawn = common(common(common(range, seen[0]), seen[1]), near(NEAR_PLANE_MM));
        let solid = common(drawn, near(solid_mm));
        let all = match solid[0] < solid[1] {
            true => vec![
                ([drawn[0], solid[0]], true),
                (solid, false),
                ([solid[1], drawn[1]], true),
            ],
            false => vec![(drawn, true)],
        };
        all.into_iter().filter(|([from, to], _)| from < to).collect()
    }

    /// A bar across the line at `t`, so many pixels to each side.
    fn bar(&self, t: f64, half: f64) -> [[f64; 2]; 2] {
        let ([x, y], [dx, dy], per_mm) = (self.pixel(t), self.step, self.pixels());
        let (dx, dy) = (dx / per_mm * half, dy / per_mm * half);
        [[x + dy, y - dx], [x - dy, y + dx]]
    }
}

/// Where `start + t step` lies in the range; nowhere is a range that runs backwards.
fn within(start: f64, step: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    if step == 0.0 {
        return match (low..=high).contains(&start) {
            true => [f64::NEG_INFINITY, f64::INFINITY],
            false => [f64::INFINITY, f64::NEG_INFINITY],
        };
    }
    let [a, b] = [(low - start) / step, (high - start) / step];
    [a.min(b), a.max(b)]
}

impl Overlay<'_> {
    fn solid_mm(&self) -> f64 {
        self.tool.diameter_mm / 2.0
    }

    /// What is drawn of a line.
    fn way_lines(&self, way: &Way, range: [f64; 2]) -> Vec<(Vec<[f64; 2]>, Dashes)> {
        let stretches = way.stretches(range, self.plane.size(), self.solid_mm());
        let line = |([from, to], dashed): Stretch| {
            let dashes = if dashed { DASHED } else { None };
            (vec![way.pixel(from), way.pixel(to)], dashes)
        };
        stretches.into_iter().map(line).collect()
    }

    /// The axis ahead of the tip, and where on it the drawing ends, mm from the tip: at the depth of the chosen target where that lies
    /// ahead, else where the image does.
    pub(super) fn path(&self, pose: Rigid<Ct, Tool>) -> (Way, f64) {
        let (tip, axis) = (pose * Point::<Tool>::new(0.0, 0.0, 0.0), pose * Direction::<Tool>::Z);
        let to_target = self
            .chosen
            .map(|chosen| (self.place(chosen.centre) - tip).dot(axis.vector()));
        let end = to_target.filter(|mm| *mm > 0.0).unwrap_or(f64::INFINITY);
        (Way::of(self.plane, tip, axis), end)
    }

    /// The path ahead of the tip, from so many pixels on, with a tick every 10 mm.
    pub(super) fn path_lines(&self, pose: Rigid<Ct, Tool>, cross_px: f64) -> Vec<(Vec<[f64; 2]>, Dashes)> {
        let (way, end) = self.path(pose);
        let range = [cross_px / way.pixels(), end];
        let bar = |t| (way.bar(t, TICK * self.unit()).to_vec(), None);
        let ticks = self.path_ticks(&way, range).into_iter().map(bar);
        self.way_lines(&way, range).into_iter().chain(ticks).collect()
    }

    /// Where the path's ticks are, mm from the tip.
    pub(super) fn path_ticks(&self, way: &Way, range: [f64; 2]) -> Vec<f64> {
        let room = TICK_ROOM * self.unit().max(1.0);
        let Some(every) = TICKS_MM.into_iter().find(|mm| mm * way.pixels() >= room) else {
            return Vec::new();
        };
        let drawn = way.stretches(range, self.plane.size(), self.solid_mm());
        let (Some(first), Some(last)) = (drawn.first(), drawn.last()) else {
            return Vec::new();
        };
        let (from, to) = (
            (first.0[0] / every).ceil().max(1.0) as u32,
            (last.0[1] / every).floor() as u32,
        );
        (from..=to).map(|k| f64::from(k) * every).collect()
    }

    /// The plan's line from the entry to the chosen target's centre, with its length, mm.
    pub(super) fn planned(&self) -> Option<(Way, f64)> {
        // On a plane that was asked for, whoever asked draws the plan that she makes there.
        let chosen = self.chosen.filter(|_| self.notice != Notice::Look)?;
        let entry = chosen.entry?;
        let along = (chosen.centre - entry).direction()?;
        Some((Way::of(self.plane, entry, along), chosen.centre.distance(entry)))
    }

    /// The plan's line: a square on its corner at the entry, a bar where the tip is to stop.
    pub(super) fn draw_planned(&self, canvas: &mut Canvas) {
        let (Some((way, length)), Some(chosen)) = (self.planned(), self.chosen) else {
            return;
        };
        let mut lines = self.way_lines(&way, [0.0, length]);
        let is_near = |t: f64| way.depth(t).abs() <= NEAR_PLANE_MM;
        if is_near(0.0) {
            let ([x, y], r) = (way.pixel(0.0), ENTRY * self.unit());
            lines.push((vec![[x + r, y], [x, y + r], [x - r, y], [x, y - r], [x + r, y]], None));
        }
        let stop = length - chosen.stop_mm;
        let has_direction = way.pixels() * self.plane.pixel_mm() >= LEAST_FLAT;
        if chosen.stop_mm > 0.0 && stop > 0.0 && is_near(stop) && has_direction {
            lines.push((way.bar(stop, STOP * self.unit()).to_vec(), None));
        }
        canvas.polylines(&lines, self.line(palette::TARGET, 1.0, false));
    }
}
