//! Poses from a recording, for replay and for tests.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! for pose in recorder::reader::poses("session.mcap".as_ref(), recorder::schema::TOOL_POSE)? {
//!     println!("{}", pose?.seq);
//! }
//! # Ok(())
//! # }
//! ```

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use bus::message::ToolPose;
use mcap::Message;
use mcap::records::Metadata;

use crate::damage::{Damage, OpenError};
use crate::proto::{DecodeError, decode_pose};
use crate::scan::{self, Item, Scan};
use crate::schema::{POSE_SCHEMA, RUN, SCENE};

/// Why a pose could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Part of the file is damaged, or its end is missing.
    #[error(transparent)]
    Damage(#[from] Damage),
    /// The channel holds something else.
    #[error("topic {topic} holds {found} instead of {POSE_SCHEMA}")]
    Schema {
        /// The topic.
        topic: String,
        /// The schema found; empty where there is none.
        found: String,
    },
    /// The message is not a pose.
    #[error("topic {topic}: {source}")]
    Decode {
        /// The topic.
        topic: String,
        /// What is wrong.
        source: DecodeError,
    },
}

/// The poses of one topic in the order of the file; an error in place of each part that cannot be read, also of a
/// missing end. Those who can do with less go on behind it.
#[derive(Debug)]
pub struct Poses {
    scan: Scan<BufReader<File>>,
    topic: String,
}

/// Opens a recording for the poses of `topic`: [`crate::schema::TOOL_POSE`] or [`crate::schema::GROUND_TRUTH`].
///
/// # Errors
/// [`OpenError`].
pub fn poses(path: &Path, topic: &str) -> Result<Poses, OpenError> {
    Ok(Poses {
        scan: scan::open(path)?,
        topic: topic.to_owned(),
    })
}

impl Iterator for Poses {
    type Item = Result<ToolPose, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.scan.next()? {
                Ok(Item::Message(message)) if message.channel.topic == self.topic => {
                    return Some(decode_item(&message));
                }
                Ok(_) => {}
                Err(damage) => return Some(Err(damage.into())),
            }
        }
    }
}

/// The pose in a recorded message.
///
/// # Errors
/// [`ReadError::Schema`], [`ReadError::Decode`].
pub fn decode_item(message: &Message<'_>) -> Result<ToolPose, ReadError> {
    let topic = message.channel.topic.clone();
    let found = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
    if found != POSE_SCHEMA {
        let found = found.to_owned();
        return Err(ReadError::Schema { topic, found });
    }
    decode_pose(&message.data).map_err(|source| ReadError::Decode { topic, source })
}

/// What lies in a recording beside the messages.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Beside {
    /// The scene file, if it is readable text.
    pub scene: Option<String>,
    /// The newest facts of the run: see [`crate::schema::RunFacts`].
    pub run: Option<Metadata>,
}

/// Reads what lies beside the messages; reads the whole file. Damage is passed over.
///
/// # Errors
/// [`OpenError`].
pub fn beside(path: &Path) -> Result<Beside, OpenError> {
    let mut beside = Beside::default();
    for item in scan::open(path)?.flatten() {
        match item {
            Item::Attachment(file) if file.name == SCENE => {
                beside.scene = String::from_utf8(file.data.into_owned()).ok();
            }
            Item::Metadata(facts) if facts.name == RUN => beside.run = Some(facts),
            _ => {}
        }
    }
    Ok(beside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::{GROUND_TRUTH, TF, TOOL_POSE};
    use crate::testing;

    #[test]
    fn poses_and_what_lies_beside_them() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, testing::finished(2, 5)).unwrap();
        for topic in [TOOL_POSE, GROUND_TRUTH] {
            let poses: Vec<_> = poses(&path, topic).unwrap().map(Result::unwrap).collect();
            assert_eq!(poses, (0..10).map(testing::pose).collect::<Vec<_>>());
        }
        let beside = beside(&path).unwrap();
        assert_eq!(beside.scene.as_deref(), Some("seed = 1\n"));
        assert_eq!(beside.run, Some(testing::facts().metadata()));
    }

    #[test]
    fn another_topic_and_another_file_are_refused() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, testing::finished(1, 1)).unwrap();
        let text = poses(&path, TF).unwrap().next().unwrap().unwrap_err().to_string();
        assert_eq!(
            text,
            "topic /tf holds foxglove.FrameTransform instead of trocar.ToolPose"
        );
        std::fs::write(&path, "hello").unwrap();
        let text = poses(&path, TF).unwrap_err().to_string();
        assert!(text.contains("is not an MCAP file: it starts with [68, 65"), "{text}");
    }
}
