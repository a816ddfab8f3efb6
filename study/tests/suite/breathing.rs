//! What breathes changes where the target is, and nothing of what anybody sees.

use std::fs;

use study::run::run;

use crate::support::{QUICK, plan};

fn lines(dials: &str) -> Vec<Vec<String>> {
    let text = format!(
        "seed = 6\noperations = 2\n{QUICK}targets = [\"pre-aortic\", \"iliac-left\"]\n[[stratum]]\nname = \"a\"\n{dials}\n"
    );
    let folder = tempfile::tempdir().unwrap();
    run(&plan(&text), folder.path(), 2).unwrap();
    let lines = fs::read_to_string(folder.path().join("operations.csv")).unwrap();
    let fields = |line: &str| line.split(',').map(str::to_owned).collect();
    lines.lines().map(fields).collect()
}

#[test]
fn only_the_truth_is_another_where_organs_breathe() {
    let held = lines("");
    assert_eq!(held, lines("breathing = { mm = 0.0, period_s = 3.0 }"));
    let breathing = lines("breathing = { mm = 10.0 }");
    let of_truth = ["tre_mm", "nees", "miss_mm", "organs_mm", "rest_mm", "hash"];
    for (own, other) in held.iter().zip(&breathing).skip(1) {
        for ((column, a), b) in held[0].iter().zip(own).zip(other) {
            assert_eq!(a != b, of_truth.contains(&column.as_str()), "{column}: {a} {b}");
        }
    }
    assert_eq!(held.len(), 1 + 2 * 2);
}
