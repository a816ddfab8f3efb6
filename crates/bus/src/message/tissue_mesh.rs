//! The organs that a tube moves, at rest: cubes of 27 nodes and where each organ is.
//!
//! Behind the header lie the organs, one after the other, little-endian: name (32 bytes), nodes, cubes, the region's numbers of values
//! along its axes (`u32` each), its first value's place and step (`f64`), each cube (corner and side as `f64`, 27 nodes as `u32`), and
//! the region's values (`f32`, fastest along x).

mod bytes;

use geometry::{Ct, DoorError, Model, Rigid, checked};
use iceoryx2::prelude::ZeroCopySend;

use bytes::{Reader, organ_bytes};

/// Travels in front of the organs' bytes.
///
/// On the wire: numbers only. Read it through [`TissueMesh::read`].
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/TissueMeshHeader/1")]
pub struct TissueMeshHeader {
    /// BLAKE3 of everything else that this header says, and of the bytes behind it.
    pub mesh_id: [u8; 32],
    /// The examination whose organs they are.
    pub volume_hash: [u8; 32],
    /// Unit quaternion (w, x, y, z) of `ct_from_model`.
    pub q: [f64; 4],
    /// Translation of `ct_from_model`, mm.
    pub t_mm: [f64; 3],
    /// How many organs there are.
    pub organs: u64,
}

const _: () = assert!(size_of::<TissueMeshHeader>() == 128 && align_of::<TissueMeshHeader>() == 8);

/// A cube of 27 nodes along the model's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshCube {
    /// Its lowest corner at rest, mm in the model's frame.
    pub low: [f64; 3],
    /// Its side, mm.
    pub side: f64,
    /// Its nodes, fastest along x, then y, then z.
    pub nodes: [u32; 27],
}

/// An organ at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOrgan {
    /// Its name, at most 32 bytes of UTF-8.
    pub name: String,
    /// How many nodes it has.
    pub nodes: u32,
    /// Its cubes.
    pub cubes: Vec<MeshCube>,
    /// Where the first value of its region lies, mm in the model's frame.
    pub region_origin: [f64; 3],
    /// From one value to the next, mm.
    pub region_step_mm: f64,
    /// Values along the axes.
    pub region_dims: [u32; 3],
    /// Negative where the organ is at rest; fastest along x.
    pub region: Vec<f32>,
}

/// The organs that a tube moves, at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct TissueMesh {
    /// From the model's frame to the patient.
    pub ct_from_model: Rigid<Ct, Model>,
    /// The examination whose organs they are.
    pub volume_hash: [u8; 32],
    /// The organs; places of [`super::TissueHeader`] come in their order.
    pub organs: Vec<MeshOrgan>,
}

