//! What a file's index alone says, where it can be relied on: what it names fills the file, and the lists behind its chunks hold as
//! many messages as it counts. Where an index does not account for all of its file, as those of other programs may not, the head of
//! every record says whether its chunks lie where it has them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::sync::Arc;

use mcap::Channel;
use mcap::records::ChunkIndex;

use super::Session;
use super::places::{self, Places};
use super::tiled;
use crate::read::damage::OpenError;
use crate::read::scan::{self, Item};

/// Stamps at or beyond it show on no clock: 2^61 ns.
const NO_CLOCK_NS: u64 = 1 << 61;

/// The index of a recording, held against its own sums and places, or against where its records lie.
pub(crate) struct Indexed<'a> {
    session: &'a Session,
    /// In the order of the file.
    chunks: Vec<&'a ChunkIndex>,
    /// The channels by their number.
    pub(crate) channels: BTreeMap<u16, Arc<Channel<'static>>>,
    counts: BTreeMap<u16, u64>,
}

impl Session {
    /// The file's index, or why it cannot be relied on, in words. Reads nothing but the index, or the head of every record where that
    /// does not account for all of the file.
    pub(crate) fn indexed(&self) -> Result<Indexed<'_>, String> {
        let words = |error: OpenError| error.to_string();
        let summary = self.summary.as_ref().ok_or("the file has no index that can be read")?;
        let stats = summary.stats.as_ref().ok_or("its index counts no messages")?;
        let (mut file, length) = scan::open_file(&self.path).map_err(words)?;
        let reading = |error| format!("reading: {error}");
        let listed = match tiled::listed(&mut file, length, summary).map_err(reading)? {
            Some(listed) => Some(listed),
            None => self.walked(&mut file, length)?,
        };
        let counts = stats.channel_message_counts.iter().map(|(id, count)| (*id, *count));
        let counts: BTreeMap<u16, u64> = counts.filter(|(_, count)| *count > 0).collect();
        let total: u64 = counts.values().fold(0, |sum, count| sum.saturating_add(*count));
        if listed.as_ref() != Some(&counts) || total != stats.message_count {
            let there: u64 = listed.iter().flat_map(BTreeMap::values).sum();
            return Err(format!(
                "its index counts {} messages, and its chunks list {there}",
                stats.message_count,
            ));
        }
        let mut chunks: Vec<&ChunkIndex> = summary.chunk_indexes.iter().collect();
        chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
        if let Some(chunk) = chunks.iter().find(|chunk| chunk.message_end_time >= NO_CLOCK_NS) {
            return Err(format!("it has a message of {} ns", chunk.message_end_time));
        }
        Ok(Indexed {
            session: self,
            chunks,
            channels: summary
                .channels
                .iter()
                .map(|(id, channel)| (*id, channel.clone()))
                .collect(),
            counts,
        })
    }

    /// The messages that the lists between the records hold, of each channel; `None` where some lie in no chunk. In words where the
    /// index has anything elsewhere than the file.
    fn walked(&self, file: &mut File, length: u64) -> Result<Option<BTreeMap<u16, u64>>, String> {
        let walked = Places::walk(file, length).map_err(|error| format!("reading: {error}"))?;
        match places::differences(&self.places, &walked).into_iter().next() {
            Some(difference) => Err(difference),
            None => Ok(walked.is_complete.then_some(walked.listed)),
        }
    }
}

impl Indexed<'_> {
    /// Messages of a topic.
    pub(crate) fn count(&self, topic: &str) -> u64 {
        self.of(topic).filter_map(|id| self.counts.get(&id)).sum()
    }

    fn of(&self, topic: &str) -> impl Iterator<Item = u16> {
        self.channels
            .iter()
            .filter(move |(_, channel)| channel.topic == topic)
            .map(|(id, _)| *id)
    }

    /// All chunks, in the order of the file, and whether each holds messages of a topic.
    pub(crate) fn chunks_and(&self, topic: &str) -> impl Iterator<Item = (&ChunkIndex, bool)> {
        let ids: Vec<u16> = self.of(topic).collect();
        let holds = move |chunk: &ChunkIndex| ids.iter().any(|id| chunk.message_index_offsets.contains_key(id));
        self.chunks.iter().map(move |chunk| (*chunk, holds(chunk)))
    }

    /// The chunks that hold messages of a topic, in the order of the file.
    pub(crate) fn chunks_of(&self, topic: &str) -> Vec<&ChunkIndex> {
        let holding = self.chunks_and(topic).filter(|(_, holds)| *holds);
        holding.map(|(chunk, _)| chunk).collect()
    }

    /// What is in one chunk; `None` where it cannot be read.
    pub(crate) fn items(&self, chunk: &ChunkIndex) -> Result<Option<Vec<Item>>, OpenError> {
        let at = chunk.chunk_start_offset;
        let end = at.saturating_add(chunk.chunk_length);
        let mut scan = self.session.scan_at(Some(at))?;
        let mut items = Vec::new();
        while let Some(item) = scan.next() {
            match item {
                // What lies behind the chunk is another's.
                Ok(_) if scan.progress().0 > end => break,
                Ok(item) => items.push(item),
                // The scan has gone on behind a damaged chunk when it tells of it.
                Err(damage) if damage.at < end => return Ok(None),
                Err(_) => break,
            }
        }
        // Damage is told only when it is known what comes behind it, which may be an attachment: a chunk that is listed and gave
        // nothing was not read.
        Ok((!items.is_empty()).then_some(items))
    }

    /// The attachments and the metadata in the order of the file, an error in the place of one that cannot be read.
    pub(crate) fn beside(&self) -> Result<Vec<Option<Item>>, OpenError> {
        let places = &self.session.places;
        let mut at: Vec<u64> = places.attachments.iter().chain(&places.metadata).copied().collect();
        at.sort_unstable();
        let one = |at: u64| -> Result<Option<Item>, OpenError> {
            let mut scan: scan::Scan<BufReader<File>> = self.session.scan_at(Some(at))?;
            Ok(scan.next().and_then(Result::ok))
        };
        at.into_iter().map(one).collect()
    }
}
