//! A rendered image and the stamp it can never be parted from.

use std::ops::RangeInclusive;

use iceoryx2::prelude::ZeroCopySend;

use super::images::{CENTRE_HU, FIELD_MM, WIDTH_HU};
use super::tissue::{WHY_WORDS, packed, unpacked};
use super::{Lost, TargetShown, TissueShown, ToolPose, Tracked, VolumeHash};
use crate::clock;
use geometry::SlicePlane;
use geometry::checked::{self, DoorError};
use scene::{Limits, WindowLevel};

/// Which pose, which registration and which volume an image shows, and when each stage was passed.
///
/// Stage times are ns on the run's clock.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/FrameStamp/6")]
pub struct FrameStamp {
    /// Sequence number of the pose shown.
    pub seq: u64,
    /// The source's own time of that pose.
    pub t_device_ns: i64,
    /// When the pose was captured.
    pub t_capture_ns: i64,
    /// When the pose was published.
    pub t_publish_ns: i64,
    /// When the renderer took it from the bus.
    pub t_seen_ns: i64,
    /// When the last pixel was drawn.
    pub t_rendered_ns: i64,
    /// When the image was handed to the bus.
    pub t_framed_ns: i64,
    /// The registration that the pose rests on.
    pub registration_id: u64,
    /// The volume that was cut.
    pub volume_hash: [u8; 32],
    /// Code of a [`FrameState`].
    pub state: u32,
    /// Index of the view in the scene's list.
    pub view: u32,
    /// 1 where the image was asked for by a command and not drawn because a pose came.
    pub on_request: u32,
    /// 1 where the pose comes out of a recording, 2 where time is simulated; 0 is the present. Whoever shows such an image says
    /// so, whatever its state.
    pub replay: u32,
    /// Of the tissue that is shown: [`super::TissueHeader::seq`].
    pub tissue_seq: u64,
    /// Its mesh: the first eight bytes of its id; 0 where none is known.
    pub tissue_mesh: u64,
    /// The chosen target's centre, mm in the CT, as it was planned, and where the image has it; both zero where none is chosen.
    pub target_mm: [f64; 3],
    /// See `target_mm`.
    pub target_shown_mm: [f64; 3],
    /// What a settled state's tissue does to the tube, N, and 95 % of what is uncertain of that; each below 0 where it is not known.
    pub force_n: f64,
    /// See `force_n`.
    pub force_95_n: f64,
    /// Code of a [`super::TissueShown`]: what of the tissue the image shows.
    pub tissue: u32,
    /// Code of a [`TargetShown`]: where the image has the chosen target.
    pub target: u32,
    /// Why the image shows organs at rest where a model refused the pose, as UTF-8 with zeros behind it: see [`FrameStamp::tissue_why`].
    pub tissue_why: [u64; 20],
}

const _: () = assert!(WHY_WORDS == 20 && size_of::<FrameStamp>() == 360 && align_of::<FrameStamp>() == 8);

/// What an image claims about the present.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameState {
    /// Shows a valid pose, young enough when it was drawn.
    Live,
    /// Shows a valid pose, older than the scene's limit when it was drawn; its age stands on it.
    Stale,
    /// Shows a valid pose that was asked for: it claims nothing of the present.
    Requested,
    /// Shows a plane that was asked for, whatever the tool does: it claims nothing of the present, and shows no pose.
    Look,
    /// There is no pose, and the image says so.
    Lost(Lost),
}

/// When a pose grows old, and when it is none any more, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ages {
    /// Older than this it is stale.
    pub stale_ns: i64,
    /// Older than this its source is silent, and there is no pose. At least as large.
    pub lost_ns: i64,
}

impl Ages {
    /// Of a scene.
    pub fn of(limits: &Limits) -> Self {
        Self {
            stale_ns: clock::ns(limits.stale),
            lost_ns: clock::ns(limits.lost),
        }
    }

    /// What a valid pose of this age is.
    pub fn state(self, age_ns: i64) -> FrameState {
        match age_ns {
            age if age > self.lost_ns => FrameState::Lost(Lost::Silent),
            age if age > self.stale_ns => FrameState::Stale,
            _ => FrameState::Live,
        }
    }

