//! The structures of a label map as Segmentation Storage, BINARY (DICOM PS3.3, A.51 and C.8.20): the one that every reader knows.
//!
//! A frame is one plane of one segment. The first segment has a frame in every plane, so that the grid of the map is in the file whatever
//! the structures are; of each other segment there are those between its first and its last plane. Places are those of the map's voxels, also
//! where a tilted gantry sheared them. Segments count from 1 without a gap, as the standard wants it of this kind.

use std::fs::Permissions;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use bus::message::VolumeHash;
use bus::volume::VolumeView;
use dicom_core::value::PrimitiveValue;
use dicom_core::{DataElement, VR};
use dicom_dictionary_std::{tags, uids};

use super::bits::Bits;
use super::context::Context;
use super::error::DerivedError;
use super::items::{self, Object, code, item, now, put, put_items, put_u16};
use crate::dicom_out::ds::{decimal_string, decimal_strings};
use crate::dicom_out::placement::Placement;
use crate::dicom_out::uid::of_hash;
use crate::nrrd::Segment;
use crate::partial::Partial;
use crate::write::error::io;

/// More frames than this are no segmentation that a reader opens.
const MOST_FRAMES: usize = 1 << 17;
/// Category and type of a structure of which nothing but a name is known, as 3D Slicer has it.
const TISSUE: [&str; 3] = ["85756007", "SCT", "Tissue"];

/// What the slices of the series are to the segmentation (PS3.16, CID 7202).
const SOURCE: [&str; 3] = ["121322", "DCM", "Source image for image processing operation"];

/// One frame: a plane of the map, and which of the segments, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Frame {
    plane: u32,
    segment: usize,
}

/// Writes these structures of `map`, whose hash is `hash`, to `path` as a segmentation of the series of `context`; segment `i`, from 1, is the `i`-th of `segments`.
///
/// # Errors
/// [`DerivedError`]; nothing is left of the file then, and what was at its path is still there.
pub(crate) fn write(
    path: &Path,
    map: &VolumeView<'_>,
    hash: VolumeHash,
    context: &Context,
    segments: &[Segment],
) -> Result<(), DerivedError> {
    let frames = frames(map.grid.dims()[2], segments)?;
    let length = pixel_bytes(map, frames.len())?;
    let head = Head {
        path,
        map,
        hash,
        context,
        segments,
        frames: &frames,
    };
    let header = items::encoded(head.object()?)?;
    let partial = Partial::create(path)?;
    let mut file = partial.file()?;
    let failed = io(path, "write it");
    // It names the patient.
    file.set_permissions(Permissions::from_mode(0o600)).map_err(&failed)?;
    file.write_all(&header).map_err(&failed)?;
    file.write_all(&pixel_header(length)).map_err(&failed)?;
    write_frames(map, segments, &frames, |bytes| file.write_all(bytes).map_err(&failed))?;
    if length % 2 == 1 {
        file.write_all(&[0]).map_err(&failed)?;
    }
    Ok(partial.rename()?)
}

/// Plane by plane, so that each plane of the map is taken once.
fn frames(planes: u32, segments: &[Segment]) -> Result<Vec<Frame>, DerivedError> {
    if segments.is_empty() {
        return Err(DerivedError::Nothing { what: "structure" });
    }
    let mut frames = Vec::new();
    for plane in 0..planes {
        for (segment, one) in segments.iter().enumerate() {
            let (first, last) = one.extent;
            if segment == 0 || (first[2]..=last[2]).contains(&plane) {
                frames.push(Frame { plane, segment });
            }
        }
        if frames.len() > MOST_FRAMES {
            return Err(DerivedError::TooMany {
                found: frames.len() as u64,
                what: "frames, each a plane of a structure",
                most: MOST_FRAMES as u64,
            });
        }
    }
    Ok(frames)
}

/// Bytes of the pixel data but for the one that makes them even.
fn pixel_bytes(map: &VolumeView<'_>, frames: usize) -> Result<u32, DerivedError> {
    let [columns, rows, _] = map.grid.dims().map(u64::from);
    let bytes = (columns * rows * frames as u64).div_ceil(8);
    // An element's length is even, and the greatest number means that it is not defined.
    let most = u64::from(u32::MAX - 2);
    let what = "bytes of voxels";
    let found = bytes;
    u32::try_from(bytes)
        .ok()
        .filter(|bytes| u64::from(*bytes) <= most)
        .ok_or(DerivedError::TooMany { found, what, most })
}

/// The header of PixelData in Explicit VR Little Endian, OB.
fn pixel_header(length: u32) -> [u8; 12] {
    let [a, b, c, d] = length.next_multiple_of(2).to_le_bytes();
    [0xE0, 0x7F, 0x10, 0x00, b'O', b'B', 0, 0, a, b, c, d]
}

