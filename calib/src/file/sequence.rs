//! Sequences of the PLUS toolkit: MetaImage headers with transforms, their status and a time for each frame.
//!
//! Lines are `Seq_FrameNNNN_NameTransform = 16 numbers by rows`, `..._NameTransformStatus = OK`, `..._Timestamp = seconds`,
//! with lengths in mm; other lines are passed over. A frame without the transform, or whose status is not OK, holds no pose.
//! Rotations that are off by what text and single precision lose are put right by the nearest one.

use std::collections::{BTreeMap, BTreeSet};

use geometry::checked;
use geometry::named::{Chain, Disagree, NoChain};
use geometry::rotation::{RotationError, RotationMatrix};
use geometry::{Frame as GeometryFrame, Rigid};

use super::{MAX_MM, quoted};

/// The most frames of a sequence.
pub const MAX_FRAMES: usize = 200_000;
/// The largest distance of a matrix from a rotation, Frobenius norm.
pub const MOST_OFF: f64 = 5e-3;
/// What the last row may differ by.
const LAST_ROW_TOLERANCE: f64 = 1e-6;
/// The line that ends a header; pixels may follow it.
const END_OF_HEADER: &[u8] = b"ElementDataFile";

/// One frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its number in the file.
    pub number: u32,
    /// Its time stamp, s, where it has one.
    pub t_s: Option<f64>,
    /// The poses asked for, in that order; `None` where it has none that is valid.
    pub poses: Vec<Option<Pose>>,
}

/// A pose as read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Unit quaternion w, x, y, z.
    pub quaternion: [f64; 4],
    /// Translation, mm.
    pub translation_mm: [f64; 3],
    /// How far the matrix was from a rotation, Frobenius norm.
    pub off: f64,
}

impl Pose {
    /// The same between frames that the caller knows; `None` never, but for numbers put in by hand.
    pub fn rigid<To: GeometryFrame, From: GeometryFrame>(&self) -> Option<Rigid<To, From>> {
        checked::rigid(self.quaternion, self.translation_mm, 1e-9).ok()
    }
}

/// Why a text gave no poses. Lines and columns count from 1.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// There is no transform in it.
    #[error("there is no pose in it; expected lines such as Seq_Frame0000_StylusToTrackerTransform = 16 numbers")]
    NoPoses,
    /// The transform asked for is not there.
    #[error("there is no transform {asked}; found {found}")]
    NoTransform {
        /// Its name.
        asked: String,
        /// The names that are there.
        found: String,
    },
    /// The transform asked for is not there, and no chain leads to it.
    #[error("{source}; found {found}")]
    NoChain {
        /// Why.
        source: NoChain,
        /// The names that are there.
        found: String,
    },
    /// Two chains that lead to it end apart.
    #[error("frame {number}: {source}; name one of the transforms that are in it")]
    Disagree {
        /// Its number in the file.
        number: u32,
        /// How far.
        source: Disagree,
    },
    /// More frames than are read.
    #[error("more than {MAX_FRAMES} frames; cut the sequence")]
    TooMany,
    /// A field that is not a number.
    #[error(
        "line {line}, column {column} ({what}): found {found:?}, expected a finite number of at most 1e9, with a point for the decimals"
    )]
    Field {
        /// Its line.
        line: usize,
        /// Its column, in characters.
        column: usize,
        /// What it belongs to.
        what: &'static str,
        /// Its text.
        found: String,
    },
    /// More or fewer numbers than a matrix has.
    #[error("line {line}: {found} numbers of a matrix, expected 16")]
    Count {
        /// The line.
        line: usize,
        /// How many there are.
        found: usize,
    },
    /// The last row is not that of a rigid transform.
    #[error("line {line}: the last row of the matrix is {found:?}, expected 0 0 0 1")]
    BottomRow {
        /// The line.
        line: usize,
        /// The row.
        found: [f64; 4],
    },
    /// No rotation is near.
    #[error("line {line}: the matrix holds no rotation: {source}")]
    NoRotation {
        /// The line.
        line: usize,
        /// Why.
        source: RotationError,
    },
    /// The nearest rotation is too far.
    #[error(
        "line {line}: the rotation is off by {distance:.2e} (Frobenius norm to the nearest one), at most {MOST_OFF:e} is \
         accepted; is there a scale in it, or are rows and columns exchanged?"
    )]
    FarFromRotation {
        /// The line.
        line: usize,
        /// How far.
        distance: f64,
    },
}

