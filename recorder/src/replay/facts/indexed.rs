//! The same by the index of the file: the counts of its channels, and the poses of the first chunk and of the last that hold
//! some. A recorder writes poses in the order of their publication, so that the first and the last moment are in these.

use std::path::Path;

use mcap::records::ChunkIndex;

use super::Facts;
use crate::read::scan::Item;
use crate::read::seek::{Indexed, Session};
use crate::wire::schema::{EMITTERS, GROUND_TRUTH, MARKERS, TOOL_POSE};

/// The facts, or why the index does not tell them, in words. Whatever is to be refused is left to whoever reads all.
pub(super) fn facts(path: &Path) -> Result<Facts, String> {
    let words = |error: &dyn std::error::Error| error.to_string();
    let session = Session::open(path).map_err(|e| words(&e))?;
    let indexed = session.indexed()?;
    let mut facts = Facts::default();
    for channel in indexed.channels.values() {
        facts.declare(path, channel).map_err(|e| words(&e))?;
    }
    for item in indexed.beside().map_err(|e| words(&e))? {
        let item = item.ok_or("an attachment, or what is said of the run, cannot be read")?;
        facts.beside(path, item).map_err(|e| words(&e))?;
    }
    moments(path, &indexed, &mut facts)?;
    facts.poses = indexed.count(TOOL_POSE);
    facts.truths = indexed.count(GROUND_TRUTH);
    facts.emitters = indexed.count(EMITTERS);
    facts.markers = indexed.count(MARKERS);
    Ok(facts)
}

/// The first moment and the last, by the poses of the first chunk that has some and of the last one.
fn moments(path: &Path, indexed: &Indexed<'_>, facts: &mut Facts) -> Result<(), String> {
    let chunks: Vec<(&ChunkIndex, bool)> = indexed.chunks_and(TOOL_POSE).collect();
    let holds = |(_, holds): &(&ChunkIndex, bool)| *holds;
    let (Some(first), Some(last)) = (chunks.iter().position(holds), chunks.iter().rposition(holds)) else {
        return Ok(());
    };
    // A capture before the run's epoch is written as 0, and is refused where all is read.
    let mut later = chunks.iter().skip(first + 1).filter(|chunk| holds(chunk));
    if later.any(|(chunk, _)| chunk.message_start_time == 0) {
        return Err("it has a message of 0 ns behind others".to_owned());
    }
    for (number, (chunk, is_listed)) in chunks.iter().enumerate() {
        // Those before the first and behind the last are read too: a list may leave out what is there.
        let is_empty = chunk.message_index_offsets.is_empty();
        if (number <= first || number >= last) && !is_empty {
            ends(path, indexed, (chunk, *is_listed), facts)?;
        }
    }
    Ok(())
}

/// Takes the poses of a chunk, that has some or has none.
fn ends(
    path: &Path,
    indexed: &Indexed<'_>,
    (chunk, is_listed): (&ChunkIndex, bool),
    facts: &mut Facts,
) -> Result<(), String> {
    let damaged = || format!("its chunk at byte {} cannot be read", chunk.chunk_start_offset);
    let items = indexed.items(chunk).map_err(|error| error.to_string())?;
    let mut has_some = false;
    for item in items.ok_or_else(damaged)? {
        if let Item::Message(message) = item {
            has_some |= message.channel.topic == TOOL_POSE;
            facts.count(path, &message).map_err(|error| error.to_string())?;
        }
    }
    match has_some == is_listed {
        true => Ok(()),
        false => Err(format!(
            "the list behind its chunk at byte {} is not that of its poses",
            chunk.chunk_start_offset
        )),
    }
}
