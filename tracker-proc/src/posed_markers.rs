//! Where the markers of a scene are, frame by frame, where a localizer makes their poses itself.

use bus::message::{MarkerFrame, Sight};
use geometry::{Frame, Marker, Reference, Tool, Tracker, Uncertain};
use scene::tracking::MarkerSource;
use scene::{Scene, TrackerSource};

use crate::chain::Stamps;
use crate::follow::{calibration_of, posed_uncertain};
use crate::markers::{MarkersError, Seen};

/// The markers of a scene whose localizer makes their poses.
#[derive(Debug, Clone)]
pub struct PosedMarkers {
    spec: MarkerSource,
    marker_from_tool: Result<Uncertain<Marker, Tool>, String>,
    stamps: Stamps,
}

impl PosedMarkers {
    /// Those of a scene with `tracker.source = "markers"`; `None` for another one.
    ///
    /// # Errors
    /// [`MarkersError::NoNoise`]: what is made of poses is weighted by how sure they are.
    pub fn of(scene: &Scene) -> Result<Option<Self>, MarkersError> {
        let TrackerSource::Markers(spec) = &scene.tracker.source else {
            return Ok(None);
        };
        if spec
            .markers
            .noise
            .is_none_or(|noise| noise.shift_mm == 0.0 || noise.turn_rad == 0.0)
        {
            return Err(MarkersError::NoNoise);
        }
        let own = Ok(spec.markers.marker_from_tool.into());
        let file = scene.tracker.links.calibration.as_ref();
        Ok(Some(Self {
            spec: MarkerSource::clone(spec),
            marker_from_tool: file.map_or(own, |link| calibration_of(link, &scene.tool.name)),
            stamps: Stamps::default(),
        }))
    }

    /// Whether there is a marker on the patient.
    pub fn has_reference(&self) -> bool {
        self.spec.markers.reference.is_some()
    }

    /// The tool's calibration in use.
    ///
    /// # Errors
    /// Why the file that the scene names is not used, in words.
    pub fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String> {
        self.marker_from_tool.clone()
    }

    /// One frame, where it is `now_ns` on the run's clock. Frames pass once and in order, as they do in the tracker.
    ///
    /// # Errors
    /// Why there is no pose, in words.
    pub fn see(&mut self, frame: &MarkerFrame, now_ns: i64) -> Result<Seen, String> {
        self.stamps
            .admit(frame.t_capture_ns, frame.t_capture_ns, now_ns)
            .map_err(|error| error.to_string())?;
        let tool: Sight<Marker> = frame.sight(MarkerFrame::TOOL).map_err(|error| error.to_string())?;
        let marker = self.pose(tool).map_err(|why| format!("tool: {why}"))?;
        let reference = self.has_reference().then(|| {
            let sight: Sight<Reference> = frame.sight(MarkerFrame::REFERENCE).map_err(|error| error.to_string())?;
            self.pose(sight)
                .map_err(|why| format!("reference on the patient: {why}"))
        });
        Ok(Seen {
            marker,
            reference: reference.transpose()?,
        })
    }

    fn pose<F: Frame>(&self, sight: Sight<F>) -> Result<Uncertain<Tracker, F>, String> {
        let pose = sight.tracker_from_marker.map_err(|lost| lost.words().to_owned())?;
        let most = self.spec.max_error_mm;
        if let Some(most) = most.filter(|most| sight.error_mm > *most) {
            return Err(format!(
                "an error of fit of {} mm; at most {most} mm are allowed",
                sight.error_mm
            ));
        }
        posed_uncertain(pose, self.spec.markers.noise).ok_or_else(|| "its noise is no covariance".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use bus::message::{Lost, MarkerSight};
    use geometry::{Rigid, Vector};

    use super::*;

    fn scene(more: &str) -> Scene {
        let text = format!("[tracker]\nsource = \"markers\"\n[tracker.markers]\nreference = \"R\"\n{more}");
        Scene::parse(&text, Path::new("s.toml")).unwrap()
    }

    fn frame(t_capture_ns: i64, sights: &[MarkerSight]) -> MarkerFrame {
        let mut frame = MarkerFrame {
            t_capture_ns,
            ..MarkerFrame::EMPTY
        };
        frame.set(sights).unwrap();
        frame
    }

    #[test]
    fn poses_come_with_the_noise_that_the_scene_states_and_lost_ones_with_their_reason() {
        let noise = "noise_mm = 0.2\nnoise_deg = 0.1\nmax_error_mm = 0.5\n";
        let mut markers = PosedMarkers::of(&scene(noise)).unwrap().unwrap();
        let at: Rigid<Tracker, Marker> =
            Rigid::from_rotation_vector(Vector::new(0.1, 0.2, 0.3), Vector::new(10.0, 20.0, -1500.0)).unwrap();
        let patient = MarkerSight::seen(1, Rigid::<Tracker, Reference>::identity(), 0.1);
        let seen = markers
            .see(&frame(5, &[MarkerSight::seen(0, at, 0.3), patient]), 10)
            .unwrap();
        // What carries the noise there and back rounds: two units in the last place of 1500 mm.
        let off = seen
            .marker
            .transform()
            .translation_mm()
            .into_iter()
            .zip(at.translation_mm());
        assert!(off.into_iter().all(|(a, b)| (a - b).abs() < 5e-13));
        assert!((seen.marker.transform().inverse() * at).angle() < 1e-14);
        let origin = seen.marker * geometry::Point::<Marker>::new(0.0, 0.0, 0.0);
        // Three axes of 0.2 mm; at 1500 mm of lever, cancellation leaves 1e-9 of it.
        assert!((origin.covariance().trace() - 0.12).abs() < 1e-8);
        let said = |sights: &[MarkerSight], at_ns| markers.clone().see(&frame(at_ns, sights), 10).unwrap_err();
        assert_eq!(
            said(&[MarkerSight::lost(0, Lost::OutOfVolume, 0), patient], 6),
            "tool: outside the localizer's view"
        );
        assert_eq!(
            said(&[MarkerSight::seen(0, at, 0.3)], 6),
            "reference on the patient: marker not seen"
        );
        assert!(said(&[MarkerSight::seen(0, at, 0.6), patient], 6).contains("an error of fit of 0.6 mm"));
        assert!(said(&[MarkerSight::seen(0, at, 0.3), patient], 5).contains("came again"));
    }

    #[test]
    fn nothing_is_made_of_poses_of_which_nobody_says_how_sure_they_are() {
        for more in ["", "noise_mm = 0.2\n", "noise_mm = 0\nnoise_deg = 0.1\n"] {
            let error = PosedMarkers::of(&scene(more)).unwrap_err().to_string();
            assert!(error.contains("tracker.markers.noise_mm"), "{error}");
        }
        let other = Scene::parse("", Path::new("s.toml")).unwrap();
        assert!(PosedMarkers::of(&other).unwrap().is_none());
    }
}
