//! Whether recorded states of organs are what they are called: by what certifies each, and by the mesh that it is of.

use std::collections::BTreeMap;
use std::path::Path;

use bus::message::{TissueError, TissueHeader, TissueMesh, TissueState};
use scene::{Scene, raw};

use crate::wire::proto::{MeshFrame, TissueFrame};
use crate::wire::seq::SeqWatch;

/// A scene allows no more (`tissue.tolerance`): what settled states are held against before the recording's scene is known.
pub(crate) const MOST_TOLERANCE: f64 = 0.1;

/// States and meshes so far.
#[derive(Debug)]
pub(super) struct Organs {
    tolerance: f64,
    /// Nodes by the id of the mesh.
    meshes: BTreeMap<[u8; 32], usize>,
    /// Of states whose mesh did not come before them: the first of each mesh and number of coordinates.
    pending: BTreeMap<([u8; 32], usize), TissueHeader>,
    /// How many there are of each state, in the order of their codes.
    counts: [u64; 5],
    seqs: SeqWatch,
}

impl Default for Organs {
    fn default() -> Self {
        Self {
            tolerance: MOST_TOLERANCE,
            meshes: BTreeMap::new(),
            pending: BTreeMap::new(),
            counts: [0; 5],
            seqs: SeqWatch::default(),
        }
    }
}

impl Organs {
    /// Takes note of the run's scene; one that cannot be read says nothing.
    pub(super) fn scene(&mut self, bytes: &[u8]) {
        let text = std::str::from_utf8(bytes).unwrap_or_default();
        let scene = raw::parse(text, Path::new("scene.toml")).and_then(|source| Scene::from_raw(&source));
        if let Some(tissue) = scene.ok().and_then(|scene| scene.tissue) {
            self.tolerance = tissue.tolerance;
        }
    }

    /// Takes note of a mesh; what is wrong with it, in words. `volume_hash` is the run's examination, where it is known.
    pub(super) fn mesh(&mut self, mesh: &MeshFrame, volume_hash: Option<&str>) -> Option<String> {
        let read = match TissueMesh::read(&mesh.header, &mesh.bytes) {
            Ok(read) => read,
            Err(error) => return Some(error.to_string()),
        };
        self.meshes.insert(mesh.header.mesh_id, read.nodes());
        let found = hexadecimal(&read.volume_hash);
        let expected = volume_hash.filter(|expected| **expected != found)?;
        Some(format!(
            "the mesh of the tissue is of examination {found}, and the run of {expected}"
        ))
    }

    /// Takes note of a state; what is wrong with it, in words.
    pub(super) fn state(&mut self, state: &TissueFrame) -> Option<String> {
        let (header, length) = (&state.header, state.nodes.len());
        self.seqs.saw(header.seq);
        let certified = header.certified(self.tolerance).map_err(|error| error.to_string());
        if let Ok(found) = header.state_of() {
            self.counts[found.code() as usize] += 1;
        }
        match self.meshes.get(&header.mesh_id) {
            Some(nodes) => {
                let held = held(header, &state.nodes, *nodes);
                certified.err().or_else(|| held.err().map(|error| error.to_string()))
            }
            None => {
                self.pending.entry((header.mesh_id, length)).or_insert(*header);
                certified.err()
            }
        }
    }

    /// What is wrong with states whose mesh came behind them, or never.
    pub(super) fn at_end(&self) -> impl Iterator<Item = String> {
        self.pending.iter().filter_map(|((id, length), header)| {
            let Some(nodes) = self.meshes.get(id) else {
                return Some(format!(
                    "tissue {} and others are of mesh {}, which the recording does not hold",
                    header.seq,
                    hexadecimal(&id[..4])
                ));
            };
            let zeros = vec![0.0; *length];
            held(header, &zeros, *nodes).err().map(|error| error.to_string())
        })
    }

    /// How many states there are of a kind; `None` where some are missing, or the model began anew.
    pub(super) fn count(&self, state: TissueState) -> Option<u64> {
        let is_whole =
            self.seqs.missing == 0 && self.seqs.restarts == 0 && self.seqs.range.is_none_or(|(first, _)| first == 1);
        is_whole.then(|| self.counts[state.code() as usize])
    }
}

/// Nodes of a mesh of so many; none are needed where there is no state of the pose.
fn held(header: &TissueHeader, values: &[f32], nodes: usize) -> Result<(), TissueError> {
    let is_of_pose = header.state_of().is_ok_and(TissueState::is_of_pose);
    match is_of_pose || !values.is_empty() {
        true => header.places(values, (&header.mesh_id, nodes)).map(|_| ()),
        false => Ok(()),
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
