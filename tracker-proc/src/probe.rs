//! The simulated ultrasound probe of an operating room: images of the run's own patient, or of a tank, at the tool's tip.
//!
//! A pure function of the image's number and the seed, as the room is. The tool's tip is the middle of the probe's face, beams
//! run along the tool's z, the image's rows along its x:
//!
//! ```text
//! tool_from_image = (x, y, z) -> (x - face_x, -z, y - face_y)
//! ```
//!
//! with the image's x along its rows and y along its columns ([`ultrasound::Shape`]).

mod publish;
mod tank;
mod tissue;

use geometry::{Ct, Point, Rigid, Tool, Vector, checked};
use scene::operating_room::{Array, Probe};
use ultrasound::{Beams, Body, Pose, Scanner, Scene, SceneError, Settings, Shape, water};

pub(crate) use publish::Publishing;
pub use tank::{Tank, TankError};
pub(crate) use tissue::Tissue;

/// From this depth on a scanner of lower frequency is taken: the other one's sound does not come back.
const DEEP_MM: f64 = 70.0;

/// A probe that makes images.
#[derive(Debug)]
pub struct SimulatedProbe {
    scanner: Scanner,
    /// The face's middle in the image's plane, mm.
    face_mm: [f64; 2],
    spec: Probe,
}

