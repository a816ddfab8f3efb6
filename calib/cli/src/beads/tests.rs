//! The three commands on a volume in memory.

use std::fs;
use std::path::Path;

use bus::message::{Marks, VolumeHash};
use bus::volume::{Layout, OwnedVolume, Voxels};
use clap::Parser;
use geometry::{Affine, VolumeGrid};
use scene::VolumeSpec;
use tempfile::TempDir;

use crate::beads::Loaded;
use crate::cli::{Cli, run};
use crate::commands::Outcome;

/// Centres of the beads, voxels, which are mm here.
const BEADS: [[f64; 3]; 4] = [
    [10.0, 10.0, 10.0],
    [40.3, 12.2, 14.4],
    [14.0, 38.0, 20.7],
    [33.1, 30.0, 35.0],
];

/// Balls of 1 mm radius and 14 000 HU in water, as a Gaussian of the same mass and the same second moment: what a scanner of
/// 0.6 mm blur shows of them but for some percent.
fn volume(spec: &VolumeSpec) -> Result<Loaded, Box<dyn std::error::Error + Send + Sync>> {
    let unit = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let grid = VolumeGrid::checked([50, 50, 45], unit)?;
    let layout = Layout::choose(grid.dims())?;
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    let variance = 0.6 * 0.6 + 0.2;
    let peak = 14_000.0 * 4.0 / 3.0 * std::f64::consts::PI / (std::f64::consts::TAU * variance).powf(1.5);
    for z in 0..45_u32 {
        for y in 0..50_u32 {
            for x in 0..50_u32 {
                let at = [x, y, z].map(f64::from);
                let square = |c: &[f64; 3]| (0..3).map(|a| (at[a] - c[a]).powi(2)).sum::<f64>();
                let hu: f64 = BEADS.iter().map(|c| peak * (-0.5 * square(c) / variance).exp()).sum();
                voxels[layout.offset([x, y, z])] = hu.round() as i16;
            }
        }
    }
    // By the file's name, as a series of another scanner.
    let is_mr = matches!(&spec.source, scene::VolumeSource::File(file) if file.path.ends_with("mr"));
    Ok(Loaded {
        volume: OwnedVolume {
            grid,
            layout,
            voxels,
            padding_hu: -1000,
            hash: VolumeHash([7; 32]),
            marks: Marks::NONE,
        },
        modality: Some(if is_mr { "MR" } else { "CT" }.to_owned()),
        warnings: vec!["slices are shifted against one another".to_owned()],
    })
}

