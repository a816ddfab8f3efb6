//! Beads inserted in real CTs, near bone too: none missed, none found in bone or metal.

use std::path::{Path, PathBuf};
use std::time::Instant;

use bead::{Dense, Ground, Search, Voxels, find};
use bus::volume::OwnedVolume;
use geometry::{Affine, Point, VolumeGrid};
use scene::VolumeSpec;

use super::bodies::taken;
use super::planted::{Bead, Planted};
use super::table::{Row, compared};
use super::{beads_of, succeed};
use crate::support::*;

/// Voxels where a bead may be put: soft tissue with bone beside it, and soft tissue or fat anywhere.
fn places(volume: &OwnedVolume, count: usize, near_bone: bool, apart_mm: f64) -> Vec<[f64; 3]> {
    let dims = volume.grid.dims();
    let view = volume.view();
    let spacing = volume.grid.spacing_mm();
    let mut state = if near_bone { 7_u64 } else { 99 };
    let mut random = |n: u32| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u32 % n
    };
    let mut found: Vec<[f64; 3]> = Vec::new();
    for _ in 0..3_000_000 {
        if found.len() == count {
            break;
        }
        let voxel = dims.map(|n| 8 + random(n - 16));
        if !(-150..150).contains(&view.at(voxel)) {
            continue;
        }
        let reach = spacing.map(|s| (3.0 / s).round().max(1.0) as i64);
        let around = |a: usize, d: i64| {
            let mut other = voxel;
            other[a] = (i64::from(voxel[a]) + d * reach[a]).clamp(0, i64::from(dims[a]) - 1) as u32;
            view.at(other)
        };
        let bone = (0..3).any(|a| around(a, 1).max(around(a, -1)) > 350);
        if bone != near_bone {
            continue;
        }
        // A bead on an implant is told of and not taken: none is put there.
        if bright_about(volume, voxel, spacing) {
            continue;
        }
        // Anywhere within the voxel.
        let index = voxel.map(|i| f64::from(i) + f64::from(random(1000)) / 1000.0 - 0.5);
        let p = (volume.grid.ct_from_voxel() * Point::new(index[0], index[1], index[2])).mm();
        let distance = |q: &[f64; 3]| (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt();
        if found.iter().all(|q| distance(q) > apart_mm) {
            found.push(p);
        }
    }
    found
}

/// Whether metal lies within 12 mm along the axes and diagonals.
fn bright_about(volume: &OwnedVolume, voxel: [u32; 3], spacing: [f64; 3]) -> bool {
    let (dims, view) = (volume.grid.dims(), volume.view());
    let reach = spacing.map(|s| (12.0 / s).ceil() as i64);
    let range = |a: usize| {
        let at = i64::from(voxel[a]);
        (at - reach[a]).max(0) as u32..(at + reach[a] + 1).min(i64::from(dims[a])) as u32
    };
    let mut all = range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| [x, y, z])));
    all.any(|voxel| view.at(voxel) > 1700)
}

