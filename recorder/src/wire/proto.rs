//! The messages in the file, as protobuf.
//!
//! [`ToolPose`] is ours and lossless: what was on the bus can be rebuilt from it bit for bit. [`FrameTransform`] is
//! Foxglove's, so that its viewer draws the tool; it is in **metres**, the only place of this crate that is.
//! [`EmitterFrame`] and [`MarkerFrame`] are what the localizer saw, [`RawImage`] what an ultrasound probe saw, [`TissueState`] and [`TissueMesh`]
//! where organs were, and [`Guide`] what a person chose, without loss too; the rest is for people.

use bus::message::{self, Tracked};
use prost_types::Timestamp;

mod emitters;
mod guide;
mod identity;
mod markers;
mod tissue;
mod us_image;
mod words;

pub use emitters::{EmitterFrame, decode_emitters};
pub use guide::{Guide, Workflow, decode_guide};
pub use identity::Identity;
pub use markers::{MarkerFrame, decode_markers};
pub use tissue::{MeshFrame, TissueFrame, TissueMesh, TissueState, decode_mesh, decode_tissue};
pub use us_image::{RawImage, UsFrame, decode_us_image};
pub use words::{CompressedImage, Log, ProcessStatus};

/// `trocar.ToolPose`: every field of [`bus::message::ToolPose`], in its units (ns, mm, rad).
#[derive(Clone, PartialEq, prost::Message)]
pub struct ToolPose {
    /// See [`message::ToolPose::seq`].
    #[prost(uint64, tag = "1")]
    pub seq: u64,
    /// See [`message::ToolPose::t_device_ns`].
    #[prost(sint64, tag = "2")]
    pub t_device_ns: i64,
    /// See [`message::ToolPose::t_capture_ns`].
    #[prost(sint64, tag = "3")]
    pub t_capture_ns: i64,
    /// See [`message::ToolPose::t_publish_ns`].
    #[prost(sint64, tag = "4")]
    pub t_publish_ns: i64,
    /// See [`message::ToolPose::registration_id`]. A hash: fixed width is shorter.
    #[prost(fixed64, tag = "5")]
    pub registration_id: u64,
    /// See [`message::ToolPose::status`].
    #[prost(uint32, tag = "6")]
    pub status: u32,
    /// See [`message::ToolPose::visible`].
    #[prost(uint32, tag = "7")]
    pub visible: u32,
    /// (w, x, y, z), 4 values.
    #[prost(double, repeated, tag = "8")]
    pub q: Vec<f64>,
    /// mm, 3 values.
    #[prost(double, repeated, tag = "9")]
    pub t_mm: Vec<f64>,
    /// 21 values.
    #[prost(double, repeated, tag = "10")]
    pub covariance: Vec<f64>,
    /// mm. Optional, because proto3 leaves out a plain 0 and takes -0.0 for one.
    #[prost(double, optional, tag = "11")]
    pub fre_rms_mm: Option<f64>,
    /// mm. See [`message::ToolPose::tip_mm`]. Left out by files of before: 0, with no flag that says it is known.
    #[prost(double, optional, tag = "12")]
    pub tip_mm: Option<f64>,
    /// See [`message::ToolPose::delay_ns`].
    #[prost(sint64, tag = "13")]
    pub delay_ns: i64,
    /// See [`message::ToolPose::used`].
    #[prost(uint32, tag = "14")]
    pub used: u32,
    /// See [`message::ToolPose::flags`].
    #[prost(uint32, tag = "15")]
    pub flags: u32,
}

/// The sequence number of a `trocar.ToolPose`, without the rest.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PoseSeq {
    /// See [`message::ToolPose::seq`].
    #[prost(uint64, tag = "1")]
    pub seq: u64,
}

/// `foxglove.Vector3`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Vector3 {
    /// x
    #[prost(double, tag = "1")]
    pub x: f64,
    /// y
    #[prost(double, tag = "2")]
    pub y: f64,
    /// z
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// `foxglove.Quaternion`: x, y, z, w.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Quaternion {
    /// x
    #[prost(double, tag = "1")]
    pub x: f64,
    /// y
    #[prost(double, tag = "2")]
    pub y: f64,
    /// z
    #[prost(double, tag = "3")]
    pub z: f64,
    /// w
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// `foxglove.FrameTransform`: `parent_from_child`, metres.
#[derive(Clone, PartialEq, prost::Message)]
pub struct FrameTransform {
    /// Since the run's epoch.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Name of the parent frame.
    #[prost(string, tag = "2")]
    pub parent_frame_id: String,
    /// Name of the child frame.
    #[prost(string, tag = "3")]
    pub child_frame_id: String,
    /// Metres.
    #[prost(message, optional, tag = "4")]
    pub translation: Option<Vector3>,
    /// The rotation.
    #[prost(message, optional, tag = "5")]
    pub rotation: Option<Quaternion>,
}

