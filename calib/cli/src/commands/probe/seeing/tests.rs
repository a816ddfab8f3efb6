//! Points read off the images of a real sequence and of a generated one.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clap::Parser;

use crate::cli::{Cli, run};

fn answer(words: &[&str]) -> Result<String, String> {
    let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
    run(cli, |_| Err("no volume here".into())).map(|outcome| outcome.text)
}

/// The oracle is PLUS's own segmentation of the same images.
#[test]
fn dots_of_the_real_recording_are_those_that_plus_found() {
    let Some(shared) = std::env::var_os("TROCAR_SHARED") else {
        println!("SKIPPED: TROCAR_SHARED is not set");
        return;
    };
    let data = Path::new(&shared).join("data/plus-ultrasound");
    if !data.is_dir() {
        println!("SKIPPED: {} is not there", data.display());
        return;
    }
    let file = |name: &str| data.join(name).to_string_lossy().into_owned();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let text = answer(&[
        "calib",
        "probe",
        "--sequence",
        &file("fCal_Test_Calibration_3NWires_fCal2.0.igs.mha"),
        "--config",
        &file("PlusDeviceSet_fCal_Sim_SpatialCalibration_2.0.xml"),
        "--phantom-error-mm",
        "0",
        "--phantom-error-deg",
        "0",
        "--points-out",
        &at("points.csv"),
        "--picture",
        &at("dots.png"),
    ])
    .unwrap();
    assert!(text.contains("1710 points in 190 of 190"), "{text}");
    assert!(fs::read(at("dots.png")).unwrap().starts_with(b"\x89PNG"));
    let points = fs::read_to_string(at("points.csv")).unwrap();
    let ours: BTreeMap<(String, String), [f64; 2]> = points
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let px = [2, 3].map(|k| fields[k].parse().unwrap());
            ((fields[0].to_owned(), fields[1].to_owned()), px)
        })
        .collect();
    let json = fs::read_to_string(data.join("nwire_points_calibration.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let (mut off, mut all) = (Vec::new(), 0);
    for (frame, marks) in json["frames"].as_object().unwrap() {
        for mark in marks.as_array().unwrap() {
            all += 1;
            let name = mark["wire"].as_str().unwrap().to_owned();
            let Some([u, v]) = ours.get(&(frame.clone(), name)) else {
                continue;
            };
            let px = [0, 1].map(|k| mark["px"][k].as_f64().unwrap());
            // PLUS's own sizes of these pixels.
            off.push(((u - px[0]) * 0.0796).hypot((v - px[1]) * 0.0745));
        }
    }
    off.sort_by(f64::total_cmp);
    let (median, most) = (off[off.len() / 2], off[off.len() - 1]);
    println!(
        "{} of {all} points, median {median:.3}, at most {most:.2} mm from PLUS's",
        off.len()
    );
    // A wrong name would be 5 mm off; half a dot's width is 0.6 mm.
    assert!(
        off.len() == all && median < 0.05 && most < 0.6,
        "{} of {all}, {median}, {most}",
        off.len()
    );
}

#[test]
fn a_lag_is_found_by_the_wall_in_the_images() {
    let (columns, rows, lag) = (160, 120, 0.05);
    let way = |t: f64| 3.0 * (2.1 * t).sin() + 1.5 * (3.7 * t + 1.0).sin();
    let mut header = format!("NDims = 3\nDimSize = {columns} {rows} 200\nElementType = MET_UCHAR\n");
    let mut pixels = Vec::new();
    for i in 0..200 {
        let t = 50.0 + 0.05 * f64::from(i);
        let name = format!("Seq_Frame{i:04}_ProbeToReferenceTransform");
        writeln!(
            header,
            "{name} = 1 0 0 4 0 1 0 {:.6} 0 0 1 9 0 0 0 1\n{name}Status = OK",
            way(t)
        )
        .unwrap();
        writeln!(header, "Seq_Frame{i:04}_Timestamp = {t:.3}").unwrap();
        let row = 60.0 - 8.0 * way(t + lag);
        for v in 0..rows {
            let y = (f64::from(v) - row) / 2.5;
            pixels.extend(vec![(200.0 * (-0.5 * y * y).exp()) as u8; columns as usize]);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tank.mha");
    fs::write(
        &path,
        [(header + "ElementDataFile = LOCAL\n").as_bytes(), &pixels].concat(),
    )
    .unwrap();
    let path = path.to_string_lossy();
    let text = answer(&["calib", "lag", "--sequence", &path]).unwrap();
    assert!(text.contains("in 200 of 200"), "{text}");
    let told = text.lines().find(|line| line.starts_with("lag ")).unwrap();
    let told: f64 = told.split_whitespace().nth(1).unwrap().parse().unwrap();
    // A tenth of a pixel of 8 a mm, at 5 mm/s and 200 images: below 1 ms.
    assert!((told - 1e3 * lag).abs() < 2.0, "{text}");
    let refused = answer(&["calib", "lag", "--sequence", &path, "--region", "0,0,161,120"]).unwrap_err();
    assert!(refused.contains("an image of 160 x 120 does not hold"), "{refused}");
}