    /// What the newest sample of a tracker, which came to `tracked`, is at `now_ns`. One without a pose says why as long as it is news: it bears
    /// the time when nothing was seen, which behind a queue is long ago, and its source is silent only where it has long been *published*.
    pub fn of_sample(self, sample: &ToolPose, tracked: Tracked, now_ns: i64) -> FrameState {
        match tracked {
            Tracked::Valid(_) => self.state(now_ns.saturating_sub(sample.t_capture_ns)),
            Tracked::Lost(reason) => {
                let news_ns = sample.t_publish_ns.max(sample.t_capture_ns);
                match self.state(now_ns.saturating_sub(news_ns)) {
                    FrameState::Live => FrameState::Lost(reason),
                    _ => FrameState::Lost(Lost::Silent),
                }
            }
        }
    }
}

impl FrameState {
    /// The code on the wire.
    pub const fn code(self) -> u32 {
        match self {
            Self::Live => 0,
            Self::Stale => 100,
            Self::Requested => 101,
            Self::Look => 102,
            Self::Lost(reason) => reason.code(),
        }
    }

    /// The state with this code.
    pub const fn from_code(code: u32) -> Option<Self> {
        match code {
            0 => Some(Self::Live),
            100 => Some(Self::Stale),
            101 => Some(Self::Requested),
            102 => Some(Self::Look),
            code => match Lost::from_code(code) {
                Some(reason) => Some(Self::Lost(reason)),
                None => None,
            },
        }
    }
}

impl FrameStamp {
    /// The state, or `None` for an unknown code.
    pub fn frame_state(&self) -> Option<FrameState> {
        FrameState::from_code(self.state)
    }

    /// What the image may claim at `now_ns`: one that was live when it was drawn grows stale and then lost with its pose,
    /// whatever stands on it.
    pub fn state_at(&self, now_ns: i64, ages: Ages) -> Option<FrameState> {
        let aged = ages.state(now_ns.saturating_sub(self.t_capture_ns));
        match self.frame_state() {
            Some(FrameState::Live) => Some(aged),
            Some(FrameState::Stale) if aged != FrameState::Live => Some(aged),
            state => state,
        }
    }

    /// The stamp in words, for the text chunks of a PNG. Only what is the same whenever the same pose is drawn again: no
    /// times of this run's clock.
    pub fn texts(&self) -> Vec<(&'static str, String)> {
        let state = match self.frame_state() {
            Some(FrameState::Live | FrameState::Requested) => "valid",
            Some(FrameState::Stale) => "stale",
            Some(FrameState::Look) => "none",
            Some(FrameState::Lost(reason)) => reason.words(),
            None => "unknown",
        };
        let mut texts = vec![
            ("pose_seq", self.seq.to_string()),
            ("pose_time_ns", self.t_device_ns.to_string()),
            ("registration_id", format!("{:016x}", self.registration_id)),
            ("volume_hash", self.volume().to_string()),
            ("pose_state", state.to_owned()),
        ];
        match TissueShown::from_code(self.tissue) {
            Some(TissueShown::None) => {}
            Some(shown) => texts.push(("tissue", shown.word().to_owned())),
            None => texts.push(("tissue", "unknown".to_owned())),
        }
        if !self.tissue_why().is_empty() {
            texts.push(("tissue_why", self.tissue_why().to_owned()));
        }
        if self.tissue_seq != 0 {
            texts.push(("tissue_seq", self.tissue_seq.to_string()));
            texts.push(("tissue_mesh", format!("{:016x}", self.tissue_mesh)));
        }
        if let Some((force, error)) = self.force() {
            texts.push(("tissue_force_n", format!("{force:.3}")));
            let error = error.map_or_else(|| "unknown".to_owned(), |error| format!("{error:.3}"));
            texts.push(("tissue_force_95_n", error));
        }
        if TargetShown::from_code(self.target).is_some_and(TargetShown::is_moved) {
            let [x, y, z] = self.target_shown_mm;
            texts.push(("target_moved_to_mm", format!("{x:.3} {y:.3} {z:.3}")));
        }
        texts
    }

