//! The messages of a recording in the order in which they were published.

use std::iter::Peekable;
use std::path::{Path, PathBuf};

use bus::message::ToolPose;

use crate::damage::OpenError;
use crate::reader::{self, Poses, ReadError};
use crate::replay::facts::impossible_stamp;
use crate::schema::{GROUND_TRUTH, TOOL_POSE};

/// True poses that are kept behind one pose at most: a recording without poses of the tool does not fill the memory.
const MOST_TRUTHS: usize = 4096;

/// What is published together.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// The tool's pose.
    pub pose: ToolPose,
    /// The true poses that were published from then on, up to the next pose; with the first pose also those before it.
    pub truths: Vec<ToolPose>,
}

impl Moment {
    /// When it was published, ns on the clock of the recorded run.
    pub fn due_ns(&self) -> i64 {
        self.pose.t_publish_ns
    }
}

/// A recording being replayed.
///
/// A place is found by reading up to it. [`Tape::rewind`] is where an index of the file is to be used once there is a
/// reader for it.
#[derive(Debug)]
pub struct Tape {
    path: PathBuf,
    poses: Peekable<Readable>,
    truths: Peekable<Readable>,
    next: Option<Moment>,
}

/// The poses that can be read. What cannot was told before the replay began: see [`crate::replay::facts`].
#[derive(Debug)]
struct Readable(Poses);

impl Iterator for Readable {
    type Item = ToolPose;

    fn next(&mut self) -> Option<ToolPose> {
        loop {
            match self.0.next()? {
                Ok(pose) if impossible_stamp(&pose).is_none() => return Some(pose),
                Ok(_) => {}
                Err(ReadError::Damage(damage)) if damage.stops => return None,
                Err(_) => {}
            }
        }
    }
}

impl Tape {
    /// Opens a recording at its start.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let open = |topic| reader::poses(path, topic).map(|poses| Readable(poses).peekable());
        let mut tape = Self {
            path: path.to_owned(),
            poses: open(TOOL_POSE)?,
            truths: open(GROUND_TRUTH)?,
            next: None,
        };
        tape.next = tape.read();
        Ok(tape)
    }

    /// Back to the start.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn rewind(&mut self) -> Result<(), OpenError> {
        *self = Self::open(&self.path)?;
        Ok(())
    }

    /// What comes next, without taking it.
    pub fn peek(&self) -> Option<&Moment> {
        self.next.as_ref()
    }

    /// Takes what comes next.
    pub fn take(&mut self) -> Option<Moment> {
        let next = self.read();
        std::mem::replace(&mut self.next, next)
    }

    fn read(&mut self) -> Option<Moment> {
        let pose = self.poses.next()?;
        let until_ns = self.poses.peek().map_or(i64::MAX, |next| next.t_publish_ns);
        let mut truths = Vec::new();
        while let Some(truth) = self.truths.next_if(|truth| truth.t_publish_ns < until_ns) {
            truths.push(truth);
            if truths.len() == MOST_TRUTHS {
                break;
            }
        }
        Some(Moment { pose, truths })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::Source;
    use crate::testing;

    fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        (tmp, path)
    }

    #[test]
    fn every_pose_comes_bit_for_bit_with_its_truth() {
        let (_tmp, path) = written(&testing::finished(3, 10));
        let mut tape = Tape::open(&path).unwrap();
        for round in 0..2 {
            for seq in 0..30 {
                assert_eq!(tape.peek().map(|m| m.pose.seq), Some(seq), "round {round}");
                let moment = tape.take().unwrap();
                assert_eq!(testing::bytes(&moment.pose), testing::bytes(&testing::pose(seq)));
                let truths: Vec<u64> = moment.truths.iter().map(|t| t.seq).collect();
                assert_eq!(truths, [seq]);
            }
            assert!(tape.take().is_none() && tape.peek().is_none());
            tape.rewind().unwrap();
        }
    }

    #[test]
    fn truths_come_behind_the_pose_that_was_published_before_them() {
        let mut log = testing::log(0, 1);
        for seq in 0..3 {
            log.pose(Source::Tool, &testing::pose(seq)).unwrap();
        }
        for (seq, after_ns) in [(0, -1), (1, 1), (2, 5), (9, 1_000_000_000)] {
            let mut truth = testing::pose(seq);
            truth.t_publish_ns += after_ns;
            log.pose(Source::Truth, &truth).unwrap();
        }
        let (_tmp, path) = written(&log.finish().unwrap().into_inner());
        let mut tape = Tape::open(&path).unwrap();
        let mut all = Vec::new();
        while let Some(moment) = tape.take() {
            all.push(moment.truths.iter().map(|t| t.seq).collect::<Vec<_>>());
        }
        assert_eq!(all, [vec![0], vec![1], vec![2, 9]]);
    }

    #[test]
    fn damage_is_passed_over() {
        // Cut off within the third chunk.
        let cut = testing::unfinished(2, 10).len() + 100;
        let (_tmp, path) = written(&testing::unfinished(3, 10)[..cut]);
        let mut tape = Tape::open(&path).unwrap();
        let seqs: Vec<u64> = std::iter::from_fn(|| tape.take()).map(|m| m.pose.seq).collect();
        assert_eq!(seqs, (0..20).collect::<Vec<_>>());
    }
}
