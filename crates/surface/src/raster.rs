//! A z-buffer: triangles seen by parallel projection, the nearest one in each pixel.
//!
//! Corners are put to 1/256 of a pixel, and what a pixel's centre lies in is told in whole numbers, with the rule of top and left edges: a
//! surface has neither cracks nor pixels that two of its triangles fight for. Depth is weighed between the corners of a triangle, so that it
//! never leaves their range; of two at the same depth the first one stays.

use geometry::{Ct, Point, SlicePlane};

use crate::Mesh;

/// A colour.
pub type Rgb = [u8; 3];

/// Parts of a pixel that corners are put to.
const PARTS: f32 = 256.0;
/// Triangles with a corner further from the first pixel are left out, pixels: products of differences stay within 64 bits.
const FAR: f32 = 1e6;
/// What a face in the grazing light keeps of its brightness.
const LEAST_LIGHT: f32 = 0.2;

/// The nearest surface in each pixel of an image.
#[derive(Debug, Clone)]
pub struct ZBuffer {
    width: usize,
    height: usize,
    /// Behind the plane of the image, mm; infinite where nothing is.
    depths: Vec<f32>,
    colours: Vec<Rgb>,
    /// The corners of the mesh that is drawn.
    corners: Vec<Corner>,
}

/// A corner as it is seen.
#[derive(Debug, Clone, Copy, Default)]
struct Corner {
    /// In parts of a pixel, from the first pixel's centre; `None` where that is too far.
    at: Option<[i32; 2]>,
    depth: f32,
    /// 0 to 1.
    light: f32,
}

impl ZBuffer {
    /// Nothing, in so many columns and rows.
    pub fn new([width, height]: [u32; 2]) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width: width as usize,
            height: height as usize,
            depths: vec![f32::INFINITY; pixels],
            colours: vec![[0; 3]; pixels],
            corners: Vec::new(),
        }
    }

    /// Takes everything away.
    pub fn clear(&mut self) {
        self.depths.fill(f32::INFINITY);
    }

    /// Of each pixel, row by row: how far behind the image's plane the nearest surface is, mm; infinite where there is none.
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// And its colour, which means nothing where there is none.
    pub fn colours(&self) -> &[Rgb] {
        &self.colours
    }

    /// Draws the faces that look at the viewer. A triangle whose paint is not in `paints`, and one beyond a million pixels, is left out.
    pub fn draw(&mut self, mesh: &Mesh, camera: &SlicePlane, paints: &[Rgb]) {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        let seen = Seen::of(camera);
        corners.extend(mesh.points.iter().zip(&mesh.normals).map(|(p, n)| seen.corner(*p, *n)));
        for (triangle, paint) in mesh.triangles.iter().zip(&mesh.paints) {
            if let Some(paint) = paints.get(usize::from(*paint)) {
                let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
                self.triangle([a, b, c], *paint);
            }
        }
        self.corners = corners;
    }

    /// A straight line, `width` pixels wide, in one colour, `nearer_mm` before its place.
    pub fn line(&mut self, camera: &SlicePlane, [from, to]: [Point<Ct>; 2], width: f64, nearer_mm: f64, colour: Rgb) {
        let [a, b] = [from, to].map(|p| camera.project(p));
        let along = [b.x - a.x, b.y - a.y];
        let length = along[0].hypot(along[1]);
        let half = width / 2.0;
        // Seen along itself it is a dot, at its nearer end. Elsewhere its ends are cut straight: what went beyond them would have no depth of its
        // own, and a rim would come before the line that it goes with.
        let ([ux, uy], forth, depths) = match length < 1.0 {
            true => ([1.0, 0.0], half, [a.depth_mm.min(b.depth_mm); 2]),
            false => (along.map(|c| c / length), 0.0, [a.depth_mm, b.depth_mm]),
        };
        let corner = |end: usize, sense: f64, aside: f64| {
            let (at, depth) = ([[a.x, a.y], [b.x, b.y]][end], depths[end]);
            let at = [
                at[0] + sense * forth * ux - aside * half * uy,
                at[1] + sense * forth * uy + aside * half * ux,
            ];
            Corner {
                at: parts(at.map(|c| c as f32)),
                depth: (depth - nearer_mm) as f32,
                light: 1.0,
            }
        };
        let [a0, a1, b0, b1] = [
            corner(0, -1.0, -1.0),
            corner(0, -1.0, 1.0),
            corner(1, 1.0, -1.0),
            corner(1, 1.0, 1.0),
        ];
        // Turned to the viewer.
        self.triangle([a0, a1, b1], colour);
        self.triangle([a0, b1, b0], colour);
    }

    fn triangle(&mut self, [a, c, b]: [Corner; 3], paint: Rgb) {
        // Anticlockwise to the viewer; taken the other way round, as rows go down.
        let (Some(pa), Some(pb), Some(pc)) = (a.at, b.at, c.at) else {
            return;
        };
        let [pa, pb, pc] = [pa, pb, pc].map(|p| p.map(i64::from));
        let area = edge(pa, pb, pc);
        if area <= 0 {
            return;
        }
        let Some([columns, rows]) = self.pixels_of([pa, pb, pc]) else {
            return;
        };
        let (ab, bc, ca) = (Side::new(pa, pb), Side::new(pb, pc), Side::new(pc, pa));
        let first = [columns[0], rows[0]].map(|pixel| pixel as i64 * PARTS as i64);
        let mut starts = [bc.at(first), ca.at(first), ab.at(first)];
        let scale = 1.0 / area as f32;
        for y in rows[0]..rows[1] {
            let mut weights = starts;
            for x in columns[0]..columns[1] {
                if (weights[0] + bc.rule) | (weights[1] + ca.rule) | (weights[2] + ab.rule) >= 0 {
                    let [wa, wb, wc] = weights.map(|weight| weight as f32 * scale);
                    let depth = wa * a.depth + wb * b.depth + wc * c.depth;
                    let pixel = y * self.width + x;
                    if depth < self.depths[pixel] {
                        self.depths[pixel] = depth;
                        let light = ((wa * a.light + wb * b.light + wc * c.light) * 256.0) as u32;
                        self.colours[pixel] = paint.map(|channel| ((u32::from(channel) * light.min(256)) >> 8) as u8);
                    }
                }
                weights = [weights[0] + bc.right, weights[1] + ca.right, weights[2] + ab.right];
            }
            starts = [starts[0] + bc.down, starts[1] + ca.down, starts[2] + ab.down];
        }
    }

    /// The columns and rows, from the first to the one behind the last, whose centres a triangle may hold; `None`: none.
    fn pixels_of(&self, corners: [[i64; 2]; 3]) -> Option<[[usize; 2]; 2]> {
        let range = |axis: usize, count: usize| {
            let values = corners.map(|corner| corner[axis]);
            let [low, high] = [values.iter().min()?, values.iter().max()?];
            let parts = PARTS as i64;
            let from = (low + parts - 1).div_euclid(parts).max(0);
            let to = (high.div_euclid(parts) + 1).min(count as i64);
            (from < to).then_some([from as usize, to as usize])
        };
        Some([range(0, self.width)?, range(1, self.height)?])
    }
}

