//! What the tests of text headers share: sources, files, and comparisons.

use std::path::{Path, PathBuf};

use geometry::{Affine, Point, VolumeGrid, Voxel};

use super::{OpenOptions, RasterSource};
use crate::WriteError;
use crate::phantom_source::PhantomSource;
use crate::source::{Conversion, ReadError, Scratch, VoxelSource};
use crate::write::WriteOptions;

pub(crate) const PACKED: WriteOptions = WriteOptions { compress: true };
pub(crate) const ASSUMED: OpenOptions = OpenOptions { assume_lps: true };

/// A format with a text header: how it is written, how it is read.
pub(crate) struct Format {
    pub write: fn(&Path, &mut dyn VoxelSource, WriteOptions) -> Result<Conversion, WriteError>,
    pub open: fn(&Path, OpenOptions) -> Result<RasterSource, ReadError>,
}

impl Format {
    pub(crate) fn read(&self, path: &Path) -> Result<(Vec<i16>, Conversion), ReadError> {
        drink_both(&mut (self.open)(path, OpenOptions::default())?)
    }

    /// Reads bytes as a file of this name.
    pub(crate) fn read_bytes(&self, name: &str, bytes: &[u8]) -> Result<(Vec<i16>, Conversion), ReadError> {
        let folder = tempfile::tempdir().unwrap();
        self.read(&file(&folder, name, bytes))
    }

