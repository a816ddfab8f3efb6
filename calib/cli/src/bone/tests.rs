//! The command on volumes in memory.

use std::fs;

use bus::message::{Marks, VolumeHash};
use bus::volume::{LabelMap, Layout, OwnedVolume, Voxels};
use clap::Parser;
use exchange::mesh::{self, MeshFormat};
use exchange::{PatientAxes, Said};
use geometry::{Affine, VolumeGrid};
use scene::VolumeSpec;
use tempfile::TempDir;

use super::BoneFile;
use crate::beads::Loaded;
use crate::cli::{Cli, Hands, carry_out};
use crate::commands::Outcome;
use crate::live::FollowMarkers;

type Read<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// Balls with 2 mm of cortex: middle, mm, and radius.
const BALLS: [([f64; 3], f64); 2] = [([30.0, 30.0, 30.0], 14.0), ([60.0, 30.0, 30.0], 9.0)];

/// A normal distribution to 0.02, which a scanner's blur of 1.2 mm is as good as any other.
fn step(x: f64) -> f64 {
    1.0 / (1.0 + (-1.702 * x).exp())
}

fn hu([x, y, z]: [f64; 3]) -> f64 {
    let mut sum = 40.0;
    for ([a, b, c], radius) in BALLS {
        let d = ((x - a).powi(2) + (y - b).powi(2) + (z - c).powi(2)).sqrt() - radius;
        sum += 1260.0 * step(-d / 1.2) - 1100.0 * step((-d - 2.0) / 1.2);
    }
    sum
}

/// The same with a vessel of 400 HU along y, which touches the small ball from below.
fn beside_a_vessel(p: [f64; 3]) -> f64 {
    let across = (p[0] - 60.0).hypot(p[2] - 17.0) - 4.0;
    let tissue = hu(p);
    tissue.max(40.0 + 360.0 * step(-across / 1.2))
}

fn filled(steps: f64, value: impl Fn([f64; 3]) -> f64) -> Read<OwnedVolume> {
    let unit = Affine::from_rows([[steps, 0.0, 0.0, 0.0], [0.0, steps, 0.0, 0.0], [0.0, 0.0, steps, 0.0]]);
    let grid = VolumeGrid::checked([40, 30, 30], unit)?;
    let layout = Layout::choose(grid.dims())?;
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    for z in 0..30_u32 {
        for y in 0..30_u32 {
            for x in 0..40_u32 {
                let at = [x, y, z].map(|k| f64::from(k) * steps);
                voxels[layout.offset([x, y, z])] = value(at).round() as i16;
            }
        }
    }
    Ok(OwnedVolume {
        grid,
        layout,
        voxels,
        padding_hu: -1000,
        hash: VolumeHash([7; 32]),
        marks: Marks::NONE,
    })
}

fn ct(spec: &VolumeSpec) -> Read<Loaded> {
    // By the file's name, as a series of another scanner.
    let is_mr = matches!(&spec.source, scene::VolumeSource::File(file) if file.path.ends_with("mr"));
    let has_vessel = matches!(&spec.source, scene::VolumeSource::File(file) if file.path.ends_with("vessel"));
    Ok(Loaded {
        volume: filled(2.0, if has_vessel { beside_a_vessel } else { hu })?,
        modality: is_mr.then(|| "MR".to_owned()),
        warnings: vec!["slices are shifted against one another".to_owned()],
    })
}

/// Label 3 is the small ball, 5 the large one; of `other.nii` on another grid.
fn labels(path: &std::path::Path, _: &VolumeSpec) -> Read<LabelMap> {
    let steps = if path.ends_with("other.nii") { 2.1 } else { 2.0 };
    let volume = filled(steps, |p| {
        let within =
            |(middle, radius): ([f64; 3], f64)| (0..3).map(|k| (p[k] - middle[k]).powi(2)).sum::<f64>().sqrt() < radius;
        if within(BALLS[1]) {
            3.0
        } else if within(BALLS[0]) {
            5.0
        } else {
            0.0
        }
    })?;
    Ok(LabelMap {
        volume,
        is_in_its_frame: true,
        doubts: Vec::new(),
    })
}

