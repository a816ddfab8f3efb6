//! Which slices belong together, and choosing among several stacks of them.

mod apart;
pub(super) mod whole;

use std::fmt;
use std::path::{Path, PathBuf};

use geometry::Vector;

use self::whole::{Lack, Whole};
use super::error::DicomError;
use super::geometry::Stack;
use super::group::{MAX_SERIES, group};
use super::header::{Header, Placed, identity};
use super::scan::{self, LeftOut, Scanned};
use super::text::Label;
use super::words;

/// What a folder holds.
#[derive(Debug)]
pub struct Found {
    /// The series, in an order that depends on nothing but the files' headers, and of files with frames that name one object, on
    /// their paths.
    pub series: Vec<Series>,
    /// Files that are not DICOM images.
    pub ignored: usize,
    folder: PathBuf,
}

/// Slices of one series, one orientation and one size, and of files with several frames of one stack, one point in time and one
/// reconstruction; where they name no series, of one study, frame of reference, series number
/// and kernel.
#[derive(Debug, Clone)]
pub struct Series {
    pub(crate) folder: PathBuf,
    /// From 1, and how many there are.
    pub(crate) number: [usize; 2],
    pub(crate) ignored: usize,
    pub(crate) left_out: LeftOut,
    pub(crate) headers: Vec<Header>,
    /// Each slice names a frame of reference of its own.
    pub(crate) frames_merged: bool,
    /// Why these are not all slices of their volume.
    pub(crate) lack: Option<Lack>,
    /// What is doubtful about whether they are.
    pub(crate) doubts: Vec<String>,
}

/// A series in a list; nothing in it names a patient.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesSummary {
    /// Its number, from 1.
    pub number: usize,
    /// Modality, such as `CT`.
    pub modality: String,
    /// How many slices.
    pub slices: usize,
    /// Pixels in a row, and rows.
    pub size: [u16; 2],
    /// The plane in words, where slices have one.
    pub plane: Option<String>,
    /// The median step between slices, mm, where there is one.
    pub step_mm: Option<f64>,
    /// ConvolutionKernel.
    pub kernel: Option<String>,
    /// Of slices that are frames of one file: which of its stacks, points in time and reconstructions.
    pub part: Option<String>,
    /// Overview images to plan slices on.
    pub localizer: bool,
}

impl fmt::Display for SeriesSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [columns, rows] = self.size;
        write!(
            f,
            "  {}: {}, {} slices of {columns} x {rows}",
            self.number, self.modality, self.slices
        )?;
        match &self.plane {
            Some(plane) => write!(f, ", {plane}")?,
            None => write!(f, ", without position")?,
        }
        if self.localizer {
            write!(f, ", localizer")?;
        }
        if let Some(step) = self.step_mm {
            write!(f, ", step {step:.3} mm")?;
        }
        if let Some(kernel) = &self.kernel {
            write!(f, ", kernel {kernel}")?;
        }
        self.part.as_ref().map_or(Ok(()), |part| write!(f, ", {part}"))
    }
}

impl Series {
    /// Reads the headers of all DICOM images below `folder`, or of one file with several frames, and sorts them into series.
    ///
    /// # Errors
    /// [`DicomError`]: nothing there, too much there, or a broken file.
    pub fn scan(folder: &Path) -> Result<Found, DicomError> {
        Self::of(folder, scan::scan(folder)?)
    }

    /// The same of what was found at `folder`.
    ///
    /// # Errors
    /// [`DicomError::None`], [`DicomError::TooMuch`].
    pub(crate) fn of(folder: &Path, scanned: Scanned) -> Result<Found, DicomError> {
        let (path, ignored, left_out) = (folder.to_owned(), scanned.ignored, scanned.left_out);
        if scanned.headers.is_empty() {
            let left_out = left_out.told().map_or_else(String::new, |told| format!("; {told}"));
            return Err(DicomError::None {
                path,
                ignored,
                left_out,
            });
        }
        let mut whole = Whole::of(&scanned.headers);
        let groups = group(scanned.headers).ok_or(DicomError::TooMuch {
            path: folder.to_owned(),
            limit: MAX_SERIES,
            what: "series",
        })?;
        whole.grouped(&groups);
        let (count, apart) = (groups.len(), apart::told(&groups));
        let numbered = (1..)
            .zip(groups)
            .zip(apart)
            .map(|((number, (headers, frames_merged)), apart)| Self {
                folder: path.clone(),
                number: [number, count],
                ignored,
                left_out: left_out.clone(),
                lack: whole.lack(&headers),
                doubts: whole.warnings(&headers).into_iter().chain(apart).collect(),
                headers,
                frames_merged,
            });
        Ok(Found {
            series: numbered.collect(),
            ignored,
            folder: path.clone(),
        })
    }

