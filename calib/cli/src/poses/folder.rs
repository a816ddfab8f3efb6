//! A folder of 4 x 4 matrices, one a text file, named by their time in nanoseconds.

use std::fs;
use std::path::{Path, PathBuf};

use super::matrix::At;
use super::{MAX_POSES, PosesError, Recording};
use crate::input_files::fields;
use crate::input_files::source::{MAX_BYTES, Source};

const EXPECTED: &str =
    "expected files named by a number, such as 1378476417807806000.txt, with four rows of four numbers each";

/// Reads the files of a folder whose name before the point is a number, in the order of these numbers; others are
/// passed over.
pub(super) fn read(path: &Path) -> Result<Recording, PosesError> {
    let files = files(path)?;
    let mut recording = Recording::new(path);
    let mut hash = blake3::Hasher::new();
    let first = files.first().map_or(0, |(time, _)| *time);
    for (time, file) in files {
        let source = Source::read(&file)?;
        recording.bytes += source.bytes;
        if recording.bytes > MAX_BYTES {
            return Err(PosesError::TooMany { path: path.to_owned() });
        }
        hash.update(time.to_string().as_bytes());
        hash.update(b"\0");
        hash.update(&source.bytes.to_le_bytes());
        hash.update(source.text.as_bytes());
        // From the first on: the nanoseconds of an epoch do not fit the digits.
        recording.add(Some((time - first) as f64 * 1e-9), Some(matrix(&source)?))?;
    }
    recording.blake3 = hash.finalize().to_hex().to_string();
    if recording.frames == 0 {
        let path = path.to_owned();
        return Err(PosesError::NoPoses {
            path,
            expected: EXPECTED,
        });
    }
    Ok(recording)
}

fn files(path: &Path) -> Result<Vec<(u64, PathBuf)>, PosesError> {
    let failed = |source| PosesError::Read {
        path: path.to_owned(),
        source,
    };
    let mut files = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let digits = !stem.is_empty() && stem.bytes().all(|b| b.is_ascii_digit());
        if let Some(time) = stem.parse().ok().filter(|_| digits) {
            files.push((time, file));
        }
        if files.len() > MAX_POSES {
            return Err(PosesError::TooMany { path: path.to_owned() });
        }
    }
    files.sort();
    Ok(files)
}

/// The one matrix of a file.
fn matrix(source: &Source) -> Result<super::Seen, PosesError> {
    let mut numbers = Vec::with_capacity(16);
    let mut first = 1;
    for (line, text) in source.rows() {
        let at = At {
            path: &source.path,
            line,
        };
        if numbers.is_empty() {
            first = line;
        }
        let row = fields::plain(text);
        if row.len() != 4 || numbers.len() == 16 {
            let (path, found) = (source.path.clone(), row.len());
            let what = if found == 4 {
                "numbers in a fifth row"
            } else {
                "numbers in a row"
            };
            return Err(PosesError::Count {
                path,
                line,
                found,
                what,
                expected: 4,
            });
        }
        for field in &row {
            numbers.push(at.number(field, "a 4 x 4 matrix")?);
        }
    }
    let found = numbers.len() / 4;
    let matrix: [f64; 16] = numbers.try_into().map_err(|_| PosesError::Count {
        path: source.path.clone(),
        line: first,
        found,
        what: "rows of a matrix",
        expected: 4,
    })?;
    At {
        path: &source.path,
        line: first,
    }
    .matrix(&matrix)
}
