//! The command on a sequence and a signal made by hand.

use std::fmt::Write as _;
use std::fs;

use clap::Parser;

use crate::cli::{Cli, run};

/// A hand that goes back and forth at changing speed, mm.
fn hand(t: f64) -> f64 {
    8.0 * (2.1 * t).sin() + 3.0 * (3.7 * t + 1.0).sin()
}

/// What the command says of 200 frames over 10 s whose images are of the way at their time and `lag`.
fn answer(lag: f64, head: &str, more: &[&str], change: impl Fn(String) -> String) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let (mut header, mut signal) = ("NDims = 3\n".to_owned(), format!("{head}\n"));
    for i in 0..200 {
        let t = 50.0 + 0.05 * f64::from(i);
        writeln!(
            header,
            "Seq_Frame{i:04}_ProbeToReferenceTransform = 1 0 0 4 0 1 0 {:.6} 0 0 1 9 0 0 0 1",
            hand(t)
        )
        .unwrap();
        writeln!(header, "Seq_Frame{i:04}_ProbeToReferenceTransformStatus = OK").unwrap();
        writeln!(header, "Seq_Frame{i:04}_Timestamp = {t:.3}").unwrap();
        let first = if head.starts_with("frame") {
            i.to_string()
        } else {
            format!("{t:.3}")
        };
        // Rows are whole pixels: the rounding is the noise.
        writeln!(signal, "{first},{}", (250.0 - 12.0 * hand(t + lag)).round()).unwrap();
    }
    header.push_str("ElementDataFile = LOCAL\n");
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    fs::write(at("s.mha"), header).unwrap();
    fs::write(at("s.csv"), change(signal)).unwrap();
    let mut words = vec![
        "calib".to_owned(),
        "lag".to_owned(),
        "--signal".to_owned(),
        at("s.csv"),
        "--sequence".to_owned(),
        at("s.mha"),
    ];
    words.extend(more.iter().map(|word| (*word).to_owned()));
    let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
    run(cli, |_| Err("no volume here".into())).map(|outcome| outcome.text)
}

#[test]
fn a_lag_is_told_with_its_sign_by_frames_and_by_times() {
    for (lag, head) in [(-0.06, "frame,value"), (0.04, "t_s,value")] {
        let text = answer(lag, head, &[], |s| s).unwrap();
        let told: f64 = text.split_whitespace().nth(1).unwrap().parse().unwrap();
        // Whole pixels of 12 a mm: less than a ms.
        assert!((told - 1e3 * lag).abs() < 2.0, "{text}");
        assert!(
            text.contains("181 used, 0 left out") || text.contains("180 used, 0 left out"),
            "{text}"
        );
    }
}

#[test]
fn what_is_wrong_is_refused_by_name() {
    let refused =
        |more: &[&str], change: &dyn Fn(String) -> String| answer(0.0, "frame,value", more, change).unwrap_err();
    let keep = |s: String| s;
    assert!(refused(&[], &|s| s.replacen("frame", "t", 1)).contains("line 1: found \"t,value\", expected the columns"));
    assert!(refused(&[], &|s| s.replacen("\n7,", "\n7;", 1)).contains("line 9: found \"7;"));
    assert!(refused(&[], &|s| s.replacen("\n199,", "\n999,", 1)).contains("frame 999 is not in"));
    assert!(refused(&["--window-ms", "20"], &keep).contains("samples are 0.050 s apart and the window is 0.020 s"));
    assert!(refused(&["--most-ms", "nan"], &keep).contains("the largest lag, s is NaN; 0.01 to 5 are allowed"));
    assert!(refused(&["--max-sigma-ms", "0.02"], &keep).contains("at most 0.00002 s is accepted"));
    assert!(refused(&["--transform", "ToolToReference"], &keep).contains("ToolToReference"));
    let noise = |s: String| {
        s.lines()
            .enumerate()
            .map(|(i, line)| match (i, line.split_once(',')) {
                (1.., Some((frame, _))) => format!("{frame},{}\n", (i * 7919) % 613),
                _ => format!("{line}\n"),
            })
            .collect()
    };
    let unlike = refused(&[], &noise);
    assert!(unlike.contains("the correlation of both signals is 0."), "{unlike}");
}
