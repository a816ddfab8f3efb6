//! Messages of the bus out of a recording, for replay and for tests. [`crate::read::seek`] starts in the middle of it.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! for pose in recorder::read::reader::poses("session.mcap".as_ref(), recorder::wire::schema::TOOL_POSE)? {
//!     println!("{}", pose?.seq);
//! }
//! # Ok(())
//! # }
//! ```

use std::fs::File;
use std::io::BufReader;
use std::marker::PhantomData;
use std::path::Path;

use bus::message::{EmitterFrame, Guide, MarkerFrame, ToolPose};
use mcap::Message;
use mcap::records::Metadata;

use crate::read::damage::{Damage, OpenError};
use crate::read::scan::{self, Item, Scan};
use crate::wire::proto::{
    DecodeError, MeshFrame, TissueFrame, UsFrame, decode_emitters, decode_guide, decode_markers, decode_mesh,
    decode_pose, decode_tissue, decode_us_image,
};
use crate::wire::schema::{
    EMITTER_SCHEMA, EMITTERS, GUIDE, GUIDE_SCHEMA, MARKER_SCHEMA, MARKERS, POSE_SCHEMA, RAW_IMAGE_SCHEMA, RUN, SCENE,
    TISSUE_MESH_SCHEMA, TISSUE_SCHEMA, US_IMAGE,
};

/// Why a message could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Part of the file is damaged, or its end is missing.
    #[error(transparent)]
    Damage(#[from] Damage),
    /// The channel holds something else.
    #[error("topic {topic} holds {found} instead of {expected}{}", hint(found, expected))]
    Schema {
        /// The topic.
        topic: String,
        /// The schema found; empty where there is none.
        found: String,
        /// The schema that belongs there.
        expected: &'static str,
    },
    /// The message is not what its schema says.
    #[error("topic {topic}: {source}")]
    Decode {
        /// The topic.
        topic: String,
        /// What is wrong.
        source: DecodeError,
    },
}

/// A schema of the same name with another version behind it was written by another version of this program.
fn hint(found: &str, expected: &str) -> &'static str {
    match found.strip_prefix(expected) {
        Some(_) => ": another version of this program wrote it, and can read it",
        None => "",
    }
}

/// A message of the bus that is recorded without loss.
pub trait Recorded: Sized {
    /// The name of its schema.
    const SCHEMA: &'static str;

    /// The message in these bytes.
    ///
    /// # Errors
    /// [`DecodeError`].
    fn decode(bytes: &[u8]) -> Result<Self, DecodeError>;
}

impl Recorded for ToolPose {
    const SCHEMA: &'static str = POSE_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_pose(bytes)
    }
}

impl Recorded for EmitterFrame {
    const SCHEMA: &'static str = EMITTER_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_emitters(bytes)
    }
}

impl Recorded for MarkerFrame {
    const SCHEMA: &'static str = MARKER_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_markers(bytes)
    }
}

impl Recorded for UsFrame {
    const SCHEMA: &'static str = RAW_IMAGE_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_us_image(bytes)
    }
}

impl Recorded for TissueFrame {
    const SCHEMA: &'static str = TISSUE_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_tissue(bytes)
    }
}

impl Recorded for MeshFrame {
    const SCHEMA: &'static str = TISSUE_MESH_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_mesh(bytes)
    }
}

impl Recorded for Guide {
    const SCHEMA: &'static str = GUIDE_SCHEMA;

    fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        decode_guide(bytes)
    }
}

/// The messages of one topic in the order of the file; an error in place of each part that cannot be read, also of a
/// missing end. Those who can do with less go on behind it.
#[derive(Debug)]
pub struct Messages<T> {
    scan: Scan<BufReader<File>>,
    topic: String,
    from: u64,
    kind: PhantomData<T>,
}

/// The poses of one topic.
pub type Poses = Messages<ToolPose>;
/// What a person chose.
pub type Guides = Messages<Guide>;
/// What the localizer saw.
pub type Emitters = Messages<EmitterFrame>;
/// The images of an ultrasound probe.
pub type UsImages = Messages<UsFrame>;
/// Where organs were.
pub type Tissues = Messages<TissueFrame>;
/// The markers that it followed.
pub type Markers = Messages<MarkerFrame>;

/// Opens a recording for the poses of `topic`: [`crate::wire::schema::TOOL_POSE`] or [`crate::wire::schema::GROUND_TRUTH`].
///
/// # Errors
/// [`OpenError`].
pub fn poses(path: &Path, topic: &str) -> Result<Poses, OpenError> {
    Ok(Messages::of(scan::open(path)?, topic, 0))
}

/// Opens a recording for the emitters that the localizer saw.
///
/// # Errors
/// [`OpenError`].
pub fn emitters(path: &Path) -> Result<Emitters, OpenError> {
    Ok(Messages::of(scan::open(path)?, EMITTERS, 0))
}

/// Opens a recording for the markers that the localizer followed.
///
/// # Errors
/// [`OpenError`].
pub fn markers(path: &Path) -> Result<Markers, OpenError> {
    Ok(Messages::of(scan::open(path)?, MARKERS, 0))
}

/// Opens a recording for the images of an ultrasound probe.
///
/// # Errors
/// [`OpenError`].
pub fn us_images(path: &Path) -> Result<UsImages, OpenError> {
    Ok(Messages::of(scan::open(path)?, US_IMAGE, 0))
}

/// Opens a recording for what a person chose.
///
/// # Errors
/// [`OpenError`].
pub fn guides(path: &Path) -> Result<Guides, OpenError> {
    Ok(Messages::of(scan::open(path)?, GUIDE, 0))
}

impl<T> Messages<T> {
    /// The messages of `topic` among what `scan` finds, captured at `from` or later.
    pub(crate) fn of(scan: Scan<BufReader<File>>, topic: &str, from: u64) -> Self {
        let topic = topic.to_owned();
        let kind = PhantomData;
        Self {
            scan,
            topic,
            from,
            kind,
        }
    }

    /// Bytes read so far, and bytes of the whole file.
    pub fn progress(&self) -> (u64, u64) {
        self.scan.progress()
    }
}

impl<T: Recorded> Iterator for Messages<T> {
    type Item = Result<T, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.scan.next()? {
                Ok(Item::Message(message)) if message.channel.topic == self.topic && message.log_time >= self.from => {
                    return Some(decode(&message));
                }
                Ok(_) => {}
                Err(damage) => return Some(Err(damage.into())),
            }
        }
    }
}

/// A message of the bus in a recorded one.
///
/// # Errors
/// [`ReadError::Schema`], [`ReadError::Decode`].
pub fn decode<T: Recorded>(message: &Message<'_>) -> Result<T, ReadError> {
    let topic = message.channel.topic.clone();
    let found = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
    if found != T::SCHEMA {
        let (found, expected) = (found.to_owned(), T::SCHEMA);
        return Err(ReadError::Schema { topic, found, expected });
    }
    T::decode(&message.data).map_err(|source| ReadError::Decode { topic, source })
}

/// The pose in a recorded message.
///
/// # Errors
/// [`ReadError::Schema`], [`ReadError::Decode`].
pub fn decode_item(message: &Message<'_>) -> Result<ToolPose, ReadError> {
    decode(message)
}

/// What lies in a recording beside the messages.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Beside {
    /// The scene file, if it is readable text.
    pub scene: Option<String>,
    /// The newest facts of the run: see [`crate::wire::schema::RunFacts`].
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
    use crate::testing;
    use crate::wire::schema::{GROUND_TRUTH, TF, TOOL_POSE};

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
