//! Whether a recording is what it claims to be: every CRC, every message, every count.
//!
//! An index, and each of its parts, is optional in MCAP (specification, "Summary Section": "the section may be absent", and so may
//! each record in it): a file of another program that has none is whole, and that is said beside it. Trocar's recorder always
//! writes one, with all its parts, so that a file of its own without is not what it wrote. Who wrote a file is told by the
//! `library` of its header, which the sum over the file's data covers.

use std::collections::BTreeMap;
use std::path::Path;

use bus::message::{EmitterFrame, MarkerFrame, ToolPose};
use mcap::records::Metadata;
use mcap::{Attachment, Message, Summary};
use scene::raw;

use crate::edit::cut::CUT;
use crate::edit::progress::Progress;
use crate::read::damage::OpenError;
use crate::read::one_run::OneRun;
use crate::read::organs::Organs;
use crate::read::reader::{self, ReadError, Recorded};
use crate::read::scan::{self, Item};
use crate::read::seek;
use crate::read::stated::{self, Held, REPORT};
use crate::wire::proto::{MeshFrame, TissueFrame, UsFrame};
use crate::wire::schema::{
    EMITTER_SCHEMA, LIBRARIES, MARKER_SCHEMA, POSE_SCHEMA, RAW_IMAGE_SCHEMA, RUN, SCENE, TISSUE_MESH_SCHEMA,
    TISSUE_SCHEMA, TOOL_POSE, US_IMAGE,
};

/// More are counted, not named.
const NAMED: usize = 100;

/// What was looked at, and what is wrong with it.
#[derive(Debug, Default)]
pub struct Verified {
    /// Messages read.
    pub messages: u64,
    /// Attached files read.
    pub attachments: u64,
    /// What is wrong, in words; at most 100 of them.
    pub findings: Vec<String>,
    /// How many findings there are.
    pub found: u64,
    /// What the file leaves out and may, in words.
    pub left_out: Vec<String>,
    counts: BTreeMap<u16, (String, u64)>,
    last: BTreeMap<u16, (u64, u64)>,
    one_run: OneRun,
    organs: Organs,
    facts: Facts,
}

/// What lies beside the messages, as far as others are held against it.
#[derive(Debug, Default)]
struct Facts {
    volume_hash: Option<String>,
    seed: Option<u64>,
    report: Option<Vec<u8>>,
    is_cut: bool,
}

/// Reads a recording from start to end and holds it against its index.
///
/// # Errors
/// [`OpenError`].
pub fn verify(path: &Path) -> Result<Verified, OpenError> {
    let mut verified = Verified::default();
    let mut scan = scan::open(path)?;
    let mut progress = Progress::new("verifying");
    while let Some(item) = scan.next() {
        let (read, length) = scan.progress();
        progress.at(read, length);
        let of_another = item.as_ref().ok().and_then(|item| verified.one_run.beside(item));
        of_another.into_iter().for_each(|words| verified.find(words));
        match item {
            Ok(Item::Message(message)) => verified.message(&message),
            Ok(Item::Attachment(file)) => verified.attached(&file),
            Ok(Item::Metadata(record)) => verified.beside(&record),
            Ok(_) => {}
            Err(damage) => verified.find(damage.to_string()),
        }
    }
    verified.hold_organs();
    let is_ours = scan.library().is_some_and(|library| library.starts_with(LIBRARIES));
    verified.hold_index(path, is_ours)?;
    Ok(verified)
}

impl Verified {
    fn find(&mut self, words: String) {
        self.found += 1;
        if self.findings.len() < NAMED {
            self.findings.push(words);
        }
    }

    fn attached(&mut self, file: &Attachment<'_>) {
        self.attachments += 1;
        match file.name.as_str() {
            SCENE => {
                self.organs.scene(&file.data);
                let text = std::str::from_utf8(&file.data).unwrap_or_default();
                let source = raw::parse(text, Path::new(SCENE)).ok();
                self.facts.seed = source.map(|source| source.scene.seed);
            }
            REPORT => self.facts.report = Some(file.data.to_vec()),
            _ => {}
        }
    }

