//! What a recording holds.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use bus::message::{EmitterFrame, MarkerFrame};
use mcap::Message;

use crate::edit::progress::Progress;
use crate::edit::recovered::{self, RECOVERED};
use crate::read::damage::{Damage, OpenError};
use crate::read::one_run::OneRun;
use crate::read::reader;
use crate::read::scan::{self, Item};
use crate::read::tally::Tally;
use crate::read::timing::{self, Timing};
use crate::wire::schema::{EMITTER_SCHEMA, MARKER_SCHEMA, POSE_SCHEMA};

/// What a recording holds.
#[derive(Debug, Default)]
pub struct Info {
    /// Counts per topic.
    pub tally: Tally,
    /// Attached files: name and length in bytes.
    pub attachments: Vec<(String, usize)>,
    /// Metadata records: name and content.
    pub metadata: Vec<(String, Vec<(String, String)>)>,
    /// What could not be read; empty for a file that is whole.
    pub damage: Vec<Damage>,
    /// When messages came, by topic.
    pub timing: BTreeMap<String, Timing>,
    /// Why it is no recording of one run, in words; what is told of the run is then that of the last one.
    pub of_two_runs: Option<String>,
    one_run: OneRun,
}

impl Info {
    /// Takes note of what was found next.
    pub fn take(&mut self, item: Result<&Item, Damage>) {
        if let Some(why) = item.as_ref().ok().and_then(|item| self.one_run.beside(item)) {
            self.of_two_runs.get_or_insert(why);
        }
        match item {
            Ok(Item::Channel(channel)) => {
                self.tally.declare(channel);
            }
            Ok(Item::Message(message)) => {
                self.tally.count(message);
                self.time(message);
            }
            Ok(Item::Attachment(file)) => self.attachments.push((file.name.clone(), file.data.len())),
            Ok(Item::Metadata(facts)) => {
                let content = facts.metadata.clone().into_iter().collect();
                self.metadata.push((facts.name.clone(), content));
            }
            Err(damage) => self.damage.push(damage),
        }
    }

    fn time(&mut self, message: &Message<'_>) {
        let topic = &message.channel.topic;
        match message.channel.schema.as_ref().map_or("", |schema| &schema.name) {
            POSE_SCHEMA => {
                if let Ok(pose) = reader::decode(message) {
                    self.timing.entry(topic.clone()).or_default().pose(&pose);
                }
            }
            EMITTER_SCHEMA => {
                if let Ok(frame) = reader::decode::<EmitterFrame>(message) {
                    let stamps = [frame.t_capture_ns, frame.t_publish_ns];
                    self.timing.entry(topic.clone()).or_default().frame(frame.seq, stamps);
                }
            }
            MARKER_SCHEMA => {
                if let Ok(frame) = reader::decode::<MarkerFrame>(message) {
                    let stamps = [frame.t_capture_ns, frame.t_publish_ns];
                    self.timing.entry(topic.clone()).or_default().frame(frame.seq, stamps);
                }
            }
            _ => {}
        }
    }

    /// What was lost when a whole file was made of a damaged one, in words.
    fn losses(&self) -> impl Iterator<Item = String> {
        let records = self.metadata.iter().filter(|(name, _)| name == RECOVERED);
        records.map(|(_, facts)| recovered::words(&facts.iter().cloned().collect()))
    }

    /// Whether the file is whole, or ends as a kill leaves it: everything that was written is there.
    pub fn is_intact(&self) -> bool {
        self.damage.iter().all(|damage| damage.fault.is_mere_ending())
    }
}

/// Reads a recording, whole or not.
///
/// # Errors
/// [`OpenError`].
pub fn info(path: &Path) -> Result<Info, OpenError> {
    let mut info = Info::default();
    let mut scan = scan::open(path)?;
    let mut progress = Progress::new("reading");
    while let Some(item) = scan.next() {
        let (read, length) = scan.progress();
        progress.at(read, length);
        match item {
            Ok(item) => info.take(Ok(&item)),
            Err(damage) => info.take(Err(damage)),
        }
    }
    Ok(info)
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.tally)?;
        timing::write_table(f, self.timing.iter())?;
        for (name, length) in &self.attachments {
            writeln!(f, "attachment {name}: {length} bytes")?;
        }
        // The newest record of a name says all that the earlier ones do.
        let newest = |name: &str| self.metadata.iter().rposition(|(other, _)| other == name);
        for (index, (name, content)) in self.metadata.iter().enumerate() {
            if newest(name) == Some(index) {
                let facts: Vec<_> = content.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                writeln!(f, "{name}: {}", facts.join(", "))?;
            }
        }
        if let Some(why) = &self.of_two_runs {
            writeln!(
                f,
                "NOT OF ONE RUN: {why}; what stands here of the run is of the last one"
            )?;
        }
        let mut losses = self.losses().peekable();
        match &self.damage[..] {
            [] if losses.peek().is_some() => {
                writeln!(f, "The file is whole, but does not hold all that was recorded.")?;
                losses.try_for_each(|words| writeln!(f, "It was made of {words}."))
            }
            [] => writeln!(f, "The file is whole."),
            damage => damage.iter().try_for_each(|damage| writeln!(f, "{damage}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    fn text(bytes: &[u8]) -> String {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        info(&path).unwrap().to_string()
    }

    #[test]
    fn a_table_with_counts_rates_and_numbers() {
        let text = text(&testing::finished(2, 30));
        assert!(
            text.starts_with("from 0.000 s to 0.983 s of the run: 0.983 s\n"),
            "{text}"
        );
        let row = text.lines().find(|line| line.starts_with("/tool_pose")).unwrap();
        let cells: Vec<_> = row.split_whitespace().collect();
        assert_eq!(
            cells,
            ["/tool_pose", "60", "60.0", "0", "59", "0", "0", "0", "trocar.ToolPose"]
        );
        assert!(text.contains("attachment scene.toml: 9 bytes"), "{text}");
        assert!(text.contains("run: epoch_ns = 123456, name = demo"), "{text}");
        assert!(text.ends_with("The file is whole.\n"), "{text}");
    }

    #[test]
    fn an_unfinished_file_says_so() {
        let text = text(&testing::unfinished(2, 30));
        assert!(text.ends_with("its recording was never finished\n"), "{text}");
    }
}
