//! `calib steps`: the guided calibration, registration and check of a run that is going, as one of its processes.
//!
//! What a person does here step by step is done by the commands of this crate, each as its command line would: a step listens to the
//! run (`calib pivot --live`), and what comes of it is shown on the topic `steps` with its residuals, gates and errors. Nothing is written
//! where a tracker reads before a person accepts it.
//!
//! ```text
//! [run]: requests, the hand, the bus -> [desk]: which task, what goes on -> [course]: one task, its results
//!                                             [job]: a command on a thread of its own
//! ```

mod checking;
mod course;
mod desk;
pub mod hand;
mod job;
mod made;
mod on_base;
mod run;
mod tasks;
#[cfg(test)]
mod tests;
mod touched;
mod touching;
mod turning;

use std::path::PathBuf;

use bus::process::Membership;
use clap::Args;

pub(crate) use job::CarryOut;

pub(crate) const STEPS_HELP: &str = "\
The pilot starts this process where the scene has a table [steps]; `pilot steps` and the operator's window tell it what to do. \
What is accepted goes into the files of [tracker.calibration] and [tracker.registration]; touches, poses and what was replaced \
are kept in the folder --work.

Example (by hand, in a run that is going):
  calib steps --run-dir /run/user/1000/trocar/default --work steps";

#[derive(Debug, Args)]
pub(crate) struct StepsArgs {
    /// The run's folder
    #[arg(long)]
    run_dir: PathBuf,
    /// The pilot's process; this one ends with it
    #[arg(long)]
    parent: Option<u32>,
    /// Where touches, poses and replaced files are kept
    #[arg(long, value_name = "DIR")]
    work: PathBuf,
}

impl StepsArgs {
    /// Serves the run until asked to stop; `carry_out` does what a command line of this program asks.
    pub(crate) fn run(self, carry_out: CarryOut) -> Result<(), run::StepsError> {
        let membership = Membership {
            run_dir: self.run_dir,
            parent: self.parent,
        };
        run::run(&membership, self.work, carry_out)
    }
}
