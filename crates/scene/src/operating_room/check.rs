//! From the raw room to the checked one.

mod tank;

use std::ops::RangeInclusive;
use std::path::PathBuf;

use geometry::{Ct, Direction, Frame, Point, Rigid, Vector, checked};

use super::super::raw::RawRigid;
use super::super::values::{Checked, UNIT_TOLERANCE, invalid, number, point};
use super::raw::{
    RawBall, RawBreathing, RawBump, RawEmitter, RawFaults, RawGates, RawHand, RawHandle, RawLocalizer, RawMarker,
    RawPatient, RawPractice, RawProbe, RawReference, RawRoom,
};
use super::{
    Approach, Array, Breathing, Bump, Deviations, Emitters, Faults, Gates, Hand, Handle, ListedEmitter, MAX_EMITTERS,
    MAX_EYES, Patient, PlayedGesture, PracticeRoom, Probe, ReferenceMarker, Room, Sensor, Shape, Timing,
};

/// Script times that a scene may name, s: a day.
const SCRIPT_S: RangeInclusive<f64> = 0.0..=86_400.0;
/// Coordinates and moves that a scene may name, mm.
const MAX_MM: f64 = 100_000.0;
/// The default marker's centre: this far behind the handle's beginning,
const MARKER_BEHIND_MM: f64 = 100.0;
/// and this far from the tube's axis, so that handle and hand leave it free.
const MARKER_ASIDE_MM: f64 = 60.0;
/// The default width of a linear array, mm.
const LINEAR_MM: f64 = 50.0;
/// The default angle of a curved array, degrees.
const CONVEX_DEG: f64 = 60.0;
/// Sides of a simulated ultrasound image, pixels.
const LEAST_PIXELS: f64 = 24.0;
const MOST_PIXELS: f64 = 1024.0;
/// The default handle's length.
const HANDLE_MM: f64 = 80.0;

/// Where the localizer stands unless the scene says otherwise: 2.3 m from the CT's origin towards the feet and the left,
/// looking at it, its +y the patient's back. A scene that says nothing cannot be told from one that says the identity, in
/// which no localizer can stand: inside the patient.
pub(in super::super) fn place_of_localizer(written: &RawRigid) -> RawRigid {
    if *written != RawRigid::default() {
        return written.clone();
    }
    // A turn about +y by -atan(3/4): the +z of the localizer is (-0.6, 0, 0.8).
    let tenth = 0.1_f64.sqrt();
    RawRigid {
        quaternion: [3.0 * tenth, 0.0, -tenth, 0.0],
        translation_mm: [1380.0, 0.0, -1840.0],
    }
}

pub(in super::super) fn room(raw: &RawRoom, approach: Approach, tool_mm: f64) -> Checked<Room> {
    let marker = marker("marker", &raw.marker)?;
    Ok(Room {
        marker_from_tool: marker_from_tool("marker", &raw.marker, tool_mm)?,
        handle: handle(&raw.handle, tool_mm)?,
        hand: raw.hand.as_ref().map(hand).transpose()?,
        sensor: sensor(&raw.localizer)?,
        timing: timing(&raw.localizer)?,
        patient: patient(&raw.patient)?,
        reference: raw
            .reference
            .as_ref()
            .map(|on| reference("reference", on))
            .transpose()?,
        faults: faults(&raw.faults, marker.emitters.count())?,
        gates: gates("gates", &raw.gates)?,
        reference_gates: gates("reference_gates", &raw.reference_gates)?,
        calibration_error: deviations("calibration", raw.calibration_error_mm, raw.calibration_error_deg)?,
        registration_error: deviations("registration", raw.registration_error_mm, raw.registration_error_deg)?,
        approach,
        played: raw.gesture.as_ref().map(played).transpose()?,
        practice: raw.practice.as_ref().map(practice).transpose()?,
        probe: raw
            .probe
            .as_ref()
            .map(|of| probe(of, raw.practice.is_some()))
            .transpose()?,
        tank: tank::tank(raw)?,
        marker,
    })
}

