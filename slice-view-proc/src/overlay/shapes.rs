//! Lines over the slice: the tip with its error, and targets. All with a dark rim, so that they are seen on bone and on air.

use bus::message::Chosen;
use geometry::{Ct, Point, Rigid, Tool};
use picture::{Canvas, Line, Rgb, palette};
use scene::{Extent, Target};

use super::Overlay;

/// Targets further than this from the plane are not drawn, mm: an outline over other anatomy would mislead.
pub const NEAR_PLANE_MM: f64 = 10.0;
/// From the outline of the chosen target to its second ring, pixels of 512.
const RING: f64 = 5.0;
/// A thinner line between two rows of pixels has too little contrast to its rim, pixels.
const THINNEST: f64 = 1.3;
/// The rim of a line, pixels of 512: a pixel beside the thinnest line is all rim, also where that lies between two rows.
const RIM: f64 = 1.35;

/// A target on the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline<'a> {
    pub(super) target: &'a Target,
    pub(super) circle: Circle,
    /// What words keep off, pixels from its middle: its outline, or the second ring.
    pub(super) reach_px: f64,
}

/// A ball on the image: its cut with the plane, or its outline.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    /// Its middle, pixels.
    pub(super) at: [f64; 2],
    pub(super) radius_px: f64,
    /// How far behind the plane its centre is, mm.
    pub(super) depth_mm: f64,
    /// Whether the plane meets it.
    pub(super) cut: bool,
}

impl Overlay<'_> {
    pub(super) fn line(&self, colour: Rgb, width: f64, dashed: bool) -> Line {
        let width = (width * self.unit()).max(THINNEST) as f32;
        let line = match dashed {
            true => Line::dashed(colour, width),
            false => Line::solid(colour, width),
        };
        line.with_rim((RIM * self.unit()).max(1.0) as f32)
    }

    /// The tube and the path ahead, and over them the tip with its error.
    pub(super) fn tube(&self, canvas: &mut Canvas, pose: Rigid<Ct, Tool>) {
        let tip = self.tip(pose);
        let error = self.error_at_tip(tip);
        let [gap, arm] = self.cross(tip, error.as_deref());
        if !self.is_surface() {
            self.draw_tube(canvas, pose, arm);
        }
        if let Some(error) = &error {
            canvas.polyline(error, self.line(palette::TIP, 1.2, false));
        }
        for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            let [from, to] = [gap, arm].map(|reach| [tip[0] + dx * reach, tip[1] + dy * reach]);
            canvas.line(from, to, self.line(palette::TIP, 1.5, false));
        }
    }

    /// The tip's pixel.
    fn tip(&self, pose: Rigid<Ct, Tool>) -> [f64; 2] {
        let tip = self.plane.project(pose * Point::<Tool>::new(0.0, 0.0, 0.0));
        [tip.x, tip.y]
    }

    /// Where the arms of the cross at the tip begin and end, pixels from it: outside the ellipse, which they would fill.
    fn cross(&self, tip: [f64; 2], error: Option<&[[f64; 2]]>) -> [f64; 2] {
        let reach = |p: &[f64; 2]| (p[0] - tip[0]).hypot(p[1] - tip[1]);
        let widest = error.unwrap_or_default().iter().map(reach).fold(0.0, f64::max);
        let gap = (3.0 * self.unit()).max(widest + 1.5 * self.unit());
        [gap, gap + 6.0 * self.unit()]
    }

    /// What words keep off about the tip: the cross, or the image's middle ninth where the ellipse is larger.
    pub(super) fn about_the_tip(&self, pose: Rigid<Ct, Tool>) -> [[f64; 2]; 2] {
        let tip = self.tip(pose);
        let [_, arm] = self.cross(tip, self.error_at_tip(tip).as_deref());
        let arm = arm.min(512.0 / 6.0 * self.unit());
        [[tip[0] - arm, tip[1] - arm], [tip[0] + arm, tip[1] + arm]]
    }

    /// The 95 % ellipse about the tip, on surfaces and on images that show the tip enlarged.
    fn error_at_tip(&self, tip: [f64; 2]) -> Option<Vec<[f64; 2]>> {
        match self.view.extent {
            Extent::Global if !self.is_surface() => None,
            Extent::Local | Extent::Global => self.accuracy?.ellipse(self.plane, tip),
        }
    }

    /// The targets near the plane that the image shows: the cut where the plane meets one, else its outline.
    pub(super) fn outlines(&self) -> impl Iterator<Item = Outline<'_>> {
        let outlines = self.targets.iter().map(|target| {
            let circle = self.circle(self.place(target.centre), target.diameter_mm / 2.0);
            let ring = if self.is_chosen(target) {
                RING * self.unit()
            } else {
                0.0
            };
            Outline {
                target,
                circle,
                reach_px: circle.radius_px + ring,
            }
        });
        outlines.filter(|outline| self.is_seen(&outline.circle))
    }

    /// Whether this target of the scene is the chosen one, by its place.
    fn is_chosen(&self, target: &Target) -> bool {
        let is_it = |chosen: &Chosen| (chosen.centre, chosen.radius_mm) == (target.centre, target.diameter_mm / 2.0);
        self.chosen.is_some_and(is_it)
    }

    pub(super) fn is_seen(&self, outline: &Circle) -> bool {
        let [width, height] = self.plane.size().map(f64::from);
        let ([x, y], r) = (outline.at, outline.radius_px);
        let is_near = self.is_surface() || outline.depth_mm.abs() <= NEAR_PLANE_MM;
        is_near && x + r >= 0.0 && x - r <= width && y + r >= 0.0 && y - r <= height
    }

    /// A ball on the image.
    pub(super) fn circle(&self, centre: Point<Ct>, radius: f64) -> Circle {
        let at = self.plane.project(centre);
        // On a surface a ball is seen whole, wherever it is.
        let depth_mm = if self.is_surface() { 0.0 } else { at.depth_mm };
        let cut_sq = radius * radius - depth_mm * depth_mm;
        let cut = cut_sq > 0.0;
        let radius_px = if cut { cut_sq.sqrt() } else { radius } / self.plane.pixel_mm();
        Circle {
            at: [at.x, at.y],
            radius_px: radius_px.max(3.0 * self.unit()),
            depth_mm: at.depth_mm,
            cut,
        }
    }

    pub(super) fn draw_outlines(&self, canvas: &mut Canvas) {
        self.draw_places_at_rest(canvas);
        self.draw_model_errors(canvas);
        for Outline { circle: outline, .. } in self.outlines() {
            let line = self.line(palette::TARGET, 1.5, !outline.cut);
            canvas.circle(outline.at, outline.radius_px, line);
        }
    }

    /// The second ring about the chosen target: told by its shape, whoever sees no colours. The first is drawn here too where the
    /// scene has no target in that place.
    pub(super) fn ring_chosen(&self, canvas: &mut Canvas) {
        let Some(chosen) = self.chosen else { return };
        let outline = self.circle(self.place(chosen.centre), chosen.radius_mm);
        if !self.is_seen(&outline) {
            return;
        }
        let line = self.line(palette::TARGET, 1.5, !outline.cut && !self.is_surface());
        if !self.is_surface() && !self.targets.iter().any(|target| self.is_chosen(target)) {
            canvas.circle(outline.at, outline.radius_px, line);
        }
        canvas.circle(outline.at, outline.radius_px + RING * self.unit(), line);
    }
}
