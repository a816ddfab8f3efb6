//! Whether a recording is what it claims to be: every CRC, every message, every count.
//!
//! An index, and each of its parts, is optional in MCAP (specification, "Summary Section": "the section may be absent", and so may
//! each record in it): a file of another program that has none is whole, and that is said beside it. Trocar's recorder always
//! writes one, with all its parts, so that a file of its own without is not what it wrote. Who wrote a file is told by the
//! `library` of its header, which the sum over the file's data covers.

mod content;
mod index;
mod lists;

use std::collections::BTreeMap;
use std::path::Path;

use mcap::records::Metadata;
use mcap::{Attachment, Message};
use scene::raw;

use crate::edit::cut::CUT;
use crate::edit::progress::Progress;
use crate::edit::recovered::{self, RECOVERED};
use crate::read::damage::OpenError;
use crate::read::one_run::OneRun;
use crate::read::organs::Organs;
use crate::read::reader;
use crate::read::scan::{self, Item};
use crate::read::stated::{self, Held, REPORT};
use crate::wire::proto::{MeshFrame, TissueFrame};
use crate::wire::schema::{LIBRARIES, RUN, SCENE, TISSUE_MESH_SCHEMA, TISSUE_SCHEMA, TOOL_POSE};
use content::Content;

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
    content: Content,
    /// Whether Trocar's recorder wrote the file.
    is_ours: bool,
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
        verified.is_ours = scan.library().is_some_and(|library| library.starts_with(LIBRARIES));
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
    verified.hold_index(path)?;
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
            RECOVERED => {
                // What is told of the whole is not of what was left of it.
                self.facts.is_cut = true;
                let words = recovered::words(&record.metadata);
                self.left_out.push(format!("it was made of {words}"));
            }
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
        let words = self.content.hold(message, self.is_ours);
        let organs = self.hold_organ(message);
        words
            .into_iter()
            .chain(organs)
            .for_each(|words| self.find(format!("message {number} of {topic}{words}")));
    }

    /// Holds a state of organs against its mesh, and a mesh against the examination. What cannot be decoded is told already.
    fn hold_organ(&mut self, message: &Message<'_>) -> Option<String> {
        let schema = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
        let wrong = match schema {
            TISSUE_SCHEMA => self.organs.state(&reader::decode::<TissueFrame>(message).ok()?),
            TISSUE_MESH_SCHEMA => {
                let mesh = reader::decode::<MeshFrame>(message).ok()?;
                self.organs.mesh(&mesh, self.facts.volume_hash.as_deref())
            }
            _ => None,
        };
        wrong.map(|words| format!(": {words}"))
    }
}

#[cfg(test)]
mod tests;
