//! The meshes.

#![allow(dead_code, reason = "each benchmark is a crate of its own and uses its part")]

use std::io::Read;
use std::path::PathBuf;

use nalgebra::Vector3;
use simulation::space::cells::{Field, LabelField, LabelMap, Mesh, Parts, Plane, Settings, Smoothing};

/// Meshes with their names.
pub(crate) fn all() -> Vec<(&'static str, Mesh)> {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let block = Mesh::new(
        &everywhere,
        [Vector3::zeros(), Vector3::repeat(100.0)],
        &Settings::of_side(12.5),
        &|_, _| false,
    );
    let quarter = Mesh::new(
        &everywhere,
        [Vector3::zeros(), Vector3::new(50.0, 50.0, 100.0)],
        &Settings {
            levels: 2,
            ..Settings::of_side(25.0)
        },
        &|low, high| {
            let top = Vector3::new(0.0, 0.0, 100.0);
            let reach = if high.x - low.x > 20.0 { 40.0 } else { 25.0 };
            (top.sup(low).inf(high) - top).norm() < reach
        },
    );
    let mut meshes = vec![
        ("block", block.unwrap()),
        ("graded quarter", quarter.unwrap()),
        ("bean", organ(&bean())),
    ];
    match kidney() {
        Some(field) => meshes.push(("kidney", organ(&field))),
        None => println!("no kidney: TROCAR_SHARED does not name its folder"),
    }
    meshes
}

fn organ(field: &LabelField) -> Mesh {
    let corners = field.known().unwrap().1;
    Mesh::new(field, corners, &Settings::of_side(12.0), &|_, _| false).unwrap()
}

fn field(size: [usize; 3], labels: &[u16], label: u16) -> LabelField {
    let map = LabelMap {
        size,
        origin: Vector3::zeros(),
        spacing: Vector3::repeat(3.0),
        labels,
    };
    let smoothing = Smoothing {
        sigma: 3.0,
        parts: Parts::Largest,
        fill_holes: true,
    };
    LabelField::new(&map, label, &smoothing).unwrap()
}

/// A kidney's size: 120 x 60 x 50 mm, bent.
fn bean() -> LabelField {
    let size = [60, 40, 30];
    let inside = |n: usize| {
        let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]].map(|x| 3.0 * x as f64);
        let [x, y, z] = [at[0] - 90.0, at[1] - 60.0, at[2] - 45.0];
        let y = y - x * x / 200.0;
        (x / 60.0).powi(2) + (y / 30.0).powi(2) + (z / 25.0).powi(2) < 1.0
    };
    let labels: Vec<u16> = (0..size.iter().product()).map(|n| u16::from(inside(n))).collect();
    field(size, &labels, 1)
}

/// Label 2 of a segmented CT of bytes, 3 mm voxels.
pub(crate) fn kidney() -> Option<LabelField> {
    let folder = std::env::var_os("TROCAR_SHARED").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let path = folder.join("data/ct-abdopelvis-nifti/example_seg_fast_force_split.nii.gz");
    let (file, mut bytes) = (std::fs::File::open(path).ok()?, Vec::new());
    flate2::read::GzDecoder::new(file).read_to_end(&mut bytes).unwrap();
    let short = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!((short(70), [80, 84, 88].map(float)), (2, [3.0; 3]));
    let size = [42, 44, 46].map(|at| usize::try_from(short(at)).unwrap());
    let labels: Vec<u16> = bytes[float(108) as usize..].iter().map(|b| u16::from(*b)).collect();
    Some(field(size, &labels, 2))
}
