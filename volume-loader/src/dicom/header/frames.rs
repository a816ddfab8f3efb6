//! The frames of an Enhanced CT as slices: each with the place, the numbers and the part of the file that it says it has.

use std::path::PathBuf;

use super::part::{Number, Part};
use super::{Header, placed};
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
    pub part: Part,
    /// InStackPositionNumber; compared with the place, never taken for it.
    pub in_stack: Option<u32>,
    /// FrameAcquisitionNumber.
    pub acquisition: Option<u16>,
    pub concatenation: Option<Concatenation>,
    /// By which element and value its pixels do not lie where its place and its axes put them.
    pub distorted: Option<(Tag, String)>,
    /// The headers of the extended table of offsets and of that of lengths.
    pub tables: [Option<Element>; 2],
}

/// VolumetricProperties and VolumeBasedCalculationTechnique of what is no slice of a body (PS3.3, C.8.16.2.1): pixels of a plane that
/// is bent or seen in perspective, or colours of a surface.
const NO_SLICES: [&str; 4] = ["DISTORTED", "CURVED_MPR", "VOLUME_RENDER", "SURFACE_RENDER"];

/// A volume in several files (PS3.3, C.7.6.16.2.2.4).
#[derive(Debug, Clone)]
pub(crate) struct Concatenation {
    /// Never shown.
    pub uid: String,
    /// InConcatenationNumber, from 1.
    pub number: u32,
    /// InConcatenationTotalNumber, which a file may leave out.
    pub total: Option<u32>,
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
        let tag = el::IN_CONCATENATION;
        let number = u32::from(e.u16(tag)?);
        if number == 0 || total.is_some_and(|total| number > total) {
            return Err(FileError::Value {
                tag,
                found: number.to_string(),
                expected: "a number from 1 to InConcatenationTotalNumber",
            });
        }
        Ok(Some(Self { uid, number, total }))
    }

    /// Its number, unless it is known to be the only one.
    pub(crate) fn one_of_several(&self) -> Option<u32> {
        (self.total != Some(1)).then_some(self.number)
    }
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
            found: match groups.len() {
                1 => "one item".to_owned(),
                count => format!("{count} items"),
            },
            expected: format!("{of}: one for each frame"),
        });
    }
    let nothing = Group::default();
    let shared = e.shared.as_deref().and_then(<[Group]>::first).unwrap_or(&nothing);
    let concatenation = Concatenation::of(e)?;
    let joined = concatenation.as_ref().map(|whole| (whole.uid.clone(), PathBuf::new()));
    let instance = joined.or_else(|| {
        // Slices of one series that lie in a file each belong together as classic ones do.
        let own = || (e.text(el::SOP_INSTANCE).unwrap_or_default(), file.path.clone());
        (of > 1).then(own)
    });
    let common = Frame {
        number: 0,
        part: Part {
            instance,
            ..Part::default()
        },
        in_stack: None,
        acquisition: None,
        concatenation,
        distorted: None,
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
    let localizer = file.localizer || kind.localizer;
    // What is said of the whole file holds for a frame that says nothing to the contrary.
    let contrast = [kind.contrast, file.contrast.clone()].into_iter().flatten();
    let properties = [
        (el::VOLUMETRIC, kind.volumetric),
        (el::TECHNIQUE, kind.technique),
        (el::VOLUMETRIC, file.volumetric.clone()),
        (el::TECHNIQUE, file.technique.clone()),
    ];
    let properties = properties.into_iter().filter_map(|(tag, value)| Some((tag, value?)));
    let part = Part {
        stack: content.stack,
        temporal: content.temporal,
        phases: [group.cardiac.map(|cardiac| cardiac.percent), group.respiratory]
            .map(|percent| percent.flatten().map(Number)),
        // Where there is a percentage, the delay follows from it and from how fast the heart beat at each frame.
        delay: group
            .cardiac
            .filter(|cardiac| cardiac.percent.is_none())
            .and_then(|cardiac| cardiac.delay_ms)
            .map(Number),
        kind: kind.label,
        algorithm: made.algorithm,
        kernel: kernel.clone(),
        rescale_type: transformation.kind.clone().filter(|kind| kind.shown() != "HU"),
        ..frame.part
    };
    let (position, orientation) = (group.position.flatten(), group.orientation.flatten());
    Ok(Header {
        localizer,
        placed: placed(position, orientation, measures.spacing, localizer)?,
        slope: transformation.slope,
        intercept: transformation.intercept,
        rescale_type: transformation.kind,
        contrast: contrast
            .into_iter()
            .find(|kind| !["NONE", "MIXED"].contains(&kind.as_str())),
        tilt_deg: details.tilt_deg.or(converted.tilt_deg),
        thickness_mm: measures.thickness_mm,
        spacing_between_mm: measures.spacing_between_mm,
        kernel,
        modality_lut: file.modality_lut || group.modality_lut,
        frame: Some(Frame {
            part,
            in_stack: content.in_stack,
            acquisition: content.acquisition,
            distorted: properties
                .into_iter()
                .find(|(_, value)| NO_SLICES.contains(&value.as_str())),
            ..frame
        }),
        ..file.clone()
    })
}
