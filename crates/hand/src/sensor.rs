//! What measures the tube.

use geometry::{Ct, Rigid, Tool};
use guidance::sight::Covariance;

/// A pose as it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Where the tool seems to be.
    pub pose: Rigid<Ct, Tool>,
    /// What it states of its error.
    pub covariance: Covariance,
}

/// What measures the tube for the display: a model of errors, or a whole chain from emitters to the patient.
pub trait Sensor {
    /// What is shown in picture `frame` of the glass, which may show nothing that was captured after `t_s`, s from the first
    /// look; before that it is negative. `truly` says where the tube is at a time up to `t_s`, or `None` where it lies
    /// across its way.
    ///
    /// The same for the same arguments, always: pictures are asked for more than once. `None` where nothing was measured.
    fn measured(&self, frame: u64, t_s: f64, truly: &dyn Fn(f64) -> Option<Rigid<Ct, Tool>>) -> Option<Measured>;
}
