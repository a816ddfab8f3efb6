//! The unpacked bytes of a file, in order, with the position and the reason of every failure.

use std::fs::{File, Metadata};
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};
use scene::file::OpenError;

use crate::source::{Place, ReadError};

/// The first two bytes of gzip, RFC 1952.
const GZIP: [u8; 2] = [0x1f, 0x8b];
const BUFFER_BYTES: usize = 1 << 16;

/// How a stream is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    /// Not at all.
    Plain,
    /// RFC 1952.
    Gzip,
    /// RFC 1950, or RFC 1952 where the first two bytes say so.
    Zlib,
}

/// A file's bytes, unpacked where it is compressed.
pub(crate) struct Stream {
    path: PathBuf,
    input: Input,
    position: u64,
    /// Bytes that there are, where that is known beforehand.
    length: Option<u64>,
    /// Of a compressed stream: bytes of the file from its first on, and the most that belong to it.
    packed: [u64; 2],
}

type Buffered = BufReader<Take<File>>;

enum Input {
    Plain(Buffered),
    Gzip(Box<MultiGzDecoder<Buffered>>),
    Zlib(Box<ZlibDecoder<Buffered>>),
}

impl Input {
    fn new(file: Buffered, packing: Packing) -> Self {
        match packing {
            Packing::Plain => Self::Plain(file),
            Packing::Gzip => Self::Gzip(Box::new(MultiGzDecoder::new(file))),
            Packing::Zlib => Self::Zlib(Box::new(ZlibDecoder::new(file))),
        }
    }
}

