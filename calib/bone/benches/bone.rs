//! How exact a bone's surface is, on generated CTs, beside a threshold.
//!
//! `cargo bench -p bone --bench bone`; with words, the rows that hold one of them.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use bone::{Bone, Options, Region, extract};
use common::{Body, Cortex, Scene, grid, scan};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    println!(
        "{:<44} {:>6} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6} {:>6} {:>6}  scanner",
        "row", "kept", "bias", "sd", "sigma", "shared", "z rms", "in95", "lost", "s"
    );
    let ball = Body::Ball { radius: 18.0 };
    let shapes = [
        ("ball 18", ball),
        (
            "capsule 9",
            Body::Capsule {
                radius: 9.0,
                half: 15.0,
            },
        ),
        ("torus 22/8", Body::Torus { ring: 22.0, tube: 8.0 }),
        (
            "ellipsoid",
            Body::Ellipsoid {
                half: [24.0, 16.0, 11.0],
            },
        ),
    ];
    for (step, blur) in [(0.7, 0.45), (1.5, 0.8), (3.0, 1.3)] {
        for (shape, body) in shapes {
            for (name, cortex) in [
                ("0.5", Cortex::Even(0.5)),
                ("1", Cortex::Even(1.0)),
                ("1.5", Cortex::Even(1.5)),
                ("2", Cortex::Even(2.0)),
                ("3", Cortex::Even(3.0)),
                ("0.5..3", Cortex::Waves(0.5, 3.0)),
                ("1..3", Cortex::Waves(1.0, 3.0)),
            ] {
                let row = format!("{step} mm, {shape}, cortex {name}");
                if !words.is_empty() && !words.iter().any(|w| row.contains(w.as_str())) {
                    continue;
                }
                let hu: f64 = std::env::var("HU").map_or(1300.0, |v| v.parse().unwrap());
                let mut scene = Scene::new(body, cortex, step, blur);
                scene.hu[1] = hu;
                measure(&row, &scene);
            }
        }
    }
}

fn measure(row: &str, scene: &Scene) {
    let ct = scan(scene, grid(scene));
    let mut options = Options::of(Region::Number(1));
    options.threads = 2;
    if std::env::var("TOLD").is_ok() {
        options.blur_mm = Some(scene.blur_mm);
    }
    let start = Instant::now();
    match extract(&ct, &options) {
        Ok(bone) => report(row, scene, &bone, start.elapsed().as_secs_f64()),
        Err(refused) => println!("{row:<44} {refused}"),
    }
}

fn report(row: &str, scene: &Scene, bone: &Bone, seconds: f64) {
    let errors: Vec<f64> = bone.places.iter().map(|p| scene.body.distance(p.mm.into())).collect();
    let n = errors.len() as f64;
    let bias = errors.iter().sum::<f64>() / n;
    let sd = (errors.iter().map(|e| (e - bias).powi(2)).sum::<f64>() / n).sqrt();
    let z: Vec<f64> = bone.places.iter().zip(&errors).map(|(p, e)| e / p.total_mm()).collect();
    let rms = (z.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
    let within = z.iter().filter(|z| z.abs() < 1.96).count() as f64 / n * 100.0;
    let s = &bone.scanner;
    let lost: usize = bone.lost.values().sum();
    println!(
        "{row:<44} {:>6} {bias:>7.3} {sd:>7.3} {:>7.3} {:>7.3} {rms:>6.2} {within:>6.1} {lost:>6} {seconds:>6.1}  blur {:.2} {:.2} +- {:.3}, cortex {:.0} +- {:.0} x {:.2}, kurt {:.2} +- {:.2}, t {:.2} x {:.2}, noise {:.0} {:.2?}",
        bone.places.len(),
        bone.deviation_rms_mm(),
        bone.shared_rms_mm(),
        s.blur_mm[0],
        s.blur_mm[1],
        s.blur_relative[0],
        s.cortex_hu[0],
        s.cortex_hu[1],
        s.cortex_spread,
        s.kurtosis[0],
        s.kurtosis[1],
        s.log_thickness[0].exp(),
        s.log_thickness[1].exp(),
        s.noise_hu,
        s.noise_neighbours
    );
}
