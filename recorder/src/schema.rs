//! What a recording of ours holds: topics, schemas, the facts of the run.

use std::borrow::Cow;
use std::collections::BTreeMap;

use bus::message::VolumeHash;
use mcap::read::ChannelAccumulator;
use mcap::records::{self, Metadata, SchemaHeader};

use crate::descriptor;

/// The topic of the tracker's poses, `trocar.ToolPose`.
pub const TOOL_POSE: &str = "/tool_pose";
/// The topic of the simulated tool's true poses, `trocar.ToolPose`.
pub const GROUND_TRUTH: &str = "/ground_truth";
/// The topic of the same poses for Foxglove, `foxglove.FrameTransform`, valid ones only.
pub const TF: &str = "/tf";
/// The name of our lossless schema.
pub const POSE_SCHEMA: &str = "trocar.ToolPose";
/// The name of Foxglove's schema.
pub const TF_SCHEMA: &str = "foxglove.FrameTransform";
/// The attached scene file.
pub const SCENE: &str = "scene.toml";
/// The name of the metadata records with the run's facts. Written again when more is known: the last one counts.
pub const RUN: &str = "run";
/// Who wrote the file.
pub const LIBRARY: &str = concat!("trocar recorder ", env!("CARGO_PKG_VERSION"));

const PROTOBUF: &str = "protobuf";
const POSE_SCHEMA_ID: u16 = 1;
const TF_SCHEMA_ID: u16 = 2;
/// The channel of [`TF`].
pub(crate) const TF_CHANNEL: u16 = 3;

/// Which of the tool's poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The tracker's.
    Tool,
    /// The simulator's true one.
    Truth,
}

impl Source {
    /// The channel of its poses.
    pub(crate) const fn channel(self) -> u16 {
        match self {
            Self::Tool => 1,
            Self::Truth => 2,
        }
    }

    /// The topic of its poses.
    pub const fn topic(self) -> &'static str {
        match self {
            Self::Tool => TOOL_POSE,
            Self::Truth => GROUND_TRUTH,
        }
    }

    /// The name of its frame for Foxglove.
    pub(crate) const fn frame(self) -> &'static str {
        match self {
            Self::Tool => "tool",
            Self::Truth => "tool_truth",
        }
    }
}

/// The schemas: number, name, descriptor.
pub(crate) fn schemas() -> [(u16, &'static str, Vec<u8>); 2] {
    [
        (POSE_SCHEMA_ID, POSE_SCHEMA, descriptor::tool_pose()),
        (TF_SCHEMA_ID, TF_SCHEMA, descriptor::frame_transform()),
    ]
}

/// The channels, with their conventions in words for people who find the file alone.
pub(crate) fn channels() -> [records::Channel; 3] {
    let pose = "ct_from_tool, LPS; lengths mm, angles rad, stamps ns since the run's epoch; q is w, x, y, z";
    let tf = "ct_from_tool, LPS; lengths m";
    let channel = |id, schema_id, topic: &str, conventions: &str| records::Channel {
        id,
        schema_id,
        topic: topic.to_owned(),
        message_encoding: PROTOBUF.to_owned(),
        metadata: BTreeMap::from([("conventions".to_owned(), conventions.to_owned())]),
    };
    [
        channel(Source::Tool.channel(), POSE_SCHEMA_ID, TOOL_POSE, pose),
        channel(Source::Truth.channel(), POSE_SCHEMA_ID, GROUND_TRUTH, pose),
        channel(TF_CHANNEL, TF_SCHEMA_ID, TF, tf),
    ]
}

/// Schemas and channels as every file of this version has them: stands in where those of a file are damaged.
pub(crate) fn built_in() -> ChannelAccumulator<'static> {
    let mut built_in = ChannelAccumulator::default();
    for (id, name, data) in schemas() {
        let header = SchemaHeader {
            id,
            name: name.to_owned(),
            encoding: PROTOBUF.to_owned(),
        };
        // Neither can fail: the numbers are distinct, and the schemas come first.
        let _ = built_in.add_schema(header, Cow::Owned(data));
    }
    for channel in channels() {
        let _ = built_in.add_channel(channel);
    }
    built_in
}

/// What is known of the run; goes into the file as metadata named [`RUN`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunFacts {
    /// The run's name.
    pub name: String,
    /// CLOCK_MONOTONIC at the run's start, ns: the zero of all stamps.
    pub epoch_ns: i64,
    /// The registration that the poses rest on; known once there is a pose.
    pub registration_id: Option<u64>,
    /// The volume that was navigated in; known once it is loaded.
    pub volume_hash: Option<VolumeHash>,
}

impl RunFacts {
    /// The metadata record.
    pub fn metadata(&self) -> Metadata {
        let mut facts = BTreeMap::from([
            ("name".to_owned(), self.name.clone()),
            ("epoch_ns".to_owned(), self.epoch_ns.to_string()),
            ("software".to_owned(), LIBRARY.to_owned()),
        ]);
        if let Some(id) = self.registration_id {
            facts.insert("registration_id".to_owned(), format!("{id:016x}"));
        }
        if let Some(hash) = self.volume_hash {
            facts.insert("volume_hash".to_owned(), hash.to_string());
        }
        Metadata {
            name: RUN.to_owned(),
            metadata: facts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_channels_are_linked_to_their_schemas() {
        let built_in = built_in();
        for channel in channels() {
            let found = built_in.get(channel.id).unwrap();
            assert_eq!(found.topic, channel.topic);
            assert!(found.schema.is_some());
        }
    }
}
