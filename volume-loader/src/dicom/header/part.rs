//! What keeps the frames of one series apart.

use std::cmp::Ordering;
use std::fmt;
use std::path::PathBuf;

use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::Label;

/// What keeps frames of one series apart: those of one volume agree in all of it. Names are compared by their bytes: two that may
/// not be shown are not alike for that.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Part {
    pub instance: Option<Instance>,
    pub(super) stack: Option<Label>,
    pub(super) temporal: Option<u32>,
    /// Percentages of the heart's cycle and of the breath's.
    pub(super) phases: [Option<Number<f32>>; 2],
    /// Behind the heart's beat, ms.
    pub(super) delay: Option<Number<f64>>,
    pub(super) kind: Option<Label>,
    pub(super) algorithm: Option<Label>,
    pub(super) kernel: Option<Label>,
    /// Where it is another than HU: a frame without one is taken as HU, as a classic slice is.
    pub(super) rescale_type: Option<Label>,
}

/// The concatenation, by its UID and no file, or the file, by the UID of its object and its path: a UID alone is another file's too
/// where somebody copied one. Single frames have none: they are slices of their series. Never shown.
pub(crate) type Instance = (String, PathBuf);

/// A nominal number, as the file says it: frames of one phase say the same one, and what differs however little is kept apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Number<T>(pub T);

/// What is finite and may be compared.
pub(super) trait Finite: Copy {
    fn order(self, other: Self) -> Ordering;
}

impl Finite for f32 {
    fn order(self, other: Self) -> Ordering {
        // Both zeros are one.
        (self + 0.0).total_cmp(&(other + 0.0))
    }
}

impl Finite for f64 {
    fn order(self, other: Self) -> Ordering {
        (self + 0.0).total_cmp(&(other + 0.0))
    }
}

impl<T: Finite> Ord for Number<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.order(other.0)
    }
}

impl<T: Finite> PartialOrd for Number<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Finite> PartialEq for Number<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<T: Finite> Eq for Number<T> {}

impl Part {
    /// What it says of the stack and the point in time, each with the element that says so: a frame that is silent where others of
    /// its file speak is of one of theirs, and nobody knows of which.
    pub(crate) fn places(&self) -> [(Tag, bool); 2] {
        [
            (el::STACK, self.stack.is_some()),
            (el::TEMPORAL, self.temporal.is_some()),
        ]
    }

    /// Whether something of it may not be shown, so that another part's words may be the same.
    pub(crate) fn is_hidden(&self) -> bool {
        let labels = [
            &self.stack,
            &self.kind,
            &self.algorithm,
            &self.kernel,
            &self.rescale_type,
        ];
        labels.into_iter().flatten().any(Label::is_hidden)
    }

    /// What it says of how the frame was made, likewise: one may have been made without.
    pub(crate) fn makings(&self) -> [(Tag, bool); 6] {
        let [cardiac, respiratory] = self.phases;
        [
            (el::CARDIAC_PHASE, cardiac.is_some()),
            (el::CARDIAC_DELAY, self.delay.is_some()),
            (el::RESPIRATORY_PHASE, respiratory.is_some()),
            (el::FRAME_TYPE, self.kind.is_some()),
            (el::ALGORITHM, self.algorithm.is_some()),
            (el::KERNEL, self.kernel.is_some()),
        ]
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frames")?;
        if let Some(stack) = &self.stack {
            write!(f, " of stack {stack}")?;
        }
        if let Some(temporal) = self.temporal {
            write!(f, ", temporal position {temporal}")?;
        }
        for (phase, what) in self.phases.iter().zip(["cardiac", "respiratory"]) {
            if let Some(Number(percent)) = phase {
                write!(f, ", {percent} % of the {what} cycle")?;
            }
        }
        if let Some(Number(ms)) = self.delay {
            write!(f, ", {ms} ms after the heart's beat")?;
        }
        let words = [&self.kind, &self.algorithm, &self.rescale_type];
        words.into_iter().flatten().try_for_each(|word| write!(f, ", {word}"))
    }
}
