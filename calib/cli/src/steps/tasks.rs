//! The tasks that a scene has, each from its beginning.

use std::rc::Rc;

use bus::message::StepTask;
use scene::steps::{Calibrating, Registering, StepsSpec};

use super::checking::Checking;
use super::course::{Around, Course};
use super::on_base::OnBase;
use super::touching::Touching;
use super::turning::Turning;

/// The tasks that a scene has.
pub(super) fn tasks(spec: &StepsSpec) -> Vec<StepTask> {
    let has = |task: &StepTask| match task {
        StepTask::Calibrate => spec.calibrate.is_some(),
        StepTask::Register => spec.register.is_some(),
        StepTask::Check => !spec.check.is_empty(),
    };
    StepTask::ALL.into_iter().filter(has).collect()
}

/// A task from its beginning.
///
/// # Errors
/// In words: the scene has no such task, or what it needs cannot be read.
pub(super) fn begin(task: StepTask, around: &Rc<Around>) -> Result<Box<dyn Course>, String> {
    let none = || format!("the scene's [steps] has nothing to {}", task.word());
    Ok(match task {
        StepTask::Calibrate => match around.spec.calibrate.ok_or_else(none)? {
            Calibrating::Pivot => Box::new(Turning::new(around, false)),
            Calibrating::PivotAndSpin => Box::new(Turning::new(around, true)),
            Calibrating::Base => Box::new(OnBase::new(around)?),
        },
        StepTask::Register => match around.spec.register.clone().ok_or_else(none)? {
            Registering::Points(points) => Box::new(Touching::points(around, points)),
            Registering::Beads(path) => Box::new(Touching::beads(around, path)?),
        },
        StepTask::Check if around.spec.check.is_empty() => return Err(none()),
        StepTask::Check => Box::new(Checking::new(around)),
    })
}
