//! The schemas of the file: the `.proto` files of `recorder/proto`, which are the published contract, compiled to what an
//! MCAP schema of encoding `protobuf` is: a binary `FileDescriptorSet` with every imported file in it.
//!
//! The compiled ones stand beside them, so that building needs no compiler of protobuf; a test compiles them again.

/// The schema of [`crate::wire::proto::ToolPose`].
pub(crate) const TOOL_POSE: &[u8] = include_bytes!("../../proto/trocar/ToolPose.binpb");
/// The schema of [`crate::wire::proto::EmitterFrame`].
pub(crate) const EMITTER_FRAME: &[u8] = include_bytes!("../../proto/trocar/EmitterFrame.binpb");
/// The schema of [`crate::wire::proto::MarkerFrame`].
pub(crate) const MARKER_FRAME: &[u8] = include_bytes!("../../proto/trocar/MarkerFrame.binpb");
/// The schema of [`crate::wire::proto::Guide`].
pub(crate) const GUIDE: &[u8] = include_bytes!("../../proto/trocar/Guide.binpb");
/// The schema of [`crate::wire::proto::Workflow`].
pub(crate) const WORKFLOW: &[u8] = include_bytes!("../../proto/trocar/Workflow.binpb");
/// The schema of [`crate::wire::proto::TissueState`].
pub(crate) const TISSUE_STATE: &[u8] = include_bytes!("../../proto/trocar/TissueState.binpb");
/// The schema of [`crate::wire::proto::TissueMesh`].
pub(crate) const TISSUE_MESH: &[u8] = include_bytes!("../../proto/trocar/TissueMesh.binpb");
/// The schema of [`crate::wire::proto::ProcessStatus`].
pub(crate) const PROCESS_STATUS: &[u8] = include_bytes!("../../proto/trocar/ProcessStatus.binpb");
/// The schema of [`crate::wire::proto::Identity`].
pub(crate) const IDENTITY: &[u8] = include_bytes!("../../proto/trocar/Identity.binpb");
/// The schema of [`crate::wire::proto::FrameTransform`].
pub(crate) const FRAME_TRANSFORM: &[u8] = include_bytes!("../../proto/foxglove/FrameTransform.binpb");
/// The schema of [`crate::wire::proto::Log`].
pub(crate) const LOG: &[u8] = include_bytes!("../../proto/foxglove/Log.binpb");
/// The schema of [`crate::wire::proto::CompressedImage`].
pub(crate) const COMPRESSED_IMAGE: &[u8] = include_bytes!("../../proto/foxglove/CompressedImage.binpb");

/// The schema of [`crate::wire::proto::RawImage`].
pub(crate) const RAW_IMAGE: &[u8] = include_bytes!("../../proto/foxglove/RawImage.binpb");

#[cfg(test)]
mod tests;
