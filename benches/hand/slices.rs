//! A reader that has the local images alone: where tip, axis and the target's ring lie on them, to the pixel of the
//! screen.
//!
//! * Planes, the field and what of a target is drawn are the renderer's: a ring where the plane cuts it, dashed up to
//!   10 mm off the plane, nothing beyond; the tip in the middle with its 95 % ellipse.
//! * She looks at as few images as say all: the one that the tube lies in most, and the one across the tube once it
//!   shows the target; before, every image along the tube that shows it.
//! * The tip has arrived where, on each of these, its ellipse lies within the ring that the plane cuts: nearly the room
//!   that ON TARGET leaves, which asks for the ball of the error instead.
//! * Where none shows the target, she pushes on by the marks on the tube until it ought to come into the field, and
//!   then by steps.

use std::path::Path;

use geometry::{Affine, Ct, Direction, Point, Rigid, SlicePlane, Tool, Uncertain, VolumeGrid};
use guidance::sight::Covariance;
use hand::{Reader, Reading, Shown};
use scene::{Extent, Plane, Scene, View};
use slice_view_proc::NEAR_PLANE_MM;
use window::sizes::Sizes;

use crate::pixels::SCREEN;

/// From a deviation to the 95 % ellipse, and to the 95 % ball: the roots of chi-squared's quantiles with two and three
/// degrees of freedom.
const ELLIPSE_PER_BALL: f64 = 2.447_746_830_680_816 / 2.795_483_482_915_108;
/// An image lies along the tube where it shows this part of the unit axis.
const ALONG: f64 = 0.5;
/// She stops short of where the target ought to come into the field, mm: half the field, less this.
const INTO_FIELD_MM: f64 = 5.0;
/// A step where the target ought to be seen and is not, mm.
const STEP_MM: f64 = 10.0;

/// The local images of the thesis's seven, and who reads them.
pub struct SliceReader {
    views: Vec<View>,
    grid: VolumeGrid,
    /// Pixels of the screen for one of an image.
    scale: f64,
    /// Only a target that the plane cuts is seen.
    cut_alone: bool,
}

/// One image of what is shown.
struct Image {
    plane: SlicePlane,
    /// From the tip to the target, mm along right and up, by whole pixels of the screen.
    target_mm: [f64; 2],
    /// The unit axis along right and up.
    axis: [f64; 2],
    /// How far the target's centre is off the plane, mm.
    off_mm: f64,
}

impl SliceReader {
    /// On [`SCREEN`]; `cut_alone` where a target that the plane does not cut is not seen, though it is drawn.
    pub fn new(cut_alone: bool) -> Self {
        let scene = Scene::parse("", Path::new("")).unwrap();
        let views: Vec<View> = scene
            .views
            .into_iter()
            .filter(|view| view.extent == Extent::Local)
            .collect();
        let spaced = Affine::from_rows([
            [1.0, 0.0, 0.0, -200.0],
            [0.0, 1.0, 0.0, -200.0],
            [0.0, 0.0, 1.0, -200.0],
        ]);
        let sizes = Sizes::of(SCREEN, 7).unwrap();
        // An image has the cell below its title.
        let side = sizes.cells[0].height() - 1.2 * sizes.plain;
        Self {
            scale: f64::from(side) / f64::from(views[0].size[1]),
            views,
            grid: VolumeGrid::checked([400; 3], spaced).unwrap(),
            cut_alone,
        }
    }

    fn image(&self, picture: usize, pose: Rigid<Ct, Tool>, target: Point<Ct>) -> Image {
        let plane = slice_view_proc::plane(&self.views[picture], &self.grid, &pose).unwrap();
        let tip = plane.project(pose * Point::<Tool>::new(0.0, 0.0, 0.0));
        let at = plane.project(target);
        let pixel_mm = plane.pixel_mm() / self.scale;
        let pixels = |from: f64, to: f64| ((to * self.scale).round() - (from * self.scale).round()) * pixel_mm;
        let along = pose * Direction::<Tool>::Z;
        // The axis is drawn to the border, and its direction known by where it ends there.
        let reach = 0.5 * self.views[picture].field_mm;
        let drawn = |direction: Direction<Ct>| (along.dot(direction) * reach / pixel_mm).round() * pixel_mm / reach;
        Image {
            target_mm: [pixels(tip.x, at.x), -pixels(tip.y, at.y)],
            axis: [drawn(plane.right()), -drawn(plane.down())],
            off_mm: at.depth_mm,
            plane,
        }
    }

