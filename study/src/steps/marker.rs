//! The marker of a tool, from frames of its emitters.

use std::fs;

use calib_cli::CalibrationFile;
use geometry::{Ct, Marker, Point, Rigid, Vector};
use tracker_proc::Markers;
use tracker_proc::operating_room::Frame;

use super::{MARKER, Refused, Step, Work};
use crate::Words;
use crate::room::{Held, TrueRoom, farther, parsed, tracker_text};

/// Where the marker is turned before the localizer, mm in the CT.
const TURNED_AT_MM: [f64; 3] = [0.0, -300.0, 100.0];

/// What a registration rests on, and what it is of.
pub(crate) struct Prepared {
    pub(crate) markers: Markers,
    /// The emitters as they were calibrated.
    pub(crate) emitters: Vec<Point<Marker>>,
}

impl Work<'_> {
    /// The marker of what is held, turned to all sides before the localizer: `marker.json`, of the probe `probe-marker.json`.
    pub(crate) fn marker(&self, room: &mut TrueRoom, (held, step): (Held, Step)) -> Result<Prepared, Refused> {
        let refused = Refused::at::<Words>(step);
        let [views, found] = match step {
            Step::Probe => ["probe-frames.csv", "probe-marker.json"],
            _ => ["frames.csv", "marker.json"],
        };
        let marker_from_tool = room.room.marker_from_tool;
        let count = self.stratum.dials.calibration.marker_frames;
        let poses = (0..count).map(|k| turned(k, count) * marker_from_tool);
        let frames = room.held(poses);
        fs::write(self.file(views), frames_text(&frames)).map_err(Refused::at(step))?;
        let localizer = self.stratum.dials.localizer;
        let (frames, out) = (self.named(views), self.named(found));
        // The deviations where the marker is turned: they grow with the distance, those in depth with its square.
        let times = farther(&localizer, TURNED_AT_MM);
        let [across, depth] =
            [localizer.across_mm * times, localizer.depth_mm * times * times].map(|mm| mm.to_string());
        let count = self.stratum.dials.marker.emitters.to_string();
        let words = [
            "marker",
            &frames,
            "--sigma-mm",
            &across,
            "--depth-sigma-mm",
            &depth,
            "--emitters",
            &count,
            "--tool",
            held.name,
            "--marker",
            MARKER,
            "--out",
            &out,
        ];
        self.calib(step, &words)?;
        let emitters = self.calibrated(found).map_err(&refused)?;
        let scene = parsed(&tracker_text(&self.stratum.dials, held, &emitters)).map_err(&refused)?;
        let markers = Markers::of(&scene).map_err(Refused::at(step))?;
        Ok(Prepared { markers, emitters })
    }

    /// The emitters of a calibrated marker.
    fn calibrated(&self, name: &str) -> Result<Vec<Point<Marker>>, Words> {
        let text = fs::read_to_string(self.file(name))?;
        let file: CalibrationFile = serde_json::from_str(&text)?;
        let body = file.marker_body.ok_or("there is no marker in its calibration")?;
        let place = |emitter: Option<calib_cli::EmitterRecord>| {
            let [x, y, z] = emitter.ok_or("an emitter was seen too seldom")?.at_mm;
            Ok(Point::new(x, y, z))
        };
        body.emitters.into_iter().map(place).collect()
    }
}

/// The marker's pose in the `k`-th of so many views, to all sides in small steps.
fn turned(k: u64, count: u64) -> Rigid<Ct, Marker> {
    let share = k as f64 / count as f64;
    let none = Vector::new(0.0, 0.0, 0.0);
    let about = |axis: [f64; 3]| {
        let [x, y, z] = axis;
        // Any vector of finite numbers is a rotation.
        Rigid::<Marker, Marker>::from_rotation_vector(Vector::new(x, y, z), none).unwrap_or(Rigid::identity())
    };
    let pi = std::f64::consts::PI;
    let turn = about([pi * share, 0.0, 0.0]) * about([0.0, 0.0, 12.0 * pi * share]);
    let [x, y, z] = TURNED_AT_MM;
    Rigid::from_parts(turn.rotation(), Vector::new(x, y, z))
}

/// Frames as `calib marker` reads them.
fn frames_text(frames: &[Frame]) -> String {
    let mut text = "frame,emitter,x,y,z\n".to_owned();
    for (number, frame) in frames.iter().enumerate() {
        for sighting in &frame.tool {
            let [x, y, z] = sighting.place.mm();
            text += &format!("{number},{},{x},{y},{z}\n", sighting.emitter);
        }
    }
    text
}