    /// What the tissue of the image does to the tube, N, and 95 % of what uncertain numbers of the model leave of that, where it is known; `None` of an
    /// image that shows no settled state.
    pub fn force(&self) -> Option<(f64, Option<f64>)> {
        let is_known = |n: f64| n >= 0.0 && n.is_finite();
        let is_settled = TissueShown::from_code(self.tissue) == Some(TissueShown::Settled);
        let force = is_settled.then_some(self.force_n).filter(|n| is_known(*n))?;
        Some((force, Some(self.force_95_n).filter(|n| is_known(*n))))
    }

    /// The same with so much of the words why a model refused the pose as there is room for.
    #[must_use]
    pub fn refused_because(self, why: &str) -> Self {
        let tissue_why = packed(why);
        Self { tissue_why, ..self }
    }

    /// Why a model refused the pose, in its words; empty where it did not, or what is told is no text.
    pub fn tissue_why(&self) -> &str {
        unpacked(&self.tissue_why)
    }

    /// The volume shown.
    pub fn volume(&self) -> VolumeHash {
        VolumeHash(self.volume_hash)
    }
}

/// Which plane of the patient an image shows, and which window of HU.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/ImagePlane/1")]
pub struct ImagePlane {
    /// Centre of the first pixel (column 0, row 0) in the CT's frame, LPS, mm.
    pub origin_mm: [f64; 3],
    /// Unit direction of growing columns, LPS.
    pub right: [f64; 3],
    /// Unit direction of growing rows, LPS, orthogonal to `right`.
    pub down: [f64; 3],
    /// Side of a pixel, mm; 0 where no pose ever placed the image.
    pub pixel_mm: f64,
    /// The HU shown as middle grey.
    pub centre_hu: f64,
    /// From black to white, HU.
    pub width_hu: f64,
}

impl ImagePlane {
    /// That of `plane`; `None` where no pose ever placed the image.
    pub fn of(plane: Option<&SlicePlane>, window: WindowLevel) -> Self {
        let placed = plane.map(|plane| Self {
            origin_mm: plane.origin().mm(),
            right: plane.right().components(),
            down: plane.down().components(),
            pixel_mm: plane.pixel_mm(),
            ..Self::default()
        });
        Self {
            centre_hu: window.centre_hu,
            width_hu: window.width_hu,
            ..placed.unwrap_or_default()
        }
    }
}

/// No place of an image lies further from the CT's origin along an axis, mm.
const MAX_MM: f64 = 1e4;

