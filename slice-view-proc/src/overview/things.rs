//! What is drawn among the anatomy for each pose: the tube and the way before its tip, targets, the way to the chosen one, the slices.

use bus::message::Chosen;
use geometry::{Ct, Point, Rigid, SlicePlane, Tool, VolumeGrid};
use picture::palette;
use scene::{Extent, Plane, Scene, View};
use surface::{Mesh, Rgb, ZBuffer};

use crate::view;

/// So far before the tip its way is drawn, mm.
const AHEAD_MM: f64 = 100.0;
/// A target is no smaller than this, pixels of 512: as on slices.
const LEAST_RADIUS: f64 = 3.0;
/// Lines and their rims, pixels of 512; lines lie this far before their rims, mm.
const LINE: f64 = 2.0;
const RIM: f64 = 1.0;
const BEFORE_RIM_MM: f64 = 0.05;
/// The paints of solids.
const SOLIDS: [Rgb; 2] = [rgb(palette::TUBE), rgb(palette::TARGET)];
const TUBE: u8 = 0;
const TARGET: u8 = 1;

/// What there is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Things<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) grid: &'a VolumeGrid,
    /// `None` while there is none: neither tube nor slices are drawn then.
    pub(crate) pose: Option<Rigid<Ct, Tool>>,
    pub(crate) chosen: Option<&'a Chosen>,
}

const fn rgb(colour: picture::Rgb) -> Rgb {
    [colour.0, colour.1, colour.2]
}

impl Things<'_> {
    pub(crate) fn draw(&self, camera: &SlicePlane, solids: &mut Mesh, onto: &mut ZBuffer) {
        let shorter = camera.size()[0].min(camera.size()[1]);
        let unit = (f64::from(shorter) / 512.0).clamp(0.4, 3.0);
        let line = |onto: &mut ZBuffer, ends, colour| {
            onto.line(camera, ends, (LINE + 2.0 * RIM) * unit, 0.0, rgb(palette::RIM));
            onto.line(camera, ends, LINE * unit, BEFORE_RIM_MM, rgb(colour));
        };
        solids.clear();
        let least_mm = LEAST_RADIUS * unit * camera.pixel_mm();
        for target in &self.scene.targets {
            solids.ball(target.centre, (target.diameter_mm / 2.0).max(least_mm), TARGET);
        }
        if let Some(chosen) = self.chosen {
            solids.ball(chosen.centre, chosen.radius_mm.max(least_mm), TARGET);
            if let Some(entry) = chosen.entry {
                line(onto, [entry, chosen.centre], palette::TARGET);
            }
        }
        if let Some(pose) = self.pose {
            let along = |mm: f64| pose * Point::<Tool>::new(0.0, 0.0, mm);
            let tool = &self.scene.tool;
            solids.tube([along(-tool.length_mm), along(0.0)], tool.diameter_mm / 2.0, TUBE);
            line(onto, [along(0.0), along(AHEAD_MM)], palette::TIP);
            for corners in self.slices(&pose) {
                for (from, to) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
                    onto.line(camera, [corners[from], corners[to]], unit, 0.0, rgb(palette::QUIET));
                }
            }
        }
        onto.draw(solids, camera, &SOLIDS);
    }

    /// The corners of the images of slices, one of each direction: a local one where there is one, which shows where it is.
    fn slices(&self, pose: &Rigid<Ct, Tool>) -> impl Iterator<Item = [Point<Ct>; 4]> {
        let of = |plane: Plane| self.scene.views.iter().filter(move |view| view.plane == plane);
        let is_local = |view: &&View| view.extent == Extent::Local;
        let planes = [Plane::Axial, Plane::Frontal, Plane::Sagittal, Plane::Perpendicular];
        let views = planes
            .into_iter()
            .filter_map(move |plane| of(plane).find(is_local).or_else(|| of(plane).next()));
        views.filter_map(|view| {
            let plane = view::plane(view, self.grid, pose).ok()?;
            let [right, down] = plane.size().map(|n| f64::from(n) - 0.5);
            Some([(-0.5, -0.5), (right, -0.5), (right, down), (-0.5, down)].map(|(x, y)| plane.point(x, y)))
        })
    }
}
