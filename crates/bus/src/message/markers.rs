//! What a localizer that knows its markers delivers: their poses at one instant, before the chain to the patient.

use geometry::{DoorError, Frame, Rigid, Tracker, checked};
use iceoryx2::prelude::ZeroCopySend;

use super::{Lost, field_text, text_field};
use crate::clock;

/// One marker in one frame: its pose, or the reason why there is none.
///
/// On the wire: numbers only. Read it through [`MarkerFrame::sights`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/MarkerSight/1")]
pub struct MarkerSight {
    /// Unit quaternion (w, x, y, z) of `tracker_from_marker`; all zero when lost.
    pub q: [f64; 4],
    /// Translation of `tracker_from_marker`, mm; all zero when lost.
    pub t_mm: [f64; 3],
    /// How badly the localizer found the marker to fit, as it states it, mm; 0 where it states nothing.
    pub error_mm: f64,
    /// How long before the frame's capture the marker was seen last, ns; 0 in a pose, [`MarkerSight::NEVER`] where it was not
    /// seen since the localizer is there.
    pub age_ns: i64,
    /// Which marker: [`MarkerFrame::TOOL`], [`MarkerFrame::REFERENCE`]; others from 2 on.
    pub marker: u32,
    /// 0 is a pose; anything else is the code of a [`Lost`].
    pub status: u32,
}

/// Poses of markers, all of one instant.
///
/// On the wire: numbers only. Read it through [`MarkerFrame::sights`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/MarkerFrame/1")]
pub struct MarkerFrame {
    /// Counts the frames of a run from 0; the pose made of it has the same number.
    pub seq: u64,
    /// The localizer's own time of the measurement as it came, ns; 0 where it stamps nothing.
    pub t_device_ns: i64,
    /// When the frame was captured, ns on the run's clock: the stamp mapped onto it, or the arrival.
    pub t_capture_ns: i64,
    /// When the last byte of it arrived, ns on the run's clock.
    pub t_arrival_ns: i64,
    /// When it was published, ns on the run's clock.
    pub t_publish_ns: i64,
    /// How wrong `t_capture_ns` may be, ns, apart from the link's least delay; 0 where nothing is known of it.
    pub t_uncertain_ns: i64,
    /// What `t_capture_ns` rests on: the code of a [`CaptureClock`].
    pub clock: u32,
    /// How many of `sights` are meant.
    pub count: u32,
    /// The localizer's name, UTF-8, zeros behind: read it through [`MarkerFrame::device_name`].
    pub device: [u8; 32],
    /// The markers; zeros behind those that are meant.
    pub sights: [MarkerSight; MarkerFrame::MOST],
}

const _: () = assert!(size_of::<MarkerSight>() == 80 && align_of::<MarkerSight>() == 8);
const _: () = assert!(size_of::<MarkerFrame>() == 1368 && align_of::<MarkerFrame>() == 8);

/// What the time of a capture rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaptureClock {
    /// The time of arrival: the localizer's stamp is missing, or is not believed.
    Arrival,
    /// The localizer's stamp, mapped by the law of its clock ([`crate::clock::mapping`]).
    Mapped,
}

impl CaptureClock {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::Arrival, Self::Mapped];

    /// The code on the wire.
    pub const fn code(self) -> u32 {
        match self {
            Self::Arrival => 0,
            Self::Mapped => 1,
        }
    }

    /// The one with this code.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|clock| clock.code() == code)
    }

    /// In a word, for status and recordings.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Arrival => "arrival",
            Self::Mapped => "mapped",
        }
    }
}

/// A marker's pose, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight<M: Frame> {
    /// `tracker_from_marker`.
    pub tracker_from_marker: Result<Rigid<Tracker, M>, Lost>,
    /// See [`MarkerSight::error_mm`].
    pub error_mm: f64,
}

impl<M: Frame> Sight<M> {
    /// Of a marker that does not stand in the frame.
    pub const NONE: Self = Self {
        tracker_from_marker: Err(Lost::NotSeen),
        error_mm: 0.0,
    };
}