/// From the patient to pixels, in single precision: there are many corners.
struct Seen {
    /// For each of column, row and depth: what is added, and what each coordinate counts.
    rows: [[f32; 4]; 3],
    into: [f32; 3],
}

impl Seen {
    fn of(camera: &SlicePlane) -> Self {
        let row = |direction: geometry::Direction<Ct>, scale: f64| {
            let [x, y, z] = direction.components().map(|c| (c * scale) as f32);
            let offset = (Point::new(0.0, 0.0, 0.0) - camera.origin()).dot(direction.vector()) * scale;
            [offset as f32, x, y, z]
        };
        let pixels = 1.0 / camera.pixel_mm();
        Self {
            rows: [
                row(camera.right(), pixels),
                row(camera.down(), pixels),
                row(camera.into_screen(), 1.0),
            ],
            into: camera.into_screen().components().map(|c| c as f32),
        }
    }

    fn corner(&self, p: [f32; 3], normal: [f32; 3]) -> Corner {
        let [x, y, depth] = self.rows.map(|[o, a, b, c]| o + a * p[0] + b * p[1] + c * p[2]);
        let facing = -(normal[0] * self.into[0] + normal[1] * self.into[1] + normal[2] * self.into[2]);
        Corner {
            at: parts([x, y]),
            depth,
            light: LEAST_LIGHT + (1.0 - LEAST_LIGHT) * facing.clamp(0.0, 1.0),
        }
    }
}

/// A place in parts of a pixel.
fn parts(at: [f32; 2]) -> Option<[i32; 2]> {
    // A comparison with NaN is false: that is no place either.
    let is_near = at.iter().all(|c| c.abs() <= FAR);
    is_near.then(|| at.map(|c| (c * PARTS).round() as i32))
}

/// Twice the area of a triangle; positive where its corners go clockwise on the screen.
fn edge(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// A side of a triangle, and on which side of it a place lies: inside where that is 0 or more, by the rule of top and left.
struct Side {
    a: [i64; 2],
    b: [i64; 2],
    /// What one pixel to the right, and one down, change.
    right: i64,
    down: i64,
    /// 0 on top and left sides, which hold the places on themselves; else -1.
    rule: i64,
}

impl Side {
    fn new(a: [i64; 2], b: [i64; 2]) -> Self {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        Self {
            a,
            b,
            right: -dy * PARTS as i64,
            down: dx * PARTS as i64,
            rule: if dy < 0 || (dy == 0 && dx > 0) { 0 } else { -1 },
        }
    }

    fn at(&self, p: [i64; 2]) -> i64 {
        edge(self.a, self.b, p)
    }
}
