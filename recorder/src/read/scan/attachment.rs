//! What mcap's parser does not look at in an attachment.

use mcap::McapError;
use mcap::records::op;

use super::fault;
use crate::read::damage::{Fault, record_name};

/// Refuses an attachment whose lengths ask for more than it has, where mcap's parser would panic, and one whose CRC is not
/// that of its bytes, which mcap's parser does not look at.
pub(super) fn check(body: &[u8]) -> Result<(), Fault> {
    let fits = || {
        // Two times, name and media type with lengths of 4 bytes, data with one of 8, CRC.
        let mut rest = body.get(16..)?;
        for width in [4, 4, 8] {
            let (length, behind) = rest.split_at_checked(width)?;
            let length = length
                .iter()
                .rev()
                .try_fold(0_usize, |n, &byte| n.checked_mul(256)?.checked_add(byte.into()));
            rest = behind.get(length?..)?;
        }
        let crc = rest.get(..4)?;
        let before = body.get(..body.len() - rest.len())?;
        Some((before, u32::from_le_bytes(crc.try_into().ok()?)))
    };
    let (before, saved) = fits().ok_or(Fault::Length {
        record: record_name(op::ATTACHMENT),
        found: body.len() as u64,
    })?;
    let calculated = crc32fast::hash(before);
    match saved {
        // Not everybody writes one.
        0 => Ok(()),
        _ if saved == calculated => Ok(()),
        _ => Err(fault(op::ATTACHMENT, McapError::BadAttachmentCrc { saved, calculated })),
    }
}
