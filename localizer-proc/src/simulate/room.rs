//! What a simulated device sees: handed in by the binary, as this crate does not know the simulated operating room.

use std::path::Path;

use bus::message::Lost;

/// Opens the simulated operating room of the scene at a path.
pub type OpenRoom = fn(&Path) -> Result<Box<dyn Room>, Box<dyn std::error::Error + Send + Sync>>;

/// What the binary hands in.
#[derive(Debug, Clone, Copy)]
pub struct Hands {
    /// What the device measures.
    pub room: OpenRoom,
}

/// A room in which a localizer measures frame after frame. Times are ns since the room was opened (script time).
pub trait Room {
    /// Places of the emitters of the tool's marker, and of the patient's if there is one, each in its own frame, mm.
    fn emitters_mm(&self) -> (Vec<[f64; 3]>, Option<Vec<[f64; 3]>>);

    /// The number of the newest frame that is measured after `after_ns` and until `until_ns`.
    fn newest(&mut self, after_ns: i64, until_ns: i64) -> Option<u64>;

    /// A frame by its number; always the same.
    fn frame(&self, number: u64) -> RoomFrame;
}

/// What is seen at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct RoomFrame {
    /// Its number, from 0.
    pub number: u64,
    /// When, ns of the device's own clock.
    pub device_ns: i64,
    /// The marker on the surgeon's tool.
    pub tool: RoomMarker,
    /// That on the patient, where the scene has one.
    pub patient: Option<RoomMarker>,
}

/// One marker at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct RoomMarker {
    /// Where it is, with the noise of the room's sensor, or why that is not known.
    pub pose: Result<RoomPose, Lost>,
    /// The emitters that are seen by number, each with its place in the localizer's frame, mm.
    pub emitters_mm: Vec<(usize, [f64; 3])>,
}

/// `tracker_from_marker`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoomPose {
    /// Unit quaternion, w x y z.
    pub q: [f64; 4],
    /// mm.
    pub t_mm: [f64; 3],
    /// Root mean square distance of its emitters from the marker, mm.
    pub error_mm: f64,
}
