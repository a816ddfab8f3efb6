//! `[tracker.room]`: the simulated operating room, in which a localizer sees the emitters of a tool and of a patient.
//!
//! Frames are those of the thesis's chain: the tool's marker (B) is seen by the localizer (L), and the patient's CT (C) is
//! where the registration says. Lengths are in mm, angles in radians, times in seconds of the script. Every imperfection is
//! a number here, and zero (or the widest angle, or no table) switches it off.

pub(super) mod check;
pub mod raw;
mod tank;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

use geometry::{Base, Ct, Direction, Frame, Marker, Point, Reference, Rigid, Tool, Tracker, Vector};

use super::Approach;

pub(super) use check::{place_of_localizer, room};
pub use raw::{AtEnd, RawRoom};
pub use tank::{Bottom, RawBottom, RawTank, Tank};

/// Most emitters of one marker.
pub const MAX_EMITTERS: usize = 32;
/// Most eyes of a localizer.
pub const MAX_EYES: usize = 8;

/// The simulated operating room, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// The marker on the tool.
    pub marker: Shape<Marker>,
    /// Where it sits on the tool.
    pub marker_from_tool: Rigid<Marker, Tool>,
    /// The tool's handle, which hides emitters.
    pub handle: Handle,
    /// The surgeon's hand, which hides emitters now and then; `None`: it never does.
    pub hand: Option<Hand>,
    /// What the localizer sees, and how well.
    pub sensor: Sensor,
    /// When its frames come.
    pub timing: Timing,
    /// How the patient moves.
    pub patient: Patient,
    /// A marker on the patient; `None`: the registration rests on a localizer that stands still.
    pub reference: Option<ReferenceMarker>,
    /// What is broken.
    pub faults: Faults,
    /// When a pose of the tool's marker is refused.
    pub gates: Gates,
    /// When one of the patient's is.
    pub reference_gates: Gates,
    /// Errors of the tool's calibration, about the tip.
    pub calibration_error: Deviations,
    /// Errors of the patient's registration, about the point of the patient that counts.
    pub registration_error: Deviations,
    /// The scripted gesture, played where [`Room::played`] is `None`.
    pub approach: Approach,
    /// A gesture from a file.
    pub played: Option<PlayedGesture>,
    /// The hand does what the steps of calibration, registration and check ask for; `None`: it does its gesture and nothing else.
    pub practice: Option<PracticeRoom>,
    /// The tool is an ultrasound probe; `None`: it is none.
    pub probe: Option<Probe>,
    /// What the probe images instead of the patient; `None`: the patient.
    pub tank: Option<Tank>,
}

/// A simulated ultrasound probe: the tool's tip is the middle of its face, beams run along the tool's z, the image's rows along
/// its x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Its elements.
    pub array: Array,
    /// How deep beams are shown, mm.
    pub depth_mm: f64,
    /// The side of a pixel, mm.
    pub pixel_mm: f64,
    /// Images a second.
    pub rate_hz: f64,
    /// How much later than its capture an image is stamped, s.
    pub lag_s: f64,
    /// The true speed of sound over the one that the scanner assumes.
    pub speed_ratio: f64,
}

impl Probe {
    /// The sides of the smallest image that shows every beam whole, mm.
    pub fn extent_mm(&self) -> [f64; 2] {
        match self.array {
            Array::Linear { width_mm } => [width_mm, self.depth_mm],
            Array::Convex {
                radius_mm,
                half_angle_rad,
            } => {
                let far_mm = radius_mm + self.depth_mm;
                [
                    2.0 * far_mm * half_angle_rad.sin(),
                    far_mm - radius_mm * half_angle_rad.cos(),
                ]
            }
        }
    }
}

/// The elements of an ultrasound probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Array {
    /// Side by side.
    Linear {
        /// From the first beam to the last, mm.
        width_mm: f64,
    },
    /// On an arc.
    Convex {
        /// The arc's, mm.
        radius_mm: f64,
        /// How far the outermost beams lean to each side, rad.
        half_angle_rad: f64,
    },
}

/// What is there to practise with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PracticeRoom {
    /// Where the divot is that a tip is turned in.
    pub divot: Point<Ct>,
    /// Where the calibration base stands.
    pub ct_from_base: Rigid<Ct, Base>,
    /// How far off the point a touch of the patient is, standard deviation along each axis, mm; the calibration base guides the tool.
    pub touch_error_mm: f64,
    /// How the tip trembles while it is held, standard deviation along each axis, mm.
    pub tremor_mm: f64,
}

/// A marker: its emitters, and how far to the side each is seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape<F: Frame> {
    /// Where they are.
    pub emitters: Emitters<F>,
    /// Half-angle of the cone about an emitter's normal from which it is seen; pi: from everywhere.
    pub cone_rad: f64,
}

/// Where the emitters of a marker are.
#[derive(Debug, Clone, PartialEq)]
pub enum Emitters<F: Frame> {
    /// Even on a sphere about the marker's origin, each looking outwards: the thesis's ball.
    Ball {
        /// How many.
        count: usize,
        /// The sphere's, mm.
        radius_mm: f64,
    },
    /// One by one.
    Listed(Vec<ListedEmitter<F>>),
}

