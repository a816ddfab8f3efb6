//! What calibrating a camera costs by the number of views, and how exact it is.
//!
//! `cargo bench -p optics --bench camera`. Views of 9 x 7 discs through a lens of Brown's, each disc with noise of its own
//! covariance. Beside the whole calibration is the least that the usual way would cost: as many solutions of the dense
//! normal equations of all unknowns, the camera's and six a view, as it made steps, without forming them. Both take turns;
//! times are the least of the rounds, in milliseconds of the wall; the error is that of the focal length, beside its
//! stated deviation.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
#![allow(
    clippy::unwrap_used,
    reason = "the tests' rig, which is sound or the benchmark fails"
)]
#![allow(dead_code, reason = "the tests' rig, of which a part is needed")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/suite/camera/rig.rs"]
mod rig;

use std::hint::black_box;
use std::time::Instant;

use common::Random;
use nalgebra::{DMatrix, DVector, Vector2};
use optics::camera::{Camera, Lens, Options, calibrate};
use rig::{Rig, SIZE};

const ROUNDS: usize = 5;

fn camera() -> Camera {
    let lens = Lens {
        k1: -0.25,
        k2: 0.1,
        p1: 0.004,
        p2: -0.007,
        ..Lens::default()
    };
    Camera {
        lens,
        ..Camera::pinhole(1200.0, Vector2::new(655.0, 340.0))
    }
}

/// Seconds of one dense solution for so many unknowns.
fn dense(unknowns: usize) -> f64 {
    let matrix = DMatrix::from_fn(unknowns, unknowns, |i, j| {
        if i == j { 2.0 } else { 1.0 / (1.0 + (i + j) as f64) }
    });
    let right = DVector::from_element(unknowns, 1.0);
    let start = Instant::now();
    let solved = black_box(matrix).cholesky().map(|c| c.solve(&right));
    black_box(solved);
    start.elapsed().as_secs_f64()
}

fn main() {
    for views in [3_u32, 10, 30, 100] {
        let exact = Rig::around(camera(), views, 0.5).views(None);
        let noisy = rig::noisy(&exact, &mut Random::new(u64::from(views)), 1.0);
        let (mut ours, mut theirs, mut steps) = (f64::INFINITY, f64::INFINITY, 1);
        let mut error = [0.0; 2];
        for _ in 0..ROUNDS {
            let start = Instant::now();
            let Ok(found) = calibrate(black_box(&noisy), SIZE, &Options::default()) else {
                println!("{views:>4} views: refused");
                break;
            };
            ours = ours.min(start.elapsed().as_secs_f64());
            steps = found.steps;
            error = [(found.camera.focal.x - 1200.0).abs(), found.sigmas()[0]];
            theirs = theirs.min(dense(8 + 6 * views as usize));
        }
        let rival = theirs * steps as f64;
        println!(
            "{views:>4} views {:>9.2} ms, {steps} steps in the last round; dense solutions alone {:>9.2} ms, ratio {:.2}; \
             focal length off {:.3} px, deviation {:.3}",
            ours * 1e3,
            rival * 1e3,
            ours / rival,
            error[0],
            error[1]
        );
    }
}
