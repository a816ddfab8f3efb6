//! POINT, IMGMETA and CAPABILITY: lists of places, of images that can be asked for, and of types that a peer reads.

use super::scalar::Scalar;
use crate::fault::Fault;
use crate::fields::{Fields, Value};
use crate::limits::Limits;
use crate::malformed::Refusal;
use crate::name::{DeviceName, Name, TypeName};
use crate::stamp::Stamp;
use crate::wire::{Reader, put_real, put_reals, put_u16s};

const POINT_BYTES: u64 = 136;
const IMAGE_ENTRY_BYTES: u64 = 260;
const TYPE_BYTES: u64 = 12;

/// A place of a POINT, 136 bytes: name (64), group (32), colour (4), place (12), diameter (4), owner (20).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landmark {
    /// Its name.
    pub name: Name<64>,
    /// What it is one of: `Fiducial`, `Landmark`.
    pub group: Name<32>,
    /// Red, green, blue, opacity.
    pub colour: [u8; 4],
    /// Millimetres, in the frame of the owner: patients are RAS.
    pub place: [f32; 3],
    /// Millimetres; 0 where it has none.
    pub diameter: f32,
    /// The image in which it lies; empty for none.
    pub owner: DeviceName,
}

pub(crate) fn read_points(reader: &mut Reader<'_>, limits: &Limits) -> Result<Vec<Landmark>, Refusal> {
    let count = reader.elements(POINT_BYTES, "points", limits.elements)?;
    let mut points = Vec::with_capacity(count);
    for _ in 0..count {
        points.push(Landmark {
            name: reader.label("the name of a point")?,
            group: reader.label("the group of a point")?,
            colour: reader.array()?,
            place: reader.reals("the place of a point")?,
            diameter: reader.real("the diameter of a point")?,
            owner: reader.label("the owner of a point")?,
        });
    }
    Ok(points)
}

pub(crate) fn write_points(points: &[Landmark], out: &mut Vec<u8>) -> Result<(), Fault> {
    for point in points {
        out.extend(point.name.field());
        out.extend(point.group.field());
        out.extend(point.colour);
        put_reals(out, &point.place, "the place of a point")?;
        put_real(out, point.diameter, "the diameter of a point")?;
        out.extend(point.owner.field());
    }
    Ok(())
}

pub(crate) fn point_fields(points: &[Landmark], fields: &mut Fields) {
    fields.add("points", points.len());
    for (number, point) in points.iter().enumerate() {
        let mut add = |field: &str, value: Value| fields.add(format!("points[{number}].{field}"), value);
        add("name", (&point.name).into());
        add("group", (&point.group).into());
        add("colour_rgba", point.colour[..].into());
        add("place_mm", point.place[..].into());
        add("diameter_mm", point.diameter.into());
        add("owner", (&point.owner).into());
    }
}

/// An image of an IMGMETA, 260 bytes: name (64), device (20), modality (32), patient (64), patient's number (64), stamp
/// (8), voxels (6), scalar (1), nothing (1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageEntry {
    /// What a person calls it.
    pub name: Name<64>,
    /// The device by which GET_IMAGE asks for it.
    pub device: DeviceName,
    /// `CT`, `MRI`.
    pub modality: Name<32>,
    /// Whose it is.
    pub patient_name: Name<64>,
    /// The patient's number.
    pub patient_id: Name<64>,
    /// When it was taken.
    pub stamp: Stamp,
    /// Voxels along its three axes.
    pub dimensions: [u16; 3],
    /// What a voxel is.
    pub scalar: Scalar,
}

pub(crate) fn read_images(reader: &mut Reader<'_>, limits: &Limits) -> Result<Vec<ImageEntry>, Refusal> {
    let count = reader.elements(IMAGE_ENTRY_BYTES, "images", limits.elements)?;
    let mut images = Vec::with_capacity(count);
    for _ in 0..count {
        images.push(ImageEntry {
            name: reader.label("the name of an image")?,
            device: reader.label("the device of an image")?,
            modality: reader.label("the modality of an image")?,
            patient_name: reader.label("the name of a patient")?,
            patient_id: reader.label("the number of a patient")?,
            stamp: Stamp(reader.u64()?),
            dimensions: reader.u16s()?,
            scalar: Scalar::read(reader)?,
        });
        reader.u8()?;
    }
    Ok(images)
}

pub(crate) fn write_images(images: &[ImageEntry], out: &mut Vec<u8>) {
    for image in images {
        out.extend(image.name.field());
        out.extend(image.device.field());
        out.extend(image.modality.field());
        out.extend(image.patient_name.field());
        out.extend(image.patient_id.field());
        out.extend(image.stamp.0.to_be_bytes());
        put_u16s(out, &image.dimensions);
        out.extend([image.scalar.number(), 0]);
    }
}

pub(crate) fn image_fields(images: &[ImageEntry], fields: &mut Fields) {
    fields.add("images", images.len());
    for (number, image) in images.iter().enumerate() {
        let mut add = |field: &str, value: Value| fields.add(format!("images[{number}].{field}"), value);
        add("name", (&image.name).into());
        add("device", (&image.device).into());
        add("modality", (&image.modality).into());
        add("patient_name", (&image.patient_name).into());
        add("patient_id", (&image.patient_id).into());
        add("stamp_ns", image.stamp.ns().into());
        add("voxels", image.dimensions[..].into());
        add("scalar", image.scalar.word().into());
    }
}

/// The types of a CAPABILITY, 12 bytes each.
pub(crate) fn read_types(reader: &mut Reader<'_>, limits: &Limits) -> Result<Vec<TypeName>, Refusal> {
    let count = reader.elements(TYPE_BYTES, "types", limits.elements)?;
    let mut types = Vec::with_capacity(count);
    for _ in 0..count {
        types.push(reader.name("the name of a type")?);
    }
    Ok(types)
}

pub(crate) fn write_types(types: &[TypeName], out: &mut Vec<u8>) {
    types.iter().for_each(|name| out.extend(name.field()));
}

pub(crate) fn type_fields(types: &[TypeName], fields: &mut Fields) {
    fields.add(
        "types",
        types.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "),
    );
}
