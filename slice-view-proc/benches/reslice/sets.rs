//! The planes that are timed.

use geometry::{Ct, Direction, Point, SlicePlane, Vector};

use crate::shared::ct::CENTRE_MM;
use crate::shared::planes::{Axes, Random, orthogonal, square};

pub(crate) const SIDE: u32 = 512;
pub(crate) const PIXEL_MM: f64 = 0.5;
/// Planes of each set, and rounds.
pub(crate) const PLANES: usize = 24;
/// How far from the middle of the volume images may be, mm: all of them lie mostly inside.
const REACH_MM: f64 = 40.0;

/// Planes of one kind.
pub(crate) struct Set {
    pub(crate) name: &'static str,
    pub(crate) planes: Vec<SlicePlane>,
    /// Each plane lies beside the one before.
    pub(crate) coherent: bool,
}

/// Axis-aligned planes, poses by chance, and a tube on its way.
pub(crate) fn all() -> Vec<Set> {
    let mut random = Random::new(3);
    let directions = [
        ("axial", [Direction::X, Direction::Y]),
        ("frontal", [Direction::X, -Direction::Z]),
        ("sagittal", [Direction::Y, -Direction::Z]),
    ];
    let mut sets: Vec<Set> = directions
        .map(|(name, axes)| Set {
            name,
            planes: of(|_| square(random.point(REACH_MM), axes, PIXEL_MM, SIDE)),
            coherent: false,
        })
        .into();
    sets.push(Set {
        name: "poses by chance",
        planes: of(|_| square(random.point(REACH_MM), random.axes(), PIXEL_MM, SIDE)),
        coherent: false,
    });
    sets.push(Set {
        name: "coherent path, caches warm",
        planes: of(|i| on_path(i as f64)),
        coherent: true,
    });
    sets
}

fn of(plane: impl FnMut(usize) -> SlicePlane) -> Vec<SlicePlane> {
    (0..PLANES).map(plane).collect()
}

/// Perpendicular to a tube that advances by 0.4 mm from image to image and sways by a few degrees.
fn on_path(step: f64) -> SlicePlane {
    let sway = 0.05 * (step * 0.3).sin();
    let along = Vector::new(-0.7, -0.5 + sway, 0.4 - sway)
        .direction()
        .expect("not zero");
    let [x, y, z] = CENTRE_MM;
    square(
        Point::new(x, y, z) + along * (0.4 * step),
        across(along),
        PIXEL_MM,
        SIDE,
    )
}

/// The image axes of a view along `into`, head up.
fn across(into: Direction<Ct>) -> Axes {
    let right = Direction::Z.cross(into).direction().expect("not along the body");
    let down = into.cross(right).direction().expect("orthogonal");
    orthogonal(right, down)
}
