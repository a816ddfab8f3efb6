//! `calib discs`: all discs of a drawn image, dark and bright, and bad input refused by name.

use std::fs;
use std::process::Output;

use crate::support::*;
use serde_json::Value;

const SIDE: usize = 160;
/// Middles and radii, pixels; the last lies across the border.
const DISCS: [[f64; 3]; 4] = [
    [40.2, 37.6, 6.0],
    [110.7, 48.1, 9.0],
    [70.4, 118.9, 4.5],
    [151.0, 120.0, 7.0],
];

/// Dark discs on a slope of grey, with a little noise; `bright` turns it round.
fn view(bright: bool) -> Vec<u8> {
    let grey = |x: f64, y: f64| {
        let inside = DISCS.iter().any(|d| (x - d[0]).hypot(y - d[1]) < d[2]);
        if inside { 60.0 } else { 170.0 + 0.1 * x }
    };
    let pixel = |i: usize| {
        let (x, y) = ((i % SIDE) as f64, (i / SIDE) as f64);
        let parts = (0..36).map(|k| grey(x + (f64::from(k % 6) - 2.5) / 6.0, y + (f64::from(k / 6) - 2.5) / 6.0));
        let noise = ((i.wrapping_mul(2_654_435_761) >> 7) % 7) as f64 - 3.0;
        let value = (parts.sum::<f64>() / 36.0 + noise).round() as u8;
        if bright { 255 - value } else { value }
    };
    let mut file = format!("P5 {SIDE} {SIDE} 255\n").into_bytes();
    file.extend((0..SIDE * SIDE).map(pixel));
    file
}

fn run(world: &World, name: &str, bytes: &[u8], more: &[&str]) -> Output {
    let path = world.path(name);
    fs::write(&path, bytes).unwrap();
    world.output("calib", &[&["discs", path.to_str().unwrap()][..], more].concat())
}

#[test]
fn dark_and_bright_discs_are_found_where_they_are() {
    let world = World::new();
    for (bright, polarity) in [(false, "dark"), (true, "bright")] {
        let seen = world.path(&format!("{polarity}.png"));
        let more = [
            "--polarity",
            polarity,
            "--radius-min",
            "3",
            "--radius-max",
            "12",
            "--json",
            "--overlay",
        ];
        let output = run(
            &world,
            "view.pgm",
            &view(bright),
            &[&more[..], &[seen.to_str().unwrap()]].concat(),
        );
        assert!(output.status.success(), "{}", stderr(&output));
        let file: Value = serde_json::from_str(&stdout(&output)).unwrap();
        let discs = file["discs"].as_array().unwrap();
        assert_eq!(discs.len(), DISCS.len(), "{polarity}: {discs:?}");
        for [x, y, _] in &DISCS[..3] {
            let off = |d: &Value| (d["x_px"].as_f64().unwrap() - x).hypot(d["y_px"].as_f64().unwrap() - y);
            let nearest = discs.iter().map(off).fold(f64::MAX, f64::min);
            // Noise of 2 steps on 110 with radii from 4.5 px: 0.015 px; three of that.
            assert!(nearest < 0.05, "{polarity} {x} {y}: {nearest}");
        }
        let overlay = image::open(&seen).unwrap();
        assert_eq!([overlay.width() as usize, overlay.height() as usize], [SIDE; 2]);
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let world = World::new();
    let said = |name: &str, bytes: &[u8], more: &[&str]| {
        let output = run(&world, name, bytes, more);
        assert!(!output.status.success(), "{name}: {}", stdout(&output));
        stderr(&output)
    };
    for (name, bytes, word) in [
        ("none.pgm", &b"P5 0 0 255\n"[..], "none.pgm"),
        ("one.pgm", b"P5 1 1 255\n\x05", "1 x 1 pixels"),
        ("two.pgm", b"P5 2 1 255\n\x05\x06", "2 x 1 pixels"),
        ("huge.pgm", b"P5 20000 20000 255\n", "20000 x 20000"),
        ("short.pgm", b"P5 40 40 255\nabc", "damaged"),
    ] {
        let text = said(name, bytes, &[]);
        assert!(text.contains(word) && !text.contains("panicked"), "{name}: {text}");
    }
    let radii = said("view.pgm", &view(false), &["--radius-min", "9", "--radius-max", "4"]);
    assert!(radii.contains("radii from 9 to 4"), "{radii}");
    // Nothing there is no error: an empty list.
    let mut constant = b"P5 64 64 255\n".to_vec();
    constant.extend([9; 64 * 64]);
    let output = run(&world, "constant.pgm", &constant, &["--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let file: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(file["discs"].as_array().unwrap().len(), 0);
}
