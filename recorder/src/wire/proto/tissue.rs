//! Organs that a tube moves: their mesh and their states, without loss.

use bus::message::{MOST_ERRORS, PlaceError, TissueHeader, TissueMeshHeader};

use super::{DecodeError, values};
use crate::wire::schema::{TISSUE_MESH_SCHEMA, TISSUE_SCHEMA};

/// A state of the bus in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct TissueFrame {
    /// What it is of, and what certifies it.
    pub header: TissueHeader,
    /// Three for each node, mm in the mesh's frame; none without a state.
    pub nodes: Vec<f32>,
}

/// A mesh of the bus in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFrame {
    /// What it is of.
    pub header: TissueMeshHeader,
    /// The organs.
    pub bytes: Vec<u8>,
}

/// `trocar.TissueState`: every field of [`TissueHeader`], in its units, and the nodes.
#[derive(Clone, PartialEq, prost::Message)]
pub struct TissueState {
    /// See [`TissueHeader::seq`].
    #[prost(uint64, tag = "1")]
    pub seq: u64,
    /// See [`TissueHeader::pose_seq`].
    #[prost(uint64, tag = "2")]
    pub pose_seq: u64,
    /// See [`TissueHeader::t_capture_ns`].
    #[prost(sint64, tag = "3")]
    pub t_capture_ns: i64,
    /// See [`TissueHeader::registration_id`].
    #[prost(fixed64, tag = "4")]
    pub registration_id: u64,
    /// See [`TissueHeader::t_publish_ns`].
    #[prost(sint64, tag = "5")]
    pub t_publish_ns: i64,
    /// See [`TissueHeader::mesh_id`]: 32 bytes.
    #[prost(bytes = "vec", tag = "6")]
    pub mesh_id: Vec<u8>,
    /// See [`TissueHeader::factor`].
    #[prost(uint64, tag = "7")]
    pub factor: u64,
    /// See [`TissueHeader::state`].
    #[prost(uint32, tag = "8")]
    pub state: u32,
    /// See [`TissueHeader::steps`].
    #[prost(uint32, tag = "9")]
    pub steps: u32,
    /// Residual, what is unsettled, what is left, depth, least determinant, energy: 6 values.
    #[prost(double, repeated, tag = "10")]
    pub certificate: Vec<f64>,
    /// See [`TissueHeader::force`]: 3 values.
    #[prost(double, repeated, tag = "11")]
    pub force: Vec<f64>,
    /// See [`TissueHeader::moment`]: 3 values.
    #[prost(double, repeated, tag = "12")]
    pub moment: Vec<f64>,
    /// Little-endian 32-bit floats.
    #[prost(bytes = "vec", tag = "13")]
    pub nodes: Vec<u8>,
    /// See [`TissueHeader::errors_pose_seq`].
    #[prost(uint64, tag = "14")]
    pub errors_pose_seq: u64,
    /// See [`TissueHeader::errors_t_capture_ns`].
    #[prost(sint64, tag = "15")]
    pub errors_t_capture_ns: i64,
    /// See [`TissueHeader::errors`]: 9 values each, as many as there are.
    #[prost(double, repeated, tag = "16")]
    pub errors: Vec<f64>,
    /// See [`TissueHeader::why`].
    #[prost(string, tag = "17")]
    pub why: String,
    /// See [`TissueHeader::force_covariance`]: 6 values, or none where it is not known.
    #[prost(double, repeated, tag = "18")]
    pub force_covariance: Vec<f64>,
}

/// Values of a place with its covariance.
const OF_PLACE: usize = 9;

/// `trocar.TissueMesh`: every field of [`TissueMeshHeader`], and the organs' bytes.
#[derive(Clone, PartialEq, prost::Message)]
pub struct TissueMesh {
    /// When it is written down, ns on the run's clock.
    #[prost(sint64, tag = "1")]
    pub t_ns: i64,
    /// See [`TissueMeshHeader::mesh_id`]: 32 bytes.
    #[prost(bytes = "vec", tag = "2")]
    pub mesh_id: Vec<u8>,
    /// See [`TissueMeshHeader::volume_hash`]: 32 bytes.
    #[prost(bytes = "vec", tag = "3")]
    pub volume_hash: Vec<u8>,
    /// See [`TissueMeshHeader::q`]: 4 values.
    #[prost(double, repeated, tag = "4")]
    pub q: Vec<f64>,
    /// See [`TissueMeshHeader::t_mm`]: 3 values.
    #[prost(double, repeated, tag = "5")]
    pub t_mm: Vec<f64>,
    /// See [`TissueMeshHeader::organs`].
    #[prost(uint64, tag = "6")]
    pub organs: u64,
    /// See [`bus::message::TissueMesh`].
    #[prost(bytes = "vec", tag = "7")]
    pub data: Vec<u8>,
}

