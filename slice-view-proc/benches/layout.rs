//! What bricks cost and what they bring: the time of slices in each direction, per layout of the volume in memory.
//!
//! `cargo bench -p slice-view-proc --bench layout`. A volume of 512 x 512 x 400 voxels (200 MiB, far more than any cache)
//! is cut into images of 512 x 512 pixels at positions that change from image to image. Layouts take turns, so that a
//! noisy machine treats them alike; the median of the rounds is printed, with its ratio to plain rows in the same run.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

use bus::clock::monotonic_ns;
use bus::volume::{Layout, VolumeView};
use geometry::{Affine, Direction, Point, SlicePlane, Vector, VolumeGrid};
use scene::Filter;
use slice_view_proc::reslice::{Cpu, Reference, Resampler};

const DIMS: [u32; 3] = [512, 512, 400];
const BRICKS: [[u32; 3]; 5] = [[1, 1, 1], [2, 2, 2], [4, 4, 2], [4, 4, 4], [8, 8, 8]];
const ROUNDS: usize = 15;
const SIZE: [u32; 2] = [512, 512];

/// Directions of columns and rows, and the way from one image to the next.
fn directions() -> [(&'static str, [Direction<geometry::Ct>; 2]); 5] {
    let oblique = Vector::new(0.6, 0.5, 0.62).direction().expect("not zero");
    let right = oblique.cross(Direction::Y).direction().expect("not parallel");
    let down = oblique.cross(right).direction().expect("not parallel");
    [
        ("axial", [Direction::X, Direction::Y]),
        ("frontal", [Direction::X, -Direction::Z]),
        ("sagittal", [Direction::Y, -Direction::Z]),
        ("sagittal, turned", [-Direction::Z, Direction::Y]),
        ("oblique", [right, down]),
    ]
}

fn plane(axes: [Direction<geometry::Ct>; 2], round: usize) -> SlicePlane {
    let [right, down] = axes;
    let middle = Point::new(255.5, 255.5, 199.5);
    let shift = (round as f64 * 37.3) % 150.0 - 75.0;
    let centre = middle + right.cross(down) * shift;
    SlicePlane::centred(centre, axes, 0.7, SIZE).expect("a plane of the usual size")
}

fn main() {
    let grid = VolumeGrid::checked(
        DIMS.map(i64::from),
        Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
    )
    .expect("a usual grid");
    let layouts: Vec<Layout> = BRICKS
        .map(|brick| Layout::new(DIMS, brick).expect("a usual layout"))
        .into();
    let stored: Vec<Vec<i16>> = layouts.iter().map(filled).collect();
    println!(
        "512 x 512 pixels of 0.7 voxel from {DIMS:?}, trilinear, one thread; median of {ROUNDS}, ms (ratio to rows)"
    );
    print!("{:<18}", "brick");
    BRICKS.iter().for_each(|b| print!("{:>16}", format!("{b:?}")));
    println!("{:>22}", "worst error, HU");
    let mut cpu = Cpu::default();
    for (name, axes) in directions() {
        let mut times = vec![Vec::new(); BRICKS.len()];
        let mut worst = 0.0_f64;
        for round in 0..ROUNDS {
            for (i, layout) in layouts.iter().enumerate() {
                let view = VolumeView {
                    grid: &grid,
                    layout,
                    voxels: &stored[i],
                    padding_hu: -1024,
                };
                let mut hu = vec![0.0; (SIZE[0] * SIZE[1]) as usize];
                let began = monotonic_ns();
                let drawn = cpu.reslice(&view, &plane(axes, round), &Filter::Linear.into(), &mut hu);
                times[i].push(monotonic_ns() - began);
                drawn.expect("needs no preparation");
                if round == 0 {
                    worst = worst.max(error(&view, &plane(axes, round), &hu));
                }
            }
        }
        print_row(name, times, worst);
    }
}

/// A smooth pattern with noise in the low bits, the same for every layout.
fn filled(layout: &Layout) -> Vec<i16> {
    let mut stored = vec![0; layout.stored() as usize];
    let mut slice = vec![0; (DIMS[0] * DIMS[1]) as usize];
    for z in 0..DIMS[2] {
        for (i, value) in slice.iter_mut().enumerate() {
            let (x, y) = (i as u32 % DIMS[0], i as u32 / DIMS[0]);
            *value = ((x * 7 + y * 13 + z * 29) % 3000) as i16 - 1000;
        }
        layout.scatter(z, &slice, &mut stored);
    }
    stored
}

fn error(view: &VolumeView<'_>, plane: &SlicePlane, hu: &[f32]) -> f64 {
    let mut exact = vec![0.0; hu.len()];
    let drawn = Reference::default().reslice(view, plane, &Filter::Linear.into(), &mut exact);
    drawn.expect("needs no preparation");
    let differences = hu.iter().zip(&exact).map(|(a, b)| f64::from((a - b).abs()));
    differences.fold(0.0, f64::max)
}

fn print_row(name: &str, times: Vec<Vec<i64>>, worst: f64) {
    let median = |mut list: Vec<i64>| {
        list.sort_unstable();
        list[list.len() / 2] as f64 / 1e6
    };
    let medians: Vec<f64> = times.into_iter().map(median).collect();
    print!("{name:<18}");
    for ms in &medians {
        print!("{:>16}", format!("{ms:.2} ({:.2})", ms / medians[0]));
    }
    println!("{worst:>22.5}");
}
