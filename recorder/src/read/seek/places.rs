//! Where in a file its chunks lie, and what lies beside them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

use mcap::records::op;
use mcap::sans_io::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{MAGIC, McapResult, Summary};

use crate::read::chunk::MAX_RECORD;
use crate::wire::schema::LIBRARY;

/// Opcode and length in front of a record.
pub(super) const HEADER: u64 = 1 + 8;
/// The head of an index record.
pub(super) const LIST: u64 = 2 + 4;
/// Bytes of an index that are read at once.
const READ_AHEAD: usize = 1 << 16;
/// Most records that a walk looks at: a file of nothing but empty records must not fill the memory.
const MAX_PLACES: usize = 1 << 24;

/// A chunk: where it starts, and the times of its messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Chunk {
    pub(super) at: u64,
    pub(super) from_ns: u64,
    pub(super) to_ns: u64,
}

/// Where what lies.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(super) struct Places {
    /// In the order of the file.
    pub(super) chunks: Vec<Chunk>,
    pub(super) attachments: Vec<u64>,
    pub(super) metadata: Vec<u64>,
    /// Where a file's data end: nothing to look for is behind it.
    pub(super) end: u64,
    /// Whether all messages are in these chunks.
    pub(super) is_complete: bool,
    /// Whether this version's recorder wrote the file.
    pub(super) is_ours: bool,
    /// Messages of each channel by the index records between the chunks, where the file was walked.
    pub(super) listed: BTreeMap<u16, u64>,
}

impl Places {
    /// The first place from which on everything of `t_ns` and later is found; `None` where nothing is.
    pub(super) fn first_at(&self, t_ns: u64) -> Option<u64> {
        if !self.is_complete {
            return None;
        }
        self.chunks
            .iter()
            .find(|chunk| chunk.to_ns >= t_ns)
            .map(|chunk| chunk.at)
    }

    /// The places that a file's index names.
    pub(super) fn from_summary(summary: &Summary) -> Self {
        let chunk = |index: &mcap::records::ChunkIndex| Chunk {
            at: index.chunk_start_offset,
            from_ns: index.message_start_time,
            to_ns: index.message_end_time,
        };
        let mut chunks: Vec<Chunk> = summary.chunk_indexes.iter().map(chunk).collect();
        chunks.sort_by_key(|chunk| chunk.at);
        let end = |index: &mcap::records::ChunkIndex| {
            let length = index.chunk_length.checked_add(index.message_index_length)?;
            index.chunk_start_offset.checked_add(length)
        };
        let stated = summary.stats.as_ref().map_or(0, |stats| stats.message_count);
        Self {
            is_complete: !chunks.is_empty() || stated == 0,
            chunks,
            attachments: summary.attachment_indexes.iter().map(|index| index.offset).collect(),
            metadata: summary.metadata_indexes.iter().map(|index| index.offset).collect(),
            end: summary
                .chunk_indexes
                .iter()
                .filter_map(end)
                .max()
                .unwrap_or(MAGIC.len() as u64),
            is_ours: false,
            listed: BTreeMap::new(),
        }
    }

    /// Walks through a file from record to record.
    pub(super) fn walk(file: &mut File, length: u64) -> io::Result<Self> {
        let mut places = Self {
            is_complete: true,
            ..Self::default()
        };
        let mut at = MAGIC.len() as u64;
        while places.count() < MAX_PLACES {
            places.end = at;
            let Some((opcode, body)) = record_at(file, at, length)? else {
                break;
            };
            if matches!(opcode, op::DATA_END | op::FOOTER) {
                break;
            }
            places.note(file, opcode, at, body)?;
            at += HEADER + body;
        }
        Ok(places)
    }

    fn count(&self) -> usize {
        self.chunks.len() + self.attachments.len() + self.metadata.len()
    }

