//! Each filter on each back end: its time and its error.

use std::fmt::Write;

use bus::clock::monotonic_ns;
use geometry::SlicePlane;
use scene::{Filter, GpuWeights, Sampling};
use slice_view_proc::reslice::{Cpu, Gpu, Reference, Resampler};

use crate::fields::Field;
use crate::shared::figures::{Errors, Times, cpu_ms};
use crate::shared::planes::{Random, square};

/// Pixels a side.
pub(crate) const SIZES: [u32; 3] = [256, 512, 1024];
/// What an image shows, mm: inside the volume in every direction, and on pixels below a voxel.
const FIELD_MM: f64 = 150.0;
/// How far from the volume's middle, mm.
const REACH_MM: f64 = 25.0;
pub(crate) const PLANES: usize = 2;
const ROUNDS: usize = 9;
/// After this much time a contestant draws no more: the slow ones take seconds an image, and vary less.
const ENOUGH_MS: f64 = 300.0;

/// Who samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BackEnd {
    Vector,
    Portable,
    Reference,
    /// A graphics card, or a program that stands for one, with weights of our own.
    Gpu,
    /// The same with the sampler's weights.
    Sampler,
}

impl BackEnd {
    pub(crate) const ALL: [Self; 5] = [Self::Vector, Self::Portable, Self::Reference, Self::Gpu, Self::Sampler];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Vector => "cpu",
            Self::Portable => "cpu-portable",
            Self::Reference => "reference",
            Self::Gpu => "gpu",
            Self::Sampler => "gpu-sampler",
        }
    }

    /// `None` where there is no card.
    pub(crate) fn resampler(self) -> Option<Box<dyn Resampler>> {
        Some(match self {
            Self::Vector => Box::new(Cpu::default()),
            Self::Portable => Box::new(Cpu::portable()),
            Self::Reference => Box::new(Reference::default()),
            Self::Gpu => Box::new(Gpu::of_any_kind(GpuWeights::Exact).ok()?),
            Self::Sampler => Box::new(Gpu::of_any_kind(GpuWeights::Sampler).ok()?),
        })
    }

    /// Other filters than linear are the same with and without the sampler.
    fn draws(self, filter: Filter) -> bool {
        self != Self::Sampler || filter == Filter::Linear
    }

    /// How long `work` takes, ms: on a card until the results are there, elsewhere the CPU's time.
    pub(crate) fn time(self, work: impl FnOnce()) -> f64 {
        match self {
            Self::Vector | Self::Portable | Self::Reference => cpu_ms(work),
            Self::Gpu | Self::Sampler => {
                let began = monotonic_ns();
                work();
                (monotonic_ns() - began) as f64 / 1e6
            }
        }
    }

    /// The reference takes seconds an image and is no contestant.
    fn planes(self) -> usize {
        if self == Self::Reference { 1 } else { PLANES }
    }
}

/// One point of the curve.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) filter: Filter,
    pub(crate) back_end: BackEnd,
    pub(crate) size: u32,
    pub(crate) ms: f64,
    /// RMS, 99th percentile, and largest, HU.
    pub(crate) error: [f64; 3],
}

/// An image with what it should be.
pub(crate) struct Task {
    pub(crate) plane: SlicePlane,
    pub(crate) truth: Vec<f64>,
}

/// All points of the curve for a field.
pub(crate) fn measure(field: &Field) -> Vec<Row> {
    let found = BackEnd::ALL.into_iter();
    let mut back_ends: Vec<_> = found.filter_map(|b| Some((b, b.resampler()?))).collect();
    for (back_end, resampler) in &mut back_ends {
        let drawn = Filter::ALL.into_iter().filter(|filter| back_end.draws(*filter));
        let samplings: Vec<Sampling> = drawn.map(Sampling::from).collect();
        let prepared = resampler.prepare(&field.volume.view(), &samplings, &mut || {});
        prepared.expect("enough memory for the coefficients");
        println!("{}: {}", back_end.name(), resampler.name());
    }
    let mut rows = Vec::new();
    for size in SIZES {
        let tasks = tasks(field, size);
        for filter in Filter::ALL {
            rows.extend(race(field, filter, size, &tasks, &mut back_ends));
        }
    }
    rows
}

pub(crate) fn tasks(field: &Field, size: u32) -> Vec<Task> {
    // The same planes for each size and field.
    let mut random = Random::new(8);
    let pixel_mm = FIELD_MM / f64::from(size);
    let mut task = || {
        let plane = square(random.point(REACH_MM), random.axes(), pixel_mm, size);
        let pixels = (0..size).flat_map(|y| (0..size).map(move |x| (f64::from(x), f64::from(y))));
        Task {
            truth: pixels.map(|(x, y)| (field.truth)(plane.point(x, y))).collect(),
            plane,
        }
    };
    (0..PLANES).map(|_| task()).collect()
}

/// One filter on one size: the back ends take turns.
fn race(
    field: &Field,
    filter: Filter,
    size: u32,
    tasks: &[Task],
    back_ends: &mut [(BackEnd, Box<dyn Resampler>)],
) -> Vec<Row> {
    let mut results = vec![(Times::default(), Errors::default()); back_ends.len()];
    let mut hu = vec![0.0; (size * size) as usize];
    for round in 0..ROUNDS {
        for (i, task) in tasks.iter().enumerate() {
            for ((back_end, resampler), (times, errors)) in back_ends.iter_mut().zip(&mut results) {
                let enough = i >= back_end.planes() || (round > 0 && times.total() > ENOUGH_MS);
                if enough || !back_end.draws(filter) {
                    continue;
                }
                times.push(back_end.time(|| {
                    let drawn = resampler.reslice(&field.volume.view(), &task.plane, &filter.into(), &mut hu);
                    drawn.expect("prepared");
                }));
                // All on the same pixels: the reference has only these.
                if round == 0 && i == 0 {
                    errors.add(&hu, task.truth.iter().copied());
                }
            }
        }
    }
    let row = |((back_end, _), (times, errors)): (&(BackEnd, _), (Times, Errors))| Row {
        filter,
        back_end: *back_end,
        size,
        ms: times.median(),
        error: errors.summary(),
    };
    let drawn = back_ends.iter().zip(results).filter(|((b, _), _)| b.draws(filter));
    drawn.map(row).collect()
}

/// The rows for people.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<10}{:<14}{:>6}{:>10}{:>12}{:>12}{:>12}\n",
        "filter", "back end", "size", "ms", "RMS, HU", "p99, HU", "max, HU"
    );
    for row in rows {
        let [rms, p99, max] = row.error;
        let _ = writeln!(
            text,
            "{:<10}{:<14}{:>6}{:>10.2}{rms:>12.3}{p99:>12.3}{max:>12.3}",
            row.filter.name(),
            row.back_end.name(),
            row.size,
            row.ms
        );
    }
    text
}
