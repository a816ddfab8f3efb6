//! A plane through deformed organs: what is in each of its pixels.

use geometry::{Ct, Point, SlicePlane};
use nalgebra::Vector3;
use organs::{Labels, Model, Plan};
use picture::Rgb;
use simulation::space::cells::Field;
use simulation::space::tube::Tube;

use super::lattice::{Lattice, Moved, TETRAHEDRA, corners};
use crate::draw::colour::Ramp;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pixel {
    /// An organ, with what is shown there.
    Organ(f64),
    /// Two organs at one place, which pass through one another; or an organ and the tube, where forces do not balance.
    Overlap,
    Tube,
    /// What the scene names rigid.
    Rigid,
    /// A label that the scene does not name.
    Other,
    /// An organ was here at rest.
    Left,
    Nothing,
}

/// The pixels of a plane, row by row, and whether an organ lies there at rest.
#[derive(Debug, Clone)]
pub(super) struct Cut {
    pub(super) size: [usize; 2],
    pub(super) pixels: Vec<Pixel>,
    pub(super) at_rest: Vec<bool>,
}

/// A corner of a piece of a plane: where on it, the organ's field and what is shown.
type Corner = ([f64; 2], f64, f64);

/// Tissue so deep in the tube is shown as that, mm: places between those of a lattice are known to less.
const SEEN: f64 = 0.5;

/// Colours of what has no field.
pub(super) const RIGID: Rgb = Rgb(150, 150, 140);
pub(super) const OTHER: Rgb = Rgb(62, 62, 66);
pub(super) const NOTHING: Rgb = Rgb(24, 24, 28);
pub(super) const LEFT: [Rgb; 2] = [Rgb(96, 70, 60), NOTHING];
pub(super) const OVERLAP: Rgb = Rgb(255, 0, 60);
pub(super) const TUBE: Rgb = picture::palette::TUBE;
pub(super) const AT_REST: Rgb = Rgb(255, 255, 255);

impl Cut {
    /// The plane through organs in a state. `moved` is of each lattice, `tube` and the model's places in the label map's axes.
    pub(super) fn new(
        plane: &SlicePlane,
        (plan, labels, model): (&Plan, &Labels, &Model),
        organs: &[(&Lattice, &Moved)],
        tube: &Tube,
    ) -> Self {
        let size = plane.size().map(|n| n as usize);
        let count = size[0] * size[1];
        let mut cut = Self {
            size,
            pixels: vec![Pixel::Nothing; count],
            at_rest: vec![false; count],
        };
        for (lattice, moved) in organs {
            let mut mine = vec![None; count];
            slice(plane, labels, lattice, moved, &mut |corners| {
                fill(size, corners, &mut mine)
            });
            for (pixel, found) in cut.pixels.iter_mut().zip(mine) {
                *pixel = match (found, *pixel) {
                    (None, before) => before,
                    (Some(_), Pixel::Organ(_) | Pixel::Overlap) => Pixel::Overlap,
                    (Some(shown), _) => Pixel::Organ(shown),
                };
            }
        }
        for n in 0..count {
            let at = plane.point((n % size[0]) as f64, (n / size[0]) as f64).mm();
            let own = labels.own(&Vector3::from(at));
            let from_tube = tube.signed_distance(&own).value;
            cut.at_rest[n] = model.bodies.iter().any(|b| b.field.value(&own) < 0.0);
            cut.pixels[n] = match cut.pixels[n] {
                Pixel::Nothing if from_tube < 0.0 => Pixel::Tube,
                Pixel::Organ(_) if from_tube < -SEEN.min(0.2 * plan.way.radius) => Pixel::Overlap,
                Pixel::Nothing if cut.at_rest[n] => Pixel::Left,
                Pixel::Nothing => background(plan, labels.at(&own)),
                organ => organ,
            };
        }
        cut
    }

    /// The picture: RGBA.
    pub(super) fn painted(&self, ramp: &Ramp) -> Vec<u8> {
        let [width, height] = self.size;
        let mut rgba = Vec::with_capacity(4 * self.pixels.len());
        for (n, pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (n % width, n / width);
            // A border of what was there at rest: where a pixel to the right or below is not alike.
            let differs = |m: usize| self.at_rest[n] != self.at_rest[m];
            let edge = (x + 1 < width && differs(n + 1)) || (y + 1 < height && differs(n + width));
            let Rgb(r, g, b) = match pixel {
                _ if edge => AT_REST,
                Pixel::Organ(shown) => ramp.colour(*shown),
                Pixel::Overlap => OVERLAP,
                Pixel::Tube => TUBE,
                Pixel::Rigid => RIGID,
                Pixel::Other => OTHER,
                Pixel::Left => LEFT[usize::from((x + y) % 8 > 3)],
                Pixel::Nothing => NOTHING,
            };
            rgba.extend([r, g, b, 255]);
        }
        rgba
    }
}