    /// What a list says of it.
    pub fn summary(&self) -> SeriesSummary {
        let first = self.headers.first();
        let placed: Vec<Placed> = self.headers.iter().filter_map(|header| header.placed.ok()).collect();
        let normal = placed.first().map(|slice| {
            let [ax, ay, az, bx, by, bz] = slice.orientation;
            Vector::new(ax, ay, az).cross(Vector::new(bx, by, bz))
        });
        SeriesSummary {
            number: self.number[0],
            modality: first.map_or_else(String::new, |header| header.modality.clone()),
            slices: self.headers.len(),
            size: first.map_or([0; 2], |header| [header.columns, header.rows]),
            plane: normal.map(words::plane),
            step_mm: Stack::of(&placed).ok().map(|stack| stack.steps.median_mm),
            kernel: first.and_then(|header| header.kernel.as_ref()).map(Label::to_string),
            part: self.part(),
            localizer: self.is_localizer(),
        }
    }

    /// Which part of its file this is, in words; with a frame to find it by where another part may be told by the same words.
    fn part(&self) -> Option<String> {
        let frames = || self.headers.iter().filter_map(|header| header.frame.as_ref());
        let part = &frames().next()?.part;
        let first = frames().map(|frame| frame.number).min()?;
        Some(match part.is_hidden() {
            true => format!("{part}, the first of them is frame {first}"),
            false => part.to_string(),
        })
    }

    /// What the first file says of the patient, the visit and the place, by the elements' names: for who asks for it, and
    /// nowhere else.
    ///
    /// # Errors
    /// [`DicomError::File`], [`DicomError::Unreadable`].
    pub fn identity(&self) -> Result<Vec<(&'static str, String)>, DicomError> {
        self.headers
            .first()
            .map_or(Ok(Vec::new()), |header| identity::all(&header.path))
    }

    /// Whether the slices name no series.
    pub(crate) fn is_unnamed(&self) -> bool {
        self.headers.first().is_some_and(|header| header.series.is_none())
    }

    /// Whether these are overview images.
    pub(crate) fn is_localizer(&self) -> bool {
        self.headers.first().is_some_and(|header| header.localizer)
    }
}

impl Found {
    /// The series with this number, counted from 1; with no number, the only one.
    ///
    /// # Errors
    /// [`DicomError::Several`], [`DicomError::NoSuchSeries`].
    pub fn choose(mut self, number: Option<usize>) -> Result<Series, DicomError> {
        let (path, count) = (self.folder.clone(), self.series.len());
        match number {
            None if count == 1 => Ok(self.series.swap_remove(0)),
            None => Err(DicomError::Several {
                path,
                count,
                list: self.list(),
                hint: self.hint(),
            }),
            Some(asked) if (1..=count).contains(&asked) => Ok(self.series.swap_remove(asked - 1)),
            Some(asked) => Err(DicomError::NoSuchSeries {
                path,
                asked,
                count,
                list: self.list(),
            }),
        }
    }

    fn list(&self) -> String {
        let lines: Vec<String> = self.series.iter().map(|series| series.summary().to_string()).collect();
        lines.join("\n")
    }

    /// The only stack of CT slices, if there is just one; named, never taken.
    fn hint(&self) -> String {
        let volume = |summary: &SeriesSummary| {
            summary.modality == "CT" && !summary.localizer && summary.slices >= 2 && summary.plane.is_some()
        };
        let likely: Vec<SeriesSummary> = self.series.iter().map(Series::summary).filter(volume).collect();
        match likely.as_slice() {
            [one] => format!("\nthe only stack of CT slices among them is --series {}", one.number),
            _ => String::new(),
        }
    }
}
