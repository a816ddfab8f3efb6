//! What every writer of examinations shares: the voxels as bytes, a header beside its voxels.

pub(crate) mod error;

use std::io::{BufWriter, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use crate::partial::Partial;
use crate::source::{Conversion, VoxelSource};
use crate::write::error::{WriteError, io};

/// What a caller chooses of a file to be written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Whether the voxels are compressed, losslessly, the way the format has for it.
    pub compress: bool,
}

/// How voxels are stored behind a text header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    /// As they are.
    Plain,
    /// NRRD's way to compress them.
    Gzip,
    /// MetaImage's.
    Zlib,
}

/// Every slice of `source` as little-endian i16, and what `source` changed.
///
/// # Errors
/// [`WriteError::Io`], [`WriteError::Read`].
pub(crate) fn write_voxels(
    path: &Path,
    out: &mut dyn Write,
    source: &mut dyn VoxelSource,
) -> Result<Conversion, WriteError> {
    let read = |source| WriteError::Read {
        path: path.to_owned(),
        source,
    };
    let [nx, ny, nz] = source.grid().dims();
    let mut slice = vec![0_i16; nx as usize * ny as usize];
    let mut bytes = Vec::with_capacity(2 * slice.len());
    for k in 0..nz {
        source.read_slice(k, &mut slice).map_err(read)?;
        bytes.clear();
        bytes.extend(slice.iter().flat_map(|v| v.to_le_bytes()));
        out.write_all(&bytes).map_err(io(path, "write its voxels"))?;
    }
    source.finish().map_err(read)
}

/// Appends the voxels of `source` to what is in `partial`, whose name will be `path`.
///
/// # Errors
/// [`WriteError::Io`], [`WriteError::Read`].
pub(crate) fn append_voxels(
    path: &Path,
    partial: &Partial,
    source: &mut dyn VoxelSource,
    packing: Packing,
) -> Result<Conversion, WriteError> {
    let mut file = BufWriter::new(partial.file()?);
    let end = io(path, "write its end");
    let conversion = match packing {
        Packing::Plain => write_voxels(path, &mut file, source)?,
        Packing::Gzip => {
            let mut encoder = GzEncoder::new(&mut file, Compression::fast());
            let conversion = write_voxels(path, &mut encoder, source)?;
            encoder.finish().map_err(&end)?;
            conversion
        }
        Packing::Zlib => {
            let mut encoder = ZlibEncoder::new(&mut file, Compression::fast());
            let conversion = write_voxels(path, &mut encoder, source)?;
            encoder.finish().map_err(&end)?;
            conversion
        }
    };
    file.flush().map_err(&end)?;
    Ok(conversion)
}

/// The name of the voxels' file beside a header: the header's with another ending.
///
/// # Errors
/// [`WriteError::Name`] where the name would mean something else in the header's text.
pub(crate) fn name_beside(header: &Path, ending: &str) -> Result<String, WriteError> {
    let stem = header.file_stem().and_then(|stem| stem.to_str());
    let plain = |stem: &&str| {
        let odd = |c: char| c.is_control() || c == '%';
        !stem.contains(odd) && stem.trim() == *stem && !stem.starts_with("LIST ")
    };
    let stem = stem.filter(plain).ok_or_else(|| WriteError::Name {
        path: header.to_owned(),
        expected: "a name of plain text without % and without spaces around it, which the header can hold",
    })?;
    Ok(format!("{stem}.{ending}"))
}

/// Gives a header and its voxels their names. A header that was there before goes first, so that no moment shows an old
/// header with new voxels; cut short in between, there is no header.
///
/// # Errors
/// [`WriteError::Io`].
pub(crate) fn rename_pair(header_path: &Path, header: Partial, voxels: Partial) -> Result<(), WriteError> {
    header.sync()?;
    voxels.sync()?;
    match std::fs::remove_file(header_path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            return Err(io(header_path, "replace the old header")(source));
        }
        _ => {}
    }
    voxels.rename()?;
    header.rename()
}