/// The whole key of a name in `[tracker.room]`. The tables of other sources that share a check give theirs whole.
fn key(name: &str) -> String {
    match name.starts_with("tracker.") {
        true => name.to_owned(),
        false => format!("tracker.room.{name}"),
    }
}

fn within(name: &str, value: f64, range: RangeInclusive<f64>, unit: &str) -> Checked<f64> {
    number(&key(name), value, range, unit)
}

fn degrees(name: &str, value: f64, range: RangeInclusive<f64>) -> Checked<f64> {
    within(name, value, range, "degrees").map(f64::to_radians)
}

fn vector<F>(name: &str, [x, y, z]: [f64; 3], limit: f64, unit: &str) -> Checked<Vector<F>> {
    for value in [x, y, z] {
        within(name, value, -limit..=limit, unit)?;
    }
    Ok(Vector::new(x, y, z))
}

fn direction<F: Frame>(name: &str, components: [f64; 3]) -> Checked<Direction<F>> {
    let none = |_| invalid(key(name), format!("{components:?}"), "three finite numbers, not all 0");
    checked::direction(components).map_err(none)
}

fn rigid<To: Frame, From: Frame>(name: &str, raw: &RawRigid) -> Checked<Rigid<To, From>> {
    vector::<To>(&format!("{name}.translation_mm"), raw.translation_mm, MAX_MM, "mm")?;
    checked::rigid(raw.quaternion, raw.translation_mm, UNIT_TOLERANCE).map_err(|e| {
        invalid(
            key(&format!("{name}.quaternion")),
            format!("{:?}", raw.quaternion),
            e.to_string(),
        )
    })
}

pub(in super::super) fn marker<F: Frame>(table: &str, raw: &RawMarker) -> Checked<Shape<F>> {
    shape(table, raw.ball, raw.emitters.as_deref(), raw.cone_deg)
}

pub(in super::super) fn reference(table: &str, raw: &RawReference) -> Checked<ReferenceMarker> {
    Ok(ReferenceMarker {
        shape: shape(table, raw.ball, raw.emitters.as_deref(), raw.cone_deg)?,
        ct_from_reference: rigid(&format!("{table}.ct_from_reference"), &raw.ct_from_reference)?,
    })
}

fn shape<F: Frame>(
    table: &str,
    ball: Option<RawBall>,
    listed: Option<&[RawEmitter]>,
    cone_deg: f64,
) -> Checked<Shape<F>> {
    let emitters = match (ball, listed) {
        (Some(_), Some(_)) => return Err(invalid(key(table), "ball and emitters", "one of the two")),
        (ball, None) => self::ball(table, ball.unwrap_or_default())?,
        (None, Some(list)) => self::listed(table, list)?,
    };
    Ok(Shape {
        emitters,
        cone_rad: degrees(&format!("{table}.cone_deg"), cone_deg, 1.0..=180.0)?,
    })
}

fn ball<F: Frame>(table: &str, raw: RawBall) -> Checked<Emitters<F>> {
    let count = raw.emitters as usize;
    if !(3..=MAX_EMITTERS).contains(&count) {
        let allowed = format!("3 to {MAX_EMITTERS}");
        return Err(invalid(key(&format!("{table}.ball.emitters")), count, allowed));
    }
    let radius_mm = within(&format!("{table}.ball.radius_mm"), raw.radius_mm, 1.0..=1000.0, "mm")?;
    Ok(Emitters::Ball { count, radius_mm })
}

fn listed<F: Frame>(table: &str, list: &[RawEmitter]) -> Checked<Emitters<F>> {
    let name = |index: usize, field: &str| format!("{table}.emitters.{index}.{field}");
    if !(3..=MAX_EMITTERS).contains(&list.len()) {
        let allowed = format!("3 to {MAX_EMITTERS} emitters");
        return Err(invalid(key(&format!("{table}.emitters")), list.len(), allowed));
    }
    let one = |(index, raw): (usize, &RawEmitter)| {
        vector::<F>(&name(index, "at_mm"), raw.at_mm, 1000.0, "mm")?;
        let normal = raw.normal.map(|n| direction(&name(index, "normal"), n)).transpose()?;
        let place: Point<F> = point(&key(&name(index, "at_mm")), raw.at_mm)?;
        Ok(ListedEmitter { place, normal })
    };
    Ok(Emitters::Listed(
        list.iter().enumerate().map(one).collect::<Checked<_>>()?,
    ))
}

