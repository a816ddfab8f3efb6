//! How well a tracked pointer locates points, by the procedure of ASTM F2554: one divot touched again and again, the pointer
//! turned about its tip in a divot, and the distances between the divots of a phantom of known shape; at several places of
//! the working volume, its edges among them.
//!
//! | test | what is told |
//! |---|---|
//! | [`Test::Single`] | bias: the mean's distance from the divot's place by the phantom; scatter about the mean |
//! | [`Test::Roll`], [`Test::Pitch`], [`Test::Yaw`] | scatter about the mean of the test: an error of the tip's calibration moves with the turn |
//! | [`Test::Distance`] | measured less known distance, of each pair of divots in each round |
//!
//! The phantom is registered to each place by the means of its divots in [`Test::Distance`]; that registration is the
//! reference of the bias. The standard measures localization only, no orientation. [`Simulation`] runs the whole procedure
//! on a simulated localizer, where the truth is known.

mod measure;
mod simulate;

use geometry::{Frame, Point, Tracker};

pub use measure::{Distances, PlaceReport, Report, Scatter, measure};
pub use simulate::{Simulation, phantom};

/// The frame of the phantom's drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phantom {}

impl Frame for Phantom {
    const NAME: &'static str = "Phantom";
}

/// What is done with the pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Test {
    /// Touching one divot again and again.
    Single,
    /// Turning the pointer about its shaft, the tip in a divot.
    Roll,
    /// Tilting it to and from the localizer.
    Pitch,
    /// Tilting it to the sides.
    Yaw,
    /// Touching every divot of the phantom.
    Distance,
}

impl Test {
    /// All tests.
    pub const ALL: [Self; 5] = [Self::Single, Self::Roll, Self::Pitch, Self::Yaw, Self::Distance];
    /// The turns about the tip.
    pub const TURNS: [Self; 3] = [Self::Roll, Self::Pitch, Self::Yaw];

    /// Its name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Roll => "roll",
            Self::Pitch => "pitch",
            Self::Yaw => "yaw",
            Self::Distance => "distance",
        }
    }
}

/// A place of the tip as measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Which place of the working volume, by its number.
    pub place: usize,
    /// What was being done.
    pub test: Test,
    /// Which divot of the phantom, by its number.
    pub divot: usize,
    /// The turn of the pointer, rad; 0 where it is not known.
    pub angle_rad: f64,
    /// Where the tip was measured.
    pub at: Point<Tracker>,
}

/// Why there is no report. Samples and divots count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// No sample at all.
    #[error("there are no samples")]
    None,
    /// A number is NaN or infinite.
    #[error("sample {sample}: {found:?} holds a number that is not finite")]
    NotFinite {
        /// The sample.
        sample: usize,
        /// The place found, mm.
        found: [f64; 3],
    },
    /// The phantom has no such divot.
    #[error("sample {sample} touches divot {divot}; the phantom has {divots}, counted from 0")]
    NoSuchDivot {
        /// The sample.
        sample: usize,
        /// The divot named.
        divot: usize,
        /// How many there are.
        divots: usize,
    },
    /// A turn happened in several divots, or a single point is several.
    #[error("place {place}: the {} test touches divots {first} and {second}; it is done in one", .test.name())]
    SeveralDivots {
        /// The place.
        place: usize,
        /// The test.
        test: Test,
        /// The first divot.
        first: usize,
        /// Another one.
        second: usize,
    },
    /// The divots measured do not fit the phantom.
    #[error(
        "place {place}: the divots measured do not fit the phantom: divot {divot} is {found_mm:.2} mm off after registration, \
         at most {allowed_mm} mm is taken for an error of measurement; are divots exchanged, or is it another phantom?"
    )]
    OffPhantom {
        /// The place.
        place: usize,
        /// The worst divot.
        divot: usize,
        /// Its distance, mm.
        found_mm: f64,
        /// The largest accepted, mm.
        allowed_mm: f64,
    },
    /// The phantom could not be registered.
    #[error("place {place}: the phantom cannot be registered: {source}")]
    NoRegistration {
        /// The place.
        place: usize,
        /// Why.
        source: crate::registration::Refused,
    },
    /// A number of the simulation is not usable.
    #[error("the simulation's {what} is {found}, expected {expected}")]
    BadNumber {
        /// Which.
        what: &'static str,
        /// The number found.
        found: f64,
        /// What is allowed.
        expected: &'static str,
    },
}
