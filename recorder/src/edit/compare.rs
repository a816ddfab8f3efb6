//! The poses of two recordings side by side: how far apart the tips, what angle between the tubes; and the states of organs of these poses.
//!
//! Poses belong together by their sequence number: a session and the same session made again from its raw measurements
//! through another calibration. A table of every pose, a chart over the session, and the numbers that sum it up.

mod difference;
mod output;
mod plot;
mod summary;
mod tissue;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bus::message::{ToolPose, Tracked};
use geometry::{Ct, Rigid, Tool};

use crate::read::damage::OpenError;
use crate::read::reader::{self, ReadError};
use crate::read::seek::Session;
use crate::wire::schema::RUN;

pub(crate) use difference::{Compared, Difference};
pub(crate) use output::{OutputError, write};
pub(crate) use summary::Summary;

/// Why two recordings cannot be compared.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CompareError {
    /// One of them cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// One of them has something else on the topic.
    #[error("{path}: {source}")]
    Read {
        /// The recording.
        path: PathBuf,
        /// What is wrong.
        source: ReadError,
    },
    /// One of them has no poses.
    #[error("{path} holds no poses on topic {topic}: there is nothing to compare")]
    NoPoses {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
    },
    /// They have no sequence number in common.
    #[error(
        "{a} has poses {} to {}, {b} has poses {} to {}, and none of the same number: poses are compared by their \
         sequence number, so both must come from one session", range_a.0, range_a.1, range_b.0, range_b.1
    )]
    Disjoint {
        /// The one recording.
        a: PathBuf,
        /// Its first and last number.
        range_a: (u64, u64),
        /// The other.
        b: PathBuf,
        /// Its first and last number.
        range_b: (u64, u64),
    },
    /// The results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// A sample, as far as it is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) t_device_ns: i64,
    pub(crate) status: u32,
    /// `None`: there is no pose, or none that can be believed.
    pub(crate) pose: Option<Rigid<Ct, Tool>>,
    /// Of all that the sample says but when it was published.
    pub(crate) bits: blake3::Hash,
}

/// The samples of one recording by number, and how many of a number that had come before: the later one counts.
#[derive(Debug, Default)]
pub(crate) struct Samples {
    pub(crate) by_seq: BTreeMap<u64, Sample>,
    pub(crate) repeated: u64,
    /// Places of the file that could not be read.
    pub(crate) damaged: u64,
}

impl Sample {
    pub(crate) fn of(pose: &ToolPose) -> Self {
        Self {
            t_device_ns: pose.t_device_ns,
            status: pose.status,
            pose: match pose.tracked() {
                Ok(Tracked::Valid(pose)) => Some(pose),
                _ => None,
            },
            bits: {
                let said = ToolPose {
                    t_publish_ns: 0,
                    ..*pose
                };
                blake3::hash(&prost::Message::encode_to_vec(&crate::wire::proto::ToolPose::from(
                    &said,
                )))
            },
        }
    }
}

impl Samples {
    fn add(&mut self, pose: &ToolPose) {
        self.repeated += u64::from(self.by_seq.insert(pose.seq, Sample::of(pose)).is_some());
    }

    fn range(&self) -> (u64, u64) {
        let first = self.by_seq.first_key_value().map_or(0, |(&seq, _)| seq);
        (first, self.by_seq.last_key_value().map_or(0, |(&seq, _)| seq))
    }
}

/// Compares the poses of `topic` ([`crate::wire::schema::TOOL_POSE`] or [`crate::wire::schema::GROUND_TRUTH`]) of `a` with those of
/// `b`. What cannot be read of a damaged file is passed over. Takes about 190 bytes of memory for each pose of both.
///
/// # Errors
/// [`CompareError`].
pub(crate) fn compare(a: &Path, topic_a: &str, b: &Path, topic_b: &str) -> Result<Compared, CompareError> {
    let (samples_a, samples_b) = (samples(a, topic_a)?, samples(b, topic_b)?);
    let compared = Compared::of(&samples_a, &samples_b);
    if compared.differences.is_empty() {
        return Err(CompareError::Disjoint {
            a: a.to_owned(),
            range_a: samples_a.range(),
            b: b.to_owned(),
            range_b: samples_b.range(),
        });
    }
    Ok(Compared {
        tissue: tissue::compare(a, b)?,
        other_examination: other_examination(a, b)?,
        ..compared
    })
}

/// The examinations of both, where they say so and they are not the same.
fn other_examination(a: &Path, b: &Path) -> Result<Option<[String; 2]>, OpenError> {
    let of = |path| -> Result<Option<String>, OpenError> {
        let run = Session::open(path)?.metadata(RUN)?;
        Ok(run.and_then(|run| run.metadata.get("volume_hash").cloned()))
    };
    let both = of(a)?.zip(of(b)?);
    Ok(both.filter(|(a, b)| a != b).map(|(a, b)| [a, b]))
}

fn samples(path: &Path, topic: &str) -> Result<Samples, CompareError> {
    let mut samples = Samples::default();
    for pose in reader::poses(path, topic)? {
        match pose {
            Ok(pose) => samples.add(&pose),
            Err(ReadError::Damage(_)) => samples.damaged += 1,
            Err(source) => {
                let path = path.to_owned();
                return Err(CompareError::Read { path, source });
            }
        }
    }
    match samples.by_seq.is_empty() {
        true => Err(CompareError::NoPoses {
            path: path.to_owned(),
            topic: topic.to_owned(),
        }),
        false => Ok(samples),
    }
}

#[cfg(test)]
mod tests;
