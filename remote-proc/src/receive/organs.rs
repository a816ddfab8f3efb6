//! The organs that the run moves: those at rest are pulled once, when a state of them comes; then the states are published as they come.
//!
//! Until organs are here, and where they are refused, there is no state on this machine's bus, and images say so.

use std::time::Duration;

use bus::clock::{monotonic_ns, ns};
use bus::message::{
    TissueError, TissueHeader, TissueMesh, TissueMeshError, TissueMeshHeader, VolumeHash, Wire, WireError, nodes_from,
};
use bus::port::HeadedPublisher;
use bus::topic::{TISSUE, TISSUE_MESH};
use bus::{Bus, BusError};
use zenoh::Wait;
use zenoh::qos::{CongestionControl, Priority};

use super::inbox::{Inbox, Incoming, Promise, answer};
use crate::protocol::{MESH, MeshPiece, MeshPieceError};
use crate::session::Opened;

/// A piece that has not come after so long is asked for again.
const WITHIN: Duration = Duration::from_secs(20);
/// Behind a refusal.
const HOLD: Duration = Duration::from_millis(200);

/// What identifies organs at rest.
type MeshId = [u8; 32];

/// Why organs are not shown moved.
#[derive(Debug, thiserror::Error)]
enum NoOrgans {
    #[error(transparent)]
    Piece(#[from] MeshPieceError),
    #[error("organs at rest of {found} bytes; pieces before were of {expected}")]
    Total { found: usize, expected: usize },
    #[error(transparent)]
    Header(#[from] WireError),
    #[error(transparent)]
    Mesh(#[from] TissueMeshError),
    #[error("the organs that came are not those that the states are of: they were altered on the way")]
    Other,
    #[error("the organs are of another examination")]
    Examination,
}

/// Organs, and where their states go.
#[derive(Debug, Default)]
pub(super) struct Organs {
    there: Option<There>,
    coming: Option<Coming>,
    /// Those that are not shown, and why.
    refused: Option<(MeshId, String)>,
}

/// Organs that are on this machine's bus.
#[derive(Debug)]
struct There {
    id: MeshId,
    nodes: usize,
    meshes: HeadedPublisher<TissueMeshHeader, u8>,
    states: HeadedPublisher<TissueHeader, f32>,
}

/// Organs as far as they have come.
#[derive(Debug)]
struct Coming {
    id: MeshId,
    /// Header and what lies behind it.
    bytes: Vec<u8>,
    /// How many there will be; 0 before the first piece.
    total: usize,
    /// The next piece, and when it was asked for.
    next: u32,
    asked_ns: Option<i64>,
    hold_ns: i64,
    /// The sender's last refusal.
    why: Option<String>,
}

impl Coming {
    fn of(id: MeshId) -> Self {
        Self {
            id,
            bytes: Vec::new(),
            total: 0,
            next: 0,
            asked_ns: None,
            hold_ns: i64::MIN,
            why: None,
        }
    }

    /// Takes in the piece that was asked for; whether all is here.
    fn take(&mut self, piece: &MeshPiece) -> Result<bool, NoOrgans> {
        if self.next > 0 && piece.total != self.total {
            let (found, expected) = (piece.total, self.total);
            return Err(NoOrgans::Total { found, expected });
        }
        self.total = piece.total;
        self.bytes.extend_from_slice(&piece.bytes);
        (self.next, self.asked_ns, self.why) = (self.next + 1, None, None);
        Ok(self.bytes.len() == self.total)
    }

    /// The organs, where they are those that the states are of, and of this examination.
    fn read(&self, volume: VolumeHash) -> Result<(TissueMeshHeader, TissueMesh), NoOrgans> {
        let (head, behind) = self.bytes.split_at(MeshPiece::LEAST.min(self.bytes.len()));
        let header = TissueMeshHeader::from_wire(head)?;
        if header.mesh_id != self.id {
            return Err(NoOrgans::Other);
        }
        let mesh = TissueMesh::read(&header, behind)?;
        match mesh.volume_hash == volume.0 {
            true => Ok((header, mesh)),
            false => Err(NoOrgans::Examination),
        }
    }
}

impl There {
    /// Whether the organs of an earlier sender go first is for the caller: a topic has one publisher.
    fn publish(bus: &Bus, (header, mesh): (TissueMeshHeader, &TissueMesh), behind: &[u8]) -> Result<Self, BusError> {
        let nodes = mesh.nodes();
        let there = Self {
            id: header.mesh_id,
            nodes,
            meshes: HeadedPublisher::open(bus, &TISSUE_MESH, behind.len())?,
            states: HeadedPublisher::open(bus, &TISSUE, 3 * nodes)?,
        };
        there.meshes.send(header, behind)?;
        Ok(there)
    }
}

impl Organs {
    /// Publishes a state of the organs that are here, or begins to pull those that it is of. Why it is not published, in words.
    pub(super) fn state(&mut self, body: &[u8]) -> Result<Option<String>, BusError> {
        let (head, behind) = body.split_at(size_of::<TissueHeader>().min(body.len()));
        let read = TissueHeader::from_wire(head).and_then(|header| Ok((header, nodes_from(behind)?)));
        let (header, nodes) = match read {
            Ok(read) => read,
            Err(error) => return Ok(Some(error.to_string())),
        };
        let id = header.mesh_id;
        let Some(there) = self.there.as_ref().filter(|there| there.id == id) else {
            self.begin(id);
            return Ok(None);
        };
        if let Err(error) = judged(&header, &nodes, there) {
            return Ok(Some(error.to_string()));
        }
        there.states.send(header, &nodes)?;
        Ok(None)
    }

    fn begin(&mut self, id: MeshId) {
        let is_begun = self.coming.as_ref().is_some_and(|coming| coming.id == id);
        let is_refused = self.refused.as_ref().is_some_and(|(refused, _)| *refused == id);
        if !is_begun && !is_refused {
            (self.coming, self.refused) = (Some(Coming::of(id)), None);
        }
    }

    /// What was asked for over an earlier session does not come any more; what was refused may be another by now.
    pub(super) fn ask_anew(&mut self) {
        self.refused = None;
        if let Some(coming) = &mut self.coming {
            coming.asked_ns = None;
        }
    }

    /// Asks for what is missing, a piece at a time.
    pub(super) fn ask(&mut self, session: &Opened, inbox: &Inbox, now: i64) {
        let Some(coming) = &mut self.coming else { return };
        let waits = coming.asked_ns.is_some_and(|at_ns| now - at_ns < ns(WITHIN));
        if !waits && now >= coming.hold_ns {
            coming.asked_ns = Some(now);
            ask(session, inbox, coming.id, coming.next);
        }
    }

    /// Takes in a piece; once all are here and are what they should be, they are published. `volume` is the examination that is shown.
    pub(super) fn take(
        &mut self,
        bus: &Bus,
        ((id, index), answer): ((MeshId, u32), Result<Vec<u8>, String>),
        volume: VolumeHash,
    ) -> Result<(), BusError> {
        let Some(coming) = self
            .coming
            .as_mut()
            .filter(|coming| (coming.id, coming.next) == (id, index))
        else {
            return Ok(());
        };
        let bytes = match answer {
            Ok(bytes) => bytes,
            Err(why) => {
                (coming.asked_ns, coming.why) = (None, Some(why));
                coming.hold_ns = monotonic_ns().saturating_add(ns(HOLD));
                return Ok(());
            }
        };
        let taken = MeshPiece::read(&bytes, index).map_err(NoOrgans::from);
        let read = match taken.and_then(|piece| coming.take(&piece)) {
            Ok(false) => return Ok(()),
            Ok(true) => coming.read(volume),
            Err(error) => Err(error),
        };
        let Some(come) = self.coming.take() else { return Ok(()) };
        match read {
            Ok((header, mesh)) => {
                bus::stderr_line!("remote-proc: {} organs that move are here", mesh.organs.len());
                self.there = None;
                self.there = Some(There::publish(bus, (header, &mesh), &come.bytes[MeshPiece::LEAST..])?);
            }
            Err(error) => {
                bus::stderr_line!("remote-proc: error: {error}. Organs are shown at rest");
                self.refused = Some((come.id, error.to_string()));
            }
        }
        Ok(())
    }

    pub(super) fn serve_late_joiners(&self) {
        if let Some(there) = &self.there {
            there.meshes.serve_late_joiners();
            there.states.serve_late_joiners();
        }
    }

    /// What is not there yet, or why, in words.
    pub(super) fn words(&self) -> Option<String> {
        if let Some((_, why)) = &self.refused {
            return Some(format!("ORGANS AT REST: {why}"));
        }
        let coming = self.coming.as_ref()?;
        let why = coming.why.as_ref().map_or(String::new(), |why| format!(" ({why})"));
        let (came, total) = (coming.bytes.len() >> 10, coming.total >> 10);
        Some(format!("organs: {came} of {total} KiB{why}"))
    }
}

/// A state without nodes is none of any place; one with nodes has them all, each in a patient.
fn judged(header: &TissueHeader, nodes: &[f32], there: &There) -> Result<(), TissueError> {
    header.state_of()?;
    match nodes.is_empty() {
        true => Ok(()),
        false => header.places(nodes, (&there.id, there.nodes)).map(drop),
    }
}

fn ask(session: &Opened, inbox: &Inbox, id: MeshId, index: u32) {
    let of = move |answer| Incoming::Mesh(id, index, answer);
    let promise = Promise::of(inbox, of(Err("nobody answers".to_owned())));
    let asked = session
        .get(MESH)
        .payload([&id[..], &index.to_le_bytes()].concat())
        .timeout(WITHIN)
        .priority(Priority::DataLow)
        .congestion_control(CongestionControl::Block)
        .callback(move |reply| promise.keep(of(answer(reply))))
        .wait();
    if let Err(why) = asked {
        inbox.put(of(Err(why.to_string())));
    }
}
