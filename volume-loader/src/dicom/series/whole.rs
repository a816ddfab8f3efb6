//! What volumes that lie in frames lack: parts in other files, places, and what tells a frame from the others.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::dicom::error::{DicomError, FileError};
use crate::dicom::header::Header;
use crate::dicom::header::frames::{Concatenation, Frame};
use crate::dicom::header::part::{Instance, Part};
use crate::dicom::tag::Tag;

/// The study, the series and the file or concatenation, and whether these are localizers: what is said of a volume holds among these.
type Among = (String, Option<String>, Option<Instance>, bool);

/// Why a volume is not whole.
#[derive(Debug, Clone)]
pub(crate) enum Lack {
    /// A part that no file of the same series holds.
    Part { path: PathBuf, missing: u32, total: u32 },
    /// One part, and nothing says whether there are more.
    Alone { path: PathBuf, number: u32 },
    /// Two files of one part.
    Twice { paths: [PathBuf; 2], number: u32 },
    /// A frame that belongs to the volume and does not say what it must.
    Frame {
        path: PathBuf,
        frame: u32,
        source: FileError,
    },
}

impl From<Lack> for DicomError {
    fn from(lack: Lack) -> Self {
        match lack {
            Lack::Part { path, missing, total } => Self::Parts { path, missing, total },
            Lack::Alone { path, number } => Self::PartAlone { path, number },
            Lack::Twice {
                paths: [path, other],
                number,
            } => Self::PartTwice { path, other, number },
            Lack::Frame { path, frame, source } => Self::File {
                path,
                source: source.in_frame(Some(frame)),
            },
        }
    }
}

/// What is known of each volume in frames, from the frames of all of them: one that is listed apart for what it does not say would
/// else be missed by nobody.
#[derive(Debug, Default)]
pub(crate) struct Whole {
    lacks: BTreeMap<Among, Lack>,
    warnings: BTreeMap<Among, Vec<String>>,
}

impl Whole {
    pub(crate) fn of(headers: &[Header]) -> Self {
        let mut frames: BTreeMap<Among, Vec<(&Header, &Frame)>> = BTreeMap::new();
        for header in headers {
            if let (Some(among), Some(frame)) = (among(header), &header.frame) {
                frames.entry(among).or_default().push((header, frame));
            }
        }
        let mut whole = Self::default();
        for (among, frames) in frames {
            let (lack, mut warnings) = parts(&frames);
            if let Some(lack) = lack.or_else(|| silent(&frames)) {
                whole.lacks.insert(among.clone(), lack);
            }
            warnings.extend(unlike(&frames));
            whole.warnings.insert(among, warnings);
        }
        whole
    }

    /// Adds a warning where frames of one part of a file are in several of these groups, for another orientation, spacing, size or
    /// modality: a stack has one of each, and who chooses one group of it is without the rest.
    pub(crate) fn grouped(&mut self, groups: &[(Vec<Header>, bool)]) {
        let mut parts: BTreeMap<Among, BTreeMap<Part, Vec<usize>>> = BTreeMap::new();
        for (headers, _) in groups {
            let Some(first) = headers.first() else { continue };
            if let (Some(among), Some(frame)) = (among(first), &first.frame)
                && frame.part.instance.is_some()
            {
                let slices = parts.entry(among).or_default().entry(frame.part.clone()).or_default();
                slices.push(headers.len());
            }
        }
        for (among, parts) in parts {
            for (part, slices) in parts.into_iter().filter(|(_, slices)| slices.len() > 1) {
                let (count, all) = (slices.len(), slices.iter().sum::<usize>());
                let warning = format!(
                    "{all} {part} are {count} series, for another orientation, spacing or size: each lacks the slices of the others"
                );
                self.warnings.entry(among.clone()).or_default().push(warning);
            }
        }
    }

    /// What the volume of these slices lacks.
    pub(crate) fn lack(&self, headers: &[Header]) -> Option<Lack> {
        self.lacks.get(&among(headers.first()?)?).cloned()
    }

