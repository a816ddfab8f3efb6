//! A segmentation as the voxels of a label map.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use geometry::VolumeGrid;

use super::error::SegmentationError;
use super::lattice::{Lattice, LatticeError};
use super::object::{Cells, Object, Refused};
use crate::dicom::Reference;
use crate::dicom::error::DicomError;
use crate::dicom::geometry::GeometryError;
use crate::load::origin::error::OriginError;
use crate::source::{Conversion, Facts, Place, ReadError, Turn, VoxelSource};

/// One segmentation, read plane by plane; voxels are SegmentNumbers, 0 for none.
#[derive(Debug)]
pub(crate) struct SegmentationSource {
    path: PathBuf,
    file: File,
    object: Object,
    lattice: Lattice,
    /// What is doubtful about whose it is.
    told: Vec<String>,
    turn: Turn,
    /// Voxels of each segment so far.
    voxels: BTreeMap<i16, u64>,
    bytes: Vec<u8>,
}

impl SegmentationSource {
    /// Opens and judges a file; `None` where it is no segmentation of DICOM.
    ///
    /// # Errors
    /// [`ReadError::Dicom`], [`ReadError::Segmentation`].
    pub(crate) fn open(path: &Path) -> Result<Option<Self>, ReadError> {
        let Some(object) = Object::read(path)? else {
            return Ok(None);
        };
        let lattice = Lattice::of(&object).map_err(|error| refused(path, error))?;
        check_twice(&object, &lattice).map_err(|error| Refused::from(error).of(path))?;
        let (file, _) = scene::file::open(path).map_err(|error| unreadable(path, Place::Header, 0, error.into()))?;
        Ok(Some(Self {
            path: path.to_owned(),
            file,
            lattice,
            told: Vec::new(),
            turn: Turn::default(),
            voxels: object.segments.iter().map(|(segment, _)| (*segment, 0)).collect(),
            object,
            bytes: Vec::new(),
        }))
    }

    /// The frame of reference of its places; never shown.
    pub(crate) fn frame_of_reference(&self) -> &str {
        &self.object.frame_of_reference
    }

    /// Holds it against the examination that it is to be of: what is doubtful, which [`VoxelSource::facts`] tells from then on too.
    ///
    /// # Errors
    /// [`OriginError`].
    pub(crate) fn check_origin(&mut self, examination: &Reference) -> Result<Vec<String>, OriginError> {
        self.told = self.object.origin.check(examination)?;
        Ok(self.told.clone())
    }

    /// The segments with their names, in the order of the file.
    pub(crate) fn segments(&self) -> &[(i16, String)] {
        &self.object.segments
    }

    /// Puts the voxels of a frame into the plane.
    fn take(&mut self, k: u32, frame: usize, out: &mut [i16]) -> Result<(), ReadError> {
        let bits = match self.object.cells {
            Cells::Bits => 1,
            Cells::Parts(_) => 8,
            Cells::Labels(bytes) => 8 * bytes as u64,
        };
        let first_bit = frame as u64 * self.object.frame_pixels() * bits;
        let last_byte = (first_bit + self.object.frame_pixels() * bits).div_ceil(8);
        let first_byte = first_bit / 8;
        self.bytes.resize((last_byte - first_byte) as usize, 0);
        let at = self.object.pixels.value_at + first_byte;
        self.file
            .read_exact_at(&mut self.bytes, at)
            .map_err(|source| unreadable(&self.path, Place::Slice(k), at, source))?;
        let claims = Claims {
            frame: frame as u32 + 1,
            columns: usize::from(self.object.columns),
            segment: self.object.frames.get(frame).and_then(|frame| frame.segment),
        };
        let put = match self.object.cells {
            Cells::Bits => {
                // Frames go on within a byte, the lowest bit first (PS3.5 section 8.1.1).
                let (skip, bytes) = ((first_bit % 8) as usize, &self.bytes);
                claims.put(out, |i| {
                    let bit = skip + i;
                    Ok(claims.of_segment((bytes[bit / 8] >> (bit % 8)) & 1 == 1))
                })
            }
            Cells::Parts(most) => claims.put(out, |i| claims.of_part(u16::from(self.bytes[i]), most)),
            Cells::Labels(1) => claims.put(out, |i| claims.of_label(u16::from(self.bytes[i]), &self.voxels)),
            Cells::Labels(_) => claims.put(out, |i| {
                let label = u16::from_le_bytes([self.bytes[2 * i], self.bytes[2 * i + 1]]);
                claims.of_label(label, &self.voxels)
            }),
        };
        put.map_err(|error| Refused::from(error).of(&self.path))
    }
}

/// What a frame claims of a plane.
#[derive(Debug, Clone, Copy)]
struct Claims {
    frame: u32,
    columns: usize,
    segment: Option<i16>,
}

