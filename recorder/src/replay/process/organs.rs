//! Organs of a recording, for the renderers of its replay: the mesh that a state is of, then the state, then its pose.

use bus::message::{TissueHeader, TissueMesh, TissueMeshHeader};
use bus::port::HeadedPublisher;
use bus::topic::{TISSUE, TISSUE_MESH};
use bus::{Bus, BusError};

use crate::read::damage::OpenError;
use crate::read::seek::Session;
use crate::replay::process::ReplayError;
use crate::wire::proto::{MeshFrame, TissueFrame};
use crate::wire::schema::TISSUE as TISSUE_STATES;

/// Where states go, and the meshes that they are of.
#[derive(Debug)]
pub(super) struct Organs {
    /// Each once.
    known: Vec<MeshFrame>,
    meshes: HeadedPublisher<TissueMeshHeader, u8>,
    states: HeadedPublisher<TissueHeader, f32>,
    /// Coordinates that a state may have.
    room: usize,
    /// The mesh that was published last.
    told: Option<[u8; 32]>,
}

impl Organs {
    /// Of a recording that holds a mesh; what cannot be read of it is added to `unread`, in words.
    ///
    /// # Errors
    /// [`OpenError`], [`BusError::Open`].
    pub(super) fn open(bus: &Bus, session: &Session, unread: &mut Vec<String>) -> Result<Option<Self>, ReplayError> {
        let (known, room) = meshes(session, unread)?;
        let most = known.iter().map(|mesh| mesh.bytes.len()).max();
        let Some(most) = most else {
            if session.may_hold(TISSUE_STATES) {
                unread.push("states of the tissue without the organs that they are of".to_owned());
            }
            return Ok(None);
        };
        Ok(Some(Self {
            known,
            meshes: HeadedPublisher::open(bus, &TISSUE_MESH, most)?,
            states: HeadedPublisher::open(bus, &TISSUE, room)?,
            room,
            told: None,
        }))
    }

    /// Publishes a state, and before it its mesh where another was told last. A state of no mesh of the recording has no use.
    pub(super) fn send(&mut self, state: &TissueFrame) -> Result<(), BusError> {
        let id = state.header.mesh_id;
        let mesh = self.known.iter().find(|mesh| mesh.header.mesh_id == id);
        let Some(mesh) = mesh.filter(|_| state.nodes.len() <= self.room) else {
            return Ok(());
        };
        if self.told != Some(id) {
            self.meshes.send(mesh.header, &mesh.bytes)?;
            self.told = Some(id);
        }
        self.states.send(state.header, &state.nodes)
    }

    pub(super) fn serve_late_joiners(&self) {
        self.meshes.serve_late_joiners();
        self.states.serve_late_joiners();
    }
}

/// The meshes of a recording that are what their ids say, each once, and the most coordinates that a state of one has.
fn meshes(session: &Session, unread: &mut Vec<String>) -> Result<(Vec<MeshFrame>, usize), OpenError> {
    let found = session.meshes()?;
    unread.extend(found.unread);
    let (mut known, mut room) = (Vec::<MeshFrame>::new(), 0);
    for mesh in found.messages {
        if known.iter().any(|one| one.header.mesh_id == mesh.header.mesh_id) {
            continue;
        }
        match TissueMesh::read(&mesh.header, &mesh.bytes) {
            Ok(read) => {
                room = room.max(3 * read.nodes());
                known.push(mesh);
            }
            Err(error) => unread.push(error.to_string()),
        }
    }
    Ok((known, room))
}