    fn beside(&mut self, record: &Metadata) {
        match record.name.as_str() {
            RUN => {
                let hash = record.metadata.get("volume_hash").cloned();
                self.facts.volume_hash = hash.or(self.facts.volume_hash.take());
            }
            // What is told of the whole is not of a part.
            CUT => self.facts.is_cut = true,
            _ => {}
        }
    }

    /// Holds states against meshes that came behind them, and the run's report against all.
    fn hold_organs(&mut self) {
        let at_end: Vec<String> = self.organs.at_end().collect();
        at_end.into_iter().for_each(|words| self.find(words));
        let poses = self.counts.values().find(|(topic, _)| topic == TOOL_POSE);
        let held = Held {
            volume_hash: self.facts.volume_hash.as_deref(),
            seed: self.facts.seed,
            poses: poses.map_or(0, |(_, count)| *count),
            is_whole: self.found == 0 && !self.facts.is_cut,
        };
        let report = self.facts.report.as_deref();
        let denied = report.map(|report| stated::denied(report, &held, &self.organs));
        denied.into_iter().flatten().for_each(|words| self.find(words));
    }

    fn message(&mut self, message: &Message<'_>) {
        self.messages += 1;
        let topic = &message.channel.topic;
        let (_, count) = self
            .counts
            .entry(message.channel.id)
            .or_insert_with(|| (topic.clone(), 0));
        *count += 1;
        let number = *count;
        let schema = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
        let stamps = match schema {
            POSE_SCHEMA => stamps::<ToolPose>(message, |pose| (pose.seq, pose.t_capture_ns)),
            EMITTER_SCHEMA => stamps::<EmitterFrame>(message, |frame| (frame.seq, frame.t_capture_ns)),
            // Images of other programs have this schema too.
            RAW_IMAGE_SCHEMA if topic == US_IMAGE => {
                stamps::<UsFrame>(message, |image| (image.header.seq, image.header.t_capture_ns))
            }
            TISSUE_SCHEMA => reader::decode::<TissueFrame>(message).map(|state| {
                let wrong = self.organs.state(&state);
                wrong
                    .into_iter()
                    .for_each(|words| self.find(format!("message {number} of {topic}: {words}")));
                (state.header.seq, state.header.t_capture_ns)
            }),
            TISSUE_MESH_SCHEMA => {
                let mesh = reader::decode::<MeshFrame>(message).map_err(|error| error.to_string());
                let volume_hash = self.facts.volume_hash.as_deref();
                let wrong = mesh.map_or_else(Some, |mesh| self.organs.mesh(&mesh, volume_hash));
                wrong
                    .into_iter()
                    .for_each(|words| self.find(format!("message {number} of {topic}: {words}")));
                return;
            }
            MARKER_SCHEMA => stamps::<MarkerFrame>(message, |frame| (frame.seq, frame.t_capture_ns)),
            _ => return,
        };
        match stamps {
            Ok((seq, t_ns)) => self.order(message, number, seq, t_ns),
            Err(error) => self.find(format!("message {number} of {topic}: {error}")),
        }
    }

    /// Holds a message's header against its content, and it against the one before.
    fn order(&mut self, message: &Message<'_>, number: u64, seq: u64, t_ns: i64) {
        let topic = message.channel.topic.clone();
        let of = |what: &str| format!("message {number} of {topic} (number {seq}): {what}");
        if message.sequence != seq as u32 || message.log_time != crate::wire::proto::file_time(t_ns) {
            let (sequence, log_time) = (message.sequence, message.log_time);
            self.find(of(&format!(
                "its header says number {sequence} and {log_time} ns instead of {t_ns} ns"
            )));
        }
        let last = self.last.insert(message.channel.id, (seq, message.log_time));
        let Some((last_seq, last_ns)) = last else { return };
        // A publisher that was restarted begins anew.
        if seq > last_seq && message.log_time < last_ns {
            self.find(of(&format!(
                "captured at {} ns, before number {last_seq} at {last_ns} ns",
                message.log_time
            )));
        } else if seq == last_seq {
            self.find(of("the number of the one before it"));
        }
    }

    fn hold(&mut self, what: &str, stated: u64, found: u64) {
        if stated != found {
            self.find(format!("the index states {stated} {what}, and there are {found}"));
        }
    }

