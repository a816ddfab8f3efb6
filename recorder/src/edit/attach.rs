//! Attaches a file to a whole recording, in place: what is written once the session is over, such as its report.
//!
//! Chunks are not touched: the attachment takes the place of the index, which is written anew behind it. Where that is cut
//! short, the recording has no index, as one that was never finished, and `recorder recover` makes it whole.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use mcap::MAGIC;
use mcap::records::op;

use crate::read::damage::OpenError;
use crate::read::scan;
use crate::write::beside::{self, Beside};

/// Footer with its header, and the magic behind it.
const END: u64 = 9 + 20 + 8;
const DATA_END: u64 = 9 + 4;
/// Longest index.
const MAX_INDEX: u64 = 1 << 28;
/// Where a statistics record has its count of attachments.
const ATTACHMENT_COUNT: std::ops::Range<usize> = 14..18;

/// Why nothing was attached.
#[derive(Debug, thiserror::Error)]
pub(crate) enum AttachError {
    /// The recording cannot be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The recording is not whole.
    #[error(
        "{path}: {what}. Files are attached to whole recordings only: make it whole first, with `recorder recover`"
    )]
    NotWhole {
        /// The recording.
        path: PathBuf,
        /// What is wrong.
        what: &'static str,
    },
    /// Readers would take the later one.
    #[error(
        "{path} holds a file named {name:?} already, {bytes} bytes: it would be taken for the other. Give yours another name"
    )]
    Taken {
        /// The recording.
        path: PathBuf,
        /// The name.
        name: String,
        /// The length of the one that is there.
        bytes: u64,
    },
    /// The file to attach cannot be read.
    #[error("reading {path}, to attach it: {source}")]
    File {
        /// The file to attach.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The recording cannot be written.
    #[error("attaching to {path}: {source}. Its messages are all there; `recorder recover` brings back its index")]
    Write {
        /// The recording.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Attaches `file` to the whole recording `session`, which holds none of this name.
///
/// # Errors
/// Each variant of [`AttachError`].
pub(crate) fn attach(session: &Path, file: &Path) -> Result<(), AttachError> {
    let beside = beside::read(file).map_err(|source| AttachError::File {
        path: file.to_owned(),
        source,
    })?;
    let (_, length) = scan::open_file(session)?;
    let fail = |source| AttachError::Write {
        path: session.to_owned(),
        source,
    };
    let mut target = File::options().read(true).write(true).open(session).map_err(fail)?;
    let tail = read_tail(&mut target, length).map_err(fail)?;
    let tail = tail.map_err(|what| AttachError::NotWhole {
        path: session.to_owned(),
        what,
    })?;
    if let Some(bytes) = tail.attached(&beside.name) {
        let (path, name) = (session.to_owned(), beside.name);
        return Err(AttachError::Taken { path, name, bytes });
    }
    let (at, bytes) = tail.with(&beside);
    let written = target.seek(SeekFrom::Start(at)).and_then(|_| target.write_all(&bytes));
    written.and_then(|()| target.sync_all()).map_err(fail)
}

/// What lies behind the data of a whole recording.
struct Tail {
    /// Where the record lies that ends the data.
    at: u64,
    data_crc: u32,
    /// Records of the index, each with its header.
    index: Vec<(u8, Vec<u8>)>,
}

/// Reads what lies behind the data; the inner error says what a whole recording has and this one has not.
fn read_tail(file: &mut File, length: u64) -> io::Result<Result<Tail, &'static str>> {
    let no_index = Ok(Err("it has no index: its recording was never finished"));
    let Some(footer_at) = length.checked_sub(END) else {
        return no_index;
    };
    let footer = read_at(file, footer_at, END)?;
    if !footer.ends_with(MAGIC) || footer[0] != op::FOOTER {
        return no_index;
    }
    let start = u64_at(&footer, 9);
    let Some(at) = start.checked_sub(DATA_END).filter(|_| start <= footer_at) else {
        return no_index;
    };
    if footer_at - start > MAX_INDEX {
        return Ok(Err("its index is too long to be one"));
    }
    let data_end = read_at(file, at, DATA_END)?;
    if data_end[0] != op::DATA_END || u64_at(&data_end, 1) != 4 {
        return Ok(Err("its data do not end where its index begins"));
    }
    let bytes = read_at(file, start, footer_at - start)?;
    Ok(records(&bytes).ok_or("its index is damaged").map(|index| Tail {
        at,
        data_crc: u32::from_le_bytes(std::array::from_fn(|i| data_end[9 + i])),
        index,
    }))
}

fn read_at(file: &mut File, at: u64, length: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    match bytes.len() as u64 == length {
        true => Ok(bytes),
        false => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

/// The records in these bytes but for those that say where groups of records begin, which are made anew.
fn records(mut bytes: &[u8]) -> Option<Vec<(u8, Vec<u8>)>> {
    let mut records = Vec::new();
    while !bytes.is_empty() {
        let header = bytes.get(..9)?;
        let length = usize::try_from(u64_at(header, 1)).ok()?.checked_add(9)?;
        let record = bytes.get(..length)?;
        if header[0] == op::STATISTICS && record.len() < 9 + ATTACHMENT_COUNT.end {
            return None;
        }
        if header[0] != op::SUMMARY_OFFSET {
            records.push((header[0], record.to_vec()));
        }
        bytes = &bytes[length..];
    }
    Some(records)
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

/// Text with its length in front. Names of files are short.
fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn attachment(file: &Beside) -> Vec<u8> {
    let mut body = [0_u64.to_le_bytes(), file.changed_ns.to_le_bytes()].concat();
    body.extend(text(&file.name));
    body.extend(text(file.media_type));
    body.extend((file.bytes.len() as u64).to_le_bytes());
    body.extend(&file.bytes);
    body.extend(crc32fast::hash(&body).to_le_bytes());
    record(op::ATTACHMENT, &body)
}

impl Tail {
    /// How long the attached file of this name is, where the index has one.
    fn attached(&self, name: &str) -> Option<u64> {
        let wanted = text(name);
        let entries = self.index.iter().filter(|(opcode, _)| *opcode == op::ATTACHMENT_INDEX);
        let mut bodies = entries.filter_map(|(_, record)| record.get(9..));
        // Behind five numbers of 8 bytes, of which the last is the length.
        bodies.find_map(|body| body.get(40..)?.starts_with(&wanted).then(|| u64_at(body, 32)))
    }

    /// The place and the bytes of a tail with this file in front.
    fn with(mut self, file: &Beside) -> (u64, Vec<u8>) {
        let mut bytes = attachment(file);
        self.note(file, bytes.len() as u64);
        let crc = match self.data_crc {
            // Not everybody writes one.
            0 => 0,
            crc => {
                let mut hasher = crc32fast::Hasher::new_with_initial(crc);
                hasher.update(&bytes);
                hasher.finalize()
            }
        };
        bytes.extend(record(op::DATA_END, &crc.to_le_bytes()));
        let start = self.at + bytes.len() as u64;
        bytes.extend(index(&self.index, start));
        (self.at, bytes)
    }

    /// Takes the attachment into the index.
    fn note(&mut self, file: &Beside, length: u64) {
        let numbers = [self.at, length, 0, file.changed_ns, file.bytes.len() as u64];
        let mut body: Vec<u8> = numbers.into_iter().flat_map(u64::to_le_bytes).collect();
        body.extend(text(&file.name));
        body.extend(text(file.media_type));
        self.index
            .push((op::ATTACHMENT_INDEX, record(op::ATTACHMENT_INDEX, &body)));
        // Readers want those of a kind together.
        self.index.sort_by_key(|(opcode, _)| *opcode);
        for (_, record) in self.index.iter_mut().filter(|(opcode, _)| *opcode == op::STATISTICS) {
            let count = &mut record[9..][ATTACHMENT_COUNT];
            let new = u32::from_le_bytes(std::array::from_fn(|i| count[i])).saturating_add(1);
            count.copy_from_slice(&new.to_le_bytes());
        }
    }
}

/// The index from byte `start` of the file on, with where its groups begin, its footer and the magic.
fn index(records: &[(u8, Vec<u8>)], start: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut offsets = Vec::new();
    for group in records.chunk_by(|a, b| a.0 == b.0) {
        let at = start + bytes.len() as u64;
        group.iter().for_each(|(_, record)| bytes.extend(record));
        let length = start + bytes.len() as u64 - at;
        let body = [&[group[0].0], &at.to_le_bytes()[..], &length.to_le_bytes()].concat();
        offsets.extend(record(op::SUMMARY_OFFSET, &body));
    }
    let offsets_at = start + bytes.len() as u64;
    bytes.extend(offsets);
    bytes.push(op::FOOTER);
    bytes.extend(20_u64.to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend(offsets_at.to_le_bytes());
    let crc = crc32fast::hash(&bytes);
    bytes.extend(crc.to_le_bytes());
    bytes.extend(MAGIC);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::fs;

    fn world(bytes: &[u8]) -> (tempfile::TempDir, PathBuf, PathBuf) {
        let tmp = tempfile::tempdir().unwrap();
        let (session, report) = (tmp.path().join("s.mcap"), tmp.path().join("report.json"));
        fs::write(&session, bytes).unwrap();
        fs::write(&report, "{\"views\": []}").unwrap();
        (tmp, session, report)
    }

    #[test]
    fn a_file_is_attached_and_everything_else_stays() {
        let (tmp, session, report) = world(&testing::finished(3, 4));
        let before = crate::read::info::info(&session).unwrap();
        attach(&session, &report).unwrap();
        let more = tmp.path().join("more.txt");
        fs::write(&more, "more").unwrap();
        attach(&session, &more).unwrap();
        let after = crate::read::info::info(&session).unwrap();
        // Both CRCs of the file, over its data and over its index, are among what is checked.
        assert!(after.damage.is_empty(), "{:?}", after.damage);
        assert_eq!((before.tally, before.metadata), (after.tally, after.metadata));
        let names: Vec<_> = after.attachments.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["scene.toml", "report.json", "more.txt"]);
        let found = crate::read::verify::verify(&session).unwrap();
        assert!(found.findings.is_empty(), "{:?}", found.findings);
        let indexed = crate::read::seek::Session::open(&session).unwrap();
        assert!(indexed.is_indexed());
        assert_eq!(
            indexed.attachment("report.json").unwrap().as_deref(),
            Some(&b"{\"views\": []}"[..])
        );
    }

    /// A second scene took the place of the run's own.
    #[test]
    fn a_name_that_is_attached_already_is_refused_and_the_recording_stays() {
        let (tmp, session, report) = world(&testing::finished(1, 4));
        attach(&session, &report).unwrap();
        let before = fs::read(&session).unwrap();
        let scene = tmp.path().join("scene.toml");
        fs::write(&scene, "seed = 2\n").unwrap();
        for (file, words) in [
            (&scene, "\"scene.toml\" already, 9 bytes"),
            (&report, "\"report.json\" already"),
        ] {
            let text = attach(&session, file).unwrap_err().to_string();
            assert!(text.contains(words), "{text}");
            assert_eq!(fs::read(&session).unwrap(), before);
        }
    }

    #[test]
    fn cut_short_while_attaching_no_message_is_lost() {
        let (_tmp, session, report) = world(&testing::finished(3, 4));
        let old = fs::read(&session).unwrap();
        attach(&session, &report).unwrap();
        let new = fs::read(&session).unwrap();
        let same = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
        for written in 0..new.len() - same {
            let mut torn = old.clone();
            torn.resize(old.len().max(same + written), 0);
            torn[same..same + written].copy_from_slice(&new[same..same + written]);
            fs::write(&session, &torn).unwrap();
            let info = crate::read::info::info(&session).unwrap();
            assert_eq!(info.tally.topics["/tool_pose"].messages, 12, "after {written} bytes");
        }
    }

    #[test]
    fn what_is_not_whole_is_refused() {
        for bytes in [testing::unfinished(2, 2), testing::finished(2, 2)[..900].to_vec()] {
            let (_tmp, session, report) = world(&bytes);
            let text = attach(&session, &report).unwrap_err().to_string();
            assert!(text.contains("recorder recover"), "{text}");
            assert_eq!(fs::read(&session).unwrap(), bytes);
        }
        let (tmp, session, _) = world(&testing::finished(1, 1));
        let text = attach(&session, &tmp.path().join("missing")).unwrap_err().to_string();
        assert!(text.contains("missing, to attach it"), "{text}");
    }
}
