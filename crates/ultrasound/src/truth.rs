//! Where things truly lie in an image: for judging who reads it.
//!
//! Nothing here is shared with the making of the image but the scene and the shape: each beam's middle is followed
//! through the body in small steps, and what is met is found by bisection.

use crate::scene::{Body, Pose, Scene, SceneError, dot, sub};
use crate::shape::Shape;

/// Step along a beam, mm: what is thinner may be missed.
const STEP_MM: f64 = 0.1;
/// Bisections of a step: to a ten-millionth of a mm.
const HALVINGS: usize = 20;
/// Reach of the differences that give the surface's normal, mm.
const REACH_MM: f64 = 0.05;
/// Below this there is no way for sound.
const GAS_HU: f64 = -400.0;

/// What a beam's middle meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Met {
    /// Nothing that stops it.
    Nothing,
    /// Air under the face, thicker than `gel_mm`: the beam shows nothing.
    Air,
    /// Gas, at this true depth in mm.
    Gas(f64),
    /// Bone, or a wall.
    Bone(Crossing),
}

/// Where a beam's middle meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// In the patient's frame, mm.
    pub place_mm: [f64; 3],
    /// The way from the face, mm.
    pub depth_mm: f64,
    /// The depth at which the image shows it, mm: the true one over the speed's ratio.
    pub shown_mm: f64,
    /// The pixel, with its fraction, at which the image shows it.
    pub pixel: [f64; 2],
    /// Between the beam and the surface's normal, rad, 0 to a quarter turn; NaN where the HU do not change.
    pub incidence: f64,
}

/// Where a wire crosses the image's plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WireCrossing {
    /// The wire's number in the scene.
    pub wire: usize,
    /// In the patient's frame, mm.
    pub place_mm: [f64; 3],
    /// The pixel, with its fraction, at which the image shows it.
    pub pixel: [f64; 2],
    /// Between the wire and the plane, rad: a quarter turn where it is square to it.
    pub steep: f64,
}

/// The truth of one image.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// By beam, evenly from the leftmost to the rightmost.
    pub beams: Vec<Met>,
    /// The wires that cross within the image, and are not behind bone or a wall.
    pub wires: Vec<WireCrossing>,
}

/// What counts in the search for the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// From this HU on it is bone.
    pub bone_hu: f64,
    /// True speed of sound over the assumed one.
    pub speed_ratio: f64,
    /// Air under the face up to this thickness counts as gel, mm.
    pub gel_mm: f64,
}

/// Finds the truth of `beams` beams; at least 2.
///
/// # Errors
/// [`SceneError`]: a wire or a wall that cannot be.
pub fn truth<B: Body>(
    scene: &Scene<B>,
    pose: &Pose,
    shape: &Shape,
    level: &Level,
    beams: usize,
) -> Result<Truth, SceneError> {
    scene.check()?;
    let search = Search {
        scene,
        pose,
        shape,
        level,
    };
    let beams = beams.max(2);
    let shares = (0..beams).map(|beam| beam as f64 / (beams - 1) as f64);
    let wires = scene.wires.iter().enumerate();
    Ok(Truth {
        beams: shares.map(|share| search.beam(share)).collect(),
        wires: wires.filter_map(|(number, _)| search.wire(number)).collect(),
    })
}

struct Search<'a, B> {
    scene: &'a Scene<'a, B>,
    pose: &'a Pose,
    shape: &'a Shape,
    level: &'a Level,
}

