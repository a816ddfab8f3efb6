//! What a recording of ours holds: topics, schemas, the facts of the run.

use std::borrow::Cow;
use std::collections::BTreeMap;

use bus::message::VolumeHash;
use mcap::read::ChannelAccumulator;
use mcap::records::{self, Metadata, SchemaHeader};

use crate::wire::descriptor;

/// The topic of the tracker's poses, `trocar.ToolPose`.
pub const TOOL_POSE: &str = "/tool_pose";
/// The topic of the simulated tool's true poses, `trocar.ToolPose`.
pub const GROUND_TRUTH: &str = "/ground_truth";
/// The topic of the same poses for Foxglove, `foxglove.FrameTransform`, valid ones only.
pub const TF: &str = "/tf";
/// The topic of what the localizer saw, `trocar.EmitterFrame`.
pub const EMITTERS: &str = "/emitters";
/// The topic of the poses of markers that the localizer made, `trocar.MarkerFrame`.
pub const MARKERS: &str = "/markers";
/// The topic of the images of an ultrasound probe, `foxglove.RawImage`.
pub const US_IMAGE: &str = "/us_image";
/// The topic of where organs are that a tube moves, `trocar.TissueState`.
pub const TISSUE: &str = "/tissue";
/// The topic of the organs at rest, `trocar.TissueMesh`.
pub const TISSUE_MESH: &str = "/tissue_mesh";
/// The topic of the processes' states, `trocar.ProcessStatus`, where they change.
pub const STATUS: &str = "/status";
/// The topic of what a person chose and held, `trocar.Guide`, where it changes.
pub const GUIDE: &str = "/guide";
/// The topic of how far the run had come, `trocar.Workflow`, where it changes.
pub const WORKFLOW: &str = "/workflow";
/// The topic of what happened, in words, `foxglove.Log`.
pub const LOG: &str = "/log";
/// The topic of whose examination it is, `trocar.Identity`: only where the scene asks for it.
pub const IDENTITY: &str = "/identity";
/// In front of the name of a view: the topic of its small images, `foxglove.CompressedImage`.
pub const VIEW: &str = "/view/";
/// The name of our lossless schema of emitters.
pub const EMITTER_SCHEMA: &str = "trocar.EmitterFrame";
/// The name of our lossless schema of markers.
pub const MARKER_SCHEMA: &str = "trocar.MarkerFrame";
/// The name of our lossless schema of states of organs.
pub const TISSUE_SCHEMA: &str = "trocar.TissueState";
/// The name of our lossless schema of organs at rest.
pub const TISSUE_MESH_SCHEMA: &str = "trocar.TissueMesh";
/// The name of Foxglove's schema of images as they came, with ours of an ultrasound image beside.
pub const RAW_IMAGE_SCHEMA: &str = "foxglove.RawImage";
/// The name of our lossless schema.
pub const POSE_SCHEMA: &str = "trocar.ToolPose";
/// The name of our lossless schema of what was chosen.
pub const GUIDE_SCHEMA: &str = "trocar.Guide";
/// The name of our schema of how far a run had come.
pub const WORKFLOW_SCHEMA: &str = "trocar.Workflow";
/// The name of our schema of states.
pub const STATUS_SCHEMA: &str = "trocar.ProcessStatus";
/// The name of our schema of whose examination it is.
pub const IDENTITY_SCHEMA: &str = "trocar.Identity";
/// The name of Foxglove's schema of lines of a log.
pub const LOG_SCHEMA: &str = "foxglove.Log";
/// The name of Foxglove's schema of images.
pub const IMAGE_SCHEMA: &str = "foxglove.CompressedImage";
/// The name of Foxglove's schema.
pub const TF_SCHEMA: &str = "foxglove.FrameTransform";
/// The attached scene file.
pub const SCENE: &str = "scene.toml";
/// The name of the metadata records with the run's facts. Written again when more is known: the last one counts.
pub const RUN: &str = "run";
/// How the header's `library` of every recording begins that any version of this recorder wrote.
pub const LIBRARIES: &str = "trocar recorder ";
/// Who wrote the file.
pub const LIBRARY: &str = concat!("trocar recorder ", env!("CARGO_PKG_VERSION"));

