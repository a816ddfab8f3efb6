//! What must be known of a recording before it is replayed.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bus::message::ToolPose;
use mcap::Channel;
use prost::Message as _;
use prost_types::FileDescriptorSet;
use serde::Serialize;

use crate::damage::OpenError;
use crate::descriptor;
use crate::proto::{DecodeError, decode_pose};
use crate::scan::{self, Item};
use crate::schema::{GROUND_TRUTH, POSE_SCHEMA, RUN, SCENE, TOOL_POSE};

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
    /// What cannot be read, in words; empty for a file that is whole.
    pub damage: Vec<String>,
}

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
    #[error(
        "{path}: topic {topic} holds {found:?} where {POSE_SCHEMA:?} is needed; this version can replay nothing else"
    )]
    Schema {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The schema found.
        found: String,
    },
    /// Its poses have fields that this version would leave out.
    #[error(
        "{path}: the poses of topic {topic} have fields that this version does not know ({unknown}), and would be replayed \
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

/// Reads a recording from start to end.
///
/// # Errors
/// [`FactsError`].
pub fn facts(path: &Path) -> Result<Facts, FactsError> {
    let mut facts = Facts::default();
    for item in scan::open(path)? {
        match item {
            Ok(Item::Channel(channel)) => check_schema(path, &channel)?,
            Ok(Item::Message(message)) => facts.count(path, &message)?,
            Ok(Item::Attachment(file)) if file.name == SCENE => {
                facts.scene = String::from_utf8(file.data.into_owned()).ok();
            }
            Ok(Item::Metadata(metadata)) if metadata.name == RUN => facts.take(metadata.metadata),
            Ok(_) => {}
            Err(damage) => facts.damage.push(damage.to_string()),
        }
    }
    match facts.poses {
        0 => Err(FactsError::NoPoses { path: path.to_owned() }),
        _ => Ok(facts),
    }
}

