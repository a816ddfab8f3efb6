//! Touches from planted sequences whose truth is known, through the command line.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use clap::Parser;

use crate::cli::{Cli, run};
use crate::commands::Outcome;

/// Where the tip stands, mm, each for two seconds, with a second between.
const POINTS: [[f64; 3]; 3] = [[10.0, 20.0, 1500.0], [60.0, -15.0, 1480.0], [-30.0, 5.0, 1520.0]];
const TIP_MM: [f64; 3] = [3.0, -2.0, 150.0];

/// A number in -1 to 1, the same in every run.
fn noise(i: usize) -> f64 {
    let x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (((x ^ (x >> 29)) >> 11) as f64 / (1_u64 << 52) as f64) - 1.0
}

/// The tip at a time.
fn stands(t: f64) -> [f64; 3] {
    let (k, rest) = ((t / 3.0) as usize, t % 3.0);
    let [a, b] = [POINTS[k.min(2)], POINTS[(k + 1).min(2)]];
    let way = (rest - 2.0).max(0.0);
    let smooth = way * way * (3.0 - 2.0 * way);
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * smooth)
}

/// A recording at 50 Hz of a stylus that tilts slowly while its tip goes where `tip` says, over a reference that moves.
fn sequence(
    seconds: f64,
    noise_mm: f64,
    tip: impl Fn(f64) -> [f64; 3],
    status: impl Fn(f64) -> &'static str,
) -> String {
    let mut text = "ObjectType = Image\n".to_owned();
    for i in 0..(seconds * 50.0) as usize {
        let t = i as f64 / 50.0;
        // Stylus: a turn about y by a; its marker lies so that the tip is where it is said to be, in the reference.
        let (s, c) = (0.3 * (0.4 * t).sin()).sin_cos();
        let lever = [c * TIP_MM[0] + s * TIP_MM[2], TIP_MM[1], -s * TIP_MM[0] + c * TIP_MM[2]];
        let at = tip(t);
        let p = [0, 1, 2].map(|k| at[k] - lever[k] + noise_mm * noise(3 * i + k));
        // Reference to tracker: a shift that wanders.
        let shift = [100.0 + 5.0 * t.sin(), -50.0, 20.0 + 3.0 * t];
        let q = [0, 1, 2].map(|k| p[k] + shift[k]);
        let _ = writeln!(
            text,
            "Seq_Frame{i:04}_StylusToTrackerTransform = {c} 0 {s} {} 0 1 0 {} {} 0 {c} {} 0 0 0 1\n\
             Seq_Frame{i:04}_StylusToTrackerTransformStatus = {}\n\
             Seq_Frame{i:04}_ReferenceToTrackerTransform = 1 0 0 {} 0 1 0 {} 0 0 1 {} 0 0 0 1\n\
             Seq_Frame{i:04}_ReferenceToTrackerTransformStatus = OK\nSeq_Frame{i:04}_Timestamp = {t}",
            q[0],
            q[1],
            -s,
            q[2],
            status(t),
            shift[0],
            shift[1],
            shift[2]
        );
    }
    text + "ElementDataFile = LOCAL\n"
}

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, text: &str, options: &str) -> Result<Outcome, String> {
        fs::write(self.path("s.mha"), text).unwrap();
        let line = format!("calib touch p --from-sequence @s.mha --to @touched.csv {options}");
        let words = line
            .split_whitespace()
            .map(|w| w.replace('@', &format!("{}/", self.folder.path().display())));
        run(Cli::try_parse_from(words).unwrap(), |_| {
            unreachable!("no volume is read")
        })
    }

    /// The tip's place from a sequence that has the tip itself.
    fn tipped(text: &str) -> String {
        let [x, y, z] = TIP_MM;
        let with = |line: &str| match line.split_once("_Timestamp") {
            Some((frame, _)) => {
                format!("{line}\n{frame}_StylusTipToStylusTransform = 1 0 0 {x} 0 1 0 {y} 0 0 1 {z} 0 0 0 1\n")
            }
            None => format!("{line}\n"),
        };
        text.lines().map(with).collect()
    }

    fn touches(&self) -> Vec<[f64; 9]> {
        let text = fs::read_to_string(self.path("touched.csv")).unwrap();
        let rows = text.lines().filter(|l| l.starts_with("p-"));
        let row = |line: &str| -> Vec<f64> { line.split(',').skip(1).map(|x| x.parse().unwrap()).collect() };
        rows.map(|line| row(line)[..9].try_into().unwrap()).collect()
    }
}

