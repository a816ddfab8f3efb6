use scene::operating_room::{Array, Probe};
use scene::{Scene, TrackerSource};

use super::super::SimulatedProbe;
use super::*;

/// Two wires along the phantom's y, and where they stand in the marker.
const FILE: &str = r#"<PlusConfiguration><CoordinateDefinitions>
    <Transform From="Phantom" To="Reference" Matrix="1 0 0 -20  0 1 0 30  0 0 1 10  0 0 0 1"/>
    </CoordinateDefinitions><PhantomDefinition><Geometry><Pattern>
    <Wire Name="a" EndPointFront="0 0 0" EndPointBack="0 40 0"/>
    <Wire Name="b" EndPointFront="30 0 5" EndPointBack="30 40 5"/>
    </Pattern></Geometry></PhantomDefinition></PlusConfiguration>"#;

fn room(more: &str) -> (Room, Spec) {
    let text = format!(
        "[tracker]\nsource = \"operating-room\"\n[tracker.room.reference]\n[tracker.room.reference.ct_from_reference]\n\
         translation_mm = [100, 0, 0]\n[tracker.room.probe.tank]\nfile = \"wires.xml\"\n{more}"
    );
    let scene = Scene::parse(&text, Path::new("s.toml")).unwrap();
    let TrackerSource::OperatingRoom(room) = scene.tracker.source else {
        panic!("another source");
    };
    let tank = room.tank.clone().unwrap();
    (*room, tank)
}

fn tank(file: &str, more: &str, seed: u64) -> Result<Tank, String> {
    let (room, spec) = room(more);
    Tank::parse(file.as_bytes(), &spec, &room, seed).map_err(|error| error.to_string())
}

#[test]
fn wires_stand_where_the_file_and_the_marker_say_and_elsewhere_by_what_is_planted() {
    let exact = tank(FILE, "bottom = { point_mm = [0, 0, 60], normal = [0, 0, -1] }", 1).unwrap();
    assert_eq!(exact.wires[1].ends, [[110.0, 30.0, 15.0], [110.0, 70.0, 15.0]]);
    assert_eq!(
        (exact.walls[0].point, exact.walls[0].normal),
        ([80.0, 30.0, 70.0], [0.0, 0.0, -1.0])
    );
    assert_eq!(exact.speed_ratio(), None);
    // 200 seeds of 0.5 mm along and 1 degree about each axis: the middle is off by the shift alone.
    let (mut square_mm, mut square_rad) = (0.0, 0.0);
    for seed in 0..200 {
        let planted = tank(FILE, "error_mm = 0.5\nerror_deg = 1", seed).unwrap();
        let off = planted.ct_from_phantom() * exact.ct_from_phantom().inverse();
        let middle = exact.ct_from_phantom() * Point::<Phantom>::new(15.0, 20.0, 2.5);
        square_mm += (off * middle).distance(middle).powi(2) / 600.0;
        square_rad += off.angle().powi(2) / 600.0;
    }
    // Sums of 600 squares: their relative deviation is sqrt(2 / 600), here four of them.
    let near = |square: f64, size: f64| (square / (size * size) - 1.0).abs() < 4.0 * (2.0_f64 / 600.0).sqrt();
    assert!(
        near(square_mm, 0.5) && near(square_rad, 1.0_f64.to_radians()),
        "{square_mm} {square_rad}"
    );
}

#[test]
fn a_file_without_wires_or_without_a_place_is_refused_by_name() {
    let refused = |from: &str, to: &str| tank(&FILE.replace(from, to), "", 1).unwrap_err();
    for (from, to, words) in [
        (
            "Wire Name",
            "Thread Name",
            "wires.xml: 0 wires in its PhantomDefinition",
        ),
        ("From=\"Phantom\"", "From=\"Stylus\"", "wires.xml: "),
        ("1 0 0 -20", "2 0 0 -20", "wires.xml: "),
        ("30 40 5", "30 0.5 5", "the wire b is shorter than 1 mm"),
        ("1 0 0 -20", "1 0 0 1e8", "the wire a is more than 100 m"),
        ("</PlusConfiguration>", "", "wires.xml: "),
    ] {
        let error = refused(from, to);
        assert!(error.contains("wires.xml") && error.contains(words), "{from}: {error}");
    }
    let (room, spec) = room("");
    let missing = Tank::load(&spec, &room, 1).unwrap_err().to_string();
    assert!(missing.starts_with("reading the phantom wires.xml: "), "{missing}");
    let bare = Room {
        reference: None,
        ..room
    };
    let error = Tank::parse(FILE.as_bytes(), &spec, &bare, 1).unwrap_err().to_string();
    assert!(error.contains("no reference"), "{error}");
}

/// A wire 30 mm below the face is shown there by the speed of tissue, and 30 * 1540 / 1482.3 mm deep in water of 20 degrees: once, not twice.
#[test]
fn a_wire_in_water_is_shown_too_deep_by_the_speed_of_sound_once() {
    for (more, ratio) in [("", 1.0), ("water_celsius = 20", 1482.343 / 1540.0)] {
        let (room, spec) = room(more);
        let tank = Tank::parse(FILE.as_bytes(), &spec, &room, 1).unwrap();
        let of = Probe {
            array: Array::Linear { width_mm: 40.0 },
            pixel_mm: 0.1,
            ..room.probe.unwrap()
        };
        let mut probe = SimulatedProbe::in_tank(of, &tank, 1).unwrap();
        // The face 30 mm before the middle of wire a, which runs across the image.
        let held = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), Vector::new(80.0, 50.0, -20.0)).unwrap();
        let grey = probe.image_in_tank(&tank, held, 0).unwrap();
        let shape = *probe.shape();
        let (mut sum, mut weight) = (0.0, 0.0);
        for (at, level) in grey.iter().enumerate() {
            let [u, v] = [at % shape.columns(), at / shape.columns()].map(|part| part as f64 * 0.1);
            // About the middle beam, and below the face's own ringing.
            if (u - 20.0).abs() < 1.0 && v > 5.0 && *level > 128 {
                (sum, weight) = (sum + v * f64::from(*level), weight + f64::from(*level));
            }
        }
        let shown = sum / weight;
        // A pixel's side.
        assert!((shown - 30.0 / ratio).abs() < 0.1, "{more}: {shown}");
    }
}
