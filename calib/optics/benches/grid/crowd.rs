//! What thousands of candidates cost: images full of small discs, in rows and scattered, none the grid that is asked for.

use optics::grid::{GridRefused, find};
use optics::image::Image;

use crate::common::Random;
use crate::common::grid_series::SIDE;
use crate::{cpu_ms, spec};

/// Dark discs of a third of `pitch` about places, with an edge of a pixel and noise of 2.
fn image(places: &[[f64; 2]], radius: f64) -> Image {
    let mut random = Random::new(5);
    let mut grey = vec![200.0_f64; SIDE * SIDE];
    for [x, y] in places {
        let range = |v: f64| ((v - radius - 1.0).max(0.0) as usize)..((v + radius + 2.0).min(SIDE as f64) as usize);
        for i in range(*y) {
            for j in range(*x) {
                let off = (j as f64 - x).hypot(i as f64 - y);
                let inside = (radius + 0.5 - off).clamp(0.0, 1.0);
                grey[i * SIDE + j] -= 160.0 * inside;
            }
        }
    }
    let byte = |v: &f64| (v.max(40.0) + 2.0 * random.normal()).clamp(0.0, 255.0).round() as u8;
    let bytes: Vec<u8> = grey.iter().map(byte).collect();
    Image::from_bytes(SIDE, SIDE, &bytes).unwrap()
}

/// As many discs as fit at a distance, in rows, or as many anywhere.
fn places(pitch: f64, scattered: bool) -> Vec<[f64; 2]> {
    let n = (SIDE as f64 / pitch) as usize;
    let mut random = Random::new(9);
    let place = |i: usize| match scattered {
        true => [SIDE as f64 * random.unit(), SIDE as f64 * random.unit()],
        false => [i % n, i / n].map(|k| (k as f64 + 0.5) * pitch),
    };
    (0..n * n).map(place).collect()
}

/// Prints the time for each number of discs.
pub(crate) fn run() {
    for pitch in [40.0, 20.0, 14.0, 10.0, 8.0, 6.0] {
        for scattered in [false, true] {
            let places = places(pitch, scattered);
            let image = image(&places, pitch / 3.0);
            let mut least = f64::MAX;
            let mut said = String::new();
            for _ in 0..3 {
                let start = cpu_ms();
                let found = find(&image, &spec());
                least = least.min(cpu_ms() - start);
                said = found
                    .err()
                    .map_or_else(|| "found".to_owned(), |e: GridRefused| e.to_string());
            }
            let how = if scattered { "anywhere" } else { "in rows" };
            println!("{:5} discs {how}: {least:6.1} ms of CPU; {said}", places.len());
        }
    }
}
