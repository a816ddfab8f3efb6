//! The frames of an Enhanced CT as slices: each with the place, the numbers and the part of the file that it says it has.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::PathBuf;

use super::{Header, is_localizer, placed};
use crate::dicom::element::Elements;
use crate::dicom::element::groups::Group;
use crate::dicom::error::FileError;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::walk::Element;

/// One frame of a file.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// From 1.
    pub number: u32,
    /// How many the file has.
    pub of: u32,
    pub part: Part,
    /// InStackPositionNumber; compared with the place, never taken for it.
    pub in_stack: Option<u32>,
    pub concatenation: Option<Concatenation>,
    /// Whether its pixels do not lie where its place and its axes put them.
    pub distorted: bool,
    /// The headers of the extended table of offsets and of that of lengths.
    pub tables: [Option<Element>; 2],
}

/// What keeps frames of one series apart: those of one volume agree in all of it.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Part {
    /// The concatenation or the file; `None` where each file has one frame. Never shown.
    instance: Option<String>,
    stack: Option<String>,
    temporal: Option<u32>,
    /// Percentages of the heart's cycle and of the breath's, in hundredths.
    phases: [Option<i64>; 2],
    kind: Option<String>,
    algorithm: Option<String>,
    kernel: Option<String>,
    /// Where it is another than HU: a frame that does not say it is refused, and no part by itself.
    rescale_type: Option<String>,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frames")?;
        if let Some(stack) = &self.stack {
            write!(f, " of stack {stack}")?;
        }
        if let Some(temporal) = self.temporal {
            write!(f, ", temporal position {temporal}")?;
        }
        for (phase, what) in self.phases.iter().zip(["cardiac", "respiratory"]) {
            if let Some(phase) = phase {
                write!(f, ", {} % of the {what} cycle", *phase as f64 / 100.0)?;
            }
        }
        let words = [&self.kind, &self.algorithm, &self.rescale_type];
        words.into_iter().flatten().try_for_each(|word| write!(f, ", {word}"))
    }
}

/// A volume in several files (PS3.3, C.7.6.16.2.2.4).
#[derive(Debug, Clone)]
pub(crate) struct Concatenation {
    /// Never shown.
    uid: String,
    /// InConcatenationNumber, from 1.
    number: u32,
    total: Option<u32>,
}

impl Concatenation {
    fn of(e: &Elements) -> Result<Option<Self>, FileError> {
        let Some(uid) = e.text(el::CONCATENATION) else {
            return Ok(None);
        };
        let total = match e.get(el::IN_CONCATENATION_TOTAL) {
            None | Some([]) => None,
            Some(_) => Some(u32::from(e.u16(el::IN_CONCATENATION_TOTAL)?)),
        };
        let number = u32::from(e.u16(el::IN_CONCATENATION)?);
        Ok(Some(Self { uid, number, total }))
    }

    /// Its number, unless it is known to be the only one.
    pub(crate) fn one_of_several(&self) -> Option<u32> {
        (self.total != Some(1)).then_some(self.number)
    }
}

/// A part of a volume in several files that no file holds.
#[derive(Debug, Clone)]
pub(crate) struct Missing {
    /// A file of the volume.
    pub path: PathBuf,
    pub missing: u32,
    pub total: u32,
}

/// Of each concatenation that is not whole, by its UID.
pub(crate) fn missing_parts(headers: &[Header]) -> BTreeMap<String, Missing> {
    let mut found: BTreeMap<&str, (BTreeSet<u32>, u32, &PathBuf)> = BTreeMap::new();
    for header in headers {
        let Some(whole) = header.frame.as_ref().and_then(|frame| frame.concatenation.as_ref()) else {
            continue;
        };
        let (numbers, total, _) = found.entry(&whole.uid).or_insert((BTreeSet::new(), 0, &header.path));
        numbers.insert(whole.number);
        *total = whole.number.max(whole.total.unwrap_or(0)).max(*total);
    }
    let lack = |(uid, (numbers, total, path)): (&str, (BTreeSet<u32>, u32, &PathBuf))| {
        let missing = (1..=total).find(|number| !numbers.contains(number))?;
        let path = path.clone();
        Some((uid.to_owned(), Missing { path, missing, total }))
    };
    found.into_iter().filter_map(lack).collect()
}

/// What these slices, which are of one volume, lack.
pub(crate) fn missing_of(missing: &BTreeMap<String, Missing>, headers: &[Header]) -> Option<Missing> {
    let whole = headers.first()?.frame.as_ref()?.concatenation.as_ref()?;
    missing.get(&whole.uid).cloned()
}

/// The first frame without a place of each stack, point in time and reconstruction; localizers apart.
pub(crate) type Unplaced = BTreeMap<(Part, bool), (PathBuf, u32, Tag)>;

/// Of all frames. Without it a volume would lack a slice and nobody would be told.
pub(crate) fn unplaced(headers: &[Header]) -> Unplaced {
    let mut unplaced = Unplaced::new();
    for header in headers {
        if let (Some(frame), Err(tag)) = (&header.frame, header.placed) {
            let first = (header.path.clone(), frame.number, tag);
            unplaced.entry((frame.part.clone(), header.localizer)).or_insert(first);
        }
    }
    unplaced
}