    /// Takes note of the record at `at`; the file is behind its header.
    fn note(&mut self, file: &mut File, opcode: u8, at: u64, body: u64) -> io::Result<()> {
        match opcode {
            op::CHUNK if body >= 16 => {
                let mut times = [0; 16];
                file.read_exact(&mut times)?;
                let [from_ns, to_ns] = [0, 8].map(|i| u64::from_le_bytes(std::array::from_fn(|k| times[i + k])));
                self.chunks.push(Chunk { at, from_ns, to_ns });
            }
            // Its channel, the bytes of its list, and 16 of them for a message.
            op::MESSAGE_INDEX if body >= LIST => {
                let mut channel = [0; 2];
                file.read_exact(&mut channel)?;
                *self.listed.entry(u16::from_le_bytes(channel)).or_default() += (body - LIST) / 16;
            }
            op::ATTACHMENT => self.attachments.push(at),
            op::METADATA => self.metadata.push(at),
            op::MESSAGE => self.is_complete = false,
            op::HEADER => {
                let mut text = Vec::new();
                file.take(body.min(1 << 10)).read_to_end(&mut text)?;
                self.is_ours = text.ends_with(LIBRARY.as_bytes());
            }
            _ => {}
        }
        Ok(())
    }
}

/// The opcode and the length of the record at `at`; `None` where the file has no whole one there.
pub(super) fn record_at(file: &mut File, at: u64, length: u64) -> io::Result<Option<(u8, u64)>> {
    let room = length.saturating_sub(at);
    if room < HEADER {
        return Ok(None);
    }
    let mut header = [0; HEADER as usize];
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(&mut header)?;
    let body = u64::from_le_bytes(std::array::from_fn(|i| header[1 + i]));
    Ok((body <= room - HEADER).then_some((header[0], body)))
}

/// The file's index; `None` where it has none, or a damaged one.
pub(super) fn summary(file: &mut File, length: u64) -> Option<Summary> {
    let summary = read_summary(file, length).ok().flatten()?;
    fits(&summary, length).then_some(summary)
}

/// Whether every place that an index names lies in a file of this length.
pub(super) fn fits(summary: &Summary, length: u64) -> bool {
    let fits = |at: u64| at >= MAGIC.len() as u64 && at < length;
    let offsets = summary.chunk_indexes.iter().map(|index| index.chunk_start_offset);
    let offsets = offsets.chain(summary.attachment_indexes.iter().map(|index| index.offset));
    offsets
        .chain(summary.metadata_indexes.iter().map(|index| index.offset))
        .all(fits)
}

/// The file's index; `None` where it states that it has none.
pub(super) fn read_summary(file: &mut File, length: u64) -> McapResult<Option<Summary>> {
    let options = SummaryReaderOptions::default()
        .with_file_size(length)
        .with_record_length_limit(MAX_RECORD);
    let mut reader = SummaryReader::new_with_options(options);
    // The reader counts from the start, and asks for each record in two small pieces.
    file.rewind()?;
    let mut input = BufReader::with_capacity(READ_AHEAD, file);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = input.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(input.seek(to)?),
        }
    }
    Ok(reader.finish())
}

/// Takes out of what is there the kinds of which an index names none at all, as the format allows; which, in words.
pub(super) fn leave_out(index: &Places, walked: &mut Places) -> Vec<String> {
    let mut left_out = Vec::new();
    let mut say = |count: usize, what: &str| left_out.push(format!("its index lists none of its {count} {what}"));
    if index.chunks.is_empty() && !walked.chunks.is_empty() {
        say(walked.chunks.len(), "chunks");
        walked.chunks.clear();
    }
    if index.attachments.is_empty() && !walked.attachments.is_empty() {
        say(walked.attachments.len(), "attachments");
        walked.attachments.clear();
    }
    if index.metadata.is_empty() && !walked.metadata.is_empty() {
        say(walked.metadata.len(), "metadata records");
        walked.metadata.clear();
    }
    left_out
}

/// What an index says otherwise than the records do, in words: a line for each kind.
pub(super) fn differences(index: &Places, walked: &Places) -> Vec<String> {
    let mut found = Vec::new();
    if index.chunks != walked.chunks {
        let first = index.chunks.iter().zip(&walked.chunks).find(|(a, b)| a != b);
        let at = first.map_or(String::new(), |(a, b)| {
            format!(
                ": it has one at byte {} where the file has one at byte {}, or with other times",
                a.at, b.at
            )
        });
        let (stated, there) = (index.chunks.len(), walked.chunks.len());
        found.push(format!("the index lists {stated} chunks, and there are {there}{at}"));
    }
    for (what, stated, there) in [
        ("attachments", &index.attachments, &walked.attachments),
        ("metadata records", &index.metadata, &walked.metadata),
    ] {
        if stated != there {
            found.push(format!(
                "the index lists {what} at bytes {stated:?}, and they are at bytes {there:?}"
            ));
        }
    }
    found
}
