//! A slice in HU as a MetaImage, for comparison with other software.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use geometry::SlicePlane;

/// Why a MetaImage was not written.
#[derive(Debug, thiserror::Error)]
#[error("writing {path}: {source}. Nothing was left under that name; check that the folder exists and has space")]
pub struct MhaError {
    /// The file.
    path: PathBuf,
    /// Why.
    source: io::Error,
}

/// Writes `hu` (row by row) as a float32 MetaImage of width x height x 1 voxels with origin, spacing and direction in
/// LPS mm, as ITK reads it. Whole or absent.
///
/// # Errors
/// [`MhaError`].
pub fn write_mha(path: &Path, plane: &SlicePlane, hu: &[f32]) -> Result<(), MhaError> {
    let part = path.with_extension("mha.part");
    let written = write_part(&part, plane, hu).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        let _ = fs::remove_file(&part);
        MhaError {
            path: path.to_owned(),
            source,
        }
    })
}

fn write_part(path: &Path, plane: &SlicePlane, hu: &[f32]) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(header(plane).as_bytes())?;
    for value in hu {
        file.write_all(&value.to_le_bytes())?;
    }
    file.into_inner()?.sync_all()
}

fn header(plane: &SlicePlane) -> String {
    let [width, height] = plane.size();
    let join = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    // ITK reads one axis after the other: right, down, into the screen.
    let axes = [plane.right(), plane.down(), plane.into_screen()].map(|d| d.components());
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n\
         TransformMatrix = {}\nOffset = {}\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = RAI\n\
         ElementSpacing = {}\nDimSize = {width} {height} 1\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n",
        join(axes.as_flattened()),
        join(&plane.origin().mm()),
        join(&[plane.pixel_mm(); 3]),
    )
}
