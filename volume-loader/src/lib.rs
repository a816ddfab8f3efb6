//! The volume loader: reads the examination and puts it once into shared memory.
//!
//! Sources ([`source::VoxelSource`]) give slices in order; [`fill`] puts them into bricks and takes the volume's hash on
//! the way; `run` publishes the result and keeps it there for late joiners. No process holds a second copy.

pub mod cli;
pub mod dicom;
pub mod dicom_out;
mod error;
mod fill;
pub mod inspect;
#[cfg(test)]
mod irregular;
mod load;
pub mod metaimage;
pub mod nifti;
pub mod nrrd;
pub mod part;
mod partial;
pub mod phantom_source;
mod progress;
pub mod raster;
pub mod receive;
mod run;
mod scale;
#[cfg(test)]
mod sides;
pub mod source;
mod stream;
mod voxels;
mod write;

pub use dicom_out::derived::{DerivedError, structure_set_bytes};
pub use error::LoadError;
pub use fill::{Filled, fill};
pub use load::names::{LabelNamesError, label_names};
pub use load::origin::error::OriginError;
pub use load::segmentation::SegmentationError;
pub use load::structure_set::{NamedPoint, StructureSet, StructureSetError, structure_set};
pub use load::{
    Told, load, load_label_map, load_labels, load_labels_seeded, load_seeded, load_told, load_told_seeded, open,
};
pub use run::RunError;
pub use write::WriteOptions;
pub use write::error::WriteError;
