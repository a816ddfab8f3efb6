//! Calibrations and registrations for the simulated operating room, as `calib` writes them.

use std::path::Path;

use bus::Bus;
use bus::port::VolumeSubscriber;
use calib_cli::{CalibrationFile, Kind, ToolRecord};
use geometry::{Point, Rigid, Tracker, Vector};

use super::{World, stderr, wait_for};

/// Where a room's marker sits on the tool unless the scene says otherwise.
pub const MARKER_FROM_TOOL_MM: [f64; 3] = [0.0, -60.0, 280.0];
/// And where its localizer stands.
pub const CT_FROM_TRACKER: ([f64; 4], [f64; 3]) = (
    [0.948_683_298_050_513_8, 0.0, -0.316_227_766_016_837_94, 0.0],
    [1380.0, 0.0, -1840.0],
);

/// A calibrated tool of this name at this place in its marker, with a deviation of 0.1 mm at the tip.
pub fn tool_json(tool: &str, marker: &str, translation_mm: [f64; 3]) -> String {
    let mut covariance_upper = [0.0; 21];
    let turn = 1e-8;
    // The errors turn about the tip, the covariance about the marker's origin: v = v_tip - w x tip.
    let [x, y, z] = translation_mm;
    let lever = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let mut full = [[0.0; 6]; 6];
    for i in 0..3 {
        full[i][i] = turn;
        for j in 0..3 {
            full[i][3 + j] = -turn * lever[i][j];
            let square: f64 = (0..3).map(|k| lever[k][i] * lever[k][j]).sum();
            full[3 + i][3 + j] = turn * square + if i == j { 0.01 } else { 0.0 };
        }
    }
    let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
    for (into, (i, j)) in covariance_upper.iter_mut().zip(places) {
        *into = full[i][j];
    }
    let file = CalibrationFile {
        trocar_calibration: 1,
        kind: Kind::Tool,
        id: String::new(),
        date_utc: "2026-01-01T00:00:00Z".to_owned(),
        program: "a test".to_owned(),
        tool: tool.to_owned(),
        marker: marker.to_owned(),
        verdict: "accepted".to_owned(),
        gates: Vec::new(),
        recorded: None,
        computed_from: Vec::new(),
        pivot: None,
        spin: None,
        imported: None,
        seat: None,
        marker_body: None,
        base: None,
        tool_frame: Some(ToolRecord {
            quaternion_wxyz: [1.0, 0.0, 0.0, 0.0],
            translation_mm,
            covariance_upper,
            roll_by: "x".to_owned(),
            tip_off_axis_mm: 0.0,
        }),
    };
    file.sealed().unwrap().to_json().unwrap()
}

/// Registers the room's patient with `calib register` from six points that are off by 0.2 mm, into `out`.
pub fn register(world: &World, from: &str, ct_hash: &str, out: &Path) {
    let (q, t) = CT_FROM_TRACKER;
    let ct_from_tracker: Rigid<geometry::Ct, Tracker> = geometry::checked::rigid(q, t, 1e-9).unwrap();
    let mut csv = "from_x,from_y,from_z,to_x,to_y,to_z\n".to_owned();
    for (i, at) in [
        [90.0, 0.0, 0.0],
        [-90.0, 10.0, 30.0],
        [0.0, 80.0, -40.0],
        [10.0, -80.0, 60.0],
        [40.0, 30.0, 120.0],
        [-30.0, -20.0, -110.0],
    ]
    .into_iter()
    .enumerate()
    {
        let off = Vector::new(0.2, 0.0, 0.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let [x, y, z] = at;
        let seen = (ct_from_tracker.inverse() * (Point::new(x, y, z) + off)).mm();
        csv += &format!("{},{},{},{x},{y},{z}\n", seen[0], seen[1], seen[2]);
    }
    let pairs = world.file("pairs.csv", &csv);
    let arguments = [
        "register",
        "--pairs",
        pairs.to_str().unwrap(),
        "--to",
        "ct",
        "--from",
        from,
    ];
    let more = [
        "--noise-mm",
        "0.2",
        "--ct-hash",
        ct_hash,
        "--overwrite",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = world.output("calib", &[&arguments[..], &more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
}

/// The hash of the run's volume.
pub fn volume_hash(bus: &Bus) -> String {
    let volumes = VolumeSubscriber::open(bus).unwrap();
    wait_for("the volume", || volumes.poll().unwrap()).hash().to_string()
}
