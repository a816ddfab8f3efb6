//! Sequences of the PLUS toolkit: MetaImage headers with a transform, a status and a time for each frame.
//!
//! Lines are `Seq_FrameNNNN_NameTransform = 16 numbers by rows`, `..._NameTransformStatus = OK`, `..._Timestamp = seconds`,
//! with lengths in mm. Pixels may follow the line `ElementDataFile = LOCAL` and are not read, only hashed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::matrix::At;
use super::{MAX_POSES, PosesError, Recording, Seen, quoted};
use crate::fields;
use crate::source::{MAX_BYTES, Source, SourceError};

/// The line that ends a header.
const END: &str = "ElementDataFile";

/// Reads the poses `transform` of a sequence, such as `StylusToTracker`; of its only one where none is named.
pub(super) fn read(path: &Path, transform: Option<&str>) -> Result<Recording, PosesError> {
    let (source, blake3) = header(path)?;
    let mut recording = from_source(&source, transform)?;
    recording.blake3 = blake3;
    Ok(recording)
}

/// The header as text, and the hash of the whole file.
fn header(path: &Path) -> Result<(Source, String), PosesError> {
    let failed = |source| PosesError::Read {
        path: path.to_owned(),
        source,
    };
    // Asked for before opening: opening a pipe would wait for its writer.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        let path = path.to_owned();
        return Err(SourceError::NotAFile { path }.into());
    }
    let mut file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.by_ref().take(MAX_BYTES).read_to_end(&mut bytes).map_err(failed)?;
    let mut hash = blake3::Hasher::new();
    hash.update(&bytes);
    io::copy(&mut file, &mut hash).map_err(failed)?;
    let length = end(&bytes).ok_or_else(|| PosesError::NoHeaderEnd { path: path.to_owned() })?;
    bytes.truncate(length);
    let source = Source::from_bytes(path, bytes)?;
    Ok((source, hash.finalize().to_hex().to_string()))
}

/// Where the header ends: after the line that begins with [`END`].
fn end(bytes: &[u8]) -> Option<usize> {
    let mut start = 0;
    for line in bytes.split_inclusive(|b| *b == b'\n') {
        start += line.len();
        if line.starts_with(END.as_bytes()) {
            return Some(start);
        }
    }
    None
}

