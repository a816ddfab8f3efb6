//! A header whose every field has been judged, before anything is allocated for it.

use std::path::Path;

use geometry::VolumeGrid;

use super::error::NrrdError;
use super::fields::{Field, Fields};
use super::lists;
use super::place::place;
use super::types;
use crate::raster::{Data, Encoding, Head, OpenOptions, Remarks, Skip, is_hu, quote};
use crate::stream::Packing;
use crate::voxels::Sample;

/// Voxels later than this are refused: what stands before them is text, not volumes.
const MAX_SKIP: u64 = 64 << 20;
const NAMES: [&str; 5] = ["NRRD0001", "NRRD0002", "NRRD0003", "NRRD0004", "NRRD0005"];

/// Judges the header at the beginning of `path`.
///
/// # Errors
/// [`NrrdError`].
pub(crate) fn parse(path: &Path, head: &mut Head, options: OpenOptions) -> Result<Data, NrrdError> {
    let fields = Fields::parse(head)?;
    let dimension = dimension(&fields)?;
    lists::check(&fields, dimension)?;
    let sizes = sizes(&fields, dimension)?;
    let mut placed = place(&fields, dimension, options)?;
    check_axes(&fields, &sizes, placed.axes)?;
    check_rest(&fields)?;
    let dims = placed.axes.map(|axis| sizes.get(axis).copied().unwrap_or(0));
    let grid = VolumeGrid::checked(dims, placed.ct_from_voxel)?;
    meaning(&fields, &mut placed.remarks);
    let encoding = encoding(&fields)?;
    let sample = sample(&fields)?;
    let skip = skip(&fields, encoding)?;
    let big_endian = big_endian(&fields, sample, encoding)?;
    let (files, slices_per_file) = match fields.files()? {
        None => (vec![path.to_owned()], grid.dims()[2]),
        Some((line, list)) => {
            let refused = |source| NrrdError::Files { line, source };
            let last = sizes.last().copied().unwrap_or(0);
            let per_last = list.slices_per_file(last, dimension as i64).map_err(refused)?;
            // Where the last axis is the one of length 1, its one step is the whole volume.
            let whole = placed.axes[2] + 1 != dimension;
            let per_file = if whole { grid.dims()[2] } else { per_last };
            (list.paths(path).map_err(refused)?, per_file)
        }
    };
    let attached = fields.get("data file").is_none();
    Ok(Data {
        header: path.to_owned(),
        format: NAMES.get(usize::from(fields.version) - 1).copied().unwrap_or("NRRD"),
        grid,
        sample,
        big_endian,
        encoding,
        files,
        slices_per_file,
        skip: Skip {
            head: if attached { fields.end } else { 0 },
            ..skip
        },
        packed_limit: u64::MAX,
        remarks: placed.remarks,
    })
}

fn dimension(fields: &Fields) -> Result<usize, NrrdError> {
    let expected = "3, or 4 with one axis of length 1: one volume";
    let field = fields.need("dimension", expected)?;
    match field.text.parse() {
        Ok(dimension @ 3..=4) => Ok(dimension),
        _ => Err(field.refuse(expected)),
    }
}

fn sizes(fields: &Fields, dimension: usize) -> Result<Vec<i64>, NrrdError> {
    let expected = "a whole number of voxels for each axis";
    let field = fields.need("sizes", expected)?;
    let words = field.text.split_whitespace().take(dimension + 1);
    let sizes: Option<Vec<i64>> = words.map(|word| word.parse().ok()).collect();
    sizes
        .filter(|sizes| sizes.len() == dimension)
        .ok_or_else(|| field.refuse(expected))
}

/// What is doubtful about the numbers being HU.
fn meaning(fields: &Fields, remarks: &mut Remarks) {
    if let Some(field) = fields.get("sample units") {
        let unit = field.text.trim_matches('"').trim();
        if !["", "???", "none"].contains(&unit) && !is_hu(unit) {
            remarks.doubt(format!("sample units are {}: its numbers are not HU", quote(unit)));
        }
    }
    remarks.claims(&fields.claims);
}

/// Each of the volume's axes holds places, and what else there is has length 1.
fn check_axes(fields: &Fields, sizes: &[i64], axes: [usize; 3]) -> Result<(), NrrdError> {
    if let Some(extra) = (0..sizes.len()).find(|axis| !axes.contains(axis))
        && sizes.get(extra) != Some(&1)
    {
        let field = fields.need("sizes", "a length for each axis")?;
        return Err(field.refuse("length 1 for the axis without a direction: one scalar volume"));
    }
    let Some(field) = fields.get("kinds") else {
        return Ok(());
    };
    for (axis, kind) in field.text.split_whitespace().enumerate() {
        let places = ["domain", "space", "none", "???"].contains(&kind.to_lowercase().as_str());
        if axes.contains(&axis) && !places {
            return Err(NrrdError::Kind {
                line: field.line,
                axis,
                found: quote(kind),
            });
        }
    }
    Ok(())
}

/// Fields that change nothing where they are well, and must not be passed over where they are not.
fn check_rest(fields: &Fields) -> Result<(), NrrdError> {
    for name in ["old min", "old max"] {
        if let Some(field) = fields.get(name) {
            return Err(NrrdError::Quantised {
                line: field.line,
                field: field.name,
            });
        }
    }
    if let Some(field) = fields.get("space dimension").filter(|field| field.text != "3") {
        return Err(field.refuse("3"));
    }
    if let Some(field) = fields.get("centers") {
        // The origin is the centre of the first voxel either way.
        let known = |word: &str| ["cell", "node", "none", "???"].contains(&word.to_lowercase().as_str());
        if !field.text.split_whitespace().all(known) {
            return Err(field.refuse("cell or node for each axis"));
        }
    }
    Ok(())
}

fn encoding(fields: &Fields) -> Result<Encoding, NrrdError> {
    let expected = "raw, gzip, ascii or hex (write other files again: unu save -e gzip)";
    let field = fields.need("encoding", expected)?;
    types::encoding(&field.text).ok_or_else(|| field.refuse(expected))
}

fn sample(fields: &Fields) -> Result<Sample, NrrdError> {
    let expected = "an integer of 8 to 64 bits, float or double";
    let field = fields.need("type", expected)?;
    types::sample(&field.text).ok_or_else(|| field.refuse(expected))
}

/// Needed where a voxel has several bytes.
fn big_endian(fields: &Fields, sample: Sample, encoding: Encoding) -> Result<bool, NrrdError> {
    let expected = "little or big";
    if sample.bytes() == 1 || encoding == Encoding::Text {
        return Ok(false);
    }
    let field = fields.need("endian", expected)?;
    match field.text.to_lowercase().as_str() {
        "little" => Ok(false),
        "big" => Ok(true),
        _ => Err(field.refuse(expected)),
    }
}

/// Lines are skipped before bytes; -1 bytes means that the voxels are the file's last.
fn skip(fields: &Fields, encoding: Encoding) -> Result<Skip, NrrdError> {
    let count = |field: &Field, expected| {
        let found = field.text.parse().ok().filter(|&count: &u64| count <= MAX_SKIP);
        found.ok_or_else(|| field.refuse(expected))
    };
    let lines = match fields.get("line skip") {
        Some(field) => count(field, "a number of lines")?,
        None => 0,
    };
    let bytes = match fields.get("byte skip") {
        Some(field) if field.text == "-1" && encoding == Encoding::Bytes(Packing::Plain) => None,
        Some(field) => Some(count(field, "a number of bytes up to 64 MiB, or -1 for raw voxels")?),
        None => Some(0),
    };
    Ok(Skip { head: 0, lines, bytes })
}
