//! Derivatives by differences.

use geometry::motion::Pose;
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Point, Probe, Reference, Rigid, Vector};
use nalgebra::{DVector, Matrix3, Matrix6, Vector3, Vector6};

use super::*;
use crate::{Mark, Seen, Track, Wire, Wires};

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

/// Every column of a row, with everything free, against the difference of two residuals: within what a step of 1e-5
/// loses.
#[test]
fn derivatives_are_those_of_differences() {
    let wire = |x: f64| Wire {
        name: format!("{x}"),
        front: Point::new(x, 0.0, 5.0),
        back: Point::new(60.0 - x, 40.0, 3.0),
    };
    let wires = Wires::new(vec![wire(10.0), wire(25.0), wire(40.0)]).unwrap();
    let pose = |t: f64| -> Rigid<Reference, Probe> {
        Rigid::from_rotation_vector(
            Vector::new(0.3, -0.2 + 0.4 * t, 0.1 * t),
            Vector::new(5.0 * t, 20.0 - 3.0 * t, 8.0),
        )
        .unwrap()
    };
    let timed: Vec<_> = (0..30)
        .map(|i| (f64::from(i) * 0.05, pose(f64::from(i) * 0.05)))
        .collect();
    let track = Track::new(&timed, 0.1).unwrap();
    let mark = |wire, u, v| Mark { wire, px: [u, v] };
    let frames: Vec<Seen> = [0.31, 0.8]
        .map(|t| Seen {
            number: 0,
            t_s: Some(t),
            reference_from_probe: pose(t),
            marks: vec![mark(0, 100.0, 250.0), mark(1, 430.0, 60.0), mark(2, 250.0, 500.0)],
        })
        .to_vec();
    let options = Options {
        priors: Priors {
            pixel_mm: None,
            lag_s: 0.1,
            tracker: 0.05,
            play_mm: 0.1,
        },
        ..Options::default()
    };
    let given = (turn([0.2, 0.1, -0.4]).matrix().into(), Vector3::new(3.0, -2.0, 10.0));
    for wall in [false, true] {
        let data = Data::new(&frames, Some(&track), &wires.lines, given);
        let solver = Solver {
            data: &data,
            options: &options,
            layout: Layout::new(&options.priors, !wall, 3, wall),
            phantom_prior: Matrix6::identity(),
        };
        let state = State {
            image: Pose {
                turn: turn([0.5, -1.1, 0.7]),
                shift: Vector3::new(12.0, 40.0, -7.0),
            },
            size: [0.08, 0.11],
            phantom: Vector6::new(0.05, -0.08, 0.1, 0.4, -0.2, 0.3),
            lag: 0.03,
            tracker: Matrix3::new(0.01, 0.0, -0.02, 0.03, 0.01, 0.0, 0.0, -0.01, 0.02),
            play: vec![[0.1, -0.2, 0.05, 0.3]; 3],
            wall: Wall {
                normal: Vector3::new(0.6, 0.0, 0.8),
                distance: 12.0,
            },
        };
        let poses = data.poses(state.lag).unwrap();
        for (frame, seen) in frames.iter().enumerate() {
            for mark in &seen.marks {
                let row = solver.row(&state, &poses, frame, mark);
                for column in 0..solver.layout.len {
                    let step = |sign: f64| {
                        let mut by = DVector::zeros(solver.layout.len);
                        by[column] = 1e-5 * sign;
                        let moved = state.moved(&by, &solver.layout).unwrap();
                        solver
                            .row(&moved, &data.poses(moved.lag).unwrap(), frame, mark)
                            .residual
                    };
                    let difference = (step(1.0) - step(-1.0)) / 2e-5;
                    let off = (difference - row.unknowns.column(column)).norm();
                    // Differences are off by h^2 times a third derivative and by rounding over h; the left
                    // Jacobian's series by 1e-6 here.
                    let bound = 1e-6 + 3e-6 * difference.norm();
                    assert!(
                        off < bound,
                        "wall {wall}, column {column}: {difference} {}",
                        row.unknowns.column(column)
                    );
                }
            }
        }
    }
}