fn calib(line: &str) -> Result<Outcome, String> {
    let follow: FollowMarkers = |_| Err("no run is followed here".into());
    let hands = Hands {
        load: ct,
        labels,
        label_names: |_| Ok(guidance::safety::LabelNames::default()),
        follow,
    };
    let cli = Cli::try_parse_from(line.split(' ')).map_err(|error| error.to_string())?;
    carry_out(cli, hands)
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_bone_is_written_with_what_it_rests_on() {
    let folder = TempDir::new().unwrap();
    let (out, png) = (path(&folder, "b.ply"), path(&folder, "b.png"));
    let line = format!("calib bone ct.mha --seed 60,30,38 --out {out} --png {png}");
    let told = calib(&line).unwrap();
    assert!(
        told.text.contains("07070707") && told.text.contains("body at [60.0, 30.0, 38.0] mm"),
        "{}",
        told.text
    );
    assert!(fs::metadata(&png).unwrap().len() > 1000);
    let bytes = fs::read(&out).unwrap();
    let file: BoneFile = serde_json::from_slice(&fs::read(path(&folder, "b.json")).unwrap()).unwrap();
    assert_eq!(
        (file.format.as_str(), file.version, file.frame.as_str()),
        ("trocar-bone", 1, "LPS")
    );
    assert_eq!(file.surface_file.as_deref(), Some("b.ply"));
    assert_eq!(file.surface_blake3, blake3::hash(&bytes).to_string());
    assert!(file.surface_sigma_mm > 0.0 && file.surface_shared_sigma_mm > 0.0 && file.deviation_95_mm < 1.0);
    // The file says its axes itself, and its corners lie on the ball.
    let said = Said { axes: None, unit: None };
    let mesh = mesh::read(&bytes, MeshFormat::Ply, said).unwrap();
    assert_eq!(
        (mesh.points.len(), mesh.triangles.len()),
        (file.corners, file.triangles)
    );
    let (middle, radius) = BALLS[1];
    let mean = mesh.points.iter().map(|p| {
        let p = p.mm();
        (0..3).map(|k| (p[k] - middle[k]).powi(2)).sum::<f64>().sqrt() - radius
    });
    let mean = mean.sum::<f64>() / mesh.points.len() as f64;
    // The blur of this volume is no Gaussian: 0.1 of it is a third of a threshold's error.
    assert!(mean.abs() < 0.25, "{mean}");
    let again = calib(&line).unwrap_err();
    assert!(again.contains("there is a file of this name"), "{again}");
    let vtk = path(&folder, "b.vtk");
    let json = calib(&format!(
        "calib bone ct.mha --seed 60,30,38 --out {vtk} --overwrite --json"
    ))
    .unwrap();
    let file: BoneFile = serde_json::from_str(&json.text).unwrap();
    let bytes = fs::read(&vtk).unwrap();
    assert_eq!(file.surface_blake3, blake3::hash(&bytes).to_string());
    let mesh = mesh::read(&bytes, MeshFormat::Vtk, said).unwrap();
    assert_eq!(mesh.points.len(), file.corners);
    assert!(mesh::write(&mesh, MeshFormat::Ply, PatientAxes::Lps).is_ok());
}

/// What a vessel's wall is said to be, in the text, in the file and in the surface: nothing registers to it, whatever program reads the surface.
#[test]
fn a_vessel_beside_the_bone_is_told_and_no_triangle_is_on_it() {
    let folder = TempDir::new().unwrap();
    let out = path(&folder, "b.ply");
    let line = format!("calib bone vessel --seed 60,30,38 --out {out}");
    let told = calib(&line).unwrap().text;
    assert!(
        told.contains("left out, no cortex") && told.contains("HU inside"),
        "{told}"
    );
    let file: BoneFile = serde_json::from_slice(&fs::read(path(&folder, "b.json")).unwrap()).unwrap();
    let left: f64 = file.left_out.iter().map(|piece| piece.area_mm2).sum();
    assert!(file.contrast_hu == Some(450.0) && left > 100.0, "{:?}", file.left_out);
    // 400 HU blurred over a radius of 4 mm by 1.2 mm and more.
    assert!((300.0..450.0).contains(&file.left_out[0].hu), "{:?}", file.left_out);
    let bytes = fs::read(&out).unwrap();
    assert!(bytes.windows(27).any(|word| word == b"property float cortex_seen\n"));
    let mesh = mesh::read(&bytes, MeshFormat::Ply, Said { axes: None, unit: None }).unwrap();
    assert_eq!(mesh.points.len(), file.corners);
    let used: std::collections::BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
    assert!(
        used.len() + file.unseen_corners <= file.corners,
        "{} {}",
        used.len(),
        file.unseen_corners
    );
    // Off the ball by more than the blur is on the vessel.
    let off = |corner: &&u32| {
        let p = mesh.points[**corner as usize].mm();
        (0..3).map(|k| (p[k] - BALLS[1].0[k]).powi(2)).sum::<f64>().sqrt() - BALLS[1].1 > 2.0
    };
    assert_eq!(used.iter().filter(off).count(), 0);
    let taken = calib(&format!("{line} --overwrite --accept-no-cortex")).unwrap().text;
    assert!(
        !taken.contains("left out") && taken.contains("no cortex seen on"),
        "{taken}"
    );
    // Of a CT without contrast medium a person says so, and all of it is bone.
    let none = calib(&format!("{line} --overwrite --contrast-hu 0")).unwrap().text;
    assert!(!none.contains("left out") && !none.contains("no cortex"), "{none}");
}

#[test]
fn a_label_map_names_the_bone_and_keeps_others_out() {
    let told = calib("calib bone ct.mha --labels map.nii --label 3").unwrap();
    assert!(
        told.text.contains("label 3 of map.nii") && told.text.contains("kept out: label 5"),
        "{}",
        told.text
    );
    let missing = calib("calib bone ct.mha --labels map.nii --label 4").unwrap_err();
    assert!(
        missing.contains("no label 4") && missing.contains("label 3, label 5"),
        "{missing}"
    );
    let other = calib("calib bone ct.mha --labels other.nii --label 3").unwrap_err();
    assert!(
        other.contains("does not lie on the CT's voxels (its voxels are others in number, size or direction)"),
        "{other}"
    );
    assert!(!other.contains("Other"), "{other}");
}

#[test]
fn what_is_not_said_or_cannot_be_is_refused_with_words() {
    let which = calib("calib bone ct.mha").unwrap_err();
    assert!(
        which.contains("which bone is meant") && which.contains("\n       2"),
        "{which}"
    );
    for (line, words) in [
        (
            "calib bone ct.mha --seed 5,5,5",
            "at the seed [5.0, 5.0, 5.0] mm there is no bone",
        ),
        ("calib bone ct.mha --seed 5,5,500", "does not lie in the CT"),
        ("calib bone ct.mha --component 9", "no body 9"),
        ("calib bone ct.mha --threshold-hu 3 --component 1", "50 to 1500"),
        ("calib bone ct.mha --component 1 --out b.stl", ".ply or .vtk"),
        ("calib bone ct.mha --labels map.nii", "--label"),
        ("calib bone ct.mha --seed 1,2", "2 numbers; 3 are needed"),
        ("calib bone ct.mha --cut 1,2,3,0,0,0", "must not be zero"),
        ("calib bone ct.mha --seed 1,2,3 --component 1", "cannot be used with"),
    ] {
        let error = calib(line).map(|told| told.text).unwrap_err();
        assert!(error.contains(words), "{line}: {error}");
    }
}

#[test]
fn bone_of_what_is_no_ct_is_refused_and_warnings_of_the_loader_are_told_and_written() {
    let refused = calib("calib bone mr --seed 60,30,38").unwrap_err();
    assert!(refused.contains("not a CT") && refused.contains("MR"), "{refused}");
    let json = calib("calib bone mr --seed 60,30,38 --accept-not-ct --json")
        .unwrap()
        .text;
    let file: BoneFile = serde_json::from_str(&json).unwrap();
    assert_eq!(file.warnings.len(), 2);
    assert!(
        file.warnings[1].contains("--accept-not-ct") && file.warnings[1].contains("MR"),
        "{:?}",
        file.warnings
    );
    let told = calib("calib bone ct.mha --seed 60,30,38").unwrap().text;
    assert!(told.contains("warning: slices are shifted"), "{told}");
}
