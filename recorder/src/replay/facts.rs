//! What must be known of a recording before it is replayed.

mod indexed;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use mcap::Channel;
use prost::Message as _;
use prost_types::FileDescriptorSet;
use serde::Serialize;

use crate::read::damage::OpenError;
use crate::read::one_run::OneRun;
use crate::read::scan::{self, Item};
use crate::replay::tape::impossible_stamp;
use crate::wire::descriptor;
use crate::wire::proto::{DecodeError, decode_pose};
use crate::wire::schema::{
    EMITTER_SCHEMA, EMITTERS, GROUND_TRUTH, GUIDE, GUIDE_SCHEMA, MARKER_SCHEMA, MARKERS, POSE_SCHEMA, RUN, SCENE,
    TOOL_POSE,
};
use crate::write::beside;

/// What a recording says of itself, as far as a replay needs it.
#[derive(Debug, Default, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// The attached scene; `None` where there is none.
    pub scene: Option<String>,
    /// The name of the run that was recorded.
    pub run: Option<String>,
    /// The examination that was navigated in.
    pub volume_hash: Option<String>,
    /// The registration that the poses rest on.
    pub registration_id: Option<String>,
    /// Poses of the tool.
    pub poses: u64,
    /// True poses of the simulated tool.
    pub truths: u64,
    /// When the first pose was published, ns on the run's clock.
    pub first_ns: i64,
    /// When the last one was.
    pub last_ns: i64,
    /// Frames of emitters of which poses can be made again.
    pub emitters: u64,
    /// Why none can, although there are some, in words.
    pub emitters_refused: Option<String>,
    /// Frames of markers of which poses can be made again.
    pub markers: u64,
    /// Why none can, although there are some, in words.
    pub markers_refused: Option<String>,
    /// The text files attached beside the scene: calibrations and registrations.
    pub files: Vec<AttachedText>,
    /// What cannot be read, in words; empty for a file that is whole.
    pub damage: Vec<String>,
    #[serde(skip)]
    one_run: OneRun,
}

/// A text file that a recording holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AttachedText {
    /// Its name.
    pub name: String,
    /// What it says.
    pub text: String,
}

/// More attached files are not looked at, nor longer ones: a recorder attaches no more of them.
const MOST_FILES: usize = 64;

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum FactsError {
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// It has no poses.
    #[error(
        "{path} holds no poses (topic {TOOL_POSE}): there is nothing to replay. `recorder info` says what it holds"
    )]
    NoPoses {
        /// The recording.
        path: PathBuf,
    },
    /// Its poses are of another kind.
    #[error("{path}: topic {topic} holds {found:?} where {wanted:?} is needed; this version can replay nothing else")]
    Schema {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The schema found.
        found: String,
        /// The schema needed.
        wanted: &'static str,
    },
    /// It is of more than one run, or holds more than one scene.
    #[error("{path}: {why}; only a recording of one run, with its scene, can be replayed")]
    TwoRuns {
        /// The recording.
        path: PathBuf,
        /// What was found and expected.
        why: String,
    },
    /// Its messages have fields that this version would leave out.
    #[error(
        "{path}: the messages of topic {topic} have fields that this version does not know ({unknown}), and would be replayed \
         without them. Replay the file with the version that recorded it, or a later one"
    )]
    Newer {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The unknown fields: names and numbers.
        unknown: String,
    },
    /// A pose of a time that no clock shows.
    #[error(
        "{path}: message {number} of topic {topic}: pose {seq} was {what} at {found_ns} ns; stamps are ns since the run's \
         epoch, and below 2^61"
    )]
    Stamp {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Which message of it, from 1.
        number: u64,
        /// Which pose.
        seq: u64,
        /// captured or published
        what: &'static str,
        /// The stamp.
        found_ns: i64,
    },
    /// A message is not a pose.
    #[error("{path}: message {number} of topic {topic}: {source}")]
    Decode {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Which message of it, from 1.
        number: u64,
        /// What is wrong.
        source: DecodeError,
    },
}

/// What a recording says of itself, by its index where that can be relied on; else it is read from start to end, and why is
/// said on stderr. By the index, damage within the chunks is not known.
///
/// # Errors
/// [`FactsError`].
pub fn facts(path: &Path) -> Result<Facts, FactsError> {
    match indexed::facts(path) {
        Ok(facts) => some_poses(path, facts),
        Err(why) => {
            if path.is_file() {
                bus::stderr_line!("recorder: {}: {why}: it is read from start to end", path.display());
            }
            facts_of_all(path)
        }
    }
}

/// The same of every message, whatever the index says.
///
/// # Errors
/// [`FactsError`].
pub fn facts_of_all(path: &Path) -> Result<Facts, FactsError> {
    some_poses(path, read(path)?)
}

fn some_poses(path: &Path, facts: Facts) -> Result<Facts, FactsError> {
    match facts.poses {
        0 => Err(FactsError::NoPoses { path: path.to_owned() }),
        _ => Ok(facts),
    }
}

fn read(path: &Path) -> Result<Facts, FactsError> {
    let mut facts = Facts::default();
    for item in scan::open(path)? {
        match item {
            Ok(Item::Channel(channel)) => facts.declare(path, &channel)?,
            Ok(Item::Message(message)) => facts.count(path, &message)?,
            Ok(item) => facts.beside(path, item)?,
            Err(damage) => facts.damage.push(damage.to_string()),
        }
    }
    Ok(facts)
}

