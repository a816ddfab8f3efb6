//! The facts, and the voxels and organs at rest, piece by piece, as they lie in memory.

use std::sync::PoisonError;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use bus::message::voxel_bytes;
use bus::port::{SharedVolume, VolumeSubscriber};
use bus::run::RunContext;
use bus::{Bus, BusError};
use zenoh::query::Query;

use super::answers::{Told, reply};
use super::organs::Organs;
use crate::protocol::{FACTS, MESH, PIECE, piece};

/// Between two looks for an examination.
const LOOK: Duration = Duration::from_millis(100);
/// A question: the hash of the examination, or the id of the organs, and the number of the piece.
const ASKED: usize = 36;

/// Answers `questions` until nobody can ask any more.
pub(super) fn serve(
    (run, moves): (&RunContext, bool),
    facts: &Told,
    questions: &Receiver<Query>,
) -> Result<(), BusError> {
    let bus = Bus::join(run)?;
    let volumes = VolumeSubscriber::open(&bus)?;
    let mut volume: Option<SharedVolume> = None;
    let mut organs = moves.then(|| Organs::open(&bus)).transpose()?;
    loop {
        if let Some(new) = volumes.poll()? {
            // Who asks names the one that the facts told; any other is none of the run's.
            volume = Some(new);
        }
        match questions.recv_timeout(LOOK) {
            Ok(query) if query.key_expr().as_str() == FACTS => reply(&query, told(facts)),
            Ok(query) if query.key_expr().as_str() == PIECE => reply(&query, part(volume.as_ref(), &query)),
            Ok(query) if query.key_expr().as_str() == MESH => {
                let organs = organs.as_mut().map(|organs| organs.piece(asked(&query)?));
                reply(&query, organs.unwrap_or(Err("no organs move in this run")));
            }
            Ok(query) => reply(&query, Err("ask so that the answer need not wait")),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}

fn told(facts: &Told) -> Result<Vec<u8>, &'static str> {
    let facts = facts.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match facts.is_empty() {
        true => Err("the run has no examination yet"),
        false => Ok(facts),
    }
}

/// The bytes of a piece, or why there are none.
fn part(volume: Option<&SharedVolume>, query: &Query) -> Result<Vec<u8>, &'static str> {
    let volume = volume.ok_or("there is no examination yet")?;
    let (hash, index) = asked(query)?;
    if hash != volume.hash().0 {
        return Err("the examination is another one");
    }
    let values = volume.view().voxels;
    let range = piece(index, values.len()).ok_or("the examination has no such piece")?;
    Ok(voxel_bytes(&values[range]).to_vec())
}

/// Of what a piece is asked for, by its hash or id, and its number.
fn asked(query: &Query) -> Result<([u8; 32], u32), &'static str> {
    let asked = query.payload().map(zenoh::bytes::ZBytes::to_bytes).unwrap_or_default();
    let asked: &[u8; ASKED] = asked[..].try_into().map_err(|_| "a piece is asked for with 36 bytes")?;
    match asked.split_first_chunk::<32>() {
        Some((of, index)) => Ok((*of, u32::from_le_bytes(index.try_into().unwrap_or_default()))),
        None => Err("a piece is asked for with 36 bytes"),
    }
}
