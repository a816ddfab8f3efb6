//! How long frames of the operator's screen take to paint on the CPU, and how far they are from the reference.
//!
//! `cargo bench -p window --bench paint`. Eight image cells with lines, circles and words, twelve words in a strip below; one
//! thread, CPU time of painting alone: what egui needs to make its triangles is in a column of its own. Images have 512 x 512
//! pixels and are scaled to their cells, or have the size of the cells and are copied. The error is the largest
//! difference of a level, 0 to 255, from a slow painter in `f64` with the same rule of sampling.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(dead_code, reason = "the tests use more of what is shared")]

#[path = "../tests/paint/reference.rs"]
mod reference;
#[path = "../tests/paint/screens.rs"]
mod screens;

use egui::Color32;
use reference::{Reference, difference};
use rustix::time::{ClockId, clock_gettime};
use screens::{CELLS, Content, Screen, lend, texels};
use window::paint::{CpuPainter, Frame, Image, Painter, Pixels};

const ROUNDS: u32 = 41;
const CLEAR: Color32 = Color32::BLACK;

/// What differs from one frame to the next.
#[derive(Debug, Clone, Copy)]
struct Case {
    name: &'static str,
    /// Images with another version in each frame.
    images: usize,
    /// Whether lines and words change.
    moves: bool,
    /// Age of the memory.
    age: u8,
}

const CASES: [Case; 5] = [
    Case {
        name: "nothing",
        images: 0,
        moves: false,
        age: 1,
    },
    Case {
        name: "one image",
        images: 1,
        moves: false,
        age: 1,
    },
    Case {
        name: "seven images",
        images: 7,
        moves: false,
        age: 1,
    },
    Case {
        name: "seven images, words, lines",
        images: 7,
        moves: true,
        age: 1,
    },
    Case {
        name: "all",
        images: 8,
        moves: true,
        age: 0,
    },
];

/// CPU time of this thread, ms.
fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 / 1e6
}

fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    format!("load {}", text.split_whitespace().next().unwrap_or("unknown"))
}

fn main() {
    println!(
        "CPU time of a frame, ms: median (least) of {ROUNDS}, one thread; {}",
        load()
    );
    println!(
        "{:<12}{:<8}{:<28}{:>16}{:>12}{:>14}{:>14}",
        "screen", "images", "changed", "painting", "egui", "damage, %", "error, levels"
    );
    for size in [[1280, 800], [1920, 1080], [3840, 2160]] {
        for is_copied in [false, true] {
            CASES.iter().for_each(|case| row(size, is_copied, *case));
        }
    }
    println!("{}", load());
}

fn row(size: [u32; 2], is_copied: bool, case: Case) {
    let density = if size[0] > 2000 { 2.0 } else { 1.0 };
    let screen = Screen::new(size, density);
    let side = if is_copied { screen.cells()[0][2] } else { 512 };
    let pixels: Vec<Vec<u8>> = (0..CELLS as u32).map(|i| texels([side, side], i)).collect();
    let mut painter = CpuPainter::new();
    let mut memory = vec![0; (size[0] * size[1]) as usize];
    let (mut painting, mut making, mut damaged, mut error) = (Vec::new(), Vec::new(), 0.0, 0.0);
    let mut reference = Reference::default();
    for round in 0..=ROUNDS {
        let began = cpu_ms();
        let moment = if case.moves { round } else { 0 };
        let mut made = screen.make(Content {
            moment,
            tint: Color32::WHITE,
        });
        let made_at = cpu_ms();
        reference.set(&made.textures);
        let images = versions(lend(&pixels, side, 0), case.images, round);
        let frame = Frame {
            size,
            pixels_per_point: density,
            clear: CLEAR,
            textures: &mut made.textures,
            primitives: &made.primitives,
            images: &images,
        };
        let age = if round == 0 { 0 } else { case.age };
        let target = Pixels {
            pixels: &mut memory,
            age,
        };
        let paint_began = cpu_ms();
        let painted = painter.paint(frame, target).expect("memory of this size");
        let painted_at = cpu_ms();
        // The first frame takes memory, which those after it do not.
        if round > 0 {
            painting.push(painted_at - paint_began);
            making.push(made_at - began);
            let area: f64 = painted.damage.iter().map(|a| f64::from(a.width() * a.height())).sum();
            damaged = 100.0 * area / f64::from(size[0] * size[1]);
        }
        if round == ROUNDS {
            images.iter().for_each(|image| reference.lend(image));
            error = difference(&memory, &reference.paint(size, density, CLEAR, &made.primitives));
        }
    }
    let screen = format!("{}x{}", size[0], size[1]);
    let images = if is_copied { "copied" } else { "scaled" };
    println!(
        "{screen:<12}{images:<8}{:<28}{:>16}{:>12.2}{damaged:>14.1}{error:>14}",
        case.name,
        format!("{:.2} ({:.2})", median(&mut painting), painting[0]),
        median(&mut making),
    );
}

/// The first `count` images with another version for each round.
fn versions(mut images: Vec<Image<'_>>, count: usize, round: u32) -> Vec<Image<'_>> {
    images
        .iter_mut()
        .take(count)
        .for_each(|image| image.version = u64::from(round) + 1);
    images
}

/// Sorts `times`.
fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}