    /// Whether the target is drawn on the image, as far as the image reaches.
    fn is_drawn(&self, image: &Image, radius_mm: f64) -> bool {
        let half = 0.5 * image.plane.pixel_mm() * f64::from(image.plane.size()[0]);
        let reaches = image.target_mm.iter().all(|mm| mm.abs() - radius_mm <= half);
        let near_mm = if self.cut_alone { radius_mm } else { NEAR_PLANE_MM };
        image.off_mm.abs() <= near_mm && reaches
    }
}

impl Reader for SliceReader {
    fn pictures(&self, shown: &Shown) -> Vec<usize> {
        let images = (0..self.views.len()).map(|k| (k, self.image(k, shown.pose, shown.aim.target)));
        let seen: Vec<(usize, f64)> = images
            .filter(|(_, image)| self.is_drawn(image, shown.aim.radius_mm))
            .map(|(k, image)| (k, image.axis[0].hypot(image.axis[1])))
            .collect();
        let across = seen.iter().find(|(k, _)| self.views[*k].plane == Plane::Perpendicular);
        let mut along: Vec<(usize, f64)> = seen.iter().copied().filter(|(_, length)| *length >= ALONG).collect();
        along.sort_by(|a, b| b.1.total_cmp(&a.1));
        match across {
            Some((across, _)) => along.iter().take(1).map(|(k, _)| *k).chain([*across]).collect(),
            None if along.is_empty() => seen.iter().map(|(k, _)| *k).collect(),
            None => along.iter().map(|(k, _)| *k).collect(),
        }
    }

    fn axes(&self, picture: usize, pose: Rigid<Ct, Tool>) -> [Direction<Ct>; 2] {
        let plane = slice_view_proc::plane(&self.views[picture], &self.grid, &pose).unwrap();
        [plane.right(), -plane.down()]
    }

    fn read(&mut self, picture: usize, shown: &Shown) -> Option<Reading> {
        let radius_mm = shown.aim.radius_mm;
        let image = self.image(picture, shown.pose, shown.aim.target);
        if !self.is_drawn(&image, radius_mm) {
            return None;
        }
        let cut_sq = radius_mm * radius_mm - image.off_mm * image.off_mm;
        let ring_mm = if cut_sq > 0.0 { cut_sq.sqrt() } else { radius_mm };
        let room_mm = ring_mm - ellipse_mm(shown);
        let [x, y] = image.target_mm;
        Some(Reading {
            target_mm: image.target_mm,
            axis: image.axis,
            to_go_mm: None,
            room_mm,
            is_inside: cut_sq > 0.0 && x.hypot(y) <= room_mm,
        })
    }

    fn unseen_mm(&self, shown: &Shown) -> f64 {
        let tip = shown.pose * Point::<Tool>::new(0.0, 0.0, 0.0);
        let planned = shown.aim.target.distance(shown.entry);
        // Marks on the tube are read to the millimetre.
        let to_go = planned - tip.distance(shown.entry).round();
        let until_seen = to_go - (0.5 * self.views[0].field_mm - INTO_FIELD_MM);
        if until_seen > 0.0 {
            until_seen
        } else {
            STEP_MM.min(to_go)
        }
    }
}

/// The half-axis of the tip's 95 % ellipse, mm.
fn ellipse_mm(shown: &Shown) -> f64 {
    let Covariance::Upper(upper) = shown.covariance else {
        return 0.0;
    };
    let at_tip = Uncertain::from_upper(shown.pose, upper).map(|pose| pose * Point::<Tool>::new(0.0, 0.0, 0.0));
    at_tip.map_or(f64::INFINITY, |tip| tip.radius_95_mm() * ELLIPSE_PER_BALL)
}
