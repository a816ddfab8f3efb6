//! The ends of the dials: right, or refused by name.

use std::fs;

use study::record::Ended;
use study::run::run;

use crate::support::{QUICK, plan};

/// As `config/study/extremes.toml`, with examinations that take a second.
#[test]
fn an_operation_at_the_ends_of_the_dials_is_right_or_refused_by_name() {
    let strata = [
        ("uptime", "localizer = { uptime_s = 8e7 }", ""),
        ("beads", "beads = { diameter_mm = 1.0 }", "ct"),
        ("thick", "ct = { spacing_mm = [2.0, 2.0, 10.0] }", "ct"),
        (
            "thick-large",
            "ct = { spacing_mm = [2.0, 2.0, 10.0] }\nbeads = { diameter_mm = 6.0 }",
            "match",
        ),
        ("four", "marker = { emitters = 4 }", "marker"),
        ("ball", "marker = { radius_mm = 5.0 }", "pivot"),
        ("noise", "localizer = { across_mm = 5.0, depth_mm = 5.0 }", "marker"),
        ("three", "marker = { emitters = 3, cone_deg = 180.0 }", "pivot"),
        (
            "needle",
            "marker = { width = 0.01, made_mm = 0.0, cone_deg = 180.0 }",
            "marker",
        ),
        ("thin", "marker = { width = 0.1, made_mm = 0.0, cone_deg = 180.0 }", ""),
        (
            "far",
            "localizer = { across_mm = 0.01, depth_mm = 0.01, moved_mm = [1e4, 0, 0] }",
            "",
        ),
        ("half", "localizer = { turned_deg = 179.9999999 }", ""),
        ("beyond", "localizer = { turned_deg = 180.0000001 }", ""),
        ("reference", "reference = { turned_deg = 179.9999999 }", ""),
        (
            "deep",
            "beads = { diameter_mm = 4.0, at_mm = [[0, 0, 50], [40, 20, 0], [-40, 30, 90], [20, 40, 140]] }",
            "",
        ),
    ];
    let each = strata.map(|(name, dials, _)| format!("[[stratum]]\nname = \"{name}\"\n{dials}\n"));
    let text = format!("operations = 1\n{QUICK}targets = [\"pre-aortic\"]\n{}", each.concat());
    let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let done = run(&plan(&text), folder.path(), 2).unwrap();
    for ((name, _, step), row) in strata.iter().zip(&done.rows) {
        assert_eq!(*name, row.stratum);
        assert_eq!(*step, row.step, "{name}: {}", row.why);
        match step.is_empty() {
            // Five deviations: one operation of a million is beyond.
            true => assert!(row.ended == Ended::Arrived && row.nees < 35.0, "{row:?}"),
            false => assert!(row.ended == Ended::Refused && row.why.len() > 20, "{row:?}"),
        }
        // What is wrong is told, and not that a file is empty.
        let words = match *name {
            "thick" => "take thinner slices",
            "thick-large" => "of the 6 touched points",
            "three" => "3 emitters are seen",
            "ball" => "do not hold the tip",
            "needle" => "off a line",
            _ => "",
        };
        assert!(row.why.contains(words), "{name}: {}", row.why);
    }
    // No word of a refusal names a folder of this very run.
    run(&plan(&text), other.path(), 1).unwrap();
    let lines = [&folder, &other].map(|folder| fs::read_to_string(folder.path().join("operations.csv")).unwrap());
    assert_eq!(lines[0], lines[1]);
}