    /// The patient, written under each name, comes back bit for bit; so many files lie in the folder then.
    pub(crate) fn assert_the_patient_comes_back(&self, cases: &[(&str, WriteOptions, usize)]) {
        let folder = tempfile::tempdir().unwrap();
        let patient = PhantomSource::new(3, [6.0, 5.0, 8.0]).unwrap();
        let (want, _) = drink_both(&mut patient.clone()).unwrap();
        for &(name, options, files) in cases {
            let path = folder.path().join(name);
            (self.write)(&path, &mut patient.clone(), options).unwrap();
            let mut source = (self.open)(&path, OpenOptions::default()).unwrap();
            assert_eq!(source.grid(), patient.grid());
            let unchanged = (want.clone(), Conversion::default());
            assert_eq!(drink_both(&mut source).unwrap(), unchanged, "{name}");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), files, "{name}");
        }
    }

    /// A source that fails leaves the old files as they were, and no others.
    pub(crate) fn assert_a_failure_leaves_the_old(&self, names: [&str; 2]) {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = file(&folder, name, b"old");
            let mut source = given(TURNED[0]);
            source.fails_at = Some(2);
            let error = (self.write)(&path, &mut source, PACKED).unwrap_err();
            assert!(matches!(error, WriteError::Read { .. }), "{error}");
            assert_eq!(std::fs::read(&path).unwrap(), b"old");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    /// Names that cannot be written are refused, and a folder that is not there; nothing is left behind.
    pub(crate) fn assert_unwritable(&self, names: &[&str], no_folder: &str) {
        let folder = tempfile::tempdir().unwrap();
        let refused = |name: &str| {
            let path = folder.path().join(name);
            (self.write)(&path, &mut given(TURNED[0]), WriteOptions::default()).unwrap_err()
        };
        for name in names {
            assert!(matches!(refused(name), WriteError::Name { .. }), "{name}");
        }
        assert!(matches!(refused(no_folder), WriteError::Io { .. }));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

/// `lines` with the line of a field replaced, left out (where nothing follows the sign), or added so many lines before the
/// end (where it was not there).
pub(crate) fn changed(lines: &[&str], sign: char, changes: &[&str], before_end: usize) -> Vec<String> {
    let field_of = |line: &str| line.split_once(sign).map(|(field, _)| field.trim().to_owned());
    let mut lines: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
    for change in changes {
        let (field, text) = change.split_once(sign).unwrap();
        let place = lines
            .iter()
            .position(|line| field_of(line).as_deref() == Some(field.trim()));
        match (place, text.is_empty()) {
            (Some(at), true) => drop(lines.remove(at)),
            (Some(at), false) => (*change).clone_into(&mut lines[at]),
            (None, _) => lines.insert(lines.len() - before_end, (*change).to_owned()),
        }
    }
    lines
}

/// The voxels 0 to 11.
pub(crate) fn counted() -> Vec<u8> {
    (0..12_i16).flat_map(i16::to_le_bytes).collect()
}

/// Voxels 0, 1, 2 and so on, less 7 a slice, on any grid; it can fail at a slice.
pub(crate) struct Given {
    pub grid: VolumeGrid,
    pub fails_at: Option<u32>,
}

pub(crate) fn given(rows: [[f64; 4]; 3]) -> Given {
    let grid = VolumeGrid::checked([5, 4, 3], Affine::from_rows(rows)).unwrap();
    Given { grid, fails_at: None }
}

impl VoxelSource for Given {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        0
    }
    fn describe(&self) -> String {
        "given".to_owned()
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        if self.fails_at == Some(k) {
            return Err(ReadError::Order {
                expected: 0,
                found: k,
                count: 0,
            });
        }
        (0..).zip(out).for_each(|(i, v)| *v = i - 700 * k as i16);
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(Conversion::default())
    }
}

/// Grids of every sort: turned, mirrored, with swapped axes; odd numbers throughout.
pub(crate) const TURNED: [[[f64; 4]; 3]; 4] = [
    [
        [0.8 * 0.7, -0.6 * 0.3, 0.0, -120.512_345_678_901],
        [0.6 * 0.7, 0.8 * 0.3, 0.0, 1.0 / 3.0],
        [0.0, 0.0, 1.1, 700.1],
    ],
    [
        [0.8 * 2.0, 0.6 * 3.0, 0.0, 1e-7],
        [0.6 * 2.0, -0.8 * 3.0, 0.0, 2.0],
        [0.0, 0.0, 4.0, 3.0],
    ],
    [[0.0, 0.0, -4.1, 1.0], [-2.3, 0.0, 0.0, 2.0], [0.0, 3.7, 0.0, 3.0]],
    [[-2.0, 0.0, 0.0, 0.0], [0.0, -3.0, 0.0, 0.0], [0.0, 0.0, -4.0, 0.0]],
];
/// A tilted gantry.
pub(crate) const SHEARED: [[f64; 4]; 3] = [[0.7, 0.0, 0.0, 9.3], [0.0, 0.7, 0.3, -4.0], [0.0, 0.0, 1.3, 0.1]];

pub(crate) fn file(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn zlib(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn slice_voxels(source: &dyn VoxelSource) -> usize {
    let [nx, ny, _] = source.grid().dims();
    nx as usize * ny as usize
}

/// Every slice, then the end.
pub(crate) fn drink(source: &mut dyn VoxelSource) -> Result<(Vec<i16>, Conversion), ReadError> {
    let slice = slice_voxels(source);
    let mut voxels = Vec::new();
    for k in 0..source.grid().dims()[2] {
        voxels.resize(voxels.len() + slice, 0);
        source.read_slice(k, &mut voxels[slice * k as usize..])?;
    }
    Ok((voxels, source.finish()?))
}

/// Every slice where it lies, the last one first.
pub(crate) fn pick(source: &dyn VoxelSource) -> Option<Result<(Vec<i16>, Conversion), ReadError>> {
    let slices = source.slices()?;
    let (slice, count) = (slice_voxels(source), source.grid().dims()[2]);
    let mut voxels = vec![0; slice * count as usize];
    let (mut conversion, mut scratch) = (Conversion::default(), Scratch::default());
    for k in (0..count).rev() {
        let out = &mut voxels[slice * k as usize..][..slice];
        match slices.read(k, out, &mut scratch) {
            Ok(more) => conversion += more,
            Err(error) => return Some(Err(error)),
        }
    }
    Some(Ok((voxels, conversion)))
}

/// Reads in order, and where it lies if that can be: the same both ways.
pub(crate) fn drink_both(source: &mut dyn VoxelSource) -> Result<(Vec<i16>, Conversion), ReadError> {
    let picked = pick(source);
    let drunk = drink(source)?;
    if let Some(picked) = picked {
        assert_eq!(picked.unwrap(), drunk);
    }
    Ok(drunk)
}

/// The corners of `a` and `b` lie within `tolerance` of each other, relative to their distance from the origin.
pub(crate) fn assert_same_place(a: &VolumeGrid, b: &VolumeGrid, tolerance: f64) {
    assert_eq!(a.dims(), b.dims());
    let [nx, ny, nz] = a.dims().map(f64::from);
    for corner in [[0.0; 3], [nx, 0.0, 0.0], [0.0, ny, 0.0], [0.0, 0.0, nz], [nx, ny, nz]] {
        let voxel = Point::<Voxel>::new(corner[0], corner[1], corner[2]);
        let (ours, theirs) = (a.ct_from_voxel() * voxel, b.ct_from_voxel() * voxel);
        let size = 1.0 + theirs.distance(Point::new(0.0, 0.0, 0.0));
        let apart = ours.distance(theirs);
        assert!(apart <= tolerance * size, "{apart} mm at {voxel:?}");
    }
}

/// A file below the folder of shared data; `None`, said aloud, where it is not there.
pub(crate) fn shared_file(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("TROCAR_SHARED").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let path = folder.join(name);
    if !path.is_file() {
        println!(
            "skipped: {} is not there; TROCAR_SHARED names the folder that holds data/",
            path.display()
        );
        return None;
    }
    Some(path)
}

/// Cuts `bytes` at every length and hands each to `open`, which must refuse all of them.
pub(crate) fn every_truncation(bytes: &[u8], open: impl Fn(&[u8]) -> bool) {
    for length in 0..bytes.len() {
        assert!(
            !open(&bytes[..length]),
            "accepted with {length} of {} bytes",
            bytes.len()
        );
    }
}

/// Flips bits of every byte in turn; whatever is told of it, nothing panics.
pub(crate) fn every_flip(bytes: &[u8], open: impl Fn(&[u8])) {
    for at in 0..bytes.len() {
        for bits in [0x01, 0x10, 0x80, 0xff] {
            let mut damaged = bytes.to_vec();
            damaged[at] ^= bits;
            open(&damaged);
        }
    }
}
