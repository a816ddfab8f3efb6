//! Pieces of the organs at rest: the message's header and what lies behind it, one after the other, as many bytes as a piece of the voxels.

use bus::message::{TissueMeshHeader, Wire};

use super::PIECE_VALUES;

/// Bytes of a piece; the last has what is left.
const PIECE_BYTES: usize = 2 * PIECE_VALUES;

/// An answer about the organs at rest: how many bytes they are altogether, and a piece of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshPiece {
    /// Bytes of header and organs.
    pub total: usize,
    /// Those of the piece.
    pub bytes: Vec<u8>,
}

/// An answer that is no piece.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MeshPieceError {
    /// Too short to say how many there are.
    #[error("an answer of {0} bytes about organs at rest; at least 8 are expected")]
    Short(usize),
    /// More than any organs, or fewer.
    #[error(
        "organs at rest of {found} bytes; {} to {} are allowed",
        MeshPiece::LEAST,
        MeshPiece::MOST
    )]
    Total {
        /// What was said.
        found: u64,
    },
    /// Not as many as the piece has.
    #[error("piece {index} of organs at rest has {found} bytes; expected are {expected}")]
    Piece {
        /// From 0.
        index: u32,
        /// How many came.
        found: usize,
        /// How many it has.
        expected: usize,
    },
}

impl MeshPiece {
    /// Bytes of organs at rest, at least: the header.
    pub const LEAST: usize = size_of::<TissueMeshHeader>();
    /// At most.
    pub const MOST: usize = 256 << 20;

    /// Piece `index` of a message; `None` where there is no such piece.
    pub fn of(header: &TissueMeshHeader, behind: &[u8], index: u32) -> Option<Self> {
        let (head, total) = (header.wire_bytes(), Self::LEAST + behind.len());
        let range = range(index, total).filter(|_| total <= Self::MOST)?;
        let in_head = range.start.min(head.len())..range.end.min(head.len());
        let past = |at: usize| at.saturating_sub(head.len());
        let bytes = [&head[in_head], &behind[past(range.start)..past(range.end)]].concat();
        Some(Self { total, bytes })
    }

    /// As it goes over the link.
    pub fn wire(&self) -> Vec<u8> {
        [&(self.total as u64).to_le_bytes()[..], &self.bytes].concat()
    }

    /// The answer that `bytes` are, to a question for piece `index`.
    ///
    /// # Errors
    /// [`MeshPieceError`].
    pub fn read(bytes: &[u8], index: u32) -> Result<Self, MeshPieceError> {
        let (total, bytes) = bytes
            .split_first_chunk::<8>()
            .ok_or(MeshPieceError::Short(bytes.len()))?;
        let found = u64::from_le_bytes(*total);
        let total = usize::try_from(found).ok();
        let total = total.filter(|total| (Self::LEAST..=Self::MOST).contains(total));
        let total = total.ok_or(MeshPieceError::Total { found })?;
        let expected = range(index, total).map_or(0, |range| range.len());
        match bytes.len() == expected {
            true => Ok(Self {
                total,
                bytes: bytes.to_vec(),
            }),
            false => Err(MeshPieceError::Piece {
                index,
                found: bytes.len(),
                expected,
            }),
        }
    }
}

fn range(index: u32, total: usize) -> Option<std::ops::Range<usize>> {
    let from = (index as usize).checked_mul(PIECE_BYTES)?;
    (from < total).then(|| from..total.min(from.saturating_add(PIECE_BYTES)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_header_and_organs_once_and_in_their_order() {
        let header = TissueMeshHeader {
            mesh_id: [7; 32],
            organs: 3,
            ..TissueMeshHeader::default()
        };
        for behind in [0, 1, PIECE_BYTES - MeshPiece::LEAST, PIECE_BYTES, 3 * PIECE_BYTES + 5] {
            let organs: Vec<u8> = (0..behind).map(|at| (at % 251) as u8).collect();
            let mut came = Vec::new();
            let mut index = 0;
            while let Some(piece) = MeshPiece::of(&header, &organs, index) {
                assert_eq!(MeshPiece::read(&piece.wire(), index), Ok(piece.clone()));
                assert_eq!(piece.total, MeshPiece::LEAST + behind);
                came.extend(piece.bytes);
                index += 1;
            }
            assert_eq!(came, [header.wire_bytes(), &organs[..]].concat(), "{behind}");
        }
    }

    #[test]
    fn answers_that_are_no_piece_are_refused_by_name() {
        let piece = MeshPiece::of(&TissueMeshHeader::default(), &[1; 40], 0).unwrap();
        let why = |bytes: &[u8], index| MeshPiece::read(bytes, index).unwrap_err().to_string();
        let wire = piece.wire();
        assert!(why(&wire[..7], 0).contains("7 bytes about organs at rest"));
        assert!(why(&wire[..wire.len() - 1], 0).contains("has 167 bytes; expected are 168"));
        assert!(why(&wire, 1).contains("piece 1 of organs at rest has 168 bytes; expected are 0"));
        for total in [0_u64, 127, (256 << 20) + 1, u64::MAX] {
            let mut bad = wire.clone();
            bad[..8].copy_from_slice(&total.to_le_bytes());
            assert!(why(&bad, 0).contains(&format!("of {total} bytes; 128 to ")), "{total}");
        }
    }
}
