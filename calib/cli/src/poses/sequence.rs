//! Sequences of the PLUS toolkit: MetaImage headers with a transform, a status and a time for each frame; or with the links
//! of a chain to it.
//!
//! Lines are `Seq_FrameNNNN_NameTransform = 16 numbers by rows`, `..._NameTransformStatus = OK`, `..._Timestamp = seconds`,
//! with lengths in mm. Pixels may follow the line `ElementDataFile = LOCAL` and are not read, only hashed.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use calib::file::sequence;
use geometry::{Marker, Rigid, Tracker};

use super::{PosesError, Recording, Seen, quoted};
use crate::input_files::source::{MAX_BYTES, Source, SourceError};

/// Reads the poses `transform` of a sequence, such as `StylusToTracker`, or composes them of others; of its only one where
/// none is named.
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
    let length = sequence::header_end(&bytes).ok_or_else(|| PosesError::NoHeaderEnd { path: path.to_owned() })?;
    bytes.truncate(length);
    let source = Source::from_bytes(path, bytes)?;
    Ok((source, hash.finalize().to_hex().to_string()))
}

/// One frame of a sequence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Timed {
    /// Its number in the file.
    pub(crate) number: u32,
    pub(crate) t_s: Option<f64>,
    pub(crate) pose: Option<Rigid<Tracker, Marker>>,
}

/// All frames of a sequence with a transform's poses, or with those that are composed for it.
pub(crate) fn timed(path: &Path, transform: &str) -> Result<Vec<Timed>, PosesError> {
    let (source, _) = header(path)?;
    let failed = |source| PosesError::Sequence {
        path: path.to_owned(),
        source,
    };
    let (frames, _) = sequence::chained(&source.text, transform).map_err(failed)?;
    let one = |frame: &sequence::Frame| Timed {
        number: frame.number,
        t_s: frame.t_s,
        pose: frame.poses.first().copied().flatten().and_then(|pose| pose.rigid()),
    };
    Ok(frames.iter().map(one).collect())
}

fn from_source(source: &Source, transform: Option<&str>) -> Result<Recording, PosesError> {
    let failed = |error| PosesError::Sequence {
        path: source.path.clone(),
        source: error,
    };
    let name = chosen(source, transform)?;
    let (frames, chain) = sequence::chained(&source.text, &name).map_err(failed)?;
    let mut recording = Recording::new(&source.path);
    recording.bytes = source.bytes;
    for frame in frames {
        let pose = frame.poses.first().copied().flatten();
        let seen = pose.and_then(|pose| {
            Some(Seen {
                pose: pose.rigid()?,
                off: pose.off,
                covariance: None,
            })
        });
        recording.add(frame.t_s, seen)?;
    }
    recording.transform = Some(match chain.links() {
        [link] if !link.inverse => name,
        _ => format!("{name} ({chain})"),
    });
    Ok(recording)
}

/// The transform asked for, or the only one.
fn chosen(source: &Source, asked: Option<&str>) -> Result<String, PosesError> {
    if let Some(asked) = asked {
        return Ok(asked.strip_suffix("Transform").unwrap_or(asked).to_owned());
    }
    let names = sequence::transforms(&source.text);
    match names.first() {
        Some(_) if names.len() > 1 => {
            let shown: Vec<String> = names.iter().take(10).map(|name| quoted(name)).collect();
            Err(PosesError::SeveralTransforms {
                path: source.path.clone(),
                found: shown.join(", "),
            })
        }
        // Without any, the reader says what it expects.
        only => Ok(only.copied().unwrap_or_default().to_owned()),
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
            (
                two.as_str(),
                Some("DToB"),
                "no transform DToB, and none can be composed of what there is; found AToB, CToB",
            ),
            (two.as_str(), Some("atoB"), "no transform atoB"),
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
    fn a_chain_is_composed_and_a_frame_without_a_link_has_no_pose() {
        let at = |frame: u32, name: &str, x: f64, status: &str| {
            format!(
                "Seq_Frame000{frame}_{name}Transform = 0 -1 0 {x} 1 0 0 0 0 0 1 0 0 0 0 1\nSeq_Frame000{frame}_{name}TransformStatus = \
                 {status}\n"
            )
        };
        let lines: String = (0..4)
            .map(|i| {
                let status = |bad: u32| if i == bad { "INVALID" } else { "OK" };
                at(i, "StylusTipToStylus", 7.0, status(3))
                    + &at(i, "StylusToTracker", f64::from(i), status(1))
                    + &at(i, "ReferenceToTracker", 2.0, status(2))
            })
            .collect();
        let found = parse(&lines, Some("StylusTipToReference")).unwrap();
        assert_eq!((found.frames, found.invalid), (4, 3));
        // Tip to stylus: (7, 0); a quarter turn of that and (0, 0): (0, 7); back from the reference: (x - 2, 7) turned by -90.
        let [x, y, z] = found.poses[0].translation_mm();
        assert!((x - 7.0).abs() + (y - 2.0).abs() + z.abs() < 1e-12, "{x} {y} {z}");
        let name = found.transform.unwrap();
        assert_eq!(
            name,
            "StylusTipToReference (StylusTipToStylus, then StylusToTracker, then inverse ReferenceToTracker)"
        );
        let error = parse(&lines, Some("ProbeToReference")).unwrap_err();
        assert!(
            error.contains("found ReferenceToTracker, StylusTipToStylus, StylusToTracker"),
            "{error}"
        );
        // A second way to the reference that is a millimetre off.
        let two = lines.clone() + &at(0, "StylusToReference", 5.0, "OK");
        let error = parse(&two, Some("StylusTipToReference")).unwrap_err();
        assert!(
            error.contains("frame 0:") && error.contains("mm and") && error.contains("apart"),
            "{error}"
        );
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "(Seq_Frame|[0-9]{1,12}|_|AToBTransform|Status|Timestamp| = |[-0-9. e]{0,9}|\n){0,40}") {
            let _ = parse(&text, None);
            let _ = parse(&text, Some("AToB"));
        }
    }
}
