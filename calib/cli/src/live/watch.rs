//! Who is told while a run is listened to.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

use bus::message::StepMotion;

/// What was heard so far.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Heard {
    /// s that have passed.
    pub(crate) passed_s: f64,
    /// s that were asked for.
    pub(crate) asked_s: f64,
    /// Frames that came.
    pub(crate) frames: usize,
    /// Those that show the marker.
    pub(crate) poses: usize,
    /// What the motion still lacks, or why the last frame shows no marker.
    pub(crate) advice: String,
    /// What it covers, as a picture.
    pub(crate) motion: Option<StepMotion>,
}

/// What is said of a motion that goes on.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lacks {
    /// What it still lacks.
    pub(crate) words: String,
    /// What it covers; `None`: nothing is known of it, or nobody looks.
    pub(crate) motion: Option<StepMotion>,
}

/// Is called again and again while a run is listened to, and may end that.
type Told = dyn Fn(&Heard) -> ControlFlow<()> + Send + Sync;

/// Who is told; nobody where a command line listens, which writes to stderr.
#[derive(Clone, Default)]
pub(crate) struct Watch(Option<Arc<Told>>);

impl Watch {
    pub(crate) fn new(told: impl Fn(&Heard) -> ControlFlow<()> + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(told)))
    }

    /// Whether anybody is told.
    pub(crate) const fn is_there(&self) -> bool {
        self.0.is_some()
    }

    /// Tells; whether to go on.
    pub(crate) fn tell(&self, heard: &Heard) -> ControlFlow<()> {
        self.0.as_ref().map_or(ControlFlow::Continue(()), |told| told(heard))
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Watch({})", self.is_there())
    }
}