fn calib(line: &str) -> Result<Outcome, String> {
    run(
        Cli::try_parse_from(line.split(' ')).map_err(|error| error.to_string())?,
        volume,
    )
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn beads_are_found_matched_and_checked() {
    let folder = TempDir::new().unwrap();
    let (beads, touched, out) = (path(&folder, "b.json"), path(&folder, "t.txt"), path(&folder, "r.json"));
    let found = calib(&format!(
        "calib beads ct.mha --out {beads} --png {}",
        path(&folder, "b.png")
    ))
    .unwrap();
    assert!(
        found.text.contains("4 beads") && found.text.contains("07070707"),
        "{}",
        found.text
    );
    assert!(Path::new(&path(&folder, "b.png")).exists());
    // Turned by a quarter about z, in another order.
    let turned = |[x, y, z]: [f64; 3]| format!("{} {x} {z}\n", -y);
    let text: String = [3, 1, 0, 2].iter().map(|i| turned(BEADS[*i])).collect();
    fs::write(&touched, text).unwrap();
    let matched = calib(&format!("calib match {beads} {touched} --ct ct.mha --out {out}")).unwrap();
    assert!(
        matched.text.contains("ct_from_tracker") && matched.text.contains("bead 4"),
        "{}",
        matched.text
    );
    let check = |touched: &str| calib(&format!("calib check {out} --known 20,20,20 --touched {touched}")).unwrap();
    let good = check("-20,20,20.2");
    assert!(
        good.refused.is_none() && good.text.contains("verdict          pass"),
        "{}",
        good.text
    );
    let bad = check("-20,20,23");
    assert!(
        bad.refused.is_some_and(|why| why.contains("do not use")),
        "{}",
        bad.text
    );
    let limited = calib(&format!(
        "calib check {out} --known 20,20,20 --touched -20,20,20 --max-mm 0.5"
    ))
    .unwrap();
    assert!(
        limited.text.contains("warn") && limited.text.contains("beyond --max-mm"),
        "{}",
        limited.text
    );
}

/// The covariances in a file of touches were passed over: each touch was taken to be off by `--touch-mm` alone.
#[test]
fn match_counts_what_the_file_of_touches_states() {
    let folder = TempDir::new().unwrap();
    let (beads, touched) = (path(&folder, "b.json"), path(&folder, "t.csv"));
    calib(&format!("calib beads ct.mha --out {beads}")).unwrap();
    let registered = |columns: &str, error: &str, more: &str| {
        let row = |[x, y, z]: &[f64; 3]| format!("a,{},{x},{z}{error}\n", -y);
        let rows: String = BEADS.iter().map(row).collect();
        fs::write(&touched, format!("on,x,y,z{columns}\n{rows}")).unwrap();
        calib(&format!("calib match {beads} {touched} --target 20,20,20 --json{more}")).map(|outcome| {
            let file: serde_json::Value = serde_json::from_str(&outcome.text).unwrap();
            let at = |point: &str| {
                file["predicted_tre"][point.parse::<usize>().unwrap()]["rms_mm"]
                    .as_f64()
                    .unwrap()
            };
            ([at("0"), at("1")], file["noise"].clone())
        })
    };
    const C: &str = ",cxx,cxy,cxz,cyy,cyz,czz";
    const U: &str = ",u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z";
    let (plain, noise) = registered("", "", "").unwrap();
    assert!(noise["touches"].is_null(), "{noise}");
    // 0.3 mm of the hand, 0.1 mm of the bead and 0.4 mm of the file, along each axis: sqrt(0.26 / 0.1) times as much.
    let (own, noise) = registered(C, ",0.16,0,0,0.16,0,0.16", "").unwrap();
    for (own, plain) in own.iter().zip(plain) {
        assert!((own / plain - 2.6_f64.sqrt()).abs() < 1e-9, "{own} {plain}");
    }
    assert_eq!(noise["touches"]["shared_mm"], serde_json::Value::Null);
    let sigma = |noise: &serde_json::Value| noise["sigma_mm"].as_f64().unwrap();
    assert!((sigma(&noise) - 0.26_f64.sqrt()).abs() < 1e-12, "{noise}");
    // All of it shared: 0.4 mm along each axis at the centre, however many touches there are.
    let all = format!("{C}{U}");
    let (shared, noise) = registered(&all, ",0.16,0,0,0.16,0,0.16,0.4,0,0,0,0.4,0,0,0,0.4", "").unwrap();
    let expected = (plain[0] * plain[0] + 3.0 * 0.16).sqrt();
    assert!((shared[0] - expected).abs() < 1e-9, "{shared:?} {expected}");
    assert!(
        (noise["touches"]["shared_mm"].as_f64().unwrap() - 0.4).abs() < 1e-12,
        "{noise}"
    );
    let (hand, _) = registered(C, ",0.16,0,0,0.16,0,0.16", " --touch-mm 0.2").unwrap();
    assert!((hand[0] / plain[0] - (0.21_f64 / 0.1).sqrt()).abs() < 1e-9, "{hand:?}");
    for (columns, error) in [
        (C, ",-1,0,0,1,0,1"),
        (all.as_str(), ",0.16,0,0,0.16,0,0.16,0.5,0,0,0,0.4,0,0,0,0.4"),
    ] {
        let refused = registered(columns, error, "").unwrap_err();
        assert!(refused.contains("touched point 1: its covariance is none"), "{refused}");
    }
}

/// Registration and check took the tip's error for two independent ones: with a tip known to 0.5 mm along each axis a marker that had
/// moved by 2 mm passed.
#[test]
fn a_check_knows_what_registration_and_touch_share() {
    let folder = TempDir::new().unwrap();
    let [beads, touched, known, out] = ["b.json", "t.csv", "k.csv", "r.json"].map(|name| path(&folder, name));
    calib(&format!("calib beads ct.mha --out {beads}")).unwrap();
    const COLUMNS: &str = "on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z";
    // A tip that is 0.5 mm off along each axis, as it may be, held alike; touched beads and the known point have all of it.
    let row = |[x, y, z]: [f64; 3]| {
        let [x, y, z] = [0.5 - y, x + 0.5, z + 0.5];
        format!("a,{x},{y},{z},0.2501,0,0,0.2501,0,0.2501,0.5,0,0,0,0.5,0,0,0,0.5\n")
    };
    let head = |id: &str| format!("# places of the tip of a in the tracker, mm; calibration {id}\n{COLUMNS}\n");
    fs::write(&touched, head("00000000000000aa") + &BEADS.map(row).concat()).unwrap();
    calib(&format!("calib match {beads} {touched} --touch-mm 0.1 --out {out}")).unwrap();
    let check = |id: &str, off: f64| {
        fs::write(&known, head(id) + &row([20.0, 20.0, 20.0 + off])).unwrap();
        calib(&format!(
            "calib check {out} --known 20,20,20 --touches {known} --touch-mm 0.1 --json"
        ))
        .map(|outcome| {
            let record: serde_json::Value = serde_json::from_str(&outcome.text).unwrap();
            let number = |key: &str| record[key].as_f64().unwrap();
            let of = [number("predicted_radius_95_mm"), number("apart_radius_95_mm")];
            (
                record["verdict"].as_str().unwrap().to_owned(),
                of,
                record["tip"].to_string(),
            )
        })
    };
    let (verdict, [radius, apart], words) = check("00000000000000aa", 0.0).unwrap();
    assert!(verdict == "pass" && words.contains("it cancels"), "{verdict} {words}");
    // Held alike all of it cancels: left are 0.1 mm of hand, bead and known point each. Apart, 0.71 mm along each axis come to it.
    assert!(radius < 0.6 && apart > 1.9, "{radius} {apart}");
    assert_eq!(check("00000000000000aa", 2.0).unwrap().0, "fail");
    // With another calibration nothing is known of what cancels; what is told is not taken for slack.
    let (_, [other, _], words) = check("00000000000000bb", 0.0).unwrap();
    assert!(
        other <= radius && words.contains("different calibrations") && words.contains("the stricter"),
        "{words}"
    );
    // A place alone: the registration's part is not held for slack either.
    let plain = calib(&format!(
        "calib check {out} --known 20,20,20 --touched -19.5,20.5,22.5 --touch-mm 0.1"
    ))
    .unwrap();
    assert!(
        plain.refused.is_some() && plain.text.contains("the touch does not tell it apart"),
        "{}",
        plain.text
    );
    // A limit is vouched for by what does not cancel.
    let line = format!("calib check {out} --known 20,20,20 --touches {known} --touch-mm 0.1 --max-mm 1.5");
    check("00000000000000aa", 0.0).unwrap();
    assert!(calib(&line).unwrap().text.contains("verdict          warn"));
    // Parts that are more than the whole, and touches of another frame, are refused.
    let text = fs::read_to_string(&out).unwrap();
    let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
    file["shared"]["columns"][3][0] = 5.0.into();
    fs::write(&out, file.to_string()).unwrap();
    assert!(
        check("00000000000000aa", 0.0)
            .unwrap_err()
            .contains("more than its covariance")
    );
    let other = text.replace("\"from\": \"tracker\"", "\"from\": \"reference\"");
    fs::write(&out, other.replace("ct_from_tracker", "ct_from_reference")).unwrap();
    assert!(check("00000000000000aa", 0.0).unwrap_err().contains("in the tracker"));
}

/// What touches state was passed over by `calib register`, and in the guided steps the greater of it and of the hand's error was taken.
#[test]
fn register_counts_what_touches_state_as_match_does() {
    let folder = TempDir::new().unwrap();
    let [beads, touched, pairs, points] = ["b.json", "t.csv", "p.csv", "ct.txt"].map(|name| path(&folder, name));
    calib(&format!("calib beads ct.mha --out {beads}")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&fs::read_to_string(&beads).unwrap()).unwrap();
    let centres: Vec<[f64; 3]> = file["beads"]
        .as_array()
        .unwrap()
        .iter()
        .map(|bead| serde_json::from_value(bead["centre_mm"].clone()).unwrap())
        .collect();
    let (columns, first) = (
        "cxx,cxy,cxz,cyy,cyz,czz,u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z",
        "# places of the tip of a in the tracker, mm; calibration 00000000000000aa",
    );
    let error = "0.3,0,0,0.3,0.01,0.4,0.5,0,0,0,0.4,0,0.1,0,0.3";
    let lines = |row: &dyn Fn(&[f64; 3]) -> String| centres.iter().map(row).collect::<String>();
    fs::write(
        &touched,
        format!(
            "{first}\non,x,y,z,{columns}\n{}",
            lines(&|[x, y, z]| format!("a,{},{x},{z},{error}\n", -y))
        ),
    )
    .unwrap();
    fs::write(&points, lines(&|[x, y, z]| format!("{x},{y},{z}\n"))).unwrap();
    let both = |[x, y, z]: &[f64; 3]| format!("{x},{y},{z},{},{x},{z},{error}\n", -y);
    fs::write(
        &pairs,
        format!(
            "{first}\nto_x,to_y,to_z,from_x,from_y,from_z,{columns}\n{}",
            lines(&both)
        ),
    )
    .unwrap();
    let made = |line: &str| {
        let outcome = calib(&format!("calib {line} --target 20,20,20 --json")).unwrap();
        let file: serde_json::Value = serde_json::from_str(&outcome.text).unwrap();
        let rms: Vec<f64> = file["predicted_tre"]
            .as_array()
            .unwrap()
            .iter()
            .map(|at| at["rms_mm"].as_f64().unwrap())
            .collect();
        (rms, file)
    };
    let (expected, matched) = made(&format!("match {beads} {touched}"));
    let rest = 0.3_f64.hypot(0.1);
    for words in [
        format!("register --to ct --from tracker --pairs {pairs} --least-noise-mm {rest}"),
        format!("register --to ct --to-points {points} --from-points {touched} --noise-mm {rest}"),
    ] {
        let (found, file) = made(&words);
        for (found, expected) in found.iter().zip(&expected) {
            // Of the same pairs: to rounding.
            assert!((found - expected).abs() < 1e-9, "{words}: {found} {expected}");
        }
        assert_eq!(file["shared"]["calibration"], "00000000000000aa", "{words}");
        let at = |file: &serde_json::Value, i: usize, j: usize| file["shared"]["columns"][i][j].as_f64().unwrap();
        for (i, j) in (0..6).flat_map(|i| (0..3).map(move |j| (i, j))) {
            assert!((at(&file, i, j) - at(&matched, i, j)).abs() < 1e-9, "{words} {i} {j}");
        }
    }
    // Without what they share it is said that the covariance lacks it; what is no covariance is refused with its line.
    let text = fs::read_to_string(&pairs).unwrap();
    let short = text
        .replace(",u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z", "")
        .replace(",0.5,0,0,0,0.4,0,0.1,0,0.3", "");
    fs::write(&pairs, short).unwrap();
    let (_, file) = made(&format!("register --to ct --from tracker --pairs {pairs}"));
    assert!(
        file["shared"]["columns"].is_null() && file["shared"].is_object(),
        "{}",
        file["shared"]
    );
    fs::write(&pairs, text.replacen("0.3,0,0,0.3,0.01", "0.2,0,0,0.3,0.01", 1)).unwrap();
    let refused = calib(&format!("calib register --pairs {pairs}")).unwrap_err();
    assert!(refused.contains("line 3: cxx to czz are no covariance"), "{refused}");
}

#[test]
fn wrong_files_are_refused_by_name() {
    let folder = TempDir::new().unwrap();
    let beads = path(&folder, "b.json");
    calib(&format!("calib beads ct.mha --out {beads}")).unwrap();
    let text = fs::read_to_string(&beads).unwrap();
    let touched = path(&folder, "t.txt");
    fs::write(&touched, "0 0 0\n50 0 0\n0 50 0\n").unwrap();
    let refused = |text: &str| {
        fs::write(&beads, text).unwrap();
        calib(&format!("calib match {beads} {touched}")).unwrap_err()
    };
    for (from, to, words) in [
        ("\"version\": 1", "\"version\": 2", "expected \"trocar-beads\", 1"),
        ("07070707", "xy", "expected 64 hexadecimal"),
        ("\"beads\": [", "\"beads\": [7,", "invalid type"),
    ] {
        let error = refused(&text.replacen(from, to, 1));
        assert!(error.contains("reading the beads") && error.contains(words), "{error}");
    }
    for end in [0, 1, 100, text.len() / 2] {
        assert!(!refused(&text[..end]).is_empty());
    }
    let many = text.find("\"beads\": [").unwrap() + 10;
    let first = text[many..].find("},").unwrap() + many + 2;
    let again = text[many..first].repeat(65);
    let error = refused(&format!("{}{again}{}", &text[..many], &text[many..]));
    assert!(error.contains("69 beads, at most 64"), "{error}");
}

/// A tracker uses no registration that does not say of which CT it is.
#[test]
fn a_registration_of_pairs_says_of_which_ct_it_is() {
    let folder = TempDir::new().unwrap();
    let (pairs, out) = (path(&folder, "p.csv"), path(&folder, "r.json"));
    let text = "from_x,from_y,from_z,to_x,to_y,to_z\n0,0,0,5,0,0\n40,0,0,45,0,0\n0,40,0,5,40,0\n0,0,40,5,0,40\n";
    fs::write(&pairs, text).unwrap();
    let line = format!("calib register --pairs {pairs} --to ct --from tracker --noise-mm 0.1 --out {out}");
    calib(&format!("{line} --ct ct.mha")).unwrap();
    let file = calib::file::RegistrationFile::parse(&fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!(file.ct_hash, Some("07".repeat(32)));
    fs::write(&pairs, text.replace("45,0,0", "65,0,0")).unwrap();
    let outside = calib(&format!("{line} --overwrite --ct ct.mha")).unwrap_err();
    assert!(
        outside.contains("line 3: the point [65.0, 0.0, 0.0] of the CT lies outside it"),
        "{outside}"
    );
    let both = calib(&format!("{line} --ct ct.mha --ct-hash ab")).unwrap_err();
    assert!(both.contains("cannot be used with"), "{both}");
}

#[test]
fn beads_of_what_is_no_ct_are_refused_and_warnings_of_the_loader_are_told_and_written() {
    let refused = calib("calib beads mr").unwrap_err();
    assert!(refused.contains("not a CT") && refused.contains("MR"), "{refused}");
    let told = calib("calib beads mr --accept-not-ct").unwrap().text;
    assert!(
        told.contains("warning: taken as a CT by --accept-not-ct") && told.contains("MR"),
        "{told}"
    );
    let told = calib("calib beads ct.mha").unwrap().text;
    assert!(told.contains("warning: slices are shifted"), "{told}");
    let json = calib("calib beads ct.mha --json").unwrap().text;
    let file: crate::BeadsFile = serde_json::from_str(&json).unwrap();
    assert_eq!(file.warnings, ["slices are shifted against one another"]);
}
