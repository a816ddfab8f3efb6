//! Floor 2: what an ultrasound image shows: the line of a bone, dots of wires, the line of a wall.
//!
//! Pure numerics: no file, no clock, no process. Places are mm in the image's plane ([`ultrasound::Shape`]), or
//! pixels where it is said. The same input gives the same bits.

pub mod bone;
mod dots;
mod grey;
mod wall;
mod wires;

pub use dots::{Dot, DotOptions, dots};
pub use grey::{Grey, GreyError, Region};
pub use wall::{Wall, WallError, WallOptions, WallPoint, wall};
pub use wires::{Drawing, Labelled, WiresError, WiresOptions, label};
