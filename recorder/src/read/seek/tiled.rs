//! Whether an index accounts for every byte of its file's data, by itself: nothing of the data is read for it.
//!
//! A sum over the index says that its bytes are those that were written. Its chunks with the lists behind them, its attachments and its
//! metadata then have to lie one behind the other from the file's header to the end of its data, without a gap or an overlap: there
//! is no message, attachment or chunk beside those that it names. Whether each of them can be read, says whoever reads it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::{ChunkIndex, op};
use mcap::{MAGIC, Summary};

use super::places::{HEADER, LIST, record_at};

/// Start of the index, start of its groups, and the sum over both.
const FOOTER: u64 = 8 + 8 + 4;
/// The sum over the data.
const DATA_END: u64 = 4;
/// A message in a list: its time and its place.
const LISTED: u64 = 16;

/// The messages of each channel as the index places their lists; `None` where it does not account for all of the file, as files of
/// other programs may not.
///
/// # Errors
/// Those of reading.
pub(super) fn listed(file: &mut File, length: u64, summary: &Summary) -> io::Result<Option<BTreeMap<u16, u64>>> {
    let Some(summary_start) = sound_start(file, length)? else {
        return Ok(None);
    };
    let Some(data_end) = summary_start.checked_sub(HEADER + DATA_END) else {
        return Ok(None);
    };
    let header_at = MAGIC.len() as u64;
    let (header, end) = (record_at(file, header_at, length)?, record_at(file, data_end, length)?);
    let Some((op::HEADER, header)) = header else {
        return Ok(None);
    };
    Ok(match end == Some((op::DATA_END, DATA_END)) {
        true => tiled(summary, header_at + HEADER + header, data_end),
        false => None,
    })
}

/// Where the index starts, if the sum over it is stated and right.
fn sound_start(file: &mut File, length: u64) -> io::Result<Option<u64>> {
    let Some(footer_at) = length.checked_sub(HEADER + FOOTER + MAGIC.len() as u64) else {
        return Ok(None);
    };
    if record_at(file, footer_at, length)? != Some((op::FOOTER, FOOTER)) {
        return Ok(None);
    }
    let mut footer = [0; FOOTER as usize];
    file.read_exact(&mut footer)?;
    let start = u64::from_le_bytes(std::array::from_fn(|i| footer[i]));
    let stated = u32::from_le_bytes(std::array::from_fn(|i| footer[16 + i]));
    // 0: whoever wrote the file made none.
    if stated == 0 || start > footer_at {
        return Ok(None);
    }
    let end = footer_at + HEADER + FOOTER - 4;
    Ok((sum(file, start, end)? == stated).then_some(start))
}

/// The sum over the bytes from `start` to `end`.
fn sum(file: &mut File, start: u64, end: u64) -> io::Result<u32> {
    file.seek(SeekFrom::Start(start))?;
    let mut input = file.take(end - start);
    let (mut hasher, mut buffer) = (crc32fast::Hasher::new(), vec![0; 1 << 16]);
    loop {
        match input.read(&mut buffer)? {
            0 => return Ok(hasher.finalize()),
            read => hasher.update(&buffer[..read]),
        }
    }
}

/// The messages of each channel, where what the index names fills the bytes from `start` to `end`.
fn tiled(summary: &Summary, start: u64, end: u64) -> Option<BTreeMap<u16, u64>> {
    let mut pieces = Vec::new();
    let mut listed = BTreeMap::new();
    for chunk in &summary.chunk_indexes {
        pieces.push((
            chunk.chunk_start_offset,
            chunk.chunk_length.checked_add(chunk.message_index_length)?,
        ));
        lists(chunk, &mut listed)?;
    }
    pieces.extend(
        summary
            .attachment_indexes
            .iter()
            .map(|index| (index.offset, index.length)),
    );
    pieces.extend(
        summary
            .metadata_indexes
            .iter()
            .map(|index| (index.offset, index.length)),
    );
    pieces.sort_unstable();
    let filled = pieces.into_iter().try_fold(
        start,
        |at, (from, bytes)| {
            if from == at { at.checked_add(bytes) } else { None }
        },
    );
    (filled == Some(end)).then_some(listed)
}

