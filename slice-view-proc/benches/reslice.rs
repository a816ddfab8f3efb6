//! How long slices of a usual CT take, how wrong they are, and how far that is from the least possible.
//!
//! `cargo bench -p slice-view-proc --bench reslice`. Images of 512 x 512 pixels of 0.5 mm from 512 x 512 x 400 voxels, one
//! thread, CPU time. In every round each contestant draws one image, each from another plane: whatever one leaves in
//! the caches is of no use to the next, but for the coherent path, where it is meant to be. The floor is a contestant
//! too: it reads one voxel of each cache line that a linear slice needs. Errors are distances from the f64 reference; those
//! of the nearest voxel come from pixels in the middle between two.
//!
//! Then the seven images of the default scene, along an approach.
//!
//! `--serve FOLDER` answers for `peers/reslice.py`, see [`serve`].

#![allow(
    clippy::print_stderr,
    clippy::print_stdout,
    reason = "the table is what this program is for"
)]

#[path = "reslice/floor.rs"]
mod floor;
#[path = "reslice/serve.rs"]
mod serve;
#[path = "reslice/sets.rs"]
mod sets;
#[path = "reslice/seven.rs"]
mod seven;
mod shared;

use bus::volume::OwnedVolume;
use floor::Floor;
use geometry::SlicePlane;
use scene::{Filter, Sampling};
use sets::{PLANES, SIDE, Set};
use shared::ct;
use shared::figures::{Errors, Times, cpu_ms, load};
use slice_view_proc::reslice::{Cpu, Reference, Resampler};

/// Planes between two contestants of one round.
const STRIDE: usize = 5;
/// Planes of each set that the reference draws too; it is slow.
const CHECKED: usize = 2;

fn main() {
    // Cargo adds --bench.
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let volume = ct::textured();
    match (arguments.next().as_deref(), arguments.next()) {
        (Some("--serve"), Some(folder)) => {
            if let Err(error) = serve::serve(&volume, folder.as_ref()) {
                eprintln!("reslice: error: {error}");
                std::process::exit(1);
            }
        }
        _ => tables(&volume),
    }
}

fn tables(volume: &OwnedVolume) {
    let mut bench = Bench::new(volume);
    println!(
        "{SIDE} x {SIDE} pixels of 0.5 mm from {:?} voxels, bricks {:?}; one thread, CPU time, median (least) of {PLANES} planes; {}",
        ct::DIMS,
        volume.layout.brick(),
        load()
    );
    for set in sets::all() {
        bench.table(&set);
    }
    seven::tables(volume);
    println!("\n{}", load());
}

/// The contestants, ready to draw.
struct Bench<'a> {
    volume: &'a OwnedVolume,
    vector: Cpu,
    portable: Cpu,
    reference: Reference,
    hu: Vec<f32>,
}

impl<'a> Bench<'a> {
    fn new(volume: &'a OwnedVolume) -> Self {
        let mut bench = Self {
            volume,
            vector: Cpu::default(),
            portable: Cpu::portable(),
            reference: Reference::default(),
            hu: vec![0.0; (SIDE * SIDE) as usize],
        };
        let all = Filter::ALL.map(Sampling::from);
        let resamplers: [&mut dyn Resampler; 3] = [&mut bench.vector, &mut bench.portable, &mut bench.reference];
        for resampler in resamplers {
            let prepared = resampler.prepare(&volume.view(), &all, &mut || {});
            prepared.expect("enough memory for the coefficients");
        }
        bench
    }

    fn table(&mut self, set: &Set) {
        let floors: Vec<Floor> = set.planes.iter().map(|p| Floor::new(&self.volume.view(), p)).collect();
        let mut times = vec![[Times::default(), Times::default()]; Filter::ALL.len()];
        let mut floor = Times::default();
        for round in 0..PLANES {
            let mut turn = 0;
            let mut next = || {
                turn += 1;
                (round + if set.coherent { 0 } else { turn * STRIDE }) % PLANES
            };
            for (filter, times) in Filter::ALL.into_iter().zip(&mut times) {
                let [vector, portable] = [next(), next()].map(|i| &set.planes[i]);
                times[0].push(draw(&mut self.vector, self.volume, vector, filter, &mut self.hu));
                times[1].push(draw(&mut self.portable, self.volume, portable, filter, &mut self.hu));
                floor.push(floors[next()].touch_ms(&self.volume.voxels));
            }
        }
        let lines = floors.iter().map(Floor::lines).sum::<usize>() / floors.len();
        println!(
            "\n{}: floor {:.2} ({:.2}) ms, {lines} lines on average",
            set.name,
            floor.median(),
            floor.least()
        );
        println!(
            "{:<10}{:>18}{:>8}{:>8}{:>18}{:>8}{:>16}{:>14}",
            "filter", "vector, ms", "ns/px", "floors", "portable, ms", "ns/px", "rms error, HU", "worst, HU"
        );
        for (filter, times) in Filter::ALL.into_iter().zip(times) {
            let errors = self.errors(set, filter);
            print_row(filter, &times, floor.median(), errors);
        }
    }

    /// RMS and worst difference from the reference; the back ends give the same bits.
    fn errors(&mut self, set: &Set, filter: Filter) -> [f64; 2] {
        let mut errors = Errors::default();
        let mut other = self.hu.clone();
        for plane in set.planes.iter().take(CHECKED) {
            draw(&mut self.reference, self.volume, plane, filter, &mut other);
            draw(&mut self.vector, self.volume, plane, filter, &mut self.hu);
            errors.add(&self.hu, other.iter().copied().map(f64::from));
            draw(&mut self.portable, self.volume, plane, filter, &mut other);
            assert!(self.hu == other, "vector and portable code differ");
        }
        let [rms, _, worst] = errors.summary();
        [rms, worst]
    }
}

/// Draws an image; returns the CPU time, ms.
fn draw(
    resampler: &mut dyn Resampler,
    volume: &OwnedVolume,
    plane: &SlicePlane,
    filter: Filter,
    hu: &mut [f32],
) -> f64 {
    cpu_ms(|| {
        let drawn = resampler.reslice(&volume.view(), plane, &filter.into(), hu);
        drawn.expect("prepared");
    })
}

fn print_row(filter: Filter, [vector, portable]: &[Times; 2], floor: f64, [rms, worst]: [f64; 2]) {
    let ms = |times: &Times| format!("{:.2} ({:.2})", times.median(), times.least());
    let ns = |times: &Times| times.median() * 1e6 / f64::from(SIDE * SIDE);
    println!(
        "{:<10}{:>18}{:>8.1}{:>8.1}{:>18}{:>8.1}{rms:>16.2e}{worst:>14.2e}",
        filter.name(),
        ms(vector),
        ns(vector),
        vector.median() / floor,
        ms(portable),
        ns(portable),
    );
}
