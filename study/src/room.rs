//! The operating room of one operation: what is truly there, and what the tracker's scene says of it.

use std::fmt::Write;
use std::path::Path;

use bus::message::Practice;
use calib::marker::even_directions;
use calib_cli::HeardPoses;
use chance::Chance;
use geometry::{Ct, Marker, Point, Reference, Rigid, Tool, Tracker, Uncertain, Vector};
use scene::operating_room::{Emitters, Room};
use scene::{Scene, TrackerSource};
use tracker_proc::Markers;
use tracker_proc::operating_room::{Frame, OperatingRoom, Script};

use crate::Words;
use crate::plan::{Dials, Localizer, Stratum};

/// From the order until the hand is there and has settled, s: it goes for 1.2 s.
const SETTLED_S: f64 = 1.4;
/// Places in the room, mm: as in `config/practice/base.toml`.
pub(crate) const DIVOT_MM: [f64; 3] = [260.0, -60.0, 0.0];
const BASE: &str =
    "quaternion = [0.7071067811865476, 0.7071067811865476, 0.0, 0.0], translation_mm = [280.0, -40.0, 60.0]";
/// The tube's length from the tip to the handle, mm.
pub(crate) const LENGTH_MM: f64 = 180.0;
/// The tool of an operation.
pub(crate) const TUBE: Held = Held {
    name: "mediastinoscope",
    length_mm: LENGTH_MM,
};
/// The ultrasound probe, from the middle of its face: its marker is 160 mm behind that, and 60 mm beside.
pub(crate) const PROBE: Held = Held {
    name: "probe",
    length_mm: 60.0,
};
/// Where the localizer stands, as a scene has it that says nothing of it: the first and the third number of the quaternion, and mm.
const STANDS_QUATERNION: [f64; 2] = [0.948_683_298_050_513_8, -0.316_227_766_016_837_94];
const STANDS_MM: [f64; 3] = [1380.0, 0.0, -1840.0];
/// Where the marker on the patient sits, as a scene has it that says nothing of it, and about what it is turned there: 2, 3 and 6 sevenths.
const REFERENCE_MM: [f64; 3] = [150.0, -120.0, -150.0];
const REFERENCE_AXIS: [f64; 3] = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
/// The diameter of a hand that comes between, mm.
const HAND_MM: f64 = 45.0;

/// A tool with a marker.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Held {
    pub(crate) name: &'static str,
    /// From the tip to the handle.
    length_mm: f64,
}

/// What is truly there.
pub(crate) struct TrueRoom {
    scene: Scene,
    pub(crate) room: Room,
    pub(crate) localizer: OperatingRoom,
    seed: u64,
    rate_hz: f64,
    /// Script time up to which frames were taken, s.
    now_s: f64,
}

impl Held {
    /// As a scene has it.
    fn text(self) -> String {
        let Self { name, length_mm } = self;
        format!("[tool]\nname = \"{name}\"\nlength_mm = {length_mm}\n")
    }
}

impl TrueRoom {
    /// The room of an operation of this seed, with this tool in it.
    pub(crate) fn new(stratum: &Stratum, held: Held, seed: u64) -> Result<Self, Words> {
        let dials = &stratum.dials;
        let scene = parsed(&truth_text(dials, held, seed))?;
        let TrackerSource::OperatingRoom(room) = &scene.tracker.source else {
            return Err("the study's own scene has no room".into());
        };
        let mut room = (**room).clone();
        made(&mut room.marker.emitters, dials.marker.made_mm, Chance::new(seed, 11));
        let localizer = operating(&scene, &room, seed, dials.localizer.rate_hz)?;
        Ok(Self {
            scene,
            room,
            localizer,
            seed,
            rate_hz: dials.localizer.rate_hz,
            now_s: dials.localizer.uptime_s,
        })
    }

    /// The same room with a localizer without noise, for the truth of each link.
    pub(crate) fn quiet(&self) -> Result<OperatingRoom, Words> {
        let mut room = self.room.clone();
        (room.sensor.across_mm, room.sensor.depth_mm) = (0.0, 0.0);
        operating(&self.scene, &room, self.seed, self.rate_hz)
    }