/// The lines of a frame that matter: number and value each.
#[derive(Default)]
struct Frame<'a> {
    matrix: Option<(usize, &'a str)>,
    status: Option<&'a str>,
    time: Option<(usize, &'a str)>,
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

fn from_source(source: &Source, transform: Option<&str>) -> Result<Recording, PosesError> {
    let name = chosen(source, transform)?;
    let (matrix, status) = (format!("{name}Transform"), format!("{name}TransformStatus"));
    let mut frames: BTreeMap<u32, Frame<'_>> = BTreeMap::new();
    for (i, text) in source.text.lines().enumerate() {
        let Some((number, field, value)) = field(text) else {
            continue;
        };
        let frame = frames.entry(number).or_default();
        match field {
            "Timestamp" => frame.time = Some((i + 1, value)),
            _ if field == matrix => frame.matrix = Some((i + 1, value)),
            _ if field == status => frame.status = Some(value),
            _ => {}
        }
        if frames.len() > MAX_POSES {
            let path = source.path.clone();
            return Err(PosesError::TooMany { path });
        }
    }
    let mut recording = Recording::new(&source.path);
    recording.bytes = source.bytes;
    for frame in frames.values() {
        let time = frame.time.map(|(line, text)| time(source, line, text)).transpose()?;
        recording.add(time, frame.seen(source)?)?;
    }
    recording.transform = Some(name);
    Ok(recording)
}

/// The transform asked for, or the only one.
fn chosen(source: &Source, asked: Option<&str>) -> Result<String, PosesError> {
    let names: BTreeSet<&str> = source
        .text
        .lines()
        .filter_map(|line| field(line)?.1.strip_suffix("Transform"))
        .collect();
    let path = source.path.clone();
    let shown: Vec<String> = names.iter().take(10).map(|name| quoted(name)).collect();
    let found = if shown.is_empty() {
        "none".to_owned()
    } else {
        shown.join(", ")
    };
    match (asked, names.first()) {
        (Some(asked), _) => {
            let asked = asked.strip_suffix("Transform").unwrap_or(asked);
            let missing = || PosesError::NoTransform {
                path,
                asked: quoted(asked),
                found,
            };
            names.contains(asked).then(|| asked.to_owned()).ok_or_else(missing)
        }
        (None, Some(only)) if names.len() == 1 => Ok((*only).to_owned()),
        (None, Some(_)) => Err(PosesError::SeveralTransforms { path, found }),
        (None, None) => Err(PosesError::NoPoses {
            path,
            expected: "expected lines such as Seq_Frame0000_StylusToTrackerTransform = 16 numbers",
        }),
    }
}

fn time(source: &Source, line: usize, text: &str) -> Result<f64, PosesError> {
    let at = At {
        path: &source.path,
        line,
    };
    let field = fields::plain(text).into_iter().next();
    let field = field.unwrap_or(fields::Field {
        text: "".into(),
        column: 1,
    });
    at.number(&field, "Timestamp")
}

impl Frame<'_> {
    /// The pose, where the frame has the transform and its status is OK or absent.
    fn seen(&self, source: &Source) -> Result<Option<Seen>, PosesError> {
        let Some((line, text)) = self.matrix.filter(|_| self.status.is_none_or(|s| s == "OK")) else {
            return Ok(None);
        };
        let at = At {
            path: &source.path,
            line,
        };
        let row = fields::plain(text);
        let mut numbers = Vec::with_capacity(16);
        for field in row.iter().take(17) {
            numbers.push(at.number(field, "a 4 x 4 matrix")?);
        }
        let matrix: [f64; 16] = numbers.try_into().map_err(|_| PosesError::Count {
            path: source.path.clone(),
            line,
            found: row.len(),
            what: "numbers of a matrix",
            expected: 16,
        })?;
        at.matrix(&matrix).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ONE: &str = "1 0 0 5 0 1 0 6 0 0 1 7 -0 0 -0 1";

    fn parse(text: &str, transform: Option<&str>) -> Result<Recording, String> {
        let source = Source::from_bytes(Path::new("p.mha"), text.into()).map_err(|e| e.to_string())?;
        let found = from_source(&source, transform).and_then(|r| r.checked(false));
        found.map_err(|e| e.to_string())
    }

    #[test]
    fn frames_are_taken_by_their_number_and_status() {
        let text = format!(
            "ObjectType = Image\nSeq_Frame0001_AToBTransform = 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\n\
             Seq_Frame0001_Timestamp = 2.5\nSeq_Frame0000_AToBTransform = {ONE}\nSeq_Frame0000_Timestamp = 2.6\n\
             Seq_Frame0002_AToBTransform = 0 0 0 0\nSeq_Frame0002_AToBTransformStatus = INVALID\n\
             Seq_Frame0003_Timestamp = 3\nSeq_Frame0000_AToBTransformStatus = OK\n"
        );
        for transform in [None, Some("AToB"), Some("AToBTransform")] {
            let found = parse(&text, transform).unwrap();
            assert_eq!((found.frames, found.invalid, found.backwards), (4, 2, 1));
            assert_eq!(found.poses[0].translation_mm(), [5.0, 6.0, 7.0]);
            assert_eq!(found.transform.as_deref(), Some("AToB"));
        }
    }

    #[test]
    fn what_is_wrong_is_told() {
        let frame = |matrix: &str| format!("\nSeq_Frame0000_AToBTransform = {matrix}\n");
        let two = format!("{}Seq_Frame0000_CToBTransform = {ONE}\n", frame(ONE));
        for (text, transform, words) in [
            ("ObjectType = Image\n", None, "no pose in it"),
            (two.as_str(), None, "several transforms: AToB, CToB"),
            (two.as_str(), Some("DToB"), "no transform DToB; found AToB, CToB"),
            (&frame("1 0 0"), None, "line 2: 3 numbers of a matrix, expected 16"),
            (
                &frame("1 0 0 5 0 1 0 6 0 0 x 7 0 0 0 1"),
                None,
                "line 2, column 21 (a 4 x 4 matrix): found \"x\"",
            ),
            (&frame("1 0 0 5 0 1 0 6 0 0 1 7 0 0 1 1"), None, "expected 0 0 0 1"),
            (&frame("1 0 0 5 0 1 0 6 0 0 -1 7 0 0 0 1"), None, "holds no rotation"),
            (&frame("2 0 0 5 0 2 0 6 0 0 2 7 0 0 0 1"), None, "off by 1.73e0"),
        ] {
            let error = parse(text, transform).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    #[test]
    fn the_header_ends_before_the_pixels() {
        assert_eq!(end(b"A = 1\nElementDataFile = LOCAL\n\xff\xfe"), Some(30));
        assert_eq!(end(b"A = 1\n"), None);
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "(Seq_Frame|[0-9]{1,12}|_|AToBTransform|Status|Timestamp| = |[-0-9. e]{0,9}|\n){0,40}") {
            let _ = parse(&text, None);
            let _ = parse(&text, Some("AToB"));
        }
    }
}
