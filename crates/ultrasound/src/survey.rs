//! The body's HU over the image, coarse, and where each beam is stopped, fine.

use crate::fan::Fan;
use crate::scene::{Body, Pose, Scene, cross, dot, sub};
use crate::tissue::{COUPLED_HU, GAS_HU};

/// How far from the image's plane the outer rays run, deviations of the beam: 95 % of the sound lies between them.
pub(crate) const OUTER: f64 = 2.0;
/// The ray in the plane comes first.
const RAYS: [f64; 3] = [0.0, -OUTER, OUTER];
/// Roots are found to this, mm: a twentieth of the finest pulse would be less, a pixel is ten times more.
const ROOT_MM: f64 = 0.005;
/// How far along a beam, mm, bone beside the plane is looked for from where it is in the plane.
const NEAR_MM: f64 = 8.0;

/// What stops a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Bone,
    Gas,
}

/// Where a ray is stopped, mm as shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stop {
    pub(crate) depth: f64,
    pub(crate) kind: Kind,
}

/// A beam's way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Path {
    /// Where tissue begins, mm as shown; `None` where there is air under the face.
    pub(crate) entry: Option<f64>,
    /// In the plane and at either side of it.
    pub(crate) stops: [Option<Stop>; 3],
    /// Between the beam and the normal of what stops it.
    pub(crate) cosine: f64,
}

/// HU on nodes `step` mm apart along beams and about as far apart across them.
#[derive(Debug)]
pub(crate) struct Survey {
    columns: usize,
    rows: usize,
    step: f64,
    /// In the plane, column by column, then beside it on either side; NaN where nobody asked: below what stops sound.
    hu: [Vec<f32>; 3],
    pub(crate) paths: Vec<Path>,
    /// How often the body was asked.
    pub(crate) asked: usize,
}

/// What the survey is of.
struct Sight<'a, B> {
    scene: &'a Scene<'a, B>,
    pose: &'a Pose,
    fan: &'a Fan,
    bone_hu: f64,
    gel_mm: f64,
}

impl<B: Body> Sight<'_, B> {
    /// HU on a ray.
    fn hu(&self, beam: f64, ray: usize, shown: f64) -> f64 {
        let hu = self.scene.body.hu(self.place(beam, ray, shown));
        if hu.is_finite() { hu } else { -1000.0 }
    }

    fn place(&self, beam: f64, ray: usize, shown: f64) -> [f64; 3] {
        let (plane, _) = self.fan.at(beam, shown);
        self.pose.beside(plane, RAYS[ray] * self.fan.elevation_mm(shown))
    }
}

impl Survey {
    pub(crate) fn new(fan: &Fan, survey_mm: f64) -> Self {
        let depth = fan.shape.depth_mm();
        let wide = fan.pitch_mm(0.75 * depth) * (fan.beams - 1) as f64;
        // Tissue changes less along the skin than down into it.
        let columns = ((wide / (1.5 * survey_mm)).ceil() as usize + 1).clamp(2, fan.beams);
        let rows = (depth / survey_mm).ceil().max(4.0);
        let nodes = columns * (rows as usize + 1);
        Self {
            columns,
            rows: rows as usize + 1,
            step: depth / rows,
            hu: std::array::from_fn(|_| vec![f32::NAN; nodes]),
            paths: Vec::with_capacity(fan.beams),
            asked: 0,
        }
    }

    /// Asks the body for everything that an image needs.
    pub(crate) fn take<B: Body>(&mut self, scene: &Scene<B>, pose: &Pose, fan: &Fan, (bone_hu, gel_mm): (f64, f64)) {
        let sight = Sight {
            scene,
            pose,
            fan,
            bone_hu,
            gel_mm,
        };
        self.asked = 0;
        for side in &mut self.hu {
            side.fill(f32::NAN);
        }
        self.paths.clear();
        for beam in 0..fan.beams {
            let path = self.central(&sight, beam);
            self.paths.push(path);
        }
        self.outer(&sight);
        for beam in 0..fan.beams {
            self.walls(&sight, beam);
        }
        for beam in 0..fan.beams {
            self.paths[beam].cosine = self.cosine(&sight, beam);
        }
    }

    /// HU of the plane between the nodes; NaN where sound does not come.
    pub(crate) fn hu_at(&self, fan: &Fan, beam: f64, shown: f64) -> f32 {
        let (column, across) = self.column(fan, beam);
        let row = (shown / self.step).clamp(0.0, (self.rows - 1) as f64);
        let first = (row as usize).min(self.rows - 2);
        let along = (row - first as f64) as f32;
        let at = column * self.rows + first;
        let [a, b] = [&self.hu[0][at..at + 2], &self.hu[0][at + self.rows..at + self.rows + 2]];
        let upper = a[0] + across * (b[0] - a[0]);
        let lower = a[1] + across * (b[1] - a[1]);
        upper + along * (lower - upper)
    }