    /// The marker on the patient is moved on it, for good.
    pub(crate) fn bump(&mut self, motion: Rigid<Reference, Reference>) -> Result<(), Words> {
        if let Some(reference) = &mut self.room.reference {
            reference.ct_from_reference = reference.ct_from_reference * motion;
        }
        self.localizer = operating(&self.scene, &self.room, self.seed, self.rate_hz)?;
        Ok(())
    }

    /// Where the marker on the patient sits on it now.
    pub(crate) fn ct_from_reference(&self) -> Rigid<Ct, Reference> {
        let reference = self.room.reference.as_ref();
        reference.map_or(Rigid::identity(), |reference| reference.ct_from_reference)
    }

    /// The emitters of the tool's marker where they truly are.
    pub(crate) fn emitters(&self) -> Vec<Point<Marker>> {
        match &self.room.marker.emitters {
            Emitters::Listed(list) => list.iter().map(|emitter| emitter.place).collect(),
            Emitters::Ball { .. } => Vec::new(),
        }
    }

    /// The number of the first frame that was not taken yet.
    pub(crate) fn next_frame(&self) -> u64 {
        (self.now_s * self.rate_hz).ceil() as u64
    }

    /// Frames a second.
    pub(crate) fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// The hand does as it is told for so long once it is there; what the markers' poses were meanwhile, against the marker on the
    /// patient, which the tracker stands for.
    pub(crate) fn listen(
        &mut self,
        practice: &Practice,
        seconds: f64,
        markers: &mut Markers,
    ) -> Result<HeardPoses, Words> {
        self.localizer.order(practice, self.now_s)?;
        let from = ((self.now_s + SETTLED_S) * self.rate_hz).ceil() as u64;
        let until = ((self.now_s + SETTLED_S + seconds) * self.rate_hz).ceil() as u64;
        let mut heard = HeardPoses::default();
        for seq in from..until {
            hear(&self.localizer.frame(seq), markers, &mut heard);
        }
        self.now_s = until as f64 / self.rate_hz;
        Ok(heard)
    }

    /// Frames of a tool that is held so in each of them.
    pub(crate) fn held(&mut self, poses: impl Iterator<Item = Rigid<Ct, Tool>>) -> Vec<Frame> {
        let from = self.next_frame();
        let frames: Vec<Frame> = (from..)
            .zip(poses)
            .map(|(seq, pose)| self.localizer.frame_at(seq, pose))
            .collect();
        self.now_s += frames.len() as f64 / self.rate_hz;
        frames
    }

    /// Time goes by.
    pub(crate) fn wait(&mut self, seconds: f64) {
        self.now_s += seconds;
    }
}

/// The pose that the chain makes of one frame, against the marker on the patient; `None` where he has none.
///
/// # Errors
/// Why there is no pose, in words.
pub(crate) fn seen(frame: &Frame, markers: &mut Markers) -> Result<Option<Uncertain<Reference, Marker>>, String> {
    let message = frame.message(frame.t_capture_ns, frame.t_arrival_ns);
    let seen = markers.see(&message, frame.t_arrival_ns)?;
    Ok(seen.reference.map(|reference| reference.inverse() * seen.marker))
}

fn hear(frame: &Frame, markers: &mut Markers, heard: &mut HeardPoses) {
    match seen(frame, markers).map(|pose| pose.and_then(stand_in)) {
        Ok(Some(pose)) => {
            heard.poses.push(pose);
            heard.times_s.push(frame.t_capture_ns as f64 / 1e9);
        }
        Ok(None) => heard.lost += 1,
        Err(why) => {
            heard.lost += 1;
            heard.why = why;
        }
    }
}

/// The same pose with the tracker's name on its frame: what calibrations take poses in.
fn stand_in(pose: Uncertain<Reference, Marker>) -> Option<Uncertain<Tracker, Marker>> {
    let [x, y, z] = pose.transform().translation_mm();
    let rigid = Rigid::from_parts(pose.transform().rotation(), Vector::new(x, y, z));
    Uncertain::from_upper(rigid, pose.upper()).ok()
}

fn operating(scene: &Scene, room: &Room, seed: u64, rate_hz: f64) -> Result<OperatingRoom, Words> {
    let script = Script::of_room(room, &scene.targets, None).map_err(|error| error.to_string())?;
    let script = script.practised(room, seed);
    let made = OperatingRoom::new(script, room, &scene.tracker.ct_from_tracker, seed, rate_hz);
    Ok(made.map_err(|error| error.to_string())?)
}

