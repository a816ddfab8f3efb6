//! The tool's pose, as published by the tracker process.

use geometry::{Ct, DoorError, Rigid, Tool, checked};
use iceoryx2::prelude::ZeroCopySend;

use super::Lost;
use crate::clock;

/// One sample of the tool's pose in the patient, or the reason why there is none.
///
/// On the wire: numbers only. Read it through [`ToolPose::tracked`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/ToolPose/2")]
pub struct ToolPose {
    /// Counts the samples of a run from 0; a gap means that samples were lost.
    pub seq: u64,
    /// The source's own time of the measurement, ns: the localizer's clock, the simulator's script, a recording.
    pub t_device_ns: i64,
    /// When the sample was captured, ns on the run's clock.
    pub t_capture_ns: i64,
    /// When it was published, ns on the run's clock.
    pub t_publish_ns: i64,
    /// Identifies the registration (and calibrations) that `ct_from_tool` rests on.
    pub registration_id: u64,
    /// 0 is valid; anything else is the code of a [`Lost`].
    pub status: u32,
    /// How many emitters the localizer saw.
    pub visible: u32,
    /// Unit quaternion (w, x, y, z) of `ct_from_tool`; all zero when lost.
    pub q: [f64; 4],
    /// Translation of `ct_from_tool`, mm; all zero when lost.
    pub t_mm: [f64; 3],
    /// Upper triangle, row by row, of the 6x6 covariance of (rotation vector, translation) in `Ct`; rad and mm.
    pub covariance: [f64; 21],
    /// Root of the mean squared distance per emitter of the marker's fit, mm.
    pub fre_rms_mm: f64,
    /// Predicted error at the tip, 95 %, mm; 0 where it is not known. Read it through [`ToolPose::tip_95_mm`].
    pub tip_mm: f64,
    /// How much older than its capture the pose is in effect, by smoothing, ns; 0 without.
    pub delay_ns: i64,
    /// How many of the emitters seen the pose rests on.
    pub used: u32,
    /// Bits of [`ToolPose::OUTSIDE`], [`ToolPose::TIP_KNOWN`], [`ToolPose::NOISELESS`].
    pub flags: u32,
}

const _: () = assert!(size_of::<ToolPose>() == 304 && align_of::<ToolPose>() == 8);

/// A value or a reason, never a sentinel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tracked {
    /// The pose `ct_from_tool`.
    Valid(Rigid<Ct, Tool>),
    /// No pose, and why.
    Lost(Lost),
}

/// Why a pose from the bus was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// The numbers are not a rigid transform.
    #[error("pose {seq}: {source}")]
    NotRigid {
        /// Which sample.
        seq: u64,
        /// What is wrong with the numbers.
        source: DoorError,
    },
    /// The sample claims to be captured later than now: its age would never be noticed.
    #[error(
        "pose {seq}: captured {ahead_ms:.1} ms in the future; at most {allowed_ms:.1} ms are allowed. Stamps are ns since the run's epoch on CLOCK_MONOTONIC"
    )]
    Future {
        /// Which sample.
        seq: u64,
        /// How far ahead.
        ahead_ms: f64,
        /// The most that is taken for jitter between two readings of the clock.
        allowed_ms: f64,
    },
    /// The tool is further from the origin of the examination's frame than any localizer sees.
    #[error("pose {seq}: the tip is {found_mm:e} mm from the origin; at most {allowed_mm:e} mm are allowed")]
    Far {
        /// Which sample.
        seq: u64,
        /// The distance found.
        found_mm: f64,
        /// The largest allowed.
        allowed_mm: f64,
    },
    /// The error predicted at the tip is no radius, or so large that the pose says nothing.
    #[error(
        "pose {seq}: the error predicted at the tip is {found_mm} mm; allowed are 0 to {allowed_mm} mm, with variances of at least 0"
    )]
    Accuracy {
        /// Which sample.
        seq: u64,
        /// The error found, mm, or the variance below zero.
        found_mm: f64,
        /// The largest allowed.
        allowed_mm: f64,
    },
    /// The status is neither valid nor a known reason.
    #[error("pose {seq}: status {found} is unknown; allowed are 0 (valid) and 1 to {most}", most = Lost::ALL.len())]
    UnknownStatus {
        /// Which sample.
        seq: u64,
        /// The code found.
        found: u32,
    },
}

