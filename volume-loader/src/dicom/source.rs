//! A DICOM series as an examination.

use std::collections::BTreeSet;
use std::path::Path;

use bus::message::Marks;
use geometry::VolumeGrid;

use super::alike;
use super::error::{DicomError, FileError};
use super::facts::SeriesFacts;
use super::fragments::offsets;
use super::geometry::{GeometryError, Stack};
use super::header::frames::Concatenation;
use super::header::person::Person;
use super::header::{Header, Kind, Placed, identity};
use super::padding::Padding;
use super::plan::{self, Take};
use super::report::{self, Laid};
use super::scan::{self, Scanned};
use super::series::Series;
use super::slice::Slice;
use crate::source::{Conversion, Facts, ReadError, Scratch, SliceReader, Turn, VoxelSource, Whose};

/// What may be done to a series that is no even stack.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Put uneven slices on an even grid by linear interpolation between neighbours; holes stay holes. Even ones stay as
    /// they are. Marks every image ([`Marks::REGRIDDED`]).
    pub regrid: bool,
}

/// One series, read slice by slice.
#[derive(Debug)]
pub struct DicomSource {
    folder: std::path::PathBuf,
    grid: VolumeGrid,
    /// In order along the stack.
    slices: Vec<Slice>,
    plan: Vec<Take>,
    padding: Padding,
    facts: SeriesFacts,
    turn: Turn,
    conversion: Conversion,
    scratch: Scratch,
}

/// The source for a folder and the number of one of its series, from 1; `None` where `path` is neither a folder nor a DICOM
/// file.
///
/// # Errors
/// [`DicomError`]; [`DicomError::OneFile`] for a file of one slice, [`DicomError::OnePart`] for one of several files.
pub(crate) fn open_path(
    path: &Path,
    series: Option<usize>,
    options: Options,
) -> Result<Option<DicomSource>, DicomError> {
    if path.is_dir() {
        let series = Series::scan(path)?.choose(series)?;
        return DicomSource::open(&series, options).map(Some);
    }
    if !may_be_dicom(path) {
        return Ok(None);
    }
    // A name alone makes no slice.
    let kind = scan::read(path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).to_owned();
    let is_object = matches!(kind, Kind::Object);
    let Some(headers) = frames(kind) else {
        let path = path.to_owned();
        if is_object {
            return Err(DicomError::NoSlices { path });
        }
        return Err(DicomError::OneFile { path, folder });
    };
    let concatenation = headers
        .first()
        .and_then(|first| first.frame.as_ref()?.concatenation.as_ref());
    if let Some(number) = concatenation.and_then(Concatenation::one_of_several) {
        let path = path.to_owned();
        return Err(DicomError::OnePart { path, number, folder });
    }
    let found = Scanned {
        headers,
        ..Scanned::default()
    };
    let series = Series::of(path, found)?.choose(series)?;
    DicomSource::open(&series, options).map(Some)
}

/// Whether a file is tried as DICOM. Old files have no preamble, and then the name must say it.
fn may_be_dicom(path: &Path) -> bool {
    path.is_file() && (scan::has_dicom_name(path) || Header::has_preamble(path))
}

/// The frames of a file that holds several slices.
fn frames(kind: Kind) -> Option<Vec<Header>> {
    match kind {
        Kind::Images(headers) => {
            let first = headers.first()?;
            (first.frame.is_some() && first.frames > 1).then_some(headers)
        }
        Kind::Object | Kind::Other => None,
    }
}

/// Whether series of slices may be at `path`: a folder, or one file with several frames.
pub(crate) fn holds_series(path: &Path) -> bool {
    path.is_dir() || may_be_dicom(path) && Header::read(path).is_ok_and(|kind| frames(kind).is_some())
}

/// Whether the file begins like DICOM.
pub(crate) fn has_preamble(path: &Path) -> bool {
    path.is_file() && Header::has_preamble(path)
}

/// What says of which patient and where in her a series is; never shown.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Reference {
    /// FrameOfReferenceUID; several where each slice names another one ([`Series::frames_merged`]), and none where none is named.
    pub frames: BTreeSet<String>,
    pub person: Person,
    /// StudyInstanceUID.
    pub study: Option<String>,
    /// SeriesInstanceUID.
    pub series: Option<String>,
}

