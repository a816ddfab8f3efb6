//! The beams as they are computed: a grid of beams and samples along them.

use crate::settings::{Focus, Settings};
use crate::shape::{Beams, Shape};

/// Samples of a beam at most: twice the rows of a large screen.
const MOST_SAMPLES: f64 = 2048.0;
/// Full width at half of the peak of a Gaussian of deviation 1.
pub(crate) const FULL_WIDTH: f64 = 2.354_820_045_030_949_4;

/// Beam b of `beams` and sample n of `samples`; samples are `step_mm` apart as shown.
#[derive(Debug, Clone)]
pub(crate) struct Fan {
    pub(crate) shape: Shape,
    pub(crate) beams: usize,
    pub(crate) samples: usize,
    pub(crate) step_mm: f64,
    /// The true depth over the shown one.
    pub(crate) ratio: f64,
    pub(crate) pulse: f64,
    lateral: Focus,
    elevation: Focus,
}

impl Fan {
    pub(crate) fn new(shape: &Shape, settings: &Settings) -> Self {
        let depth = shape.depth_mm();
        // Four samples a pulse, so that a Gaussian between them keeps its height within 2 %.
        let intervals = (depth / (settings.pulse_mm / 4.0))
            .ceil()
            .clamp(8.0, MOST_SAMPLES - 1.0);
        let step_mm = depth / intervals;
        Self {
            shape: *shape,
            beams: settings.beams,
            samples: intervals as usize + 1,
            step_mm,
            ratio: settings.speed_ratio,
            // Narrower than half a sample, an echo between two would vanish.
            pulse: (settings.pulse_mm / FULL_WIDTH / step_mm).max(0.5),
            lateral: settings.lateral,
            elevation: settings.elevation,
        }
    }

    /// The place in the image's plane where what is shown at `shown_mm` of a beam truly lies.
    pub(crate) fn at(&self, beam: f64, shown_mm: f64) -> ([f64; 2], [f64; 2]) {
        let share = beam / (self.beams - 1) as f64;
        self.shape.along(share, shown_mm * self.ratio)
    }

    /// The beam, with its fraction, and the depth as shown of a place of the plane; both may lie outside.
    pub(crate) fn locate(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let last = (self.beams - 1) as f64;
        match self.shape.beams() {
            Beams::Linear {
                from_mm,
                to_mm,
                face_mm,
            } => ((x - from_mm) / (to_mm - from_mm) * last, (y - face_mm) / self.ratio),
            Beams::Convex {
                centre_mm,
                radius_mm,
                half_angle,
            } => {
                let [x, y] = [x - centre_mm[0], y - centre_mm[1]];
                let share = 0.5 + 0.5 * x.atan2(y) / half_angle;
                (share * last, (x.hypot(y) - radius_mm) / self.ratio)
            }
        }
    }

    /// How far beams are apart at a depth as shown, mm.
    pub(crate) fn pitch_mm(&self, shown_mm: f64) -> f64 {
        let last = (self.beams - 1) as f64;
        match self.shape.beams() {
            Beams::Linear { from_mm, to_mm, .. } => (to_mm - from_mm) / last,
            Beams::Convex {
                radius_mm, half_angle, ..
            } => 2.0 * half_angle / last * (radius_mm + shown_mm * self.ratio),
        }
    }

    /// The deviation of the Gaussian across the image, mm, at a depth as shown.
    pub(crate) fn elevation_mm(&self, shown_mm: f64) -> f64 {
        self.elevation.width_at(shown_mm) / FULL_WIDTH
    }

    /// The deviation of the Gaussian along a row, in beams, at a depth as shown.
    pub(crate) fn lateral_beams(&self, shown_mm: f64) -> f64 {
        // Narrower than half of the way between two beams, a wire between them would vanish.
        (self.lateral.width_at(shown_mm) / FULL_WIDTH / self.pitch_mm(shown_mm)).max(0.5)
    }

    /// Where a sample lies, mm as shown.
    pub(crate) fn shown_mm(&self, sample: usize) -> f64 {
        sample as f64 * self.step_mm
    }
}