/// Inserts beads, finds them, and returns root mean square and greatest error, mm, of those near bone and of the others.
fn inserted(world: &World, path: PathBuf, bead: Bead, arguments: &[&str]) -> [[f64; 2]; 2] {
    let volume = volume_loader::load(&VolumeSpec::of_path(path)).unwrap();
    let near = places(&volume, 20, true, 16.0 * bead.radius);
    let mut all = near.clone();
    for p in places(&volume, 20, false, 16.0 * bead.radius) {
        let distance = |q: &[f64; 3]| (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt();
        if near.iter().all(|q| distance(q) > 16.0 * bead.radius) {
            all.push(p);
        }
    }
    assert!(near.len() == 20 && all.len() > 30, "{} {}", near.len(), all.len());
    let beads: Vec<Bead> = all
        .iter()
        .map(|centre| Bead {
            centre: *centre,
            ..bead
        })
        .collect();
    let file = world.path("inserted.mha");
    Planted::in_volume(&volume, &beads).write(&file);
    let out = world.path("inserted.json");
    let png = world.path("inserted.png");
    let started = Instant::now();
    let command = [
        "beads",
        file.to_str().unwrap(),
        "--overwrite",
        "--out",
        out.to_str().unwrap(),
    ];
    let png = ["--png", png.to_str().unwrap()];
    let text = succeed(world, &[&command[..], &png, arguments].concat());
    println!(
        "{text}\n{:.1} s of wall time, reading included",
        started.elapsed().as_secs_f64()
    );
    errors(&out, &all, near.len())
}

fn errors(out: &Path, truth: &[[f64; 3]], near: usize) -> [[f64; 2]; 2] {
    let found = beads_of(out);
    let mut errors = [[0.0_f64; 2]; 2];
    for (i, truth) in truth.iter().enumerate() {
        let distance =
            |b: &calib_cli::BeadRecord| (0..3).map(|a| (b.centre_mm[a] - truth[a]).powi(2)).sum::<f64>().sqrt();
        let nearest = found.beads.iter().map(distance).fold(f64::INFINITY, f64::min);
        let why: Vec<String> = found
            .rejected
            .iter()
            .filter(|r| (0..3).all(|a| (r.place_mm[a] - truth[a]).abs() < 5.0))
            .map(|r| r.reason.clone())
            .collect();
        if nearest > 1.0 {
            println!("missed: bead {i} at {truth:?}: {why:?}");
        }
        let group = &mut errors[usize::from(i >= near)];
        group[0] += nearest * nearest;
        group[1] = group[1].max(nearest);
    }
    println!("{} beads found of {}", found.beads.len(), truth.len());
    assert_eq!(found.beads.len(), truth.len(), "none missed and none false");
    let counts = [near, truth.len() - near];
    [0, 1].map(|g| [(errors[g][0] / counts[g] as f64).sqrt(), errors[g][1]])
}

#[test]
fn beads_in_a_real_chest_are_all_found_and_nothing_else_is() {
    let Some(path) = shared("data/ct-chest-lidc-dicom") else {
        return;
    };
    let world = World::new();
    let bead = Bead {
        centre: [0.0; 3],
        radius: 1.0,
        metal_hu: 14_000.0,
    };
    let [near, others] = inserted(&world, path, bead, &[]);
    println!(
        "near bone: rms {:.4}, worst {:.4} mm; elsewhere: rms {:.4}, worst {:.4} mm",
        near[0], near[1], others[0], others[1]
    );
    // The root mean square of 20 errors of 3 components is good to 1 / sqrt(120) = 9 %; the worst is within three.
    assert!(near[0] <= 0.02 && others[0] <= 0.02, "{near:?} {others:?}");
    assert!(near[1] < 0.06 && others[1] < 0.06, "{near:?} {others:?}");
}

#[test]
fn beads_in_a_real_abdomen_are_all_found_and_nothing_else_is() {
    let Some(path) = shared("data/ct-abdopelvis-nifti/example_ct.nii.gz") else {
        return;
    };
    let world = World::new();
    let said = super::refusal(&world, &["beads", path.to_str().unwrap()]);
    // Voxels of 3 mm.
    assert!(
        said.contains("bone is brighter") && said.contains("[3.0, 3.0, 3.0]"),
        "{said}"
    );
    let bead = Bead {
        centre: [0.0; 3],
        radius: 2.5,
        metal_hu: 14_000.0,
    };
    let [near, others] = inserted(&world, path, bead, &["--radius-mm", "2.5"]);
    println!(
        "near bone: rms {:.4}, worst {:.4} mm; elsewhere: rms {:.4}, worst {:.4} mm",
        near[0], near[1], others[0], others[1]
    );
    assert!(near[1] < 0.8 && others[1] < 0.8, "{near:?} {others:?}");
}

/// A volume of the shared data, in memory.
fn dense(path: &str) -> Option<Dense> {
    let volume = volume_loader::load(&VolumeSpec::of_path(shared(path)?)).unwrap();
    let [nx, ny, nz] = volume.grid.dims();
    let view = volume.view();
    let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    let values = all.map(|voxel| view.at(voxel)).collect();
    Some(Dense::new(volume.grid, values).unwrap())
}

const CHEST: &str = "data/ct-chest-lidc-dicom";

/// Bone that lay beside a bead drew its centre by 0.074 mm, root mean square.
#[test]
fn bone_does_not_draw_the_centres_of_beads_in_a_real_chest() {
    let Some(volume) = dense(CHEST) else {
        return;
    };
    let scores = compared("chest", &volume, 1.0, 8, &[Ground::Correlated]);
    let score = &scores[0];
    assert_eq!(score.wrong, 0);
    let errors: Vec<f64> = score.rows.iter().flat_map(|r: &Row| r.errors.clone()).collect();
    assert!(
        score.rows.iter().all(|r| r.missed == 0) && errors.len() == 56,
        "{score:?}"
    );
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(rms <= 0.02, "{rms}");
    // Eight errors of 3 components are good to 1 / sqrt(48) = 14 %.
    assert!(score.rows.iter().all(|r| r.rms() <= 0.02 * 1.3), "{score:?}");
}

/// The mean of `take` voxels to a voxel along each axis: coarser slices of the same patient.
fn coarser(volume: &Dense, take: [usize; 3]) -> Dense {
    let (grid, dims) = (volume.grid(), volume.grid().dims().map(|d| d as usize));
    let coarse = [0, 1, 2].map(|a| dims[a] / take[a]);
    let mean = |i: usize| {
        let first = [i % coarse[0], i / coarse[0] % coarse[1], i / coarse[0] / coarse[1]];
        let voxels = (0..take.iter().product()).map(|j| {
            let offset = [j % take[0], j / take[0] % take[1], j / take[0] / take[1]];
            f64::from(volume.at([0, 1, 2].map(|a| (first[a] * take[a] + offset[a]) as u32)))
        });
        (voxels.sum::<f64>() / take.iter().product::<usize>() as f64).round() as i16
    };
    let mut rows = grid.ct_from_voxel().rows();
    for row in &mut rows {
        let middle: f64 = (0..3).map(|a| row[a] * 0.5 * (take[a] as f64 - 1.0)).sum();
        row[3] += middle;
        (0..3).for_each(|a| row[a] *= take[a] as f64);
    }
    let grid = VolumeGrid::checked(coarse.map(|d| d as i64), Affine::from_rows(rows)).unwrap();
    Dense::new(grid, (0..coarse.iter().product()).map(mean).collect()).unwrap()
}

/// In coarser voxels knobs of bone and calcium passed for beads: nine and two in these two.
#[test]
fn knobs_of_bone_in_coarse_voxels_of_a_real_chest_are_no_beads() {
    let Some(volume) = dense(CHEST) else {
        return;
    };
    for (take, radius_mm, metal_hu) in [([1, 1, 3], 0.75, 14_000.0), ([2, 2, 2], 1.0, 14_000.0)] {
        let search = Search {
            metal_hu,
            ..Search::of_radius(radius_mm)
        };
        let found = find(&coarser(&volume, take), &search).unwrap();
        assert!(found.beads.is_empty(), "{take:?}: {:?}", found.beads);
    }
}

const HEAD: &str = "data/ct-head-phantom-tilt-dicom/S21610";

/// Slices of 2.5 mm of a phantom's head, its gantry tilted: with sloping ground, bone was taken for a bead's own blur, so that
/// beads were missed, or found half a millimetre off.
#[test]
fn beads_beside_bone_in_thick_slices_are_all_found_and_nothing_else_is() {
    let Some(volume) = dense(HEAD) else {
        return;
    };
    let scores = compared("head", &volume, 1.0, 6, &[Ground::Correlated]);
    let score = &scores[0];
    assert_eq!(score.wrong, 0);
    let errors: Vec<f64> = score.rows.iter().flat_map(|r: &Row| r.errors.clone()).collect();
    assert!(
        score.rows.iter().all(|r| r.missed == 0) && errors.len() == 42,
        "{score:?}"
    );
    // The goal for 3 mm; six errors of 3 components are good to 1 / sqrt(36) = 17 %.
    assert!(score.rows.iter().all(|r| r.rms() <= 0.06 * 1.3), "{score:?}");
}

/// A short thin rod along the slices' normal, and a ball of half the radius, look like beads in slices of 2.5 mm and are not
/// among these (`docs/beads.md`).
#[test]
fn rods_plates_pairs_and_larger_balls_beside_bone_are_no_beads() {
    let Some(volume) = dense(HEAD) else {
        return;
    };
    let names = [
        "rod along x, radius 0.5, length 4",
        "rod along x, radius 1, length 5",
        "rod along z, radius 1, length 5",
        "ball of radius 1.80",
        "plate across slices",
        "two balls that touch",
    ];
    assert_eq!(taken("head", &volume, 1.0, 1, |name| names.contains(&name)), 0);
}

/// What is taken for a bead in `docs/beads.md`: `cargo test --release --test cli -- --ignored --nocapture real::table_of_bodies`.
#[test]
#[ignore = "minutes; prints the table of the documentation"]
fn table_of_bodies_in_real_cts() {
    for (what, path) in [("chest", CHEST), ("head", HEAD)] {
        if let Some(volume) = dense(path) {
            taken(what, &volume, 1.0, 6, |_| true);
        }
    }
}

/// The table of `docs/beads.md`: `cargo test --release --test cli -- --ignored --nocapture real::table`.
#[test]
#[ignore = "minutes; prints the table of the documentation"]
fn table_of_grounds_in_real_cts() {
    let all = [Ground::Constant, Ground::Sloping, Ground::Quadratic, Ground::Correlated];
    for (what, path, radius_mm) in [
        ("chest, 0.78 x 0.78 x 1 mm", CHEST, 1.0),
        ("chest, 0.78 x 0.78 x 1 mm", CHEST, 1.5),
        ("head phantom, tilted, 0.48 x 0.48 x 2.5 mm", HEAD, 1.0),
        (
            "abdomen, 3 x 3 x 3 mm",
            "data/ct-abdopelvis-nifti/example_ct.nii.gz",
            2.5,
        ),
    ] {
        if let Some(volume) = dense(path) {
            compared(what, &volume, radius_mm, 30, &all);
        }
    }
}