fn write_frames(
    map: &VolumeView<'_>,
    segments: &[Segment],
    frames: &[Frame],
    mut write: impl FnMut(&[u8]) -> Result<(), crate::WriteError>,
) -> Result<(), DerivedError> {
    let [columns, rows, _] = map.grid.dims();
    let mut plane = vec![0; columns as usize * rows as usize];
    let (mut taken, mut bits, mut bytes) = (None, Bits::default(), Vec::new());
    for frame in frames {
        if taken != Some(frame.plane) {
            map.slice(frame.plane, &mut plane);
            taken = Some(frame.plane);
        }
        let label = segments.get(frame.segment).map_or(0, |segment| segment.label);
        bits.push(plane.iter().map(|voxel| *voxel == label), &mut bytes);
        write(&bytes)?;
        bytes.clear();
    }
    bits.finish(&mut bytes);
    Ok(write(&bytes)?)
}

/// What the object says before its pixels.
struct Head<'a> {
    path: &'a Path,
    map: &'a VolumeView<'a>,
    hash: VolumeHash,
    context: &'a Context,
    segments: &'a [Segment],
    frames: &'a [Frame],
}

impl Head<'_> {
    fn object(&self) -> Result<Object, DerivedError> {
        let placement = Placement::new(self.map.grid, self.path)?;
        let [day, time] = now();
        let mut object = Object::new_empty();
        self.context.put(&mut object);
        self.series(&mut object, [&day, &time]);
        self.image(&mut object);
        put_items(&mut object, tags::SEGMENT_SEQUENCE, self.described()?);
        self.dimensions(&mut object, [&day, &time]);
        put_items(
            &mut object,
            tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE,
            vec![shared(&placement)],
        );
        let groups = self.frames.iter().map(|frame| group(frame, &placement)).collect();
        put_items(&mut object, tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, groups);
        Ok(object)
    }

    /// An identifier of this object: of the map, its names, the series, and when it was made.
    fn uid(&self, which: &str, now: [&str; 2]) -> String {
        let mut hasher = blake3::Hasher::new_derive_key("trocar dicom segmentation 1");
        for part in [which, now[0], now[1], &self.context.series] {
            hasher.update(part.as_bytes()).update(&[0]);
        }
        hasher.update(&self.hash.0);
        for segment in self.segments {
            hasher.update(&segment.label.to_le_bytes());
            hasher
                .update(segment.name.as_deref().unwrap_or_default().as_bytes())
                .update(&[0]);
        }
        of_hash(&hasher)
    }

    fn series(&self, object: &mut Object, now: [&str; 2]) {
        put(object, tags::SOP_CLASS_UID, VR::UI, uids::SEGMENTATION_STORAGE);
        put(object, tags::SOP_INSTANCE_UID, VR::UI, &self.uid("instance", now));
        put(object, tags::MODALITY, VR::CS, "SEG");
        put(object, tags::SERIES_INSTANCE_UID, VR::UI, &self.uid("series", now));
        put(object, tags::SERIES_NUMBER, VR::IS, "1");
        put(object, tags::SERIES_DESCRIPTION, VR::LO, "Segmentation");
        put(object, tags::MANUFACTURER, VR::LO, "Trocar");
        put(object, tags::MANUFACTURER_MODEL_NAME, VR::LO, "Trocar");
        put(object, tags::DEVICE_SERIAL_NUMBER, VR::LO, "1");
        put(object, tags::SOFTWARE_VERSIONS, VR::LO, env!("CARGO_PKG_VERSION"));
        put(object, tags::INSTANCE_NUMBER, VR::IS, "1");
        put(object, tags::CONTENT_DATE, VR::DA, now[0]);
        put(object, tags::CONTENT_TIME, VR::TM, now[1]);
        let series = item(|series| {
            put(series, tags::SERIES_INSTANCE_UID, VR::UI, &self.context.series);
            put_items(series, tags::REFERENCED_INSTANCE_SEQUENCE, self.context.references());
        });
        put_items(object, tags::REFERENCED_SERIES_SEQUENCE, vec![series]);
        let mut sources = self.context.references();
        for source in &mut sources {
            put_items(source, tags::PURPOSE_OF_REFERENCE_CODE_SEQUENCE, code(SOURCE));
        }
        put_items(object, tags::SOURCE_IMAGE_SEQUENCE, sources);
    }

    fn image(&self, object: &mut Object) {
        put(object, tags::IMAGE_TYPE, VR::CS, "DERIVED\\PRIMARY");
        put(object, tags::PHOTOMETRIC_INTERPRETATION, VR::CS, "MONOCHROME2");
        put(object, tags::LOSSY_IMAGE_COMPRESSION, VR::CS, "00");
        put(object, tags::NUMBER_OF_FRAMES, VR::IS, &self.frames.len().to_string());
        // A checked grid has at most 16384 voxels along an axis.
        let [columns, rows, _] = self.map.grid.dims().map(|count| count as u16);
        for (tag, number) in [
            (tags::SAMPLES_PER_PIXEL, 1),
            (tags::ROWS, rows),
            (tags::COLUMNS, columns),
            (tags::BITS_ALLOCATED, 1),
            (tags::BITS_STORED, 1),
            (tags::HIGH_BIT, 0),
            (tags::PIXEL_REPRESENTATION, 0),
        ] {
            put_u16(object, tag, number);
        }
        put(object, tags::SEGMENTATION_TYPE, VR::CS, "BINARY");
        put(object, tags::SEGMENTS_OVERLAP, VR::CS, "NO");
        put(object, tags::CONTENT_LABEL, VR::CS, "SEGMENTATION");
        put(object, tags::CONTENT_DESCRIPTION, VR::LO, "");
        put(object, tags::CONTENT_CREATOR_NAME, VR::PN, "");
    }

    /// The segments by their names.
    fn described(&self) -> Result<Vec<Object>, DerivedError> {
        let described = |(number, segment): (u16, &Segment)| {
            let label = segment.label;
            if label <= 0 {
                return Err(DerivedError::Label { label });
            }
            let name = segment.name.clone().unwrap_or_else(|| format!("label {label}"));
            items::name(&name)?;
            Ok(item(|object| {
                put_u16(object, tags::SEGMENT_NUMBER, number);
                put(object, tags::SEGMENT_LABEL, VR::LO, &name);
                // A file of labels does not say who drew it; the standard has no word for that.
                put(object, tags::SEGMENT_ALGORITHM_TYPE, VR::CS, "SEMIAUTOMATIC");
                put(
                    object,
                    tags::SEGMENT_ALGORITHM_NAME,
                    VR::LO,
                    "not known, from a label map",
                );
                put_items(object, tags::SEGMENTED_PROPERTY_CATEGORY_CODE_SEQUENCE, code(TISSUE));
                put_items(object, tags::SEGMENTED_PROPERTY_TYPE_CODE_SEQUENCE, code(TISSUE));
            }))
        };
        (1..).zip(self.segments).map(described).collect()
    }

    /// By what frames are told apart: the segment, and the plane.
    fn dimensions(&self, object: &mut Object, now: [&str; 2]) {
        let organization = self.uid("dimensions", now);
        let pointer = |pointer, group, words| {
            item(|object| {
                put(object, tags::DIMENSION_ORGANIZATION_UID, VR::UI, &organization);
                for (tag, to) in [
                    (tags::DIMENSION_INDEX_POINTER, pointer),
                    (tags::FUNCTIONAL_GROUP_POINTER, group),
                ] {
                    object.put(DataElement::new(tag, VR::AT, PrimitiveValue::from(to)));
                }
                put(object, tags::DIMENSION_DESCRIPTION_LABEL, VR::LO, words);
            })
        };
        let indices = vec![
            pointer(
                tags::REFERENCED_SEGMENT_NUMBER,
                tags::SEGMENT_IDENTIFICATION_SEQUENCE,
                "Segment",
            ),
            pointer(tags::IMAGE_POSITION_PATIENT, tags::PLANE_POSITION_SEQUENCE, "Plane"),
        ];
        let all = item(|object| put(object, tags::DIMENSION_ORGANIZATION_UID, VR::UI, &organization));
        put_items(object, tags::DIMENSION_ORGANIZATION_SEQUENCE, vec![all]);
        put_items(object, tags::DIMENSION_INDEX_SEQUENCE, indices);
    }
}

