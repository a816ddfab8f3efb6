//! A header whose every field has been judged, before anything is allocated for it.

use std::path::Path;

use geometry::VolumeGrid;

use super::error::MetaImageError;
use super::fields::Fields;
use super::place::ct_from_voxel;
use crate::raster::{Data, Encoding, Head, OpenOptions, Skip, numbers};
use crate::stream::Packing;
use crate::voxels::Sample;

/// Voxels later than this are refused: what stands before them is a header, not volumes.
const MAX_SKIP: u64 = 64 << 20;
const ATTACHED: &str = "0 or -1 where the voxels follow the header";

/// Judges the header at the beginning of `path`.
///
/// # Errors
/// [`MetaImageError`].
pub(crate) fn parse(path: &Path, head: &mut Head, options: OpenOptions) -> Result<Data, MetaImageError> {
    let fields = Fields::parse(head)?;
    check_kind(&fields)?;
    let dims = dims(&fields)?;
    let sample = sample(&fields)?;
    let (ct_from_voxel, mut remarks) = ct_from_voxel(&fields, options)?;
    let grid = VolumeGrid::checked(dims, ct_from_voxel)?;
    remarks.claims(&fields.claims);
    let encoding = encoding(&fields)?;
    let big_endian = big_endian(&fields, sample, encoding)?;
    let list = fields.files()?;
    let skip = skip(&fields, encoding, list.is_none())?;
    let packed_limit = packed_limit(&fields)?;
    let (files, slices_per_file) = match list {
        None => (vec![path.to_owned()], grid.dims()[2]),
        Some(list) => {
            let line = fields.data_file_line();
            let refused = |source| MetaImageError::Files { line, source };
            let per_file = list.slices_per_file(dims[2], 3).map_err(refused)?;
            (list.paths(path).map_err(refused)?, per_file)
        }
    };
    Ok(Data {
        header: path.to_owned(),
        format: "MetaImage",
        grid,
        sample,
        big_endian,
        encoding,
        files,
        slices_per_file,
        skip,
        packed_limit,
        remarks,
    })
}

/// One scalar image in three dimensions, whose voxels are HU as they are.
fn check_kind(fields: &Fields) -> Result<(), MetaImageError> {
    let one_of = |name: &str, allowed: &[f64], expected| match fields.get(name) {
        Some(field) if !field.text.parse().is_ok_and(|found: f64| allowed.contains(&found)) => {
            Err(field.refuse(expected))
        }
        _ => Ok(()),
    };
    if let Some(field) = fields.get("ObjectType").filter(|field| field.text != "Image") {
        return Err(field.refuse("Image"));
    }
    fields.need("NDims", "3")?;
    if let Some(field) = fields.get("HeaderSizesPerDataFile") {
        return Err(field.refuse("HeaderSize, which is the same for each file, or no line of this name"));
    }
    one_of("NDims", &[3.0], "3")?;
    one_of("ElementNumberOfChannels", &[1.0], "1: one scalar volume")?;
    one_of(
        "ElementToIntensityFunctionSlope",
        &[1.0],
        "1: programs disagree on whether it is applied",
    )?;
    one_of(
        "ElementToIntensityFunctionOffset",
        &[0.0],
        "0: programs disagree on whether it is applied",
    )
}

fn dims(fields: &Fields) -> Result<[i64; 3], MetaImageError> {
    let expected = "three whole numbers of voxels";
    let field = fields.need("DimSize", expected)?;
    numbers(&field.text).ok_or_else(|| field.refuse(expected))
}

fn sample(fields: &Fields) -> Result<Sample, MetaImageError> {
    let expected = "a scalar of 8 to 64 bits, MET_CHAR to MET_DOUBLE";
    let field = fields.need("ElementType", expected)?;
    Ok(match field.text.as_str() {
        "MET_CHAR" | "MET_ASCII_CHAR" => Sample::I8,
        "MET_UCHAR" => Sample::U8,
        "MET_SHORT" => Sample::I16,
        "MET_USHORT" => Sample::U16,
        "MET_INT" => Sample::I32,
        "MET_UINT" => Sample::U32,
        "MET_LONG_LONG" => Sample::I64,
        "MET_ULONG_LONG" => Sample::U64,
        "MET_FLOAT" => Sample::F32,
        "MET_DOUBLE" => Sample::F64,
        "MET_LONG" | "MET_ULONG" => {
            return Err(field.refuse("MET_INT or MET_LONG_LONG: a long has 4 bytes on some systems and 8 on others"));
        }
        _ => return Err(field.refuse(expected)),
    })
}

fn encoding(fields: &Fields) -> Result<Encoding, MetaImageError> {
    let binary = fields.flag("BinaryData")?.unwrap_or(true);
    let compressed = fields.flag("CompressedData")?.unwrap_or(false);
    match (binary, compressed) {
        (true, false) => Ok(Encoding::Bytes(Packing::Plain)),
        (true, true) => Ok(Encoding::Bytes(Packing::Zlib)),
        (false, false) => Ok(Encoding::Text),
        (false, true) => {
            let field = fields.need("CompressedData", "False")?;
            Err(field.refuse("False, because BinaryData is False"))
        }
    }
}

/// The format leaves a missing order to the machine that reads: refused rather than guessed.
fn big_endian(fields: &Fields, sample: Sample, encoding: Encoding) -> Result<bool, MetaImageError> {
    let field = "BinaryDataByteOrderMSB";
    let told = fields.flag(field)?;
    if sample.bytes() == 1 || encoding == Encoding::Text {
        return Ok(false);
    }
    let expected = "True or False: the order of a voxel's bytes";
    told.ok_or(MetaImageError::Missing { field, expected })
}

/// -1 means that the voxels are the file's last bytes.
fn skip(fields: &Fields, encoding: Encoding, attached: bool) -> Result<Skip, MetaImageError> {
    let head = if attached { fields.end } else { 0 };
    let plain = encoding == Encoding::Bytes(Packing::Plain);
    let bytes = match fields.get("HeaderSize") {
        None => Some(0),
        Some(field) if field.text == "-1" && plain => None,
        Some(field) => {
            let bytes = field.text.parse().ok().filter(|&bytes: &u64| bytes <= MAX_SKIP);
            let bytes = bytes.ok_or_else(|| field.refuse("a number of bytes up to 64 MiB, or -1 for raw voxels"))?;
            if bytes > 0 && attached {
                return Err(field.refuse(ATTACHED));
            }
            if bytes > 0 && !plain {
                return Err(field.refuse("0 where the voxels are compressed or text"));
            }
            Some(bytes)
        }
    };
    Ok(Skip { head, lines: 0, bytes })
}

/// How many bytes the compressed stream has; 0 and a missing size mean all that there are.
fn packed_limit(fields: &Fields) -> Result<u64, MetaImageError> {
    let Some(field) = fields.get("CompressedDataSize") else {
        return Ok(u64::MAX);
    };
    match field.text.parse() {
        Ok(0) => Ok(u64::MAX),
        Ok(bytes) => Ok(bytes),
        Err(_) => Err(field.refuse("a number of bytes")),
    }
}