fn background(plan: &Plan, label: u16) -> Pixel {
    match label {
        // What has an organ's label and is not within its smooth surface is its voxels' edge.
        0 => Pixel::Nothing,
        label if plan.organs.iter().any(|o| o.label == label) => Pixel::Nothing,
        label if plan.rigid.iter().any(|r| r.labels.contains(&label)) => Pixel::Rigid,
        _ => Pixel::Other,
    }
}

/// Calls `each` with the triangles in which a plane cuts the tetrahedra of a lattice.
fn slice(plane: &SlicePlane, labels: &Labels, lattice: &Lattice, moved: &Moved, each: &mut dyn FnMut([Corner; 3])) {
    let samples = &lattice.samples;
    let seen = |n: usize| {
        let at = labels.patient(&(samples.place(n) + moved.by[n]));
        let on = plane.project(Point::<Ct>::new(at.x, at.y, at.z));
        (([on.x, on.y], lattice.values[n], moved.shown[n]), on.depth_mm)
    };
    for first in &lattice.cells {
        let corners = corners(samples, *first).map(seen);
        let above = corners.iter().filter(|c| c.1 >= 0.0).count();
        if above == 0 || above == 8 {
            continue;
        }
        for tetrahedron in TETRAHEDRA {
            piece(&tetrahedron.map(|k| corners[k]), each);
        }
    }
}

/// The one or two triangles in which a plane cuts a tetrahedron.
fn piece(corners: &[(Corner, f64); 4], each: &mut dyn FnMut([Corner; 3])) {
    let (above, below): (Vec<_>, Vec<_>) = corners.iter().partition(|c| c.1 >= 0.0);
    let between = |p: &(Corner, f64), q: &(Corner, f64)| -> Corner {
        let t = p.1 / (p.1 - q.1);
        let mix = |a: f64, b: f64| a + (b - a) * t;
        let ((x, a, s), (y, b, r)) = (p.0, q.0);
        ([mix(x[0], y[0]), mix(x[1], y[1])], mix(a, b), mix(s, r))
    };
    match (above.as_slice(), below.as_slice()) {
        ([one], three @ [_, _, _]) | (three @ [_, _, _], [one]) => {
            each([
                between(one, &three[0]),
                between(one, &three[1]),
                between(one, &three[2]),
            ]);
        }
        ([a, b], [c, d]) => {
            let (ac, ad, bc, bd) = (between(a, c), between(a, d), between(b, c), between(b, d));
            each([ac, ad, bd]);
            each([ac, bd, bc]);
        }
        _ => {}
    }
}

/// Writes what is shown into the pixels of a triangle that lie within the organ.
fn fill(size: [usize; 2], corners: [Corner; 3], pixels: &mut [Option<f64>]) {
    let [(p, ..), (q, ..), (r, ..)] = corners;
    let cross = |o: [f64; 2], u: [f64; 2], v: [f64; 2]| (u[0] - o[0]) * (v[1] - o[1]) - (u[1] - o[1]) * (v[0] - o[0]);
    let area = cross(p, q, r);
    if !area.is_finite() || area == 0.0 {
        return;
    }
    let range = |axis: usize| {
        let (low, high) = (p[axis].min(q[axis]).min(r[axis]), p[axis].max(q[axis]).max(r[axis]));
        let last = size[axis] as f64 - 1.0;
        (low.max(0.0).ceil() as usize, high.min(last).floor())
    };
    let ((left, right), (top, bottom)) = (range(0), range(1));
    for y in top..(bottom + 1.0).max(0.0) as usize {
        for x in left..(right + 1.0).max(0.0) as usize {
            let at = [x as f64, y as f64];
            let (wp, wq) = (cross(q, r, at) / area, cross(r, p, at) / area);
            let weights = [wp, wq, 1.0 - wp - wq];
            // A hair beyond the edge, so that neighbours leave no gap.
            let mixed = |of: fn(&Corner) -> f64| weights.iter().zip(&corners).map(|(w, c)| w * of(c)).sum::<f64>();
            if weights.iter().all(|w| *w >= -1e-6) && mixed(|c| c.1) < 0.0 {
                pixels[y * size[0] + x] = Some(mixed(|c| c.2));
            }
        }
    }
}
