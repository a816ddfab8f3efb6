//! The images of a sequence of PLUS (MetaImage, `.mha`): 8 bits a pixel, plain or deflated (zlib), one image at a time.
//!
//! Whatever the header promises, no more than one image is held. Frame i of the header is image i of the data. Images
//! are taken in PLUS's own orientation `MF` (columns from the probe's marked side, rows away from it), which PLUS
//! writes and in which its device sets tell places; without a word of it, as they are.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::ZlibDecoder;

use super::MAX_POSES;
use crate::input_files::source::MAX_BYTES;

/// Columns and rows: as [`ultrasound::Shape`] allows.
const SIDES: std::ops::RangeInclusive<usize> = 16..=4096;
/// The line after which the data begin.
const LAST_KEY: &str = "ElementDataFile";

/// Why a sequence gave no images. Lines count from 1, bytes and images from 0.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PixelsError {
    /// The file could not be opened or read.
    #[error("reading {path}: {source}. Check the name and the permissions")]
    Read { path: PathBuf, source: io::Error },
    /// A folder, a pipe or a device.
    #[error("reading {path}: this is not a file; give a sequence of PLUS, .mha")]
    NotAFile { path: PathBuf },
    /// There is no end of the header, or it is no text.
    #[error(
        "reading {path}: the header does not end in a line {LAST_KEY} within {MAX_BYTES} bytes of text; is it a \
         sequence?"
    )]
    NoHeaderEnd { path: PathBuf },
    /// A key that must be there.
    #[error("reading {path}: the header has no line {key}; expected {expected}")]
    NoKey {
        path: PathBuf,
        key: &'static str,
        expected: &'static str,
    },
    /// A key with another value than is read.
    #[error("reading {path}: line {line}: {key} is {found:?}; expected {expected}")]
    Value {
        path: PathBuf,
        line: usize,
        key: &'static str,
        found: String,
        expected: &'static str,
    },
    /// The data end too early, or are no deflated bytes.
    #[error(
        "reading {path}: image {image} of {of}: {source} after {found} of its {expected} bytes; the data begin at byte \
         {begin}. Copy the file again"
    )]
    Data {
        path: PathBuf,
        image: usize,
        of: usize,
        found: usize,
        expected: usize,
        begin: u64,
        source: io::Error,
    },
    /// More than the header says.
    #[error("reading {path}: the data go on after the last of {of} images of {columns} x {rows}; DimSize is too small")]
    More {
        path: PathBuf,
        of: usize,
        columns: usize,
        rows: usize,
    },
}

/// The images of a sequence, read one after another.
pub(crate) struct Pixels {
    path: PathBuf,
    columns: usize,
    rows: usize,
    count: usize,
    next: usize,
    begin: u64,
    data: Box<dyn Read>,
    grey: Vec<u8>,
}

/// What a header says of its images.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Pictured {
    /// Columns and rows; `None` of a sequence of poses alone.
    pub(crate) size_px: Option<[usize; 2]>,
    /// `UltrasoundImageOrientation`.
    pub(crate) orientation: Option<String>,
}

/// A line of the header: its number, its key and its value.
type Line = (usize, String, String);

impl Pixels {
    /// Opens a sequence and checks what its header says of its images.
    ///
    /// # Errors
    /// [`PixelsError`]: all but [`PixelsError::Data`] and [`PixelsError::More`].
    pub(crate) fn open(path: &Path) -> Result<Self, PixelsError> {
        Self::over(path, opened(path)?)
    }

    /// What the header of a sequence says of its images, which it need not have.
    ///
    /// # Errors
    /// [`PixelsError::Read`], [`PixelsError::NotAFile`], [`PixelsError::NoHeaderEnd`].
    pub(crate) fn pictured(path: &Path) -> Result<Pictured, PixelsError> {
        let (lines, _) = header(path, &mut opened(path)?)?;
        let header = Header { path, lines: &lines };
        Ok(Pictured {
            size_px: header.size().ok().map(|[columns, rows, _]| [columns, rows]),
            orientation: header
                .get("UltrasoundImageOrientation")
                .map(|(_, value)| value.chars().take(8).collect()),
        })
    }

    /// The same of bytes that lie elsewhere.
    fn over(path: &Path, mut bytes: impl BufRead + 'static) -> Result<Self, PixelsError> {
        let (lines, begin) = header(path, &mut bytes)?;
        let header = Header { path, lines: &lines };
        let [columns, rows, count] = header.size()?;
        let data: Box<dyn Read> = match header.is_packed()? {
            true => Box::new(ZlibDecoder::new(bytes)),
            false => Box::new(bytes),
        };
        Ok(Self {
            path: path.to_owned(),
            columns,
            rows,
            count,
            next: 0,
            begin,
            data,
            grey: vec![0; columns * rows],
        })
    }

