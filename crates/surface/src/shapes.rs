//! Solids that are drawn beside the anatomy.

use std::f64::consts::{PI, TAU};

use geometry::{Ct, Direction, Point, Vector};

use crate::Mesh;

/// Sides of a tube, and of the equator of a ball: a polygon of 32 lies within 0.5 % of its circle.
const SIDES: u32 = 32;
/// Bands of a ball from pole to pole.
const BANDS: u32 = 12;

impl Mesh {
    /// Adds a cylinder about the line between two places, with its ends closed; nothing where they are the same.
    pub fn tube(&mut self, [from, to]: [Point<Ct>; 2], radius_mm: f64, paint: u8) {
        let Some(along) = (to - from).direction() else { return };
        let [u, v] = across(along);
        let first = self.points.len() as u32;
        for side in 0..SIDES {
            let (s, c) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            let out = u * c + v * s;
            // Each corner twice: the rim has an edge, which light must show.
            for (end, cap) in [(from, -along), (to, along)] {
                self.corner(end + out * radius_mm, out);
                self.corner(end + out * radius_mm, cap.vector());
            }
        }
        let at = |side: u32, which: u32| first + side % SIDES * 4 + which;
        for side in 0..SIDES {
            let next = side + 1;
            self.face([at(side, 0), at(next, 0), at(next, 2)], paint);
            self.face([at(side, 0), at(next, 2), at(side, 2)], paint);
            if (1..SIDES - 1).contains(&side) {
                self.face([at(0, 1), at(next, 1), at(side, 1)], paint);
                self.face([at(0, 3), at(side, 3), at(next, 3)], paint);
            }
        }
    }

    /// Adds a ball.
    pub fn ball(&mut self, centre: Point<Ct>, radius_mm: f64, paint: u8) {
        let first = self.points.len() as u32;
        for band in 0..=BANDS {
            let (ring, height) = (PI * f64::from(band) / f64::from(BANDS)).sin_cos();
            for side in 0..SIDES {
                let (s, c) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
                let out = Vector::new(ring * c, ring * s, height);
                self.corner(centre + out * radius_mm, out);
            }
        }
        let at = |band: u32, side: u32| first + band * SIDES + side % SIDES;
        for band in 0..BANDS {
            for side in 0..SIDES {
                let [a, b] = [at(band, side), at(band, side + 1)];
                let [c, d] = [at(band + 1, side), at(band + 1, side + 1)];
                self.face([a, c, d], paint);
                self.face([a, d, b], paint);
            }
        }
    }

    fn corner(&mut self, place: Point<Ct>, normal: Vector<Ct>) {
        self.points.push(place.mm().map(|mm| mm as f32));
        self.normals.push(normal.mm().map(|c| c as f32));
    }

    fn face(&mut self, corners: [u32; 3], paint: u8) {
        self.triangles.push(corners);
        self.paints.push(paint);
    }
}

/// Two directions that go with `along` to a right-handed frame, `along` the last.
fn across(along: Direction<Ct>) -> [Vector<Ct>; 2] {
    // The axis that is furthest from it, so that the product is far from zero.
    let [x, y, z] = along.components().map(f64::abs);
    let axis = match (x <= y && x <= z, y <= z) {
        (true, _) => Direction::X,
        (false, true) => Direction::Y,
        (false, false) => Direction::Z,
    };
    let u = axis.cross(along);
    let u = u.direction().map_or(u, Direction::vector);
    [u, along.vector().cross(u)]
}
