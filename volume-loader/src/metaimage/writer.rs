//! Any examination to MetaImage: i16, HU as they are, LPS and mm; places are true to a few roundings of a double.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use geometry::VolumeGrid;

use crate::partial::Partial;
use crate::source::{Conversion, VoxelSource};
use crate::write::error::{WriteError, io};
use crate::write::{Packing, WriteOptions, append_voxels, name_beside, rename_pair};

/// How far from a right angle (cosine) axes may be: the format's matrix is a rotation to many programs.
const SKEW: f64 = 1e-5;

/// Writes every slice of `source` to `path`, and gives what `source` changed: a `.mha` file, or an `.mhd` header with the
/// voxels beside it in a file of the same name that ends in `.raw`, or in `.zraw` where they are compressed.
///
/// Files are written under other names in the same folder and renamed when they are whole; an old header with the name
/// of a new one goes before the voxels are replaced.
///
/// # Errors
/// Each variant of [`WriteError`].
pub fn write(path: &Path, source: &mut dyn VoxelSource, options: WriteOptions) -> Result<Conversion, WriteError> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    check_angles(path, source.grid())?;
    match ending {
        Some("mha") => attached(path, source, options),
        Some("mhd") => detached(path, source, options),
        _ => Err(WriteError::Name {
            path: path.to_owned(),
            expected: "a name that ends in .mha or .mhd",
        }),
    }
}

fn check_angles(path: &Path, grid: &VolumeGrid) -> Result<(), WriteError> {
    let step = |axis| grid.ct_from_voxel().step(axis);
    for axes in [[0, 1], [0, 2], [1, 2]] {
        let [a, b] = axes.map(step);
        let cosine = a.dot(b) / (a.norm() * b.norm());
        if cosine.abs() > SKEW {
            return Err(WriteError::Sheared {
                path: path.to_owned(),
                axes,
                degrees: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
            });
        }
    }
    Ok(())
}

fn attached(path: &Path, source: &mut dyn VoxelSource, options: WriteOptions) -> Result<Conversion, WriteError> {
    let partial = Partial::create(path)?;
    let mut file = partial.file()?;
    let failed = io(path, "write its header");
    let grid = *source.grid();
    let put = |file: &mut File, packed: u64| {
        let text = header(&grid, options, packed, "LOCAL");
        file.write_all(text.as_bytes()).map(|()| text.len() as u64)
    };
    let start = put(&mut file, 0).map_err(&failed)?;
    let conversion = append_voxels(path, &partial, source, packing(options))?;
    if options.compress {
        // The size is known only now; the header keeps its length.
        let end = file.stream_position().map_err(&failed)?;
        file.seek(SeekFrom::Start(0)).map_err(&failed)?;
        put(&mut file, end - start).map_err(&failed)?;
    }
    partial.rename()?;
    Ok(conversion)
}

fn detached(path: &Path, source: &mut dyn VoxelSource, options: WriteOptions) -> Result<Conversion, WriteError> {
    let name = name_beside(path, if options.compress { "zraw" } else { "raw" })?;
    let voxels_path = path.with_file_name(&name);
    let (head, body) = (Partial::create(path)?, Partial::create(&voxels_path)?);
    let grid = *source.grid();
    let conversion = append_voxels(&voxels_path, &body, source, packing(options))?;
    let packed = body.file()?.stream_position().map_err(io(&voxels_path, "measure it"))?;
    let header = header(&grid, options, packed, &name);
    head.file()?
        .write_all(header.as_bytes())
        .map_err(io(path, "write it"))?;
    rename_pair(path, head, body)?;
    Ok(conversion)
}

fn packing(options: WriteOptions) -> Packing {
    if options.compress {
        Packing::Zlib
    } else {
        Packing::Plain
    }
}

/// The header up to the line end after `data_file`; its length does not depend on `packed`.
fn header(grid: &VolumeGrid, options: WriteOptions, packed: u64, data_file: &str) -> String {
    let ([nx, ny, nz], spacing) = (grid.dims(), grid.spacing_mm());
    let map = grid.ct_from_voxel();
    let directions = [0, 1, 2].map(|axis| words(map.step(axis).mm().map(|v| v / spacing[axis])));
    let (compressed, size) = if options.compress {
        ("True", format!("CompressedDataSize = {packed:020}\n"))
    } else {
        ("False", String::new())
    };
    let (matrix, origin) = (directions.join(" "), words(map.rows().map(|row| row[3])));
    let spacing = words(spacing);
    format!(
        "ObjectType = Image\n\
         NDims = 3\n\
         BinaryData = True\n\
         BinaryDataByteOrderMSB = False\n\
         CompressedData = {compressed}\n\
         {size}\
         TransformMatrix = {matrix}\n\
         Offset = {origin}\n\
         CenterOfRotation = 0 0 0\n\
         ElementSpacing = {spacing}\n\
         DimSize = {nx} {ny} {nz}\n\
         ElementType = MET_SHORT\n\
         ElementDataFile = {data_file}\n"
    )
}

/// The shortest text that is read as the same doubles.
fn words([x, y, z]: [f64; 3]) -> String {
    // Adding zero makes -0 a plain 0.
    format!("{} {} {}", x + 0.0, y + 0.0, z + 0.0)
}
