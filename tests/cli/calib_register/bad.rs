//! Files and sets that have no registration: each is refused by name, with its place and its numbers.

use std::fs;

use super::{HEADER, csv, pairs, refused, register, registered};
use crate::support::*;

const GOOD: &str = "0,0,0,5,0,-7\n60,0,0,5,60,-7\n0,80,0,-75,0,-7\n";

#[test]
fn bad_files_are_refused_by_name() {
    let world = World::new();
    let with = |rows: &str| format!("{HEADER}\n{GOOD}{rows}").into_bytes();
    let only = |rows: &str| format!("{HEADER}\n{rows}").into_bytes();
    let weighted = |w: [&str; 3]| {
        let lines = GOOD.lines().zip(w).map(|(line, w)| format!("{line},{w}\n"));
        format!("{HEADER},weight\n{}", lines.collect::<String>()).into_bytes()
    };
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "p.csv: the file is empty (0 bytes)"),
        (
            b"# only this\n".to_vec(),
            "p.csv: there are no pairs in it, only blank lines and comments",
        ),
        (only(""), "there are no pairs in it, only the header"),
        (
            GOOD.into(),
            "line 1: the header has no column from_x | found \"0,0,0,5,0,-7\" | from_x,from_y,from_z,to_x",
        ),
        (
            HEADER.replace("to_y", "y").into(),
            "line 1: the header has no column to_y",
        ),
        (
            HEADER.replace("to_z", "to_z,wieght").into(),
            "p.csv, line 1, column 37 (wieght): this column is not known",
        ),
        (
            with("1,2,3,4,5\n"),
            "p.csv: line 5, column 10: 5 fields, expected 6 (from_x,from_y,from_z,to_x,to_y,to_z)",
        ),
        (
            with("1,2,3,4,5,6,7\n"),
            "p.csv: line 5, column 13: 7 fields, expected 6",
        ),
        (
            with("# one\n\n1,2,3,4,five,6\n"),
            "p.csv, line 7, column 9 (to_y): found \"five\", expected a number in mm",
        ),
        (
            with("1,2,NaN,4,5,6\n"),
            "p.csv, line 5, column 5 (from_z): found \"NaN\", which is not finite",
        ),
        (
            with("1,2,3,4,5,-inf\n"),
            "line 5, column 11 (to_z): found \"-inf\", which is not finite",
        ),
        (
            with("1,2,3,4,5,1e400\n"),
            "(to_z): found \"1e400\", which is not finite",
        ),
        (
            with("1,2,3,4,5,1e11\n"),
            "(to_z): found \"1e11\", at most 1e9 mm is allowed",
        ),
        (
            with("60,0,0,5,60,-7\n"),
            "p.csv: lines 3 and 5 hold the same pair | --allow-duplicates",
        ),
        (
            with("60,0,0,5,61,-7\n"),
            "lines 3 and 5 hold the same from point [60.0, 0.0, 0.0] with different partners",
        ),
        (
            with("61,0,0,5,60,-7\n"),
            "lines 3 and 5 hold the same to point [5.0, 60.0, -7.0] with different partners",
        ),
        (
            weighted(["0", "0", "0.0"]),
            "p.csv: the weights of all 3 pairs are zero",
        ),
        (
            weighted(["1", "-2", "1"]),
            "p.csv, line 3, column 16 (weight): found \"-2\", a weight must be at least 0",
        ),
        (
            weighted(["1", "nan", "1"]),
            "(weight): found \"nan\", which is not finite",
        ),
        (
            weighted(["1", "1", "0"]),
            "the 3 pairs of | 2 pairs carry weight; at least 3 are needed | Measure",
        ),
        (with("1,2,3,4,5,\"6\n"), "p.csv: line 5, column 11: the quoted field"),
        (with("\0,2,3,4,5,6\n"), "line 5, column 1 (from_x): found \"\\0\""),
        (
            [&with("")[..], b"\xff,2,3,4,5,6\n"].concat(),
            "p.csv: line 5: byte 80 is not UTF-8",
        ),
        (vec![b','; 5000], "p.csv: line 1 has 5000 bytes, at most 4096"),
        (
            with(&"1,2,3,4,5,6\n".repeat(10_000)),
            "p.csv: line 10002 begins pair 10001, at most 10000",
        ),
    ];
    for (bytes, words) in cases {
        let weights: &[&str] = if String::from_utf8_lossy(&bytes).contains(",weight") {
            &["--weights"]
        } else {
            &[]
        };
        let path = world.path("p.csv");
        fs::write(&path, bytes).unwrap();
        refused(
            &register(&world, &[&["--pairs", path.to_str().unwrap()], weights].concat()),
            words,
        );
    }
    let path = world.file("p.csv", &format!("{HEADER}\n{GOOD}"));
    let path = path.to_str().unwrap();
    refused(
        &register(&world, &["--pairs", path, "--weights"]),
        "--weights needs a column weight | line 1",
    );
    refused(
        &register(&world, &["--pairs", "/no/such.csv"]),
        "reading /no/such.csv: No such file",
    );
    refused(
        &register(&world, &["--pairs", "/dev/zero"]),
        "reading /dev/zero: this is not a file",
    );
    fs::File::create(world.path("p.csv"))
        .unwrap()
        .set_len((64 << 20) + 1)
        .unwrap();
    refused(
        &register(&world, &["--pairs", path]),
        "the file has 67108865 bytes, at most 67108864",
    );
}

#[test]
fn sets_without_an_answer_are_refused_with_their_singular_values() {
    let world = World::new();
    let line = "0,0,0,5,0,-7\n10,10,0,15,10,-7\n20,20,0,25,20,-7\n30,30,0,35,30,-7\n";
    let mirror = "10,0,0,-10,0,0\n-10,0,0,10,0,0\n0,10,0,0,-10,0\n0,-10,0,0,10,0\n0,0,10,0,0,-10\n0,0,-10,0,0,10\n";
    let point = "1,2,3,5,0,-7\n1,2,3,15,10,-7\n1,2,3,25,20,-7\n";
    for (rows, words) in [
        (
            "0,0,0,5,0,-7\n60,0,0,5,60,-7\n",
            "the 2 pairs of | 2 pairs carry weight; at least 3 are needed",
        ),
        (
            line,
            "lie on a line | relative singular values | Add a point well off that line",
        ),
        (
            mirror,
            "mirror each other | relative singular values | check the sign of each axis",
        ),
        (point, "the points coincide in one frame | radius"),
    ] {
        let path = world.file("p.csv", &format!("{HEADER}\n{rows}"));
        let output = register(&world, &["--pairs", path.to_str().unwrap(), "--allow-duplicates"]);
        refused(&output, &format!("p.csv by newton | {words}"));
    }
    // A mirror image of three different extents has one best rotation, and a bad one.
    let uneven = world.file(
        "p.csv",
        &format!(
            "{HEADER}\n{}",
            mirror
                .replace("0,0,10,0,0,-10", "0,0,30,0,0,-30")
                .replace("0,10,0,0,-10,0", "0,20,0,0,-20,0")
        ),
    );
    let (report, file) = registered(&world, &["--pairs", uneven.to_str().unwrap()]);
    assert!(
        file.singular_values.unwrap()[2] < -0.05 && report.contains("WARNING          a mirror image"),
        "{report}"
    );
    let many = world.file("p.csv", &csv(&pairs(501, 0.1)));
    let output = register(&world, &["--pairs", many.to_str().unwrap(), "--robust", "1"]);
    refused(&output, "the 501 pairs of | takes at most 500");
}
