//! The three commands on a volume in memory.

use std::fs;
use std::path::Path;

use bus::message::{Marks, VolumeHash};
use bus::volume::{Layout, OwnedVolume, Voxels};
use clap::Parser;
use geometry::{Affine, VolumeGrid};
use scene::VolumeSpec;
use tempfile::TempDir;

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
#[allow(clippy::unnecessary_wraps, reason = "the signature is that of a loader")]
fn volume(_: &VolumeSpec) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
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
    Ok(OwnedVolume {
        grid,
        layout,
        voxels,
        padding_hu: -1000,
        hash: VolumeHash([7; 32]),
        marks: Marks::NONE,
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
    let text = "from_x,from_y,from_z,to_x,to_y,to_z\n0,0,0,5,0,0\n60,0,0,65,0,0\n0,80,0,5,80,0\n0,0,50,5,0,50\n";
    fs::write(&pairs, text).unwrap();
    let line = format!("calib register --pairs {pairs} --to ct --from tracker --noise-mm 0.1 --out {out}");
    calib(&format!("{line} --ct ct.mha")).unwrap();
    let file = calib::file::RegistrationFile::parse(&fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!(file.ct_hash, Some("07".repeat(32)));
    let both = calib(&format!("{line} --ct ct.mha --ct-hash ab")).unwrap_err();
    assert!(both.contains("cannot be used with"), "{both}");
}
