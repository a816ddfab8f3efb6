//! The organs at rest that the run's states are of, piece by piece.

use bus::message::TissueMeshHeader;
use bus::port::{Headed, HeadedSubscriber};
use bus::topic::TISSUE_MESH;
use bus::{Bus, BusError};

use crate::protocol::MeshPiece;

/// What the run publishes.
pub(super) struct Organs {
    meshes: HeadedSubscriber<TissueMeshHeader, u8>,
    newest: Option<Headed<TissueMeshHeader, u8>>,
}

impl Organs {
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            meshes: HeadedSubscriber::open(bus, &TISSUE_MESH, 1)?,
            newest: None,
        })
    }

    /// A piece of those of this id, as it goes over the link, or why there is none.
    pub(super) fn piece(&mut self, (id, index): ([u8; 32], u32)) -> Result<Vec<u8>, &'static str> {
        while let Some(mesh) = self.meshes.next().map_err(|_| "the bus gives no organs")? {
            self.newest = Some(mesh);
        }
        let mesh = self.newest.as_ref().filter(|mesh| mesh.header().mesh_id == id);
        let mesh = mesh.ok_or("the run has other organs by now")?;
        let piece = MeshPiece::of(mesh.header(), mesh.values(), index);
        Ok(piece.ok_or("the organs have no such piece")?.wire())
    }
}