    /// What is doubtful about it.
    pub(crate) fn warnings(&self, headers: &[Header]) -> Vec<String> {
        let among = headers.first().and_then(among);
        let warnings = among.and_then(|among| self.warnings.get(&among).cloned());
        warnings.unwrap_or_default()
    }
}

/// `None` of a file without frames.
fn among(header: &Header) -> Option<Among> {
    let instance = header.frame.as_ref()?.part.instance.clone();
    Some((header.study.clone(), header.series.clone(), instance, header.localizer))
}

/// The parts of a concatenation: which of them is not there, and what is not known of it.
fn parts(frames: &[(&Header, &Frame)]) -> (Option<Lack>, Vec<String>) {
    let mut files: BTreeMap<u32, &PathBuf> = BTreeMap::new();
    let mut known: Option<u32> = None;
    for (header, frame) in frames {
        let Some(Concatenation { number, total, .. }) = frame.concatenation else {
            return (None, Vec::new());
        };
        known = known.max(total);
        let first = *files.entry(number).or_insert(&header.path);
        if *first != header.path {
            let paths = [first.clone(), header.path.clone()];
            return (Some(Lack::Twice { paths, number }), Vec::new());
        }
    }
    let Some((&last, &path)) = files.last_key_value() else {
        return (None, Vec::new());
    };
    let (path, total) = (path.clone(), known.unwrap_or(0).max(last));
    if let Some(missing) = (1..=total).find(|number| !files.contains_key(number)) {
        return (Some(Lack::Part { path, missing, total }), Vec::new());
    }
    match known {
        Some(_) => (None, Vec::new()),
        None if last == 1 => (Some(Lack::Alone { path, number: 1 }), Vec::new()),
        None => {
            let warning = format!(
                "{last} files are parts of one volume (a concatenation) and do not say how many there are: the last may be missing"
            );
            (None, vec![warning])
        }
    }
}

/// The first frame without a place, or without a stack or a point in time where others say theirs.
fn silent(frames: &[(&Header, &Frame)]) -> Option<Lack> {
    let lack = |(header, frame): &(&Header, &Frame), source: FileError| Lack::Frame {
        path: header.path.clone(),
        frame: frame.number,
        source,
    };
    let unplaced = |row: &(&Header, &Frame)| row.0.placed.err().map(|tag| lack(row, FileError::Missing { tag }));
    frames.iter().find_map(unplaced).or_else(|| {
        let (row, tag) = first_silent(frames, |frame| frame.part.places()).into_iter().next()?;
        let (found, expected) = (
            "absent".to_owned(),
            "there, as in other frames: it may be of the stack of any of these",
        );
        Some(lack(&row, FileError::Value { tag, found, expected }))
    })
}

/// Frames that do not say how they were made where others do: they are listed apart.
fn unlike(frames: &[(&Header, &Frame)]) -> Vec<String> {
    let rows = first_silent(frames, |frame| frame.part.makings());
    let told = rows.into_iter().map(|((header, frame), tag)| {
        let (path, number) = (header.path.display(), frame.number);
        format!("frame {number} of {path} has no {tag} and others have: it is in no volume of theirs")
    });
    told.collect()
}

/// Of each element that some frames have and some have not, the first that has not.
fn first_silent<'a, const N: usize>(
    frames: &[(&'a Header, &'a Frame)],
    said: impl Fn(&Frame) -> [(Tag, bool); N],
) -> Vec<((&'a Header, &'a Frame), Tag)> {
    let all: Vec<[(Tag, bool); N]> = frames.iter().map(|(_, frame)| said(frame)).collect();
    let lacking = |k: usize| {
        if !all.iter().any(|said| said[k].1) {
            return None;
        }
        let at = all.iter().position(|said| !said[k].1)?;
        Some((*frames.get(at)?, all[at][k].0))
    };
    (0..N).filter_map(lacking).collect()
}
