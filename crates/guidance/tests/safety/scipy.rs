//! A real label map, held against SciPy and NumPy.

use std::path::{Path, PathBuf};
use std::process::Command;

use chance::SplitMix64;
use geometry::{Affine, Point, VolumeGrid, Voxel};
use guidance::safety::{Distance, Structures, Tube};
use serde_json::{Value, json};

use crate::support::Map;

/// Steps of a voxel from one sample of SciPy's transform to the next.
const FINER: f64 = 3.0;

fn shared(path: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let path = std::env::var_os("TROCAR_SHARED")
        .map_or(beside, PathBuf::from)
        .join(path);
    if path.exists() {
        return Some(path);
    }
    println!(
        "skipped: {} is not there (set TROCAR_SHARED to the folder that holds it)",
        path.display()
    );
    None
}

fn python() -> Option<PathBuf> {
    let python = std::env::var_os("TROCAR_PYTHON").map(PathBuf::from);
    if python.is_none() {
        println!("skipped: TROCAR_PYTHON is not set (`cargo xtask test` prepares an interpreter and sets it)");
    }
    python
}

/// Runs the script, which must succeed and print one JSON object.
fn script(python: &Path, arguments: &[&Path]) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/python/check_safety.py");
    #[allow(clippy::disallowed_methods, reason = "an oracle in another language")]
    let output = Command::new(python).arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The map as the script unpacked it: 16-bit labels, x fastest, in LPS.
fn read(folder: &Path, head: &Value) -> Map {
    let rows: [[f64; 4]; 3] = serde_json::from_value(head["ct_from_voxel"].clone()).unwrap();
    let dims: [i64; 3] = serde_json::from_value(head["dims"].clone()).unwrap();
    let bytes = std::fs::read(folder.join("labels.i16")).unwrap();
    let labels = bytes
        .as_chunks::<2>()
        .0
        .iter()
        .map(|pair| i16::from_le_bytes(*pair))
        .collect();
    Map {
        grid: VolumeGrid::checked(dims, Affine::from_rows(rows)).unwrap(),
        labels,
    }
}

/// Ways of 40 to 160 mm into the body, from all sides; the last ones within the map, thin and thick.
fn tubes(grid: &VolumeGrid) -> Vec<Tube> {
    let mut random = SplitMix64::new(20);
    let dims = grid.dims().map(f64::from);
    let mut index = |spread: f64| {
        let [x, y, z] = [0, 1, 2].map(|k: usize| random.around(dims[k] / 2.0, spread * dims[k]));
        grid.ct_from_voxel() * Point::<Voxel>::new(x, y, z)
    };
    (0..14)
        .map(|k| {
            let (from, to) = (index(0.45), index(0.3));
            Tube::new(from, to, [3.0, 4.5, 6.0, 10.0][k % 4]).unwrap()
        })
        .collect()
}

fn told(structures: &Structures, tube: &Tube) -> Value {
    let found = structures.clearance(tube, 1e4).unwrap();
    let of = |distance| match distance {
        Distance::Nearest(nearest) => json!([nearest.distance_mm, nearest.depth_mm, nearest.point.mm()]),
        Distance::Beyond { .. } => unreachable!("the map is smaller than ten metres"),
    };
    let sections = structures.profile(tube, 40, 1e4).unwrap();
    let least = |s: &guidance::safety::Section| {
        s.nearest
            .map(|(label, n)| json!([s.from_mm, s.to_mm, label, n.distance_mm]))
    };
    json!({
        "entry": tube.entry().mm(), "tip": tube.tip().mm(), "radius": tube.radius_mm(),
        "structures": found.structures.iter().map(|c| json!([c.label, of(c.distance)])).collect::<Vec<_>>(),
        "sections": sections.iter().map(least).collect::<Vec<_>>(),
    })
}

/// Every distance of 14 tubes from every structure: equal to NumPy's over all voxels but for rounding; and that of SciPy's exact
/// Euclidean distance transform to half a voxel's diagonal.
#[test]
fn a_real_label_map_has_the_distances_that_scipy_finds() {
    let (Some(python), Some(labels)) = (
        python(),
        shared("data/ct-abdopelvis-nifti/example_seg_fast_force_split.nii.gz"),
    ) else {
        return;
    };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("safety");
    std::fs::create_dir_all(&folder).unwrap();
    let head = script(&python, &[Path::new("unpack"), &labels, &folder]);
    let map = read(&folder, &head);
    let structures = map.build();
    let tubes = tubes(&map.grid);
    let answers: Vec<Value> = tubes.iter().map(|tube| told(&structures, tube)).collect();
    std::fs::write(folder.join("answers.json"), json!(answers).to_string()).unwrap();
    let seen = script(&python, &[Path::new("compare"), &labels, &folder.join("answers.json")]);
    println!("{seen}");
    let number = |name: &str| seen[name].as_f64().unwrap();
    let counts: Vec<i64> = structures.list().iter().map(|s| s.voxels() as i64).collect();
    assert_eq!(json!(counts), seen["voxels"]);
    assert_eq!(number("distances"), (tubes.len() * structures.list().len()) as f64);
    // Coordinates within 500 mm: 32 eps of them here, and as much there.
    let rounding = 64.0 * f64::EPSILON * 500.0;
    assert!(
        number("numpy_mm") <= rounding && number("sections_mm") <= rounding,
        "{seen}"
    );
    // SciPy's is the distance from the nearest of finer points within the tube: never below, as each is one of the tube's. The tube's
    // nearest point is a corner at worst: a ball of half the finer diagonal d, which holds a finer point, fits into the tube with its middle
    // sqrt(2) d away. So it is above by at most (1 + sqrt(2)) d, which is less than half a voxel's diagonal.
    let half = structures.voxel_half_diagonal_mm();
    let above = (1.0 + 2.0_f64.sqrt()) * half / FINER;
    assert!(above < half);
    assert!(
        number("scipy_above_mm") <= above && number("scipy_below_mm") <= rounding,
        "{seen}"
    );
    assert!(number("scipy_distances") > 60.0, "{seen}");
}
