//! The recording of PLUS (fCal 2.0, three N patterns), its own segmented points, and its published answer.

use std::path::PathBuf;

use calib::file::sequence;
use geometry::rotation::RotationMatrix;
use geometry::{Phantom, Point, Probe, Reference, Rigid, Uncertain, Vector};
use nalgebra::{Matrix6, Vector6};
use probe::{Mark, Options, PointNoise, PoseNoise, Priors, Seen, Track, Wire, Wires, calibrate, cross_validate};
use serde_json::Value;

type Pose = Rigid<Reference, Probe>;

/// Ends of the wires in the device set of the recording, mm.
const WIRES: [(&str, [f64; 3], [f64; 3]); 9] = [
    ("7:G1_g1", [30.0, 0.0, 20.0], [30.0, 40.0, 20.0]),
    ("8:L1_h1", [55.0, 0.0, 20.0], [35.0, 40.0, 20.0]),
    ("9:M1_m1", [60.0, 0.0, 20.0], [60.0, 40.0, 20.0]),
    ("4:G3_g3", [30.0, 0.0, 10.0], [30.0, 40.0, 10.0]),
    ("5:H3_l3", [35.0, 0.0, 10.0], [55.0, 40.0, 10.0]),
    ("6:M3_m3", [60.0, 0.0, 10.0], [60.0, 40.0, 10.0]),
    ("1:H5_h5", [35.0, 0.0, 0.0], [35.0, 40.0, 0.0]),
    ("2:L5_i5", [55.0, 0.0, 0.0], [40.0, 40.0, 0.0]),
    ("3:M5_m5", [60.0, 0.0, 0.0], [60.0, 40.0, 0.0]),
];
/// Its place in the reference.
const PHANTOM: ([[f64; 3]; 3], [f64; 3]) = (
    [
        [-0.0167397, -0.0153548, -0.999742],
        [-0.999834, 0.0075107, 0.0166258],
        [0.00725347, 0.999854, -0.015478],
    ],
    [15.6642, -25.3628, -40.7799],
);

struct Recording {
    frames: Vec<Seen>,
    timed: Vec<(f64, Pose)>,
    wires: Wires,
    phantom: Rigid<Reference, Phantom>,
    /// PLUS's own image to probe, by rows.
    plus: Vec<f64>,
}

fn recording() -> Option<Recording> {
    let folder = std::env::var_os("TROCAR_SHARED")
        .map(PathBuf::from)?
        .join("data/plus-ultrasound");
    let bytes = std::fs::read(folder.join("fCal_Test_Calibration_3NWires_fCal2.0.igs.mha")).ok()?;
    let header = std::str::from_utf8(&bytes[..sequence::header_end(&bytes).unwrap()]).unwrap();
    let (poses, _) = sequence::chained(header, "ProbeToReference").unwrap();
    let read = |name: &str| -> Value { serde_json::from_slice(&std::fs::read(folder.join(name)).unwrap()).unwrap() };
    let points = read("nwire_points_calibration.json");
    let number = |value: &Value| value.as_f64().unwrap();
    let (mut frames, mut timed) = (Vec::new(), Vec::new());
    for frame in poses {
        let (Some(pose), Some(t)) = (frame.poses[0], frame.t_s) else {
            continue;
        };
        let pose: Pose = pose.rigid().unwrap();
        timed.push((t, pose));
        let Some(marks) = points["frames"][frame.number.to_string()].as_array() else {
            continue;
        };
        let mark = |m: &Value| Mark {
            wire: WIRES.iter().position(|w| w.0 == m["wire"].as_str().unwrap()).unwrap(),
            px: [number(&m["px"][0]), number(&m["px"][1])],
        };
        frames.push(Seen {
            number: frame.number,
            t_s: Some(t),
            reference_from_probe: pose,
            marks: marks.iter().map(mark).collect(),
        });
    }
    let point = |p: [f64; 3]| Point::new(p[0], p[1], p[2]);
    let wire = |w: &(&str, [f64; 3], [f64; 3])| Wire {
        name: w.0.to_owned(),
        front: point(w.1),
        back: point(w.2),
    };
    let turn = RotationMatrix::nearest(PHANTOM.0).unwrap().matrix.rotation();
    let [x, y, z] = PHANTOM.1;
    let plus = read("nwire_answer.json")["image_to_probe_plus"]
        .as_array()
        .unwrap()
        .clone();
    Some(Recording {
        frames,
        timed,
        wires: Wires::new(WIRES.iter().map(wire).collect()).unwrap(),
        phantom: Rigid::from_parts(turn, Vector::new(x, y, z)),
        plus: plus.iter().map(number).collect(),
    })
}

/// Half a degree and 0.3 mm: the deviations of section 5 of the notes, about the middle of the wires.
fn loose(phantom: Rigid<Reference, Phantom>) -> Uncertain<Reference, Phantom> {
    let (turn, shift) = (0.5_f64.to_radians().powi(2), 0.09);
    let about = phantom * Point::new(45.0, 20.0, 10.0);
    let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
    Uncertain::from_covariance_about(about, phantom, covariance).unwrap()
}

