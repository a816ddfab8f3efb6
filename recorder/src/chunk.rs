//! The records of one chunk, all or nothing.

use std::io::Read;

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

/// Longest record, and longest chunk once unpacked. Ours are a hundredth of it; a length from a damaged file must not
/// make this process ask for all memory.
pub const MAX_RECORD: usize = 64 << 20;
const HEADER: usize = 1 + 8;

/// A record: its opcode and its bytes.
pub type RawRecord = (u8, Vec<u8>);

/// Unpacks a chunk record's body. Its CRC is checked before anything of it is believed.
///
/// # Errors
/// [`McapError::BadChunkCrc`], and what is wrong with its lengths or its compression.
pub fn unpack(body: &[u8]) -> McapResult<Vec<RawRecord>> {
    refuse_untiled(body)?;
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(MAX_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let length = (body.len() as u64).to_le_bytes();
    let mut input = (&[op::CHUNK][..]).chain(&length[..]).chain(body);
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::Record { data, opcode } => records.push((opcode, data.to_vec())),
            LinearReadEvent::ReadRequest(wanted) => {
                let read = input.read(reader.insert(wanted.min(body.len() + HEADER)))?;
                reader.notify_read(read);
            }
        }
    }
    Ok(records)
}

/// Refuses an uncompressed chunk whose records do not fill it exactly: mcap's reader counts on it, and overflows.
fn refuse_untiled(body: &[u8]) -> McapResult<()> {
    let mcap::records::Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, body)? else {
        return Ok(());
    };
    let mut rest: &[u8] = if header.compression.is_empty() { &data } else { &[] };
    while !rest.is_empty() {
        let (record, behind) = rest.split_at_checked(HEADER).ok_or(McapError::UnexpectedEoc)?;
        let length = record.last_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        let behind = usize::try_from(length).ok().and_then(|length| behind.get(length..));
        rest = behind.ok_or(McapError::UnexpectedEoc)?;
    }
    Ok(())
}