    /// The column before a beam and the share of the way to the next.
    pub(crate) fn column(&self, fan: &Fan, beam: f64) -> (usize, f32) {
        let place = beam / (fan.beams - 1) as f64 * (self.columns - 1) as f64;
        let column = (place.max(0.0) as usize).min(self.columns - 2);
        (column, (place - column as f64).clamp(0.0, 1.0) as f32)
    }

    /// How far columns are apart in the middle of the image, mm.
    pub(crate) fn column_mm(&self, fan: &Fan) -> f64 {
        fan.pitch_mm(fan.shape.depth_mm() / 2.0) * (fan.beams - 1) as f64 / (self.columns - 1) as f64
    }

    /// A row of nodes, between two columns: mm as shown apart, and HU.
    pub(crate) fn profile(&self, column: usize, across: f32, out: &mut Vec<f32>) -> f64 {
        let at = column * self.rows;
        let pairs = self.hu[0][at..at + self.rows].iter().zip(&self.hu[0][at + self.rows..]);
        out.clear();
        out.extend(pairs.map(|(a, b)| a + across * (b - a)));
        self.step
    }

    fn node<B: Body>(&mut self, sight: &Sight<B>, ray: usize, column: usize, row: usize) -> f64 {
        let at = column * self.rows + row;
        let known = self.hu[ray][at];
        if !known.is_nan() {
            return f64::from(known);
        }
        let beam = column as f64 / (self.columns - 1) as f64 * (sight.fan.beams - 1) as f64;
        self.asked += 1;
        let hu = sight.hu(beam, ray, row as f64 * self.step);
        self.hu[ray][at] = hu as f32;
        hu
    }

    fn between<B: Body>(&mut self, sight: &Sight<B>, ray: usize, beam: usize, row: usize) -> f64 {
        let (column, across) = self.column(sight.fan, beam as f64);
        let [a, b] = [0, 1].map(|next| self.node(sight, ray, column + next, row));
        a + f64::from(across) * (b - a)
    }

    fn central<B: Body>(&mut self, sight: &Sight<B>, beam: usize) -> Path {
        // The speed in gel is about that in tissue; one ratio serves both.
        let gel = (sight.gel_mm / sight.fan.ratio / self.step) as usize;
        let entry = (0..=gel.min(self.rows - 1)).find(|&row| self.between(sight, 0, beam, row) >= COUPLED_HU);
        let stop = entry.and_then(|entry| self.march(sight, 0, beam, entry..self.rows));
        Path {
            entry: entry.map(|row| row as f64 * self.step),
            stops: [stop, None, None],
            cosine: 1.0,
        }
    }

    /// The first stop among these rows.
    fn march<B: Body>(
        &mut self,
        sight: &Sight<B>,
        ray: usize,
        beam: usize,
        rows: std::ops::Range<usize>,
    ) -> Option<Stop> {
        let first = rows.start;
        let mut before = f64::NAN;
        for row in rows {
            let hu = self.between(sight, ray, beam, row);
            let depth = row as f64 * self.step;
            if hu >= sight.bone_hu {
                let kind = Kind::Bone;
                if row == first {
                    return Some(Stop { depth, kind });
                }
                if let Some(depth) = self.root(sight, ray, beam, depth) {
                    return Some(Stop { depth, kind });
                }
            }
            if hu < GAS_HU && row > first && before >= GAS_HU {
                let depth = depth - self.step * (hu - GAS_HU) / (hu - before);
                let kind = Kind::Gas;
                return Some(Stop { depth, kind });
            }
            before = hu;
        }
        None
    }