/// What all frames share: how they are turned, and how far their pixels and planes are apart.
fn shared(placement: &Placement) -> Object {
    item(|object| {
        let orientation = item(|object| {
            let text = decimal_strings(placement.orientation);
            put(object, tags::IMAGE_ORIENTATION_PATIENT, VR::DS, &text);
        });
        put_items(object, tags::PLANE_ORIENTATION_SEQUENCE, vec![orientation]);
        let measures = item(|object| {
            let step = decimal_string(placement.step_mm);
            put(object, tags::SLICE_THICKNESS, VR::DS, &step);
            put(object, tags::SPACING_BETWEEN_SLICES, VR::DS, &step);
            let spacing = decimal_strings(placement.pixel_spacing_mm);
            put(object, tags::PIXEL_SPACING, VR::DS, &spacing);
        });
        put_items(object, tags::PIXEL_MEASURES_SEQUENCE, vec![measures]);
    })
}

/// What one frame says of itself: where it is in the dimensions, where its plane lies, and of which segment it is.
fn group(frame: &Frame, placement: &Placement) -> Object {
    item(|object| {
        let number = frame.segment as u16 + 1;
        let content = item(|object| {
            let index = PrimitiveValue::U32([u32::from(number), frame.plane + 1].as_slice().into());
            object.put(DataElement::new(tags::DIMENSION_INDEX_VALUES, VR::UL, index));
        });
        put_items(object, tags::FRAME_CONTENT_SEQUENCE, vec![content]);
        let position = item(|object| {
            let text = decimal_strings(placement.position_mm(frame.plane));
            put(object, tags::IMAGE_POSITION_PATIENT, VR::DS, &text);
        });
        put_items(object, tags::PLANE_POSITION_SEQUENCE, vec![position]);
        let segment = item(|object| put_u16(object, tags::REFERENCED_SEGMENT_NUMBER, number));
        put_items(object, tags::SEGMENT_IDENTIFICATION_SEQUENCE, vec![segment]);
    })
}
