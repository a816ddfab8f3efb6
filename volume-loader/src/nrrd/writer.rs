//! Any examination to NRRD: i16, HU as they are, LPS and mm; numbers so exact that the same doubles are read again.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use geometry::VolumeGrid;

use crate::partial::Partial;
use crate::source::{Conversion, VoxelSource};
use crate::write::error::{WriteError, io};
use crate::write::{Packing, WriteOptions, append_voxels, name_beside, rename_pair};

/// Writes every slice of `source` to `path`, and gives what `source` changed: a `.nrrd` file, or an `.nhdr` header with
/// the voxels beside it in a file of the same name that ends in `.raw`, or in `.raw.gz` where they are compressed.
///
/// Files are written under other names in the same folder and renamed when they are whole; an old header with the name
/// of a new one goes before the voxels are replaced.
///
/// # Errors
/// Each variant of [`WriteError`] but `Sheared`.
pub fn write(path: &Path, source: &mut dyn VoxelSource, options: WriteOptions) -> Result<Conversion, WriteError> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    match ending {
        Some("nrrd") => attached(path, source, options),
        Some("nhdr") => detached(path, source, options),
        _ => Err(WriteError::Name {
            path: path.to_owned(),
            expected: "a name that ends in .nrrd or .nhdr",
        }),
    }
}

/// A structure of a label map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segment {
    /// Its label.
    pub label: i16,
    /// Its name, where it has one.
    pub name: Option<String>,
    /// The least and the greatest index of its voxels along each axis.
    pub extent: ([u32; 3], [u32; 3]),
}

/// Writes a label map to `path`, a `.nrrd` file, with the keys by which 3D Slicer knows its segments (`.seg.nrrd`).
///
/// # Errors
/// Each variant of [`WriteError`] but `Sheared`.
pub fn write_labels(
    path: &Path,
    source: &mut dyn VoxelSource,
    options: WriteOptions,
    segments: &[Segment],
) -> Result<(), WriteError> {
    if path.extension().is_none_or(|ending| ending != "nrrd") {
        return Err(WriteError::Name {
            path: path.to_owned(),
            expected: "a name that ends in .seg.nrrd or .nrrd",
        });
    }
    write_attached(path, source, options, &keys(segments)).map(|_| ())
}

/// Key/value pairs of segments, as 3D Slicer has them.
fn keys(segments: &[Segment]) -> String {
    let mut text = String::new();
    for (number, segment) in segments.iter().enumerate() {
        let label = segment.label;
        let name = segment.name.clone().unwrap_or_else(|| format!("label {label}"));
        let escaped = name.replace('\\', "\\\\").replace('\n', "\\n");
        let ([x, y, z], [to_x, to_y, to_z]) = segment.extent;
        // To a string: this cannot fail.
        let _ = write!(
            text,
            "Segment{number}_ID:=Segment_{label}\n\
             Segment{number}_Name:={escaped}\n\
             Segment{number}_LabelValue:={label}\n\
             Segment{number}_Layer:=0\n\
             Segment{number}_Extent:={x} {to_x} {y} {to_y} {z} {to_z}\n"
        );
    }
    text
}

fn attached(path: &Path, source: &mut dyn VoxelSource, options: WriteOptions) -> Result<Conversion, WriteError> {
    write_attached(path, source, options, "")
}

fn write_attached(
    path: &Path,
    source: &mut dyn VoxelSource,
    options: WriteOptions,
    keys: &str,
) -> Result<Conversion, WriteError> {
    let partial = Partial::create(path)?;
    let mut file = partial.file()?;
    let header = header(source.grid(), options, None, keys);
    file.write_all(header.as_bytes())
        .map_err(io(path, "write its header"))?;
    let conversion = append_voxels(path, &partial, source, packing(options))?;
    partial.rename()?;
    Ok(conversion)
}

fn detached(path: &Path, source: &mut dyn VoxelSource, options: WriteOptions) -> Result<Conversion, WriteError> {
    let name = name_beside(path, if options.compress { "raw.gz" } else { "raw" })?;
    let voxels_path = path.with_file_name(&name);
    let (head, body) = (Partial::create(path)?, Partial::create(&voxels_path)?);
    let header = header(source.grid(), options, Some(&name), "");
    head.file()?
        .write_all(header.as_bytes())
        .map_err(io(path, "write it"))?;
    let conversion = append_voxels(&voxels_path, &body, source, packing(options))?;
    rename_pair(path, head, body)?;
    Ok(conversion)
}

fn packing(options: WriteOptions) -> Packing {
    if options.compress {
        Packing::Gzip
    } else {
        Packing::Plain
    }
}

/// The header with the empty line that ends it; `keys` are lines of key/value pairs.
fn header(grid: &VolumeGrid, options: WriteOptions, data_file: Option<&str>, keys: &str) -> String {
    let [nx, ny, nz] = grid.dims();
    let map = grid.ct_from_voxel();
    let [sx, sy, sz] = [0, 1, 2].map(|axis| vector(map.step(axis).mm()));
    let origin = vector(map.rows().map(|row| row[3]));
    let encoding = if options.compress { "gzip" } else { "raw" };
    // Version 4 is the first with a space.
    let mut text = format!(
        "NRRD0004\n\
         # Complete NRRD file format specification at:\n\
         # http://teem.sourceforge.net/nrrd/format.html\n\
         type: short\n\
         dimension: 3\n\
         space: left-posterior-superior\n\
         sizes: {nx} {ny} {nz}\n\
         space directions: {sx} {sy} {sz}\n\
         kinds: domain domain domain\n\
         endian: little\n\
         encoding: {encoding}\n\
         space units: \"mm\" \"mm\" \"mm\"\n\
         space origin: {origin}\n"
    );
    if let Some(name) = data_file {
        // To a string: this cannot fail.
        let _ = writeln!(text, "data file: {name}");
    }
    text.push_str(keys);
    text.push('\n');
    text
}

/// The shortest text that is read as the same doubles.
fn vector([x, y, z]: [f64; 3]) -> String {
    // Adding zero makes -0 a plain 0.
    format!("({},{},{})", x + 0.0, y + 0.0, z + 0.0)
}