pub(in super::super) fn marker_from_tool<To: Frame, From: Frame>(
    table: &str,
    raw: &RawMarker,
    tool_mm: f64,
) -> Checked<Rigid<To, From>> {
    let beside_the_handle = || RawRigid {
        translation_mm: [0.0, -MARKER_ASIDE_MM, tool_mm + MARKER_BEHIND_MM],
        ..RawRigid::default()
    };
    let written = raw.marker_from_tool.clone().unwrap_or_else(beside_the_handle);
    rigid(&format!("{table}.marker_from_tool"), &written)
}

fn handle(raw: &RawHandle, tool_mm: f64) -> Checked<Handle> {
    let from_mm = within("handle.from_mm", raw.from_mm.unwrap_or(tool_mm), 0.0..=2000.0, "mm")?;
    let to_mm = raw.to_mm.unwrap_or(from_mm + HANDLE_MM);
    Ok(Handle {
        from_mm,
        to_mm: within("handle.to_mm", to_mm, from_mm..=3000.0, "mm (its beginning or more)")?,
        radius_mm: within("handle.radius_mm", raw.radius_mm, 0.0..=200.0, "mm")?,
    })
}

fn hand(raw: &RawHand) -> Checked<Hand> {
    let every_s = within("hand.every_s", raw.every_s, 0.1..=3600.0, "s")?;
    Ok(Hand {
        radius_mm: within("hand.radius_mm", raw.radius_mm, 0.0..=200.0, "mm")?,
        every_s,
        for_s: within("hand.for_s", raw.for_s, 0.0..=every_s, "s (at most every_s)")?,
    })
}

fn sensor(raw: &RawLocalizer) -> Checked<Sensor> {
    let at = |name: &str| format!("localizer.{name}");
    let nearest_mm = within(&at("nearest_mm"), raw.nearest_mm, 0.0..=MAX_MM, "mm")?;
    if !(1..=MAX_EYES).contains(&raw.eyes_mm.len()) {
        let allowed = format!("1 to {MAX_EYES} eyes");
        return Err(invalid(key(&at("eyes_mm")), raw.eyes_mm.len(), allowed));
    }
    let eye = |(index, mm): (usize, &[f64; 3])| {
        let name = at(&format!("eyes_mm.{index}"));
        vector::<geometry::Tracker>(&name, *mm, 5000.0, "mm")?;
        point(&key(&name), *mm)
    };
    Ok(Sensor {
        across_mm: within(&at("across_mm"), raw.across_mm, 0.0..=50.0, "mm")?,
        depth_mm: within(&at("depth_mm"), raw.depth_mm, 0.0..=50.0, "mm")?,
        at_mm: within(&at("at_mm"), raw.at_mm, 1.0..=MAX_MM, "mm")?,
        growth_across: within(&at("growth_across"), raw.growth_across, 0.0..=4.0, "")?,
        growth_depth: within(&at("growth_depth"), raw.growth_depth, 0.0..=4.0, "")?,
        quantisation_mm: within(&at("quantisation_mm"), raw.quantisation_mm, 0.0..=10.0, "mm")?,
        eyes: raw.eyes_mm.iter().enumerate().map(eye).collect::<Checked<_>>()?,
        view_rad: degrees(&at("view_deg"), raw.view_deg, 1.0..=180.0)?,
        nearest_mm,
        farthest_mm: within(
            &at("farthest_mm"),
            raw.farthest_mm,
            nearest_mm..=MAX_MM,
            "mm (nearest_mm or more)",
        )?,
    })
}

