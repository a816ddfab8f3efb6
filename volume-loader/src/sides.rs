//! The patient's sides in every format: whatever the signs and the order of a grid's axes, each voxel stays at its place.

use std::collections::BTreeMap;
use std::path::Path;

use geometry::{Affine, Point, Vector, VolumeGrid, Voxel};
use scene::VolumeSpec;

use crate::raster::test_files::{drink, file};
use crate::source::{Conversion, ReadError, VoxelSource};
use crate::write::WriteOptions;
use crate::{dicom_out, load, metaimage, nifti, nrrd};

/// Voxels of the patient along left, posterior and superior, and the distances between them, mm.
const SIZE: [usize; 3] = [5, 4, 3];
const STEP_MM: [f64; 3] = [0.75, 1.25, 2.5];
const FIRST_MM: [f64; 3] = [-61.5, -100.25, 700.125];
/// The liver: on the right, at the front, below. LPS: the right is where x is small.
const LIVER: [usize; 3] = [0, 0, 0];
const LIVER_HU: i16 = 60;

/// HU at a place of the patient, each another one, so that no mirror and no exchange of axes gives the same.
fn hu([x, y, z]: [usize; 3]) -> i16 {
    match [x, y, z] {
        LIVER => LIVER_HU,
        _ => (100 + x + 10 * y + 100 * z) as i16,
    }
}

fn place([x, y, z]: [usize; 3]) -> [f64; 3] {
    let at = [x, y, z];
    std::array::from_fn(|i| FIRST_MM[i] + at[i] as f64 * STEP_MM[i])
}

/// The same patient on a grid whose axis `a` runs along the patient's axis `order[a]`, backwards where that is asked for.
#[derive(Debug, Clone, Copy)]
struct Axes {
    order: [usize; 3],
    back: [bool; 3],
}

fn all_axes() -> Vec<Axes> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let signs = (0..8).map(|bits| [bits & 1 > 0, bits & 2 > 0, bits & 4 > 0]);
    let pairs = orders
        .into_iter()
        .flat_map(|order| signs.clone().map(move |back| (order, back)));
    pairs.map(|(order, back)| Axes { order, back }).collect()
}

impl Axes {
    fn dims(&self) -> [usize; 3] {
        self.order.map(|axis| SIZE[axis])
    }

    /// The place in the patient of a voxel.
    fn patient(&self, voxel: [usize; 3]) -> [usize; 3] {
        let mut at = [0; 3];
        for ((axis, back), index) in self.order.into_iter().zip(self.back).zip(voxel) {
            at[axis] = if back { SIZE[axis] - 1 - index } else { index };
        }
        at
    }

    fn origin(&self) -> [f64; 3] {
        place(self.patient([0; 3]))
    }

    /// One voxel along axis `a`, mm LPS.
    fn step(&self, a: usize) -> [f64; 3] {
        let mut step = [0.0; 3];
        step[self.order[a]] = if self.back[a] { -1.0 } else { 1.0 } * STEP_MM[self.order[a]];
        step
    }

    /// In the order of a file, x fastest.
    fn voxels(&self) -> Vec<i16> {
        let [nx, ny, nz] = self.dims();
        let voxel = |at: usize| hu(self.patient([at % nx, at / nx % ny, at / nx / ny]));
        (0..nx * ny * nz).map(voxel).collect()
    }

    fn source(&self) -> Planted {
        let [x, y, z] = self.origin();
        let steps = [0, 1, 2].map(|a| {
            let [x, y, z] = self.step(a);
            Vector::new(x, y, z)
        });
        let map = Affine::from_steps(Point::new(x, y, z), steps);
        Planted {
            grid: VolumeGrid::checked(self.dims().map(|n| n as i64), map).unwrap(),
            voxels: self.voxels(),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        self.voxels().iter().flat_map(|hu| hu.to_le_bytes()).collect()
    }
}

struct Planted {
    grid: VolumeGrid,
    voxels: Vec<i16>,
}

impl VoxelSource for Planted {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        -1024
    }
    fn describe(&self) -> String {
        "planted".to_owned()
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        let start = out.len() * k as usize;
        out.copy_from_slice(&self.voxels[start..start + out.len()]);
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(Conversion::default())
    }
}

