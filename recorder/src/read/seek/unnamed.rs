//! An index whose channels come without their schemas, as the format allows: mcap's reader refuses it whole.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::{Record, op};
use mcap::{MAGIC, Summary};

use crate::read::chunk::MAX_RECORD;

const HEADER: usize = 1 + 8;
/// The footer: two places and a sum.
const FOOTER: u64 = 8 + 8 + 4;

/// What such an index says, but for its channels; `None` where its records cannot be read.
pub(super) fn summary(file: &mut File, length: u64) -> io::Result<Option<Summary>> {
    let Some(footer) = length.checked_sub(MAGIC.len() as u64 + FOOTER + HEADER as u64) else {
        return Ok(None);
    };
    let mut start = [0; 8];
    file.seek(SeekFrom::Start(footer + HEADER as u64))?;
    file.read_exact(&mut start)?;
    let start = u64::from_le_bytes(start);
    let Some(bytes) = footer.checked_sub(start).filter(|bytes| *bytes <= MAX_RECORD as u64) else {
        return Ok(None);
    };
    let mut rest = Vec::new();
    file.seek(SeekFrom::Start(start))?;
    file.take(bytes).read_to_end(&mut rest)?;
    Ok(parsed(&rest))
}

fn parsed(mut rest: &[u8]) -> Option<Summary> {
    let mut summary = Summary::default();
    while !rest.is_empty() {
        let (head, behind) = rest.split_at_checked(HEADER)?;
        let length = u64::from_le_bytes(head.get(1..)?.try_into().ok()?);
        let (body, behind) = behind.split_at_checked(usize::try_from(length).ok()?)?;
        rest = behind;
        let opcode = *head.first()?;
        if matches!(opcode, op::SCHEMA | op::CHANNEL | op::SUMMARY_OFFSET) {
            continue;
        }
        match mcap::parse_record(opcode, body).ok()? {
            Record::Statistics(stats) => summary.stats = Some(stats),
            Record::ChunkIndex(index) => summary.chunk_indexes.push(index),
            Record::AttachmentIndex(index) => summary.attachment_indexes.push(index),
            Record::MetadataIndex(index) => summary.metadata_indexes.push(index),
            _ => {}
        }
    }
    Some(summary)
}