fn timing(raw: &RawLocalizer) -> Checked<Timing> {
    let at = |name: &str| format!("localizer.{name}");
    let milliseconds = |name: &str, value: f64, most: f64| Ok(within(&at(name), value, 0.0..=most, "ms")? / 1e3);
    Ok(Timing {
        latency_s: milliseconds("latency_ms", raw.latency_ms, 1000.0)?,
        jitter_s: milliseconds("jitter_ms", raw.jitter_ms, 1000.0)?,
        dropped: within(&at("dropped"), raw.dropped, 0.0..=1.0, "")?,
        late: within(&at("late"), raw.late, 0.0..=1.0, "")?,
        late_s: milliseconds("late_ms", raw.late_ms, 2000.0)?,
        drift_ppm: within(&at("drift_ppm"), raw.drift_ppm, -100_000.0..=100_000.0, "ppm")?,
        offset_s: within(&at("offset_s"), raw.offset_s, -1e6..=1e6, "s")?,
    })
}

fn patient(raw: &RawPatient) -> Checked<Patient> {
    let drift = vector("patient.drift_mm_per_min", raw.drift_mm_per_min, 1000.0, "mm/min")?;
    Ok(Patient {
        breathing: raw.breathing.as_ref().map(breathing).transpose()?,
        bump: raw.bump.as_ref().map(bump).transpose()?,
        drift_mm_per_s: drift * (1.0 / 60.0),
    })
}

fn breathing(raw: &RawBreathing) -> Checked<Breathing> {
    let at = |name: &str| format!("patient.breathing.{name}");
    Ok(Breathing {
        amplitude_mm: within(&at("amplitude_mm"), raw.amplitude_mm, 0.0..=100.0, "mm")?,
        direction: direction(&at("direction"), raw.direction)?,
        period_s: within(&at("period_s"), raw.period_s, 0.5..=60.0, "s")?,
    })
}

fn bump(raw: &RawBump) -> Checked<Bump> {
    let at = |name: &str| format!("patient.bump.{name}");
    let turn = vector(&at("rotation_deg"), raw.rotation_deg, 180.0, "degrees")?;
    Ok(Bump {
        at_s: within(&at("at_s"), raw.at_s, SCRIPT_S, "s")?,
        over_s: within(&at("over_s"), raw.over_s, 0.0..=60.0, "s")?,
        translation: vector(&at("translation_mm"), raw.translation_mm, 1000.0, "mm")?,
        rotation: turn * 1.0_f64.to_radians(),
    })
}

fn practice(raw: &RawPractice) -> Checked<PracticeRoom> {
    let at = |name: &str| format!("practice.{name}");
    let RawRigid {
        quaternion,
        translation_mm,
    } = raw.ct_from_base.clone();
    let rigid = checked::rigid(quaternion, translation_mm, UNIT_TOLERANCE).map_err(|error| {
        let found = format!("{quaternion:?}, {translation_mm:?}");
        invalid(key(&at("ct_from_base")), found, error.to_string())
    })?;
    let divot: Vector<Ct> = vector(&at("divot_ct_mm"), raw.divot_ct_mm, MAX_MM, "mm")?;
    Ok(PracticeRoom {
        divot: Point::new(0.0, 0.0, 0.0) + divot,
        ct_from_base: rigid,
        touch_error_mm: within(&at("touch_error_mm"), raw.touch_error_mm, 0.0..=50.0, "mm")?,
        tremor_mm: within(&at("tremor_mm"), raw.tremor_mm, 0.0..=50.0, "mm")?,
    })
}