/// Every voxel at its place in the patient. Places are multiples of 1/8 mm below 1024 mm: exact in every format.
fn hold(source: &mut dyn VoxelSource, what: &str) {
    let (grid, voxels) = (*source.grid(), drink(source).unwrap().0);
    let [nx, ny, _] = grid.dims().map(|n| n as usize);
    let micrometres = |mm: [f64; 3]| mm.map(|v| (v * 1e3).round() as i64);
    let mut found = BTreeMap::new();
    for (at, hu) in voxels.into_iter().enumerate() {
        let [i, j, k] = [at % nx, at / nx % ny, at / nx / ny].map(|index| index as f64);
        found.insert(
            micrometres((grid.ct_from_voxel() * Point::<Voxel>::new(i, j, k)).mm()),
            hu,
        );
    }
    let mut want = BTreeMap::new();
    for at in 0..SIZE.iter().product() {
        let at = [at % SIZE[0], at / SIZE[0] % SIZE[1], at / SIZE[0] / SIZE[1]];
        want.insert(micrometres(place(at)), hu(at));
    }
    assert_eq!(found, want, "{what}");
    let (&liver, _) = found.iter().find(|(_, hu)| **hu == LIVER_HU).unwrap();
    let middle = grid.centre().mm();
    assert!((liver[0] as f64) < 1e3 * middle[0], "{what}: the liver is on the right");
}

fn read(path: &Path) -> Box<dyn VoxelSource> {
    load::open(&VolumeSpec::of_path(path.to_owned()), 0).unwrap()
}

#[derive(Debug, Clone, Copy)]
enum Format {
    Nifti,
    Nrrd,
    MetaImage,
    Dicom,
}

const FORMATS: [(Format, &str); 4] = [
    (Format::Nifti, "nii"),
    (Format::Nrrd, "nrrd"),
    (Format::MetaImage, "mha"),
    (Format::Dicom, ""),
];

fn write(format: Format, path: &Path, source: &mut dyn VoxelSource) {
    match format {
        Format::Nifti => nifti::write(path, source).map(|_| ()).unwrap(),
        Format::Nrrd => nrrd::write(path, source, WriteOptions::default()).map(|_| ()).unwrap(),
        Format::MetaImage => metaimage::write(path, source, WriteOptions::default())
            .map(|_| ())
            .unwrap(),
        Format::Dicom => dicom_out::write(path, source, &dicom_out::Options::default())
            .map(|_| ())
            .unwrap(),
    }
}

#[test]
fn the_liver_stays_on_the_right_through_every_writer_and_reader() {
    for axes in all_axes() {
        let folder = tempfile::tempdir().unwrap();
        for (first, ending) in FORMATS {
            let path = folder.path().join(format!("{first:?}.{ending}"));
            write(first, &path, &mut axes.source());
            hold(read(&path).as_mut(), &format!("{axes:?} as {first:?}"));
            for (then, ending) in FORMATS {
                let next = folder.path().join(format!("{first:?}-{then:?}.{ending}"));
                write(then, &next, read(&path).as_mut());
                hold(
                    read(&next).as_mut(),
                    &format!("{axes:?} as {first:?} and then {then:?}"),
                );
            }
        }
    }
}

#[test]
fn the_liver_is_on_the_right_in_nrrd_headers_of_every_space_and_sign() {
    let spaces = [
        ("left-posterior-superior", [1.0, 1.0, 1.0]),
        ("right-anterior-superior", [-1.0, -1.0, 1.0]),
        ("left-anterior-superior", [1.0, -1.0, 1.0]),
    ];
    for axes in all_axes() {
        for (space, signs) in spaces {
            let vector = |lps: [f64; 3]| {
                let [x, y, z]: [f64; 3] = std::array::from_fn(|i| signs[i] * lps[i]);
                format!("({x},{y},{z})")
            };
            let [a, b, c] = [0, 1, 2].map(|axis| vector(axes.step(axis)));
            let [nx, ny, nz] = axes.dims();
            let head = format!(
                "NRRD0004\ntype: short\ndimension: 3\nspace: {space}\nsizes: {nx} {ny} {nz}\nspace directions: {a} {b} {c}\n\
                 endian: little\nencoding: raw\nspace origin: {}\n\n",
                vector(axes.origin())
            );
            let folder = tempfile::tempdir().unwrap();
            let path = file(&folder, "a.nrrd", &[head.as_bytes(), &axes.bytes()].concat());
            hold(read(&path).as_mut(), &format!("{axes:?} in {space}"));
        }
    }
}