impl<F: Frame> Emitters<F> {
    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Ball { count, .. } => *count,
            Self::Listed(list) => list.len(),
        }
    }
}

/// One emitter of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedEmitter<F: Frame> {
    /// Where it is.
    pub place: Point<F>,
    /// Where it looks; `None`: it is seen from everywhere.
    pub normal: Option<Direction<F>>,
}

/// The tool's handle: a cylinder with round ends about the tube's axis. A radius of 0 hides nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handle {
    /// From the tip back to its nearer end, mm.
    pub from_mm: f64,
    /// From the tip back to its farther end, mm.
    pub to_mm: f64,
    /// Its radius, mm.
    pub radius_mm: f64,
}

/// The surgeon's hand: a ball that goes once around the tool's marker, every so often.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Its radius, mm.
    pub radius_mm: f64,
    /// From one coming to the next, s.
    pub every_s: f64,
    /// How long it stays, s.
    pub for_s: f64,
}

/// What the localizer sees, and how well.
///
/// Noise is normal; at `d` mm from the origin of its frame the deviations are `across_mm (d / at_mm)^growth_across` along
/// each of the two directions across the line of sight and `depth_mm (d / at_mm)^growth_depth` along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Standard deviation across the line of sight, mm.
    pub across_mm: f64,
    /// Along it, mm.
    pub depth_mm: f64,
    /// The distance for which these hold, mm.
    pub at_mm: f64,
    /// How the deviation across grows with the distance.
    pub growth_across: f64,
    /// How the one along grows.
    pub growth_depth: f64,
    /// Coordinates are rounded to whole multiples of this, mm; 0: not at all.
    pub quantisation_mm: f64,
    /// Its eyes: an emitter is localized where every one of them sees it.
    pub eyes: Vec<Point<Tracker>>,
    /// Half-angle of its field of view about its +z; pi: all directions.
    pub view_rad: f64,
    /// Emitters nearer than this are not seen, mm.
    pub nearest_mm: f64,
    /// Nor those farther away, mm.
    pub farthest_mm: f64,
}

/// When the localizer's frames come, and what its clock says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// From the capture to the arrival, at least, s.
    pub latency_s: f64,
    /// Added to it: uniform between 0 and this, s.
    pub jitter_s: f64,
    /// Chance that a frame never comes.
    pub dropped: f64,
    /// Chance that a frame comes late.
    pub late: f64,
    /// By how much, s.
    pub late_s: f64,
    /// How much faster than true time its clock goes, parts per million.
    pub drift_ppm: f64,
    /// What its clock says when the script starts, s.
    pub offset_s: f64,
}

/// How the patient moves, and with it the CT's frame, the tool in it and the marker on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patient {
    /// `None`: it holds its breath.
    pub breathing: Option<Breathing>,
    /// `None`: nobody runs into it.
    pub bump: Option<Bump>,
    /// It slides, mm/s.
    pub drift_mm_per_s: Vector<Ct>,
}

/// Breathing: the patient is `amplitude_mm sin^4(pi t / period_s)` along `direction` from where it was registered, at the end
/// of an expiration, in which it rests longest (Lujan et al. 1999, with n = 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breathing {
    /// From the end of the expiration to that of the inspiration, mm.
    pub amplitude_mm: f64,
    /// The way of the inspiration.
    pub direction: Direction<Ct>,
    /// One breath, s.
    pub period_s: f64,
}

/// The patient is moved once and stays so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bump {
    /// When it begins, s of the script.
    pub at_s: f64,
    /// How long it takes, s.
    pub over_s: f64,
    /// By how much the CT's origin moves, mm.
    pub translation: Vector<Ct>,
    /// The turn about the CT's origin: axis times angle, radians.
    pub rotation: Vector<Ct>,
}

/// The marker on the patient.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceMarker {
    /// Its emitters.
    pub shape: Shape<Reference>,
    /// Where it sits on the patient.
    pub ct_from_reference: Rigid<Ct, Reference>,
}

/// What is broken about the tool's marker. Emitters are counted from 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faults {
    /// Emitters that do not shine.
    pub dead: Vec<usize>,
    /// Two emitters whose names are exchanged.
    pub swapped: Option<[usize; 2]>,
    /// Since when, s of the script.
    pub from_s: f64,
}

/// When a marker's pose is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gates {
    /// Fewest emitters that a pose may rest on.
    pub min_emitters: usize,
    /// Largest root mean square residual of the emitters kept, mm.
    pub max_fre_mm: f64,
    /// An emitter whose residual is this many of its own deviations off is left out.
    pub outlier_sigmas: f64,
    /// Largest predicted error at the tip, 95 %, mm.
    pub max_tip_mm: f64,
}

/// Standard deviations of a transform's error along and about each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviations {
    /// Along each axis, mm.
    pub shift_mm: f64,
    /// About each axis, radians.
    pub turn_rad: f64,
}

/// A gesture from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlayedGesture {
    /// A CSV file of poses with their times.
    pub file: PathBuf,
    /// What comes after its last pose.
    pub at_end: AtEnd,
}
