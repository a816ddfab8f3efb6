//! A tank of water with a phantom of wires, which a simulated probe images instead of the patient.
//!
//! Where the phantom truly stands in the room, whose frame is the CT's:
//!
//! ```text
//! ct_from_phantom = ct_from_reference * error * reference_from_phantom
//! ```
//!
//! with what the file tells last, and the error that the scene plants, drawn from its seed, about the middle of the wires.

use std::io::Read;
use std::path::{Path, PathBuf};

use chance::Chance;
use exchange::plus::{self, PhantomWire, PlusError};
use geometry::{Ct, Phantom, Point, Reference, Rigid, Vector};
use scene::operating_room::{Deviations, Room, Tank as Spec};
use scene::{Scene, TrackerSource};
use ultrasound::{SCANNER_M_S, Wall, Wire, water_m_s};

use crate::operating_room::about;

/// Keeps the draw of the phantom's place apart from others.
const PLACE: u64 = 0x7461_6e6b;
/// A wire is a line: a shorter one is a mistake of the file, mm. `calib probe` refuses the same.
const LEAST_MM: f64 = 1.0;
/// A scanner images nothing farther from the room's origin, mm.
const FAR_MM: f64 = 1e5;

/// What is in the tank, in the room's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Tank {
    ct_from_phantom: Rigid<Ct, Phantom>,
    pub(super) wires: Vec<Wire>,
    pub(super) walls: Vec<Wall>,
    speed_ratio: Option<f64>,
}

/// Why there is no such tank.
#[derive(Debug, thiserror::Error)]
pub enum TankError {
    /// The file cannot be read.
    #[error("reading the phantom {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It tells of no wires, or of no place.
    #[error("reading the phantom {path}: {source}")]
    Plus {
        /// The file.
        path: PathBuf,
        /// Why.
        source: Box<PlusError>,
    },
    /// A wire that cannot be.
    #[error("the phantom {path}: the wire {name} {why}")]
    Wire {
        /// The file.
        path: PathBuf,
        /// Its name.
        name: String,
        /// What is wrong.
        why: &'static str,
    },
    /// The room has no marker at the tank.
    #[error("the phantom {path}: the room has no reference, in which the phantom's place is told")]
    NoReference {
        /// The file.
        path: PathBuf,
    },
}

impl Tank {
    /// Reads the tank of a scene, as a run does at its start; `None` of a scene without one.
    ///
    /// # Errors
    /// [`TankError`].
    pub fn of(scene: &Scene) -> Result<Option<Self>, TankError> {
        let TrackerSource::OperatingRoom(room) = &scene.tracker.source else {
            return Ok(None);
        };
        let tank = room.tank.as_ref();
        tank.map(|tank| Self::load(tank, room, scene.seed)).transpose()
    }

    /// Reads the tank of a room of this seed.
    ///
    /// # Errors
    /// [`TankError`].
    pub fn load(spec: &Spec, room: &Room, seed: u64) -> Result<Self, TankError> {
        let io = |source| TankError::Io {
            path: spec.file.clone(),
            source,
        };
        let mut bytes = Vec::new();
        let (file, _) = scene::file::open(&spec.file).map_err(|error| io(error.into()))?;
        // One byte more than allowed shows that there are more, whatever the file says of its length.
        file.take(plus::MAX_BYTES as u64 + 1)
            .read_to_end(&mut bytes)
            .map_err(io)?;
        Self::parse(&bytes, spec, room, seed)
    }

    /// The same of the file's bytes.
    ///
    /// # Errors
    /// [`TankError`], all but [`TankError::Io`].
    pub fn parse(bytes: &[u8], spec: &Spec, room: &Room, seed: u64) -> Result<Self, TankError> {
        let path = spec.file.as_path();
        let plus = |source| TankError::Plus {
            path: path.to_owned(),
            source: Box::new(source),
        };
        let Some(on) = &room.reference else {
            return Err(TankError::NoReference { path: path.to_owned() });
        };
        let drawn = plus::wires(bytes).map_err(plus)?;
        let set = plus::read(bytes).map_err(plus)?;
        let told = set.find::<Reference, Phantom>("Phantom", "Reference").map_err(plus)?;
        let truth = planted(told.to_from_from, middle(&drawn), spec.error, seed);
        let ct_from_phantom = on.ct_from_reference * truth;
        let wires: Result<Vec<Wire>, TankError> = drawn.iter().map(|one| placed(path, one, &ct_from_phantom)).collect();
        let walls = spec.bottom.iter().map(|bottom| Wall {
            point: (ct_from_phantom * bottom.point).mm(),
            normal: (ct_from_phantom * bottom.normal).components(),
        });
        Ok(Self {
            walls: walls.collect(),
            wires: wires?,
            ct_from_phantom,
            speed_ratio: spec.water_celsius.map(|celsius| water_m_s(celsius) / SCANNER_M_S),
        })
    }

    /// Where the phantom truly stands.
    pub fn ct_from_phantom(&self) -> Rigid<Ct, Phantom> {
        self.ct_from_phantom
    }

    /// The speed of sound in the water over the scanner's; `None` where that of the probe's own table holds.
    pub fn speed_ratio(&self) -> Option<f64> {
        self.speed_ratio
    }
}

/// Where a phantom truly stands that is told to be at `told`.
fn planted(
    told: Rigid<Reference, Phantom>,
    middle: Point<Phantom>,
    error: Deviations,
    seed: u64,
) -> Rigid<Reference, Phantom> {
    let chance = Chance::new(seed ^ PLACE, 0);
    let drawn = |first: u64, size: f64| {
        let [x, y, z] = [0, 1, 2].map(|i| size * chance.normal(first + i));
        Vector::<Reference>::new(x, y, z)
    };
    about(told * middle, drawn(0, error.turn_rad), drawn(3, error.shift_mm)) * told
}

/// The middle of the wires' ends, about which `calib probe` takes the error of the phantom's place too.
fn middle(wires: &[PhantomWire]) -> Point<Phantom> {
    let ends = wires.iter().flat_map(|wire| [wire.front_mm, wire.back_mm]);
    let sum = ends.fold([0.0; 3], |sum, end| [0, 1, 2].map(|i| sum[i] + end[i]));
    let [x, y, z] = sum.map(|sum| sum / (2.0 * wires.len().max(1) as f64));
    Point::new(x, y, z)
}

/// A wire in the room.
fn placed(path: &Path, wire: &PhantomWire, ct_from_phantom: &Rigid<Ct, Phantom>) -> Result<Wire, TankError> {
    let place = |[x, y, z]: [f64; 3]| *ct_from_phantom * Point::<Phantom>::new(x, y, z);
    let [front, back] = [wire.front_mm, wire.back_mm].map(place);
    let is_near = |end: &Point<Ct>| end.mm().iter().all(|part| part.abs() <= FAR_MM);
    let refused = |why| TankError::Wire {
        path: path.to_owned(),
        name: wire.name.clone(),
        why,
    };
    if front.distance(back) < LEAST_MM {
        return Err(refused("is shorter than 1 mm: is the file in metres?"));
    }
    if !is_near(&front) || !is_near(&back) {
        return Err(refused("is more than 100 m from the room's origin"));
    }
    let ends = [front.mm(), back.mm()];
    Ok(Wire { ends })
}

#[cfg(test)]
mod tests;
