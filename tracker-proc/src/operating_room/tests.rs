use std::path::Path;

use super::*;
use geometry::Vector;
use scene::{Scene, TrackerSource};

use crate::chain::{Chain, Found};
use chance::Chance;

mod accuracy;
mod arrivals;
mod faults;
mod links;
mod noise;
mod patient;
mod played;
mod seen;
mod shipped;

/// No noise, and nothing hidden but by the ball itself.
pub(super) const QUIET: &str = "across_mm = 0\ndepth_mm = 0";
pub(super) const NO_HANDLE: &str = "[tracker.room.handle]\nradius_mm = 0\n";

/// A scene with these lines of `[tracker.room.localizer]` and these other tables.
pub(super) fn scene(localizer: &str, tables: &str) -> Scene {
    let text = format!("[tracker]\nsource = \"operating-room\"\n[tracker.room.localizer]\n{localizer}\n{tables}");
    Scene::parse(&text, Path::new("s.toml")).unwrap()
}

pub(super) fn room(scene: &Scene) -> &Room {
    match &scene.tracker.source {
        TrackerSource::OperatingRoom(room) => room,
        other => panic!("{other:?}"),
    }
}

/// The room of a scene in which `script` is played.
pub(super) fn played(scene: &Scene, script: impl Into<Script>, seed: u64) -> OperatingRoom {
    let tracker = &scene.tracker;
    OperatingRoom::new(script, room(scene), &tracker.ct_from_tracker, seed, tracker.rate_hz).unwrap()
}

/// The room of a scene with its approach towards the CT's origin.
pub(super) fn approached(scene: &Scene, seed: u64) -> OperatingRoom {
    played(scene, Script::of_room(room(scene), &scene.targets, None).unwrap(), seed)
}

pub(super) fn middle() -> Point<Ct> {
    Point::new(0.0, 0.0, 0.0)
}

/// How far a found place of a point of the tool is from where it is, mm.
pub(super) fn error_mm(frame: &Frame, found: &Found, p: Point<Tool>) -> f64 {
    (found.ct_from_tool.transform() * p).distance(frame.ct_from_tool * p)
}

pub(super) fn tip() -> Point<Tool> {
    Point::new(0.0, 0.0, 0.0)
}

/// Any orientation, all alike, with the tip at the CT's origin.
pub(super) fn any_orientation(seed: u64) -> Rigid<Ct, Tool> {
    let chance = Chance::new(seed, 1 << 40);
    let q = [0, 1, 2, 3].map(|i| chance.normal(i));
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    geometry::checked::rigid(q.map(|x| x / norm), [0.0; 3], 1e-9).unwrap()
}

#[test]
fn the_same_seed_gives_the_same_frames_in_any_order() {
    let tables = "[tracker.room.hand]\nevery_s = 2\n[tracker.room.reference]\n[tracker.room.patient.breathing]";
    let scene = scene(
        "jitter_ms = 30\ndropped = 0.1\nlate = 0.1\nquantisation_mm = 0.01",
        tables,
    );
    let (a, b) = (approached(&scene, 7), approached(&scene, 7));
    let forwards: Vec<Frame> = (0..600).map(|seq| a.frame(seq)).collect();
    let backwards: Vec<Frame> = (0..600).rev().map(|seq| b.frame(seq)).collect();
    assert!(forwards.iter().eq(backwards.iter().rev()));
    let other = approached(&scene, 8);
    assert!((0..600).all(|seq| other.frame(seq).tool != a.frame(seq).tool || a.frame(seq).tool.is_empty()));
}

#[test]
fn markers_and_rates_that_cannot_be_are_refused_by_name() {
    let line = "emitters = [{ at_mm = [0, 0, 0] }, { at_mm = [50, 0, 0] }, { at_mm = [100, 0, 0] }]";
    for (table, name) in [("marker", "the tool's marker"), ("reference", "the patient's marker")] {
        let scene = scene("", &format!("[tracker.room.{table}]\n{line}"));
        let script = Played::held(any_orientation(1));
        let refused = OperatingRoom::new(script, room(&scene), &Rigid::identity(), 1, 60.0).unwrap_err();
        assert!(refused.to_string().contains(name), "{refused}");
    }
    let scene = scene("", "");
    for rate_hz in [0.0, -1.0, f64::NAN, 1e6] {
        let script = Played::held(any_orientation(1));
        let refused = OperatingRoom::new(script, room(&scene), &Rigid::identity(), 1, rate_hz).unwrap_err();
        assert!(matches!(refused, RoomError::Rate { .. }), "{refused}");
    }
}

#[test]
fn the_scenes_defaults_and_limits_are_those_of_the_chain() {
    use scene::operating_room;
    assert_eq!(operating_room::MAX_EMITTERS, calib::pose::MAX_EMITTERS);
    let chain = approached(&scene("", ""), 1).chain(middle()).unwrap();
    assert_eq!(chain.gates, calib::pose::Gates::default());
    assert_eq!(chain.reference_gates, calib::pose::Gates::default());
    // Normal draw n takes the uniform draws 2 n and 2 n + 1.
    let draws = 3 * calib::pose::MAX_EMITTERS as u64;
    assert!(TOOL_DRAWS + draws <= REFERENCE_DRAWS && 2 * (REFERENCE_DRAWS + draws) <= delivery::JITTER_DRAW);
}