const CHAIN: &str = "--transform StylusTipToReference";

#[test]
fn points_at_which_the_tip_stood_still_are_found() {
    let bench = Bench::new();
    let text = Bench::tipped(&sequence(8.0, 0.2, stands, |_| "OK"));
    let outcome = bench.run(&text, &format!("{CHAIN} --dwells 3")).unwrap();
    assert!(
        outcome.text.contains("3 touches") && outcome.text.contains("in the reference"),
        "{}",
        outcome.text
    );
    let touches = bench.touches();
    for (found, truth) in touches.iter().zip(POINTS) {
        let off = (0..3).map(|k| (found[k] - truth[k]).powi(2)).sum::<f64>().sqrt();
        let sigma = (found[3] + found[6] + found[8]).sqrt();
        // 0.12 mm along each axis over some 80 poses: 0.02 mm; four of the deviations given.
        assert!(off < 0.1 && off < 4.0 * sigma && sigma < 0.1, "{off} {sigma}");
    }
    assert_eq!(touches.len(), 3);
}

#[test]
fn what_did_not_stand_still_is_refused_with_the_reason() {
    let bench = Bench::new();
    let refused = |text: &str, options: &str| {
        bench
            .run(&Bench::tipped(text), &format!("{CHAIN} {options}"))
            .unwrap_err()
    };
    let fine = sequence(8.0, 0.2, stands, |_| "OK");
    let count = refused(&fine, "--dwells 4");
    assert!(
        count.contains("3 points were touched, and --dwells says 4") && count.contains("p-2"),
        "{count}"
    );
    // 1.5 mm/s: slow enough to stand still, and 12 mm on the way.
    let drift = refused(&sequence(8.0, 0.2, |t| [1.5 * t, 0.0, 1500.0], |_| "OK"), "");
    assert!(
        drift.contains("nowhere stands still") && drift.contains("the tip moved by"),
        "{drift}"
    );
    // It trembles by 2 mm about a place.
    let trembles = refused(
        &sequence(8.0, 0.2, |t| [2.0 * (60.0 * t).sin(), 0.0, 1500.0], |_| "OK"),
        "",
    );
    assert!(trembles.contains("nowhere stands still"), "{trembles}");
    let moving = refused(&sequence(8.0, 0.2, |t| [20.0 * t, 0.0, 1500.0], |_| "OK"), "");
    assert!(moving.contains("below 2 mm/s"), "{moving}");
    // Seen every other tenth of a second only: more than half of the frames are lost, or windows have too few.
    let lost = refused(
        &sequence(
            8.0,
            0.2,
            |_| [0.0, 0.0, 1500.0],
            |t| if t % 0.2 < 0.15 { "MISSING" } else { "OK" },
        ),
        "",
    );
    assert!(lost.contains("nowhere stands still"), "{lost}");
    let slow = refused(&fine, "--dwell-s 0.3");
    assert!(slow.contains("give a longer --dwell-s"), "{slow}");
    let untimed = refused(&fine.replace("Timestamp", "Stamp"), "");
    assert!(
        untimed.contains("there is no transform StylusTipTo") || untimed.contains("no Timestamp"),
        "{untimed}"
    );
    assert!(!bench.path("touched.csv").exists());
}

/// A tracker that repeats its last pose when it sees nothing shows no dwell.
#[test]
fn a_tracker_that_repeats_itself_shows_no_dwell() {
    let bench = Bench::new();
    let frozen = sequence(8.0, 0.0, |_| [0.0, 0.0, 1500.0], |_| "OK");
    // The same numbers in every frame.
    let first: Vec<&str> = frozen.lines().filter(|l| l.starts_with("Seq_Frame0000")).collect();
    let frames = (0..400).map(|i| {
        let lines = first.iter().map(|l| l.replace("Frame0000", &format!("Frame{i:04}")));
        let stamped = lines.map(|l| match l.split_once("Timestamp") {
            Some((head, _)) => format!("{head}Timestamp = {}\n", f64::from(i) / 50.0),
            None => l + "\n",
        });
        stamped.collect::<String>()
    });
    let text = frames.collect::<String>() + "ElementDataFile = LOCAL\n";
    let refused = bench.run(&Bench::tipped(&text), CHAIN).unwrap_err();
    assert!(refused.contains("in 1 poses of 400 frames"), "{refused}");
}