/// All processes read one clock, so a stamp can be ahead only by what its maker rounds.
const FUTURE_NS: i64 = 5_000_000;
/// Both sides normalise in f64, so a quaternion further from unit than this was not made by a tracker process.
const UNIT_TOLERANCE: f64 = 1e-9;
/// A localizer sees a few metres, and scanners put their origin within a few metres of the patient.
const FARTHEST_MM: f64 = 1e5;
/// A tip that is not known to a metre is not known.
const WORST_TIP_MM: f64 = 1e3;
/// Where the variances stand among the 21 numbers of a covariance.
const VARIANCES: [usize; 6] = [0, 6, 11, 15, 18, 20];

impl ToolPose {
    /// A sample without a pose, to be filled in; every number is zero.
    pub const EMPTY: Self = Self {
        seq: 0,
        t_device_ns: 0,
        t_capture_ns: 0,
        t_publish_ns: 0,
        registration_id: 0,
        status: 1,
        visible: 0,
        q: [0.0; 4],
        t_mm: [0.0; 3],
        covariance: [0.0; 21],
        fre_rms_mm: 0.0,
        tip_mm: 0.0,
        delay_ns: 0,
        used: 0,
        flags: 0,
    };

    /// Flag: the source found the tip outside the examination. For recordings: who shows a pose compares tip and grid itself.
    pub const OUTSIDE: u32 = 1;
    /// Flag: the error at the tip is predicted.
    pub const TIP_KNOWN: u32 = 2;
    /// Flag: the source has no noise, so that a tool at rest gives the same numbers again and again. Without it such numbers
    /// are taken for a measurement that stands still ([`Lost::Frozen`]).
    pub const NOISELESS: u32 = 4;

    /// Predicted error at the tip, 95 %, mm, where there is a prediction.
    pub fn tip_95_mm(&self) -> Option<f64> {
        (self.flags & Self::TIP_KNOWN != 0 && (0.0..=WORST_TIP_MM).contains(&self.tip_mm)).then_some(self.tip_mm)
    }

    /// Whether the source found the tip outside the examination.
    pub fn said_outside(&self) -> bool {
        self.flags & Self::OUTSIDE != 0
    }

    /// Puts the pose, or the reason why there is none, into the message.
    pub fn set(&mut self, tracked: Tracked) {
        match tracked {
            Tracked::Valid(ct_from_tool) => {
                self.status = 0;
                self.q = ct_from_tool.quaternion();
                self.t_mm = ct_from_tool.translation_mm();
            }
            Tracked::Lost(reason) => {
                self.status = reason.code();
                self.q = [0.0; 4];
                self.t_mm = [0.0; 3];
            }
        }
    }

    /// The same as [`ToolPose::tracked`] for a sample that arrived at `now_ns` on the run's clock: one from the future is
    /// refused too, as it would never grow old.
    ///
    /// # Errors
    /// [`PoseError`].
    pub fn tracked_at(&self, now_ns: i64) -> Result<Tracked, PoseError> {
        let ahead = self.t_capture_ns.saturating_sub(now_ns);
        if ahead > FUTURE_NS {
            return Err(PoseError::Future {
                seq: self.seq,
                ahead_ms: clock::ms(ahead),
                allowed_ms: clock::ms(FUTURE_NS),
            });
        }
        self.tracked()
    }

    /// The typed pose: the door from the bus to geometry.
    ///
    /// # Errors
    /// [`PoseError`]: a NaN, a quaternion that is not unit to 1e-9, a tip 100 m away, an error at the tip that is no radius, an
    /// unknown status.
    pub fn tracked(&self) -> Result<Tracked, PoseError> {
        if self.status == 0 {
            let pose = checked::rigid(self.q, self.t_mm, UNIT_TOLERANCE)
                .map_err(|source| PoseError::NotRigid { seq: self.seq, source })?;
            self.check_tip(&pose)?;
            self.check_accuracy()?;
            return Ok(Tracked::Valid(pose));
        }
        Lost::from_code(self.status)
            .map(Tracked::Lost)
            .ok_or(PoseError::UnknownStatus {
                seq: self.seq,
                found: self.status,
            })
    }
}

impl ToolPose {
    fn check_tip(&self, pose: &Rigid<Ct, Tool>) -> Result<(), PoseError> {
        let [x, y, z] = pose.translation_mm();
        let found_mm = x.hypot(y).hypot(z);
        match found_mm <= FARTHEST_MM {
            true => Ok(()),
            false => Err(PoseError::Far {
                seq: self.seq,
                found_mm,
                allowed_mm: FARTHEST_MM,
            }),
        }
    }

