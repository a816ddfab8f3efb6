//! Where the planes of the other views cut this one. They are those of this image's own pose, whatever pose the other images show.

use geometry::{Ct, Point, Rigid, SlicePlane, Tool};
use picture::{Canvas, palette};
use scene::{Plane, View};

use super::Overlay;
use super::layout::Caption;
use crate::view;

/// Planes that meet at a smaller angle have no line: a little noise would throw it about. The sine of 5 degrees.
const LEAST_SINE: f64 = 0.087;
/// This part of the image's shorter side around the tip stays free.
const OPEN: f64 = 0.2;
/// A line is so much of the shorter side long at the most: where it goes is seen from its ends, and anatomy is not written over.
const STUB: f64 = 0.12;
/// How a line looks by the direction of its plane: dash, gap, dash, gap, pixels of 512.
const LOOKS: [(Plane, [f64; 4], &str); 4] = [
    (Plane::Axial, [10.0, 5.0, 10.0, 5.0], "ax"),
    (Plane::Frontal, [2.0, 5.0, 2.0, 5.0], "fro"),
    (Plane::Sagittal, [10.0, 5.0, 2.0, 5.0], "sag"),
    (Plane::Perpendicular, [20.0, 5.0, 2.0, 5.0], "perp"),
];

/// The line along which another view's plane cuts this one.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutLine<'a> {
    pub(super) other: &'a View,
    /// Its two parts, each from the image's border inwards, pixels.
    pub(super) parts: [Option<[[f64; 2]; 2]>; 2],
}

impl Overlay<'_> {
    /// The cuts of a valid pose's planes, each plane once; none on images that are too small for words.
    pub(super) fn cut_lines(&self) -> Vec<CutLine<'_>> {
        let Some(pose) = self.pose.filter(|_| self.has_words() && !self.is_surface()) else {
            return Vec::new();
        };
        let is_same = |a: &View, b: &View| (a.plane, a.ahead_mm) == (b.plane, b.ahead_mm);
        let is_first = |(i, other): &(usize, &View)| !self.views[..*i].iter().any(|before| is_same(before, other));
        let others = self.views.iter().enumerate().filter(is_first);
        others.filter_map(|(_, other)| self.cut_line(other, pose)).collect()
    }

    fn cut_line<'a>(&self, other: &'a View, pose: Rigid<Ct, Tool>) -> Option<CutLine<'a>> {
        let (through, normal) = view::lies(other, &pose)?;
        let plane = self.plane;
        if normal.cross(plane.into_screen()).norm() < LEAST_SINE {
            return None;
        }
        // Pixels of the other plane: a x + b y + c = 0.
        let (a, b) = (
            normal.vector().dot(plane.step_right()),
            normal.vector().dot(plane.step_down()),
        );
        let c = (plane.origin() - through).dot(normal.vector());
        let tip = plane.project(pose * Point::<Tool>::new(0.0, 0.0, 0.0));
        let parts = open_line([a, b, c], [tip.x, tip.y], plane);
        parts.iter().any(Option::is_some).then_some(CutLine { other, parts })
    }

    pub(super) fn draw_cuts(&self, canvas: &mut Canvas) {
        let mut lines = Vec::new();
        for cut in self.cut_lines() {
            let dashes = look(cut.other.plane).0.map(|px| (px * self.unit()) as f32);
            let parts = cut.parts.into_iter().flatten();
            lines.extend(parts.map(|ends| (ends.to_vec(), Some(dashes))));
        }
        canvas.polylines(&lines, self.line(palette::CUT, 1.0, false));
    }

    /// The names of the cuts beside their outer ends.
    pub(super) fn cut_labels(&self) -> Vec<Caption> {
        let lines = self.cut_lines();
        lines.iter().map(|cut| self.cut_label(cut)).collect()
    }

    fn cut_label(&self, cut: &CutLine<'_>) -> Caption {
        let mut text = look(cut.other.plane).1.to_owned();
        if cut.other.ahead_mm != 0.0 {
            text += &format!(" {:+}", cut.other.ahead_mm);
        }
        self.beside_ends(text, cut.parts)
    }
}

/// The look of a plane's line and its name.
fn look(plane: Plane) -> ([f64; 4], &'static str) {
    let known = LOOKS.iter().find(|(of, ..)| *of == plane);
    known.map_or((LOOKS[0].1, ""), |&(_, dashes, name)| (dashes, name))
}

/// The line `a x + b y + c = 0` from the image's border inwards, not into the ring about `tip` that stays free: from each side.
fn open_line([a, b, c]: [f64; 3], tip: [f64; 2], plane: &SlicePlane) -> [Option<[[f64; 2]; 2]>; 2] {
    let [width, height] = plane.size().map(|n| f64::from(n) - 1.0);
    let length = a.hypot(b);
    let ([nx, ny], off) = ([a / length, b / length], (a * tip[0] + b * tip[1] + c) / length);
    // The foot of the tip on the line, and places along it.
    let foot = [tip[0] - off * nx, tip[1] - off * ny];
    let at = |t: f64| [foot[0] - t * ny, foot[1] + t * nx];
    let side = |start: f64, step: f64, end: f64| match step == 0.0 {
        true if (0.0..=end).contains(&start) => [f64::NEG_INFINITY, f64::INFINITY],
        true => [f64::INFINITY, f64::NEG_INFINITY],
        false => {
            let [p, q] = [-start / step, (end - start) / step];
            [p.min(q), p.max(q)]
        }
    };
    let (x, y) = (side(foot[0], -ny, width), side(foot[1], nx, height));
    let (low, high) = (x[0].max(y[0]), x[1].min(y[1]));
    let open = OPEN * (width.min(height) + 1.0);
    let half = (open * open - off * off).max(0.0).sqrt();
    if low >= high {
        return [None; 2];
    }
    let stub = (STUB * (width.min(height) + 1.0)).min((high - low) / 2.0);
    // From an end inwards, as far as the ring; nothing where the end lies in it.
    let inwards = |end: f64, sign: f64| {
        let to_ring = -half - sign * end;
        let free = if to_ring >= 0.0 { to_ring } else { f64::INFINITY };
        let is_outside = end.abs() > half || half == 0.0;
        is_outside.then(|| [at(end), at(end + sign * stub.min(free))])
    };
    [inwards(low, 1.0), inwards(high, -1.0)]
}
