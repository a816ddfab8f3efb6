//! Why there is no calibration at all.

/// Why there is no calibration. What is found and not good enough is for gates.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProbeError {
    /// An option is out of its range.
    #[error("{what} is {found}; allowed is {allowed}")]
    Option {
        /// Which.
        what: &'static str,
        /// What was given.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A wire has no length, or a number that is none.
    #[error("wire {wire:?}: its ends are {found:.3} mm apart; 1 to 1000 mm are allowed (are these metres?)")]
    WireLength {
        /// Its name.
        wire: String,
        /// What was found, mm.
        found: f64,
    },
    /// Too few wires, or too many.
    #[error("{found} wires; 3 to 100 are allowed, for a check from 1 on")]
    WireCount {
        /// How many there are.
        found: usize,
    },
    /// All wires have one direction: along it nothing is held.
    #[error(
        "all {wires} wires are parallel to {most_deg:.2} degrees: the image may slide along them unseen; at least two must differ by 5 degrees"
    )]
    WiresParallel {
        /// How many there are.
        wires: usize,
        /// The largest angle between two, degrees.
        most_deg: f64,
    },
    /// Fewer frames than are needed.
    #[error("{found} frames with points and a pose; at least {needed} are needed")]
    TooFewFrames {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// Fewer points than are needed.
    #[error("{found} points; {needed} to {most} are allowed")]
    PointCount {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
        /// How many are taken.
        most: usize,
    },
    /// A pixel that is not a finite number from -1e5 to 1e5.
    #[error("frame {frame}, point {point}: the pixel is ({u}, {v}); numbers from -1e5 to 1e5 are allowed")]
    BadPixel {
        /// The frame's number.
        frame: u32,
        /// The point's, from 0.
        point: usize,
        /// Column.
        u: f64,
        /// Row.
        v: f64,
    },
    /// A point of a wire that is not there.
    #[error("frame {frame}, point {point}: wire {found} of {wires}, from 0")]
    NoSuchWire {
        /// The frame's number.
        frame: u32,
        /// The point's, from 0.
        point: usize,
        /// What it names.
        found: usize,
        /// How many there are.
        wires: usize,
    },
    /// A lag was asked for and there is no track to move along.
    #[error(
        "the lag between image and pose is asked for, and there are no times: it needs a track and a time for each frame"
    )]
    NoTrack,
    /// A lag was asked for and the track is no mean of neighbours.
    #[error(
        "the lag between image and pose is asked for, and the poses are taken as they were recorded: midway between two their noise is \
         less, which draws the lag there; give the track a window of at least the time between poses"
    )]
    NoWindow,
    /// A frame's time lies outside of the track.
    #[error("frame {frame}: its time {t_s} s lies outside of the poses' {first_s} to {last_s} s")]
    OffTrack {
        /// The frame's number.
        frame: u32,
        /// Its time.
        t_s: f64,
        /// The first of the track.
        first_s: f64,
        /// The last.
        last_s: f64,
    },
    /// All frames were taken at one pose.
    #[error(
        "the probe turned by {turn_deg:.2} degrees and moved by {shift_mm:.2} mm over all {frames} frames: they are one picture; move it \
         along the wires and tilt it"
    )]
    OnePose {
        /// How many there are.
        frames: usize,
        /// The largest turn from the first, degrees.
        turn_deg: f64,
        /// The largest way from the first, mm.
        shift_mm: f64,
    },
    /// The equations leave a motion open altogether.
    #[error("the points do not hold the image: {what}")]
    Open {
        /// What, in words.
        what: String,
    },
    /// No start led anywhere.
    #[error("no place of the image fits the points: wires and points do not belong together, or a unit is wrong")]
    Nowhere,
    /// The pixels found are none of an ultrasound image.
    #[error(
        "the pixels found are {u:.5} x {v:.5} mm; 0.005 to 2 mm are allowed: is the phantom or the tracker not in mm?"
    )]
    PixelSize {
        /// Along a row, mm.
        u: f64,
        /// Along a column, mm.
        v: f64,
    },
}