/// Of the frames that belong together with these slices.
pub(crate) fn unplaced_of(unplaced: &Unplaced, headers: &[Header]) -> Option<(PathBuf, u32, Tag)> {
    let first = headers.first()?;
    let part = first.frame.as_ref()?.part.clone();
    unplaced.get(&(part, first.localizer)).cloned()
}

/// Where the numbers of the frames in their stack do not follow their places.
pub(crate) fn order_warning(headers: &[&Header]) -> Option<String> {
    let number = |header: &&Header| header.frame.as_ref().and_then(|frame| frame.in_stack);
    let numbers: Vec<u32> = headers.iter().filter_map(number).collect();
    let pairs = || numbers.iter().zip(numbers.iter().skip(1));
    if pairs().all(|(a, b)| a < b) || pairs().all(|(a, b)| a > b) {
        return None;
    }
    Some("InStackPositionNumber does not follow the frames' positions, which are taken".to_owned())
}

/// A header for each frame, after `file`, the header of the file.
///
/// # Errors
/// [`FileError::Items`] where there are not as many functional groups as frames; [`FileError::Value`] and
/// [`FileError::Missing`] of NumberOfFrames; [`FileError::Frame`]. A frame without a place is none yet: it is refused when it is
/// to be read.
pub(super) fn each(file: &Header, e: &Elements) -> Result<Vec<Header>, FileError> {
    let of = e.frame_count()?;
    let groups = e.frames.as_deref().unwrap_or_default();
    if groups.len() as u64 != u64::from(of) {
        return Err(FileError::Items {
            tag: el::FRAME_GROUPS,
            found: groups.len().to_string(),
            expected: format!("{of}: one for each frame"),
        });
    }
    let nothing = Group::default();
    let shared = e.shared.as_deref().and_then(<[Group]>::first).unwrap_or(&nothing);
    let concatenation = Concatenation::of(e)?;
    let instance = concatenation.as_ref().map(|whole| whole.uid.clone()).or_else(|| {
        // Slices of one series that lie in a file each belong together as classic ones do.
        let own = || {
            e.text(el::SOP_INSTANCE)
                .unwrap_or_else(|| file.path.display().to_string())
        };
        (of > 1).then(own)
    });
    let common = Frame {
        number: 0,
        of,
        part: Part {
            instance,
            ..Part::default()
        },
        in_stack: None,
        concatenation,
        distorted: false,
        tables: e.tables,
    };
    let frame = |(number, group): (u32, &Group)| {
        let one = Frame {
            number,
            ..common.clone()
        };
        one_frame(file, one, &group.or(shared)).map_err(|error| error.in_frame(Some(number)))
    };
    (1..).zip(groups).map(frame).collect()
}

/// One frame's header. What a functional group does not say is not there, whatever the file says outside of them.
fn one_frame(file: &Header, frame: Frame, group: &Group) -> Result<Header, FileError> {
    let content = group.content.clone().unwrap_or_default();
    let kind = group.kind.clone().unwrap_or_default();
    let measures = group.measures.clone().unwrap_or_default();
    let transformation = group.transformation.clone().unwrap_or_default();
    let made = group.reconstruction.clone().unwrap_or_default();
    let details = group.details.clone().unwrap_or_default();
    let converted = group.unassigned.clone().unwrap_or_default();
    let kernel = made.kernel.or(converted.kernel).or(file.kernel.clone());
    let localizer = file.localizer
        || kind
            .codes
            .as_deref()
            .is_some_and(|codes| is_localizer(&codes.replace('/', "\\")));
    let hundredths = |phase: Option<Option<f64>>| phase.flatten().map(|percent| (percent * 100.0).round() as i64);
    let part = Part {
        stack: content.stack,
        temporal: content.temporal,
        phases: [hundredths(group.cardiac), hundredths(group.respiratory)],
        kind: kind.codes,
        algorithm: made.algorithm,
        kernel: kernel.clone(),
        rescale_type: transformation.kind.clone().filter(|kind| kind != "HU"),
        ..frame.part
    };
    let (position, orientation) = (group.position.flatten(), group.orientation.flatten());
    Ok(Header {
        localizer,
        placed: placed(position, orientation, measures.spacing, localizer)?,
        slope: transformation.slope,
        intercept: transformation.intercept,
        rescale_type: transformation.kind,
        tilt_deg: details.tilt_deg.or(converted.tilt_deg),
        thickness_mm: measures.thickness_mm,
        spacing_between_mm: measures.spacing_between_mm,
        kernel,
        modality_lut: file.modality_lut || group.modality_lut,
        frame: Some(Frame {
            part,
            in_stack: content.in_stack,
            distorted: kind.volumetric.as_deref() == Some("DISTORTED"),
            ..frame
        }),
        ..file.clone()
    })
}
