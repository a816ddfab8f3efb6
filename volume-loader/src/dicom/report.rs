//! What a person is told of a series: its facts, and what was doubtful.

use std::fmt;

use geometry::VolumeGrid;

use super::alike::{order, sides, told};
use super::error::DicomError;
use super::facts::SeriesFacts;
use super::geometry::Stack;
use super::header::Header;
use super::padding::Padding;
use super::plan::Take;
use super::series::Series;
use super::slice::{self, Slice};
use super::text::Label;
use super::words;

/// Slices laid on a grid.
#[derive(Debug)]
pub(crate) struct Laid {
    pub grid: VolumeGrid,
    pub plan: Vec<Take>,
    pub worst_corner_mm: f64,
    /// Whether slices had to be put on an even grid.
    pub regridded: bool,
}

/// The tilt by the tag and by the positions may differ by this, degrees.
const TILT_DEG: f64 = 0.5;
/// A slice distance that a header states may differ from the positions' by this part.
const STEP_PART: f64 = 0.01;

/// The padding and the facts of a series whose slices, with their headers, are in order along the stack.
///
/// # Errors
/// [`DicomError`] of the slice in the middle.
pub(crate) fn of(
    series: &Series,
    headers: &[&Header],
    slices: &[Slice],
    stack: &Stack,
    laid: &Laid,
) -> Result<(Padding, SeriesFacts), DicomError> {
    let mut warnings = warnings(series, headers, stack);
    let padding = padding(headers, slices, &mut warnings)?;
    if is_lossy(headers, slices)? {
        warnings.push("the slices were compressed with loss: HU are not the scanner's".to_owned());
    }
    let [right, down] = stack.pixel;
    let ct_from_voxel = laid.grid.ct_from_voxel();
    let count = |kind: fn(&Take) -> bool| laid.plan.iter().filter(|take| kind(take)).count();
    let between = count(|take| matches!(take, Take::Between(..)));
    let holes = count(|take| matches!(take, Take::Hole));
    let first = headers.first();
    let facts = SeriesFacts {
        number: series.number,
        modality: first.map_or_else(String::new, |header| header.modality.clone()),
        dims: laid.grid.dims(),
        ct_from_voxel,
        orientation: words::orientation(stack.normal, [right, down, stack.line]),
        tilt_deg: stack.tilt_deg(),
        tilt_tag_deg: first.and_then(|header| header.tilt_deg),
        steps: stack.steps,
        worst_corner_mm: laid.worst_corner_mm,
        positions_mm: stack.positions(),
        codec: codec(headers),
        kernel: first.and_then(|header| header.kernel.as_ref()).map(Label::to_string),
        thickness_mm: first.and_then(|header| header.thickness_mm),
        padding_hu: padding.hu,
        padding_known: padding.known,
        regridded: laid.regridded.then_some([between, holes]),
        warnings,
        ignored: series.ignored,
    };
    Ok((padding, facts))
}

fn codec(headers: &[&Header]) -> &'static str {
    let name = headers.first().map_or("", |header| header.syntax.name);
    match headers.iter().all(|header| header.syntax.name == name) {
        true => name,
        false => "several transfer syntaxes",
    }
}

fn padding(headers: &[&Header], slices: &[Slice], warnings: &mut Vec<String>) -> Result<Padding, DicomError> {
    let declared = Padding::declared(headers, slices, warnings);
    let Some(middle) = slices.get(slices.len() / 2) else {
        return Ok(declared.unwrap_or_else(|| Padding::of_corners(&[], 0)));
    };
    let mut voxels = vec![0; middle.pixels()];
    let conversion = middle.read(&mut voxels, &mut Vec::new())?;
    middle.check_hu(conversion)?;
    Ok(declared.unwrap_or_else(|| Padding::of_corners(&voxels, usize::from(middle.columns))))
}

fn is_lossy(headers: &[&Header], slices: &[Slice]) -> Result<bool, DicomError> {
    if headers.iter().any(|header| header.lossy) {
        return Ok(true);
    }
    let middle = slices.get(slices.len() / 2);
    middle.map_or(Ok(false), |slice| slice.is_lossy(&mut Vec::new()))
}

fn named(header: &Header) -> &str {
    header.kernel.as_ref().map_or("not named", Label::shown)
}

/// Where the numbers of a CT may be other than the HU of what lies at each place.
fn not_plain_hu(headers: &[&Header]) -> Vec<String> {
    let kinds = || headers.iter().filter_map(|header| header.rescale_type.as_ref());
    let other = kinds().map(Label::shown).find(|kind| *kind != "HU");
    let mut warnings: Vec<String> = other
        .map(|kind| format!("RescaleType is {kind}, not HU"))
        .into_iter()
        .collect();
    // Frames must say it; classic slices of a CT are HU where they do not (PS3.3, C.11.1.1.2).
    if headers
        .iter()
        .any(|header| header.frame.is_some() && header.rescale_type.is_none())
    {
        warnings.push("RescaleType is not there: the numbers are taken as HU".to_owned());
    }
    let contrasts = headers.iter().filter_map(|header| header.contrast.as_deref());
    if let Some(kind) = contrasts.into_iter().find(|kind| slice::DERIVED.contains(kind)) {
        warnings.push(format!(
            "the fourth value of the image's type is {kind}: its numbers were made of others, and are not the HU measured at each place"
        ));
    }
    warnings
}

