//! Identifiers made from the volume itself: the same volume has the same ones, another volume has others.
//!
//! They are UUIDs as decimal numbers under the root 2.25 (PS3.5 B.2). What the voxels are is known only after the last
//! slice, so files are written with stand-ins of the same length, and those are overwritten in place.

use bus::message::VolumeHash;

/// Which identifier stands somewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    Study,
    Series,
    FrameOfReference,
    /// The slice's own.
    Instance,
}

impl Which {
    pub(super) const ALL: [Self; 4] = [Self::Study, Self::Series, Self::FrameOfReference, Self::Instance];

    /// How often a file holds it: a slice's own stands in the file's meta information too.
    const fn count(self) -> usize {
        match self {
            Self::Instance => 2,
            _ => 1,
        }
    }

    /// What stands in its place until the volume is known.
    pub(super) fn stand_in(self) -> String {
        let digit = match self {
            Self::Study => "1",
            Self::Series => "2",
            Self::FrameOfReference => "3",
            Self::Instance => "4",
        };
        format!("2.25.{}", digit.repeat(39))
    }
}

/// All identifiers of a series.
#[derive(Debug, Clone, Copy)]
pub(super) struct Identifiers {
    hash: VolumeHash,
    variant: Option<u64>,
}

impl Identifiers {
    /// Those of the volume with this hash. A `variant` is another series of the same study and frame of reference.
    pub(super) fn new(hash: VolumeHash, variant: Option<u64>) -> Self {
        Self { hash, variant }
    }

    /// The identifier `which` in the file of slice `k`.
    pub(super) fn get(&self, which: Which, k: u32) -> String {
        let mut hasher = blake3::Hasher::new_derive_key("trocar dicom series 1");
        hasher.update(&self.hash.0);
        hasher.update(match which {
            Which::Study => b"study   ",
            Which::Series => b"series  ",
            Which::FrameOfReference => b"frame   ",
            Which::Instance => b"instance",
        });
        if matches!(which, Which::Series | Which::Instance) {
            hasher.update(&[u8::from(self.variant.is_some())]);
            hasher.update(&self.variant.unwrap_or_default().to_le_bytes());
        }
        if which == Which::Instance {
            hasher.update(&k.to_le_bytes());
        }
        of_hash(&hasher)
    }
}

/// The identifier of what was hashed: a UUID of RFC 9562, version 8, variant 10.
pub(crate) fn of_hash(hasher: &blake3::Hasher) -> String {
    let mut bytes = [0; 16];
    hasher.finalize_xof().fill(&mut bytes);
    // The first bit makes every number one of 39 digits.
    bytes[0] |= 0x80;
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    format!("2.25.{}", u128::from_be_bytes(bytes))
}

/// Where the stand-ins are in `header`, or `None` where they are not there as often as they must be.
pub(super) fn stand_ins(header: &[u8]) -> Option<Vec<(u64, Which)>> {
    let mut found = Vec::new();
    for which in Which::ALL {
        let text = which.stand_in();
        let starts = header.windows(text.len()).enumerate();
        let starts = starts.filter(|(_, window)| *window == text.as_bytes());
        let before = found.len();
        found.extend(starts.map(|(at, _)| (at as u64, which)));
        if found.len() - before != which.count() {
            return None;
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn identifiers_are_as_long_as_their_stand_ins_and_all_different() {
        let volumes = [1, 2].map(|byte| VolumeHash([byte; 32]));
        let mut seen = BTreeSet::new();
        for hash in volumes {
            for variant in [None, Some(0), Some(7)] {
                let ids = Identifiers::new(hash, variant);
                for which in Which::ALL {
                    for k in 0..50 {
                        let id = ids.get(which, k);
                        assert_eq!(id.len(), which.stand_in().len(), "{id}");
                        assert_eq!(id, ids.get(which, k));
                        seen.insert(id);
                    }
                }
            }
        }
        // Two volumes: a study and a frame each; three series each, of 50 files.
        assert_eq!(seen.len(), 2 * (2 + 3 + 3 * 50));
    }

    #[test]
    fn a_missing_stand_in_is_noticed() {
        let all: Vec<u8> = [0, 1, 2, 3, 3]
            .iter()
            .flat_map(|&i| (Which::ALL[i].stand_in() + "__").into_bytes())
            .collect();
        let found = stand_ins(&all).unwrap();
        assert_eq!((found[1], found[4]), ((46, Which::Series), (184, Which::Instance)));
        assert!(stand_ins(&all[46..]).is_none());
        assert!(stand_ins(&all[..180]).is_none());
    }
}
