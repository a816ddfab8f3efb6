//! What a data set that came says of itself, and whether it is whole: walked through from its first element to its last.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::uid::Uid;
use crate::dicom::syntax::{Coding, Syntax};
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::walk::{WalkError, Walker};

const BUFFER_BYTES: usize = 1 << 13;
/// Groups below hold commands and File Meta Information, and are in no data set.
const FIRST_GROUP: u16 = 0x0008;
/// Preamble, "DICM", and the element that says how long the File Meta Information behind it is.
const META_AT: u64 = 144;
/// Compared at once.
const PIECE: usize = 1 << 16;

/// Why a data set is not kept.
#[derive(Debug, thiserror::Error)]
pub(crate) enum InstanceError {
    #[error("its elements do not end where it ends: {0}")]
    Broken(String),
    #[error("it holds {0}, which is in no data set")]
    Group(Tag),
    #[error("it has no {0} that is a unique identifier")]
    Uid(Tag),
    #[error("it has no PixelData")]
    Pixels,
    #[error("it has {0} twice")]
    Twice(Tag),
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl From<WalkError> for InstanceError {
    fn from(error: WalkError) -> Self {
        match error {
            WalkError::File(error) => Self::Broken(error.to_string()),
            // What is coded as nothing that is known is told by the decoder like this.
            WalkError::Io(error) if error.kind() == std::io::ErrorKind::InvalidData => Self::Broken(error.to_string()),
            WalkError::Io(error) => Self::Io(error),
        }
    }
}

/// What a data set names itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Ids {
    pub class: Uid,
    pub instance: Uid,
    pub study: Uid,
    pub series: Uid,
    /// Whether it has PixelData.
    pub has_pixels: bool,
}

/// Walks through the data set that begins at `data_at` of a file of `length` bytes, which is read from its beginning.
///
/// # Errors
/// [`InstanceError`].
pub(crate) fn examine(file: impl Read + Seek, data_at: u64, length: u64, syntax: Syntax) -> Result<Ids, InstanceError> {
    const WANTED: [Tag; 4] = [el::SOP_CLASS, el::SOP_INSTANCE, el::STUDY, el::SERIES];
    let coding = syntax.elements;
    let mut walker = Walker::new(BufReader::with_capacity(BUFFER_BYTES, file), length);
    walker.seek(data_at)?;
    let (mut found, mut has_pixels): ([Option<Uid>; 4], bool) = Default::default();
    while walker.position() < length {
        let element = walker.element(coding)?;
        if element.tag.group < FIRST_GROUP {
            return Err(InstanceError::Group(element.tag));
        }
        has_pixels |= element.tag == el::PIXELS;
        let Some((tag, place)) = WANTED.iter().zip(&mut found).find(|(tag, _)| **tag == element.tag) else {
            walker.skip(&element, coding)?;
            continue;
        };
        if place.is_some() {
            return Err(InstanceError::Twice(*tag));
        }
        let value = walker.value(&element)?;
        *place = Some(Uid::checked(&value).ok_or(InstanceError::Uid(*tag))?);
    }
    let [class, instance, study, series] = found;
    Ok(Ids {
        class: class.ok_or(InstanceError::Uid(el::SOP_CLASS))?,
        instance: instance.ok_or(InstanceError::Uid(el::SOP_INSTANCE))?,
        study: study.ok_or(InstanceError::Uid(el::STUDY))?,
        series: series.ok_or(InstanceError::Uid(el::SERIES))?,
        has_pixels,
    })
}

/// Whether the file at `path` holds this data set in this coding, byte for byte. Its File Meta Information may have been written by
/// another version of this program.
///
/// # Errors
/// [`InstanceError`]: what is there cannot be read, or is no DICOM file.
pub(crate) fn is_same(path: &Path, new: &File, data_at: u64, syntax: &Uid) -> Result<bool, InstanceError> {
    let (old, about) = scene::file::open(path).map_err(std::io::Error::from)?;
    let mut walker = Walker::new(BufReader::with_capacity(BUFFER_BYTES, &old), about.len());
    walker.seek(META_AT - 12)?;
    let length = walker.element(Coding::ExplicitLittle)?;
    let value = walker.value(&length)?;
    let length = value
        .first_chunk()
        .map_or(0, |four| u64::from(u32::from_le_bytes(*four)));
    let old_at = META_AT + length;
    let mut is_same_coding = false;
    while walker.position() < old_at {
        let element = walker.element(Coding::ExplicitLittle)?;
        let value = walker.value(&element)?;
        is_same_coding |= element.tag == el::TRANSFER_SYNTAX && Uid::checked(&value).as_ref() == Some(syntax);
    }
    if !is_same_coding || new.metadata()?.len() - data_at != about.len().saturating_sub(old_at) {
        return Ok(false);
    }
    same_bytes([(&old, old_at), (new, data_at)])
}

