//! Files of numbers as they lie on the disk: bounded before they are read, and identified by their hash.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The largest file that is read, bytes: a million times what a registration needs.
pub(crate) const MAX_BYTES: u64 = 64 << 20;
/// The longest line, bytes.
pub(crate) const MAX_LINE: usize = 4096;

/// A text file, read whole.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    /// BLAKE3 of the file's bytes, hexadecimal.
    pub(crate) blake3: String,
    pub(crate) bytes: u64,
}

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SourceError {
    /// It could not be opened or read.
    #[error("reading {path}: {source}. Check the name and the permissions")]
    Read { path: PathBuf, source: io::Error },
    /// It is a folder, a pipe or a device.
    #[error("reading {path}: this is not a file; give the path of a text file of points")]
    NotAFile { path: PathBuf },
    /// It is too large.
    #[error("reading {path}: the file has {bytes} bytes, at most {MAX_BYTES} are read; is it a file of points?")]
    TooLarge { path: PathBuf, bytes: u64 },
    /// It has nothing in it.
    #[error("reading {path}: the file is empty (0 bytes); copy or export it again")]
    Empty { path: PathBuf },
    /// It is not text.
    #[error(
        "reading {path}: line {line}: byte {byte} is not UTF-8 text; save the file as plain text (a spreadsheet as CSV)"
    )]
    NotText { path: PathBuf, line: usize, byte: usize },
    /// A line is longer than any row of numbers.
    #[error(
        "reading {path}: line {line} has {bytes} bytes, at most {MAX_LINE} are allowed; expected one pair or point a line"
    )]
    LongLine { path: PathBuf, line: usize, bytes: usize },
}

impl Source {
    /// Reads a file of points.
    pub(crate) fn read(path: &Path) -> Result<Self, SourceError> {
        Self::read_whole(path)?.with_short_lines()
    }

    /// Reads a text file whatever its lines hold.
    pub(crate) fn read_whole(path: &Path) -> Result<Self, SourceError> {
        Self::from_bytes(path, bytes_of(path)?)
    }

    pub(crate) fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, SourceError> {
        let path = path.to_owned();
        if bytes.is_empty() {
            return Err(SourceError::Empty { path });
        }
        let (blake3, length) = (blake3::hash(&bytes).to_hex().to_string(), bytes.len() as u64);
        let text = String::from_utf8(bytes).map_err(|error| {
            let byte = error.utf8_error().valid_up_to();
            let line = 1 + error.as_bytes()[..byte].iter().filter(|b| **b == b'\n').count();
            let path = path.clone();
            SourceError::NotText { path, line, byte }
        })?;
        Ok(Self {
            path,
            text,
            blake3,
            bytes: length,
        })
    }

    pub(crate) fn with_short_lines(self) -> Result<Self, SourceError> {
        let mut lines = self.text.lines().map(str::len).enumerate();
        match lines.find(|(_, bytes)| *bytes > MAX_LINE) {
            None => Ok(self),
            Some((line, bytes)) => Err(SourceError::LongLine {
                path: self.path,
                line: line + 1,
                bytes,
            }),
        }
    }

    /// The lines that hold something, numbered from 1: neither blank nor a comment.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, &str)> {
        lines(&self.text).filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
    }
}

/// The lines of a text, numbered from 1, without a byte order mark.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.lines().enumerate().map(|(i, line)| (i + 1, line))
}

/// The comments of a text from their `#` on, without blanks around them, with the numbers of their lines.
pub(crate) fn comments(text: &str) -> impl Iterator<Item = (usize, &str)> {
    lines(text)
        .map(|(number, line)| (number, line.trim()))
        .filter(|(_, line)| line.starts_with('#'))
}

/// The bytes of a file, once it is known to be one and not too large.
fn bytes_of(path: &Path) -> Result<Vec<u8>, SourceError> {
    let failed = |source| SourceError::Read {
        path: path.to_owned(),
        source,
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(SourceError::NotAFile { path: path.to_owned() });
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    if length > MAX_BYTES {
        return Err(SourceError::TooLarge {
            path: path.to_owned(),
            bytes: length,
        });
    }
    // The file may have grown since.
    file.take(MAX_BYTES).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(bytes: &[u8]) -> String {
        let read = Source::from_bytes(Path::new("p.csv"), bytes.to_vec()).and_then(Source::with_short_lines);
        read.unwrap_err().to_string()
    }

    #[test]
    fn lines_keep_their_numbers() {
        let text = "\u{feff}a\r\n# comment\n\n  # another\nb,c\n";
        let source = Source::from_bytes(Path::new("p"), text.into()).unwrap();
        assert_eq!(source.rows().collect::<Vec<_>>(), [(1, "a"), (5, "b,c")]);
        assert_eq!(source.bytes, text.len() as u64);
    }

    #[test]
    fn what_is_no_text_is_refused() {
        assert!(refused(b"").contains("empty (0 bytes)"));
        assert!(refused(b"1\n2\n\xff").contains("line 3: byte 4 is not UTF-8"));
        assert!(refused(&[b'1'; 5000]).contains("line 1 has 5000 bytes, at most 4096"));
    }

    #[test]
    fn what_is_no_file_is_refused() {
        let read = |path: &str| Source::read(Path::new(path)).unwrap_err().to_string();
        assert!(read("/").contains("not a file"));
        assert!(read("/dev/zero").contains("not a file"));
        assert!(read("/no/such").contains("/no/such: No such file"));
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("large.csv");
        File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert!(Source::read(&path).unwrap_err().to_string().contains("67108865 bytes"));
    }
}
