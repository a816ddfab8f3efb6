//! The frames of markers of a run as they come, and what its localizer says.

use bus::Bus;
use bus::message::{Event, Lost, MarkerFrame, Sight};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{EVENT, MARKERS};
use geometry::{Marker, Reference, Rigid, Tracker};

use super::{Pilot, World, wait_for};

/// The frames of a run.
pub struct Watch {
    frames: Subscriber<MarkerFrame>,
    events: Subscriber<Event>,
    pub bus: Bus,
}

impl Watch {
    pub fn open(world: &World) -> Self {
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        let bus = Bus::join(&context).unwrap();
        Self {
            frames: Subscriber::open(&bus, &MARKERS, "", MARKERS.buffer).unwrap(),
            events: Subscriber::open(&bus, &EVENT, "localizer", EVENT.buffer).unwrap(),
            bus,
        }
    }

    /// Waits for so many frames, one after the other, of which `wanted` holds.
    pub fn wait(&self, what: &str, count: usize, wanted: impl Fn(&MarkerFrame) -> bool) -> Vec<MarkerFrame> {
        let mut found = Vec::new();
        wait_for(what, || {
            for frame in self.come() {
                match wanted(&frame) {
                    true => found.push(frame),
                    false => found.clear(),
                }
            }
            (found.len() >= count).then_some(())
        });
        found
    }

    /// What has come since.
    pub fn come(&self) -> Vec<MarkerFrame> {
        std::iter::from_fn(|| self.frames.next().unwrap()).collect()
    }

    /// What the localizer has told since.
    pub fn told(&self) -> Vec<String> {
        let events = std::iter::from_fn(|| self.events.next().unwrap());
        events.map(|event| event.words()).collect()
    }
}

pub fn tool(frame: &MarkerFrame) -> Result<Rigid<Tracker, Marker>, Lost> {
    let sight: Sight<Marker> = frame.sight(MarkerFrame::TOOL).unwrap();
    sight.tracker_from_marker
}

pub fn patient(frame: &MarkerFrame) -> Result<Rigid<Tracker, Reference>, Lost> {
    let sight: Sight<Reference> = frame.sight(MarkerFrame::REFERENCE).unwrap();
    sight.tracker_from_marker
}

pub fn is_seen(frame: &MarkerFrame) -> bool {
    tool(frame).is_ok()
}

pub fn is_disconnected(frame: &MarkerFrame) -> bool {
    tool(frame) == Err(Lost::Disconnected)
}

pub fn is_connected(frame: &MarkerFrame) -> bool {
    !is_disconnected(frame)
}

/// What `pilot status` says of the localizer.
pub fn note(status: &serde_json::Value) -> String {
    let processes = status["processes"].as_array().unwrap();
    let localizer = processes.iter().find(|p| p["name"] == "localizer");
    let note = localizer.and_then(|p| p["note"].as_str());
    note.unwrap_or_default().to_owned()
}

/// Waits until `pilot status` says these words of the localizer.
pub fn status_says(pilot: &Pilot<'_>, words: &str) {
    pilot.wait_for(words, |status| note(status).contains(words));
}
