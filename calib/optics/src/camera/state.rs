//! A camera, the plate and the poses of all views, and where a step leads from there.

use geometry::motion::{Motion, Pose};
use nalgebra::Vector6;

use super::error::CameraRefused;
use super::model::{Camera, PARAMETERS};
use super::normal::Numbers;
use super::paraboloid::Bend;
use super::predict::Eye;

/// The motion of a step: turn, then shift, about the image of the view's middle.
pub(super) fn in_place(pose: &Pose, step: &Vector6<f64>) -> Option<Pose> {
    pose.moved_in_place(&Motion {
        turn: step.fixed_rows::<3>(0).into(),
        shift: step.fixed_rows::<3>(3).into(),
    })
}

/// A camera, a plate and a pose per view: camera's axes from the grid's about the view's middle.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) camera: Camera,
    pub(super) bend: Bend,
    pub(super) poses: Vec<Pose>,
}

impl State {
    /// What looks at one view.
    pub(super) fn eye(&self, pose: &Pose) -> Eye {
        Eye {
            camera: self.camera,
            bend: self.bend,
            turn: pose.matrix(),
            shift: pose.shift,
        }
    }

    /// The refusal of a shared number that the views leave free.
    pub(super) fn free_number(&self, parameter: usize) -> CameraRefused {
        let numbers = self.camera.numbers();
        let of_plate = || self.bend.0[parameter - PARAMETERS];
        CameraRefused::Weak {
            parameter,
            value: numbers.get(parameter).copied().unwrap_or_else(of_plate),
            sigma: f64::INFINITY,
        }
    }

    /// With what is shared moved by `step`; none where a focal length is not above 0.
    pub(super) fn moved(&self, step: &Numbers, poses: Vec<Pose>) -> Option<Self> {
        let numbers: [f64; PARAMETERS] = {
            let old = self.camera.numbers();
            std::array::from_fn(|k| old[k] + step[k])
        };
        let good = numbers[0] > 0.0 && numbers[1] > 0.0 && step.iter().all(|x| x.is_finite());
        good.then(|| Self {
            camera: Camera::from_numbers(numbers),
            bend: Bend(std::array::from_fn(|k| self.bend.0[k] + step[PARAMETERS + k])),
            poses,
        })
    }
}
