//! 3D Slicer's lists of fiducials, `.fcsv`, of its versions 4 and 5.
//!
//! The first lines say version, axes and columns, each other line is a point. Axes are `0`, `1`, `RAS` or `LPS`. Slicer
//! up to 4.11 takes every word there for 0, which is RAS: [`write()`] writes the number. The quaternion of a point,
//! to its own axes, is passed over.

mod error;
mod read;
mod row;
mod write;

pub use error::FcsvError;
pub use read::read;
pub use write::write;

use crate::{ControlPoint, LeftOut};

/// The longest file, bytes.
pub const MAX_BYTES: usize = 16 << 20;
/// Most points of a file.
pub const MAX_POINTS: usize = 100_000;

/// The columns, as both versions write them.
const COLUMNS: &str = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// The content of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fiducials {
    /// The points that have a place, in their order.
    pub points: Vec<ControlPoint>,
    /// Those that have none.
    pub left_out: Vec<LeftOut>,
}
