use std::path::Path;

use super::super::Room;
use crate::{Scene, SceneError, TrackerSource};

fn parsed(tables: &str) -> Result<Room, SceneError> {
    let text = format!("[tracker]\nsource = \"operating-room\"\n{tables}");
    match Scene::parse(&text, Path::new("folder/s.toml"))?.tracker.source {
        TrackerSource::OperatingRoom(room) => Ok(*room),
        other => panic!("{other:?}"),
    }
}

const TANK: &str = "[tracker.room.reference]\n[tracker.room.probe.tank]\nfile = \"wires.xml\"\n";

#[test]
fn a_tank_is_read_with_its_file_beside_the_scene() {
    let more = "water_celsius = 20\nerror_mm = 0.3\nbottom = { point_mm = [0, 0, -20], normal = [0, 0, 2] }";
    let room = parsed(&format!("{TANK}{more}")).unwrap();
    let tank = room.tank.unwrap();
    assert_eq!(tank.file, Path::new("folder/wires.xml"));
    assert_eq!(
        (tank.water_celsius, tank.error.shift_mm, tank.error.turn_rad),
        (Some(20.0), 0.3, 0.0)
    );
    let bottom = tank.bottom.unwrap();
    assert_eq!(
        (bottom.point.mm(), bottom.normal.components()),
        ([0.0, 0.0, -20.0], [0.0, 0.0, 1.0])
    );
    assert!(parsed("[tracker.room.probe]").unwrap().tank.is_none());
}

#[test]
fn what_a_tank_cannot_be_is_refused_by_name() {
    let refused = [
        (
            TANK.replace("wires.xml", ""),
            "key tracker.room.probe.tank.file",
            "the path of a device set",
        ),
        (
            TANK.replace("[tracker.room.reference]", ""),
            "key tracker.room.probe.tank",
            "no [tracker.room.reference]",
        ),
        (
            format!("{TANK}[tracker.room.patient.breathing]"),
            "key tracker.room.probe.tank",
            "a tank stands still",
        ),
        (
            format!("{TANK}[tracker.room.patient.bump]"),
            "key tracker.room.probe.tank",
            "a tank stands still",
        ),
        (
            format!("{TANK}[tracker.room.patient]\ndrift_mm_per_min = [0, 0, 1]"),
            "key tracker.room.probe.tank",
            "a tank stands still",
        ),
        (
            format!("{TANK}[tracker.room.practice]"),
            "key tracker.room.probe",
            "one of the two",
        ),
        // Water of a temperature has a speed of its own: beside another one it would count twice.
        (
            format!("{TANK}water_celsius = 20\n[tracker.room.probe]\nspeed_percent = 1.5"),
            "key tracker.room.probe.speed_percent",
            "would count twice",
        ),
        (
            format!("{TANK}water_celsius = 96"),
            "key tracker.room.probe.tank.water_celsius",
            "0 to 95 degrees Celsius",
        ),
        (
            format!("{TANK}error_mm = 11"),
            "key tracker.room.probe.tank.error_mm",
            "0 to 10 mm",
        ),
        (
            format!("{TANK}error_deg = -1"),
            "key tracker.room.probe.tank.error_deg",
            "0 to 10 degrees",
        ),
        (
            format!("{TANK}bottom = {{ point_mm = [0, 0, 0], normal = [0, 0, 0] }}"),
            "key tracker.room.probe.tank.bottom.normal",
            "not all 0",
        ),
        (format!("{TANK}water_c = 20"), "water_c", "unknown field"),
    ];
    for (tables, named, words) in refused {
        let error = parsed(&tables).unwrap_err().to_string();
        assert!(error.contains(named) && error.contains(words), "{tables}: {error}");
    }
}

#[test]
fn a_written_tank_reads_back() {
    let text = format!(
        "[tracker]\nsource = \"operating-room\"\n{}water_celsius = 21.5\nerror_deg = 0.5\nbottom = {{ point_mm = [0, 0, -20], normal = [0, 0, 2] }}",
        TANK.replace("wires.xml", "/wires.xml")
    );
    let source = crate::raw::parse(&text, Path::new("s.toml")).unwrap();
    let again = crate::raw::parse(&source.to_toml(), Path::new("s.toml")).unwrap();
    assert_eq!(source.scene, again.scene);
    assert_eq!(Scene::from_raw(&source).unwrap(), Scene::from_raw(&again).unwrap());
}
