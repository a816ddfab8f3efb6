//! The check of a tank.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use geometry::{Phantom, Point, Vector};

use super::super::Deviations;
use super::super::raw::RawRoom;
use super::super::tank::{Bottom, RawBottom, Tank};
use super::{Checked, MAX_MM, degrees, direction, invalid, key, vector, within};

/// Temperatures for which the speed of sound in water is known, degrees Celsius.
const CELSIUS: RangeInclusive<f64> = 0.0..=95.0;

/// The tank of a room, where it has one.
pub(super) fn tank(raw: &RawRoom) -> Checked<Option<Tank>> {
    let Some((probe, tank)) = raw.probe.as_ref().and_then(|probe| Some((probe, probe.tank.as_ref()?))) else {
        return Ok(None);
    };
    beside(raw)?;
    let at = |name: &str| format!("probe.tank.{name}");
    // Nothing, relative to the scene file, is its folder.
    if tank.file.is_empty() || tank.file.ends_with('/') {
        let allowed = "the path of a device set of PLUS (.xml) with the phantom's wires";
        return Err(invalid(key(&at("file")), format!("{:?}", tank.file), allowed));
    }
    if tank.water_celsius.is_some() && probe.speed_percent != 0.0 {
        let allowed = "0 beside tank.water_celsius: water of that temperature has its own speed of sound, which would count twice";
        return Err(invalid(key("probe.speed_percent"), probe.speed_percent, allowed));
    }
    let celsius = |celsius| within(&at("water_celsius"), celsius, CELSIUS, "degrees Celsius");
    let bottom = |raw: &RawBottom| {
        let point: Vector<Phantom> = vector(&at("bottom.point_mm"), raw.point_mm, MAX_MM, "mm")?;
        Ok(Bottom {
            point: Point::new(0.0, 0.0, 0.0) + point,
            normal: direction(&at("bottom.normal"), raw.normal)?,
        })
    };
    Ok(Some(Tank {
        file: PathBuf::from(&tank.file),
        water_celsius: tank.water_celsius.map(celsius).transpose()?,
        error: Deviations {
            shift_mm: within(&at("error_mm"), tank.error_mm, 0.0..=10.0, "mm")?,
            turn_rad: degrees(&at("error_deg"), tank.error_deg, 0.0..=10.0)?,
        },
        bottom: tank.bottom.as_ref().map(bottom).transpose()?,
    }))
}

/// Refuses a tank in a room where it cannot stand.
fn beside(raw: &RawRoom) -> Checked<()> {
    let patient = &raw.patient;
    let moves = patient.breathing.is_some() || patient.bump.is_some() || patient.drift_mm_per_min != [0.0; 3];
    let (found, allowed) = if raw.reference.is_none() {
        let allowed = "a [tracker.room.reference]: where the phantom stands is told in the marker at the tank";
        ("there, and no [tracker.room.reference]", allowed)
    } else if moves {
        let allowed = "neither breathing nor a bump nor a drift: a tank stands still";
        ("there, and [tracker.room.patient] moves", allowed)
    } else {
        return Ok(());
    };
    Err(invalid(key("probe.tank"), found, allowed))
}
