//! What goes over the link: keys, envelopes, and what a sender says of itself.

mod clock_answer;
mod envelope;
mod facts;
mod mesh;

use std::ops::RangeInclusive;

use bus::message::{
    Event, Guide, Identity, MarkerFrame, TissueHeader, TissueMeshHeader, ToolPose, VolumeHeader, Workflow,
};
use bus::topic::{EVENT, GUIDE, IDENTITY, MARKERS, TISSUE, TISSUE_MESH, TOOL_POSE, Topic, VOLUME, WORKFLOW};

pub use clock_answer::ClockAnswer;
pub use envelope::{Envelope, EnvelopeError};
pub use facts::{Facts, FactsError, hex};
pub use mesh::{MeshPiece, MeshPieceError};

/// The version of keys, envelopes and answers.
pub const VERSION: u32 = 1;
/// Answers with [`Facts`].
pub const FACTS: &str = "trocar/1/facts";
/// Answers with a [`ClockAnswer`].
pub const CLOCK: &str = "trocar/1/clock";
/// Answers with a piece of the voxels, as they lie in memory.
pub const PIECE: &str = "trocar/1/volume";
/// Answers with a [`MeshPiece`] of the organs at rest.
pub const MESH: &str = "trocar/1/tissue-mesh";
/// Keys that a receiver asks, and the sender answers.
pub const ASKED: [&str; 4] = [FACTS, CLOCK, PIECE, MESH];
/// Stored values of a piece; the last has what is left.
pub const PIECE_VALUES: usize = 1 << 16;
/// Bytes of the coordinates of a state, at most: of a third of a million nodes.
pub const MOST_NODE_BYTES: usize = 4 << 20;

/// A topic that goes over the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// `tool-pose`
    Pose,
    /// `guide`
    Guide,
    /// `workflow`
    Workflow,
    /// `identity`
    Identity,
    /// `markers`
    Markers,
    /// `event/*` of the run's pilot and localizer.
    Event,
    /// `tissue`: the header, and behind it the coordinates.
    Tissue,
}

impl Channel {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Pose,
        Self::Guide,
        Self::Workflow,
        Self::Identity,
        Self::Markers,
        Self::Event,
        Self::Tissue,
    ];

    /// Its key.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Pose => "trocar/1/pose",
            Self::Guide => "trocar/1/guide",
            Self::Workflow => "trocar/1/workflow",
            Self::Identity => "trocar/1/identity",
            Self::Markers => "trocar/1/markers",
            Self::Event => "trocar/1/event",
            Self::Tissue => "trocar/1/tissue",
        }
    }

    /// Its topic on the bus.
    pub const fn topic(self) -> &'static Topic {
        match self {
            Self::Pose => &TOOL_POSE,
            Self::Guide => &GUIDE,
            Self::Workflow => &WORKFLOW,
            Self::Identity => &IDENTITY,
            Self::Markers => &MARKERS,
            Self::Event => &EVENT,
            Self::Tissue => &TISSUE,
        }
    }

    /// Bytes of a message of it; of a state those of its header, behind which its coordinates lie.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Pose => size_of::<ToolPose>(),
            Self::Guide => size_of::<Guide>(),
            Self::Workflow => size_of::<Workflow>(),
            Self::Identity => size_of::<Identity>(),
            Self::Markers => size_of::<MarkerFrame>(),
            Self::Event => size_of::<Event>(),
            Self::Tissue => size_of::<TissueHeader>(),
        }
    }

    /// Bytes that a message of it may have.
    pub const fn allowed(self) -> RangeInclusive<usize> {
        match self {
            Self::Tissue => self.bytes()..=self.bytes() + MOST_NODE_BYTES,
            _ => self.bytes()..=self.bytes(),
        }
    }
}

/// Every key of the link: those that the sender publishes, and those that it answers.
pub fn keys() -> impl Iterator<Item = &'static str> {
    Channel::ALL.into_iter().map(Channel::key).chain(ASKED)
}

/// What both ends must understand alike: the versioned names of all that goes over, with their sizes.
pub fn payloads() -> Vec<String> {
    let channels = Channel::ALL
        .iter()
        .map(|channel| format!("{} {}", channel.topic().payload, channel.bytes()));
    channels
        .chain([
            format!("{} {}", VOLUME.payload, size_of::<VolumeHeader>()),
            format!("{} {}", TISSUE_MESH.payload, size_of::<TissueMeshHeader>()),
        ])
        .collect()
}

/// How many pieces `stored` values make.
pub fn pieces(stored: u64) -> u32 {
    u32::try_from(stored.div_ceil(PIECE_VALUES as u64)).unwrap_or(u32::MAX)
}

/// Which of `stored` values piece `index` holds; `None` where there is no such piece.
pub fn piece(index: u32, stored: usize) -> Option<std::ops::Range<usize>> {
    let from = (index as usize).checked_mul(PIECE_VALUES)?;
    (from < stored).then(|| from..stored.min(from.saturating_add(PIECE_VALUES)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_every_value_once() {
        for stored in [
            1,
            PIECE_VALUES - 1,
            PIECE_VALUES,
            PIECE_VALUES + 1,
            10 * PIECE_VALUES + 7,
        ] {
            let mut next = 0;
            for index in 0..pieces(stored as u64) {
                let range = piece(index, stored).unwrap();
                assert_eq!(range.start, next);
                next = range.end;
            }
            assert_eq!(next, stored);
            assert_eq!(piece(pieces(stored as u64), stored), None);
        }
        assert_eq!(piece(u32::MAX, 5), None);
    }

    #[test]
    fn every_channel_has_its_own_key_below_one_root() {
        let mut keys: Vec<&str> = keys().collect();
        assert!(keys.iter().all(|key| key.starts_with(&format!("trocar/{VERSION}/"))));
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), Channel::ALL.len() + 4);
    }
}