impl From<&TissueFrame> for TissueState {
    fn from(frame: &TissueFrame) -> Self {
        let header = &frame.header;
        Self {
            seq: header.seq,
            pose_seq: header.pose_seq,
            t_capture_ns: header.t_capture_ns,
            registration_id: header.registration_id,
            t_publish_ns: header.t_publish_ns,
            mesh_id: header.mesh_id.to_vec(),
            factor: header.factor,
            state: header.state,
            steps: header.steps,
            certificate: vec![
                header.residual,
                header.unsettled_mm,
                header.left_mm,
                header.depth_mm,
                header.least_determinant,
                header.energy,
            ],
            force: header.force.to_vec(),
            moment: header.moment.to_vec(),
            nodes: frame.nodes.iter().flat_map(|x| x.to_le_bytes()).collect(),
            errors_pose_seq: header.errors_pose_seq,
            errors_t_capture_ns: header.errors_t_capture_ns,
            errors: header.errors[..known(header)]
                .iter()
                .flat_map(|error| error.at_rest_mm.into_iter().chain(error.covariance))
                .collect(),
            why: header.why().to_owned(),
            force_covariance: match header.force_error_known {
                1 => header.force_covariance.to_vec(),
                _ => Vec::new(),
            },
        }
    }
}

/// How many errors a state tells; none where it says more than there can be.
fn known(header: &TissueHeader) -> usize {
    let known = usize::try_from(header.errors_known).unwrap_or(usize::MAX);
    if known > MOST_ERRORS { 0 } else { known }
}

/// The errors in recorded values.
fn errors(seq: u64, recorded: &[f64]) -> Result<([PlaceError; MOST_ERRORS], u64), DecodeError> {
    let (places, rest) = recorded.as_chunks::<OF_PLACE>();
    if !rest.is_empty() || places.len() > MOST_ERRORS {
        return Err(DecodeError::Length {
            seq,
            field: "errors",
            expected: OF_PLACE * places.len().min(MOST_ERRORS),
            found: recorded.len(),
        });
    }
    let mut errors = [PlaceError::default(); MOST_ERRORS];
    for (error, [x, y, z, covariance @ ..]) in errors.iter_mut().zip(places) {
        (error.at_rest_mm, error.covariance) = ([*x, *y, *z], *covariance);
    }
    Ok((errors, places.len() as u64))
}

impl TryFrom<TissueState> for TissueFrame {
    type Error = DecodeError;

    fn try_from(state: TissueState) -> Result<Self, DecodeError> {
        let seq = state.seq;
        let [residual, unsettled_mm, left_mm, depth_mm, least_determinant, energy] =
            values(seq, "certificate", &state.certificate)?;
        let (nodes, rest) = state.nodes.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(DecodeError::Length {
                seq,
                field: "nodes",
                expected: 4 * (nodes.len() + 1),
                found: state.nodes.len(),
            });
        }
        let (errors, errors_known) = errors(seq, &state.errors)?;
        let (force_covariance, force_error_known) = match state.force_covariance.is_empty() {
            true => ([0.0; 6], 0),
            false => (values(seq, "force_covariance", &state.force_covariance)?, 1),
        };
        let header = TissueHeader {
            seq,
            pose_seq: state.pose_seq,
            t_capture_ns: state.t_capture_ns,
            t_publish_ns: state.t_publish_ns,
            registration_id: state.registration_id,
            mesh_id: values(seq, "mesh_id", &state.mesh_id)?,
            factor: state.factor,
            residual,
            unsettled_mm,
            left_mm,
            force: values(seq, "force", &state.force)?,
            moment: values(seq, "moment", &state.moment)?,
            depth_mm,
            least_determinant,
            energy,
            steps: state.steps,
            state: state.state,
            errors_pose_seq: state.errors_pose_seq,
            errors_t_capture_ns: state.errors_t_capture_ns,
            errors_known,
            errors,
            force_covariance,
            force_error_known,
            ..TissueHeader::default()
        };
        Ok(Self {
            header: header.because(&state.why),
            nodes: nodes.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect(),
        })
    }
}

impl TissueMesh {
    /// The message, written down at `t_ns` of the run's clock.
    pub fn of(t_ns: i64, mesh: &MeshFrame) -> Self {
        Self {
            t_ns,
            mesh_id: mesh.header.mesh_id.to_vec(),
            volume_hash: mesh.header.volume_hash.to_vec(),
            q: mesh.header.q.to_vec(),
            t_mm: mesh.header.t_mm.to_vec(),
            organs: mesh.header.organs,
            data: mesh.bytes.clone(),
        }
    }
}

impl TryFrom<TissueMesh> for MeshFrame {
    type Error = DecodeError;

    fn try_from(mesh: TissueMesh) -> Result<Self, DecodeError> {
        // A mesh has no number.
        let header = TissueMeshHeader {
            mesh_id: values(0, "mesh_id", &mesh.mesh_id)?,
            volume_hash: values(0, "volume_hash", &mesh.volume_hash)?,
            q: values(0, "q", &mesh.q)?,
            t_mm: values(0, "t_mm", &mesh.t_mm)?,
            organs: mesh.organs,
        };
        Ok(Self {
            header,
            bytes: mesh.data,
        })
    }
}

/// The state in the bytes of a recorded `trocar.TissueState`.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_tissue(bytes: &[u8]) -> Result<TissueFrame, DecodeError> {
    decoded::<TissueState>(bytes, TISSUE_SCHEMA)?.try_into()
}

/// The mesh in the bytes of a recorded `trocar.TissueMesh`; whether it is what its id says is for who takes it from the bus to say.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_mesh(bytes: &[u8]) -> Result<MeshFrame, DecodeError> {
    decoded::<TissueMesh>(bytes, TISSUE_MESH_SCHEMA)?.try_into()
}

fn decoded<M: prost::Message + Default>(bytes: &[u8], schema: &'static str) -> Result<M, DecodeError> {
    M::decode(bytes).map_err(|source| DecodeError::Protobuf { schema, source })
}

#[cfg(test)]
mod tests;