/// Where the header of a file ends: after the line that begins with `ElementDataFile`. Only the bytes before are text.
pub fn header_end(bytes: &[u8]) -> Option<usize> {
    let mut start = 0;
    for line in bytes.split_inclusive(|b| *b == b'\n') {
        start += line.len();
        if line.starts_with(END_OF_HEADER) {
            return Some(start);
        }
    }
    None
}

/// The names of the transforms, without `Transform`: `StylusToTracker`.
pub fn transforms(text: &str) -> BTreeSet<&str> {
    text.lines()
        .filter_map(|line| field(line)?.1.strip_suffix("Transform"))
        .collect()
}

/// The frames in the order of their numbers, with the poses of the transforms `names` (with or without `Transform`).
///
/// # Errors
/// Each variant of [`SequenceError`]. The matrix of a pose that is not valid is not looked at.
pub fn frames(text: &str, names: &[&str]) -> Result<Vec<Frame>, SequenceError> {
    let names = known(text, names)?;
    let mut frames: BTreeMap<u32, Lines<'_>> = BTreeMap::new();
    for (i, line) in text.lines().enumerate() {
        let Some((number, key, value)) = field(line) else {
            continue;
        };
        let frame = frames.entry(number).or_insert_with(|| Lines::new(names.len()));
        frame.take(key, (i + 1, value), &names);
        // While reading, so that a file of millions of frames is not held first.
        if frames.len() > MAX_FRAMES {
            return Err(SequenceError::TooMany);
        }
    }
    frames.iter().map(|(number, lines)| lines.frame(*number)).collect()
}

/// The frames in the order of their numbers, each with the one pose of the transform `asked` (with or without `Transform`), or of
/// the chain of transforms that leads there where the text has none of that name; and the chain. A frame of which any link is not
/// valid has no pose; [`Pose::off`] is the largest of its links.
///
/// # Errors
/// Each variant of [`SequenceError`].
pub fn chained(text: &str, asked: &str) -> Result<(Vec<Frame>, Chain), SequenceError> {
    let there = transforms(text);
    if there.is_empty() {
        return Err(SequenceError::NoPoses);
    }
    let asked = asked.strip_suffix("Transform").unwrap_or(asked);
    let chain = Chain::find(&there, asked).map_err(|source| SequenceError::NoChain {
        source,
        found: listed(&there),
    })?;
    let names: Vec<&str> = chain.names().into_iter().collect();
    let mut frames = frames(text, &names)?;
    // The transform itself is in the file: its numbers are kept, bit for bit.
    if let [link] = chain.links()
        && !link.inverse
    {
        return Ok((frames, chain));
    }
    for frame in &mut frames {
        let of = |name: &str| frame.poses[names.iter().position(|n| *n == name)?]?.rigid();
        let pose = chain.pose(of).map_err(|source| SequenceError::Disagree {
            number: frame.number,
            source,
        })?;
        // Links of other ways too, as they were compared.
        let off = frame.poses.iter().flatten().fold(0.0, |most, p| f64::max(most, p.off));
        frame.poses = vec![pose.map(|pose| Pose {
            quaternion: pose.quaternion(),
            translation_mm: pose.translation_mm(),
            off,
        })];
    }
    Ok((frames, chain))
}

/// The first names, for an error.
fn listed(names: &BTreeSet<&str>) -> String {
    names.iter().take(10).map(|n| quoted(n)).collect::<Vec<_>>().join(", ")
}

/// The names asked for as they are in the file.
fn known(text: &str, names: &[&str]) -> Result<Vec<String>, SequenceError> {
    let there = transforms(text);
    if there.is_empty() {
        return Err(SequenceError::NoPoses);
    }
    let one = |name: &&str| {
        let name = name.strip_suffix("Transform").unwrap_or(name);
        let missing = || SequenceError::NoTransform {
            asked: quoted(name),
            found: listed(&there),
        };
        there.contains(name).then(|| name.to_owned()).ok_or_else(missing)
    };
    names.iter().map(one).collect()
}