    /// Where the body's own HU climb to bone near `below`, which the nodes say is inside; `None` where they do not.
    fn root<B: Body>(&mut self, sight: &Sight<B>, ray: usize, beam: usize, below: f64) -> Option<f64> {
        let mut over = |shown: f64| {
            self.asked += 1;
            sight.hu(beam as f64, ray, shown) - sight.bone_hu
        };
        let (mut a, mut b) = ((below - self.step).max(0.0), below);
        let (mut at_a, mut at_b) = (over(a), over(b));
        // The nodes of two columns are straight between; the body may be curved.
        for _ in 0..2 {
            if at_a >= 0.0 && a > 0.0 {
                (b, at_b) = (a, at_a);
                a = (a - self.step).max(0.0);
                at_a = over(a);
            } else if at_b < 0.0 {
                (a, at_a) = (b, at_b);
                b += self.step;
                at_b = over(b);
            }
        }
        if at_a >= 0.0 || at_b < 0.0 {
            return None;
        }
        // Regula falsi of Illinois: halving the stuck end's value keeps it faster than bisection (Dowell, Jarratt 1971).
        let mut side = 0;
        for _ in 0..12 {
            let c = (a * at_b - b * at_a) / (at_b - at_a);
            if b - a < ROOT_MM {
                return Some(c);
            }
            let at_c = over(c);
            if at_c.abs() < 1.0 {
                return Some(c);
            }
            if at_c < 0.0 {
                (a, at_a) = (c, at_c);
                if side < 0 {
                    at_b *= 0.5;
                }
                side = -1;
            } else {
                (b, at_b) = (c, at_c);
                if side > 0 {
                    at_a *= 0.5;
                }
                side = 1;
            }
        }
        Some((a + b) / 2.0)
    }

    /// Bone beside the plane, near where the plane or a neighbour meets some: elsewhere its echo is weak and unasked for.
    fn outer<B: Body>(&mut self, sight: &Sight<B>) {
        let beams = self.paths.len();
        let window = beams.div_ceil(self.columns) * 2;
        for beam in 0..beams {
            if self.paths[beam].entry.is_none() {
                continue;
            }
            let own = self.paths[beam].stops[0];
            let others = self.paths[beam.saturating_sub(window)..(beam + window + 1).min(beams)].iter();
            let near = |path: &Path| path.stops[0].filter(|stop| stop.kind == Kind::Bone);
            let Some(about) = own.or_else(|| others.filter_map(near).next()) else {
                continue;
            };
            if about.kind == Kind::Gas {
                self.paths[beam].stops = [own; 3];
                continue;
            }
            let row = |depth: f64| (depth.max(0.0) / self.step) as usize;
            let rows = row(about.depth - NEAR_MM)..(row(about.depth + NEAR_MM) + 1).min(self.rows);
            for ray in 1..3 {
                self.paths[beam].stops[ray] = self.march(sight, ray, beam, rows.clone());
            }
        }
    }

    /// A wall in front of a ray's stop takes its place.
    fn walls<B: Body>(&mut self, sight: &Sight<B>, beam: usize) {
        for wall in sight.scene.walls {
            for (ray, off) in RAYS.into_iter().enumerate() {
                let mut depth = sight.fan.shape.depth_mm();
                // The ray bends with the beam's width, by little: three steps leave less than a micrometre.
                for _ in 0..3 {
                    let aside = off * sight.fan.elevation_mm(depth);
                    let (face, direction) = sight.fan.at(beam as f64, 0.0);
                    let from = sub(wall.point, sight.pose.beside(face, aside));
                    let along = dot(wall.normal, sight.pose.direction(direction)) * sight.fan.ratio;
                    depth = dot(from, wall.normal) / along;
                }
                let stops = &mut self.paths[beam].stops[ray];
                if (0.0..=sight.fan.shape.depth_mm()).contains(&depth) && stops.is_none_or(|stop| depth < stop.depth) {
                    let kind = Kind::Bone;
                    *stops = Some(Stop { depth, kind });
                }
            }
        }
    }

    /// From the places where the beam's neighbours and its outer rays meet the surface, which lie on it whatever it is.
    fn cosine<B: Body>(&self, sight: &Sight<B>, beam: usize) -> f64 {
        let place = |beam: usize, ray: usize| {
            let stop = self.paths[beam].stops[ray]?;
            Some(sight.place(beam as f64, ray, stop.depth))
        };
        let Some(own) = place(beam, 0) else { return 0.0 };
        let last = self.paths.len() - 1;
        let reach = 2;
        let [left, right] = [beam.saturating_sub(reach), (beam + reach).min(last)].map(|beam| place(beam, 0));
        let along = sub(right.unwrap_or(own), left.unwrap_or(own));
        let [near, far] = [1, 2].map(|ray| place(beam, ray).unwrap_or(own));
        let across = sub(far, near);
        let (_, direction) = sight.fan.at(beam as f64, 0.0);
        let direction = sight.pose.direction(direction);
        // Where no neighbour meets it, the surface counts as square to the image or to the beam.
        let across = match dot(across, across) > 0.0 {
            true => across,
            false => sight.pose.across(),
        };
        let normal = cross(along, across);
        let long = dot(normal, normal).sqrt();
        if long > 0.0 {
            (dot(normal, direction) / long).abs()
        } else {
            0.0
        }
    }
}