#[test]
fn the_liver_is_on_the_right_in_metaimage_headers_of_every_sign() {
    for axes in all_axes() {
        let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let spacing = axes.order.map(|axis| STEP_MM[axis]);
        let matrix: Vec<f64> = (0..3).flat_map(|a| axes.step(a).map(|v| v / spacing[a])).collect();
        let [nx, ny, nz] = axes.dims();
        let head = format!(
            "NDims = 3\nBinaryDataByteOrderMSB = False\nTransformMatrix = {}\nOffset = {}\nElementSpacing = {}\nDimSize = {nx} {ny} \
             {nz}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n",
            words(&matrix),
            words(&axes.origin()),
            words(&spacing)
        );
        let folder = tempfile::tempdir().unwrap();
        let path = file(&folder, "a.mha", &[head.as_bytes(), &axes.bytes()].concat());
        hold(read(&path).as_mut(), &format!("{axes:?}"));
    }
}

/// A NIfTI-1 header in RAS, by sform alone or by qform alone.
fn nifti_head(axes: &Axes, by_sform: bool) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    put(0, &348_i32.to_le_bytes());
    put(40, &3_i16.to_le_bytes());
    put(70, &4_i16.to_le_bytes());
    put(72, &16_i16.to_le_bytes());
    put(108, &352_f32.to_le_bytes());
    put(123, &[2]);
    put(344, b"n+1\0");
    let ras = |[x, y, z]: [f64; 3]| [-x, -y, z];
    let steps = [0, 1, 2].map(|a| ras(axes.step(a)));
    let origin = ras(axes.origin());
    for a in 0..3 {
        put(42 + 2 * a, &(axes.dims()[a] as i16).to_le_bytes());
        put(80 + 4 * a, &(STEP_MM[axes.order[a]] as f32).to_le_bytes());
        let row = [steps[0][a], steps[1][a], steps[2][a], origin[a]];
        for (c, value) in row.into_iter().enumerate() {
            put(280 + 16 * a + 4 * c, &(value as f32).to_le_bytes());
        }
        put(268 + 4 * a, &(origin[a] as f32).to_le_bytes());
    }
    (3..7).for_each(|a| put(42 + 2 * a, &1_i16.to_le_bytes()));
    put(if by_sform { 254 } else { 252 }, &1_i16.to_le_bytes());
    if !by_sform {
        let (quaternion, qfac) = quaternion(steps);
        put(76, &(qfac as f32).to_le_bytes());
        (0..3).for_each(|i| put(256 + 4 * i, &(quaternion[i + 1] as f32).to_le_bytes()));
    }
    bytes
}

/// The quaternion a, b, c, d (a >= 0) and qfac of these steps, found by trying: of the 24 rotations of a cube, each is one of these.
fn quaternion(steps: [[f64; 3]; 3]) -> ([f64; 4], f64) {
    let h = 0.5_f64.sqrt();
    let mut tried = Vec::new();
    for bits in 0..81 {
        let signs: [i32; 4] = std::array::from_fn(|i| bits / 3_i32.pow(i as u32) % 3 - 1);
        let size = match signs.iter().filter(|sign| **sign != 0).count() {
            1 => 1.0,
            2 => h,
            4 => 0.5,
            _ => continue,
        };
        tried.push(signs.map(|sign| f64::from(sign) * size));
    }
    for q in tried.into_iter().filter(|q| q[0] >= 0.0) {
        for qfac in [1.0, -1.0] {
            let turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, qfac]].map(|v| turn(q, v));
            let same = |a: usize| {
                let length = steps[a].iter().map(|v| v * v).sum::<f64>().sqrt();
                (0..3).all(|i| (turned[a][i] - steps[a][i] / length).abs() < 1e-6)
            };
            if (0..3).all(same) {
                return (q, qfac);
            }
        }
    }
    panic!("no rotation of a cube gives {steps:?}");
}

/// `q v q*`, product by product.
fn turn([a, b, c, d]: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let product = |p: [f64; 4], q: [f64; 4]| {
        [
            p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
            p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
            p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
        ]
    };
    let [_, x, y, z] = product(product([a, b, c, d], [0.0, x, y, z]), [a, -b, -c, -d]);
    [x, y, z]
}

#[test]
fn the_liver_is_on_the_right_in_nifti_headers_of_every_sign_by_sform_and_by_qform() {
    for axes in all_axes() {
        for by_sform in [true, false] {
            let folder = tempfile::tempdir().unwrap();
            let bytes = [nifti_head(&axes, by_sform), axes.bytes()].concat();
            let path = file(&folder, "a.nii", &bytes);
            hold(read(&path).as_mut(), &format!("{axes:?}, sform {by_sform}"));
        }
    }
}
