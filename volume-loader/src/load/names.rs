//! Names of a label map's structures: of the map's own header, and of files beside it that have its name.
//!
//! | file | whose convention |
//! |---|---|
//! | the header of an NRRD file | segmentations of 3D Slicer, `.seg.nrrd` |
//! | the segments of a DICOM segmentation | SegmentLabel; counted as lines |
//! | `NAME.label`, or `NAME.txt` that says so in its first lines | ITK-SNAP's label descriptions |
//! | `NAME.ctbl` | color tables of 3D Slicer |
//!
//! `NAME` is the map's file name without its endings. A file that names some other map's structures would be worse than none: no other
//! is looked at.

use std::io;
use std::path::{Path, PathBuf};

use guidance::safety::{LabelNames, NamesError};

use super::segmentation;
use crate::raster::Head;
use crate::source::ReadError;

/// A file of names is no longer than this, bytes.
const LONGEST: u64 = 1 << 20;
/// Endings of label maps; the longer first.
const ENDINGS: [&str; 9] = [
    ".dcm",
    ".seg.nrrd",
    ".seg.nhdr",
    ".nii.gz",
    ".nii",
    ".nrrd",
    ".nhdr",
    ".mha",
    ".mhd",
];
/// What ITK-SNAP writes at the beginning of its file.
const SNAP: &[u8] = b"# ITK-SnAP Label Description File";

