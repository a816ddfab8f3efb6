//! How fast and how exact this machine's card is.

use super::super::super::Reference;
use super::*;

/// `cargo test --release -p slice-view-proc -- --ignored --nocapture figures`
#[test]
#[ignore = "prints figures of this machine's card; takes a minute"]
fn figures() {
    let volume = noise([512, 512, 400], [4, 4, 4]);
    let ways = [
        (GpuWeights::Exact, Filter::Nearest),
        (GpuWeights::Exact, Filter::Linear),
        (GpuWeights::Sampler, Filter::Linear),
        (GpuWeights::Exact, Filter::Cubic),
        (GpuWeights::Exact, Filter::Sinc3),
    ];
    let normals = [[0.0, 0.001, 1.0], [1.0, 0.001, 0.0], [0.3, 0.5, 0.8]];
    for (weights, filter) in ways {
        let Some(mut gpu) = card(weights) else { return };
        let sampling = Sampling::from(filter);
        gpu.prepare(&volume.view(), &[sampling], &mut || {}).unwrap();
        let upload_ms = gpu.timings().upload_ns as f64 / 1e6;
        println!(
            "{} {filter:?}: {} bytes, upload {upload_ms:.0} ms",
            gpu.name(),
            gpu.bytes()
        );
        for normal in normals {
            let plane = plane(&volume, [0.3; 3], normal, 0.5, [512, 512]).unwrap();
            let mut best = Timings {
                run_ns: i64::MAX,
                ..Timings::default()
            };
            let mut hu = Vec::new();
            for _ in 0..9 {
                hu = drawn(&mut gpu, &volume, &plane, &sampling);
                best = if gpu.timings().run_ns < best.run_ns {
                    gpu.timings()
                } else {
                    best
                };
            }
            let exact = drawn(&mut Reference::default(), &volume, &plane, &sampling);
            let off = |(a, b): (&f32, &f32)| f64::from((a - b).abs());
            let (worst, squares) = hu
                .iter()
                .zip(&exact)
                .map(off)
                .fold((0.0, 0.0), |(w, s), d| (d.max(w), s + d * d));
            let rms = (squares / hu.len() as f64).sqrt();
            let bound = gpu.error_bound_hu(&sampling, LARGEST_HU);
            let [plan, run, read] = [best.plan_ns, best.run_ns, best.read_ns].map(|ns| ns as f64 / 1e6);
            println!(
                "  {normal:?}: plan {plan:.2} run {run:.2} read {read:.2} ms; max {worst:.2e} rms {rms:.2e} bound {bound:.2e} HU"
            );
        }
    }
}