    /// Holds the index against what was read.
    fn hold_index(&mut self, path: &Path, is_ours: bool) -> Result<(), OpenError> {
        let summary = match seek::stated(path)? {
            seek::Stated::Index(summary) => summary,
            seek::Stated::Unnamed(summary) if !is_ours => {
                self.left_out
                    .push("its index repeats channels without their schemas".to_owned());
                summary
            }
            seek::Stated::Unnamed(_) => {
                self.find(
                    "the index has channels without their schemas, and Trocar's recorder repeats these".to_owned(),
                );
                return Ok(());
            }
            seek::Stated::Nothing if is_ours => {
                self.find("the file has no index, and Trocar's recorder writes one".to_owned());
                return Ok(());
            }
            seek::Stated::Nothing => {
                self.left_out.push("it has no index".to_owned());
                return Ok(());
            }
            seek::Stated::Unreadable(why) => {
                self.find(format!("the file has no index that can be read: {why}"));
                return Ok(());
            }
        };
        self.index(&summary, is_ours);
        let seek::Differences { found, left_out } = seek::differences(path, &summary, is_ours)?;
        found.into_iter().for_each(|words| self.find(words));
        self.left_out.extend(left_out);
        Ok(())
    }

    fn index(&mut self, summary: &Summary, is_ours: bool) {
        let Some(stats) = &summary.stats else {
            match is_ours {
                true => self.find("the index counts nothing, and Trocar's recorder counts".to_owned()),
                false => self.left_out.push("its index counts nothing".to_owned()),
            }
            return;
        };
        self.hold("messages", stats.message_count, self.messages);
        self.hold("attachments", stats.attachment_count.into(), self.attachments);
        for (channel, (topic, found)) in std::mem::take(&mut self.counts) {
            let stated = stats.channel_message_counts.get(&channel).copied().unwrap_or(0);
            self.hold(&format!("messages of {topic}"), stated, found);
        }
    }
}

