//! The tube at its true width: its outline as the viewer sees it, and its cut with the plane.
//!
//! The tube is the cylinder of the scene's diameter from the handle to the tip, with flat ends. Its outline is that of its orthogonal
//! projection: two edges, one diameter apart however the tube is tilted, the ring of its mouth and the far half of its other end. Its cut
//! is the exact section of that cylinder. Where the plane holds the axis both are one band.

use std::f64::consts::{FRAC_PI_2, PI};

use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool};
use picture::{Canvas, DASHED, Dashes, palette};
use scene::ToolSpec;

use super::Overlay;

/// What is closer than this to where something begins or ends is on it, mm: rounding decides nothing.
const SAME_MM: f64 = 1e-6;
/// Points on each side of the cut. As they lie closer where it turns, it is off by less than 0.2 % of the tube's radius.
const CUT_POINTS: usize = 33;
/// Corners of a ring, at least and at most.
const RING_POINTS: [f64; 2] = [24.0, 512.0];

/// How a line of the tube is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// Of the outline, where the tube is cut by the plane or lies in front of it.
    Outline,
    /// Of the outline, where the tube's whole width lies behind the plane.
    Behind,
    /// The border of the cut.
    Cut,
}

/// The tube as it lies to a plane: mm along the plane's columns and rows from its first pixel, and depths behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tube {
    tip: [f64; 2],
    tip_depth: f64,
    /// Where the axis points to on the image, towards the tip: a unit vector, any where the tube is seen along its axis.
    along: [f64; 2],
    /// Of the axis' unit vector, what lies in the plane and what goes into the screen.
    flat: f64,
    into: f64,
    radius: f64,
    length: f64,
    pixel: f64,
    /// Between these, mm along [`Tube::along`] from the tip, lies the image.
    seen: [f64; 2],
}

impl Tube {
    pub(super) fn of(plane: &SlicePlane, pose: Rigid<Ct, Tool>, tool: &ToolSpec) -> Self {
        let at = plane.project(pose * Point::<Tool>::new(0.0, 0.0, 0.0));
        let axis = pose * Direction::<Tool>::Z;
        let [x, y] = [axis.dot(plane.right()), axis.dot(plane.down())];
        let flat = x.hypot(y);
        let along = if flat > 0.0 { [x / flat, y / flat] } else { [1.0, 0.0] };
        let pixel = plane.pixel_mm();
        let (tip, radius) = ([at.x * pixel, at.y * pixel], tool.diameter_mm / 2.0);
        let sides = plane.size().map(|n| f64::from(n) * pixel);
        let middle = (sides[0] / 2.0 - tip[0]) * along[0] + (sides[1] / 2.0 - tip[1]) * along[1];
        let reach = sides[0].hypot(sides[1]) / 2.0 + radius;
        Self {
            tip,
            tip_depth: at.depth_mm,
            along,
            flat,
            into: axis.dot(plane.into_screen()),
            radius,
            length: tool.length_mm,
            pixel,
            seen: [middle - reach, middle + reach],
        }
    }

    /// The pixel `along` mm from the tip in the direction of the axis on the image, and `across` mm to its side.
    fn pixel(&self, along: f64, across: f64) -> [f64; 2] {
        let [ex, ey] = self.along;
        [
            (self.tip[0] + along * ex - across * ey) / self.pixel,
            (self.tip[1] + along * ey + across * ex) / self.pixel,
        ]
    }

    /// How far behind the plane the nearest point of the tube's width lies at `s` mm along the axis from the tip, mm. A width is a disc,
    /// which reaches out of the plane by its radius times the cosine of the tilt.
    fn behind(&self, s: f64) -> f64 {
        self.tip_depth + s * self.into - self.radius * self.flat - SAME_MM
    }

    fn outline(&self, s: f64) -> Part {
        if self.behind(s) > 0.0 {
            Part::Behind
        } else {
            Part::Outline
        }
    }

    /// All its lines, pixels.
    pub(super) fn lines(&self) -> Vec<(Vec<[f64; 2]>, Part)> {
        let mut lines = Vec::new();
        // Seen along its axis it has no edges: mouth and other end are one ring.
        if self.length * self.flat > self.pixel {
            lines.push((
                self.ring(-self.length, [FRAC_PI_2, 3.0 * FRAC_PI_2]),
                self.outline(-self.length),
            ));
            for across in [self.radius, -self.radius] {
                for ([from, to], part) in self.edge() {
                    lines.push((
                        vec![self.pixel(from * self.flat, across), self.pixel(to * self.flat, across)],
                        part,
                    ));
                }
            }
        }
        let mouth = if self.is_cut_at_mouth() {
            Part::Cut
        } else {
            self.outline(0.0)
        };
        lines.push((self.ring(0.0, [0.0, 2.0 * PI]), mouth));
        if !self.is_cut_at_mouth() {
            lines.extend(self.cut().into_iter().map(|side| (side, Part::Cut)));
        }
        lines
    }

