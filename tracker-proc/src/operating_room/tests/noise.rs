//! The localizer's noise and its steps.

use super::*;

/// Errors of the tool's emitters: across (two numbers) and along the line of sight, with the distance.
fn errors(room: &OperatingRoom, frames: u64) -> Vec<([f64; 3], f64)> {
    let body = room.chain(middle()).unwrap().marker;
    let mut errors = Vec::new();
    for seq in 0..frames {
        let frame = room.frame(seq);
        for sighting in &frame.tool {
            let place = frame.tracker_from_marker * body.emitters()[sighting.emitter].place;
            let way = place - Point::new(0.0, 0.0, 0.0);
            let along = way.direction().unwrap();
            // Two directions across it, by hand.
            let side = along.cross(geometry::Direction::X).direction().unwrap();
            let up = along.cross(side).direction().unwrap();
            let off = sighting.place - place;
            let parts = [side, up, along].map(|axis| axis.vector().dot(off));
            errors.push((parts, way.norm()));
        }
    }
    errors
}

#[test]
fn noise_has_the_stated_size_along_each_direction_and_distance() {
    for away in [1150.0, 2300.0, 4600.0] {
        let place = format!("[tracker.ct_from_tracker]\ntranslation_mm = [0, 0, -{away}]");
        let scene = scene("", &place);
        let room = approached(&scene, 4);
        let errors = errors(&room, 4000);
        let count = errors.len() as f64;
        for axis in 0..3 {
            // In units of what the formula says: 0.1 (d / 2300) across, 0.15 (d / 2300)^2 along.
            let scaled = errors.iter().map(|(e, d)| {
                let grown = d / 2300.0;
                e[axis] / if axis < 2 { 0.1 * grown } else { 0.15 * grown * grown }
            });
            let scaled: Vec<f64> = scaled.collect();
            let mean = scaled.iter().sum::<f64>() / count;
            let deviation = (scaled.iter().map(|x| x * x).sum::<f64>() / count).sqrt();
            // Five standard errors: of a mean 1 / sqrt(n), of a deviation 1 / sqrt(2 n).
            assert!(mean.abs() < 5.0 / count.sqrt(), "{away} {axis}: mean {mean}");
            assert!(
                (deviation - 1.0).abs() < 5.0 / (2.0 * count).sqrt(),
                "{away} {axis}: {deviation}"
            );
        }
        let mixed: f64 = errors.iter().map(|(e, _)| e[0] * e[2]).sum::<f64>() / count;
        let size: f64 = errors.iter().map(|(e, _)| (e[0] * e[2]).powi(2)).sum::<f64>() / count;
        assert!(
            mixed.abs() < 5.0 * (size / count).sqrt(),
            "{away}: across and along go together"
        );
    }
}

#[test]
fn frames_and_emitters_err_independently() {
    let room = approached(
        &scene(
            "",
            "[tracker.room.marker]\ncone_deg = 180\n[tracker.room.reference]\ncone_deg = 180",
        ),
        4,
    );
    let chain = room.chain(middle()).unwrap();
    let reference = chain.reference.unwrap();
    let depth = |seq: u64| -> Vec<f64> {
        let frame = room.frame(seq);
        let tool = frame
            .tool
            .iter()
            .map(|s| (s, frame.tracker_from_marker * chain.marker.emitters()[s.emitter].place));
        let on_patient = frame.tracker_from_reference.unwrap();
        let patient = frame
            .reference
            .iter()
            .map(|s| (s, on_patient * reference.emitters()[s.emitter].place));
        tool.chain(patient)
            .map(|(s, place)| (s.place - place).mm()[2])
            .collect()
    };
    let drawn: Vec<Vec<f64>> = (0..2000).map(depth).collect();
    let correlation = |a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64| {
        let sum = |f: &dyn Fn(usize) -> f64| (0..1999).map(f).sum::<f64>();
        sum(&|i| a(i) * b(i)) / (sum(&|i| a(i) * a(i)) * sum(&|i| b(i) * b(i))).sqrt()
    };
    // A correlation of 1999 independent pairs deviates by 1 / sqrt(1999); five of those.
    let most = 5.0 / 1999.0_f64.sqrt();
    let last = drawn[0].len() - 1;
    assert!(correlation(&|i| drawn[i][0], &|i| drawn[i][1]).abs() < most);
    assert!(correlation(&|i| drawn[i][0], &|i| drawn[i][last]).abs() < most);
    assert!(correlation(&|i| drawn[i][0], &|i| drawn[i + 1][0]).abs() < most);
    assert!(correlation(&|i| drawn[i][0], &|i| drawn[i][0]) > 0.99);
}

#[test]
fn steps_round_without_bias() {
    let step = 0.1;
    let room = approached(&scene(&format!("{QUIET}\nquantisation_mm = {step}"), ""), 2);
    let body = room.chain(middle()).unwrap().marker;
    let (mut sum, mut squares, mut count) = ([0.0; 3], 0.0, 0.0);
    for seq in 0..2000 {
        let frame = room.frame(seq);
        for sighting in &frame.tool {
            let place = frame.tracker_from_marker * body.emitters()[sighting.emitter].place;
            for (axis, mm) in sighting.place.mm().into_iter().enumerate() {
                // A coordinate of 2000 mm is rounded to 2.3e-13 mm, 2.3e-12 steps.
                assert!(((mm / step) - (mm / step).round()).abs() < 1e-11);
                let off = mm - place.mm()[axis];
                assert!(off.abs() <= step / 2.0 + 1e-12, "{off}");
                sum[axis] += off;
                squares += off * off / 3.0;
            }
            count += 1.0;
        }
    }
    // Uniform over a step: deviation step / sqrt(12). Emitters at rest repeat their rounding in every frame of the pause, and
    // neighbouring frames are alike, so that a tenth of them is taken as independent.
    let five = 5.0 * step / (12.0 * count / 10.0_f64).sqrt();
    assert!(sum.iter().all(|s| (s / count).abs() < five), "{sum:?} {count}");
    let deviation = (squares / count).sqrt() / (step / 12.0_f64.sqrt());
    assert!((deviation - 1.0).abs() < 0.05, "{deviation}");
    // The chain is told of it.
    let localizer = room.chain(middle()).unwrap().localizer;
    assert_eq!(localizer.step_mm, step);
}