/// Why a recorded message cannot be turned back into the one it was.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DecodeError {
    /// Not protobuf, or not this message.
    #[error("not a {schema}: {source}")]
    Protobuf {
        /// What it should be.
        schema: &'static str,
        /// What is wrong.
        source: prost::DecodeError,
    },
    /// More emitters than a frame of the bus has room for.
    #[error(transparent)]
    TooMany(#[from] message::TooManyEmitters),
    /// Markers that no frame of the bus can hold.
    #[error(transparent)]
    Markers(#[from] message::MarkersError),
    /// A field with the wrong number of values.
    #[error("message {seq}: {field} has {found} values instead of {expected}")]
    Length {
        /// Which message.
        seq: u64,
        /// Which field.
        field: &'static str,
        /// Values that belong there.
        expected: usize,
        /// Values found.
        found: usize,
    },
}

impl From<&message::ToolPose> for ToolPose {
    fn from(pose: &message::ToolPose) -> Self {
        Self {
            seq: pose.seq,
            t_device_ns: pose.t_device_ns,
            t_capture_ns: pose.t_capture_ns,
            t_publish_ns: pose.t_publish_ns,
            registration_id: pose.registration_id,
            status: pose.status,
            visible: pose.visible,
            q: pose.q.to_vec(),
            t_mm: pose.t_mm.to_vec(),
            covariance: pose.covariance.to_vec(),
            fre_rms_mm: Some(pose.fre_rms_mm),
            tip_mm: Some(pose.tip_mm),
            delay_ns: pose.delay_ns,
            used: pose.used,
            flags: pose.flags,
        }
    }
}

impl TryFrom<&ToolPose> for message::ToolPose {
    type Error = DecodeError;

    fn try_from(pose: &ToolPose) -> Result<Self, DecodeError> {
        Ok(Self {
            seq: pose.seq,
            t_device_ns: pose.t_device_ns,
            t_capture_ns: pose.t_capture_ns,
            t_publish_ns: pose.t_publish_ns,
            registration_id: pose.registration_id,
            status: pose.status,
            visible: pose.visible,
            q: values(pose.seq, "q", &pose.q)?,
            t_mm: values(pose.seq, "t_mm", &pose.t_mm)?,
            covariance: values(pose.seq, "covariance", &pose.covariance)?,
            fre_rms_mm: values(pose.seq, "fre_rms_mm", pose.fre_rms_mm.as_slice()).map(|[fre]: [f64; 1]| fre)?,
            tip_mm: pose.tip_mm.unwrap_or(0.0),
            delay_ns: pose.delay_ns,
            used: pose.used,
            flags: pose.flags,
        })
    }
}

fn values<T: Copy, const N: usize>(seq: u64, field: &'static str, found: &[T]) -> Result<[T; N], DecodeError> {
    found.try_into().map_err(|_| DecodeError::Length {
        seq,
        field,
        expected: N,
        found: found.len(),
    })
}

/// The bus message in the bytes of a recorded `trocar.ToolPose`.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_pose(bytes: &[u8]) -> Result<message::ToolPose, DecodeError> {
    let pose: ToolPose = prost::Message::decode(bytes).map_err(|source| DecodeError::Protobuf {
        schema: crate::wire::schema::POSE_SCHEMA,
        source,
    })?;
    (&pose).try_into()
}

/// The pose for Foxglove: `ct_from_child`, with the translation turned from mm into metres. `None` where the pose is
/// lost or is none.
pub fn frame_transform_in_metres(pose: &message::ToolPose, child: &str) -> Option<FrameTransform> {
    let Ok(Tracked::Valid(ct_from_tool)) = pose.tracked() else {
        return None;
    };
    let [x, y, z] = ct_from_tool.translation_mm().map(|mm| mm / 1e3);
    let [qw, qx, qy, qz] = ct_from_tool.quaternion();
    Some(FrameTransform {
        timestamp: Some(timestamp(file_time(pose.t_capture_ns))),
        parent_frame_id: "ct".to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(Vector3 { x, y, z }),
        rotation: Some(Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        }),
    })
}

/// A stamp of the run's clock as the file's unsigned time: what lies before the run's epoch counts as the epoch. The
/// true stamp is in the message.
pub fn file_time(t_ns: i64) -> u64 {
    t_ns.max(0).unsigned_abs()
}

pub(crate) fn timestamp(t_ns: u64) -> Timestamp {
    const SECOND: u64 = 1_000_000_000;
    Timestamp {
        seconds: (t_ns / SECOND).cast_signed(),
        // Below 1e9.
        nanos: (t_ns % SECOND) as i32,
    }
}

#[cfg(test)]
mod tests;
