//! What is told of the noise and known before.

use crate::error::ProbeError;

/// Noise of a point in the image: standard deviations, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointNoise {
    /// Along a row of the image.
    pub lateral_mm: f64,
    /// Along the beam, down the image.
    pub axial_mm: f64,
    /// Across the image: half the thickness of the slice is about one deviation.
    pub elevation_mm: f64,
}

/// Noise of the probe's pose from frame to frame, which all points of a frame share: standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseNoise {
    /// Of the turn about each axis, rad.
    pub turn_rad: f64,
    /// Of the marker's origin along each axis, mm.
    pub shift_mm: f64,
}

/// What is known before, as standard deviations about it. 0 holds a number at what is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Priors {
    /// Sizes of a pixel along a row and a column, mm, with a relative deviation; `None` where nothing is known.
    pub pixel_mm: Option<([f64; 2], f64)>,
    /// Lag of the poses about 0, s; above 0 it needs a track.
    pub lag_s: f64,
    /// Each of the nine numbers of a linear error of the tracker's shifts, about 0: a field tracker's distortion.
    /// 0.03 is 3 %.
    pub tracker: f64,
    /// Play of each end of each wire in its hole, in each direction across it, mm.
    pub play_mm: f64,
}

/// How a calibration is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Noise of points.
    pub point: PointNoise,
    /// Noise of poses.
    pub pose: PoseNoise,
    /// What is known before.
    pub priors: Priors,
    /// Rounds of weights at the end, at most.
    pub rounds: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            point: PointNoise {
                lateral_mm: 0.3,
                axial_mm: 0.2,
                elevation_mm: 0.5,
            },
            pose: PoseNoise {
                turn_rad: 0.001,
                shift_mm: 0.1,
            },
            priors: Priors {
                pixel_mm: None,
                lag_s: 0.0,
                tracker: 0.0,
                play_mm: 0.0,
            },
            rounds: 60,
        }
    }
}

impl Options {
    pub(crate) fn check(&self) -> Result<(), ProbeError> {
        let PointNoise {
            lateral_mm,
            axial_mm,
            elevation_mm,
        } = self.point;
        let (sizes, relative) = self.priors.pixel_mm.unwrap_or(([0.1; 2], 0.0));
        // A NaN is within nothing.
        let rows: [(&'static str, f64, std::ops::RangeInclusive<f64>, &'static str); 11] = [
            ("the lateral noise, mm", lateral_mm, 0.001..=10.0, "0.001 to 10"),
            ("the axial noise, mm", axial_mm, 0.001..=10.0, "0.001 to 10"),
            (
                "the noise across the image, mm",
                elevation_mm,
                0.001..=10.0,
                "0.001 to 10",
            ),
            (
                "the noise of a pose's turn, rad",
                self.pose.turn_rad,
                0.0..=0.1,
                "0 to 0.1",
            ),
            (
                "the noise of a pose's shift, mm",
                self.pose.shift_mm,
                0.0..=10.0,
                "0 to 10",
            ),
            ("the pixel along a row, mm", sizes[0], 0.005..=2.0, "0.005 to 2"),
            ("the pixel along a column, mm", sizes[1], 0.005..=2.0, "0.005 to 2"),
            (
                "the deviation of the pixels' sizes",
                relative,
                0.0..=1.0,
                "0 to 1, as a share",
            ),
            ("the deviation of the lag, s", self.priors.lag_s, 0.0..=1.0, "0 to 1"),
            (
                "the linear error of the tracker",
                self.priors.tracker,
                0.0..=0.2,
                "0 to 0.2, as a share",
            ),
            ("the play of a wire, mm", self.priors.play_mm, 0.0..=2.0, "0 to 2"),
        ];
        match rows.into_iter().find(|(_, found, range, _)| !range.contains(found)) {
            None => Ok(()),
            Some((what, found, _, allowed)) => Err(ProbeError::Option { what, found, allowed }),
        }
    }
}