impl Facts {
    fn count(&mut self, path: &Path, message: &mcap::Message<'_>) -> Result<(), FactsError> {
        let topic = message.channel.topic.as_str();
        let number = match topic {
            TOOL_POSE => &mut self.poses,
            GROUND_TRUTH => &mut self.truths,
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

    /// Metadata is written again when more is known: the last one counts.
    fn take(&mut self, mut metadata: std::collections::BTreeMap<String, String>) {
        self.run = metadata.remove("name");
        self.volume_hash = metadata.remove("volume_hash");
        self.registration_id = metadata.remove("registration_id");
    }
}

/// The stamp of a pose that no clock shows: 2^61 ns are 73 years. Differences of others never overflow.
pub(crate) fn impossible_stamp(pose: &ToolPose) -> Option<(&'static str, i64)> {
    let stamps = [("captured", pose.t_capture_ns), ("published", pose.t_publish_ns)];
    stamps.into_iter().find(|(_, ns)| ns.unsigned_abs() >= 1 << 61)
}

/// Refuses poses of another kind, or with fields that would be lost on the way.
fn check_schema(path: &Path, channel: &Channel<'_>) -> Result<(), FactsError> {
    let topic = &channel.topic;
    if topic != TOOL_POSE && topic != GROUND_TRUTH {
        return Ok(());
    }
    let (name, data) = channel
        .schema
        .as_ref()
        .map_or(("", &[][..]), |s| (s.name.as_str(), &*s.data));
    if name != POSE_SCHEMA {
        return Err(FactsError::Schema {
            path: path.to_owned(),
            topic: topic.clone(),
            found: name.to_owned(),
        });
    }
    let known = fields(&descriptor::tool_pose());
    let unknown: Vec<String> = fields(data)
        .difference(&known)
        .map(|(number, name)| format!("{name} = {number}"))
        .collect();
    if unknown.is_empty() {
        return Ok(());
    }
    Err(FactsError::Newer {
        path: path.to_owned(),
        topic: topic.clone(),
        unknown: unknown.join(", "),
    })
}

/// Numbers and names of the fields of every message of a schema; none where it cannot be read.
fn fields(schema: &[u8]) -> BTreeSet<(i32, String)> {
    let files = FileDescriptorSet::decode(schema).unwrap_or_default().file;
    let messages = files.into_iter().flat_map(|file| file.message_type);
    let fields = messages.flat_map(|message| message.field);
    fields.map(|field| (field.number(), field.name().to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use mcap::records::MessageHeader;
    use std::collections::BTreeMap;

    fn of(bytes: &[u8]) -> Result<Facts, FactsError> {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        facts(&path)
    }

    #[test]
    fn a_whole_recording() {
        let facts = of(&testing::finished(2, 30)).unwrap();
        let (first, last) = (testing::pose(0), testing::pose(59));
        assert_eq!((facts.poses, facts.truths), (60, 60));
        assert_eq!((facts.first_ns, facts.last_ns), (first.t_publish_ns, last.t_publish_ns));
        assert_eq!(facts.scene.as_deref(), Some("seed = 1\n"));
        assert_eq!((facts.run.as_deref(), &facts.volume_hash), (Some("demo"), &None));
        assert!(facts.damage.is_empty());
    }

    #[test]
    fn damage_is_told_and_no_poses_are_refused() {
        // Cut off within the second chunk.
        let cut = testing::unfinished(1, 30).len() + 100;
        let facts = of(&testing::unfinished(2, 30)[..cut]).unwrap();
        assert_eq!((facts.poses, facts.damage.len()), (30, 1));
        let text = of(&testing::finished(0, 1)).unwrap_err().to_string();
        assert!(text.contains("holds no poses"), "{text}");
    }

    #[test]
    fn times_that_no_clock_shows_are_refused() {
        let mut log = testing::log(1, 2);
        let mut pose = testing::pose(2);
        pose.t_capture_ns = i64::MIN;
        log.pose(crate::schema::Source::Tool, &pose).unwrap();
        let text = of(&log.finish().unwrap().into_inner()).unwrap_err().to_string();
        assert!(
            text.contains("message 3 of topic /tool_pose: pose 2 was captured at -9223372036854775808 ns"),
            "{text}"
        );
    }

    /// A file with one message of `data` on the pose topic, under this schema.
    fn foreign(name: &str, schema: &[u8], data: &[u8]) -> Vec<u8> {
        let mut mcap = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let schema = mcap.add_schema(name, "protobuf", schema).unwrap();
        let channel = mcap
            .add_channel(schema, TOOL_POSE, "protobuf", &BTreeMap::new())
            .unwrap();
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: 0,
            publish_time: 0,
        };
        mcap.write_to_known_channel(&header, data).unwrap();
        mcap.finish().unwrap();
        mcap.into_inner().into_inner()
    }

    #[test]
    fn other_schemas_and_later_ones_are_refused() {
        let text = of(&foreign("trocar.ToolPose9", b"", b"")).unwrap_err().to_string();
        assert!(
            text.contains("holds \"trocar.ToolPose9\" where \"trocar.ToolPose\" is needed"),
            "{text}"
        );
        let mut later = FileDescriptorSet::decode(&*descriptor::tool_pose()).unwrap();
        let fields = &mut later.file[0].message_type[0].field;
        let mut more = fields[0].clone();
        (more.name, more.number) = (Some("grip".to_owned()), Some(16));
        fields.push(more);
        let text = of(&foreign(POSE_SCHEMA, &later.encode_to_vec(), b""))
            .unwrap_err()
            .to_string();
        assert!(text.contains("does not know (grip = 16)"), "{text}");
        let text = of(&foreign(POSE_SCHEMA, &descriptor::tool_pose(), b""))
            .unwrap_err()
            .to_string();
        assert!(
            text.contains("message 1 of topic /tool_pose: message 0: q has 0 values instead of 4"),
            "{text}"
        );
    }
}
