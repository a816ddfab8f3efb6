//! What is imaged, and where the image's plane lies in it.

/// Whatever can be imaged: a CT, the generated patient, a phantom.
///
/// Any `Fn([f64; 3]) -> f64` is one. What is asked for is not kept: the same place must always give the same value.
pub trait Body {
    /// The Hounsfield unit at a place of the patient, mm; what is not finite counts as air.
    fn hu(&self, place_mm: [f64; 3]) -> f64;
}

impl<F: Fn([f64; 3]) -> f64> Body for F {
    fn hu(&self, place_mm: [f64; 3]) -> f64 {
        self(place_mm)
    }
}

/// A thin wire, a line from one end to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wire {
    /// Its ends in the patient's frame, mm.
    pub ends: [[f64; 3]; 2],
}

/// A flat wall that lets no sound through: the bottom of a tank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// A place on it in the patient's frame, mm.
    pub point: [f64; 3],
    /// A direction square to it, of any length but 0.
    pub normal: [f64; 3],
}

/// What an image is made of.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a, B> {
    /// The tissue; [`water`] for a tank.
    pub body: &'a B,
    /// Wires in it. They neither shadow nor hide one another.
    pub wires: &'a [Wire],
    /// Walls in it.
    pub walls: &'a [Wall],
}

impl<'a, B: Body> Scene<'a, B> {
    /// A body and nothing else.
    pub fn of(body: &'a B) -> Self {
        let (wires, walls) = (&[], &[]);
        Self { body, wires, walls }
    }
}

/// A tank of water, everywhere.
#[must_use]
pub fn water(_: [f64; 3]) -> f64 {
    0.0
}

/// Where the image's plane lies in the patient's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    origin_mm: [f64; 3],
    u: [f64; 3],
    v: [f64; 3],
    across: [f64; 3],
}

/// Why an image cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The pose's origin is not finite or far from every patient.
    #[error("the origin of the image's plane is {0:?} mm; allowed are -100000 to 100000 mm")]
    Origin([f64; 3]),
    /// Axes that are no unit vectors square to each other.
    #[error(
        "the axes {u:?} and {v:?} of the image's plane are not unit vectors square to each other \
         within 0.000001 (lengths and cosine differ by {by:.2e})"
    )]
    Axes {
        /// Along a row.
        u: [f64; 3],
        /// Along a column.
        v: [f64; 3],
        /// The largest difference.
        by: f64,
    },
    /// A wire that is not finite, or none.
    #[error("wire {number} from {:?} to {:?} mm; allowed are lengths of 0.1 to 10000 mm", .ends[0], .ends[1])]
    Wire {
        /// Its number, from 0.
        number: usize,
        /// Its ends.
        ends: [[f64; 3]; 2],
    },
    /// A wall without a direction or a place.
    #[error("wall {number} at {point:?} mm has the direction {normal:?}; both must be finite, and its length above 0")]
    Wall {
        /// Its number, from 0.
        number: usize,
        /// As given.
        point: [f64; 3],
        /// As given.
        normal: [f64; 3],
    },
    /// More wires or walls than a phantom has.
    #[error("{found} {what}; allowed are 0 to {most}")]
    Count {
        /// Wires or walls.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there may be.
        most: usize,
    },
}

/// Poses come from rotations whose rounding is 1e-15 and from files with 6 decimals.
const SQUARE: f64 = 1e-6;
const FAR_MM: f64 = 1e5;

impl Pose {
    /// The plane in which pixel (0, 0) lies at `origin_mm`, with the directions in which u and v grow.
    ///
    /// # Errors
    /// [`SceneError::Origin`], [`SceneError::Axes`].
    pub fn new(origin_mm: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Result<Self, SceneError> {
        if !near(origin_mm) {
            return Err(SceneError::Origin(origin_mm));
        }
        let off = [dot(u, u).sqrt() - 1.0, dot(v, v).sqrt() - 1.0, dot(u, v)];
        // `max` would swallow a NaN.
        let by = off.into_iter().map(f64::abs).fold(
            0.0,
            |most, value| {
                if value > most || value.is_nan() { value } else { most }
            },
        );
        match by <= SQUARE {
            true => Ok(Self {
                origin_mm,
                u,
                v,
                across: cross(u, v),
            }),
            false => Err(SceneError::Axes { u, v, by }),
        }
    }

    /// The place in the patient's frame of a place in the image's plane, mm.
    #[must_use]
    pub fn place(&self, plane_mm: [f64; 2]) -> [f64; 3] {
        self.beside(plane_mm, 0.0)
    }

    /// The direction square to the image, u x v: the elevation.
    #[must_use]
    pub fn across(&self) -> [f64; 3] {
        self.across
    }

    /// A direction of the image's plane in the patient's frame.
    #[must_use]
    pub fn direction(&self, in_plane: [f64; 2]) -> [f64; 3] {
        std::array::from_fn(|i| in_plane[0] * self.u[i] + in_plane[1] * self.v[i])
    }

    /// As [`Pose::place`], `elevation_mm` beside the plane.
    pub(crate) fn beside(&self, [x, y]: [f64; 2], elevation_mm: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.origin_mm[i] + x * self.u[i] + y * self.v[i] + elevation_mm * self.across[i])
    }

    /// Along u, v and across: the opposite of [`Pose::beside`].
    pub(crate) fn inside(&self, place: [f64; 3]) -> [f64; 3] {
        let from = sub(place, self.origin_mm);
        [dot(from, self.u), dot(from, self.v), dot(from, self.across)]
    }
}

impl<B> Scene<'_, B> {
    /// Checks what came from outside.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        for (what, found, most) in [("wires", self.wires.len(), 1000), ("walls", self.walls.len(), 20)] {
            if found > most {
                return Err(SceneError::Count { what, found, most });
            }
        }
        for (number, wire) in self.wires.iter().enumerate() {
            let ends = wire.ends;
            let way = sub(ends[1], ends[0]);
            if !near(ends[0]) || !near(ends[1]) || !(0.1..=1e4).contains(&dot(way, way).sqrt()) {
                return Err(SceneError::Wire { number, ends });
            }
        }
        for (number, wall) in self.walls.iter().enumerate() {
            let Wall { point, normal } = *wall;
            let long = dot(normal, normal).sqrt();
            if !near(point) || !long.is_finite() || long < 1e-9 {
                return Err(SceneError::Wall { number, point, normal });
            }
        }
        Ok(())
    }
}

fn near(place: [f64; 3]) -> bool {
    place.iter().all(|part| part.abs() <= FAR_MM)
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
