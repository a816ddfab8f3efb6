//! How well a camera of some views predicts another one: what tells a better model from one with more numbers.

use super::adjust::{Problem, STEP_END};
use super::error::CameraRefused;
use super::joint_adjust;
use super::paraboloid::Ruler;
use super::paraboloid::SHARED;
use super::plate::places;
use super::plate_field::Waves;
use super::settled;
use super::state::State;
use super::view::{ImageSize, Options, Station, View};

/// The damping of an adjustment that begins near its end.
const NEAR_DAMPING: f64 = 1e-3;

/// For each view the root mean square distance, pixels, of its discs from where the camera (and plate) of all other views
/// sees them, its pose alone adjusted to them. Discs that the calibration of all views leaves out are left out.
///
/// A model that is nearer the truth has smaller ones; numbers that only follow the noise, or an error that the model has
/// no number for, have larger ones, whatever they do to the residuals of a calibration. One calibration a view.
///
/// # Errors
/// Each variant of [`CameraRefused`]; without one of three views the other two must hold the camera.
pub fn held_out(views: &[View], size: ImageSize, options: &Options) -> Result<Vec<f64>, CameraRefused> {
    let (stations, chosen) = settled(views, size, options)?;
    let used: Vec<Station> = stations.iter().zip(&chosen.kept).map(|(s, k)| s.only(k)).collect();
    let waves = options.field.then(|| Waves::of(&used, Ruler::of(places(views))));
    let one = |view| without(view, &used, &chosen.settled.state, (options, waves.as_ref()));
    (0..views.len()).map(one).collect()
}

/// That of one view.
fn without(
    view: usize,
    stations: &[Station],
    state: &State,
    (options, waves): (&Options, Option<&Waves>),
) -> Result<f64, CameraRefused> {
    let others = |k: &usize| *k != view;
    let rest: Vec<Station> = (0..stations.len())
        .filter(others)
        .map(|k| stations[k].clone())
        .collect();
    let start = State {
        poses: (0..stations.len()).filter(others).map(|k| state.poses[k]).collect(),
        ..state.clone()
    };
    let free = options.shared();
    let others = Problem { stations: &rest, free };
    // The camera of the other views, from the one of all: near its own end.
    let found = others.settle_to(STEP_END, NEAR_DAMPING, start)?.state;
    let (found, own) = match waves {
        None => (found, vec![stations[view].clone()]),
        Some(waves) => {
            let (found, field) = joint_adjust::adjusted(&rest, free, waves, found)?;
            (found, waves.moved(&stations[view..=view], &field.coefficients))
        }
    };
    // The view that was left out may choose its pose, and nothing else.
    let alone = Problem {
        stations: &own,
        free: [false; SHARED],
    };
    let start = State {
        poses: vec![state.poses[view]],
        ..found
    };
    let seen = alone.settle_to(STEP_END, NEAR_DAMPING, start)?.state;
    Ok(alone.rms_px(&seen))
}