/// That of one series; of what is no DICOM there is none.
///
/// # Errors
/// [`DicomError`].
pub(crate) fn reference(path: &Path, series: Option<usize>) -> Result<Reference, DicomError> {
    if !holds_series(path) {
        return Ok(Reference::default());
    }
    let series = Series::scan(path)?.choose(series)?;
    // Slices of several frames of reference are no examination.
    alike::check(&series)?;
    let first = series.headers.first();
    let frames = series.headers.iter().map(|header| header.frame_of_reference.clone());
    Ok(Reference {
        frames: frames.filter(|frame| !frame.is_empty()).collect(),
        person: Person::of_series(&series.headers)?,
        study: first
            .map(|header| header.study.clone())
            .filter(|study| !study.is_empty()),
        series: first.and_then(|header| header.series.clone()),
    })
}

impl DicomSource {
    /// Judges a series: every slice's pixels, their places, the grid. One slice is read, for its padding.
    ///
    /// # Errors
    /// [`DicomError`].
    pub fn open(series: &Series, options: Options) -> Result<Self, DicomError> {
        let (path, number) = (series.folder.clone(), series.number[0]);
        let refused = |source| DicomError::Geometry {
            path: path.clone(),
            number,
            source,
            two: None,
        };
        if series.is_localizer() {
            return Err(refused(GeometryError::Localizer));
        }
        if let Some(lack) = series.lack.clone() {
            return Err(lack.into());
        }
        alike::check(series)?;
        each(&series.headers, alike::sides::check)?;
        let mut slices = each(&series.headers, Slice::of)?;
        offsets::locate(&series.headers, &mut slices)?;
        let placed: Vec<Placed> = each(&series.headers, |header| {
            header.placed.map_err(|tag| FileError::Missing { tag })
        })?;
        let stack = Stack::of(&placed).map_err(|source| match source {
            GeometryError::Duplicates { .. } => DicomError::Geometry {
                path: path.clone(),
                number,
                source,
                two: at_one_place(&series.headers, &placed),
            },
            _ => refused(source),
        })?;
        let laid = Laid::of(&stack, &slices, options).map_err(|error| match error {
            LayError::Geometry(source) => refused(source),
            LayError::Grid(source) => DicomError::Grid {
                path: path.clone(),
                number,
                source,
            },
        })?;
        let headers: Vec<&Header> = stack.order.iter().filter_map(|&i| series.headers.get(i)).collect();
        let slices: Vec<Slice> = stack.order.iter().filter_map(|&i| slices.get(i).cloned()).collect();
        let (padding, facts) = report::of(series, &headers, &slices, &stack, &laid)?;
        Ok(Self {
            folder: path.clone(),
            grid: laid.grid,
            slices,
            plan: laid.plan,
            padding,
            facts,
            turn: Turn::default(),
            conversion: Conversion::default(),
            scratch: Scratch::default(),
        })
    }

    /// What was found out about the series.
    pub fn series_facts(&self) -> &SeriesFacts {
        &self.facts
    }

    fn read_measured(&self, slice: usize, out: &mut [i16], bytes: &mut Vec<u8>) -> Result<Conversion, ReadError> {
        let slice = self.slices.get(slice).ok_or(ReadError::Order {
            expected: 0,
            found: slice as u32,
            count: self.slices.len() as u32,
        })?;
        Ok(slice.read(out, bytes)?)
    }

    /// Between slices `below` and the next, which has this weight; what was not measured in either stays so.
    fn read_between(
        &self,
        below: usize,
        weight: f64,
        out: &mut [i16],
        bytes: &mut Vec<u8>,
    ) -> Result<Conversion, ReadError> {
        let mut above = vec![0; out.len()];
        let mut conversion = self.read_measured(below, out, bytes)?;
        conversion += self.read_measured(below + 1, &mut above, bytes)?;
        let padding = self.padding.known.then_some(self.padding.hu);
        for (low, high) in out.iter_mut().zip(above) {
            *low = match padding {
                Some(hu) if *low == hu || high == hu => hu,
                // Between two numbers of 16 bits.
                _ => (f64::from(*low) + weight * (f64::from(high) - f64::from(*low))).round() as i16,
            };
        }
        Ok(conversion)
    }
}

/// Something of each header, or the name of the first file, and the number of its frame, for which there is none.
fn each<T>(headers: &[Header], of: impl Fn(&Header) -> Result<T, FileError>) -> Result<Vec<T>, DicomError> {
    let named = |header: &Header| {
        of(header).map_err(|source| DicomError::File {
            path: header.path.clone(),
            source: source.in_frame(header.frame_number()),
        })
    };
    headers.iter().map(named).collect()
}

