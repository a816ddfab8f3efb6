//! Messages as bytes, for another machine.
//!
//! The bytes are those that lie in shared memory, little-endian. Their numbers are as hostile as any from outside: each message
//! has its door, which judges them there as here ([`super::ToolPose::tracked_at`] and its like).

use bytemuck::Pod;
use iceoryx2::prelude::ZeroCopySend;

use super::{Event, Guide, Identity, MarkerFrame, TissueHeader, TissueMeshHeader, ToolPose, VolumeHeader, Workflow};

/// A message that may leave the machine. It has no padding, so that every bit of it is told.
pub trait Wire: ZeroCopySend + Pod {
    /// The message as bytes.
    fn wire_bytes(&self) -> &[u8] {
        bytemuck::bytes_of(self)
    }

    /// The message that `bytes` are.
    ///
    /// # Errors
    /// [`WireError`] where they are too few or too many.
    fn from_wire(bytes: &[u8]) -> Result<Self, WireError> {
        bytemuck::try_pod_read_unaligned(bytes).map_err(|_| WireError {
            message: std::any::type_name::<Self>().rsplit("::").next().unwrap_or_default(),
            expected: size_of::<Self>(),
            found: bytes.len(),
        })
    }
}

/// Stored voxels as bytes.
pub fn voxel_bytes(voxels: &[i16]) -> &[u8] {
    bytemuck::cast_slice(voxels)
}

/// Writes the voxels that `bytes` are over `voxels`.
///
/// # Errors
/// [`WireError`] where there are more or fewer of them, and nothing is written.
pub fn voxels_from(bytes: &[u8], voxels: &mut [i16]) -> Result<(), WireError> {
    let expected = size_of_val(voxels);
    if bytes.len() != expected {
        return Err(WireError {
            message: "voxels",
            expected,
            found: bytes.len(),
        });
    }
    bytemuck::cast_slice_mut::<i16, u8>(voxels).copy_from_slice(bytes);
    Ok(())
}

/// Coordinates of a state's nodes as bytes.
pub fn node_bytes(nodes: &[f32]) -> &[u8] {
    bytemuck::cast_slice(nodes)
}

/// The coordinates that `bytes` are.
///
/// # Errors
/// [`WireError`] where the last is cut.
pub fn nodes_from(bytes: &[u8]) -> Result<Vec<f32>, WireError> {
    let (whole, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(WireError {
            message: "coordinates",
            expected: size_of_val(whole) + 4,
            found: bytes.len(),
        });
    }
    Ok(whole.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
}

/// Bytes that are no message of the kind that was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{found} bytes are no {message}, which has {expected}")]
pub struct WireError {
    /// The kind.
    pub message: &'static str,
    /// How many bytes it has.
    pub expected: usize,
    /// How many there are.
    pub found: usize,
}

// Both ends would have to turn every number round otherwise, and no machine of this kind is big-endian.
const _: () = assert!(cfg!(target_endian = "little"));

impl Wire for ToolPose {}
impl Wire for Guide {}
impl Wire for Workflow {}
impl Wire for Identity {}
impl Wire for Event {}
impl Wire for MarkerFrame {}
impl Wire for VolumeHeader {}
impl Wire for TissueHeader {}
impl Wire for TissueMeshHeader {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Level;

    #[test]
    fn a_message_comes_back_bit_for_bit_and_a_cut_one_is_refused_by_name() {
        let pose = ToolPose {
            seq: 7,
            t_mm: [-0.0, f64::MIN_POSITIVE, 1e300],
            ..ToolPose::EMPTY
        };
        let back = ToolPose::from_wire(pose.wire_bytes()).unwrap();
        assert_eq!(back.wire_bytes(), pose.wire_bytes());
        let event = Event::new(3, 5, Level::Warning, "words");
        assert_eq!(Event::from_wire(event.wire_bytes()).unwrap(), event);
        let error = ToolPose::from_wire(&pose.wire_bytes()[1..]).unwrap_err();
        assert_eq!(error.to_string(), "303 bytes are no ToolPose, which has 304");
        assert!(ToolPose::from_wire(&[0; 305]).is_err());
    }

    #[test]
    fn voxels_come_back_and_a_cut_piece_writes_nothing() {
        let mut back = [7; 3];
        voxels_from(voxel_bytes(&[-32_768, 0, 32_767]), &mut back).unwrap();
        assert_eq!(back, [-32_768, 0, 32_767]);
        let error = voxels_from(&[0; 5], &mut back).unwrap_err();
        assert_eq!((error.found, error.expected, back[0]), (5, 6, -32_768));
    }

    #[test]
    fn coordinates_come_back_bit_for_bit_and_a_cut_one_is_refused() {
        let nodes = [1.5, -0.0, f32::MIN_POSITIVE, f32::from_bits(0x7fc0_1234)];
        let bits = |nodes: &[f32]| nodes.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&nodes_from(node_bytes(&nodes)).unwrap()), bits(&nodes));
        assert_eq!(nodes_from(&[]), Ok(Vec::new()));
        let error = nodes_from(&[0; 7]).unwrap_err();
        assert_eq!((error.found, error.expected), (7, 8));
    }
}
