//! Slice after slice into its file, and the identifiers at the end.

use std::fs::{self, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use bus::volume::{Hasher, SliceHash};
use dicom_dictionary_std::uids;
use dicom_object::FileMetaTableBuilder;

use super::error::{ExportError, io};
use super::folder::Partial;
use super::header::Series;
use super::numbering::Numbering;
use super::placement::Placement;
use super::uid::{Identifiers, Which, stand_ins};
use super::{Options, Syntax};
use crate::source::{Conversion, VoxelSource};

/// Writes every slice of `source` as a file of `folder`, which must be absent or empty, and gives what `source` changed.
///
/// Files are `IM0001.dcm` and on, in the order of slices, whose instance numbers are the same (unless
/// [`Options::shuffle_names`]). Positions are true to 1e-6 mm. One slice is held in memory. The folder is written under
/// another name beside its own and renamed when it is whole.
///
/// # Errors
/// Each variant of [`ExportError`].
pub fn write(folder: &Path, source: &mut dyn VoxelSource, options: &Options) -> Result<Conversion, ExportError> {
    let grid = *source.grid();
    let [columns, rows, count] = grid.dims();
    let partial = Partial::create(folder)?;
    let series = Series {
        placement: Placement::new(&grid, folder)?,
        // A checked grid has at most 16384 voxels along an axis.
        size: [columns as u16, rows as u16],
        padding_hu: source.padding_hu(),
        marks: source.marks().words(),
        syntax: options.syntax,
    };
    let writing = Writing {
        folder,
        partial: partial.path(),
        series,
        numbering: Numbering::new(count, options.shuffle_names),
    };
    let mut hasher = Hasher::new(&grid, source.padding_hu());
    let mut files = Vec::with_capacity(count as usize);
    let mut slice = vec![0; columns as usize * rows as usize];
    let read = |source| ExportError::Read {
        path: folder.to_owned(),
        source,
    };
    for k in 0..count {
        source.read_slice(k, &mut slice).map_err(read)?;
        hasher.update(SliceHash::of(&slice));
        files.push(writing.write_slice(k, &slice)?);
    }
    let conversion = source.finish().map_err(read)?;
    let identifiers = Identifiers::new(hasher.finish(), options.shuffle_names);
    for file in &files {
        file.identify(&identifiers)?;
    }
    partial.rename()?;
    Ok(conversion)
}

/// A series on its way to the disk.
struct Writing<'a> {
    /// Where it will be: for errors.
    folder: &'a Path,
    /// Where it is.
    partial: &'a Path,
    series: Series,
    numbering: Numbering,
}

impl Writing<'_> {
    fn write_slice(&self, k: u32, slice: &[i16]) -> Result<Written, ExportError> {
        let failed = |detail: String| ExportError::Encode {
            path: self.folder.to_owned(),
            slice: k,
            detail,
        };
        let (bytes, voxel_bytes) = self.encode(k, slice).map_err(|error| failed(error.to_string()))?;
        let header = &bytes[..bytes.len().saturating_sub(voxel_bytes)];
        let stand_ins = stand_ins(header).ok_or_else(|| failed("its identifiers have no place".to_owned()))?;
        let path = self.partial.join(self.numbering.file_name(k));
        fs::write(&path, &bytes).map_err(io(self.folder, "write a slice's file in it"))?;
        Ok(Written { path, k, stand_ins })
    }

    /// The whole file, and how many bytes at its end are voxels.
    fn encode(&self, k: u32, slice: &[i16]) -> Result<(Vec<u8>, usize), Box<dyn std::error::Error>> {
        let mut object = self.series.slice(k, self.numbering.instance(k));
        let voxel_bytes = self.series.put_voxels(&mut object, slice);
        let meta = FileMetaTableBuilder::new().transfer_syntax(uid(self.series.syntax));
        let file = object.with_meta(meta)?;
        let mut bytes = Vec::with_capacity(voxel_bytes + (1 << 13));
        file.write_all(&mut bytes)?;
        Ok((bytes, voxel_bytes))
    }
}

fn uid(syntax: Syntax) -> &'static str {
    match syntax {
        Syntax::ExplicitLittle => uids::EXPLICIT_VR_LITTLE_ENDIAN,
        Syntax::ImplicitLittle => uids::IMPLICIT_VR_LITTLE_ENDIAN,
        // Retired, and therefore deprecated by name in the dictionary.
        Syntax::ExplicitBig => "1.2.840.10008.1.2.2",
        Syntax::Rle => uids::RLE_LOSSLESS,
    }
}

/// A file with stand-ins for its identifiers.
struct Written {
    path: PathBuf,
    k: u32,
    stand_ins: Vec<(u64, Which)>,
}

impl Written {
    fn identify(&self, identifiers: &Identifiers) -> Result<(), ExportError> {
        let failed = io(&self.path, "write its identifiers");
        let mut file = OpenOptions::new().write(true).open(&self.path).map_err(&failed)?;
        for &(at, which) in &self.stand_ins {
            file.seek(SeekFrom::Start(at)).map_err(&failed)?;
            file.write_all(identifiers.get(which, self.k).as_bytes())
                .map_err(&failed)?;
        }
        Ok(())
    }
}
