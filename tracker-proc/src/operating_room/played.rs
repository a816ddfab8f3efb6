//! A gesture from a file: poses with their times, and what lies between them.

mod csv;

use std::io::Read;
use std::path::{Path, PathBuf};

use geometry::rotation::Rotation;
use geometry::{Ct, Rigid, Tool};
use scene::operating_room::{AtEnd, PlayedGesture};

/// The longest file, bytes.
const MAX_BYTES: u64 = 64 << 20;
/// The most poses: four hours at 60 Hz, or four minutes at 4000.
const MAX_POSES: usize = 1_000_000;

/// A gesture from a file.
///
/// Between two poses the tip goes straight and the rotation the shortest way, both at constant speed. Before the first pose
/// the tool rests there.
#[derive(Debug, Clone, PartialEq)]
pub struct Played {
    /// At least one, each later than the one before.
    poses: Vec<Timed>,
    at_end: AtEnd,
}

/// A pose and its time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Timed {
    t_s: f64,
    ct_from_tool: Rigid<Ct, Tool>,
}

/// Why a file is no gesture. Lines and columns count from 1, columns in characters.
#[derive(Debug, thiserror::Error)]
pub enum PlayedError {
    /// It cannot be read.
    #[error("reading the gesture {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is too long.
    #[error("reading the gesture {path}: more than {most} {what}")]
    TooLong {
        /// The file.
        path: PathBuf,
        /// The most allowed.
        most: u64,
        /// Bytes or poses.
        what: &'static str,
    },
    /// It has no pose.
    #[error("reading the gesture {path}: no pose in it; the first line is {header}, then one pose a line")]
    Empty {
        /// The file.
        path: PathBuf,
        /// The header.
        header: &'static str,
    },
    /// A line is not what it should be.
    #[error("reading the gesture {path}, line {line}, column {column}: found {found}; allowed: {allowed}")]
    Field {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What stands there.
        found: String,
        /// What may.
        allowed: String,
    },
}

impl Played {
    /// Reads the file of a scene.
    ///
    /// # Errors
    /// Each variant of [`PlayedError`].
    pub fn load(gesture: &PlayedGesture) -> Result<Self, PlayedError> {
        let path = gesture.file.as_path();
        let io = |source| PlayedError::Io {
            path: path.to_owned(),
            source,
        };
        let mut text = String::new();
        let (file, _) = scene::file::open(path).map_err(|error| io(error.into()))?;
        // One byte more than allowed shows that there are more, whatever the file says of its length.
        file.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(io)?;
        if text.len() as u64 > MAX_BYTES {
            return Err(PlayedError::TooLong {
                path: path.to_owned(),
                most: MAX_BYTES,
                what: "bytes",
            });
        }
        Self::parse(&text, path, gesture.at_end)
    }

    /// Reads the text of a file; `path` stands in errors.
    ///
    /// # Errors
    /// Each variant of [`PlayedError`] but [`PlayedError::Io`].
    pub fn parse(text: &str, path: &Path, at_end: AtEnd) -> Result<Self, PlayedError> {
        let poses = csv::poses(text, path)?;
        Ok(Self { poses, at_end })
    }

    /// One pose, held.
    pub fn held(ct_from_tool: Rigid<Ct, Tool>) -> Self {
        Self {
            poses: vec![Timed { t_s: 0.0, ct_from_tool }],
            at_end: AtEnd::Hold,
        }
    }

    /// When the gesture is over, s; `None` where it is held or played again.
    pub fn end_s(&self) -> Option<f64> {
        let last = self.poses.last()?;
        (self.at_end == AtEnd::Once).then_some(last.t_s)
    }

    /// The true pose at script time `t_s`.
    pub fn ct_from_tool(&self, t_s: f64) -> Rigid<Ct, Tool> {
        let t_s = self.in_gesture(t_s);
        let next = self.poses.partition_point(|pose| pose.t_s <= t_s);
        match (
            next.checked_sub(1).and_then(|i| self.poses.get(i)),
            self.poses.get(next),
        ) {
            (Some(from), Some(to)) => between(from, to, t_s),
            (Some(only), None) | (None, Some(only)) => only.ct_from_tool,
            // There is at least one pose.
            (None, None) => Rigid::from_parts(Rotation::IDENTITY, geometry::Vector::new(0.0, 0.0, 0.0)),
        }
    }

    /// The time within the gesture at script time `t_s`: the same, unless it is played again and again.
    fn in_gesture(&self, t_s: f64) -> f64 {
        let (Some(first), Some(last)) = (self.poses.first(), self.poses.last()) else {
            return t_s;
        };
        let round_s = last.t_s - first.t_s;
        if self.at_end == AtEnd::Loop && t_s > last.t_s && round_s > 0.0 {
            return first.t_s + (t_s - first.t_s).rem_euclid(round_s);
        }
        t_s
    }
}

fn between(from: &Timed, to: &Timed, t_s: f64) -> Rigid<Ct, Tool> {
    let share = (t_s - from.t_s) / (to.t_s - from.t_s);
    let (a, b) = (from.ct_from_tool, to.ct_from_tool);
    let tip = a.translation() + (b.translation() - a.translation()) * share;
    Rigid::from_parts(a.rotation().slerp(b.rotation(), share), tip)
}
