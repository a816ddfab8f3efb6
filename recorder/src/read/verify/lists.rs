//! The lists of messages behind each chunk, and what the index says of it, held against the messages that lie in it.
//!
//! Whoever opens a recording at a moment, or looks for what was chosen in it, goes by these lists: one that names another channel
//! hides messages, and the file is as whole as before by all of its sums.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use mcap::Summary;
use mcap::records::{ChunkIndex, MessageIndex, Record, op};

use crate::read::chunk::{self, RawRecord};
use crate::read::damage::OpenError;
use crate::read::file_records::FileRecords;
use crate::read::scan;

/// Opcode and length in front of a record.
const HEADER: u64 = 1 + 8;

/// The time and the place of each message, ordered.
type Listed = BTreeMap<u16, Vec<(u64, u64)>>;

/// A chunk and the lists behind it, as they are read.
struct Read {
    at: u64,
    length: u64,
    /// The first and the last moment that its head states, ns.
    times: (u64, u64),
    compression: String,
    /// Bytes, and bytes once unpacked.
    sizes: (u64, u64),
    messages: Listed,
    lists: Listed,
    /// Where the list of each channel starts.
    places: BTreeMap<u16, u64>,
    lists_length: u64,
}

/// Tells `find` of each chunk whose lists are not those of its messages. Lists may be left out unless `is_ours`: Trocar's recorder
/// writes them all. Chunks that cannot be read are passed over: they are told of as such.
///
/// # Errors
/// [`OpenError`].
pub(super) fn hold(
    path: &Path,
    summary: &Summary,
    is_ours: bool,
    find: &mut dyn FnMut(String),
) -> Result<(), OpenError> {
    let (file, length) = open(path)?;
    let mut records = FileRecords::new(std::io::BufReader::new(file), length);
    let stated: BTreeMap<u64, &ChunkIndex> = summary
        .chunk_indexes
        .iter()
        .map(|index| (index.chunk_start_offset, index))
        .collect();
    let name = |id: u16| {
        summary
            .channels
            .get(&id)
            .map_or(format!("channel {id}"), |it| it.topic.clone())
    };
    let mut last: Option<Read> = None;
    let mut conclude = |read: Option<Read>| {
        let Some(read) = read else { return };
        let index = stated.get(&read.at).copied();
        read.wrong(index, is_ours, &name).into_iter().for_each(&mut *find);
    };
    loop {
        let at = records.at();
        // What ends the reading early is told by whoever reads the messages.
        let Ok(Some((opcode, body))) = records.next() else {
            break;
        };
        match opcode {
            op::MESSAGE_INDEX => {
                if let (Some(read), Ok(Record::MessageIndex(list))) = (&mut last, mcap::parse_record(opcode, &body)) {
                    read.list(at, body.len() as u64, list);
                }
            }
            _ => conclude(last.take()),
        }
        match opcode {
            op::CHUNK => last = Read::new(at, &body),
            op::DATA_END => break,
            _ => {}
        }
    }
    conclude(last);
    Ok(())
}

fn open(path: &Path) -> Result<(std::fs::File, u64), OpenError> {
    use std::io::Seek as _;
    let (mut file, length) = scan::open_file(path)?;
    file.rewind().map_err(|source| OpenError::Io {
        path: path.to_owned(),
        source,
    })?;
    Ok((file, length))
}

impl Read {
    fn new(at: u64, body: &[u8]) -> Option<Self> {
        let records = chunk::unpack(body).ok()?;
        let Ok(Record::Chunk { header, data }) = mcap::parse_record(op::CHUNK, body) else {
            return None;
        };
        Some(Self {
            at,
            length: HEADER + body.len() as u64,
            times: (header.message_start_time, header.message_end_time),
            compression: header.compression,
            sizes: (data.len() as u64, header.uncompressed_size),
            messages: messages(&records),
            lists: Listed::new(),
            places: BTreeMap::new(),
            lists_length: 0,
        })
    }

    fn list(&mut self, at: u64, length: u64, list: MessageIndex) {
        self.lists_length += HEADER + length;
        // An empty list says what none says.
        if !list.records.is_empty() {
            self.places.insert(list.channel_id, at);
            let all = self.lists.entry(list.channel_id).or_default();
            all.extend(list.records.iter().map(|entry| (entry.log_time, entry.offset)));
            all.sort_unstable();
        }
    }

    fn wrong(&self, index: Option<&ChunkIndex>, is_ours: bool, name: &dyn Fn(u16) -> String) -> Vec<String> {
        let mut wrong = Vec::new();
        let of = |what: String| format!("the chunk at byte {}: {what}", self.at);
        let times = self.messages.values().flatten().map(|(t_ns, _)| *t_ns);
        let span = times.clone().min().zip(times.max());
        if let Some((from, to)) = span.filter(|span| *span != self.times) {
            let (first, last) = self.times;
            wrong.push(of(format!(
                "its head says messages of {first} ns to {last} ns, and they are of {from} ns to {to} ns"
            )));
        }
        if is_ours || !self.lists.is_empty() {
            wrong.extend(self.unlisted(name).map(of));
        }
        wrong.extend(index.and_then(|index| self.index(index, is_ours)).map(of));
        wrong
    }

    /// The channels whose list is not that of their messages.
    fn unlisted<'a>(&'a self, name: &'a dyn Fn(u16) -> String) -> impl Iterator<Item = String> + 'a {
        let ids: BTreeSet<u16> = self.messages.keys().chain(self.lists.keys()).copied().collect();
        let of = |lists: &Listed, id| lists.get(&id).map_or(0, Vec::len);
        let differs = |id: &u16| self.messages.get(id) != self.lists.get(id);
        ids.into_iter().filter(differs).map(move |id| {
            let (listed, there) = (of(&self.lists, id), of(&self.messages, id));
            let others = if listed == there {
                ", at other places or times"
            } else {
                ""
            };
            let topic = name(id);
            format!("the list behind it has {listed} messages of {topic}, and there are {there}{others}")
        })
    }

    /// What an index says otherwise of this chunk.
    fn index(&self, index: &ChunkIndex, is_ours: bool) -> Option<String> {
        let are_left_out = !is_ours && index.message_index_offsets.is_empty();
        let places: BTreeMap<u16, u64> = index
            .message_index_offsets
            .iter()
            // An empty list may be named.
            .filter(|(id, _)| self.lists.contains_key(id) || self.messages.contains_key(id))
            .map(|(id, at)| (*id, *at))
            .collect();
        let is_named = places == self.places && (!is_ours || index.message_index_offsets.len() == places.len());
        if !are_left_out && !is_named {
            return Some("the index has the lists behind it at other places, or of other channels".to_owned());
        }
        let is = index.chunk_length == self.length
            && (are_left_out || index.message_index_length == self.lists_length)
            && index.compression == self.compression
            && (index.compressed_size, index.uncompressed_size) == self.sizes;
        (!is).then(|| "the index states other lengths, or another compression".to_owned())
    }
}

/// The time and the place of each message in a chunk's records.
fn messages(records: &[RawRecord]) -> Listed {
    let mut found = Listed::new();
    let mut at = 0;
    for (opcode, body) in records {
        if let (&op::MESSAGE, Ok(Record::Message { header, .. })) = (opcode, mcap::parse_record(*opcode, body)) {
            found.entry(header.channel_id).or_default().push((header.log_time, at));
        }
        at += HEADER + body.len() as u64;
    }
    found.values_mut().for_each(|all| all.sort_unstable());
    found
}