/// Why names are not known.
#[derive(Debug, thiserror::Error)]
pub enum LabelNamesError {
    /// The file cannot be read.
    #[error("names of structures: {0}")]
    Read(#[from] ReadError),
    /// It could not be looked for.
    #[error("names of structures: looking for {path}: {source}")]
    Look {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is longer than such files are.
    #[error("names of structures: {path} is longer than {LONGEST} bytes")]
    Long {
        /// Which file.
        path: PathBuf,
    },
    /// It says something that cannot be used.
    #[error("names of structures: {path}: {source}")]
    Names {
        /// Which file.
        path: PathBuf,
        /// What.
        source: NamesError,
    },
}

/// The names that a label map comes with; none where there is no such file.
///
/// # Errors
/// [`LabelNamesError`]; two names of one label, also of two files, are refused.
pub fn label_names(map: &Path) -> Result<LabelNames, LabelNamesError> {
    let mut names = of_header(map)?
        .and(of_segmentation(map)?)
        .map_err(|source| refused(map, source))?;
    for (path, kind) in beside(map) {
        let found = path.try_exists();
        let is_there = found.map_err(|source| LabelNamesError::Look {
            path: path.clone(),
            source,
        })?;
        if !is_there {
            continue;
        }
        let refused = |source| refused(&path, source);
        let Some(text) = text(&path, kind)? else { continue };
        let more = match kind {
            Kind::ColorTable => LabelNames::of_color_table(&text),
            Kind::Snap | Kind::SnapIfSo => LabelNames::of_itk_snap(&text),
        };
        names = names.and(more.map_err(refused)?).map_err(refused)?;
    }
    Ok(names)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Snap,
    /// Of an ending that other files have too.
    SnapIfSo,
    ColorTable,
}

fn beside(map: &Path) -> Vec<(PathBuf, Kind)> {
    let Some(name) = map.file_name().and_then(|name| name.to_str()) else {
        return Vec::new();
    };
    let lower = name.to_lowercase();
    let ending = ENDINGS.into_iter().find(|ending| lower.ends_with(ending));
    let stem = ending.and_then(|ending| name.get(..name.len() - ending.len()));
    let Some(stem) = stem.filter(|stem| !stem.is_empty()) else {
        return Vec::new();
    };
    let kinds = [
        ("label", Kind::Snap),
        ("txt", Kind::SnapIfSo),
        ("ctbl", Kind::ColorTable),
    ];
    kinds
        .map(|(ending, kind)| (map.with_file_name(format!("{stem}.{ending}")), kind))
        .into()
}

/// The text of a file; `None` where it is none of names.
fn text(path: &Path, kind: Kind) -> Result<Option<String>, LabelNamesError> {
    // One byte more than may be, to see that there is more.
    let mut head = Head::read_some(path, LONGEST + 1)?;
    let begins = head.first(512);
    if kind == Kind::SnapIfSo && !begins.windows(SNAP.len()).any(|part| part == SNAP) {
        return Ok(None);
    }
    let mut text = String::new();
    while let Some(line) = head.line() {
        text.push_str(&line.text);
        text.push('\n');
    }
    match head.position() > LONGEST {
        true => Err(LabelNamesError::Long { path: path.to_owned() }),
        false => Ok(Some(text)),
    }
}

fn refused(path: &Path, source: NamesError) -> LabelNamesError {
    let path = path.to_owned();
    LabelNamesError::Names { path, source }
}

/// The names of the segments of a DICOM segmentation.
fn of_segmentation(map: &Path) -> Result<LabelNames, LabelNamesError> {
    let Some((found, _)) = segmentation::open(map, None)? else {
        return Ok(LabelNames::default());
    };
    let named = found.segments().iter().filter(|(_, name)| !name.is_empty());
    let pairs = named.map(|(label, name)| (*label, name.as_str()));
    LabelNames::of_pairs(pairs).map_err(|source| refused(map, source))
}

/// The names in the header of an NRRD file.
fn of_header(map: &Path) -> Result<LabelNames, LabelNamesError> {
    let lower = map.to_string_lossy().to_lowercase();
    if !lower.ends_with(".nrrd") && !lower.ends_with(".nhdr") {
        return Ok(LabelNames::default());
    }
    let mut head = Head::read(map)?;
    let mut keys = Vec::new();
    while let Some(line) = head.line() {
        if line.text.is_empty() {
            break;
        }
        if let Some((key, value)) = line.text.split_once(":=") {
            keys.push((line.number, key.to_owned(), unescaped(value)));
        }
    }
    let each = keys
        .iter()
        .map(|(line, key, value)| (*line, key.as_str(), value.as_str()));
    LabelNames::of_segments(each).map_err(|source| refused(map, source))
}

/// A value as it was before it was written in one line: `\n` is a line's end, `\\` a backslash.
fn unescaped(value: &str) -> String {
    let mut plain = String::new();
    let mut rest = value.chars();
    while let Some(c) = rest.next() {
        match (c, rest.clone().next()) {
            ('\\', Some('n')) => plain.push('\n'),
            ('\\', Some('\\')) => plain.push('\\'),
            _ => {
                plain.push(c);
                continue;
            }
        }
        rest.next();
    }
    plain
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const MAP: &[u8] = b"NRRD0004\n# made by hand\ntype: uint8\ndimension: 3\nSegment0_Name:=liver\\\\left\nSegment0_LabelValue:=5\n\nSegment1_Name:=x";

    #[test]
    fn names_come_from_the_header_and_from_files_of_the_same_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("organs.seg.nrrd"), MAP).unwrap();
        fs::write(at("organs.txt"), "notes of the surgeon").unwrap();
        fs::write(at("other.ctbl"), "5 other 0 0 0 0").unwrap();
        let names = label_names(&at("organs.seg.nrrd")).unwrap();
        assert_eq!((names.len(), names.get(5)), (1, Some("liver\\left")));
        fs::write(at("organs.ctbl"), "6 spleen 0 0 0 255\n").unwrap();
        let snap = "####\n# ITK-SnAP Label Description File\n7 0 0 0 1 1 1 \"portal vein\"\n";
        fs::write(at("organs.txt"), snap).unwrap();
        let names = label_names(&at("organs.seg.nrrd")).unwrap();
        assert_eq!(
            (names.len(), names.get(6), names.get(7)),
            (3, Some("spleen"), Some("portal vein"))
        );
        // Of a map that has no header of its own for them.
        assert_eq!(label_names(&at("organs.nii.gz")).unwrap().len(), 2);
        assert!(label_names(&at("other")).unwrap().is_empty());
    }

    #[test]
    fn what_is_not_certain_is_refused_with_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let refusal = || label_names(&at("organs.nrrd")).unwrap_err().to_string();
        fs::write(at("organs.nrrd"), MAP).unwrap();
        fs::write(at("organs.ctbl"), "5 spleen 0 0 0 0\n").unwrap();
        let said = refusal();
        assert!(
            said.contains("organs.ctbl") && said.contains("label 5 is \"spleen\", and was"),
            "{said}"
        );
        fs::write(at("organs.ctbl"), vec![b'#'; (LONGEST + 1) as usize]).unwrap();
        assert!(
            refusal().contains("organs.ctbl is longer than 1048576 bytes"),
            "{}",
            refusal()
        );
        fs::write(at("organs.ctbl"), b"6 sp\xffleen 0 0 0 0\n").unwrap();
        assert!(refusal().contains("U+FFFD"), "{}", refusal());
        fs::remove_file(at("organs.ctbl")).unwrap();
        fs::create_dir(at("organs.label")).unwrap();
        assert!(refusal().contains("organs.label"), "{}", refusal());
    }
}