    /// The edges between the tip and the handle, as far as the image may show them, from the tip backwards so that dashes do not crawl.
    fn edge(&self) -> Vec<([f64; 2], Part)> {
        let near = (self.seen[1] / self.flat).min(0.0);
        let far = (self.seen[0] / self.flat).max(-self.length);
        if near <= far {
            return Vec::new();
        }
        // Where the edge goes behind the plane, if it does in between.
        let turn = near - self.behind(near) / self.into;
        let ends = match turn > far && turn < near {
            true => vec![[near, turn], [turn, far]],
            false => vec![[near, far]],
        };
        ends.into_iter()
            .map(|[a, b]| ([a, b], self.outline(0.5 * (a + b))))
            .collect()
    }

    /// The circle about the axis at `s`, between two angles from where the axis points to on the image.
    fn ring(&self, s: f64, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
        let points = 7.0 * (self.radius / self.pixel).sqrt() * (to - from) / (2.0 * PI);
        let points = points.clamp(RING_POINTS[0], RING_POINTS[1]).ceil() as usize;
        let at = |i: usize| {
            let (sin, cos) = (from + (to - from) * i as f64 / points as f64).sin_cos();
            self.pixel(s * self.flat + self.radius * self.into.abs() * cos, self.radius * sin)
        };
        (0..=points).map(at).collect()
    }

    /// Whether the plane goes through the mouth along it, so closely that cut and ring are one line.
    fn is_cut_at_mouth(&self) -> bool {
        let apart = self.radius * self.flat * self.flat / self.into.abs();
        self.tip_depth.abs() <= self.radius * self.flat + SAME_MM && apart < 0.5 * self.pixel
    }

    /// Where along the axis on the image the plane cuts the tube, mm from the tip.
    fn cut_range(&self) -> Option<[f64; 2]> {
        let (flat, into, depth) = (self.flat, self.into, self.tip_depth);
        // A point of the plane `a` mm along is `a into + depth flat` beside the axis, and `a flat - depth into` along it.
        let wide = between(into, depth * flat, [-self.radius, self.radius]);
        let long = between(flat, -depth * into, [-self.length - SAME_MM, SAME_MM]);
        let [low, high] = [wide, long]
            .into_iter()
            .fold(self.seen, |[l, h], [a, b]| [l.max(a), h.min(b)]);
        (low < high).then_some([low, high])
    }

    /// The two long sides of the cut; where it ends within the tube's wall they meet. Its straight ends are the tube's own, which have
    /// their rings.
    fn cut(&self) -> Vec<Vec<[f64; 2]>> {
        let Some([low, high]) = self.cut_range() else {
            return Vec::new();
        };
        let side = |sign: f64| {
            let at = |i: usize| {
                let turn = PI * (i as f64 / (CUT_POINTS - 1) as f64 - 0.5);
                let along = 0.5 * (low + high) + 0.5 * (high - low) * turn.sin();
                let beside = along * self.into + self.tip_depth * self.flat;
                let across = (self.radius * self.radius - beside * beside).max(0.0).sqrt();
                self.pixel(along, sign * across)
            };
            (0..CUT_POINTS).map(at).collect()
        };
        vec![side(1.0), side(-1.0)]
    }
}

/// Where `slope x + offset` lies in the range; nowhere is a range that runs backwards.
fn between(slope: f64, offset: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    if slope == 0.0 {
        return match (low..=high).contains(&offset) {
            true => [f64::NEG_INFINITY, f64::INFINITY],
            false => [f64::INFINITY, f64::NEG_INFINITY],
        };
    }
    let [a, b] = [(low - offset) / slope, (high - offset) / slope];
    [a.min(b), a.max(b)]
}

impl Overlay<'_> {
    /// The tube, thin where it is seen, stronger where the plane cuts it, dashed where it lies behind the plane; and the path ahead of it
    /// from so many pixels behind the tip on.
    pub(super) fn draw_tube(&self, canvas: &mut Canvas, pose: Rigid<Ct, Tool>, cross_px: f64) {
        let lines = Tube::of(self.plane, pose, self.tool).lines();
        let (cut, seen): (Vec<_>, Vec<_>) = lines.into_iter().partition(|(_, part)| *part == Part::Cut);
        let dashes = |part| if part == Part::Behind { DASHED } else { None };
        let seen = seen.into_iter().map(|(points, part)| (points, dashes(part)));
        let thin: Vec<(_, Dashes)> = seen.chain(self.path_lines(pose, cross_px)).collect();
        canvas.polylines(&thin, self.line(palette::TUBE, 1.0, false));
        let cut: Vec<(_, Dashes)> = cut.into_iter().map(|(points, _)| (points, None)).collect();
        canvas.polylines(&cut, self.line(palette::TUBE, 1.6, false));
    }
}