fn same_bytes(files: [(&File, u64); 2]) -> Result<bool, InstanceError> {
    let mut readers = Vec::new();
    for (mut file, at) in files {
        file.seek(SeekFrom::Start(at))?;
        readers.push(file);
    }
    let mut pieces = [Vec::new(), Vec::new()];
    loop {
        for (reader, piece) in readers.iter_mut().zip(&mut pieces) {
            piece.clear();
            reader.take(PIECE as u64).read_to_end(piece)?;
        }
        match &pieces {
            [a, b] if a != b => return Ok(false),
            [a, _] if a.is_empty() => return Ok(true),
            _ => {}
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    /// A data set in implicit little endian, of elements with their values.
    pub(crate) fn implicit(elements: &[(u16, u16, &[u8])]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (group, element, value) in elements {
            bytes.extend(group.to_le_bytes());
            bytes.extend(element.to_le_bytes());
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(*value);
        }
        bytes
    }

    /// A small instance of CT with these UIDs.
    pub(crate) fn instance([instance, study, series]: [&str; 3], pixels: &[u8]) -> Vec<u8> {
        implicit(&[
            (0x0008, 0x0016, b"1.2.840.10008.5.1.4.1.1.2\0"),
            (0x0008, 0x0018, instance.as_bytes()),
            (0x0020, 0x000D, study.as_bytes()),
            (0x0020, 0x000E, series.as_bytes()),
            (0x7FE0, 0x0010, pixels),
        ])
    }

    fn examined(bytes: &[u8]) -> Result<Ids, InstanceError> {
        examine(Cursor::new(bytes), 0, bytes.len() as u64, Syntax::DEFAULT)
    }

    #[test]
    fn a_whole_data_set_names_itself_and_a_cut_one_is_refused() {
        let good = instance(["1.2.31", "1.2.10", "1.2.20"], &[1, 2, 3, 4]);
        let ids = examined(&good).unwrap();
        assert!(ids.has_pixels);
        assert_eq!(
            (ids.instance.as_str(), ids.study.as_str(), ids.series.as_str()),
            ("1.2.31", "1.2.10", "1.2.20")
        );
        for end in 0..good.len() {
            // Between two elements a data set may end, but then one of the four is missing, or the pixels are.
            let is_whole = examined(&good[..end]).is_ok_and(|ids| ids.has_pixels);
            assert!(!is_whole, "{end}");
        }
        let more = [&good[..], &[0; 3]].concat();
        assert!(matches!(examined(&more), Err(InstanceError::Broken(_))));
    }

    #[test]
    fn names_that_are_none_or_not_one_are_refused() {
        let said = |bytes: &[u8]| examined(bytes).unwrap_err().to_string();
        assert!(said(&instance(["../../x", "1.2", "1.3"], b"")).contains("SOPInstanceUID"));
        assert!(said(&instance(["1.2", "1.2/..", "1.3"], b"")).contains("StudyInstanceUID"));
        let twice = [
            instance(["1.2", "1.2", "1.3"], b""),
            implicit(&[(0x0020, 0x000E, b"1.4")]),
        ]
        .concat();
        assert!(said(&twice).contains("SeriesInstanceUID twice"), "{}", said(&twice));
        // What would be read as File Meta Information with another coding in it.
        let meta = [
            implicit(&[(0x0002, 0x0010, b"1.2")]),
            instance(["1.2", "1.2", "1.3"], b""),
        ]
        .concat();
        assert!(said(&meta).contains("(0002,0010)"), "{}", said(&meta));
    }

    proptest! {
        #[test]
        fn no_changed_byte_makes_it_panic(at in 0usize..180, byte in any::<u8>(), coding in 0usize..3) {
            let mut bytes = instance(["1.2.31", "1.2.10", "1.2.20"], &[1, 2, 3, 4]);
            let last = bytes.len() - 1;
            bytes[at.min(last)] = byte;
            let syntax = ["", ".1", ".2"].map(|rest| Syntax::of(&format!("1.2.840.10008.1.2{rest}")).unwrap())[coding];
            let _ = examine(Cursor::new(&bytes), 0, bytes.len() as u64, syntax);
        }
    }
}