/// Counts the messages in the lists behind a chunk by their lengths, where they lie one behind the other.
fn lists(chunk: &ChunkIndex, listed: &mut BTreeMap<u16, u64>) -> Option<()> {
    let mut places: Vec<(u64, u16)> = chunk.message_index_offsets.iter().map(|(id, at)| (*at, *id)).collect();
    places.sort_unstable();
    let mut end = chunk.chunk_start_offset.checked_add(chunk.chunk_length)?;
    if places.first().is_some_and(|(at, _)| *at != end) {
        return None;
    }
    end = end.checked_add(chunk.message_index_length)?;
    let ends = places.iter().skip(1).map(|(at, _)| *at).chain([end]);
    for ((at, id), end) in places.iter().zip(ends) {
        let body = end.checked_sub(*at)?.checked_sub(HEADER + LIST)?;
        if !body.is_multiple_of(LISTED) {
            return None;
        }
        if body > 0 {
            *listed.entry(*id).or_default() += body / LISTED;
        }
    }
    // Bytes behind the chunk that no channel's list accounts for.
    (!places.is_empty() || chunk.message_index_length == 0).then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::seek::places;
    use crate::testing;

    fn of(bytes: &[u8]) -> Option<BTreeMap<u16, u64>> {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        let (mut file, length) = crate::read::scan::open_file(&path).unwrap();
        let summary = places::read_summary(&mut file, length).ok().flatten()?;
        listed(&mut file, length, &summary).unwrap()
    }

    /// The same by walking through the file.
    fn walked(bytes: &[u8]) -> BTreeMap<u16, u64> {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        let (mut file, length) = crate::read::scan::open_file(&path).unwrap();
        places::Places::walk(&mut file, length).unwrap().listed
    }

    #[test]
    fn the_index_alone_counts_what_a_walk_counts() {
        for (chunks, per_chunk) in [(0, 1), (1, 1), (1, 30), (7, 5)] {
            let bytes = testing::finished(chunks, per_chunk);
            assert_eq!(of(&bytes), Some(walked(&bytes)), "{chunks} of {per_chunk}");
        }
    }

    #[test]
    fn a_file_that_was_attached_to_or_cut_is_accounted_for_too() {
        let tmp = tempfile::tempdir().unwrap();
        let (path, beside) = (tmp.path().join("s.mcap"), tmp.path().join("report.json"));
        std::fs::write(&path, testing::finished(4, 30)).unwrap();
        std::fs::write(&beside, "{}").unwrap();
        crate::edit::attach::attach(&path, &beside).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(of(&bytes), Some(walked(&bytes)));
    }

    /// Whatever bit of the index is turned, it is not gone by on its own word.
    #[test]
    fn no_damaged_index_is_relied_on_alone() {
        let bytes = testing::finished(3, 5);
        let footer = bytes.len() - (9 + 20 + 8);
        let start = u64::from_le_bytes(std::array::from_fn(|i| bytes[footer + 9 + i])) as usize;
        for at in start..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            assert_eq!(of(&flipped), None, "byte {at} of {start} to {}", bytes.len());
        }
    }

    /// A record that the index does not name, where there is room for none.
    #[test]
    fn what_the_index_does_not_name_is_looked_for_by_a_walk() {
        let bytes = testing::finished(3, 5);
        let mut summary = {
            let tmp = tempfile::tempdir().unwrap();
            let path = tmp.path().join("s.mcap");
            std::fs::write(&path, &bytes).unwrap();
            let (mut file, length) = crate::read::scan::open_file(&path).unwrap();
            places::read_summary(&mut file, length).unwrap().unwrap()
        };
        let first = summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset).min();
        let start = first.unwrap().min(summary.attachment_indexes[0].offset);
        let last = summary
            .chunk_indexes
            .iter()
            .map(|c| c.chunk_start_offset + c.chunk_length + c.message_index_length);
        let metadata = summary.metadata_indexes.iter().map(|m| m.offset + m.length);
        let end = last.chain(metadata).max().unwrap();
        assert!(tiled(&summary, start, end).is_some());
        assert!(tiled(&summary, start, end + 1).is_none() && tiled(&summary, start - 1, end).is_none());
        let removed = summary.chunk_indexes.remove(1);
        assert!(tiled(&summary, start, end).is_none(), "a gap");
        summary.chunk_indexes.extend([removed.clone(), removed]);
        assert!(tiled(&summary, start, end).is_none(), "an overlap");
    }
}
