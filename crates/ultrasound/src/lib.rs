//! Floor 1: ultrasound images: where their beams run, and generated images whose truth is known.
//!
//! No I/O and no clock; the same input gives the same bits. Lengths are mm, angles rad.
//!
//! **The image.** A pixel (u, v), whole numbers being centres of pixels, u to the right and v down, lies in the
//! image's plane at (u s_u, v s_v) mm, as for `probe`'s calibrations. Where beams run in that plane is [`Beams`].

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
mod wires;

pub use scanner::Scanner;
pub use scene::{Body, Pose, Scene, SceneError, Wall, Wire, water};
pub use settings::{Focus, SettingError, Settings};
pub use shape::{Beam, Beams, Image, Shape, ShapeError};
pub use truth::{Crossing, Level, Met, Truth, WireCrossing, truth};