/// The frame, the name of a field and its value, of a line that has them.
fn field(line: &str) -> Option<(u32, &str, &str)> {
    let rest = line.strip_prefix("Seq_Frame")?;
    let (number, rest) = rest.split_once('_')?;
    let (name, value) = rest.split_once('=')?;
    let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    let number = number.parse().ok().filter(|_| digits)?;
    Some((number, name.trim(), value.trim()))
}

/// The lines of a frame that matter: number and value each.
struct Lines<'a> {
    matrices: Vec<Option<(usize, &'a str)>>,
    bad: Vec<bool>,
    time: Option<(usize, &'a str)>,
}

impl<'a> Lines<'a> {
    fn new(names: usize) -> Self {
        Self {
            matrices: vec![None; names],
            bad: vec![false; names],
            time: None,
        }
    }

    fn take(&mut self, key: &str, line: (usize, &'a str), names: &[String]) {
        if key == "Timestamp" {
            self.time = Some(line);
        }
        for (i, name) in names.iter().enumerate() {
            match key.strip_prefix(name.as_str()) {
                Some("Transform") => self.matrices[i] = Some(line),
                Some("TransformStatus") => self.bad[i] = line.1 != "OK",
                _ => {}
            }
        }
    }

    fn frame(&self, number: u32) -> Result<Frame, SequenceError> {
        let first = |(line, text): (usize, &str)| {
            let (column, text) = words(text).next().unwrap_or((1, ""));
            coordinate(line, column, text, "Timestamp")
        };
        let t_s = self.time.map(first).transpose()?;
        let matrices = self.matrices.iter().zip(&self.bad);
        let poses =
            matrices.map(|(matrix, bad)| matrix.filter(|_| !bad).map(|(line, text)| pose(line, text)).transpose());
        Ok(Frame {
            number,
            t_s,
            poses: poses.collect::<Result<_, _>>()?,
        })
    }
}

/// The words of a value with their columns in it.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_whitespace().map(|word| {
        // `split_whitespace` gives parts of `text` itself, so that the difference of addresses is the offset.
        let byte = word.as_ptr() as usize - text.as_ptr() as usize;
        (text[..byte].chars().count() + 1, word)
    })
}

fn coordinate(line: usize, column: usize, text: &str, what: &'static str) -> Result<f64, SequenceError> {
    let value = text.parse().ok().filter(|x: &f64| x.is_finite() && x.abs() <= MAX_MM);
    value.ok_or_else(|| SequenceError::Field {
        line,
        column,
        what,
        found: quoted(text),
    })
}

fn pose(line: usize, text: &str) -> Result<Pose, SequenceError> {
    // One more than a matrix has, so that a longer line is seen to be longer.
    let numbers = words(text)
        .take(17)
        .map(|(column, word)| coordinate(line, column, word, "a 4 x 4 matrix"));
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    let m: [f64; 16] = numbers.try_into().map_err(|_| SequenceError::Count {
        line,
        found: words(text).count(),
    })?;
    let found = [m[12], m[13], m[14], m[15]];
    if found
        .iter()
        .zip([0.0, 0.0, 0.0, 1.0])
        .any(|(a, b)| (a - b).abs() > LAST_ROW_TOLERANCE)
    {
        return Err(SequenceError::BottomRow { line, found });
    }
    let row = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
    let nearest = RotationMatrix::nearest([row(0), row(1), row(2)]);
    // Files have six digits: what is off is repaired, up to what rounding can have done.
    let nearest = nearest.map_err(|source| SequenceError::NoRotation { line, source })?;
    if nearest.distance.is_nan() || nearest.distance > MOST_OFF {
        let distance = nearest.distance;
        return Err(SequenceError::FarFromRotation { line, distance });
    }
    Ok(Pose {
        quaternion: nearest.matrix.rotation().quaternion(),
        translation_mm: [m[3], m[7], m[11]],
        off: nearest.distance,
    })
}