    /// What is said to be known must be usable.
    fn check_accuracy(&self) -> Result<(), PoseError> {
        if self.flags & Self::TIP_KNOWN == 0 {
            return Ok(());
        }
        let variance = VARIANCES
            .map(|at| self.covariance[at])
            .into_iter()
            .find(|v| v.is_nan() || *v < 0.0);
        let wrong = match (0.0..=WORST_TIP_MM).contains(&self.tip_mm) {
            true => variance.or_else(|| self.covariance.into_iter().find(|c| !c.is_finite())),
            false => Some(self.tip_mm),
        };
        wrong.map_or(Ok(()), |found_mm| {
            Err(PoseError::Accuracy {
                seq: self.seq,
                found_mm,
                allowed_mm: WORST_TIP_MM,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector;

    fn known(tip_mm: f64) -> ToolPose {
        let mut message = ToolPose {
            tip_mm,
            flags: ToolPose::TIP_KNOWN,
            ..ToolPose::EMPTY
        };
        message.set(Tracked::Valid(Rigid::identity()));
        message
    }

    /// It was taken for a pose, and the slice through it for an empty one.
    #[test]
    fn a_tip_out_of_this_world_is_refused() {
        for far in [1e300, -1.1e5, f64::MAX] {
            let message = ToolPose {
                t_mm: [0.0, far, 0.0],
                ..known(1.0)
            };
            assert!(matches!(message.tracked(), Err(PoseError::Far { .. })), "{far}");
        }
    }

    #[test]
    fn an_error_at_the_tip_that_is_no_radius_is_refused() {
        for good in [0.0, 0.3, 1e3] {
            assert!(known(good).tracked().is_ok() && known(good).tip_95_mm() == Some(good));
        }
        for bad in [-1e-9, -1.0, 1.1e3, f64::INFINITY, f64::NAN] {
            assert!(matches!(known(bad).tracked(), Err(PoseError::Accuracy { .. })), "{bad}");
            assert_eq!(known(bad).tip_95_mm(), None);
            let unknown = ToolPose { flags: 0, ..known(bad) };
            assert!(
                unknown.tracked().is_ok(),
                "what is not said to be known is not looked at"
            );
            let mut message = known(1.0);
            message.covariance[18] = if bad > 0.0 { f64::INFINITY } else { bad };
            assert!(message.tracked().is_err(), "{bad}");
        }
    }

    #[test]
    fn poses_come_back_bit_for_bit() {
        let pose: Rigid<Ct, Tool> =
            Rigid::from_rotation_vector(Vector::new(0.3, -1.2, 0.7), Vector::new(12.5, -40.0, 1e-3)).unwrap();
        let mut message = ToolPose::EMPTY;
        message.set(Tracked::Valid(pose));
        assert_eq!(message.tracked(), Ok(Tracked::Valid(pose)));
    }

    #[test]
    fn a_lost_pose_carries_no_numbers() {
        let mut message = ToolPose::EMPTY;
        message.set(Tracked::Valid(Rigid::identity()));
        message.set(Tracked::Lost(Lost::NotSeen));
        assert_eq!(message.q, [0.0; 4]);
        assert_eq!(message.tracked(), Ok(Tracked::Lost(Lost::NotSeen)));
    }

    #[test]
    fn a_pose_from_the_future_is_refused() {
        let mut message = ToolPose::EMPTY;
        message.set(Tracked::Valid(Rigid::identity()));
        message.t_capture_ns = 1_000_000_000;
        assert!(message.tracked_at(1_000_000_000 - FUTURE_NS).is_ok());
        let error = message.tracked_at(0).unwrap_err().to_string();
        assert!(error.contains("captured 1000.0 ms in the future"), "{error}");
        message.t_capture_ns = i64::MAX;
        assert!(message.tracked_at(i64::MIN).is_err());
    }

    #[test]
    fn impossible_poses_are_refused() {
        let mut message = ToolPose::EMPTY;
        message.set(Tracked::Valid(Rigid::identity()));
        message.seq = 41;
        for bad in [f64::NAN, f64::INFINITY] {
            let mut nan = message;
            nan.t_mm[1] = bad;
            let text = nan.tracked().unwrap_err().to_string();
            assert!(text.contains("pose 41") && text.contains("finite"), "{text}");
        }
        message.q = [1.0, 0.1, 0.0, 0.0];
        assert!(matches!(message.tracked(), Err(PoseError::NotRigid { seq: 41, .. })));
        message.status = 77;
        assert!(matches!(
            message.tracked(),
            Err(PoseError::UnknownStatus { found: 77, .. })
        ));
    }
}