pub(crate) const PROTOBUF: &str = "protobuf";
const POSE_SCHEMA_ID: u16 = 1;
const TF_SCHEMA_ID: u16 = 2;
const EMITTER_SCHEMA_ID: u16 = 3;
const STATUS_SCHEMA_ID: u16 = 4;
const LOG_SCHEMA_ID: u16 = 5;
const IMAGE_SCHEMA_ID: u16 = 6;
const IDENTITY_SCHEMA_ID: u16 = 9;
const GUIDE_SCHEMA_ID: u16 = 7;
const WORKFLOW_SCHEMA_ID: u16 = 8;
const MARKER_SCHEMA_ID: u16 = 10;
const RAW_IMAGE_SCHEMA_ID: u16 = 11;
const TISSUE_SCHEMA_ID: u16 = 12;
const TISSUE_MESH_SCHEMA_ID: u16 = 13;
/// The channel of [`TF`].
pub(crate) const TF_CHANNEL: u16 = 3;
/// The channel of [`EMITTERS`].
pub(crate) const EMITTER_CHANNEL: u16 = 4;
/// The channel of [`STATUS`].
pub(crate) const STATUS_CHANNEL: u16 = 5;
/// The channel of [`LOG`].
pub(crate) const LOG_CHANNEL: u16 = 6;
/// The channel of [`IDENTITY`].
pub(crate) const IDENTITY_CHANNEL: u16 = 9;
/// The channel of [`GUIDE`].
pub(crate) const GUIDE_CHANNEL: u16 = 7;
/// The channel of [`WORKFLOW`].
pub(crate) const WORKFLOW_CHANNEL: u16 = 8;
/// The channel of [`MARKERS`].
pub(crate) const MARKER_CHANNEL: u16 = 10;
/// The channel of [`US_IMAGE`].
pub(crate) const US_IMAGE_CHANNEL: u16 = 11;
/// The channel of [`TISSUE`].
pub(crate) const TISSUE_CHANNEL: u16 = 12;
/// The channel of [`TISSUE_MESH`].
pub(crate) const TISSUE_MESH_CHANNEL: u16 = 13;
/// The channel of the first of the [`VIEW`]s; those of the others follow.
pub(crate) const VIEW_CHANNEL: u16 = 16;

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
pub(crate) fn schemas() -> [(u16, &'static str, &'static [u8]); 12] {
    [
        (POSE_SCHEMA_ID, POSE_SCHEMA, descriptor::TOOL_POSE),
        (TF_SCHEMA_ID, TF_SCHEMA, descriptor::FRAME_TRANSFORM),
        (EMITTER_SCHEMA_ID, EMITTER_SCHEMA, descriptor::EMITTER_FRAME),
        (STATUS_SCHEMA_ID, STATUS_SCHEMA, descriptor::PROCESS_STATUS),
        (LOG_SCHEMA_ID, LOG_SCHEMA, descriptor::LOG),
        (IMAGE_SCHEMA_ID, IMAGE_SCHEMA, descriptor::COMPRESSED_IMAGE),
        (GUIDE_SCHEMA_ID, GUIDE_SCHEMA, descriptor::GUIDE),
        (WORKFLOW_SCHEMA_ID, WORKFLOW_SCHEMA, descriptor::WORKFLOW),
        (MARKER_SCHEMA_ID, MARKER_SCHEMA, descriptor::MARKER_FRAME),
        (RAW_IMAGE_SCHEMA_ID, RAW_IMAGE_SCHEMA, descriptor::RAW_IMAGE),
        (TISSUE_SCHEMA_ID, TISSUE_SCHEMA, descriptor::TISSUE_STATE),
        (TISSUE_MESH_SCHEMA_ID, TISSUE_MESH_SCHEMA, descriptor::TISSUE_MESH),
    ]
}