/// Why a frame of markers was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MarkersError {
    /// It says more markers than it can hold.
    #[error("frame {seq} of the localizer: {found} markers; at most {most} are allowed", most = MarkerFrame::MOST)]
    TooMany {
        /// Which frame.
        seq: u64,
        /// How many it claims.
        found: usize,
    },
    /// One marker stands in it twice.
    #[error("frame {seq} of the localizer: marker {marker} stands in it twice")]
    Twice {
        /// Which frame.
        seq: u64,
        /// Which marker.
        marker: u32,
    },
    /// The numbers of a marker are not a rigid transform.
    #[error("frame {seq} of the localizer, marker {marker}: {source}")]
    NotRigid {
        /// Which frame.
        seq: u64,
        /// Which marker.
        marker: u32,
        /// What is wrong with the numbers.
        source: DoorError,
    },
    /// A marker is further away than any localizer sees.
    #[error(
        "frame {seq} of the localizer, marker {marker}: {found_mm:e} mm away; at most {allowed_mm:e} mm are allowed"
    )]
    Far {
        /// Which frame.
        seq: u64,
        /// Which marker.
        marker: u32,
        /// The distance found.
        found_mm: f64,
        /// The largest allowed.
        allowed_mm: f64,
    },
    /// A pose was measured at another instant than the frame.
    #[error(
        "frame {seq} of the localizer, marker {marker}: its pose was measured {age_ms:.3} ms before the frame; a frame is of one instant"
    )]
    OtherInstant {
        /// Which frame.
        seq: u64,
        /// Which marker.
        marker: u32,
        /// How long before.
        age_ms: f64,
    },
    /// An error of fit that is none.
    #[error(
        "frame {seq} of the localizer, marker {marker}: an error of {found_mm} mm is stated; allowed are 0 (nothing stated) and more"
    )]
    Fit {
        /// Which frame.
        seq: u64,
        /// Which marker.
        marker: u32,
        /// The number found.
        found_mm: f64,
    },
    /// The status is neither a pose nor a known reason.
    #[error("frame {seq} of the localizer, marker {marker}: status {found} is unknown; allowed are 0 (a pose) and 1 to {most}", most = Lost::ALL.len())]
    UnknownStatus {
        /// Which frame.
        seq: u64,
        /// Which marker.
        marker: u32,
        /// The code found.
        found: u32,
    },
}

/// Drivers normalise in f64, and files keep fewer digits; what is further from unit is not a rotation that somebody measured.
const UNIT_TOLERANCE: f64 = 1e-6;
/// No localizer sees further.
const FARTHEST_MM: f64 = 1e5;

impl MarkerSight {
    /// [`MarkerSight::age_ns`] of a marker that was not seen yet.
    pub const NEVER: i64 = -1;

    const NONE: Self = Self {
        q: [0.0; 4],
        t_mm: [0.0; 3],
        error_mm: 0.0,
        age_ns: 0,
        marker: 0,
        status: 0,
    };

    /// A marker that was measured at the instant of the frame.
    pub fn seen<M: Frame>(marker: u32, tracker_from_marker: Rigid<Tracker, M>, error_mm: f64) -> Self {
        Self {
            q: tracker_from_marker.quaternion(),
            t_mm: tracker_from_marker.translation_mm(),
            error_mm,
            marker,
            ..Self::NONE
        }
    }

    /// A marker of which there is no pose, and when it was seen last.
    pub const fn lost(marker: u32, reason: Lost, age_ns: i64) -> Self {
        Self {
            age_ns,
            marker,
            status: reason.code(),
            ..Self::NONE
        }
    }
}

impl MarkerFrame {
    /// Most markers in a frame.
    pub const MOST: usize = 16;
    /// The marker on the tool.
    pub const TOOL: u32 = 0;
    /// The marker on the patient.
    pub const REFERENCE: u32 = 1;

    /// A frame of no marker; every number is zero.
    pub const EMPTY: Self = Self {
        seq: 0,
        t_device_ns: 0,
        t_capture_ns: 0,
        t_arrival_ns: 0,
        t_publish_ns: 0,
        t_uncertain_ns: 0,
        clock: 0,
        count: 0,
        device: [0; 32],
        sights: [MarkerSight::NONE; Self::MOST],
    };