    /// Pixels in a row, and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// How many images there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The next image with its number, row by row; `None` after the last one.
    ///
    /// # Errors
    /// [`PixelsError::Data`]; after the last, [`PixelsError::More`].
    pub(crate) fn next(&mut self) -> Result<Option<(u32, &[u8])>, PixelsError> {
        if self.next == self.count {
            return self.ended().map(|()| None);
        }
        let mut found = 0;
        while found < self.grey.len() {
            // A read of 0 bytes is the end: `read_exact` would not tell how many there were.
            let read = match self.data.read(&mut self.grey[found..]) {
                Ok(0) => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the data end")),
                other => other,
            };
            match read {
                Ok(bytes) => found += bytes,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(source) => {
                    return Err(PixelsError::Data {
                        path: self.path.clone(),
                        image: self.next,
                        of: self.count,
                        found,
                        expected: self.grey.len(),
                        begin: self.begin,
                        source,
                    });
                }
            }
        }
        let number = self.next as u32;
        self.next += 1;
        Ok(Some((number, &self.grey)))
    }

    /// Whether nothing follows the last image. What cannot be read there is as good as nothing.
    fn ended(&mut self) -> Result<(), PixelsError> {
        match self.data.read(&mut [0]) {
            Ok(0) | Err(_) => Ok(()),
            Ok(_) => Err(PixelsError::More {
                path: self.path.clone(),
                of: self.count,
                columns: self.columns,
                rows: self.rows,
            }),
        }
    }
}

fn opened(path: &Path) -> Result<BufReader<File>, PixelsError> {
    let failed = |source| PixelsError::Read {
        path: path.to_owned(),
        source,
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(PixelsError::NotAFile { path: path.to_owned() });
    }
    Ok(BufReader::new(File::open(path).map_err(failed)?))
}

/// The lines of the header, without those of single frames, and the byte after it.
fn header(path: &Path, bytes: &mut impl BufRead) -> Result<(Vec<Line>, u64), PixelsError> {
    let no_end = || PixelsError::NoHeaderEnd { path: path.to_owned() };
    let (mut lines, mut begin) = (Vec::new(), 0);
    for number in 1.. {
        let mut line = Vec::new();
        let read = bytes.by_ref().take(MAX_BYTES - begin).read_until(b'\n', &mut line);
        begin += read.map_err(|source| PixelsError::Read {
            path: path.to_owned(),
            source,
        })? as u64;
        if line.last() != Some(&b'\n') {
            break;
        }
        let text = String::from_utf8(line).map_err(|_| no_end())?;
        if text.starts_with("Seq_") {
            continue;
        }
        if let Some((key, value)) = text.split_once('=') {
            lines.push((number, key.trim().to_owned(), value.trim().to_owned()));
        }
        if text.starts_with(LAST_KEY) {
            return Ok((lines, begin));
        }
    }
    Err(no_end())
}

struct Header<'a> {
    path: &'a Path,
    lines: &'a [Line],
}

