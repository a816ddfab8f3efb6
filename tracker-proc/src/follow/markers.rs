//! Poses of markers that a localizer's process publishes, or the replayer of a recording.
//!
//! All markers of a frame are of one instant (the door of the message refuses others), so that tool and reference of different
//! instants are never combined.

use bus::message::{Lost, MarkerFrame, MarkersError, Sight};
use bus::port::Subscriber;
use bus::process::Process;
use bus::topic::MARKERS;
use calib::pose::Lost as BodyLost;
use geometry::{Frame, Marker, Point, Reference, Tracker, Uncertain};
use scene::tracking::MarkerSource;

use super::listening::{self, DEPTH, Taker};
use super::{Follower, Stamp, examination, posed, refuse};
use crate::chain::{Found, Links, Reason};
use crate::errors::errors_about;
use crate::output::Output;
use crate::run_error::RunError;

/// Publishes a pose for each frame until asked to stop.
///
/// # Errors
/// [`RunError`].
pub(crate) fn follow(process: &mut Process, output: &Output, spec: &MarkerSource) -> Result<(), RunError> {
    // Here, so that it is refused before the run begins.
    if let Some(noise) = spec.markers.noise {
        errors_about(Point::<Tracker>::new(0.0, 0.0, 0.0), noise).map_err(RunError::Noise)?;
    }
    let frames = Subscriber::<MarkerFrame>::open_waking(&process.bus, &MARKERS, "", DEPTH)?;
    let Some(examination) = examination(process)? else {
        return Ok(());
    };
    let source = posed::source(&spec.markers, process.scene.tracker.ct_from_tracker);
    let follower = Follower::new(process, output, source, examination);
    listening::listen(process, &frames, follower, &mut Taking(spec))
}

/// Makes poses of frames of markers.
struct Taking<'a>(&'a MarkerSource);

impl Taker for Taking<'_> {
    type Frame = MarkerFrame;

    fn stamp(&self, frame: &MarkerFrame) -> Result<Stamp, (u64, String)> {
        frame.sights().map_err(|error| (frame.seq, error.to_string()))?;
        let tool: Sight<Marker> = frame.sight(MarkerFrame::TOOL).unwrap_or(Sight::NONE);
        Ok(Stamp {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            // The localizer's own stamps may stand still while frames come; its process has made of them what can be believed.
            t_order_ns: frame.t_capture_ns,
            visible: u32::from(tool.tracker_from_marker.is_ok()),
        })
    }

    fn take(
        &mut self,
        frame: &MarkerFrame,
        stamp: &Stamp,
        follower: &mut Follower<'_>,
        process: &mut Process,
    ) -> Result<(), RunError> {
        let measured = |marker| {
            let sights = frame.sights().unwrap_or_default();
            let seen = sights.iter().find(|sight| sight.marker == marker && sight.status == 0);
            seen.into_iter().flat_map(|sight| sight.q.into_iter().chain(sight.t_mm))
        };
        let places = [measured(MarkerFrame::TOOL), measured(MarkerFrame::REFERENCE)];
        let (tool, reference) = (frame.sight(MarkerFrame::TOOL), frame.sight(MarkerFrame::REFERENCE));
        let unused = self.0.markers.reference.is_none();
        for error in [tool.as_ref().err(), reference.as_ref().err().filter(|_| !unused)]
            .into_iter()
            .flatten()
        {
            refuse(process, frame.seq, &error.to_string());
        }
        follower.frame(stamp, places, process, |links| self.solve(tool, reference, links))
    }
}

impl Taking<'_> {
    fn solve(
        &self,
        tool: Result<Sight<Marker>, MarkersError>,
        reference: Result<Sight<Reference>, MarkersError>,
        links: &Links,
    ) -> Result<Found, Reason> {
        let refused = |_| Reason::Stated(Lost::Refused);
        let tool = tool.map_err(refused)?;
        let marker = self.uncertain(&tool).map_err(Reason::Stated)?;
        let reference = |_| {
            let lost = |_| Reason::Reference(BodyLost::NotSeen);
            self.uncertain(&reference.map_err(refused)?).map_err(lost)
        };
        Ok(Found {
            fre_rms_mm: tool.error_mm,
            ..Found::of(links.ct_from_tool(marker, reference)?)
        })
    }

    /// The pose with its noise, where it fits as well as the scene asks for.
    fn uncertain<F: Frame>(&self, sight: &Sight<F>) -> Result<Uncertain<Tracker, F>, Lost> {
        let pose = sight.tracker_from_marker?;
        if self.0.max_error_mm.is_some_and(|most| sight.error_mm > most) {
            return Err(Lost::Residual);
        }
        posed::uncertain(pose, self.0.markers.noise).ok_or(Lost::Refused)
    }
}
