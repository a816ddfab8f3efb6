//! What it costs to find which place of the CT lies at each pixel of a slice through pushed tissue, and how exact it is, by the size of the
//! pieces that the plane cuts; beside Newton's method in each pixel, started where the neighbour's ended, which has no error.
//!
//! `cargo bench -p slice-view-proc --bench warp`. A block of 120 mm in cubes of 10 mm with a dent of 20 mm and a twist; 512 x 512 pixels of
//! 0.234 mm, of which it fills some four fifths. Table, and `out/bench/warp.csv`. A cube that is bent little is drawn whole, to within less than
//! what its pieces would be off; pieces of 0.625 mm, sixteen a cube, are drawn as such.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../../benches/shared/trade.rs"]
mod trade;

use std::collections::BTreeMap;

use geometry::{Point, SlicePlane, Vector};
use rustix::time::{ClockId, clock_gettime};
use slice_view_proc::warp::{Cube, Organ, Pixel, Region, Shape, Warp, Warped};
use trade::{Dial, Row, Trade, turns};

/// Milliseconds of processor that this thread has had: others beside it do not count.
fn processor_ms() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

const ROUNDS: usize = 21;
const SIZE: [u32; 2] = [512, 512];
const PIXEL_MM: f64 = 0.234_375;
const HALF_MM: f64 = 60.0;
const SIDE_MM: f64 = 10.0;
const HEADER: &str =
    "pieces_mm,covered_percent,median_ms,least_ms,stated_mm,worst_mm,rms_mm,newton_ms,newton_over_pieces";

/// A dent from above, a bulge about it, and a twist.
fn field([x, y, z]: [f64; 3]) -> [f64; 3] {
    let near = (-(x * x + y * y + (z - 60.0).powi(2)) / 1600.0).exp();
    let (sine, cosine) = (0.004 * z).sin_cos();
    let wide = 1.0 + 0.15 * near;
    [
        wide * (cosine * x - sine * y),
        wide * (sine * x + cosine * y),
        z - 20.0 * near,
    ]
}

/// The place that `field` takes to `now`, from a place near it.
fn inverse(now: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    let mut x = nalgebra::Vector3::from(from);
    for _ in 0..30 {
        let found = nalgebra::Vector3::from(field(x.into()));
        let off = nalgebra::Vector3::from(now) - found;
        if off.norm() < 1e-9 {
            break;
        }
        let column = |a: usize| {
            let mut beside = x;
            beside[a] += 1e-5;
            (nalgebra::Vector3::from(field(beside.into())) - found) / 1e-5
        };
        let slope = nalgebra::Matrix3::from_columns(&[column(0), column(1), column(2)]);
        x += slope.lu().solve(&off).unwrap_or_default();
    }
    x.into()
}

fn mesh() -> (Vec<Cube>, Vec<[f32; 3]>) {
    let count = (2.0 * HALF_MM / SIDE_MM) as usize;
    let (mut cubes, mut places, mut numbers) = (Vec::new(), Vec::new(), BTreeMap::new());
    for k in 0..count.pow(3) {
        let corner = [k % count, k / count % count, k / (count * count)];
        let nodes = std::array::from_fn(|n| {
            let node: [usize; 3] = std::array::from_fn(|a| 2 * corner[a] + [n % 3, n / 3 % 3, n / 9][a]);
            *numbers.entry(node).or_insert_with(|| {
                places.push(field(node.map(|i| i as f64 * SIDE_MM / 2.0 - HALF_MM)).map(|x| x as f32));
                places.len() as u32 - 1
            })
        });
        cubes.push(Cube {
            low: corner.map(|i| i as f64 * SIDE_MM - HALF_MM),
            side: SIDE_MM,
            nodes,
        });
    }
    (cubes, places)
}

fn region() -> Region {
    let count = 64_usize;
    let step = 2.0 * (HALF_MM + 2.0) / (count - 1) as f64;
    let at = |i: usize| i as f64 * step - HALF_MM - 2.0;
    let value = |k: usize| {
        let place = [k % count, k / count % count, k / (count * count)].map(at);
        place
            .iter()
            .fold(f64::NEG_INFINITY, |most, x| most.max(x.abs() - HALF_MM)) as f32
    };
    Region::new(
        [-HALF_MM - 2.0; 3],
        step,
        [count as u32; 3],
        (0..count.pow(3)).map(value).collect(),
    )
    .unwrap()
}

fn plane(round: usize) -> SlicePlane {
    let shift = (round as f64 * 7.3) % 20.0 - 10.0;
    let right = Vector::new(1.0, 0.1, 0.2).direction().unwrap();
    let down = right
        .cross(Vector::new(0.1, 1.0, 0.1).direction().unwrap())
        .direction()
        .unwrap();
    SlicePlane::centred(Point::new(shift, shift, 10.0), [right, down], PIXEL_MM, SIZE).unwrap()
}