impl Claims {
    /// Puts the label of each voxel that is claimed; `label(i)` is 0 for one that is not.
    fn put(
        &self,
        out: &mut [i16],
        label: impl Fn(usize) -> Result<i16, SegmentationError>,
    ) -> Result<(), SegmentationError> {
        for (i, voxel) in out.iter_mut().enumerate() {
            match label(i)? {
                0 => {}
                second if *voxel != 0 => {
                    return Err(SegmentationError::Overlap {
                        first: *voxel,
                        second,
                        frame: self.frame,
                        column: i % self.columns,
                        row: i / self.columns,
                    });
                }
                label => *voxel = label,
            }
        }
        Ok(())
    }

    fn of_segment(&self, is_in: bool) -> i16 {
        if is_in { self.segment.unwrap_or(0) } else { 0 }
    }

    fn of_part(&self, found: u16, most: u16) -> Result<i16, SegmentationError> {
        match found {
            0 => Ok(0),
            found if found == most => Ok(self.of_segment(true)),
            found => Err(SegmentationError::Partly {
                frame: self.frame,
                found,
                most,
            }),
        }
    }

    fn of_label(&self, found: u16, described: &BTreeMap<i16, u64>) -> Result<i16, SegmentationError> {
        let label = i16::try_from(found).ok();
        let known = label.filter(|label| *label == 0 || described.contains_key(label));
        known.ok_or(SegmentationError::Unknown {
            frame: self.frame,
            found,
        })
    }
}

/// No two frames of one segment, or of a map of labels, lie in one plane.
fn check_twice(object: &Object, lattice: &Lattice) -> Result<(), SegmentationError> {
    for plane in &lattice.frames {
        let mut seen = BTreeMap::new();
        for &frame in plane {
            let segment = object.frames.get(frame).and_then(|frame| frame.segment);
            if let Some(first) = seen.insert(segment, frame) {
                return Err(SegmentationError::Twice {
                    first: first as u32 + 1,
                    second: frame as u32 + 1,
                    segment: segment.unwrap_or(0),
                });
            }
        }
    }
    Ok(())
}

fn refused(path: &Path, error: LatticeError) -> ReadError {
    let (path, number) = (path.to_owned(), 1);
    match error {
        LatticeError::Geometry(GeometryError::Corner { found_mm, .. }) => {
            let source = SegmentationError::Beside { found_mm };
            ReadError::Segmentation { path, source }
        }
        LatticeError::Geometry(GeometryError::Duplicates { .. }) => {
            let source = SegmentationError::Nearly;
            ReadError::Segmentation { path, source }
        }
        LatticeError::Geometry(source) => DicomError::Geometry {
            path,
            number,
            source,
            two: None,
        }
        .into(),
        LatticeError::Grid(source) => DicomError::Grid { path, number, source }.into(),
        LatticeError::Step(source) => ReadError::Segmentation { path, source },
        LatticeError::Element(source) => DicomError::File { path, source }.into(),
    }
}

fn unreadable(path: &Path, place: Place, byte: u64, source: std::io::Error) -> ReadError {
    ReadError::Unreadable {
        path: path.to_owned(),
        place,
        byte,
        source,
    }
}

impl VoxelSource for SegmentationSource {
    fn grid(&self) -> &VolumeGrid {
        &self.lattice.grid
    }

    fn padding_hu(&self) -> i16 {
        0
    }

    fn describe(&self) -> String {
        let ([nx, ny, nz], [sx, sy, sz]) = (self.lattice.grid.dims(), self.lattice.grid.spacing_mm());
        let kind = match self.object.cells {
            Cells::Bits => "BINARY",
            Cells::Parts(_) => "FRACTIONAL, of which all voxels are whole",
            Cells::Labels(_) => "LABELMAP",
        };
        format!(
            "{}: DICOM segmentation, {kind}, {} segments in {} frames, {nx} x {ny} x {nz} voxels of {sx:.3} x {sy:.3} x {sz:.3} mm, no \
             frame farther than {:.3} mm from there",
            self.path.display(),
            self.object.segments.len(),
            self.object.frames.len(),
            self.lattice.worst_corner_mm
        )
    }

    fn facts(&self) -> Facts {
        let planes = self.lattice.frames.iter().filter(|frames| frames.is_empty()).count();
        let mut warnings = self.told.clone();
        if planes > 0 {
            warnings.push(format!(
                "{planes} of its {} planes have no frame, and count as planes without a structure",
                self.lattice.frames.len()
            ));
        }
        Facts {
            warnings,
            ..Facts::default()
        }
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.lattice.grid, k, out)?;
        out.fill(0);
        let frames = self.lattice.frames.get(k as usize).cloned().unwrap_or_default();
        for frame in frames {
            self.take(k, frame, out)?;
        }
        for label in out.iter().filter(|label| **label != 0) {
            *self.voxels.entry(*label).or_insert(0) += 1;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.lattice.grid)?;
        let is_empty = |(segment, _): &&(i16, String)| self.voxels.get(segment) == Some(&0);
        match self.object.segments.iter().find(is_empty).cloned() {
            Some((segment, name)) => Err(Refused::from(SegmentationError::Empty { segment, name }).of(&self.path)),
            None => Ok(Conversion::default()),
        }
    }
}
