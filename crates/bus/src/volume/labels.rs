//! A label map that was read as a volume: its structures.

use geometry::VolumeGrid;
use guidance::safety::{GridMatch, MapError, Structures};

use super::OwnedVolume;

/// A label map of an examination, as it was read.
#[derive(Debug)]
pub struct LabelMap {
    /// Its voxels are labels, 0 for none.
    pub volume: OwnedVolume,
    /// Whether its file says to be in the frame of reference of the examination.
    pub is_in_its_frame: bool,
    /// What is doubtful about whose it is, and whether anybody approved of it, a sentence each.
    pub doubts: Vec<String>,
}

impl LabelMap {
    /// How the map lies beside the voxels of a CT.
    pub fn lies_on(&self, ct: &VolumeGrid) -> GridMatch {
        GridMatch::of(&self.volume.grid, ct).known(self.is_in_its_frame)
    }
}

impl OwnedVolume {
    /// The structures of a label map: its voxels are labels, 0 for none.
    ///
    /// # Errors
    /// [`MapError`] for what is no label map: negative labels, none at all, more than can be held.
    pub fn structures(&self) -> Result<Structures, MapError> {
        let view = self.view();
        Structures::build(&self.grid, |z, slice| view.slice(z, slice))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Hasher, Layout, Marks, Voxels};
    use geometry::{Affine, VolumeGrid};

    #[test]
    fn each_label_is_found_where_its_voxel_lies() {
        let dims = [9, 6, 5];
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let grid = VolumeGrid::checked(dims.map(i64::from), Affine::from_rows(rows)).unwrap();
        for brick in [[1, 1, 1], [4, 4, 4]] {
            let layout = Layout::new(dims, brick).unwrap();
            let mut voxels = Voxels::zeroed(layout.stored() as usize);
            let places = [[0, 0, 0], [8, 5, 4], [3, 4, 2]];
            for (label, place) in (1..).zip(places) {
                voxels[layout.offset(place)] = label;
            }
            let volume = OwnedVolume {
                grid,
                layout,
                voxels,
                padding_hu: 0,
                hash: Hasher::new(&grid, 0).finish(),
                marks: Marks::NONE,
            };
            let structures = volume.structures().unwrap();
            let found: Vec<_> = structures
                .list()
                .iter()
                .map(|s| (s.label(), s.extent().0, s.voxels()))
                .collect();
            assert_eq!(found, [(1, places[0], 1), (2, places[1], 1), (3, places[2], 1)]);
        }
    }
}