fn options(lag_s: f64, tracker: f64, play_mm: f64) -> Options {
    Options {
        point: PointNoise {
            lateral_mm: 0.15,
            axial_mm: 0.15,
            elevation_mm: 0.3,
        },
        pose: PoseNoise {
            turn_rad: 0.002,
            shift_mm: 0.15,
        },
        priors: Priors {
            pixel_mm: None,
            lag_s,
            tracker,
            play_mm,
        },
        ..Options::default()
    }
}

/// What each candidate for an error of the model is worth: kept only where frames that took no part say so. Every
/// second frame is
/// judged by the others, then the second half by the first, both ways: mean distance to the wires, mm. PLUS's own
/// matrix has 0.428 on
/// frames that it was fitted to.
#[test]
fn frames_that_took_no_part_say_what_belongs_in_the_model() {
    let Some(r) = recording() else {
        println!("SKIPPED: TROCAR_SHARED names no folder with data/plus-ultrasound");
        return;
    };
    let exact = Uncertain::from(r.phantom);
    let half = r.frames.len() / 2;
    for (name, window, phantom, o, most) in [
        ("8 numbers", 0.0, exact, options(0.0, 0.0, 0.0), [0.37, 0.57]),
        ("mean of 0.1 s", 0.1, exact, options(0.0, 0.0, 0.0), [0.335, 0.55]),
        ("mean, lag", 0.1, exact, options(0.1, 0.0, 0.0), [0.325, 0.61]),
        (
            "mean, lag, play 0.1 mm",
            0.1,
            exact,
            options(0.1, 0.0, 0.1),
            [0.23, 0.47],
        ),
        (
            "mean, lag, tracker 3 %",
            0.1,
            exact,
            options(0.1, 0.03, 0.0),
            [0.18, 0.245],
        ),
        (
            "mean, lag, tracker, play",
            0.1,
            exact,
            options(0.1, 0.03, 0.1),
            [0.135, 0.21],
        ),
        ("phantom", 0.0, loose(r.phantom), options(0.0, 0.0, 0.0), [0.25, 0.32]),
        (
            "mean, lag, phantom",
            0.1,
            loose(r.phantom),
            options(0.1, 0.0, 0.0),
            [0.2, 0.3],
        ),
    ] {
        let track = Track::new(&r.timed, window).unwrap();
        let all = calibrate(&r.frames, &r.wires, &phantom, Some(&track), &o).unwrap();
        let judged = |is_first: &dyn Fn(usize) -> bool| {
            let found = cross_validate(&r.frames, &r.wires, &phantom, Some(&track), &o, is_first).unwrap();
            f64::max(found.mean_mm[0], found.mean_mm[1])
        };
        let (every, halves) = (judged(&|i| i % 2 == 0), judged(&|i| i < half));
        let lag = all
            .lag
            .map_or(String::new(), |l| format!(", lag {:.3} +- {:.3} s", l.lag_s, l.sigma_s));
        println!(
            "{name}: own {:.3}, every second {every:.3}, halves {halves:.3} mm; noise {:.2}, frames {:.1}{lag}; {}",
            all.mean_mm,
            all.noise_ratio,
            all.frame_correlation,
            all.free()[0]
        );
        assert!(all.is_settled && all.share_kept > 0.99, "{name}");
        assert!(every < most[0] && halves < most[1], "{name}: {every} {halves}");
    }
}

/// The image lies where PLUS has it, within what both are off: the tracker's linear error alone, not the phantom's 6
/// numbers, leaves it
/// there.
#[test]
fn the_image_lies_where_plus_has_it() {
    let Some(r) = recording() else {
        println!("SKIPPED: TROCAR_SHARED names no folder with data/plus-ultrasound");
        return;
    };
    let track = Track::new(&r.timed, 0.1).unwrap();
    let apart = |phantom: &Uncertain<Reference, Phantom>, o: &Options| {
        let found = calibrate(&r.frames, &r.wires, phantom, Some(&track), o).unwrap();
        let m = &r.plus;
        let one = |px: [f64; 2]| {
            let plus = [0, 1, 2].map(|i| m[4 * i] * px[0] + m[4 * i + 1] * px[1] + m[4 * i + 3]);
            found.place(px).point().distance(Point::new(plus[0], plus[1], plus[2]))
        };
        (
            f64::max(one([200.0, 180.0]), one([600.0, 460.0])),
            found.worst_mm(),
            found.pixel_mm,
        )
    };
    let (lag, worst, _) = apart(&Uncertain::from(r.phantom), &options(0.1, 0.0, 0.0));
    let (tracker, _, pixel) = apart(&Uncertain::from(r.phantom), &options(0.1, 0.03, 0.0));
    let (phantom, ..) = apart(&loose(r.phantom), &options(0.1, 0.0, 0.0));
    println!(
        "from PLUS: lag {lag:.2} mm (predicted {worst:.2}), tracker {tracker:.2}, phantom {phantom:.2}; pixels {pixel:?}"
    );
    // PLUS states 0.479 mm of its own points, so that 0.7 mm are what two such calibrations differ by.
    assert!(lag < 0.7 && tracker < 0.7, "{lag} {tracker}");
    assert!(phantom > 2.0 * tracker, "{phantom} {tracker}");
    // PLUS has 0.0803 and 0.0745 mm.
    assert!(
        (pixel[0] / 0.080_33 - 1.0).abs() < 0.03 && (pixel[1] / 0.074_46 - 1.0).abs() < 0.03,
        "{pixel:?}"
    );
}
