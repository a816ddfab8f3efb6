//! Single slices from the command line: every pixel's HU, which side is which, and the same by other software.

#![allow(clippy::print_stdout, reason = "measured differences, and why a test was skipped")]
#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use std::array::from_fn;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::{fs, process::Command};

use crate::support::nifti::Nifti;
use crate::support::*;
use geometry::Point;
use phantom::Phantom;

/// What the fast back end states for trilinear values of voxels up to 4096 HU: seven f32 roundings.
const FAST_HU: f64 = 7.0 * 4096.0 * f32::EPSILON as f64;
/// Quaternions of a tool along the body, and of one that points to (0.9216, 0.2688, -0.28).
const ALONG: &str = "1,0,0,0";
const OBLIQUE: &str = "0.36,0.48,0.64,0.48";
/// A view, and where its columns and rows grow to for the oblique tool, LPS.
type View = (&'static str, [f64; 3], [f64; 3]);
const VIEWS: [View; 4] = [
    ("axial", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
    ("frontal", [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
    ("sagittal", [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]),
    ("perpendicular", [0.28, -0.96, 0.0], [-0.2688, -0.0784, -0.96]),
];

/// A slice as its MetaImage tells it.
struct Slice {
    size: [usize; 2],
    origin: [f64; 3],
    /// One column, and one row, mm.
    steps: [[f64; 3]; 2],
    hu: Vec<f32>,
}

impl Slice {
    fn read(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let (header, _) = text.split_once("ElementDataFile = LOCAL\n").unwrap();
        let fields = header.lines().filter_map(|line| line.split_once(" = "));
        let fields: HashMap<_, _> = fields.collect();
        assert_eq!(fields["ElementType"], "MET_FLOAT");
        let number = |name: &str, i| fields[name].split(' ').nth(i).unwrap().parse::<f64>().unwrap();
        let size = from_fn(|i| number("DimSize", i) as usize);
        let step = |axis, i| number("TransformMatrix", 3 * axis + i) * number("ElementSpacing", axis);
        let (voxels, rest) = bytes[bytes.len() - 4 * size[0] * size[1]..].as_chunks();
        assert!(rest.is_empty());
        Self {
            size,
            origin: from_fn(|i| number("Offset", i)),
            steps: from_fn(|axis| from_fn(|i| step(axis, i))),
            hu: voxels.iter().map(|raw| f32::from_le_bytes(*raw)).collect(),
        }
    }

    /// Where a pixel lies in the patient, mm.
    fn point(&self, column: f64, row: f64) -> [f64; 3] {
        from_fn(|i| self.origin[i] + self.steps[0][i] * column + self.steps[1][i] * row)
    }

    /// Every pixel's place and HU.
    fn pixels(&self) -> impl Iterator<Item = ([f64; 3], f64)> {
        let place = |at| self.point((at % self.size[0]) as f64, (at / self.size[0]) as f64);
        let hu = self.hu.iter().map(|hu| f64::from(*hu));
        hu.enumerate().map(move |(at, hu)| (place(at), hu))
    }

    fn largest_difference(&self, other: &Self) -> f64 {
        assert_eq!(self.hu.len(), other.hu.len());
        let pairs = self.hu.iter().zip(&other.hu);
        pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
    }

    /// The HU of a box: columns from `x` and rows from `y`, `side` of each.
    fn patch(&self, [x, y]: [usize; 2], side: usize) -> Vec<f64> {
        let rows = (y..y + side).flat_map(|row| &self.hu[row * self.size[0] + x..][..side]);
        rows.map(|hu| f64::from(*hu)).collect()
    }
}

/// `slice-view-proc snapshot` with these arguments, to `x.png` and `x.mha`.
fn snapshot(world: &World, volume: &Path, arguments: &str) -> Slice {
    let (volume, hu) = (volume.display(), world.path("x.mha"));
    let files = format!("--out {} --hu {}", world.path("x.png").display(), hu.display());
    let line = format!("snapshot --minify point --volume {volume} {files} {arguments}");
    let output = world.output("slice-view-proc", &line.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", stderr(&output));
    Slice::read(&hu)
}

/// The generated patient with voxels of 5 mm, so that the file holds exactly the same places.
fn patient(world: &World) -> PathBuf {
    let path = world.path("patient.nii.gz");
    let arguments = ["phantom", "--spacing-mm", "5", "--out", path.to_str().unwrap()];
    assert!(world.output("volume-loader", &arguments).status.success());
    path
}

/// What the generated patient's voxels give by trilinear interpolation, in f64 and from the definition.
struct Oracle {
    patient: Phantom,
    origin: [f64; 3],
    dims: [f64; 3],
    spacing_mm: f64,
    outside_hu: f64,
    voxels: HashMap<[i64; 3], f64>,
}

impl Oracle {
    fn new(spacing_mm: f64, outside_hu: f64) -> Self {
        let patient = Phantom::new(1);
        let grid = patient.grid([spacing_mm; 3]).unwrap();
        Self {
            origin: (grid.ct_from_voxel() * Point::new(0.0, 0.0, 0.0)).mm(),
            dims: grid.dims().map(f64::from),
            voxels: HashMap::new(),
            patient,
            spacing_mm,
            outside_hu,
        }
    }

    fn index(&self, p: [f64; 3]) -> [f64; 3] {
        from_fn(|i| (p[i] - self.origin[i]) / self.spacing_mm)
    }

    /// The voxels' cells, halves around the outermost centres.
    fn is_inside(&self, p: [f64; 3]) -> bool {
        let index = self.index(p);
        (0..3).all(|i| index[i] >= -0.5 && index[i] <= self.dims[i] - 0.5)
    }

    /// Whether `p` is as near to one voxel as to the next, to 4e-9 of a voxel.
    fn is_between(&self, p: [f64; 3]) -> bool {
        let mut index = self.index(p).into_iter();
        index.any(|v| (v.fract().abs() - 0.5).abs() <= 4e-9)
    }

    fn truth(&self, [x, y, z]: [f64; 3]) -> f64 {
        self.patient.hu(Point::new(x, y, z))
    }

    fn voxel(&mut self, index: [i64; 3]) -> f64 {
        if let Some(hu) = self.voxels.get(&index) {
            return *hu;
        }
        let hu = self.truth(from_fn(|i| self.origin[i] + self.spacing_mm * index[i] as f64));
        *self.voxels.entry(index).or_insert(hu.round())
    }

    fn trilinear(&mut self, p: [f64; 3]) -> f64 {
        if !self.is_inside(p) {
            return self.outside_hu;
        }
        let index = self.index(p);
        let index: [f64; 3] = from_fn(|i| index[i].clamp(0.0, self.dims[i] - 1.0));
        let mut sum = 0.0;
        for corner in 0..8 {
            let far: [f64; 3] = from_fn(|i| f64::from(corner >> i & 1));
            let weight = |i: usize| (1.0 - far[i] - index[i].fract()).abs();
            // Beyond the last voxel the weight is zero.
            let voxel = from_fn(|i| (index[i].floor() + far[i]).min(self.dims[i] - 1.0) as i64);
            sum += weight(0) * weight(1) * weight(2) * self.voxel(voxel);
        }
        sum
    }
}

/// The image is centred on the tip, and its columns and rows grow to where they should.
fn assert_plane(slice: &Slice, [right, down]: [[f64; 3]; 2], tip: [f64; 3], pixel_mm: f64) {
    let [width, height] = slice.size.map(|n| n as f64);
    let middle = slice.point((width - 1.0) / 2.0, (height - 1.0) / 2.0);
    let found = [middle, slice.steps[0], slice.steps[1]];
    let wanted = [tip, right.map(|v| v * pixel_mm), down.map(|v| v * pixel_mm)];
    let pairs = found.as_flattened().iter().zip(wanted.as_flattened());
    // A few roundings of numbers below 512.
    assert!(
        pairs.clone().all(|(a, b)| (a - b).abs() < 1e-12),
        "{found:?}, not {wanted:?}"
    );
}

fn assert_trilinear(slice: &Slice, oracle: &mut Oracle, what: &str) {
    let (mut worst, mut off) = (0.0_f64, Vec::new());
    for (p, hu) in slice.pixels() {
        worst = worst.max((hu - oracle.trilinear(p)).abs());
        off.extend(oracle.is_inside(p).then(|| (hu - oracle.truth(p)).abs()));
    }
    let largest = off.iter().copied().fold(0.0, f64::max);
    let rms = (off.iter().map(|v| v * v).sum::<f64>() / off.len() as f64).sqrt();
    println!("{what}: {worst:.2e} HU from the voxels; max {largest:.1}, rms {rms:.2} HU from the truth");
    assert!(worst <= FAST_HU, "{what}: {worst} HU, allowed are {FAST_HU}");
    assert!(off.len() > slice.hu.len() / 2, "{what}: mostly outside the patient");
}

#[test]
fn every_pixel_is_the_trilinear_value_of_the_voxels() {
    let world = World::new();
    let file = patient(&world);
    // The generated patient itself knows what is around it, its file does not.
    for (volume, spacing_mm, outside_hu) in [(file, 5.0, -1024.0), ("phantom".into(), 1.5, phantom::AIR_HU)] {
        let mut oracle = Oracle::new(spacing_mm, outside_hu);
        for (view, right, down) in VIEWS {
            let line = format!("--view {view} --pose {OBLIQUE},11.3,-4.7,52.9 --size 160x120 --pixel-mm 1.9");
            let slice = snapshot(&world, &volume, &line);
            assert_plane(&slice, [right, down], [11.3, -4.7, 52.9], 1.9);
            assert_trilinear(&slice, &mut oracle, &format!("{view}, voxels of {spacing_mm} mm"));
        }
    }
}

/// Voxels along the patient's right, front and head, and how far apart, mm.
const DIMS: [usize; 3] = [8, 10, 12];
const SPACING_MM: [f32; 3] = [4.0, 3.0, 2.0];

/// A block of 1000 HU at the patient's left, front and head; elsewhere neighbours differ, below -500.
fn block_hu([right, front, head]: [usize; 3]) -> i16 {
    if right < DIMS[0] / 2 && front >= DIMS[1] / 2 && head >= DIMS[2] / 2 {
        return 1000;
    }
    -1000 + ((right * 31 + front * 57 + head * 91) % 499) as i16
}

/// The same patient, stored along `axes` of (right, front, head), each backwards where its bit is in `flips`.
fn stored_along(axes: [usize; 3], flips: usize) -> Vec<u8> {
    let dims = axes.map(|axis| DIMS[axis]);
    let mut nifti = Nifti::header().dims(dims.map(|n| n as i16));
    let is_flipped = |s: usize| flips >> s & 1 == 1;
    for (s, &axis) in axes.iter().enumerate() {
        let step = SPACING_MM[axis] * if is_flipped(s) { -1.0 } else { 1.0 };
        for row in 0..3 {
            nifti = nifti.f32(280 + 16 * row + 4 * s, if row == axis { step } else { 0.0 });
        }
        // The middle of the volume is the origin.
        let first = -step * (DIMS[axis] - 1) as f32 / 2.0;
        nifti = nifti.f32(80 + 4 * s, step.abs()).f32(292 + 16 * axis, first);
    }
    let hu = |at: usize| {
        let stored = [at % dims[0], at / dims[0] % dims[1], at / dims[0] / dims[1]];
        let mut patient = [0; 3];
        for (s, &axis) in axes.iter().enumerate() {
            patient[axis] = if is_flipped(s) {
                dims[s] - 1 - stored[s]
            } else {
                stored[s]
            };
        }
        block_hu(patient).to_le_bytes()
    };
    nifti.with((0..DIMS.iter().product()).flat_map(hu)).into()
}

/// Boxes in the quarters of an image of 256 x 256 pixels, clear of its middle, its edges and what is written there.
const QUARTERS: [[usize; 2]; 4] = [[56, 56], [168, 56], [56, 168], [168, 168]];
const TOP_LEFT: usize = 0;
const TOP_RIGHT: usize = 1;

/// The block fills one quarter of the slice and of the picture, and no other.
fn assert_block_in(quarter: usize, slice: &Slice, png: &Path, what: &str) {
    let picture = image::open(png).unwrap().to_luma8();
    for (i, [x, y]) in QUARTERS.into_iter().enumerate() {
        let hu = slice.patch([x, y], 32);
        let grey = picture.get_pixel(x as u32 + 16, y as u32 + 16).0[0];
        let is_right = match i == quarter {
            true => hu.iter().all(|&hu| hu == 1000.0) && grey == 255,
            false => hu.iter().all(|&hu| hu < -500.0) && grey == 0,
        };
        assert!(is_right, "{what}, quarter {i}: {} HU, grey {grey}", hu[0]);
    }
}

#[test]
fn left_front_and_head_are_where_they_belong_however_the_file_is_stored() {
    let world = World::new();
    let file = world.path("block.nii");
    // The tip lies in the block's half. Sagittal images are seen from the left: the front is on their left.
    let views = [
        ("axial", "0,0,5", TOP_RIGHT),
        ("frontal", "0,-7,0", TOP_RIGHT),
        ("sagittal", "8,0,0", TOP_LEFT),
    ];
    for (view, tip, quarter) in views {
        let line = format!("--view {view} --pose {ALONG},{tip} --size 256x256 --pixel-mm 0.125");
        let mut first: Option<Slice> = None;
        for axes in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for flips in 0..8 {
                fs::write(&file, stored_along(axes, flips)).unwrap();
                let what = format!("{view}, stored along {axes:?}, flips {flips:03b}");
                let slice = snapshot(&world, &file, &line);
                assert_block_in(quarter, &slice, &world.path("x.png"), &what);
                let first = first.get_or_insert_with(|| snapshot(&world, &file, &line));
                // Both may be off, each its own way.
                let difference = slice.largest_difference(first);
                assert!(difference <= 2.0 * FAST_HU, "{what}: {difference} HU");
            }
        }
    }
}

/// Holds the views of an oblique tool against ITK's slices of the same file.
fn assert_as_itk(world: &World, python: &Path, volume: &Path, tip: &str, pixel_mm: f64) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_slice.py");
    for (view, ..) in VIEWS {
        let line = format!("--view {view} --pose {OBLIQUE},{tip} --size 400x300 --pixel-mm {pixel_mm}");
        snapshot(world, volume, &line);
        let mut command = Command::new(python);
        command.args([&script, volume, &world.path("x.mha")]);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        let seen: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        println!("{}, {view}: {seen}", volume.display());
        let number = |key: &str| seen[key].as_f64().unwrap();
        assert!(number("pixels") > 50_000.0 && number("range") > 1000.0, "{seen}");
        // Ours is within FAST_HU, 0.0034. ITK interpolates in f64, and both place a pixel to 1e-6 of a voxel, which may
        // be 0.004 HU at an edge of 4096.
        assert!(number("max") <= 0.01, "{view}: {seen}");
    }
}

#[test]
fn itk_resamples_the_same_values() {
    let Some(python) = python() else { return };
    let world = World::new();
    assert_as_itk(&world, &python, &patient(&world), "1.3,2.7,40.1", 0.9);
    // Mirrored and permuted: ITK finds the patient's sides by itself.
    let mirrored = world.path("mirrored.nii");
    fs::write(&mirrored, stored_along([2, 0, 1], 7)).unwrap();
    assert_as_itk(&world, &python, &mirrored, "2,-3,2", 0.05);
    if let Some(ct) = shared("data/ct-abdopelvis-nifti/example_ct.nii.gz") {
        assert_as_itk(&world, &python, &ct, "-3.5,-150,300", 0.9);
    }
    if let Some(straight) = shared("data/ct-chest-lidc-dicom") {
        assert_as_itk(&world, &python, &straight, "-1.5,141,-461.3", 0.25);
    }
    if let Some(tilted) = shared("data/ct-head-phantom-tilt-dicom/S21610/S2010") {
        assert_as_itk(&world, &python, &tilted, "0.4,90.7,771.2", 0.25);
    }
}

#[test]
fn the_liver_is_on_the_right() {
    let Some(ct) = shared("data/ct-abdopelvis-nifti/example_ct.nii.gz") else {
        return;
    };
    let world = World::new();
    let line = format!("--view frontal --pose {ALONG},-3.5,-180,260 --size 400x400 --pixel-mm 1");
    let slice = snapshot(&world, &ct, &line);
    // The image's upper left is liver throughout; its mirror image holds bowel and fat.
    let (liver, mirrored) = (slice.patch([85, 50], 40), slice.patch([275, 50], 40));
    let mean = |hu: &[f64]| hu.iter().sum::<f64>() / hu.len() as f64;
    println!(
        "image left {:.1} HU, image right {:.1} HU",
        mean(&liver),
        mean(&mirrored)
    );
    // Liver has 40 to 120 HU, without and with contrast, here with 40 HU of noise; fat has -100.
    assert!(liver.iter().all(|hu| (0.0..160.0).contains(hu)));
    assert!((40.0..120.0).contains(&mean(&liver)) && mean(&mirrored) < 0.0);
}

/// A block of bone to the patient's left, front and head: from each side it is where it belongs, as on a radiologist's screen.
#[test]
fn a_surface_is_seen_from_each_side_and_has_no_hu() {
    let world = World::new();
    let path = world.path("ct.nii");
    let voxels = (0..8).flat_map(|k| (0..10).flat_map(move |j| (0..12).map(move |i| (i, j, k))));
    // The file's axes go to the right, the front and the head.
    let block = |(i, j, k): (i32, i32, i32)| if i < 4 && j > 6 && k > 4 { 1000_i16 } else { 0 };
    let bytes = voxels.flat_map(|voxel| block(voxel).to_le_bytes());
    fs::write(&path, Nifti::header().with(bytes).0).unwrap();
    let run = |more: &str| {
        let line = format!(
            "snapshot --volume {} --view surface --pose {ALONG},900,900,900 {more}",
            path.display()
        );
        world.output("slice-view-proc", &line.split(' ').collect::<Vec<_>>())
    };
    let png = world.path("s.png");
    // Where on the image the block is: to the right, and down.
    for (side, expected) in [
        ("anterior", [true, false]),
        ("left", [false, false]),
        ("posterior", [false, false]),
        ("right", [true, false]),
        ("head", [false, false]),
        ("feet", [true, false]),
    ] {
        let output = run(&format!(
            "--from {side} --size 150x150 --pixel-mm 2 --out {}",
            png.display()
        ));
        assert!(output.status.success(), "{}", stderr(&output));
        let image = image::open(&png).unwrap().to_rgb8();
        // Grey, as the frame that says that the tip is outside is not.
        let is_bone = |[r, _, b]: [u8; 3]| r > 60 && r.abs_diff(b) < 40;
        let bone: Vec<_> = image
            .enumerate_pixels()
            .filter(|(_, _, pixel)| is_bone(pixel.0))
            .collect();
        assert!(bone.len() > 300, "{side}: {}", bone.len());
        let part = |is: fn(u32, u32) -> bool| bone.iter().filter(|(x, y, _)| is(*x, *y)).count() * 100 / bone.len();
        let found = [part(|x, _| x > 75) > 90, part(|_, y| y > 75) > 90];
        assert_eq!(
            found,
            expected,
            "{side}: {} {}",
            part(|x, _| x > 75),
            part(|_, y| y > 75)
        );
    }
    let output = run(&format!("--hu {}", world.path("s.mha").display()));
    assert!(
        !output.status.success() && stderr(&output).contains("a surface has no HU"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn images_repeat_and_back_ends_agree() {
    let world = World::new();
    let file = patient(&world);
    let taken = |more: &str| {
        let line = format!("--view perpendicular --pose {OBLIQUE},11.3,-4.7,52.9 --size 300x200 --pixel-mm 1 {more}");
        let slice = snapshot(&world, &file, &line);
        (slice, fs::read(world.path("x.png")).unwrap())
    };
    let ((linear, png), (again, png_again)) = (taken("--filter linear"), taken("--filter linear"));
    assert!(
        png == png_again && linear.hu == again.hu,
        "the same command drew another image"
    );
    let (nearest, nearest_png) = taken("--filter nearest");
    assert!(nearest.largest_difference(&linear) > 100.0 && png != nearest_png);
    let (exact, _) = taken("--filter linear --reference");
    // The reference is rounded to f32 once, and the fast back end's index is good to 4e-9 voxels of at most 4096 HU.
    let bound = FAST_HU + 4096.0 * f64::from(f32::EPSILON) / 2.0 + 3.0 * 4096.0 * 4e-9;
    let difference = linear.largest_difference(&exact);
    println!("linear: the back ends are {difference:.2e} HU apart, allowed are {bound:.2e}");
    assert!(difference > 0.0 && difference <= bound);
    let (exact, _) = taken("--filter nearest --reference");
    let oracle = Oracle::new(5.0, -1024.0);
    let other = exact.pixels().zip(nearest.pixels()).filter(|((_, a), (_, b))| a != b);
    let places: Vec<_> = other.map(|((p, _), _)| p).collect();
    println!(
        "nearest: the back ends take different voxels at {} of 60000 pixels",
        places.len()
    );
    assert!(places.iter().all(|&p| oracle.is_between(p)), "{places:?}");
}
