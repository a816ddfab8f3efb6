//! Functional groups: what the frames of one file share, and what each says of itself (DICOM PS3.3, C.7.6.16).

use std::io::{BufRead, Seek};

use super::Elements;
use crate::dicom::error::FileError;
use crate::dicom::syntax::{Coding, Syntax};
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::Label;
use crate::dicom::walk::{Element, Open, WalkError, Walker};

/// More frames than any scanner writes into one file: 20 times of 320 slices are 6400.
pub(crate) const MAX_FRAMES: u32 = 16384;
/// The same in words.
pub(crate) const FRAMES_ALLOWED: &str = "a whole number from 1 to 16384";

/// One item of functional groups. `None` where a group is absent; a group that is there holds each value that it says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group {
    pub position: Option<Option<[f64; 3]>>,
    pub orientation: Option<Option<[f64; 6]>>,
    pub measures: Option<Measures>,
    pub transformation: Option<Transformation>,
    pub content: Option<Content>,
    pub kind: Option<FrameKind>,
    pub reconstruction: Option<Reconstruction>,
    pub details: Option<Reconstruction>,
    /// What the converter of a classic series found no place for.
    pub unassigned: Option<Reconstruction>,
    pub cardiac: Option<Cardiac>,
    /// Nominal percentage of the breath's cycle.
    pub respiratory: Option<Option<f32>>,
    pub modality_lut: bool,
}

/// Nominal places in the heart's cycle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cardiac {
    pub percent: Option<f32>,
    pub delay_ms: Option<f64>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Measures {
    /// Between rows and between columns, mm.
    pub spacing: Option<[f64; 2]>,
    pub thickness_mm: Option<f64>,
    pub spacing_between_mm: Option<f64>,
}

