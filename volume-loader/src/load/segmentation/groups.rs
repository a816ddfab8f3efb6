//! What the sequences of a segmentation say, item by item.

use crate::dicom::element::tree::Tree;
use crate::dicom::error::FileError;
use crate::dicom::tag as el;

/// What one item of functional groups says.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Group {
    pub position: Option<[f64; 3]>,
    pub orientation: Option<[f64; 6]>,
    pub spacing: Option<[f64; 2]>,
    step_mm: Option<f64>,
    pub segment: Option<u16>,
    temporal: Option<u32>,
}

impl Group {
    fn of(item: &Tree) -> Result<Self, FileError> {
        let measures = item.only(el::PIXEL_MEASURES)?;
        let numbers = |tree: Option<&Tree>, tag| tree.map_or(Ok(None), |tree| tree.values.numbers::<1>(tag));
        let step = numbers(measures, el::SPACING_BETWEEN_SLICES)?;
        Ok(Self {
            position: item
                .only(el::PLANE_POSITION)?
                .map_or(Ok(None), |tree| tree.values.numbers(el::POSITION))?,
            orientation: item
                .only(el::PLANE_ORIENTATION)?
                .map_or(Ok(None), |tree| tree.values.numbers(el::ORIENTATION))?,
            spacing: measures.map_or(Ok(None), |tree| tree.values.numbers(el::PIXEL_SPACING))?,
            step_mm: step.map(|[step]| step),
            segment: item
                .only(el::SEGMENT_OF_FRAME)?
                .map(|tree| tree.values.u16(el::SEGMENT_REFERENCED))
                .transpose()?,
            temporal: item
                .only(el::FRAME_CONTENT)?
                .map_or(Ok(None), |tree| tree.values.u32(el::TEMPORAL))?,
        })
    }

    /// What it says itself, and where it is silent what all frames share.
    pub(super) fn or(self, shared: Self) -> Self {
        Self {
            position: self.position.or(shared.position),
            orientation: self.orientation.or(shared.orientation),
            spacing: self.spacing.or(shared.spacing),
            step_mm: self.step_mm.or(shared.step_mm),
            segment: self.segment.or(shared.segment),
            temporal: self.temporal.or(shared.temporal),
        }
    }
}

/// What the sequences of the file say, as they come.
#[derive(Debug, Default)]
pub(super) struct Sequences {
    pub segments: Vec<Tree>,
    /// Of the series that it was made of.
    pub series: Vec<String>,
    shared: Vec<Group>,
    pub frames: Vec<Group>,
}

impl Sequences {
    pub(super) fn take(&mut self, tag: el::Tag, item: Tree) -> Result<(), FileError> {
        match tag {
            el::SEGMENTS => self.segments.push(item),
            el::REFERENCED_SERIES => self.series.extend(item.values.text(el::SERIES)),
            el::SHARED_GROUPS => self.shared.push(Group::of(&item)?),
            el::FRAME_GROUPS => {
                let number = self.frames.len() as u32 + 1;
                let group = Group::of(&item).map_err(|error| error.in_frame(Some(number)))?;
                self.frames.push(group);
            }
            _ => {}
        }
        Ok(())
    }

    /// What all frames share.
    pub(super) fn shared(&self) -> Result<Group, FileError> {
        match self.shared[..] {
            [] => Ok(Group::default()),
            [shared] => Ok(shared),
            _ => Err(FileError::Items {
                tag: el::SHARED_GROUPS,
                found: self.shared.len().to_string(),
                expected: "one: what all frames share".to_owned(),
            }),
        }
    }

    /// SpacingBetweenSlices, mm, which frames may not say differently.
    pub(super) fn step_mm(&self) -> Result<Option<f64>, FileError> {
        let step = self.one(|group| group.step_mm)?;
        step.filter(|step| step.is_none_or(|mm| mm > 0.0))
            .ok_or_else(|| FileError::Value {
                tag: el::SPACING_BETWEEN_SLICES,
                found: "not above 0, or not the same in all frames".to_owned(),
                expected: "one number above 0, or none",
            })
    }

    /// Whether all frames are of one point in time: else they are several segmentations.
    pub(super) fn is_of_one_time(&self) -> Result<bool, FileError> {
        Ok(self.one(|group| group.temporal)?.is_some())
    }

    /// What all frames say alike; `None` where they do not.
    fn one<T: PartialEq>(&self, said: impl Fn(Group) -> Option<T>) -> Result<Option<Option<T>>, FileError> {
        let shared = self.shared()?;
        let mut all = self.frames.iter().map(|frame| said(frame.or(shared)));
        let first = all.next().flatten();
        Ok(all.all(|other| other == first).then_some(first))
    }
}
