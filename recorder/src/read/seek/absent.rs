//! The messages of chunks that a file's index lists, and that are not to be found in the file: a bit of the chunk's head is
//! enough for that.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;

use mcap::Summary;
use mcap::records::{ChunkIndex, MessageIndex, Record, op};

use super::places::{Places, record_at};
use crate::read::chunk::MAX_RECORD;
use crate::read::lost::{Hurt, told};

/// One line for each such chunk.
pub(super) fn absent(file: &mut File, length: u64, summary: &Summary, walked: &Places) -> Vec<String> {
    // A walk finds them in the order of the file.
    let is_at = |at: u64| walked.chunks.binary_search_by_key(&at, |chunk| chunk.at).is_ok();
    let there = |index: &&ChunkIndex| is_at(index.chunk_start_offset);
    let mut indexes: Vec<&ChunkIndex> = summary.chunk_indexes.iter().filter(|index| !there(index)).collect();
    indexes.sort_by_key(|index| index.chunk_start_offset);
    let name = |id: u16| match summary.channels.get(&id) {
        Some(channel) => channel.topic.clone(),
        None => format!("channel {id}"),
    };
    let mut line = |index: &ChunkIndex| {
        let times = [index.message_start_time, index.message_end_time]
            .map(u64::to_le_bytes)
            .concat();
        let mut hurt = Hurt::new(&times, &BTreeMap::new());
        for &at in index.message_index_offsets.values() {
            if let Some(list) = message_index(file, at, length) {
                hurt.list(&list);
            }
        }
        let lost: String = told(&[hurt], &BTreeMap::new(), name)
            .iter()
            .map(ToString::to_string)
            .collect();
        format!(
            "the chunk that the index has at byte {} is not readable{lost}",
            index.chunk_start_offset
        )
    };
    indexes.into_iter().map(&mut line).collect()
}

/// The index record at `at`; `None` where there is none that can be read.
fn message_index(file: &mut File, at: u64, length: u64) -> Option<MessageIndex> {
    let (opcode, body) = record_at(file, at, length).ok().flatten()?;
    if opcode != op::MESSAGE_INDEX || body > MAX_RECORD as u64 {
        return None;
    }
    let mut bytes = Vec::new();
    file.take(body).read_to_end(&mut bytes).ok()?;
    match mcap::parse_record(opcode, &bytes).ok()? {
        Record::MessageIndex(index) => Some(index),
        _ => None,
    }
}