impl Stream {
    /// Opens `path`; whether it is compressed is told by its first bytes, not by its name.
    ///
    /// # Errors
    /// [`ReadError::Missing`], [`ReadError::NotAFile`], [`ReadError::Empty`], [`ReadError::Unreadable`].
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
        let (mut file, about) = open_file(path)?;
        let length = about.len();
        let unreadable = |source| opening(path, source);
        let gzip = length >= 2 && starts_as_gzip(&mut file).map_err(unreadable)?;
        file.rewind().map_err(unreadable)?;
        let packing = if gzip { Packing::Gzip } else { Packing::Plain };
        Ok(Self::over(path, file.take(u64::MAX), packing, [0, length]))
    }

    /// Opens `path` at byte `offset`, where at most `limit` bytes belong to the stream; nothing is guessed but whether
    /// what is said to be zlib is gzip. Positions count from the file's first byte where it is plain, and from the
    /// stream's first unpacked byte elsewhere.
    ///
    /// # Errors
    /// As [`Stream::open`].
    pub(crate) fn open_at(path: &Path, offset: u64, limit: u64, packing: Packing) -> Result<Self, ReadError> {
        let (mut file, about) = open_file(path)?;
        let length = about.len();
        let unreadable = |source| opening(path, source);
        file.seek(SeekFrom::Start(offset)).map_err(unreadable)?;
        let mut packing = packing;
        if packing == Packing::Zlib && length.saturating_sub(offset) >= 2 {
            if starts_as_gzip(&mut file).map_err(unreadable)? {
                packing = Packing::Gzip;
            }
            file.seek(SeekFrom::Start(offset)).map_err(unreadable)?;
        }
        Ok(Self::over(path, file.take(limit), packing, [offset, length]))
    }

    fn over(path: &Path, file: Take<File>, packing: Packing, [offset, length]: [u64; 2]) -> Self {
        let plain = packing == Packing::Plain;
        Self {
            packed: [length.saturating_sub(offset), file.limit()],
            path: path.to_owned(),
            input: Input::new(BufReader::with_capacity(BUFFER_BYTES, file), packing),
            position: if plain { offset } else { 0 },
            length: plain.then_some(length),
        }
    }

    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes given so far, counted as [`Stream::open_at`] tells.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Length of the unpacked data in bytes; unknown where it is compressed.
    pub(crate) fn length(&self) -> Option<u64> {
        self.length
    }

    /// Fills `out` with the next bytes; `end` is how many bytes the header asks for in all.
    ///
    /// # Errors
    /// [`ReadError::Truncated`], [`ReadError::BrokenOff`], [`ReadError::Corrupt`], [`ReadError::Unreadable`].
    pub(crate) fn fill(&mut self, out: &mut [u8], place: Place, end: u64) -> Result<(), ReadError> {
        let mut filled = 0;
        while filled < out.len() {
            match self.read(&mut out[filled..], place, end)? {
                0 => return Err(self.truncated(place, end)),
                count => filled += count,
            }
        }
        Ok(())
    }

    /// Passes over bytes up to `offset`.
    ///
    /// # Errors
    /// As [`Stream::fill`].
    pub(crate) fn skip_to(&mut self, offset: u64, end: u64) -> Result<(), ReadError> {
        let mut unused = [0; 4096];
        while self.position < offset {
            let step = (offset - self.position).min(unused.len() as u64) as usize;
            self.fill(&mut unused[..step], Place::Header, end)?;
        }
        Ok(())
    }

    /// Reads on to the end, which makes a compressed stream check its length and checksum; at most `most` more bytes, whose number is given.
    ///
    /// # Errors
    /// As [`Stream::fill`], and [`ReadError::TooLong`].
    pub(crate) fn drain(&mut self, most: u64) -> Result<u64, ReadError> {
        let expected = self.position;
        let mut unused = [0; 4096];
        while self.read(&mut unused, Place::End, expected)? > 0 {
            if self.position - expected > most {
                return Err(ReadError::TooLong {
                    path: self.path.clone(),
                    expected,
                    found: self.position,
                });
            }
        }
        Ok(self.position - expected)
    }

    /// Bytes of the file behind those of a compressed stream that was read to its end; 0 where it is not compressed.
    pub(crate) fn packed_behind(&self) -> u64 {
        let [there, limit] = self.packed;
        match &self.input {
            Input::Plain(_) => 0,
            // Of several gzip streams each is read.
            Input::Gzip(_) => there.saturating_sub(limit),
            Input::Zlib(decoder) => there.saturating_sub(decoder.total_in()),
        }
    }

    /// Some of the next bytes; none at the end.
    ///
    /// # Errors
    /// As [`Stream::fill`], but for `Truncated`.
    pub(crate) fn read(&mut self, out: &mut [u8], place: Place, end: u64) -> Result<usize, ReadError> {
        loop {
            let read = match &mut self.input {
                Input::Plain(file) => file.read(out),
                Input::Gzip(decoder) => decoder.read(out),
                Input::Zlib(decoder) => decoder.read(out),
            };
            match read {
                Ok(count) => {
                    self.position += count as u64;
                    return Ok(count);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.failure(error, place, end)),
            }
        }
    }

    fn truncated(&self, place: Place, end: u64) -> ReadError {
        ReadError::Truncated {
            path: self.path.clone(),
            place,
            expected: end,
            found: self.position,
        }
    }

    /// The decoder tells a short stream and a damaged one by kinds of I/O error.
    fn failure(&self, source: std::io::Error, place: Place, end: u64) -> ReadError {
        let (path, byte) = (self.path.clone(), self.position);
        match (source.kind(), &self.input) {
            (ErrorKind::UnexpectedEof, Input::Gzip(_) | Input::Zlib(_)) => ReadError::BrokenOff {
                path,
                place,
                expected: end,
                found: byte,
            },
            (ErrorKind::InvalidInput | ErrorKind::InvalidData, Input::Gzip(_) | Input::Zlib(_)) => ReadError::Corrupt {
                path,
                place,
                byte,
                detail: source.to_string(),
            },
            _ => ReadError::Unreadable {
                path,
                place,
                byte,
                source,
            },
        }
    }
}

fn starts_as_gzip(file: &mut File) -> std::io::Result<bool> {
    let mut first = [0; 2];
    file.read_exact(&mut first)?;
    Ok(first == GZIP)
}

/// Opens a regular file that has bytes; with what is known of it.
///
/// # Errors
/// [`ReadError::Missing`], [`ReadError::NotAFile`], [`ReadError::Empty`], [`ReadError::Unreadable`].
pub(crate) fn open_file(path: &Path) -> Result<(File, Metadata), ReadError> {
    let (file, about) = scene::file::open(path).map_err(|error| match error {
        OpenError::NotAFile { found } => ReadError::NotAFile {
            path: path.to_owned(),
            found,
        },
        error => opening(path, error.into()),
    })?;
    match about.len() {
        0 => Err(ReadError::Empty { path: path.to_owned() }),
        _ => Ok((file, about)),
    }
}

/// The reason why `path` could not be opened.
pub(crate) fn opening(path: &Path, source: std::io::Error) -> ReadError {
    let path = path.to_owned();
    if source.kind() == ErrorKind::NotFound {
        return match path.is_symlink() {
            true => ReadError::Dangling { path },
            false => ReadError::Missing { path },
        };
    }
    ReadError::Unreadable {
        path,
        place: Place::Header,
        byte: 0,
        source,
    }
}
