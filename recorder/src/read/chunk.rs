//! The records of one chunk, all or nothing.

use std::io::Read;

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

/// Longest record, and longest chunk once unpacked. Ours are a hundredth of it; a length from a damaged file must not
/// make this process ask for all memory.
pub(crate) const MAX_RECORD: usize = 64 << 20;
const HEADER: usize = 1 + 8;
/// The most that the records of one chunk may take in memory: [`MAX_RECORD`] of bytes, and as much for what each record takes
/// besides, so that a chunk of nothing but empty records is bounded too.
const MAX_HELD: usize = 2 * MAX_RECORD;

/// A record: its opcode and its bytes.
pub(crate) type RawRecord = (u8, Vec<u8>);

/// Unpacks a chunk record's body. Its CRC is checked before anything of it is believed; many have none, and then records are
/// counted as they come, whatever size the chunk states.
///
/// # Errors
/// [`McapError::BadChunkCrc`], [`McapError::ChunkTooLarge`] for more than [`MAX_RECORD`] unpacked, and what is wrong with its
/// lengths or its compression.
pub(crate) fn unpack(body: &[u8]) -> McapResult<Vec<RawRecord>> {
    refuse_header(body)?;
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(MAX_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let length = (body.len() as u64).to_le_bytes();
    let mut input = (&[op::CHUNK][..]).chain(&length[..]).chain(body);
    let mut records = Vec::new();
    let mut held = 0;
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::Record { data, opcode } => {
                held += data.len() + size_of::<RawRecord>();
                if held > MAX_HELD {
                    return Err(McapError::ChunkTooLarge(held as u64));
                }
                records.push((opcode, data.to_vec()));
            }
            LinearReadEvent::ReadRequest(wanted) => {
                let read = input.read(reader.insert(wanted.min(body.len() + HEADER)))?;
                reader.notify_read(read);
            }
        }
    }
    Ok(records)
}

/// Refuses a chunk that states more than [`MAX_RECORD`], and an uncompressed one whose records do not fill it exactly: mcap's
/// reader counts on it, and overflows.
fn refuse_header(body: &[u8]) -> McapResult<()> {
    let mcap::records::Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, body)? else {
        return Ok(());
    };
    if header.uncompressed_size > MAX_RECORD as u64 {
        return Err(McapError::ChunkTooLarge(header.uncompressed_size));
    }
    let mut rest: &[u8] = if header.compression.is_empty() { &data } else { &[] };
    while !rest.is_empty() {
        let (record, behind) = rest.split_at_checked(HEADER).ok_or(McapError::UnexpectedEoc)?;
        let length = record.last_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        let behind = usize::try_from(length).ok().and_then(|length| behind.get(length..));
        rest = behind.ok_or(McapError::UnexpectedEoc)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The body of a chunk of `times` records of `record`, without a CRC, that states `stated` bytes.
    fn body(compression: mcap::Compression, record: &[u8], times: usize, stated: Option<u64>) -> Vec<u8> {
        use std::io::Write;
        let (name, packed): (&[u8], Vec<u8>) = match compression {
            mcap::Compression::Zstd => {
                let mut packer = zstd::Encoder::new(Vec::new(), 1).unwrap();
                (0..times).for_each(|_| packer.write_all(record).unwrap());
                (b"zstd", packer.finish().unwrap())
            }
            _ => {
                let mut packer = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
                (0..times).for_each(|_| packer.write_all(record).unwrap());
                (b"lz4", packer.finish().0)
            }
        };
        let size = stated.unwrap_or((record.len() * times) as u64);
        let mut body = [[0; 16].as_slice(), &size.to_le_bytes(), &[0; 4]].concat();
        body.extend((name.len() as u32).to_le_bytes());
        body.extend(name);
        body.extend((packed.len() as u64).to_le_bytes());
        body.extend(packed);
        body
    }

    fn record(length: usize) -> Vec<u8> {
        [&[0x80], &(length as u64).to_le_bytes()[..], &vec![0; length]].concat()
    }

    /// A file of 96 KB once took 5.5 GB.
    #[test]
    fn a_chunk_that_unpacks_to_more_than_a_chunk_may_is_refused() {
        for packing in [mcap::Compression::Zstd, mcap::Compression::Lz4] {
            let big = record(1 << 20);
            assert_eq!(unpack(&body(packing, &big, 60, None)).unwrap().len(), 60);
            let bomb = unpack(&body(packing, &big, 200, None));
            assert!(matches!(bomb, Err(McapError::ChunkTooLarge(_))), "{bomb:?}");
            // It states less than it unpacks to: no more than that is unpacked.
            let lie = unpack(&body(packing, &big, 200, Some(1 << 20)));
            assert!(lie.is_err() || lie.is_ok_and(|records| records.len() <= 1));
            // Nothing but empty records: what each takes besides counts too.
            let empty = unpack(&body(packing, &record(0), MAX_RECORD / HEADER, None));
            assert!(matches!(empty, Err(McapError::ChunkTooLarge(_))));
        }
    }
}