/// Why bytes are no organs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TissueMeshError {
    /// The bytes end before what they promise.
    #[error("the mesh of the tissue, byte {at}: {what} takes {expected} bytes; {left} are left")]
    Short {
        /// Where.
        at: usize,
        /// Of what.
        what: &'static str,
        /// How many.
        expected: u64,
        /// How many there are.
        left: usize,
    },
    /// There is more than organs.
    #[error("the mesh of the tissue: {0} bytes behind its last organ")]
    Long(usize),
    /// A number out of range.
    #[error("the mesh of the tissue, organ {organ}: {what} is {found}; {allowed} allowed")]
    Number {
        /// From 0.
        organ: usize,
        /// Which.
        what: &'static str,
        /// Its value.
        found: u64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Not what its id says.
    #[error("the mesh of the tissue is not the one that its id names")]
    Id,
    /// No place in the patient.
    #[error("the mesh of the tissue: {0}")]
    Placed(#[from] DoorError),
}

/// Organs of a mesh, at most.
pub(super) const MOST_ORGANS: u64 = 64;
/// As for poses: who makes a mesh normalises in f64.
const UNIT_TOLERANCE: f64 = 1e-9;

impl TissueMesh {
    /// Nodes of all organs.
    pub fn nodes(&self) -> usize {
        self.organs.iter().map(|organ| organ.nodes as usize).sum()
    }

    /// The message: what goes before, and the organs' bytes.
    pub fn write(&self) -> (TissueMeshHeader, Vec<u8>) {
        let mut bytes = Vec::new();
        self.organs.iter().for_each(|organ| organ_bytes(organ, &mut bytes));
        let mut header = TissueMeshHeader {
            mesh_id: [0; 32],
            volume_hash: self.volume_hash,
            q: self.ct_from_model.quaternion(),
            t_mm: self.ct_from_model.translation_mm(),
            organs: self.organs.len() as u64,
        };
        header.mesh_id = id(&header, &bytes);
        (header, bytes)
    }

    /// The mesh that a message is: the door from the bus.
    ///
    /// # Errors
    /// [`TissueMeshError`]; whether cubes and values are a shape is for who draws them to say.
    pub fn read(header: &TissueMeshHeader, bytes: &[u8]) -> Result<Self, TissueMeshError> {
        if id(header, bytes) != header.mesh_id {
            return Err(TissueMeshError::Id);
        }
        let ct_from_model = checked::rigid(header.q, header.t_mm, UNIT_TOLERANCE)?;
        let mut reader = Reader::new(bytes);
        let count = reader.limited((0, "organs"), header.organs, MOST_ORGANS, "1 to 64 are")?;
        let organs: Result<Vec<_>, _> = (0..count).map(|organ| reader.organ(organ as usize)).collect();
        let organs = organs?;
        match reader.left() {
            0 => Ok(Self {
                ct_from_model,
                volume_hash: header.volume_hash,
                organs,
            }),
            left => Err(TissueMeshError::Long(left)),
        }
    }
}

/// Of what a header says but its id, and of what lies behind it.
fn id(header: &TissueMeshHeader, bytes: &[u8]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new_derive_key("trocar tissue mesh 1");
    hasher.update(&bytemuck::bytes_of(header)[32..]);
    hasher.update(bytes);
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> TissueMesh {
        let organ = |name: &str, nodes: u32| MeshOrgan {
            name: name.to_owned(),
            nodes,
            cubes: (0..2)
                .map(|k| MeshCube {
                    low: [f64::from(k) * 4.0, 1.0, -2.5],
                    side: 4.0,
                    nodes: std::array::from_fn(|n| n as u32 + 18 * k),
                })
                .collect(),
            region_origin: [0.5, 0.25, 1e3],
            region_step_mm: 1.5,
            region_dims: [2, 2, 3],
            region: (0..12).map(|k| k as f32 - 5.5).collect(),
        };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        TissueMesh {
            ct_from_model: checked::rigid([half, half, 0.0, 0.0], [1.0, -2.0, 3.0], 1e-9).unwrap(),
            volume_hash: [7; 32],
            organs: vec![organ("right kidney", 45), organ("Milz", 46)],
        }
    }

    #[test]
    fn organs_come_back_bit_for_bit() {
        let (header, bytes) = mesh().write();
        assert_eq!(TissueMesh::read(&header, &bytes), Ok(mesh()));
        assert_eq!(mesh().nodes(), 91);
    }

    #[test]
    fn no_changed_byte_and_no_cut_is_taken() {
        let (header, bytes) = mesh().write();
        for at in 0..bytes.len() {
            let mut other = bytes.clone();
            other[at] ^= 1;
            assert_eq!(TissueMesh::read(&header, &other), Err(TissueMeshError::Id), "{at}");
            assert_eq!(TissueMesh::read(&header, &bytes[..at]), Err(TissueMeshError::Id));
        }
        let moved = TissueMeshHeader {
            t_mm: [1.0, -2.0, 3.5],
            ..header
        };
        assert_eq!(TissueMesh::read(&moved, &bytes), Err(TissueMeshError::Id));
    }

    /// Bytes whose id is right may promise what they do not hold, and nothing is taken for it.
    #[test]
    fn what_is_promised_and_not_there_is_refused_by_name() {
        let (header, bytes) = mesh().write();
        let why = |header: TissueMeshHeader, bytes: &[u8]| {
            let header = TissueMeshHeader {
                mesh_id: id(&header, bytes),
                ..header
            };
            TissueMesh::read(&header, bytes).unwrap_err().to_string()
        };
        (0..bytes.len()).for_each(|at| assert!(why(header, &bytes[..at]).contains("are left"), "{at}"));
        assert!(why(header, &[&bytes[..], &[0]].concat()).contains("1 bytes behind"));
        assert!(
            why(
                TissueMeshHeader {
                    organs: u64::MAX,
                    ..header
                },
                &bytes
            )
            .contains("organs is")
        );
        assert!(
            why(
                TissueMeshHeader {
                    q: [0.9, 0.0, 0.0, 0.0],
                    ..header
                },
                &bytes
            )
            .contains("quaternion")
        );
        // 55 nodes of two cubes: more than there can be.
        let mut many = bytes.clone();
        many[32..36].copy_from_slice(&55_u32.to_le_bytes());
        assert!(
            why(header, &many).contains("no more than 27 a cube"),
            "{}",
            why(header, &many)
        );
        for (at, what) in [
            (32, "nodes"),
            (36, "cubes"),
            (40, "values of its region"),
            (48, "values of its region"),
        ] {
            let mut other = bytes.clone();
            other[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
            assert!(why(header, &other).contains(what), "{at}: {}", why(header, &other));
        }
    }
}