/// From stored numbers to HU.
#[derive(Debug, Clone, Default)]
pub(crate) struct Transformation {
    pub slope: Option<f64>,
    pub intercept: Option<f64>,
    pub kind: Option<Label>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Content {
    pub stack: Option<Label>,
    pub in_stack: Option<u32>,
    pub temporal: Option<u32>,
    /// FrameAcquisitionNumber; only told.
    pub acquisition: Option<u16>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct FrameKind {
    /// FrameType.
    pub label: Option<Label>,
    /// Its fourth value.
    pub contrast: Option<String>,
    pub localizer: bool,
    pub volumetric: Option<String>,
    /// VolumeBasedCalculationTechnique.
    pub technique: Option<String>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Reconstruction {
    pub algorithm: Option<Label>,
    pub kernel: Option<Label>,
    pub tilt_deg: Option<f64>,
}

impl Reconstruction {
    fn of(e: &Elements) -> Self {
        Self {
            algorithm: e.label(el::ALGORITHM),
            kernel: e.label(el::KERNEL),
            tilt_deg: e.reported(el::GANTRY_TILT),
        }
    }

    /// These values, and those of `other` where one is not there.
    fn or(self, other: Self) -> Self {
        Self {
            algorithm: self.algorithm.or(other.algorithm),
            kernel: self.kernel.or(other.kernel),
            tilt_deg: self.tilt_deg.or(other.tilt_deg),
        }
    }
}

impl Group {
    /// This group, and where it is silent the one that all frames share. A functional group is taken whole: never one value of
    /// the frame's and another of the shared one. The unassigned attributes alone are two sequences, and what stands in one of
    /// them does not stand in the other.
    pub(crate) fn or(&self, shared: &Self) -> Self {
        fn first<T: Clone>(own: &Option<T>, shared: &Option<T>) -> Option<T> {
            own.as_ref().or(shared.as_ref()).cloned()
        }
        Self {
            position: first(&self.position, &shared.position),
            orientation: first(&self.orientation, &shared.orientation),
            measures: first(&self.measures, &shared.measures),
            transformation: first(&self.transformation, &shared.transformation),
            content: first(&self.content, &shared.content),
            kind: first(&self.kind, &shared.kind),
            reconstruction: first(&self.reconstruction, &shared.reconstruction),
            details: first(&self.details, &shared.details),
            unassigned: match (self.unassigned.clone(), shared.unassigned.clone()) {
                (Some(own), Some(shared)) => Some(own.or(shared)),
                (own, shared) => own.or(shared),
            },
            cardiac: first(&self.cardiac, &shared.cardiac),
            respiratory: first(&self.respiratory, &shared.respiratory),
            modality_lut: self.modality_lut || shared.modality_lut,
        }
    }

    /// Takes the values of one functional group.
    fn take(&mut self, e: &Elements, sequence: Tag) -> Result<(), FileError> {
        self.modality_lut |= e.modality_lut;
        match sequence {
            el::PLANE_POSITION => self.position = Some(e.numbers(el::POSITION)?),
            el::PLANE_ORIENTATION => self.orientation = Some(e.numbers(el::ORIENTATION)?),
            el::PIXEL_MEASURES => {
                self.measures = Some(Measures {
                    spacing: e.numbers(el::PIXEL_SPACING)?,
                    thickness_mm: e.reported(el::SLICE_THICKNESS),
                    spacing_between_mm: e.reported(el::SPACING_BETWEEN_SLICES),
                });
            }
            el::TRANSFORMATION => {
                self.transformation = Some(Transformation {
                    slope: e.number(el::SLOPE)?,
                    intercept: e.number(el::INTERCEPT)?,
                    kind: e.label(el::RESCALE_TYPE),
                });
            }
            el::FRAME_CONTENT => {
                self.content = Some(Content {
                    stack: e.label(el::STACK),
                    in_stack: e.u32(el::IN_STACK)?,
                    temporal: e.u32(el::TEMPORAL)?,
                    acquisition: e.u16(el::FRAME_ACQUISITION).ok(),
                });
            }
            el::CT_FRAME_TYPE => {
                self.kind = Some(FrameKind {
                    label: e.label(el::FRAME_TYPE),
                    contrast: e.contrast(el::FRAME_TYPE),
                    localizer: e.is_localizer(el::FRAME_TYPE),
                    volumetric: e.code(el::VOLUMETRIC),
                    technique: e.code(el::TECHNIQUE),
                });
            }
            el::RECONSTRUCTION => self.reconstruction = Some(Reconstruction::of(e)),
            el::ACQUISITION_DETAILS => self.details = Some(Reconstruction::of(e)),
            el::SHARED_UNASSIGNED | el::FRAME_UNASSIGNED => {
                let before = self.unassigned.take().unwrap_or_default();
                self.unassigned = Some(Reconstruction::of(e).or(before));
            }
            el::CARDIAC => {
                self.cardiac = Some(Cardiac {
                    percent: e.f32(el::CARDIAC_PHASE)?,
                    delay_ms: e.f64(el::CARDIAC_DELAY)?,
                });
            }
            el::RESPIRATORY => self.respiratory = Some(e.f32(el::RESPIRATORY_PHASE)?),
            _ => {}
        }
        Ok(())
    }
}

/// The functional groups that are read.
const READ: [Tag; 12] = [
    el::PLANE_POSITION,
    el::PLANE_ORIENTATION,
    el::PIXEL_MEASURES,
    el::TRANSFORMATION,
    el::FRAME_CONTENT,
    el::CT_FRAME_TYPE,
    el::RECONSTRUCTION,
    el::ACQUISITION_DETAILS,
    el::SHARED_UNASSIGNED,
    el::FRAME_UNASSIGNED,
    el::CARDIAC,
    el::RESPIRATORY,
];

/// The items of the sequence `element`, whose header was just read: `most` at most.
///
/// # Errors
/// [`FileError::Items`] where there are more; [`FileError::Frame`] for what is wrong with one of several; [`WalkError::Io`].
pub(super) fn read<R: BufRead + Seek>(
    walker: &mut Walker<R>,
    element: &Element,
    coding: Coding,
    most: u32,
) -> Result<Vec<Group>, WalkError> {
    let sequence = walker.open(element, coding)?;
    let mut groups = Vec::new();
    while let Some(item) = walker.next_item(&sequence)? {
        if groups.len() as u64 == u64::from(most) {
            let expected = match element.tag == el::SHARED_GROUPS {
                true => "one: what all frames share".to_owned(),
                false => format!("{most}: one for each frame"),
            };
            let found = match most {
                1 => "more than one item".to_owned(),
                _ => format!("more than {most} items"),
            };
            return Err(items(element.tag, found, expected).into());
        }
        let number = (element.tag == el::FRAME_GROUPS).then_some(groups.len() as u32 + 1);
        // A sound file may have a million elements in its frames, and not in one of them.
        let group = walker.counted_apart(|walker| group(walker, &item));
        let group = group.map_err(|error| match error {
            WalkError::File(error) => WalkError::File(error.in_frame(number)),
            io @ WalkError::Io(_) => io,
        })?;
        groups.push(group);
    }
    Ok(groups)
}

fn items(tag: Tag, found: String, expected: String) -> FileError {
    FileError::Items { tag, found, expected }
}

fn group<R: BufRead + Seek>(walker: &mut Walker<R>, item: &Open) -> Result<Group, WalkError> {
    let mut group = Group::default();
    let mut seen = Vec::new();
    while let Some(element) = walker.next_in(item)? {
        let (tag, byte) = (element.tag, element.byte);
        group.modality_lut |= tag == el::MODALITY_LUT && walker.has_items(&element, item.coding)?;
        if !READ.contains(&tag) {
            walker.skip(&element, item.coding)?;
            continue;
        }
        if seen.contains(&tag) {
            return Err(FileError::Twice { tag, byte }.into());
        }
        seen.push(tag);
        let values = only_item(walker, &element, item.coding)?;
        group.take(&values, tag)?;
    }
    Ok(group)
}

/// The values of a functional group's item; none where there is no item. A multi-energy CT has an item of acquisition details for
/// each beam: of these only the gantry's tilt is read, which is compared with the places and decides nothing, so that the first will
/// do. Several items of any other group would be several places, or several slopes.
fn only_item<R: BufRead + Seek>(
    walker: &mut Walker<R>,
    element: &Element,
    coding: Coding,
) -> Result<Elements, WalkError> {
    let sequence = walker.open(element, coding)?;
    let mut values = None;
    while let Some(item) = walker.next_item(&sequence)? {
        if values.is_some() && element.tag != el::ACQUISITION_DETAILS {
            let (found, expected) = ("more than one item".to_owned(), "one".to_owned());
            return Err(items(element.tag, found, expected).into());
        }
        let item = item_values(walker, &item)?;
        values.get_or_insert(item);
    }
    Ok(values.unwrap_or_default())
}

fn item_values<R: BufRead + Seek>(walker: &mut Walker<R>, item: &Open) -> Result<Elements, WalkError> {
    let mut elements = Elements {
        syntax: Syntax {
            elements: item.coding,
            ..Syntax::DEFAULT
        },
        ..Elements::default()
    };
    while let Some(element) = walker.next_in(item)? {
        let (tag, byte) = (element.tag, element.byte);
        elements.modality_lut |= tag == el::MODALITY_LUT && walker.has_items(&element, item.coding)?;
        if !el::GROUPED.contains(&tag) {
            walker.skip(&element, item.coding)?;
            continue;
        }
        if elements.get(tag).is_some() {
            return Err(FileError::Twice { tag, byte }.into());
        }
        let value = walker.value(&element)?;
        elements.values.push((tag, value));
    }
    Ok(elements)
}