/// Pairs of more slices than this are not looked through for the two that are told.
const MOST_COMPARED: usize = 5000;

/// The files of the two slices that are nearest to one another: a file that was copied, or another point in time.
fn at_one_place(headers: &[Header], placed: &[Placed]) -> Option<Box<[std::path::PathBuf; 2]>> {
    let mut slices: Vec<(&Header, &Placed)> = headers.iter().zip(placed).take(MOST_COMPARED).collect();
    slices.sort_by(|a, b| a.0.path.cmp(&b.0.path));
    let apart = |a: &Placed, b: &Placed| -> f64 {
        let axes = a.position.iter().zip(&b.position);
        axes.map(|(a, b)| (a - b).powi(2)).sum()
    };
    // Each with each: in an order along any axis rounding may put others between the two.
    let pairs = slices
        .iter()
        .enumerate()
        .flat_map(|(i, one)| slices[i + 1..].iter().map(move |other| (one, other)));
    let (one, other) = pairs.min_by(|a, b| apart(a.0.1, a.1.1).total_cmp(&apart(b.0.1, b.1.1)))?;
    Some(Box::new([one.0.path.clone(), other.0.path.clone()]))
}

enum LayError {
    Geometry(GeometryError),
    Grid(geometry::GridError),
}

impl Laid {
    fn of(stack: &Stack, slices: &[Slice], options: Options) -> Result<Self, LayError> {
        let size = slices.first().map_or([0; 2], |slice| [slice.columns, slice.rows]);
        let count = stack.along_mm.len();
        let (step, planes, worst_corner_mm, regridded) = match stack.even(size) {
            Ok(worst) => (stack.even_step_mm(), count as i64, worst, false),
            Err(GeometryError::Uneven { .. } | GeometryError::Corner { .. }) if options.regrid => {
                let step = stack.steps.median_mm;
                let worst = stack.askew(size).map_err(LayError::Geometry)?;
                (step, plan::even_count(&stack.along_mm, step), worst, true)
            }
            Err(error) => return Err(LayError::Geometry(error)),
        };
        let [columns, rows] = size.map(i64::from);
        let grid = VolumeGrid::checked([columns, rows, planes], stack.ct_from_voxel(step)).map_err(LayError::Grid)?;
        let plan = match regridded {
            true => plan::even_grid(&stack.along_mm, step, grid.dims()[2]),
            false => (0..count).map(Take::Whole).collect(),
        };
        Ok(Self {
            grid,
            plan,
            worst_corner_mm,
            regridded,
        })
    }
}

impl VoxelSource for DicomSource {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn padding_hu(&self) -> i16 {
        self.padding.hu
    }

    fn describe(&self) -> String {
        format!("{}: {}", self.folder.display(), self.facts)
    }

    fn marks(&self) -> Marks {
        match self.facts.regridded {
            Some(_) => Marks::REGRIDDED,
            None => Marks::NONE,
        }
    }

    fn facts(&self) -> Facts {
        self.facts.told()
    }

    /// Of the first slice: all of them have one patient's number.
    fn whose(&self) -> Result<Whose, ReadError> {
        let first = self.slices.first();
        Ok(first.map_or(Ok(Whose::default()), |slice| identity::whose(&slice.path))?)
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.grid, k, out)?;
        let mut scratch = std::mem::take(&mut self.scratch);
        let read = self.read(k, out, &mut scratch);
        self.scratch = scratch;
        self.conversion += read?;
        Ok(())
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.grid)?;
        Ok(self.conversion)
    }

    fn slices(&self) -> Option<&dyn SliceReader> {
        Some(self)
    }
}

impl SliceReader for DicomSource {
    fn read(&self, k: u32, out: &mut [i16], scratch: &mut Scratch) -> Result<Conversion, ReadError> {
        let [columns, rows, count] = self.grid.dims();
        let expected = u64::from(columns) * u64::from(rows);
        if out.len() as u64 != expected {
            let found = out.len();
            return Err(ReadError::Buffer {
                slice: k,
                expected,
                found,
            });
        }
        match self.plan.get(k as usize) {
            Some(&Take::Whole(slice)) => self.read_measured(slice, out, &mut scratch.bytes),
            Some(&Take::Between(below, weight)) => self.read_between(below, weight, out, &mut scratch.bytes),
            Some(Take::Hole) => {
                out.fill(self.padding.hu);
                Ok(Conversion::default())
            }
            None => Err(ReadError::Order {
                expected: 0,
                found: k,
                count,
            }),
        }
    }
}