/// Distances of `warped` from the field's inverse: the largest and the root of the mean of the squares.
fn errors(plane: &SlicePlane, warped: &Warped) -> [f64; 2] {
    let inside = (0..warped.pixels.len()).filter(|k| warped.pixels[*k] == Pixel::Inside(0));
    let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for k in inside.step_by(7) {
        let now = plane.point((k % 512) as f64, (k / 512) as f64).mm();
        let found = warped.rest[k].map(f64::from);
        let exact = inverse(now, found);
        let off = (0..3).map(|a| (exact[a] - found[a]).powi(2)).sum::<f64>();
        (worst, sum, count) = (worst.max(off.sqrt()), sum + off, count + 1.0);
    }
    [worst, (sum / count).sqrt()]
}

/// Newton's method in each pixel that is inside, ms.
fn newton(plane: &SlicePlane, warped: &Warped) -> f64 {
    let began = processor_ms();
    let mut last = [0.0; 3];
    for k in (0..warped.pixels.len()).filter(|k| warped.pixels[*k] == Pixel::Inside(0)) {
        last = inverse(plane.point((k % 512) as f64, (k / 512) as f64).mm(), last);
        std::hint::black_box(last);
    }
    processor_ms() - began
}

/// Sizes of pieces beside Newton's method, as a dial.
fn trade(trade: &Trade) {
    let (cubes, places) = mesh();
    let sizes = [10.0, 5.0, 3.0, 2.5, 1.25, 0.625];
    let shapes = sizes.map(|pieces| Shape::new(&cubes, places.len(), region(), pieces).unwrap());
    let mut warp = Warp::default();
    let mut errors_mm = [0.0_f64; 6];
    let mut rounds = [0; 6];
    let times = turns(trade.rounds(3, ROUNDS), 6, |k| {
        let organs = [Organ {
            shape: &shapes[k],
            places: &places,
        }];
        warp.draw(&plane(rounds[k]), &organs).unwrap();
        rounds[k] += 1;
    });
    for (error, shape) in errors_mm.iter_mut().zip(&shapes) {
        for round in 0..3 {
            let (organs, plane) = ([Organ { shape, places: &places }], plane(round));
            *error = error.max(errors(&plane, warp.draw(&plane, &organs).unwrap())[0]);
        }
    }
    let row = |k: usize| -> Row { (format!("{} mm", sizes[k]), 1e3 * times[k], errors_mm[k]) };
    let dial = Dial {
        name: "tissue-piece",
        chosen: "5 mm".to_owned(),
        time_unit: "ms an image of 512 x 512",
        error_unit: "mm",
        against: "largest distance of a pixel's place at rest to the inverse of the motion that Newton's method finds to 1e-9 mm",
    };
    trade.write(&dial, &(0..6).map(row).collect::<Vec<_>>());
}

fn main() {
    if let Some(trade) = Trade::wanted() {
        return self::trade(&trade);
    }
    let (cubes, places) = mesh();
    let mut warp = Warp::default();
    println!("{HEADER}");
    let mut rows = vec![HEADER.to_owned()];
    for pieces in [10.0, 5.0, 2.5, 1.25, 0.625] {
        let shape = Shape::new(&cubes, places.len(), region(), pieces).unwrap();
        let organs = [Organ {
            shape: &shape,
            places: &places,
        }];
        let mut times = Vec::new();
        let (mut found, mut stated, mut inside) = ([0.0_f64; 2], 0.0_f64, 0);
        for round in 0..ROUNDS {
            let plane = plane(round);
            let began = processor_ms();
            let warped = warp.draw(&plane, &organs).unwrap();
            times.push(processor_ms() - began);
            if round < 3 {
                let [worst, rms] = errors(&plane, warped);
                found = [found[0].max(worst), found[1].max(rms)];
                (stated, inside) = (
                    stated.max(warped.error_mm),
                    warped.pixels.iter().filter(|p| **p == Pixel::Inside(0)).count(),
                );
            }
        }
        let alternative = newton(&plane(0), warp.draw(&plane(0), &organs).unwrap());
        times.sort_by(f64::total_cmp);
        let (median, covered) = (times[ROUNDS / 2], 100.0 * inside as f64 / (512.0 * 512.0));
        let [worst, rms] = found;
        let row = format!(
            "{pieces},{covered:.0},{median:.2},{:.2},{stated:.3},{worst:.3},{rms:.4},{alternative:.1},{:.1}",
            times[0],
            alternative / median
        );
        println!("{row}");
        rows.push(row);
    }
    std::fs::create_dir_all("../out/bench").unwrap();
    std::fs::write("../out/bench/warp.csv", rows.join("\n") + "\n").unwrap();
}