pub(crate) fn parsed(text: &str) -> Result<Scene, Words> {
    Ok(Scene::parse(text, Path::new("the study's own scene")).map_err(|error| error.to_string())?)
}

/// Moves emitters off where they were to be put.
fn made(emitters: &mut Emitters<Marker>, made_mm: f64, chance: Chance) {
    let Emitters::Listed(list) = emitters else { return };
    for (number, emitter) in (0_u64..).zip(list) {
        let [x, y, z] = [0, 1, 2].map(|k| made_mm * chance.normal(3 * number + k));
        emitter.place = emitter.place + Vector::new(x, y, z);
    }
}

/// The scene of what is truly there, emitters where they were to be put.
fn truth_text(dials: &Dials, held: Held, seed: u64) -> String {
    let (marker, localizer, touch) = (dials.marker, dials.localizer, dials.touch);
    let [x, y, z] = DIVOT_MM;
    // What a seed of a scene may be is bounded by TOML's integers.
    let mut text = format!(
        "seed = {}\n{}[tracker]\nsource = \"operating-room\"\nrate_hz = {}\n\
         {}[tracker.room.marker]\ncone_deg = {}\nemitters = [{}]\n{}ct_from_reference = {}\n\
         [tracker.room.localizer]\nacross_mm = {}\ndepth_mm = {}\n\
         [tracker.room.practice]\ndivot_ct_mm = [{x}, {y}, {z}]\nct_from_base = {{ {BASE} }}\ntouch_error_mm = {}\ntremor_mm = {}\n",
        seed >> 1,
        held.text(),
        localizer.rate_hz,
        standing(&localizer),
        marker.cone_deg,
        ball(dials),
        reference_text("tracker.room", dials),
        pose(REFERENCE_AXIS, dials.reference_deg, REFERENCE_MM),
        localizer.across_mm,
        localizer.depth_mm,
        touch.error_mm,
        touch.tremor_mm,
    );
    if let Some([share, every_s]) = dials.occlusion {
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "[tracker.room.hand]\nradius_mm = {HAND_MM}\nevery_s = {every_s}\nfor_s = {}",
            share * every_s
        );
    }
    text
}

/// Where the localizer stands, as a scene says it of the axes that its places are told in; nothing of the usual place.
fn standing(localizer: &Localizer) -> String {
    let Localizer {
        turned_deg,
        moved_mm: [x, y, z],
        ..
    } = localizer;
    if *turned_deg == 0.0 && [x, y, z].iter().all(|mm| **mm == 0.0) {
        return String::new();
    }
    let (sin, cos) = (0.5 * turned_deg.to_radians()).sin_cos();
    // Its quaternion is (w, 0, v, 0), before which a turn about z comes.
    let [w, v] = STANDS_QUATERNION;
    let [a, b, c] = stands_mm(*turned_deg, STANDS_MM);
    format!(
        "ct_from_tracker = {{ quaternion = [{:?}, {:?}, {:?}, {:?}], translation_mm = [{:?}, {:?}, {:?}] }}\n",
        cos * w,
        -sin * v,
        cos * v,
        sin * w,
        a + x,
        b + y,
        c + z
    )
}

/// A place, turned about the patient's long axis.
fn stands_mm(deg: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = deg.to_radians().sin_cos();
    [x * cos - y * sin, x * sin + y * cos, z]
}

/// How many times farther than usual the localizer is from a place of the CT, mm.
pub(crate) fn farther(localizer: &Localizer, place: [f64; 3]) -> f64 {
    let [x, y, z] = stands_mm(localizer.turned_deg, STANDS_MM);
    let [a, b, c] = localizer.moved_mm;
    let point = |[x, y, z]: [f64; 3]| Point::<Ct>::new(x, y, z);
    let at = |stands: [f64; 3]| point(stands).distance(point(place));
    at([x + a, y + b, z + c]) / at(STANDS_MM)
}

/// A pose as a scene has it, of a turn about an axis of length 1.
fn pose(axis: [f64; 3], deg: f64, [x, y, z]: [f64; 3]) -> String {
    let (sin, cos) = (0.5 * deg.to_radians()).sin_cos();
    let [a, b, c] = axis.map(|part| sin * part);
    format!("{{ quaternion = [{cos:?}, {a:?}, {b:?}, {c:?}], translation_mm = [{x:?}, {y:?}, {z:?}] }}")
}

