//! ITK's transforms as text, `.tfm` and `.txt`, and as HDF5, `.h5`: those that are rigid.
//!
//! A transform of ITK maps **points** from the frame of the output of a resampling, the fixed image, to that of its input, the moving
//! image. Frames are in no such file; whoever reads one says by the types of [`read()`] which they are. Coordinates are LPS, mm.
//!
//! 3D Slicer saves a transform node in this way too, and what it writes is not the matrix that it shows: the node's matrix takes the node's
//! points to its parent and is along RAS on both sides, the file takes the parent's to the node's along LPS. [`slicer_node`] and
//! [`slicer_file`] are the way between.
//!
//! Fixed parameters are the centre of rotation: x -> R (x - c) + c + t.

mod error;
mod hdf5;
mod parts;
mod read;
mod write;

pub use error::ItkError;
pub use read::{Transform, read};
pub use write::write;

use geometry::Rigid;

use crate::axes::turned_both;

/// The longest file, bytes: transforms that are not rigid are larger, and are refused by their names.
pub const MAX_BYTES: usize = 256 << 20;
/// Most transforms of a composite.
pub const MAX_PARTS: usize = 256;
/// The largest Frobenius distance of a matrix from the nearest rotation: four decimals of each entry are 1.5e-4 off at most. Less than is let
/// pass of single poses (`calib`), as what a calibration is off by is in every pose.
pub const MOST_OFF: f64 = 2e-4;

/// What a node of 3D Slicer shows as its matrix, which takes `From` to its parent `To`, from what its file holds.
pub fn slicer_node<To, From>(file: &Rigid<From, To>) -> Rigid<To, From> {
    turned_both(&file.inverse())
}

/// What the file of a node of 3D Slicer holds that shows this matrix.
pub fn slicer_file<To, From>(node: &Rigid<To, From>) -> Rigid<From, To> {
    turned_both(&node.inverse())
}
