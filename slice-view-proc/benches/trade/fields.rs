//! Volumes whose true value is known between the voxels too.

use std::f64::consts::TAU;

use bus::volume::OwnedVolume;
use geometry::{Ct, Point};
use phantom::Phantom;

use crate::shared::ct;

/// Amplitude of each wave, HU.
const AMPLITUDE_HU: f64 = 200.0;
/// Directions of the waves, and their frequencies relative to the limit: along the axes and the diagonals at the limit,
/// where interpolation is hardest, and slower ones elsewhere.
const WAVES: [([f64; 3], f64); 6] = [
    ([1.0, 0.0, 0.0], 1.0),
    ([0.0, 1.0, 0.0], 1.0),
    ([0.0, 0.0, 1.0], 1.0),
    ([0.58, 0.57, 0.58], 1.0),
    ([-0.8, 0.36, 0.48], 0.7),
    ([0.48, -0.6, 0.64], 0.4),
];

type Truth = Box<dyn Fn(Point<Ct>) -> f64>;

/// A volume and what it stands for.
pub(crate) struct Field {
    pub(crate) name: &'static str,
    pub(crate) volume: OwnedVolume,
    /// The HU at a point.
    pub(crate) truth: Truth,
}

/// The fields, each made when it is its turn: one takes 200 MiB.
pub(crate) fn all() -> impl Iterator<Item = Field> {
    let makers: [fn() -> Field; 3] = [
        || waves("waves up to 0.2 cycles a voxel", 0.2),
        || waves("waves up to 0.35 cycles a voxel", 0.35),
        patient,
    ];
    makers.into_iter().map(|make| make())
}

pub(crate) fn patient() -> Field {
    let phantom = Phantom::new(phantom::DEFAULT_SEED);
    let grid = ct::grid(ct::DIMS, ct::SPACING_MM);
    Field {
        name: "generated patient",
        volume: ct::volume(grid, |z, slice| phantom.fill_slice(&grid, z, slice)),
        truth: Box::new(move |p| phantom.hu(p)),
    }
}

/// Turns (cycles) of each wave from one voxel to the next along each axis.
fn turns(limit: f64) -> [[f64; 3]; WAVES.len()] {
    WAVES.map(|(direction, part)| direction.map(|component| component * part * limit))
}

pub(crate) fn waves(name: &'static str, limit: f64) -> Field {
    let grid = ct::grid(ct::DIMS, ct::SPACING_MM);
    let turns = turns(limit);
    // cos(a + b) by the angles' sines and cosines: a cosine for each voxel and wave would take minutes.
    let along_x = turns.map(|[x, ..]| {
        let turned = |i: u32| (TAU * x * f64::from(i)).sin_cos();
        (0..ct::DIMS[0]).map(turned).collect::<Vec<_>>()
    });
    let volume = ct::volume(grid, |z, slice| {
        let mut sums = vec![0.0; ct::DIMS[0] as usize];
        for (y, row) in slice.chunks_exact_mut(ct::DIMS[0] as usize).enumerate() {
            sums.fill(0.0);
            for (i, turn) in turns.iter().enumerate() {
                let (sin, cos) = start(i, turn, [0.0, y as f64, f64::from(z)]).sin_cos();
                for (sum, (sin_x, cos_x)) in sums.iter_mut().zip(&along_x[i]) {
                    *sum += cos * cos_x - sin * sin_x;
                }
            }
            for (value, sum) in row.iter_mut().zip(&sums) {
                *value = (AMPLITUDE_HU * sum).round() as i16;
            }
        }
    });
    let truth = move |p: Point<Ct>| {
        let index = (grid.voxel_from_ct() * p).mm();
        let wave = |(i, turn)| start(i, turn, index).cos();
        AMPLITUDE_HU * turns.iter().enumerate().map(wave).sum::<f64>()
    };
    Field {
        name,
        volume,
        truth: Box::new(truth),
    }
}

/// The angle of wave `i` at a voxel index. Each wave begins elsewhere, so that no two meet at their crests.
fn start(i: usize, turn: &[f64; 3], index: [f64; 3]) -> f64 {
    let turned: f64 = turn.iter().zip(index).map(|(t, x)| t * x).sum();
    TAU * turned + 1.7 * i as f64
}