/// Why a plane that was asked for is not drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LookError {
    /// It is no plane.
    #[error("the plane asked for: {0}")]
    Plane(#[from] DoorError),
    /// A number is none, or beyond what may be asked for.
    #[error("the plane asked for: {what} is {found}, expected {expected}")]
    Number {
        /// Which.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
}

impl ImagePlane {
    /// The plane and the window of an image of `size` pixels that somebody asks for: the door from the bus to geometry.
    ///
    /// # Errors
    /// [`LookError`] for numbers that are no plane or no window, and for a plane beyond what a scene's views may show.
    pub fn asked(&self, size: [u32; 2]) -> Result<(SlicePlane, WindowLevel), LookError> {
        let within = |what, found: f64, range: RangeInclusive<f64>, expected| match range.contains(&found) {
            true => Ok(found),
            false => Err(LookError::Number { what, found, expected }),
        };
        let window = WindowLevel {
            centre_hu: within("centre_hu", self.centre_hu, CENTRE_HU, "-32768 to 32767 HU")?,
            width_hu: within("width_hu", self.width_hu, WIDTH_HU, "1 to 65536 HU")?,
        };
        let plane = checked::slice_plane(self.origin_mm, [self.right, self.down], self.pixel_mm, size)?;
        for mm in self.origin_mm {
            within("origin_mm", mm, -MAX_MM..=MAX_MM, "-10000 to 10000 mm")?;
        }
        let shorter = f64::from(size[0].min(size[1]));
        within("the shorter side", self.pixel_mm * shorter, FIELD_MM, "1 to 2000 mm")?;
        Ok((plane, window))
    }
}

/// Travels in front of the pixels: RGBA, 8 bits, row by row from the top.
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/FrameHeader/7")]
pub struct FrameHeader {
    /// What is shown.
    pub stamp: FrameStamp,
    /// Where.
    pub plane: ImagePlane,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

const _: () = assert!(size_of::<FrameHeader>() == 464);

impl FrameHeader {
    /// Where in the patient the pixels lie, bit for bit as the renderer placed them; `None` where no pose ever did, and nothing may be
    /// measured on the image.
    ///
    /// # Errors
    /// [`DoorError`] for numbers that are no plane.
    pub fn slice_plane(&self) -> Result<Option<SlicePlane>, DoorError> {
        let ImagePlane {
            origin_mm,
            right,
            down,
            pixel_mm,
            ..
        } = self.plane;
        if pixel_mm == 0.0 {
            return Ok(None);
        }
        checked::slice_plane(origin_mm, [right, down], pixel_mm, [self.width, self.height]).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Direction, Point, Rigid};

    #[test]
    fn the_plane_of_an_image_is_that_of_its_renderer_or_refused() {
        let axes = [Direction::Y, -Direction::Z];
        let plane = SlicePlane::centred(Point::new(0.1, 2.0, 1e4), axes, 0.7, [7, 5]).unwrap();
        let window = WindowLevel {
            centre_hu: 40.0,
            width_hu: 400.0,
        };
        let header = |plane| FrameHeader {
            plane,
            width: 7,
            height: 5,
            ..FrameHeader::default()
        };
        let placed = ImagePlane::of(Some(&plane), window);
        assert_eq!(header(placed).slice_plane(), Ok(Some(plane)));
        assert_eq!((placed.centre_hu, placed.width_hu), (40.0, 400.0));
        assert_eq!(header(ImagePlane::of(None, window)).slice_plane(), Ok(None));
        let bad = [
            ImagePlane {
                pixel_mm: f64::NAN,
                ..placed
            },
            ImagePlane {
                pixel_mm: -0.7,
                ..placed
            },
            ImagePlane {
                right: [0.0, f64::INFINITY, 0.0],
                ..placed
            },
            ImagePlane {
                down: placed.right,
                ..placed
            },
            ImagePlane {
                origin_mm: [f64::NAN; 3],
                ..placed
            },
        ];
        bad.iter()
            .for_each(|plane| assert!(header(*plane).slice_plane().is_err(), "{plane:?}"));
    }

    #[test]
    fn a_plane_that_is_asked_for_is_taken_to_the_bit_or_refused_by_name() {
        let good = ImagePlane {
            origin_mm: [1.0, -2.0, 1e4],
            right: [0.0, 1.0, 0.0],
            down: [0.0, 0.0, -1.0],
            pixel_mm: 0.25,
            centre_hu: 40.0,
            width_hu: 400.0,
        };
        let (plane, window) = good.asked([64, 512]).unwrap();
        assert_eq!(ImagePlane::of(Some(&plane), window), good);
        for (what, bad) in [
            (
                "centre_hu",
                ImagePlane {
                    centre_hu: f64::NAN,
                    ..good
                },
            ),
            ("centre_hu", ImagePlane { centre_hu: 4e4, ..good }),
            ("width_hu", ImagePlane { width_hu: 0.0, ..good }),
            (
                "width_hu",
                ImagePlane {
                    width_hu: f64::INFINITY,
                    ..good
                },
            ),
            (
                "origin_mm",
                ImagePlane {
                    origin_mm: [0.0, 1e5, 0.0],
                    ..good
                },
            ),
            ("shorter side", ImagePlane { pixel_mm: 40.0, ..good }),
            ("shorter side", ImagePlane { pixel_mm: 0.01, ..good }),
            ("plane", ImagePlane { pixel_mm: 0.0, ..good }),
            (
                "plane",
                ImagePlane {
                    pixel_mm: f64::NAN,
                    ..good
                },
            ),
            (
                "plane",
                ImagePlane {
                    pixel_mm: f64::MAX,
                    ..good
                },
            ),
            (
                "plane",
                ImagePlane {
                    pixel_mm: -0.25,
                    ..good
                },
            ),
            (
                "plane",
                ImagePlane {
                    origin_mm: [0.0, f64::NAN, 0.0],
                    ..good
                },
            ),
            (
                "plane",
                ImagePlane {
                    right: [0.0; 3],
                    ..good
                },
            ),
            (
                "plane",
                ImagePlane {
                    right: [0.0, 0.6, -0.8],
                    ..good
                },
            ),
            (
                "plane",
                ImagePlane {
                    down: [0.0, 0.0, -1e200],
                    ..good
                },
            ),
            ("plane", ImagePlane::default()),
        ] {
            let error = bad.asked([64, 512]).map(|_| bad).unwrap_err().to_string();
            assert!(error.contains(what), "{bad:?}: {error}");
        }
    }

    #[test]
    fn a_live_image_grows_stale() {
        let stamp = FrameStamp {
            t_capture_ns: 1000,
            ..FrameStamp::default()
        };
        let ages = Ages {
            stale_ns: 100,
            lost_ns: 500,
        };
        let expected = [
            (1100, FrameState::Live),
            (1101, FrameState::Stale),
            (1500, FrameState::Stale),
            (1501, FrameState::Lost(Lost::Silent)),
            (i64::MAX, FrameState::Lost(Lost::Silent)),
        ];
        for (now, state) in expected {
            assert_eq!(stamp.state_at(now, ages), Some(state), "{now}");
        }
        // What was drawn as old does not become young where a clock goes back, and what was asked for has no age.
        let drawn = |state: FrameState| FrameStamp {
            state: state.code(),
            ..stamp
        };
        assert_eq!(drawn(FrameState::Stale).state_at(1000, ages), Some(FrameState::Stale));
        assert_eq!(
            drawn(FrameState::Requested).state_at(9999, ages),
            Some(FrameState::Requested)
        );
        assert_eq!(drawn(FrameState::Look).state_at(9999, ages), Some(FrameState::Look));
        let lost = FrameStamp {
            state: Lost::NotSeen.code(),
            ..stamp
        };
        assert_eq!(lost.state_at(9999, ages), Some(FrameState::Lost(Lost::NotSeen)));
    }

    /// Behind a queue of 3 s a tool that was not seen, or whose poses were refused as too old, was a silent tracker.
    #[test]
    fn a_sample_without_a_pose_says_why_as_long_as_it_is_news() {
        let ages = Ages {
            stale_ns: 100,
            lost_ns: 500,
        };
        let sample = ToolPose {
            t_capture_ns: 1000,
            t_publish_ns: 4000,
            ..ToolPose::EMPTY
        };
        let lost = |now_ns| ages.of_sample(&sample, Tracked::Lost(Lost::Refused), now_ns);
        assert_eq!(lost(4100), FrameState::Lost(Lost::Refused));
        assert_eq!(lost(4101), FrameState::Lost(Lost::Silent));
        let valid = |now_ns| ages.of_sample(&sample, Tracked::Valid(Rigid::identity()), now_ns);
        assert_eq!((valid(1100), valid(1101)), (FrameState::Live, FrameState::Stale));
        assert_eq!(valid(4000), FrameState::Lost(Lost::Silent));
    }

    #[test]
    fn states_come_back() {
        for state in [
            FrameState::Live,
            FrameState::Stale,
            FrameState::Requested,
            FrameState::Look,
            FrameState::Lost(Lost::NotSeen),
            FrameState::Lost(Lost::Silent),
            FrameState::Lost(Lost::Refused),
        ] {
            assert_eq!(FrameState::from_code(state.code()), Some(state));
        }
        assert_eq!(FrameState::from_code(55), None);
    }
}