fn probe(raw: &RawProbe, has_practice: bool) -> Checked<Probe> {
    let at = |name: &str| format!("probe.{name}");
    if has_practice {
        let found = "there, and [tracker.room.practice] as well";
        return Err(invalid(
            key("probe"),
            found,
            "one of the two: the hand that practises holds a pointer",
        ));
    }
    let array = match (raw.width_mm, raw.radius_mm) {
        (Some(width), Some(_)) => {
            let allowed = "width_mm of a linear array or radius_mm of a curved one, and not both";
            return Err(invalid(key(&at("width_mm")), width, allowed));
        }
        (width, None) => {
            if let Some(angle) = raw.angle_deg {
                return Err(invalid(key(&at("angle_deg")), angle, "none without radius_mm"));
            }
            Array::Linear {
                width_mm: within(&at("width_mm"), width.unwrap_or(LINEAR_MM), 5.0..=200.0, "mm")?,
            }
        }
        (None, Some(radius)) => Array::Convex {
            radius_mm: within(&at("radius_mm"), radius, 5.0..=200.0, "mm")?,
            half_angle_rad: degrees(&at("angle_deg"), raw.angle_deg.unwrap_or(CONVEX_DEG), 2.0..=150.0)? / 2.0,
        },
    };
    let probe = Probe {
        array,
        depth_mm: within(&at("depth_mm"), raw.depth_mm, 5.0..=300.0, "mm")?,
        pixel_mm: within(&at("pixel_mm"), raw.pixel_mm, 0.05..=1.0, "mm")?,
        rate_hz: within(&at("rate_hz"), raw.rate_hz, 0.1..=60.0, "images a second")?,
        lag_s: within(&at("lag_ms"), raw.lag_ms, 0.0..=1000.0, "ms")? / 1000.0,
        speed_ratio: 1.0 + within(&at("speed_percent"), raw.speed_percent, -10.0..=10.0, "percent")? / 100.0,
    };
    let [columns, rows] = probe.extent_mm().map(|side| side / probe.pixel_mm);
    match columns.max(rows) <= MOST_PIXELS && columns.min(rows) >= LEAST_PIXELS {
        true => Ok(probe),
        false => Err(invalid(
            key(&at("pixel_mm")),
            format!("{} mm: images of {columns:.0} x {rows:.0} pixels", probe.pixel_mm),
            format!("{LEAST_PIXELS} to {MOST_PIXELS} pixels a side"),
        )),
    }
}

fn faults(raw: &RawFaults, emitters: usize) -> Checked<Faults> {
    let one = |name: &str, index: u32| {
        if index as usize >= emitters {
            let allowed = format!("0 to {}: the marker has {emitters} emitters", emitters - 1);
            return Err(invalid(key(&format!("faults.{name}")), index, allowed));
        }
        Ok(index as usize)
    };
    let swapped = match raw.swapped {
        Some([a, b]) if a == b => return Err(invalid(key("faults.swapped"), format!("{a} twice"), "two emitters")),
        Some([a, b]) => Some([one("swapped", a)?, one("swapped", b)?]),
        None => None,
    };
    let dead = raw.dead.iter().map(|&index| one("dead", index));
    Ok(Faults {
        dead: dead.collect::<Checked<_>>()?,
        swapped,
        from_s: within("faults.from_s", raw.from_s, SCRIPT_S, "s")?,
    })
}

pub(in super::super) fn gates(table: &str, raw: &RawGates) -> Checked<Gates> {
    let at = |name: &str| format!("{table}.{name}");
    let min_emitters = raw.min_emitters as usize;
    if !(3..=MAX_EMITTERS).contains(&min_emitters) {
        let allowed = format!("3 to {MAX_EMITTERS}");
        return Err(invalid(key(&at("min_emitters")), min_emitters, allowed));
    }
    Ok(Gates {
        min_emitters,
        max_fre_mm: within(&at("max_fre_mm"), raw.max_fre_mm, 0.001..=1000.0, "mm")?,
        outlier_sigmas: within(&at("outlier_sigmas"), raw.outlier_sigmas, 1.0..=1000.0, "deviations")?,
        max_tip_mm: within(&at("max_tip_mm"), raw.max_tip_mm, 0.001..=1000.0, "mm")?,
    })
}

fn deviations(link: &str, shift_mm: f64, turn_deg: f64) -> Checked<Deviations> {
    Ok(Deviations {
        shift_mm: within(&format!("{link}_error_mm"), shift_mm, 0.0..=50.0, "mm")?,
        turn_rad: degrees(&format!("{link}_error_deg"), turn_deg, 0.0..=10.0)?,
    })
}

fn played(raw: &super::raw::RawGesture) -> Checked<PlayedGesture> {
    if raw.file.is_empty() {
        return Err(invalid(key("gesture.file"), "\"\"", "the path of a CSV file"));
    }
    Ok(PlayedGesture {
        file: PathBuf::from(&raw.file),
        at_end: raw.at_end,
    })
}