/// Where the numbers of the frames in their stack do not follow their places.
fn order_warning(headers: &[&Header]) -> Option<String> {
    let number = |header: &&Header| header.frame.as_ref().and_then(|frame| frame.in_stack);
    let numbers: Vec<u32> = headers.iter().filter_map(number).collect();
    let pairs = || numbers.iter().zip(numbers.iter().skip(1));
    if pairs().all(|(a, b)| a < b) || pairs().all(|(a, b)| a > b) {
        return None;
    }
    Some("InStackPositionNumber does not follow the frames' positions, which are taken".to_owned())
}

/// Where the numbers of the frames in their stack are not those from 1 on: what is missing at an end is seen by no gap.
fn numbers_warning(headers: &[&Header]) -> Option<String> {
    let numbers = || headers.iter().filter_map(|header| header.frame.as_ref()?.in_stack);
    let (first, last) = (numbers().min()?, numbers().max()?);
    let count = headers.len();
    if first == 1 && last as usize == count {
        return None;
    }
    Some(format!(
        "InStackPositionNumber is from {first} to {last} in {count} slices: slices of the stack may be missing"
    ))
}

/// What is doubtful about headers and places.
fn warnings(series: &Series, headers: &[&Header], stack: &Stack) -> Vec<String> {
    let Some(first) = headers.first() else {
        return Vec::new();
    };
    let mut warnings: Vec<String> = series.left_out.told().into_iter().collect();
    if first.modality != "CT" {
        warnings.push(format!("not a CT ({}): its numbers are not HU", first.modality));
    } else {
        warnings.extend(not_plain_hu(headers));
    }
    warnings.extend(series.doubts.iter().cloned());
    warnings.extend(told::differences(headers));
    warnings.extend(order::told(headers));
    warnings.extend(sides::not_compared(headers));
    // Frames are told apart by it; classic slices of one series are not.
    if let Some(other) = headers.iter().find(|header| header.kernel != first.kernel) {
        warnings.push(format!(
            "the slices were not reconstructed alike: the kernel is {} in {} and {} in {}",
            named(first),
            first.path.display(),
            named(other),
            other.path.display()
        ));
    }
    if series.is_unnamed() {
        warnings.push(
            "the slices have no SeriesInstanceUID: they were put together by study, frame of reference, orientation and size"
                .to_owned(),
        );
    }
    if series.frames_merged {
        warnings.push(format!(
            "each of the {} slices names a frame of reference of its own, where a series has one: they were not kept apart",
            headers.len()
        ));
    }
    if let Some(error) = stack.straightened {
        warnings.push(format!(
            "ImageOrientationPatient was off by {error:.1e} and was made exact"
        ));
    }
    warnings.extend(order_warning(headers).or_else(|| numbers_warning(headers)));
    let tilt = stack.tilt_deg();
    if let Some(tag) = first.tilt_deg.filter(|tag| (tag.abs() - tilt).abs() > TILT_DEG) {
        warnings.push(format!(
            "GantryDetectorTilt says {tag:.2} degrees, the positions {tilt:.2}, which are taken"
        ));
    }
    let step = stack.steps.median_mm;
    if let Some(tag) = first
        .spacing_between_mm
        .filter(|tag| (tag.abs() - step).abs() > STEP_PART * step)
    {
        warnings.push(format!(
            "SpacingBetweenSlices says {tag:.4} mm, the positions {step:.4} mm, which are taken"
        ));
    }
    warnings
}

impl fmt::Display for SeriesFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([number, count], [nx, ny, nz]) = (self.number, self.dims);
        let [sx, sy, sz] = [0, 1, 2].map(|axis| self.ct_from_voxel.step(axis).norm());
        write!(
            f,
            "DICOM {}, series {number} of {count}, {}, ",
            self.modality, self.codec
        )?;
        write!(
            f,
            "{nx} x {ny} x {nz} voxels of {sx:.3} x {sy:.3} x {sz:.3} mm; {}, ",
            self.orientation
        )?;
        write!(
            f,
            "tilt {:.2} degrees, corners within {:.4} mm",
            self.tilt_deg, self.worst_corner_mm
        )?;
        if let Some([between, holes]) = self.regridded {
            write!(
                f,
                "; put on an even grid: {between} slices interpolated, {holes} a hole without measurement"
            )?;
        }
        self.warnings
            .iter()
            .try_for_each(|warning| write!(f, "; warning: {warning}"))
    }
}
