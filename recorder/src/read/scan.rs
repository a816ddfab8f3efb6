//! Reads a recording from start to end, whole or not: what is readable comes out, what is not is named by its place.
//!
//! A damaged chunk, attachment or metadata record is passed over; a record whose length is damaged ends the reading,
//! because nothing says where the next one starts. Memory is bounded by `MAX_RECORD` (`chunk.rs`), whatever the
//! lengths in the file say.

mod attachment;

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;
use std::sync::Arc;

use mcap::read::ChannelAccumulator;
use mcap::records::{Metadata, Record, SchemaHeader, op};
use mcap::{Attachment, Channel, MAGIC, McapError, Message};

use crate::read::chunk::{self, RawRecord};
use crate::read::damage::{Damage, Fault, OpenError, record_name};
use crate::read::file_records::FileRecords;
use crate::read::lost::{self, Hurt};
use crate::wire::schema::{self, LIBRARY};

/// Something readable.
#[derive(Debug)]
pub enum Item {
    /// A channel, where it is first declared.
    Channel(Arc<Channel<'static>>),
    /// A message with its channel.
    Message(Message<'static>),
    /// An attached file.
    Attachment(Attachment<'static>),
    /// Named facts.
    Metadata(Metadata),
}

/// A recording being read; an iterator over what is readable and what is not, in the order of the file.
pub struct Scan<R> {
    records: FileRecords<R>,
    /// Records of the chunk being read.
    unpacked: VecDeque<RawRecord>,
    channels: ChannelAccumulator<'static>,
    built_in: Option<ChannelAccumulator<'static>>,
    /// What the file's header says of who wrote it.
    library: Option<String>,
    /// The last number read of each channel.
    last: BTreeMap<u16, u32>,
    /// Damaged chunks of which it is not known yet what comes behind them.
    hurt: Vec<(u64, Fault, Hurt)>,
    /// Whether only index records have come since the last of these.
    listing: bool,
    /// What was found wrong, to be told before what comes next.
    told: VecDeque<Damage>,
    data_ended: bool,
    stopped: bool,
}

/// Damaged chunks that follow one another are told together up to so many.
const MOST_HURT: usize = 1024;

/// What a record comes to.
type Taken = Result<Option<Item>, Fault>;

/// Opens a recording.
///
/// # Errors
/// [`OpenError`].
pub fn open(path: &Path) -> Result<Scan<BufReader<File>>, OpenError> {
    let fail = |source| OpenError::Io {
        path: path.to_owned(),
        source,
    };
    let (mut file, length) = open_file(path)?;
    file.rewind().map_err(fail)?;
    Ok(Scan::new(BufReader::new(file), length))
}

/// Opens a file that begins as a recording does; its length, and the file behind its first bytes.
pub(crate) fn open_file(path: &Path) -> Result<(File, u64), OpenError> {
    let fail = |source| OpenError::Io {
        path: path.to_owned(),
        source,
    };
    let (mut file, about) = scene::file::open(path).map_err(|error| fail(error.into()))?;
    let length = about.len();
    let mut found = Vec::new();
    (&mut file)
        .take(MAGIC.len() as u64)
        .read_to_end(&mut found)
        .map_err(fail)?;
    if found != MAGIC {
        let path = path.to_owned();
        return Err(OpenError::NotMcap { path, found });
    }
    Ok((file, length))
}

impl<R: Read> Scan<R> {
    /// Reads `length` bytes of `input`, which is at its start.
    pub fn new(input: R, length: u64) -> Self {
        Self::of(FileRecords::new(input, length), ChannelAccumulator::default())
    }

    /// Reads on from byte `at`, where a record starts and `input` is, knowing the channels declared before.
    pub(crate) fn from_middle(input: R, length: u64, at: u64, channels: ChannelAccumulator<'static>) -> Self {
        Self::of(FileRecords::from_middle(input, length, at), channels)
    }

    fn of(records: FileRecords<R>, channels: ChannelAccumulator<'static>) -> Self {
        Self {
            records,
            unpacked: VecDeque::new(),
            channels,
            built_in: None,
            library: None,
            last: BTreeMap::new(),
            hurt: Vec::new(),
            listing: false,
            told: VecDeque::new(),
            data_ended: false,
            stopped: false,
        }
    }

    /// The program that wrote the file, by its header; `None` before that was read, and where it is damaged.
    pub fn library(&self) -> Option<&str> {
        self.library.as_deref()
    }

    /// Bytes read so far, and bytes of the whole file.
    pub fn progress(&self) -> (u64, u64) {
        (self.records.at(), self.records.length())
    }

    /// Reads the next record of the file, and says at what byte it started.
    fn step(&mut self) -> Option<Result<Item, Damage>> {
        let at = self.records.at();
        match self.records.next() {
            Ok(Some((opcode, body))) => {
                let taken = self.file_record(at, opcode, body);
                damage(at, taken)
            }
            Ok(None) => {
                self.stopped = true;
                self.tell();
                None
            }
            Err(fault) => {
                self.stopped = true;
                self.tell();
                self.told.push_back(Damage {
                    at,
                    fault,
                    stops: true,
                    lost: None,
                });
                None
            }
        }
    }

    fn file_record(&mut self, at: u64, opcode: u8, body: Vec<u8>) -> Taken {
        match opcode {
            op::CHUNK => {
                self.chunk(at, &body);
                return Ok(None);
            }
            // It lists what a damaged chunk held; of others nothing need be known.
            op::MESSAGE_INDEX => {
                if let (true, Some((.., hurt)), Ok(Record::MessageIndex(index))) =
                    (self.listing, self.hurt.last_mut(), mcap::parse_record(opcode, &body))
                {
                    hurt.list(&index);
                }
                return Ok(None);
            }
            _ => self.listing = false,
        }
        match opcode {
            op::DATA_END => {
                self.data_ended = true;
                self.tell();
                Ok(None)
            }
            // The summary repeats what came before; mcap has checked its CRC.
            _ if self.data_ended => Ok(None),
            _ => self.take(opcode, &body),
        }
    }

    /// Unpacks a chunk. One that is damaged is told of when it is known what comes behind it.
    fn chunk(&mut self, at: u64, body: &[u8]) {
        match chunk::unpack(body) {
            Ok(records) => {
                self.unpacked = records.into();
                self.tell();
            }
            Err(error) => {
                let hurt = Hurt::new(body, &self.last);
                self.hurt.push((at, fault(op::CHUNK, error), hurt));
                self.listing = true;
                if self.hurt.len() == MOST_HURT {
                    self.tell();
                }
            }
        }
    }

    /// Tells of the damaged chunks before those records that are unpacked now.
    fn tell(&mut self) {
        if self.hurt.is_empty() {
            return;
        }
        let (places, hurt): (Vec<_>, Vec<_>) = std::mem::take(&mut self.hurt)
            .into_iter()
            .map(|(at, fault, hurt)| ((at, fault), hurt))
            .unzip();
        let lost = lost::told(&hurt, &first_numbers(&self.unpacked), |channel| self.topic(channel));
        self.told
            .extend(places.into_iter().zip(lost).map(|((at, fault), lost)| Damage {
                at,
                fault,
                stops: false,
                lost: Some(Box::new(lost)),
            }));
    }

    fn topic(&self, id: u16) -> String {
        let built_in = || self.built_in.as_ref()?.get(id);
        let channel = self.channels.get(id).or_else(built_in);
        channel.map_or_else(|| format!("channel {id}"), |channel| channel.topic.clone())
    }

    /// Takes a record that is not a chunk.
    fn take(&mut self, opcode: u8, body: &[u8]) -> Taken {
        if opcode == op::ATTACHMENT {
            attachment::check(body)?;
        }
        let record = mcap::parse_record(opcode, body).map_err(|e| fault(opcode, e))?;
        match record {
            Record::Header(header) => {
                self.built_in = (header.library == LIBRARY).then(schema::built_in);
                self.library = Some(header.library);
                Ok(None)
            }
            Record::Schema { header, data } => {
                let added = self.channels.add_schema_from_slice(header, &data);
                added.map(|()| None).map_err(|e| fault(opcode, e))
            }
            Record::Channel(channel) => self.declare(channel),
            Record::Message { header, data } => self.message(header, &data),
            Record::Attachment { header, data, .. } => Ok(Some(Item::Attachment(Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data: Cow::Owned(data.into_owned()),
            }))),
            Record::Metadata(metadata) => Ok(Some(Item::Metadata(metadata))),
            _ => Ok(None),
        }
    }

    fn declare(&mut self, channel: mcap::records::Channel) -> Taken {
        let id = channel.id;
        let is_known = self.channels.get(id).is_some();
        self.channels.add_channel(channel).map_err(|e| fault(op::CHANNEL, e))?;
        let declared = self.channels.get(id).filter(|_| !is_known);
        Ok(declared.map(Item::Channel))
    }

    fn message(&mut self, header: mcap::records::MessageHeader, data: &[u8]) -> Taken {
        let id = header.channel_id;
        if self.channels.get(id).is_none() {
            self.declare_built_in(id)?;
        }
        let channel = self.channels.get(id).ok_or(Fault::UnknownChannel { channel: id })?;
        self.last.insert(id, header.sequence);
        Ok(Some(Item::Message(Message {
            channel,
            sequence: header.sequence,
            log_time: header.log_time,
            publish_time: header.publish_time,
            data: Cow::Owned(data.to_vec()),
        })))
    }

    /// Declares a channel as this version's files have it, where the file's own declaration was damaged. Through the
    /// same door as the file's, so that the two cannot contradict each other.
    fn declare_built_in(&mut self, id: u16) -> Result<(), Fault> {
        let Some(channel) = self.built_in.as_ref().and_then(|built_in| built_in.get(id)) else {
            return Ok(());
        };
        let Some(schema) = &channel.schema else { return Ok(()) };
        let header = SchemaHeader {
            id: schema.id,
            name: schema.name.clone(),
            encoding: schema.encoding.clone(),
        };
        let added = self.channels.add_schema_from_slice(header, &schema.data);
        added.map_err(|e| fault(op::SCHEMA, e))?;
        self.declare(mcap::records::Channel {
            id,
            schema_id: schema.id,
            topic: channel.topic.clone(),
            message_encoding: channel.message_encoding.clone(),
            metadata: channel.metadata.clone(),
        })?;
        Ok(())
    }
}

/// The first number of each channel among the records of a chunk.
fn first_numbers(records: &VecDeque<RawRecord>) -> BTreeMap<u16, u32> {
    let mut first = BTreeMap::new();
    for (_, body) in records.iter().filter(|(opcode, _)| *opcode == op::MESSAGE) {
        if let Ok(Record::Message { header, .. }) = mcap::parse_record(op::MESSAGE, body) {
            first.entry(header.channel_id).or_insert(header.sequence);
        }
    }
    first
}

fn fault(opcode: u8, source: McapError) -> Fault {
    Fault::Record {
        record: record_name(opcode),
        source,
    }
}

fn damage(at: u64, taken: Taken) -> Option<Result<Item, Damage>> {
    let told = |fault| Damage {
        at,
        fault,
        stops: false,
        lost: None,
    };
    taken.map_err(told).transpose()
}

impl<R: Read> Iterator for Scan<R> {
    type Item = Result<Item, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(damage) = self.told.pop_front() {
                return Some(Err(damage));
            }
            let at = self.records.at();
            let found = match self.unpacked.pop_front() {
                // A record in a chunk is named by the end of the chunk: its own place is in no file.
                Some((opcode, body)) => damage(at, self.take(opcode, &body)),
                None if self.stopped => return None,
                None => self.step(),
            };
            if found.is_some() {
                return found;
            }
        }
    }
}

impl<R> std::fmt::Debug for Scan<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scan")
            .field("stopped", &self.stopped)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
