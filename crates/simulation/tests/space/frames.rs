//! From frame to frame: the block pushed by a tube, held against `settle`, which shares neither factors nor contact with it.

mod bone;
mod certified;
mod follow;
mod held;
mod leaning;
mod refused;
mod rest;
mod several;
mod slope;
mod still;
mod together;
mod unproved;
mod unsettled;
mod yielding;

use nalgebra::{Isometry3, Vector3};
use simulation::control::{Newton, Settings as Control};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::frames::{Frames, State};
use simulation::space::term::TubeContact;
use simulation::sparse::Dissection;

use crate::block::{Grid, block, pose, top, tube};

/// 12.5 mm at the tip: as coarse as the tube's 10 mm lets it be.
const COARSE: Grid = Grid {
    side: 25.0,
    fine: &[30.0],
};
/// 10 mm.
const FINER: Grid = Grid {
    side: 20.0,
    fine: &[30.0],
};

/// The state and the force by Newton's method with new factors throughout, reached in steps of 2 mm.
fn truth(grid: Grid, nu: f64, last: &Isometry3<f64>) -> (Vec<f64>, Vector3<f64>, f64) {
    let mut system = block(grid, nu);
    let contact = TubeContact::new(&system.bodies, 0, tube(), 0.03, top(25.0)).unwrap();
    system.tubes.push(contact);
    let order = Dissection::by_places(&system.places(), &[]).unwrap();
    let control = Control {
        provisional: true,
        ..Control::default()
    };
    let (mut newton, mut a) = (Newton::ordered_by(control, order), system.initial());
    let way = tube().way_to(last);
    let count = (way / 2.0).ceil() as usize;
    let mut energy = 0.0;
    for k in 0..count {
        let next = system.tubes[0].tube().toward(last, 1.0 / (count - k) as f64);
        system.tubes[0].move_to(next);
        energy = settle(&mut system, &mut newton, &mut a, &Tolerance::default())
            .unwrap()
            .energy;
    }
    let force = system.tubes[0].force(&system.bodies, &a).force;
    (a, force, energy)
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// There in frames of 1/3 mm, as at 20 mm/s.
fn pushed(frames: &mut Frames, depths: impl Iterator<Item = u32>) {
    for k in depths {
        let frame = frames.frame(&pose(f64::from(k) / 3.0, 0.0, 0.0));
        assert_eq!(frame.state, State::Settled, "{k}: {frame:?}");
        assert!(frame.least_determinant > 0.5, "{k}: {frame:?}");
    }
}
