//! Recorded poses of a marker: a folder of matrices, comma-separated values, or a sequence of the PLUS toolkit.
//!
//! Rotations that are off by what text and single precision lose are put right by the nearest one, and the largest
//! distance is reported. A pose that repeats the one before it to the last bit is no measurement, as trackers send when
//! they have nothing new: it is left out and counted, else the covariance would promise too much. Time stamps that go
//! backwards or stand still are counted; the poses keep their order, which no calibration depends on, and `--strict`
//! refuses such a recording.

mod csv;
mod error;
mod folder;
mod live;
mod matrix;
mod pixels;
mod sequence;

use std::path::{Path, PathBuf};

use geometry::{Marker, Rigid, Tracker};

pub(crate) use error::PosesError;
pub(crate) use live::keep;
pub(crate) use pixels::{Pictured, Pixels, PixelsError};
pub(crate) use sequence::{Timed, timed};

/// The most poses of a recording.
pub(crate) const MAX_POSES: usize = 200_000;
/// The largest distance of a matrix from a rotation, Frobenius norm; of a quaternion's norm from 1.
pub(crate) const MOST_OFF: f64 = 5e-3;

/// The valid poses, and what was found beside them.
#[derive(Debug)]
pub(crate) struct Recording {
    pub(crate) path: PathBuf,
    /// `tracker_from_marker`.
    pub(crate) poses: Vec<Rigid<Tracker, Marker>>,
    /// The covariance of each pose as in [`geometry::uncertain`], the upper triangle by rows; empty where the file has none.
    pub(crate) covariances: Vec<[f64; 21]>,
    /// The transform's name in the file, where it has one.
    pub(crate) transform: Option<String>,
    /// Frames in the recording, valid or not.
    pub(crate) frames: usize,
    /// Frames whose status is not OK, or without the transform.
    pub(crate) invalid: usize,
    /// Poses that repeat the one before.
    pub(crate) repeated: usize,
    /// Time stamps before, and equal to, the largest so far.
    pub(crate) backwards: usize,
    pub(crate) same_time: usize,
    /// The largest distance of a matrix from its rotation.
    pub(crate) most_off: f64,
    /// Bytes read, and their BLAKE3, hexadecimal; of a folder, of its files' names and contents in order.
    pub(crate) bytes: u64,
    pub(crate) blake3: String,
    latest: Option<f64>,
}

/// A pose as it was read, and how far its matrix was from a rotation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    pub(crate) pose: Rigid<Tracker, Marker>,
    pub(crate) off: f64,
    /// Its covariance, where the file has one.
    pub(crate) covariance: Option<[f64; 21]>,
}

impl Recording {
    /// Reads a recording of any kind; `transform` names the one of a sequence.
    pub(crate) fn read(path: &Path, transform: Option<&str>, strict: bool) -> Result<Self, PosesError> {
        let named = |ends: &[&str]| {
            let name = path.to_string_lossy().to_lowercase();
            ends.iter().any(|end| name.ends_with(end))
        };
        let recording = if path.is_dir() {
            folder::read(path)?
        } else if named(&[".mha", ".mhd"]) {
            sequence::read(path, transform)?
        } else {
            csv::read(path)?
        };
        recording.checked(strict)
    }

    fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            poses: Vec::new(),
            covariances: Vec::new(),
            transform: None,
            frames: 0,
            invalid: 0,
            repeated: 0,
            backwards: 0,
            same_time: 0,
            most_off: 0.0,
            bytes: 0,
            blake3: String::new(),
            latest: None,
        }
    }

    /// Takes a frame: its time in seconds where it has one, its pose where it is valid.
    fn add(&mut self, time: Option<f64>, seen: Option<Seen>) -> Result<(), PosesError> {
        if self.frames == MAX_POSES {
            let path = self.path.clone();
            return Err(PosesError::TooMany { path });
        }
        self.frames += 1;
        if let Some(time) = time {
            let latest = self.latest.unwrap_or(f64::NEG_INFINITY);
            self.backwards += usize::from(time < latest);
            self.same_time += usize::from(time == latest);
            self.latest = Some(latest.max(time));
        }
        let Some(Seen { pose, off, covariance }) = seen else {
            self.invalid += 1;
            return Ok(());
        };
        if self.poses.last() == Some(&pose) {
            self.repeated += 1;
            return Ok(());
        }
        self.most_off = self.most_off.max(off);
        self.poses.push(pose);
        self.covariances.extend(covariance);
        Ok(())
    }

    fn checked(self, strict: bool) -> Result<Self, PosesError> {
        let path = self.path.clone();
        if self.poses.is_empty() {
            let (frames, name) = (self.frames, self.transform.unwrap_or_else(|| "the marker".to_owned()));
            return Err(PosesError::NoneValid { path, frames, name });
        }
        let Self {
            backwards,
            same_time,
            repeated,
            ..
        } = self;
        if strict && backwards + same_time + repeated > 0 {
            return Err(PosesError::Strict {
                path,
                backwards,
                same_time,
                repeated,
            });
        }
        Ok(self)
    }
}

/// What is quoted in errors stays short, whatever a file holds.
fn quoted(text: &str) -> String {
    text.chars().take(40).collect()
}