fn channel(id: u16, schema_id: u16, topic: &str, conventions: &str) -> records::Channel {
    records::Channel {
        id,
        schema_id,
        topic: topic.to_owned(),
        message_encoding: PROTOBUF.to_owned(),
        metadata: BTreeMap::from([("conventions".to_owned(), conventions.to_owned())]),
    }
}

/// The channels that every file has, with their conventions in words for people who find the file alone.
pub(crate) fn channels() -> Vec<records::Channel> {
    let pose = "ct_from_tool, LPS; lengths mm, angles rad, stamps ns since the run's epoch; q is w, x, y, z";
    let emitters = "places in the localizer's frame, mm, x y z for each emitter; stamps ns since the run's epoch";
    let markers =
        "tracker_from_marker; lengths mm, stamps ns since the run's epoch but the device's own; q is w, x, y, z";
    let guide = "places in the CT's frame, LPS, mm; stamps ns since the run's epoch; each holds from its t_ns on";
    let images =
        "grey values as they came; lengths mm, angles rad, stamps ns since the run's epoch but the device's own";
    let tissue = "nodes in the mesh's frame, forces in the CT's axes, LPS; lengths mm, forces N, stamps ns since the run's epoch";
    let mesh = "ct_from_model, LPS; lengths mm; q is w, x, y, z";
    let stamps = "stamps since the run's epoch";
    vec![
        channel(Source::Tool.channel(), POSE_SCHEMA_ID, TOOL_POSE, pose),
        channel(Source::Truth.channel(), POSE_SCHEMA_ID, GROUND_TRUTH, pose),
        channel(TF_CHANNEL, TF_SCHEMA_ID, TF, "ct_from_tool, LPS; lengths m"),
        channel(EMITTER_CHANNEL, EMITTER_SCHEMA_ID, EMITTERS, emitters),
        channel(STATUS_CHANNEL, STATUS_SCHEMA_ID, STATUS, stamps),
        channel(LOG_CHANNEL, LOG_SCHEMA_ID, LOG, stamps),
        channel(GUIDE_CHANNEL, GUIDE_SCHEMA_ID, GUIDE, guide),
        channel(WORKFLOW_CHANNEL, WORKFLOW_SCHEMA_ID, WORKFLOW, stamps),
        channel(MARKER_CHANNEL, MARKER_SCHEMA_ID, MARKERS, markers),
        channel(US_IMAGE_CHANNEL, RAW_IMAGE_SCHEMA_ID, US_IMAGE, images),
        channel(TISSUE_CHANNEL, TISSUE_SCHEMA_ID, TISSUE, tissue),
        channel(TISSUE_MESH_CHANNEL, TISSUE_MESH_SCHEMA_ID, TISSUE_MESH, mesh),
    ]
}

/// The schema and the channel of whose examination it is, for a file that is asked to say so; no other has them.
pub(crate) fn identity() -> ((u16, &'static str, &'static [u8]), records::Channel) {
    let conventions = "stamps ns since the run's epoch; days YYYY-MM-DD";
    (
        (IDENTITY_SCHEMA_ID, IDENTITY_SCHEMA, descriptor::IDENTITY),
        channel(IDENTITY_CHANNEL, IDENTITY_SCHEMA_ID, IDENTITY, conventions),
    )
}

/// The channels of the views' small images.
pub(crate) fn view_channels<'a>(views: impl Iterator<Item = &'a str>) -> Vec<records::Channel> {
    let channel = |(id, view)| {
        let conventions = "a small copy of what was shown; its stamp is in the PNG's texts";
        channel(id, IMAGE_SCHEMA_ID, &format!("{VIEW}{view}"), conventions)
    };
    (VIEW_CHANNEL..).zip(views).map(channel).collect()
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
        let _ = built_in.add_schema(header, Cow::Borrowed(data));
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
    /// The recording of whose emitters the poses were made again; `None` in a run that navigates.
    pub remade_from: Option<String>,
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
        if let Some(recording) = &self.remade_from {
            facts.insert("remade_from".to_owned(), recording.clone());
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
