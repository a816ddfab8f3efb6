//! The tables over the series.

use nalgebra::Vector2;
use optics::disc::{DetectOptions, detect};
use optics::grid::find;

use crate::common::grid_series::{Drawn, Scene, draw};
use crate::opencv::{Peer, peers};
use crate::{NOISES, TILTS, cpu_ms, errors, spec, thesis};

fn drawn(tilt_deg: f64, noise: f64, seed: u64) -> Drawn {
    draw(&Scene {
        tilt_deg,
        roll_deg: 17.0,
        noise,
        seed,
        ..Scene::default()
    })
}

/// Candidates, false ones and missed ones of the detector of single discs.
fn counted(drawn: &Drawn) -> [usize; 3] {
    let discs = detect(&drawn.image, &DetectOptions::new(1.5, 8.0)).unwrap();
    let near = (0.45 * drawn.least_pitch).max(1.5);
    let at = |d: &optics::disc::Disc| Vector2::new(d.at[0] as f64, d.at[1] as f64);
    let missed = drawn
        .centres
        .iter()
        .filter(|c| discs.iter().all(|d| (at(d) - **c).norm() > near));
    let missed = missed.count();
    [discs.len(), (discs.len() + missed).saturating_sub(100), missed]
}

/// What was seen in the images of one tilt and noise.
#[derive(Default)]
struct Line {
    pitch: f64,
    rms: Vec<f64>,
    ms: Vec<f64>,
    single: [usize; 3],
    chi: [usize; 3],
    /// Images in which the signature, and the angular correlation, gave both directions.
    directions: [usize; 2],
}

fn mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|e| e * e).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn line(images: &[Drawn]) -> Line {
    let mut line = Line::default();
    for drawn in images {
        line.pitch = drawn.least_pitch;
        let mut least = f64::MAX;
        for k in 0..3 {
            let start = cpu_ms();
            let found = find(&drawn.image, &spec());
            least = least.min(cpu_ms() - start);
            if k == 0 {
                line.rms.extend(found.ok().map(|f| errors(&f, drawn)[0]));
            }
        }
        line.ms.push(least);
        line.single.iter_mut().zip(counted(drawn)).for_each(|(a, b)| *a += b);
        let by_thesis = thesis::counted(drawn);
        line.chi.iter_mut().zip(by_thesis.counts).for_each(|(a, b)| *a += b);
        line.directions
            .iter_mut()
            .zip(by_thesis.directions)
            .for_each(|(a, b)| *a += usize::from(b));
    }
    line
}

fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().take(3).collect::<Vec<_>>().join(" ")
}

/// All tilts and noises, two images each.
pub(crate) fn tables(python: Option<&str>) {
    println!("load before: {}", load());
    println!(
        "ours: grids found of 2, rms error px, least CPU ms of 3 | OpenCV the same | single discs: candidates, false,"
    );
    println!(
        "missed of 200, ours and by the thesis's 5.4 | both directions found: signature 5.5, angular correlation 5.2.2"
    );
    for noise in NOISES {
        let mut totals = [0; 10];
        let mut times = [Vec::new(), Vec::new()];
        for tilt in TILTS {
            let (counts, of_row) = row(noise, tilt, python);
            totals.iter_mut().zip(counts).for_each(|(t, v)| *t += v);
            times.iter_mut().zip(of_row).for_each(|(all, more)| all.extend(more));
        }
        println!(
            "noise {noise}: ours {} of 22, OpenCV {} of 22; single discs of 2200: ours {:?}, 5.4 {:?}; directions {:?} of 22",
            totals[0],
            totals[1],
            &totals[2..5],
            &totals[5..8],
            &totals[8..]
        );
        let [ours, peer] = times.map(spread);
        println!("noise {noise}: CPU ms, least, median, most: ours {ours:.0?}, OpenCV {peer:.0?}");
    }
    println!("load after: {}", load());
}

/// The least, the median and the most; NaN of nothing.
fn spread(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    [0, values.len() / 2, last].map(|i| values.get(i).copied().unwrap_or(f64::NAN))
}

/// Prints the line of a noise and a tilt, and returns its counts, and the times of each image, ours and OpenCV's.
fn row(noise: f64, tilt: f64, python: Option<&str>) -> ([usize; 10], [Vec<f64>; 2]) {
    let images: Vec<Drawn> = (0..2).map(|seed| drawn(tilt, noise, seed)).collect();
    let line = line(&images);
    let known: Vec<_> = images.iter().map(|d| (&d.image, &*d.centres)).collect();
    let peer = python.map(|python| peers(python, &known)).unwrap_or_default();
    let ([a, b, c], [d, e, f], [g, h]) = (line.single, line.chi, line.directions);
    let least = line.ms.iter().copied().fold(f64::MAX, f64::min);
    let (found, rms) = (line.rms.len(), mean_square(&line.rms));
    println!(
        "{noise:4} {tilt:4} {:6.1} px |{found:2}/2 {rms:7.4} {least:7.1} |{} |{a:5}{b:5}{c:5} |{d:6}{e:6}{f:5} |{g:2} {h:2}",
        line.pitch,
        words(&peer),
    );
    let opencv = peer.iter().filter(|p| p.rms.is_some()).count();
    let times = [line.ms, peer.iter().map(|p| p.ms).collect()];
    ([found, opencv, a, b, c, d, e, f, g, h], times)
}

fn words(peers: &[Peer]) -> String {
    if peers.is_empty() {
        return "      not run       ".to_owned();
    }
    let rms: Vec<f64> = peers.iter().filter_map(|p| p.rms).collect();
    let ms = peers.iter().map(|p| p.ms).fold(f64::MAX, f64::min);
    format!("{:2}/2 {:7.4} {ms:7.1}", rms.len(), mean_square(&rms))
}

/// How many grids are found over so many seeds.
pub(crate) fn seeds(seeds: u64) {
    for noise in NOISES {
        let (mut total, mut times) = (0, Vec::new());
        for tilt in TILTS {
            let found: Vec<f64> = (0..seeds)
                .filter_map(|seed| {
                    let drawn = drawn(tilt, noise, 100 + seed);
                    let start = cpu_ms();
                    let found = find(&drawn.image, &spec());
                    times.push(cpu_ms() - start);
                    found.ok().map(|f| errors(&f, &drawn)[0])
                })
                .collect();
            total += found.len();
            println!(
                "noise {noise:4} tilt {tilt:4}: {:3} of {seeds}, {:.4} px",
                found.len(),
                mean_square(&found)
            );
        }
        let (of, ms) = (seeds * TILTS.len() as u64, spread(times));
        println!("noise {noise:4}: {total} of {of}, CPU ms, least, median, most: {ms:.0?}");
    }
}