/// The marker on the patient, as it was drawn.
pub(crate) fn reference_text(table: &str, dials: &Dials) -> String {
    let marker = dials.marker;
    let body = match marker.width < 1.0 {
        true => format!("emitters = [{}]", ball(dials)),
        false => format!(
            "ball = {{ emitters = {}, radius_mm = {:?} }}",
            marker.emitters, marker.radius_mm
        ),
    };
    format!("[{table}.reference]\n{body}\ncone_deg = {:?}\n", marker.cone_deg)
}

/// The emitters of a ball, one by one.
fn ball(dials: &Dials) -> String {
    let one = |out: geometry::Direction<Marker>| {
        let [x, y, z] = out.components();
        let r = dials.marker.radius_mm;
        // Along its axis it is as long as the ball; emitters look where those of the ball do.
        let across = r * dials.marker.width;
        format!(
            "{{ at_mm = [{:?}, {:?}, {:?}], normal = [{x:?}, {y:?}, {z:?}] }}",
            x * across,
            y * across,
            z * r
        )
    };
    let list: Vec<String> = even_directions(dials.marker.emitters).into_iter().map(one).collect();
    list.join(", ")
}

/// What the tracker's scene says before calibration and registration: the emitters as they were calibrated.
pub(crate) fn tracker_text(dials: &Dials, held: Held, emitters: &[Point<Marker>]) -> String {
    let one = |place: &Point<Marker>| {
        let [x, y, z] = place.mm();
        format!("{{ at_mm = [{x:?}, {y:?}, {z:?}] }}")
    };
    let list: Vec<String> = emitters.iter().map(one).collect();
    format!(
        "{}[tracker]\nsource = \"emitters\"\n\
         [tracker.emitters.marker]\nemitters = [{}]\n{}\
         [tracker.emitters.localizer]\nacross_mm = {:?}\ndepth_mm = {:?}\n",
        held.text(),
        list.join(", "),
        reference_text("tracker.emitters", dials),
        dials.localizer.across_mm,
        dials.localizer.depth_mm,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;

    /// The quaternion that is written, by matrices: a turn about the long axis before the usual place's.
    #[test]
    fn a_localizer_that_is_turned_and_moved_stands_where_it_is_said_to_stand() {
        for (deg, moved) in [
            (0.0, [0.0, 0.0, 1.0]),
            (179.9999999, [0.0; 3]),
            (-90.0, [1e4, -20.0, 3.0]),
            (300.0, [0.0; 3]),
        ] {
            let text =
                format!("[[stratum]]\nname = \"a\"\nlocalizer = {{ turned_deg = {deg:?}, moved_mm = {moved:?} }}");
            let plan = Plan::of_texts([(Path::new("a.toml"), text.as_str())]).unwrap();
            let scene = parsed(&truth_text(&plan.strata[0].dials, TUBE, 4)).unwrap();
            let usual = parsed("[tracker]\nsource = \"operating-room\"\n[tracker.room]\n").unwrap();
            let none = Vector::new(0.0, 0.0, 0.0);
            let turn =
                Rigid::<Ct, Ct>::from_rotation_vector(Vector::new(0.0, 0.0, f64::to_radians(deg)), none).unwrap();
            let [x, y, z] = moved;
            for p in [Point::new(0.0, 0.0, 0.0), Point::new(30.0, -20.0, 2300.0)] {
                let expected = turn * (usual.tracker.ct_from_tracker * p) + Vector::new(x, y, z);
                let found = scene.tracker.ct_from_tracker * p;
                // Places of 1e4 mm to rounding, and quaternions that are normed to it: 1e-12 mm times ten.
                assert!(
                    found.distance(expected) < 1e-10,
                    "{deg} {moved:?}: {found:?} {expected:?}"
                );
            }
            let eye = scene.tracker.ct_from_tracker * Point::new(0.0, 0.0, 0.0);
            let there = usual.tracker.ct_from_tracker * Point::new(0.0, 0.0, 0.0);
            let place = Point::new(0.0, -300.0, 100.0);
            let times = farther(&plan.strata[0].dials.localizer, [0.0, -300.0, 100.0]);
            assert!(
                (times - eye.distance(place) / there.distance(place)).abs() < 1e-12,
                "{times}"
            );
        }
    }
}
