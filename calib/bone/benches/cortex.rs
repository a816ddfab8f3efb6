//! What of vessels with contrast is taken for bone, and what of bone is not: on generated CTs and on the generated patient.
//!
//! `cargo bench -p bone --bench cortex`; with words, the rows that hold one of them.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]
#![allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
#![allow(dead_code, reason = "generated CTs are shared with the tests")]

#[path = "../tests/common/mod.rs"]
mod common;

use bone::{Bone, Options, Region, Voxels, extract};
use common::{Body, Cortex, Scene, Vessel, grid, scan};
use geometry::{Point, VolumeGrid};
use phantom::Phantom;

/// Whose surface a place is of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Whose {
    Bone,
    Vessel,
    /// Of the groove between both.
    Both,
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let is_asked = |row: &str| words.is_empty() || words.iter().any(|w| row.contains(w.as_str()));
    println!("row | bone: with a say, marked, left out | vessel: the same, % of area");
    for step in [1.0, 1.5, 3.0] {
        let row = format!("patient, {step} mm");
        if is_asked(&row) {
            patient(&row, step);
        }
    }
    for (step, blur) in [(0.7, 0.45), (1.5, 0.8), (3.0, 1.3)] {
        for cortex in [0.5, 1.0, 1.5, 2.0, 3.0] {
            for hu in [0.0, 150.0, 250.0, 350.0, 400.0] {
                let row = format!("{step} mm, cortex {cortex}, vessel {hu}");
                if is_asked(&row) {
                    generated(&row, (step, blur), Cortex::Even(cortex), hu);
                }
            }
        }
    }
}

fn generated(row: &str, (step, blur): (f64, f64), cortex: Cortex, hu: f64) {
    let body = Body::Capsule {
        radius: 9.0,
        half: 12.0,
    };
    let mut scene = Scene::new(body, cortex, step, blur);
    let vessel = Vessel {
        ends: [[14.0, -16.0, 0.0], [14.0, 16.0, 3.0]],
        radius: 5.0,
        hu,
    };
    scene.margin_mm = 16.0;
    scene.noise_hu = 20.0;
    if hu > 0.0 {
        scene.vessel = Some(vessel);
    }
    let ct = scan(&scene, grid(&scene));
    let whose = |p: [f64; 3]| {
        let (bone, vessel) = (
            body.distance(p).abs(),
            if hu > 0.0 { vessel.distance(p).abs() } else { 1e3 },
        );
        match bone - vessel {
            d if d > 1.0 => Whose::Vessel,
            d if d < -1.0 => Whose::Bone,
            _ => Whose::Both,
        }
    };
    tell(row, &ct, Region::Seed { mm: [0.0, 0.0, 8.0] }, &whose);
}

struct Patient(VolumeGrid, Vec<i16>);

impl Voxels for Patient {
    fn grid(&self) -> &VolumeGrid {
        &self.0
    }
    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        let [nx, ny, _] = self.0.dims().map(|d| d as usize);
        out.copy_from_slice(&self.1[(z as usize * ny + y as usize) * nx..][..nx]);
    }
}

/// Bone has 550 HU and more within 2.5 mm of its surface, a vessel nowhere.
fn patient(row: &str, step: f64) {
    let phantom = Phantom::new(1);
    let grid = phantom.grid([step; 3]).unwrap();
    let [nx, ny, nz] = grid.dims();
    let plane = (nx * ny) as usize;
    let mut hu = vec![0; plane * nz as usize];
    for (k, slice) in (0..).zip(hu.chunks_exact_mut(plane)) {
        phantom.fill_slice(&grid, k, slice);
    }
    let brightest = |p: [f64; 3], within: f64| {
        let mut most = f64::NEG_INFINITY;
        for i in -5..=5_i32 {
            for j in -5..=5_i32 {
                for k in -5..=5_i32 {
                    let d = [i, j, k].map(|n| f64::from(n) * within / 5.0);
                    if d.iter().map(|x| x * x).sum::<f64>() <= within * within {
                        most = most.max(phantom.hu(Point::new(p[0] + d[0], p[1] + d[1], p[2] + d[2])));
                    }
                }
            }
        }
        most
    };
    let whose = |p: [f64; 3]| match (brightest(p, 2.5) >= 550.0, brightest(p, 4.0) >= 550.0) {
        (true, _) => Whose::Bone,
        (false, false) => Whose::Vessel,
        _ => Whose::Both,
    };
    let region = Region::Box {
        corners_mm: [[0.0, -100.0, -150.0], [140.0, 100.0, 0.0]],
    };
    tell(row, &Patient(grid, hu), region, &whose);
}

fn tell(row: &str, ct: &dyn Voxels, region: Region<'_>, whose: &dyn Fn([f64; 3]) -> Whose) {
    let mut options = Options::of(region);
    options.threads = 2;
    options.takes_no_cortex = true;
    let before = extract(ct, &options).map(|bone| area(&bone, &bone.triangles, whose));
    options.takes_no_cortex = false;
    let before = before.unwrap_or_default();
    let start = std::time::Instant::now();
    let bone = match extract(ct, &options) {
        Ok(bone) => bone,
        Err(refused) => return println!("{row} | {refused}"),
    };
    let [with, marked] = [&bone.triangles, &bone.unseen].map(|t| area(&bone, t, whose));
    let left: Vec<String> = bone
        .bare
        .iter()
        .take(4)
        .map(|b| format!("{:.0} mm2 {:.0} HU {:.0?}", b.area_mm2, b.hu, b.centre_mm))
        .collect();
    println!(
        "{row} | before {before:.0?}, say {with:.0?}, marked {marked:.0?}, left {} {}; {:.0} s",
        bone.bare.len(),
        left.join("; "),
        start.elapsed().as_secs_f64()
    );
}

fn area(bone: &Bone, triangles: &[[u32; 3]], whose: &dyn Fn([f64; 3]) -> Whose) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for t in triangles {
        let [a, b, c] = t.map(|i| bone.places[i as usize].mm);
        let at = (a + b + c) / 3.0;
        sums[whose(at.into()) as usize] += 0.5 * (b - a).cross(&(c - a)).norm();
    }
    sums
}
