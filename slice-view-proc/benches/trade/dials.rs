//! The dials of an image of 512 x 512 pixels, one at a time.

use geometry::Point;
use phantom::Phantom;
use scene::{Filter, Sampling, Slab, SlabMode};
use slice_view_proc::reslice::{Cpu, Resampler};

use crate::fields::{self, Field};
use crate::measure::{BackEnd, PLANES, Task, tasks};
use crate::row::{Dial, Row, Trade, rms, turns};
use crate::shared::ct;
use crate::shared::planes::Random;

const SIZE: u32 = 512;
/// Deviation of a voxel in the slab's examination, HU.
const NOISE_HU: f64 = 30.0;

const PATIENT: &str = "root mean square of oblique planes to the generated patient with edges sharper than voxels";
const WAVES: &str = "root mean square of two oblique planes to a sum of waves of at most 0.2 cycles a voxel that are stored as whole HU";

/// Each dial, with a field made once for those who share it.
pub(crate) fn measure(trade: &Trade) {
    let waves = fields::waves("waves", 0.2);
    filters(trade, "filter", WAVES, &waves);
    drop(waves);
    let patient = fields::patient();
    filters(trade, "filter-at-edges", PATIENT, &patient);
    back_ends(trade, &patient);
    drop(patient);
    slabs(trade);
    spacings(trade);
}

fn dial(name: &'static str, chosen: &str, against: &'static str) -> Dial {
    Dial {
        name,
        chosen: chosen.to_owned(),
        time_unit: "ms an image of 512 x 512",
        error_unit: "HU",
        against,
    }
}

fn rounds(trade: &Trade) -> usize {
    trade.rounds(1, 9)
}

/// Median milliseconds an image and root mean square error of each sampling.
fn race(trade: &Trade, field: &Field, samplings: &[Sampling]) -> Vec<(f64, f64)> {
    let mut cpu = Cpu::default();
    let prepared = cpu.prepare(&field.volume.view(), samplings, &mut || {});
    prepared.expect("enough memory for the coefficients");
    let tasks = tasks(field, SIZE);
    let mut hu = vec![0.0; (SIZE * SIZE) as usize];
    let mut draw = |sampling: &Sampling, task: &Task| -> f64 {
        let drawn = cpu.reslice(&field.volume.view(), &task.plane, sampling, &mut hu);
        drawn.expect("prepared");
        rms(hu.iter().zip(&task.truth).map(|(v, t)| f64::from(*v) - t))
    };
    let errors: Vec<f64> = samplings
        .iter()
        .map(|s| rms(tasks.iter().map(|task| draw(s, task))))
        .collect();
    let mut hu = vec![0.0; (SIZE * SIZE) as usize];
    let times = turns(rounds(trade), samplings.len(), |k| {
        for task in &tasks {
            let drawn = cpu.reslice(&field.volume.view(), &task.plane, &samplings[k], &mut hu);
            drawn.expect("prepared");
        }
    });
    times.into_iter().map(|s| 1e3 * s / PLANES as f64).zip(errors).collect()
}

fn filters(trade: &Trade, name: &'static str, against: &'static str, field: &Field) {
    let measured = race(trade, field, &Filter::ALL.map(Sampling::from));
    let row = |(filter, (ms, hu)): (Filter, (f64, f64))| -> Row { (filter.name().to_owned(), ms, hu) };
    let rows: Vec<Row> = Filter::ALL.into_iter().zip(measured).map(row).collect();
    trade.write(&dial(name, Filter::default().name(), against), &rows);
}

/// All with the default filter. A card's time is the wall's, until the image is there.
fn back_ends(trade: &Trade, field: &Field) {
    let sampling = Sampling::from(Filter::default());
    let task = &tasks(field, SIZE)[0];
    let mut hu = vec![0.0; (SIZE * SIZE) as usize];
    let row = |back_end: BackEnd| -> Option<Row> {
        let mut resampler = back_end.resampler()?;
        resampler.prepare(&field.volume.view(), &[sampling], &mut || {}).ok()?;
        let mut draw = || {
            let drawn = resampler.reslice(&field.volume.view(), &task.plane, &sampling, &mut hu);
            drawn.expect("prepared");
        };
        draw();
        let times = (0..rounds(trade)).map(|_| back_end.time(&mut draw)).collect();
        let error = rms(hu.iter().zip(&task.truth).map(|(v, t)| f64::from(*v) - t));
        let name = match back_end {
            BackEnd::Gpu | BackEnd::Sampler => format!("{}: {}", back_end.name(), resampler.name().replace(',', ";")),
            _ => back_end.name().to_owned(),
        };
        Some((name, crate::row::median(times), error))
    };
    let rows: Vec<Row> = BackEnd::ALL.into_iter().filter_map(row).collect();
    trade.write(&dial("back-end", BackEnd::Vector.name(), PATIENT), &rows);
}

/// Thick slices of a noisy examination: what they gain in noise they lose in sharpness.
fn slabs(trade: &Trade) {
    let phantom = Phantom::new(phantom::DEFAULT_SEED);
    let grid = ct::grid(ct::DIMS, ct::SPACING_MM);
    let mut random = Random::new(3);
    let field = Field {
        name: "noisy patient",
        volume: ct::volume(grid, |z, slice| {
            phantom.fill_slice(&grid, z, slice);
            // Uniform in -1..1 has a deviation of a root of a third.
            slice
                .iter_mut()
                .for_each(|hu| *hu += (NOISE_HU * 3.0_f64.sqrt() * random.number()).round() as i16);
        }),
        truth: Box::new(move |p| phantom.hu(p)),
    };
    let thicknesses = [0.0, 1.0, 2.0, 5.0, 10.0];
    let samplings = thicknesses.map(|thickness_mm| Sampling {
        slab: (thickness_mm > 0.0).then_some(Slab {
            mode: SlabMode::Mean,
            thickness_mm,
        }),
        ..Sampling::from(Filter::default())
    });
    let measured = race(trade, &field, &samplings);
    let name = |mm: f64| {
        if mm > 0.0 {
            format!("mean of {mm} mm")
        } else {
            "none".to_owned()
        }
    };
    let row = |(mm, (ms, hu)): (f64, (f64, f64))| -> Row { (name(mm), ms, hu) };
    let rows: Vec<Row> = thicknesses.into_iter().zip(measured).map(row).collect();
    let against = "root mean square of two oblique planes to the generated patient in the plane itself; voxels of 0.7 mm with noise of 30 HU";
    trade.write(&dial("slab", "none", against), &rows);
}

/// The generated patient at other distances between voxels.
fn spacings(trade: &Trade) {
    let row = |mm: f64| -> Row {
        let phantom = Phantom::new(phantom::DEFAULT_SEED);
        let grid = phantom.grid([mm; 3]).expect("a usual grid");
        let field = Field {
            name: "patient",
            volume: ct::volume(grid, |z, slice| phantom.fill_slice(&grid, z, slice)),
            truth: Box::new(move |p: Point<geometry::Ct>| phantom.hu(p)),
        };
        let (ms, hu) = race(trade, &field, &[Sampling::from(Filter::default())])[0];
        (format!("{mm} mm"), ms, hu)
    };
    let rows: Vec<Row> = [0.75, 1.0, 1.5, 2.0, 3.0].map(row).to_vec();
    trade.write(&dial("spacing", "1.5 mm", PATIENT), &rows);
}