impl<B: Body> Search<'_, B> {
    fn hu(&self, place: [f64; 3]) -> f64 {
        let hu = self.scene.body.hu(place);
        if hu.is_finite() { hu } else { -1000.0 }
    }

    fn beam(&self, share: f64) -> Met {
        let place = |depth: f64| self.pose.place(self.shape.along(share, depth).0);
        let direction = self.pose.direction(self.shape.along(share, 0.0).1);
        let deepest = self.shape.depth_mm() * self.level.speed_ratio;
        let hu = |depth: f64| self.hu(place(depth));
        let wall = self.wall(place(0.0), direction, deepest);
        let steps = (deepest / STEP_MM).ceil() as usize;
        let depth = |step: usize| (step as f64 * STEP_MM).min(deepest);
        let gel = (0..=steps).take_while(|&step| depth(step) <= self.level.gel_mm.max(0.0));
        let Some(first) = gel.into_iter().find(|&step| hu(depth(step)) >= -500.0) else {
            return Met::Air;
        };
        let mut met = None;
        for step in first..=steps {
            let here = hu(depth(step));
            if here >= self.level.bone_hu {
                let before = if step == first { depth(step) } else { depth(step - 1) };
                let found = bisect(before, depth(step), |depth| hu(depth) >= self.level.bone_hu);
                met = Some(Met::Bone(self.crossing(share, found, self.normal(place(found)))));
                break;
            }
            if step > first && here < GAS_HU && hu(depth(step - 1)) >= GAS_HU {
                met = Some(Met::Gas(bisect(depth(step - 1), depth(step), |depth| {
                    hu(depth) < GAS_HU
                })));
                break;
            }
        }
        let far = match met {
            Some(Met::Bone(crossing)) => crossing.depth_mm,
            Some(Met::Gas(depth)) => depth,
            _ => f64::INFINITY,
        };
        match wall {
            Some((depth, normal)) if depth < far => Met::Bone(self.crossing(share, depth, normal)),
            _ => met.unwrap_or(Met::Nothing),
        }
    }

    fn crossing(&self, share: f64, depth_mm: f64, normal: [f64; 3]) -> Crossing {
        let (plane, direction) = self.shape.along(share, depth_mm);
        let shown_mm = depth_mm / self.level.speed_ratio;
        let cosine = dot(normal, self.pose.direction(direction)).abs() / dot(normal, normal).sqrt();
        Crossing {
            place_mm: self.pose.place(plane),
            depth_mm,
            shown_mm,
            pixel: self.shape.pixel_at(self.shape.along(share, shown_mm).0),
            incidence: cosine.clamp(0.0, 1.0).acos(),
        }
    }

    /// The gradient of HU, of any length.
    fn normal(&self, place: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let [up, down] = [1.0, -1.0].map(|side| {
                let mut beside = place;
                beside[axis] += side * REACH_MM;
                self.hu(beside)
            });
            up - down
        })
    }

    /// The nearest wall ahead.
    fn wall(&self, from: [f64; 3], direction: [f64; 3], deepest: f64) -> Option<(f64, [f64; 3])> {
        let walls = self.scene.walls.iter().map(|wall| {
            let depth = dot(sub(wall.point, from), wall.normal) / dot(direction, wall.normal);
            (depth, wall.normal)
        });
        walls
            .filter(|(depth, _)| (0.0..=deepest).contains(depth))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn wire(&self, wire: usize) -> Option<WireCrossing> {
        let [from, to] = self.scene.wires[wire].ends;
        let ([ax, ay, a], [bx, by, b]) = (self.pose.inside(from), self.pose.inside(to));
        // Both ends on one side, or in the plane: no single crossing.
        if (a > 0.0) == (b > 0.0) || a == b {
            return None;
        }
        let share = a / (a - b);
        let plane = [ax + share * (bx - ax), ay + share * (by - ay)];
        let beam = self.shape.beam_at(plane).or_else(|| self.deeper(plane))?;
        let hidden = match self.beam(beam.share) {
            Met::Nothing => false,
            Met::Air => true,
            Met::Gas(depth) => depth < beam.depth_mm,
            Met::Bone(crossing) => crossing.depth_mm < beam.depth_mm,
        };
        let shown_mm = beam.depth_mm / self.level.speed_ratio;
        if hidden || shown_mm > self.shape.depth_mm() {
            return None;
        }
        let way = sub(to, from);
        Some(WireCrossing {
            wire,
            place_mm: self.pose.place(plane),
            pixel: self.shape.pixel_at(self.shape.along(beam.share, shown_mm).0),
            steep: ((b - a).abs() / dot(way, way).sqrt()).min(1.0).asin(),
        })
    }

    /// A beam of the same probe that is followed deeper, for what a fast medium shows nearer than it is.
    fn deeper(&self, plane: [f64; 2]) -> Option<crate::shape::Beam> {
        let size = [self.shape.columns(), self.shape.rows()];
        let far = (self.shape.depth_mm() * self.level.speed_ratio).min(400.0);
        let longer = Shape::new(size, self.shape.pixel_mm(), self.shape.beams(), far).ok()?;
        longer.beam_at(plane)
    }
}

/// The end of `a..b` nearest to which `met` begins to hold: it holds at `b`.
fn bisect(mut a: f64, mut b: f64, met: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (a + b);
        match met(middle) {
            true => b = middle,
            false => a = middle,
        }
    }
    b
}
