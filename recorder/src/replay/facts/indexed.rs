//! The same by the index of the file: the counts of its channels, and the poses of the first chunk and of the last that hold
//! some. A recorder writes poses in the order of their publication, so that the first and the last moment are in these.

use std::path::Path;

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
    let chunks = indexed.chunks_of(TOOL_POSE);
    let (Some(first), Some(last)) = (chunks.first(), chunks.last()) else {
        return Ok(());
    };
    // A capture before the run's epoch is written as 0, and is refused where all is read.
    if chunks.iter().skip(1).any(|chunk| chunk.message_start_time == 0) {
        return Err("it has a message of 0 ns behind others".to_owned());
    }
    let ends = [*first, *last];
    let distinct = if first.chunk_start_offset == last.chunk_start_offset {
        1
    } else {
        2
    };
    for chunk in &ends[..distinct] {
        let items = indexed.items(chunk).map_err(|error| error.to_string())?;
        let damaged = || format!("its chunk at byte {} cannot be read", chunk.chunk_start_offset);
        for item in items.ok_or_else(damaged)? {
            if let Item::Message(message) = item {
                facts.count(path, &message).map_err(|error| error.to_string())?;
            }
        }
    }
    Ok(())
}