impl Facts {
    /// Refuses channels whose messages cannot be replayed.
    fn declare(&mut self, path: &Path, channel: &Channel<'_>) -> Result<(), FactsError> {
        match channel.topic.as_str() {
            TOOL_POSE | GROUND_TRUTH => check_schema(path, channel, POSE_SCHEMA, descriptor::TOOL_POSE)?,
            GUIDE => check_schema(path, channel, GUIDE_SCHEMA, descriptor::GUIDE)?,
            EMITTERS => {
                // Only poses that are made again need these.
                let refused = check_schema(path, channel, EMITTER_SCHEMA, descriptor::EMITTER_FRAME);
                self.emitters_refused = refused.err().map(|error| error.to_string());
            }
            MARKERS => {
                let refused = check_schema(path, channel, MARKER_SCHEMA, descriptor::MARKER_FRAME);
                self.markers_refused = refused.err().map(|error| error.to_string());
            }
            _ => {}
        }
        Ok(())
    }

    /// Takes what lies beside the messages, unless it is of another run.
    fn beside(&mut self, path: &Path, item: Item) -> Result<(), FactsError> {
        if let Some(why) = self.one_run.beside(&item) {
            let path = path.to_owned();
            return Err(FactsError::TwoRuns { path, why });
        }
        match item {
            Item::Attachment(file) if file.name == SCENE => {
                self.scene = String::from_utf8(file.data.into_owned()).ok();
            }
            Item::Attachment(file) if file.name.ends_with(".json") => self.keep(file.name, &file.data),
            Item::Metadata(metadata) if metadata.name == RUN => self.take(metadata.metadata),
            _ => {}
        }
        Ok(())
    }

    fn count(&mut self, path: &Path, message: &mcap::Message<'_>) -> Result<(), FactsError> {
        let topic = message.channel.topic.as_str();
        let number = match topic {
            TOOL_POSE => &mut self.poses,
            GROUND_TRUTH => &mut self.truths,
            EMITTERS => {
                self.emitters += 1;
                return Ok(());
            }
            MARKERS => {
                self.markers += 1;
                return Ok(());
            }
            _ => return Ok(()),
        };
        *number += 1;
        let pose = decode_pose(&message.data).map_err(|source| FactsError::Decode {
            path: path.to_owned(),
            topic: topic.to_owned(),
            number: *number,
            source,
        })?;
        if let Some((what, found_ns)) = impossible_stamp(&pose) {
            return Err(FactsError::Stamp {
                path: path.to_owned(),
                topic: topic.to_owned(),
                number: *number,
                seq: pose.seq,
                what,
                found_ns,
            });
        }
        if topic == TOOL_POSE {
            let first = self.poses == 1;
            let t = pose.t_publish_ns;
            self.first_ns = if first { t } else { self.first_ns.min(t) };
            self.last_ns = if first { t } else { self.last_ns.max(t) };
        }
        Ok(())
    }

    /// Keeps a text file, unless there are too many, or it is too long.
    fn keep(&mut self, name: String, data: &[u8]) {
        if self.files.len() < MOST_FILES
            && data.len() as u64 <= beside::MAX_BYTES
            && let Ok(text) = String::from_utf8(data.to_vec())
        {
            self.files.push(AttachedText { name, text });
        }
    }

    /// Metadata is written again when more is known: the last one counts.
    fn take(&mut self, mut metadata: std::collections::BTreeMap<String, String>) {
        self.run = metadata.remove("name");
        self.volume_hash = metadata.remove("volume_hash");
        self.registration_id = metadata.remove("registration_id");
    }
}

/// Refuses messages of another kind than `wanted`, or with fields that would be lost on the way.
fn check_schema(path: &Path, channel: &Channel<'_>, wanted: &'static str, known: &[u8]) -> Result<(), FactsError> {
    let topic = &channel.topic;
    let name = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
    if name != wanted {
        return Err(FactsError::Schema {
            path: path.to_owned(),
            topic: topic.clone(),
            found: name.to_owned(),
            wanted,
        });
    }
    let unknown = unknown_fields(channel, known);
    if unknown.is_empty() {
        return Ok(());
    }
    Err(FactsError::Newer {
        path: path.to_owned(),
        topic: topic.clone(),
        unknown,
    })
}

/// The fields of a channel's messages that the schema `known` has not, as names with numbers; empty where there are none.
pub(crate) fn unknown_fields(channel: &Channel<'_>, known: &[u8]) -> String {
    let data = channel.schema.as_ref().map_or(&[][..], |schema| &*schema.data);
    let known = fields(known);
    let unknown: Vec<String> = fields(data)
        .difference(&known)
        .map(|(number, name)| format!("{name} = {number}"))
        .collect();
    unknown.join(", ")
}

/// Numbers and names of the fields of every message of a schema; none where it cannot be read.
fn fields(schema: &[u8]) -> BTreeSet<(i32, String)> {
    let files = FileDescriptorSet::decode(schema).unwrap_or_default().file;
    let messages = files.into_iter().flat_map(|file| file.message_type);
    let fields = messages.flat_map(|message| message.field);
    fields.map(|field| (field.number(), field.name().to_owned())).collect()
}

#[cfg(test)]
mod tests;