fn stamps<T: Recorded>(message: &Message<'_>, of: impl Fn(&T) -> (u64, i64)) -> Result<(u64, i64), ReadError> {
    reader::decode::<T>(message).map(|decoded| of(&decoded))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use crate::wire::schema::Source;
    use crate::write::pose_log::Entry;

    fn verified(bytes: &[u8]) -> Verified {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        verify(&path).unwrap()
    }

    #[test]
    fn a_whole_file_has_no_findings() {
        let found = verified(&testing::finished(3, 5));
        assert_eq!(
            (found.messages, found.attachments, found.found),
            (15 * 5, 1, 0),
            "{:?}",
            found.findings
        );
    }

    #[test]
    fn every_flipped_bit_of_the_data_is_found() {
        let bytes = testing::finished(2, 4);
        let data = bytes.windows(4).rposition(|w| w == b"zstd").unwrap();
        for at in 8..data {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            assert!(verified(&flipped).found > 0, "byte {at}");
        }
    }

    /// Where each chunk has the name of its compression.
    fn compressed(bytes: &[u8]) -> Vec<usize> {
        let words = bytes.windows(4).enumerate();
        words.filter(|(_, w)| w == b"zstd").map(|(at, _)| at).collect()
    }

    #[test]
    fn a_chunk_whose_head_is_flipped_is_named_with_its_messages() {
        let bytes = testing::finished(3, 5);
        // The chunk of poses 5 to 9: its opcode, and a byte of its length.
        let chunks = compressed(&bytes);
        // Opcode, length, two times, size, CRC, length of this word. The first chunk holds the schemas.
        let head = chunks[2] - (1 + 8 + 16 + 8 + 4 + 4);
        for (at, bit) in [(head, 0x40), (head + 1 + 3, 0x20)] {
            let mut flipped = bytes.clone();
            flipped[at] ^= bit;
            let found = verified(&flipped).findings.join("\n");
            let words =
                format!("the chunk that the index has at byte {head} is not readable; lost are 5 of /tool_pose");
            assert!(found.contains(&words), "{found}");
            assert!(found.contains("captured from 83333333 ns to 150000000 ns"), "{found}");
        }
    }

    #[test]
    fn every_flipped_bit_of_a_chunks_content_names_its_messages() {
        let bytes = testing::finished(3, 2);
        let chunks = compressed(&bytes);
        // Behind the word is the length of what is compressed.
        let from = chunks[2] + 4;
        let length = u64::from_le_bytes(bytes[from..from + 8].try_into().unwrap()) as usize;
        let (whole, mut harmless) = (verified(&bytes).messages, 0);
        for at in from + 8..from + 8 + length {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            let found = verified(&flipped);
            // A bit that the compression does not need: every message is there, and only the sum over the file is wrong.
            if found.messages == whole {
                harmless += 1;
                continue;
            }
            let found = found.findings.join("\n");
            let words = "2 of /tool_pose (numbers 2 to 3, captured from 33333333 ns to 50000000 ns)";
            assert!(found.contains(words), "byte {at}: {found}");
        }
        assert!(harmless < length / 10, "{harmless} of {length}");
    }

    #[test]
    fn an_attachment_whose_bytes_changed_is_named() {
        let mut bytes = testing::finished(1, 1);
        let at = bytes.windows(8).position(|w| w == b"seed = 1").unwrap();
        bytes[at] ^= 1;
        let found = verified(&bytes).findings;
        assert!(
            found[0].contains("damaged attachment") && found[0].contains("CRC"),
            "{found:?}"
        );
    }

    #[test]
    fn messages_out_of_order_are_named() {
        let mut log = testing::log(1, 3);
        let mut early = testing::pose(3);
        early.t_capture_ns = 5;
        log.put(Entry::Pose(Source::Tool, &early)).unwrap();
        log.put(Entry::Pose(Source::Tool, &early)).unwrap();
        let found = verified(&log.finish().unwrap().into_inner()).findings;
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            found[0].starts_with("message 4 of /tool_pose (number 3): captured at 5 ns, before number 2"),
            "{found:?}"
        );
        assert!(found[1].contains("the number of the one before it"), "{found:?}");
    }

    /// The file without its index, as a program would write it that writes none; the sum over its data stays right.
    fn without_index(bytes: &[u8]) -> Vec<u8> {
        let footer = bytes.len() - 8 - 20;
        let start = u64::from_le_bytes(bytes[footer..footer + 8].try_into().unwrap()) as usize;
        let head = [&[2][..], &20_u64.to_le_bytes(), &[0; 16]].concat();
        let sum = crc32fast::hash(&head);
        [&bytes[..start], &head, &sum.to_le_bytes(), mcap::MAGIC].concat()
    }

    #[test]
    fn only_what_trocar_wrote_must_have_an_index() {
        let bytes = without_index(&testing::finished(2, 4));
        let found = verified(&bytes).findings;
        assert_eq!(found, ["the file has no index, and Trocar's recorder writes one"]);
        // The same of another program: its name is in the header, and the sum over the data at their end.
        let mut other = bytes;
        let name = other
            .windows(LIBRARIES.len())
            .position(|w| w == LIBRARIES.as_bytes())
            .unwrap();
        other[name..name + 6].copy_from_slice(b"tricar");
        let end = other.len() - 8 - 29 - 4;
        let sum = crc32fast::hash(&other[..end - 9]);
        other[end..end + 4].copy_from_slice(&sum.to_le_bytes());
        let found = verified(&other);
        assert_eq!(
            (found.found, found.left_out),
            (0, vec!["it has no index".to_owned()]),
            "{:?}",
            found.findings
        );
    }

    #[test]
    fn what_is_no_file_is_refused_at_once() {
        let tmp = tempfile::tempdir().unwrap();
        let pipe = tmp.path().join("pipe.mcap");
        let (kind, mode) = (rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR);
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).unwrap();
        for (path, words) in [
            (pipe.as_path(), "this is a pipe"),
            (Path::new("/dev/zero"), "this is a device"),
        ] {
            let said = verify(path).unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
            assert!(crate::read::seek::Session::open(path).is_err() && crate::read::info::info(path).is_err());
            assert!(crate::edit::import::import(path, None, &tmp.path().join("out.mcap"), false).is_err());
            assert!(crate::write::beside::read(path).is_err());
        }
    }

    #[test]
    fn an_unfinished_file_says_so() {
        let found = verified(&testing::unfinished(2, 2)).findings;
        assert!(
            found[0].contains("never finished") && found[1].contains("no index"),
            "{found:?}"
        );
    }
}
