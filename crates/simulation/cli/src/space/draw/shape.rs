//! The shaded surfaces of organs with the tube.

use geometry::{Ct, Direction, SlicePlane, Vector};
use nalgebra::{Rotation3, Vector3};
use organs::{Labels, Model};
use picture::{Canvas, Rgb};
use surface::{Mesh, ZBuffer};

use super::frame;
use super::skin::{Skin, point};

/// Colours of organs, one after the other.
const TINTS: [[u8; 3]; 6] = [
    [214, 140, 120],
    [200, 180, 110],
    [140, 190, 140],
    [180, 150, 200],
    [130, 170, 205],
    [190, 190, 190],
];
const TUBE: [u8; 3] = [0x78, 0xb7, 0xdc];
/// How far the viewer stands aside of the tube, radians: its place of contact and the tube itself are both seen.
const ASIDE: f64 = 0.9;

/// A direction of the patient as the pictures' crates have it.
pub(super) fn direction(v: &Vector3<f64>) -> Direction<Ct> {
    // No caller has a vector without length.
    Vector::new(v.x, v.y, v.z).direction().unwrap_or(Direction::X)
}

/// The patient's head is up; the viewer looks on the side that the tube comes from.
pub(super) fn camera(skins: &[Skin], along: &Vector3<f64>, size: [u32; 2]) -> Option<SlicePlane> {
    let level = Vector3::new(along.x, along.y, 0.0);
    // A tube from above or below is seen from the front.
    let ahead = level.try_normalize(0.3).unwrap_or_else(Vector3::y);
    let into = Rotation3::from_axis_angle(&Vector3::z_axis(), ASIDE) * ahead;
    let (down, right) = (-Vector3::z(), -Vector3::z().cross(&into));
    plane(skins, [right, down], None, size)
}

/// A plane of these axes on which all organs are seen at rest; through a place, or through their middle.
pub(super) fn plane(
    skins: &[Skin],
    [right, down]: [Vector3<f64>; 2],
    through: Option<Vector3<f64>>,
    size: [u32; 2],
) -> Option<SlicePlane> {
    let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    let bounds = skins.iter().map(Skin::bounds);
    let [low, high] = bounds.fold(none, |[low, high], [a, b]| [low.inf(&a), high.sup(&b)]);
    let (mut centre, diagonal) = (0.5 * (low + high), high - low);
    if let Some(through) = through {
        let normal = right.cross(&down);
        centre += normal * (through - centre).dot(&normal);
    }
    let across = |axis: &Vector3<f64>| axis.abs().dot(&diagonal);
    let [width, height] = size.map(f64::from);
    // A margin for what bulges, and for the tube.
    let pixel = 1.25 * (across(&right) / width).max(across(&down) / height);
    SlicePlane::centred(point(&centre), [direction(&right), direction(&down)], pixel, size).ok()
}

/// Draws the organs in a state with the tube, at a corner of a canvas.
pub(super) fn draw(
    canvas: &mut Canvas,
    (labels, model): (&Labels, &Model),
    skins: &[Skin],
    camera: &SlicePlane,
    a: &[f64],
    gone: f64,
    corner: [u32; 2],
) {
    let mut buffer = ZBuffer::new(camera.size());
    for (k, skin) in skins.iter().enumerate() {
        if let Some(mesh) = skin.deformed(labels, model.system.bodies.part(k, a)) {
            buffer.draw(&mesh, camera, &[TINTS[k % TINTS.len()]]);
        }
    }
    let way = &model.way;
    let place = |back: f64| point(&labels.patient(&(way.middle(gone) - way.direction * back)));
    let mut tube = Mesh::default();
    tube.tube([place(0.0), place(way.length)], way.radius, 0);
    tube.ball(place(0.0), way.radius, 0);
    buffer.draw(&tube, camera, &[TUBE]);
    let Rgb(r, g, b) = super::cut::NOTHING;
    let rgba: Vec<u8> = buffer
        .depths()
        .iter()
        .zip(buffer.colours())
        .flat_map(|(depth, [red, green, blue])| {
            if depth.is_finite() {
                [*red, *green, *blue, 255]
            } else {
                [r, g, b, 255]
            }
        })
        .collect();
    canvas.paste(&rgba, camera.size()[0], corner[0], corner[1]);
    let small = camera.size()[0] < 400;
    frame::sides(canvas, camera, corner.map(f64::from), small);
}