impl Header<'_> {
    fn get(&self, key: &str) -> Option<(usize, &str)> {
        let line = self.lines.iter().find(|(_, name, _)| name == key);
        line.map(|(number, _, value)| (*number, value.as_str()))
    }

    /// Refuses a key whose value is not among those that are read; a key that is not there is as good.
    fn only(
        &self,
        key: &'static str,
        is_read: impl Fn(&str) -> bool,
        expected: &'static str,
    ) -> Result<(), PixelsError> {
        match self.get(key) {
            Some((line, value)) if !is_read(value) => Err(self.value(line, key, value, expected)),
            _ => Ok(()),
        }
    }

    fn value(&self, line: usize, key: &'static str, found: &str, expected: &'static str) -> PixelsError {
        PixelsError::Value {
            path: self.path.to_owned(),
            line,
            key,
            found: found.chars().take(64).collect(),
            expected,
        }
    }

    /// Columns, rows and images, after everything that would make bytes mean something else.
    fn size(&self) -> Result<[usize; 3], PixelsError> {
        let local = "LOCAL: images in the same file; save the sequence as one .mha";
        self.only(LAST_KEY, |value| value == "LOCAL", local)?;
        self.only("BinaryData", |value| value.eq_ignore_ascii_case("true"), "True")?;
        self.only("HeaderSize", |value| value == "0", "0")?;
        self.only("ElementNumberOfChannels", |value| value == "1", "1: grey images")?;
        let orientation =
            "MF, MFA or MFD, as PLUS saves images: columns from the marked side, rows away from the probe";
        let is_straight = |value: &str| matches!(value, "MF" | "MFA" | "MFD");
        self.only("UltrasoundImageOrientation", is_straight, orientation)?;
        let kind = "MET_UCHAR, 8 bits a pixel";
        self.must("ElementType", kind)?;
        self.only("ElementType", |value| value == "MET_UCHAR", kind)?;
        let expected = "columns and rows of 16 to 4096, and 1 to 200000 images";
        let (line, text) = self.must("DimSize", expected)?;
        let numbers: Option<Vec<usize>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let size: Option<[usize; 3]> = numbers.and_then(|all| all.try_into().ok());
        let is_right = |[columns, rows, count]: &[usize; 3]| {
            SIDES.contains(columns) && SIDES.contains(rows) && (1..=MAX_POSES).contains(count)
        };
        size.filter(is_right)
            .ok_or_else(|| self.value(line, "DimSize", text, expected))
    }

    fn must(&self, key: &'static str, expected: &'static str) -> Result<(usize, &str), PixelsError> {
        self.get(key).ok_or_else(|| PixelsError::NoKey {
            path: self.path.to_owned(),
            key,
            expected,
        })
    }

    fn is_packed(&self) -> Result<bool, PixelsError> {
        let Some((line, value)) = self.get("CompressedData") else {
            return Ok(false);
        };
        match value.to_ascii_lowercase().as_str() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => Err(self.value(line, "CompressedData", value, "True or False")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::write::ZlibEncoder;
    use proptest::prelude::*;
    use std::io::{Cursor, Write};

    const HEADER: &str = "ObjectType = Image\nNDims = 3\nCompressedData = False\nDimSize = 16 17 3\nElementType = MET_UCHAR\n\
                          UltrasoundImageOrientation = MFA\nSeq_Frame0000_Timestamp = 1\nElementDataFile = LOCAL\n";

    fn images() -> Vec<u8> {
        (0..3 * 16 * 17).map(|i| (i % 251) as u8).collect()
    }

    /// All images one after another, or what is refused.
    fn read(header: &str, data: &[u8]) -> Result<Vec<u8>, String> {
        let bytes = [header.as_bytes(), data].concat();
        let mut pixels = Pixels::over(Path::new("s.mha"), Cursor::new(bytes)).map_err(|e| e.to_string())?;
        let mut all = Vec::new();
        let mut expected = 0;
        while let Some((number, grey)) = pixels.next().map_err(|e| e.to_string())? {
            assert_eq!(number, expected);
            expected += 1;
            all.extend_from_slice(grey);
        }
        Ok(all)
    }

    fn packed(data: &[u8]) -> Vec<u8> {
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(data).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn plain_and_packed_images_are_read_as_they_were_written() {
        assert_eq!(read(HEADER, &images()).unwrap(), images());
        let header = HEADER.replace("False", "True");
        assert_eq!(read(&header, &packed(&images())).unwrap(), images());
    }

    #[test]
    fn what_is_no_sequence_of_grey_images_is_refused_with_its_line() {
        for (from, to, words) in [
            ("LOCAL", "s.raw", "line 8: ElementDataFile is \"s.raw\"; expected LOCAL"),
            (
                "MET_UCHAR",
                "MET_SHORT",
                "line 5: ElementType is \"MET_SHORT\"; expected MET_UCHAR",
            ),
            ("ElementType", "Element", "no line ElementType"),
            ("MFA", "UF", "line 6: UltrasoundImageOrientation is \"UF\"; expected MF"),
            ("16 17 3", "16 17", "line 4: DimSize is \"16 17\""),
            ("16 17 3", "99999999999 99999999999 99999999999", "DimSize"),
            ("16 17 3", "16 -17 3", "DimSize"),
            ("16 17 3", "16 17 0", "DimSize"),
            ("False", "maybe", "line 3: CompressedData is \"maybe\""),
            (
                "NDims = 3",
                "ElementNumberOfChannels = 3",
                "line 2: ElementNumberOfChannels",
            ),
            ("ElementDataFile", "Element", "does not end in a line ElementDataFile"),
        ] {
            let error = read(&HEADER.replace(from, to), &images()).unwrap_err();
            assert!(error.contains(words), "{from} {to}: {error}");
        }
        let missing = Pixels::open(Path::new("/no/such.mha")).err().unwrap().to_string();
        assert!(missing.contains("/no/such.mha: No such file"), "{missing}");
        assert!(
            Pixels::open(Path::new("/dev/zero"))
                .err()
                .unwrap()
                .to_string()
                .contains("not a file")
        );
    }

    #[test]
    fn data_that_end_early_or_go_on_are_refused_with_the_image() {
        let all = images();
        let error = read(HEADER, &all[..300]).unwrap_err();
        assert!(
            error.contains("image 1 of 3: the data end after 28 of its 272 bytes"),
            "{error}"
        );
        let error = read(HEADER, &[&all[..], &[7]].concat()).unwrap_err();
        assert!(error.contains("go on after the last of 3 images of 16 x 17"), "{error}");
        let header = HEADER.replace("False", "True");
        let whole = packed(&all);
        let error = read(&header, &whole[..whole.len() / 2]).unwrap_err();
        assert!(
            error.contains("of its 272 bytes") && error.contains("begin at byte 1"),
            "{error}"
        );
        assert!(read(&header, &all).unwrap_err().contains("image 0 of 3"));
        // More images packed than the header has room for: told, and never unpacked.
        let long = packed(&vec![0; 1 << 22]);
        assert!(read(&header, &long).unwrap_err().contains("go on after the last"));
    }

    proptest! {
        #[test]
        fn no_bytes_panic(text in "(DimSize|ElementType|CompressedData|ElementDataFile| = |16|MET_UCHAR|LOCAL|True|[ -~]{0,5}|\n){0,40}",
                          data in proptest::collection::vec(any::<u8>(), 0..600)) {
            let _ = read(&text, &data);
            let _ = read(&HEADER.replace("False", "True"), &data);
        }
    }
}
