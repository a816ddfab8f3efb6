//! Any examination to a NIfTI-1 file: i16, HU as they are, sform always and qform where it can say the same.
//!
//! The header holds f32: places are true to 1e-7 of the volume's distance from the origin, 0.00003 mm for a patient.

use std::io::{BufWriter, Write};
use std::path::Path;

use flate2::{Compression, write::GzEncoder};
use geometry::VolumeGrid;

use super::orientation::ras_forms;
use crate::partial::Partial;
use crate::source::{Conversion, VoxelSource};
use crate::write::error::{WriteError, io};
use crate::write::write_voxels;

/// The header and the four bytes that announce no extension.
const HEADER_BYTES: usize = 352;
/// Scanner coordinates; both forms mean the same.
const SCANNER: i16 = 1;

/// Writes every slice of `source` to `path`, `.nii` or `.nii.gz` by its ending, and gives what `source` changed.
///
/// The file is written under another name in the same folder and renamed when it is whole.
///
/// # Errors
/// Each variant of [`WriteError`].
pub fn write(path: &Path, source: &mut dyn VoxelSource) -> Result<Conversion, WriteError> {
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
    let gzip = name.ends_with(".nii.gz");
    if !gzip && !name.ends_with(".nii") {
        return Err(WriteError::Name {
            path: path.to_owned(),
            expected: "a name that ends in .nii or .nii.gz",
        });
    }
    let partial = Partial::create(path)?;
    let file = BufWriter::new(partial.file()?);
    let conversion = if gzip {
        let mut encoder = GzEncoder::new(file, Compression::fast());
        let conversion = write_volume(path, &mut encoder, source)?;
        let mut file = encoder.finish().map_err(io(path, "write its end"))?;
        file.flush().map_err(io(path, "write its end"))?;
        conversion
    } else {
        let mut file = file;
        let conversion = write_volume(path, &mut file, source)?;
        file.flush().map_err(io(path, "write its end"))?;
        conversion
    };
    partial.rename()?;
    Ok(conversion)
}

fn write_volume(path: &Path, out: &mut dyn Write, source: &mut dyn VoxelSource) -> Result<Conversion, WriteError> {
    let header = header(source.grid());
    out.write_all(&header).map_err(io(path, "write its header"))?;
    write_voxels(path, out, source)
}

/// A NIfTI-1 header, little-endian, in RAS and mm.
fn header(grid: &VolumeGrid) -> [u8; HEADER_BYTES] {
    let mut bytes = [0; HEADER_BYTES];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    let forms = ras_forms(&grid.ct_from_voxel(), grid.spacing_mm());
    let (quaternion, qfac) = forms.quaternion_bcd_qfac.unwrap_or(([0.0; 3], 1.0));
    put(0, &348_i32.to_le_bytes());
    put(40, &3_i16.to_le_bytes());
    put(76, &(qfac as f32).to_le_bytes());
    for (i, (dim, spacing)) in grid.dims().into_iter().zip(grid.spacing_mm()).enumerate() {
        // A checked grid has at most 16384 voxels along an axis.
        put(42 + 2 * i, &(dim as i16).to_le_bytes());
        put(80 + 4 * i, &(spacing as f32).to_le_bytes());
        put(256 + 4 * i, &(quaternion[i] as f32).to_le_bytes());
        put(268 + 4 * i, &(forms.srow[i][3] as f32).to_le_bytes());
        for (c, value) in forms.srow[i].into_iter().enumerate() {
            put(280 + 16 * i + 4 * c, &(value as f32).to_le_bytes());
        }
    }
    // Further dimensions have length 1.
    (3..7).for_each(|i| put(42 + 2 * i, &1_i16.to_le_bytes()));
    put(70, &4_i16.to_le_bytes());
    put(72, &16_i16.to_le_bytes());
    put(108, &(HEADER_BYTES as f32).to_le_bytes());
    put(112, &1.0_f32.to_le_bytes());
    // Millimetres.
    put(123, &[2]);
    let qform = if forms.quaternion_bcd_qfac.is_some() {
        SCANNER
    } else {
        0
    };
    put(252, &qform.to_le_bytes());
    put(254, &SCANNER.to_le_bytes());
    put(344, b"n+1\0");
    bytes
}