    /// The localizer's name.
    pub fn device_name(&self) -> String {
        field_text(&self.device)
    }

    /// Names the localizer; what is longer than 32 bytes is cut.
    #[must_use]
    pub fn of_device(mut self, name: &str) -> Self {
        self.device = text_field(name);
        self
    }

    /// What the time of capture rests on; a code that is unknown promises no more than an arrival.
    pub fn capture_clock(&self) -> CaptureClock {
        CaptureClock::from_code(self.clock).unwrap_or(CaptureClock::Arrival)
    }

    /// The markers that are meant.
    ///
    /// # Errors
    /// [`MarkersError::TooMany`], [`MarkersError::Twice`]. Numbers are checked by [`MarkerFrame::sight`].
    pub fn sights(&self) -> Result<&[MarkerSight], MarkersError> {
        let (seq, found) = (self.seq, self.count as usize);
        let sights = self.sights.get(..found).ok_or(MarkersError::TooMany { seq, found })?;
        let twice =
            |(at, sight): &(usize, &MarkerSight)| sights[..*at].iter().any(|other| other.marker == sight.marker);
        match sights.iter().enumerate().find(twice) {
            Some((_, sight)) => Err(MarkersError::Twice {
                seq,
                marker: sight.marker,
            }),
            None => Ok(sights),
        }
    }

    /// Puts the markers into the frame.
    ///
    /// # Errors
    /// [`MarkersError::TooMany`]; the frame is as it was.
    pub fn set(&mut self, sights: &[MarkerSight]) -> Result<(), MarkersError> {
        let (seq, found) = (self.seq, sights.len());
        if found > Self::MOST {
            return Err(MarkersError::TooMany { seq, found });
        }
        self.sights = [MarkerSight::NONE; Self::MOST];
        self.sights[..found].copy_from_slice(sights);
        // At most 16.
        self.count = found as u32;
        Ok(())
    }

    /// The typed pose of `marker`, or why there is none: the door from the bus to geometry. A marker that does not stand in the
    /// frame was not seen.
    ///
    /// # Errors
    /// [`MarkersError`].
    pub fn sight<M: Frame>(&self, marker: u32) -> Result<Sight<M>, MarkersError> {
        let lost = |reason| Sight {
            tracker_from_marker: Err(reason),
            ..Sight::NONE
        };
        let Some(sight) = self.sights()?.iter().find(|sight| sight.marker == marker) else {
            return Ok(Sight::NONE);
        };
        let seq = self.seq;
        if sight.status != 0 {
            let found = sight.status;
            let unknown = MarkersError::UnknownStatus { seq, marker, found };
            return Lost::from_code(found).map(lost).ok_or(unknown);
        }
        let pose = checked::rigid(sight.q, sight.t_mm, UNIT_TOLERANCE).map_err(|source| MarkersError::NotRigid {
            seq,
            marker,
            source,
        })?;
        sight.check(seq)?;
        Ok(Sight {
            tracker_from_marker: Ok(pose),
            error_mm: sight.error_mm,
        })
    }
}

impl MarkerSight {
    /// What a pose must be besides rigid.
    fn check(&self, seq: u64) -> Result<(), MarkersError> {
        let marker = self.marker;
        let [x, y, z] = self.t_mm;
        let found_mm = x.hypot(y).hypot(z);
        if found_mm > FARTHEST_MM {
            let allowed_mm = FARTHEST_MM;
            return Err(MarkersError::Far {
                seq,
                marker,
                found_mm,
                allowed_mm,
            });
        }
        if self.age_ns != 0 {
            let age_ms = clock::ms(self.age_ns);
            return Err(MarkersError::OtherInstant { seq, marker, age_ms });
        }
        if !(0.0..f64::INFINITY).contains(&self.error_mm) {
            let found_mm = self.error_mm;
            return Err(MarkersError::Fit { seq, marker, found_mm });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
