//! Floor 1: ultrasound images: where their beams run, and generated images whose truth is known.
//!
//! No I/O and no clock; the same input gives the same bits. Lengths are mm, angles rad.
//!
//! **The image.** A pixel (u, v), whole numbers being centres of pixels, u to the right and v down, lies in the
//! image's plane at (u s_u, v s_v) mm, as for `probe`'s calibrations. Where beams run in that plane is [`Beams`].
//!
//! **Generated images.** A [`Scanner`] images a [`Scene`]: a [`Body`] that tells HU, wires and walls. Scatterers are drawn
//! from the number of their cell in the patient, so that tissue looks the same when the probe comes back; bone echoes by its
//! slant and shadows; the beam is as thick as [`Focus`] says, along a row and across the image. [`truth`] tells where bone
//! and wires truly lie, by a search of its own. HU do not tell tissues apart as sound does: how tissue looks is plausible,
//! where bone lies is exact. Not modelled: refraction, side lobes of anything but wires, shadows of wires, motion during an
//! image, bone beside the plane further than 2 deviations of the beam or than 8 mm along it from where the plane meets bone.
//!
//! ```
//! use ultrasound::{Beams, Pose, Scanner, Scene, Settings, Shape};
//! let beams = Beams::Linear { from_mm: 0.0, to_mm: 38.0, face_mm: 0.0 };
//! let shape = Shape::new([380, 400], [0.1, 0.1], beams, 39.0)?;
//! let mut scanner = Scanner::new(&shape, &Settings::shallow())?;
//! // Muscle, and bone from 20 mm on.
//! let body = |[_, y, _]: [f64; 3]| if y < 20.0 { 50.0 } else { 900.0 };
//! let pose = Pose::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])?;
//! let grey = scanner.scan(&Scene::of(&body), &pose, 0)?;
//! assert!(grey[200 * 380 + 190] > 150);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod display;
mod echoes;
mod fan;
mod field;
mod lattice;
mod scanner;
mod scene;
mod settings;
mod shape;
mod speckle;
mod survey;
mod tissue;
mod truth;
mod water;
mod wires;

pub use scanner::Scanner;
pub use scene::{Body, Pose, Scene, SceneError, Wall, Wire, water};
pub use settings::{Focus, SettingError, Settings};
pub use shape::{Beam, Beams, Image, Shape, ShapeError};
pub use truth::{Crossing, Level, Met, Truth, WireCrossing, truth};
pub use water::{SCANNER_M_S, water_m_s};