/// Why there is no such probe.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// Its image cannot be.
    #[error("the simulated probe (tracker.room.probe): {0}")]
    Shape(#[from] ultrasound::ShapeError),
    /// Its scanner cannot be.
    #[error("the simulated probe (tracker.room.probe): {0}")]
    Settings(#[from] ultrasound::SettingError),
    /// Its tank cannot be.
    #[error("the tank of the simulated probe (tracker.room.probe.tank): {0}")]
    Tank(#[from] Box<TankError>),
    /// The thread that makes its images.
    #[error("no thread for the images of the simulated probe: {0}")]
    Thread(#[from] std::io::Error),
    /// The thread has failed.
    #[error("the images of the simulated probe: {0}")]
    Ended(String),
}

impl SimulatedProbe {
    /// The probe of a scene.
    ///
    /// # Errors
    /// [`ProbeError::Shape`], [`ProbeError::Settings`].
    pub fn new(spec: Probe, seed: u64) -> Result<Self, ProbeError> {
        let shape = shape(&spec)?;
        let settings = match spec.depth_mm > DEEP_MM {
            true => Settings::deep(),
            false => Settings::shallow(),
        };
        let settings = Settings {
            speed_ratio: spec.speed_ratio,
            seed,
            ..settings
        };
        let (face_mm, _) = shape.along(0.5, 0.0);
        Ok(Self {
            scanner: Scanner::new(&shape, &settings)?,
            face_mm,
            spec,
        })
    }

    /// The same probe in a tank, in whose water sound may have a speed of its own.
    ///
    /// # Errors
    /// [`ProbeError::Shape`], [`ProbeError::Settings`].
    pub fn in_tank(spec: Probe, tank: &Tank, seed: u64) -> Result<Self, ProbeError> {
        let speed_ratio = tank.speed_ratio().unwrap_or(spec.speed_ratio);
        Self::new(Probe { speed_ratio, ..spec }, seed)
    }

    /// The shape of its images.
    pub fn shape(&self) -> &Shape {
        self.scanner.shape()
    }

    /// Script time at which image `number` is captured, ns.
    pub fn t_capture_ns(&self, number: u64) -> i64 {
        bus::clock::seconds(number as f64 / self.spec.rate_hz)
    }

    /// Where a place of the image's plane (mm, x along its rows, y along its columns) lies on the tool.
    pub fn tool_from_image(&self, [x, y]: [f64; 2]) -> Point<Tool> {
        Point::new(x - self.face_mm[0], 0.0, y - self.face_mm[1])
    }

    /// Where the image's plane lies on the tool, as a motion that carries image coordinates in mm (x right, y down, z = x x y).
    pub fn image_on_tool(&self) -> Option<Rigid<Tool, geometry::Image>> {
        let half = 0.5_f64.sqrt();
        // A quarter turn about x: y goes to z, z to -y.
        checked::rigid([half, half, 0.0, 0.0], [-self.face_mm[0], 0.0, -self.face_mm[1]], 1e-9).ok()
    }

    /// The grey values of image `number`, row by row, of a probe that truly is at `ct_from_tool`.
    ///
    /// # Errors
    /// [`SceneError`] for a pose that is far from every patient.
    pub fn image(
        &mut self,
        tissue: &impl Body,
        ct_from_tool: Rigid<Ct, Tool>,
        number: u64,
    ) -> Result<Vec<u8>, SceneError> {
        self.scan(&Scene::of(tissue), ct_from_tool, number)
    }

    /// The same of a tank.
    ///
    /// # Errors
    /// [`SceneError`] for a pose that is far from every tank.
    pub fn image_in_tank(
        &mut self,
        tank: &Tank,
        ct_from_tool: Rigid<Ct, Tool>,
        number: u64,
    ) -> Result<Vec<u8>, SceneError> {
        let in_water = Scene {
            body: &water,
            wires: &tank.wires,
            walls: &tank.walls,
        };
        self.scan(&in_water, ct_from_tool, number)
    }

    fn scan<B: Body>(
        &mut self,
        scene: &Scene<'_, B>,
        ct_from_tool: Rigid<Ct, Tool>,
        number: u64,
    ) -> Result<Vec<u8>, SceneError> {
        let origin = (ct_from_tool * self.tool_from_image([0.0, 0.0])).mm();
        let along = |x, z| (ct_from_tool * Vector::<Tool>::new(x, 0.0, z)).mm();
        let pose = Pose::new(origin, along(1.0, 0.0), along(0.0, 1.0))?;
        self.scanner.scan(scene, &pose, number)
    }
}

/// The smallest image that shows every beam whole.
fn shape(spec: &Probe) -> Result<Shape, ultrasound::ShapeError> {
    let [width_mm, height_mm] = spec.extent_mm();
    // A scene has at most 1024 pixels a side.
    let size = [width_mm, height_mm].map(|side| (side / spec.pixel_mm).round() as usize + 1);
    let beams = match spec.array {
        Array::Linear { width_mm } => Beams::Linear {
            from_mm: 0.0,
            to_mm: width_mm,
            face_mm: 0.0,
        },
        Array::Convex {
            radius_mm,
            half_angle_rad,
        } => Beams::Convex {
            centre_mm: [width_mm / 2.0, -radius_mm * half_angle_rad.cos()],
            radius_mm,
            half_angle: half_angle_rad,
        },
    };
    Shape::new(size, [spec.pixel_mm; 2], beams, spec.depth_mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(array: Array) -> Probe {
        Probe {
            array,
            depth_mm: 50.0,
            pixel_mm: 0.25,
            rate_hz: 15.0,
            lag_s: 0.0,
            speed_ratio: 1.0,
        }
    }

    fn arrays() -> [Array; 2] {
        let convex = Array::Convex {
            radius_mm: 50.0,
            half_angle_rad: 0.5,
        };
        [Array::Linear { width_mm: 40.0 }, convex]
    }

    #[test]
    fn the_tip_is_the_middle_of_the_face_and_beams_run_along_the_tool_s_z() {
        for array in arrays() {
            let probe = SimulatedProbe::new(spec(array), 1).unwrap();
            for depth in [0.0, 17.5] {
                let (place, _) = probe.shape().along(0.5, depth);
                let [x, y, z] = probe.tool_from_image(place).mm();
                assert!(x.abs() + y.abs() + (z - depth).abs() < 1e-9, "{array:?}: {x} {y} {z}");
            }
            // Both ways to the tool's frame are one.
            let on_tool = probe.image_on_tool().unwrap();
            let [x, y] = [3.25, 12.5];
            let there = on_tool * Point::<geometry::Image>::new(x, y, 0.0);
            assert!(there.distance(probe.tool_from_image([x, y])) < 1e-9);
        }
    }

    /// A flat bone, square to the beams and 20 mm below the face, wherever the tool is.
    #[test]
    fn a_bone_is_shown_at_its_depth_below_the_tip_wherever_the_tool_is() {
        let turned =
            Rigid::<Ct, Tool>::from_rotation_vector(Vector::new(0.7, -0.3, 1.9), Vector::new(40.0, -25.0, 90.0));
        let ct_from_tool = turned.unwrap();
        for array in arrays() {
            let mut probe = SimulatedProbe::new(spec(array), 1).unwrap();
            let depth_mm = 20.0;
            let tissue = |[x, y, z]: [f64; 3]| {
                let below = (ct_from_tool.inverse() * Point::<Ct>::new(x, y, z)).mm()[2];
                if below > depth_mm { 700.0 } else { 50.0 }
            };
            let grey = probe.image(&tissue, ct_from_tool, 0).unwrap();
            let shape = *probe.shape();
            // The middle beam: as much brighter than elsewhere on it as bone is than tissue.
            let level = |depth: f64| {
                let [u, v] = shape.pixel_at(shape.along(0.5, depth).0);
                f64::from(grey[v.round() as usize * shape.columns() + u.round() as usize])
            };
            let depths: Vec<f64> = (20..196).map(|i| f64::from(i) * 0.25).collect();
            let brightest = depths
                .iter()
                .copied()
                .max_by(|a, b| level(*a).total_cmp(&level(*b)))
                .unwrap();
            // Half a pulse and a pixel, and bone that is as thick as the beam is high where beams lean.
            assert!((brightest - depth_mm).abs() < 1.0, "{array:?}: {brightest}");
            let shadow: f64 = (24..36).map(|mm| level(f64::from(mm))).sum::<f64>() / 12.0;
            assert!(shadow < level(brightest) / 3.0, "{shadow}");
        }
    }

    /// An image that is the one before byte for byte is taken for that of a frozen screen: a probe at rest must send none.
    #[test]
    fn images_of_a_probe_at_rest_differ_by_noise_and_an_image_of_a_number_is_the_same_again() {
        let at_rest = Rigid::<Ct, Tool>::from_rotation_vector(Vector::new(0.7, -0.3, 1.9), Vector::new(4.0, -2.0, 9.0));
        let at_rest = at_rest.unwrap();
        // Tissue, tissue before bone, air in front of the face, and water.
        let bodies: [fn([f64; 3]) -> f64; 4] = [
            |_| 50.0,
            |[x, ..]| if x > 8.0 { 900.0 } else { 50.0 },
            |_| -1000.0,
            |_| 0.0,
        ];
        for (array, depth_mm) in arrays().into_iter().flat_map(|array| [(array, 50.0), (array, 120.0)]) {
            let spec = Probe {
                depth_mm,
                ..spec(array)
            };
            let mut probe = SimulatedProbe::new(spec, 1).unwrap();
            for body in bodies {
                let images = [0, 1, 2, u64::MAX].map(|number| probe.image(&body, at_rest, number).unwrap());
                for (i, one) in images.iter().enumerate() {
                    assert!(
                        images[..i].iter().all(|other| other != one),
                        "{array:?}, {depth_mm} mm: image {i}"
                    );
                }
                let mut other = SimulatedProbe::new(spec, 1).unwrap();
                assert!(other.image(&body, at_rest, 1).unwrap() == images[1]);
            }
        }
    }
}
