//! What an examination is, told without loading it: its place, its HU, what is doubtful, and three planes as a picture.
//!
//! Slices pass once and none is kept: memory is one slice, the counts of 65536 HU, and the pixels of the picture. Nothing
//! here names a patient, because no source does.

mod draw;
mod histogram;
mod place;
mod planes;
mod statistics;
mod summary;
mod text;
pub(crate) mod warnings;

#[cfg(test)]
mod tests;

use bus::volume::{Hasher, SliceHash};
use picture::Canvas;
use scene::WindowLevel;

pub use histogram::Histogram;
pub use place::{Handedness, Place};
pub use statistics::{HuRange, Padding};
pub use summary::{Changed, Summary};

use crate::source::{ReadError, VoxelSource};
use planes::Planes;
use statistics::Counts;

/// Soft tissue: what a picture shows unless told otherwise.
pub const WINDOW: WindowLevel = WindowLevel {
    centre_hu: 40.0,
    width_hu: 400.0,
};

/// What was found.
#[derive(Debug)]
pub struct Inspection {
    /// In numbers and words.
    pub summary: Summary,
    /// The three planes through the volume's middle, where they were asked for.
    pub picture: Option<Canvas>,
}

/// Reads `source` to its end and says what it is; `window` asks for the picture.
///
/// # Errors
/// The source's.
pub fn inspect(source: &mut dyn VoxelSource, window: Option<WindowLevel>) -> Result<Inspection, ReadError> {
    let (grid, padding_hu, facts) = (*source.grid(), source.padding_hu(), source.facts());
    let mut hasher = Hasher::new(&grid, padding_hu);
    let mut counts = Counts::default();
    let mut planes = window.map(|_| Planes::new(&grid, statistics::distinct_padding(padding_hu)));
    let [columns, rows, slices] = grid.dims();
    let mut slice = vec![0; columns as usize * rows as usize];
    for k in 0..slices {
        source.read_slice(k, &mut slice)?;
        hasher.update(SliceHash::of(&slice));
        counts.add(&slice);
        if let Some(planes) = &mut planes {
            planes.add(k, &slice);
        }
    }
    let changed = Changed::from(source.finish()?);
    let mut summary = Summary {
        format: source.describe(),
        place: Place::of(&grid),
        voxels: grid.voxels(),
        hu: counts.range(padding_hu),
        padding: counts.padding(padding_hu),
        histogram: counts.histogram(padding_hu),
        changed,
        marks: source.marks().words(),
        hash: hasher.finish().to_string(),
        warnings: facts.warnings,
        extra: facts.extra,
    };
    summary.warnings.extend(source.remarks());
    summary.warnings.extend(warnings::of(&summary));
    let picture = planes
        .zip(window)
        .map(|(planes, window)| draw::draw(&planes, &summary, window));
    Ok(Inspection { summary, picture })
}
