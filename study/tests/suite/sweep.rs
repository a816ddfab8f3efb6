//! A sweep, whole: its strata are operated, and the report tells what each dial does.

use std::fs;

use study::report;
use study::run::run;

use crate::support::{QUICK, plan};

#[test]
fn the_report_of_a_sweep_tells_what_dials_do() {
    let text = format!(
        "operations = 2\n{QUICK}targets = [\"pre-aortic\"]\n[sweep]\nlocalizer.across_mm = [0.05, 0.2]\nmarker.emitters = [18, 32]"
    );
    let (plan, folder) = (plan(&text), tempfile::tempdir().unwrap());
    let done = run(&plan, folder.path(), 2).unwrap();
    report::write(folder.path(), &plan, &done.rows, &[]).unwrap();
    let tables = fs::read_to_string(folder.path().join("tables.md")).unwrap();
    for part in [
        "## sweep: what each dial does",
        "| localizer.across_mm | 0.2 | ",
        "| localizer.across_mm 0.05 to 0.2 | marker.emitters 18 to 32 | ",
        "## sweep: all combinations, the least error first",
        "## Was the predicted error right?",
    ] {
        assert!(tables.contains(part), "{part}: {tables}");
    }
    // The predicted radius follows from the scene: four times the noise across, and nearly as much of it in the end.
    let line = tables
        .lines()
        .find(|line| line.starts_with("| localizer.across_mm | 0.2 | "))
        .unwrap();
    let times: f64 = line
        .split(" | ")
        .nth(5)
        .and_then(|cell| cell.split(' ').next())
        .unwrap()
        .parse()
        .unwrap();
    assert!((1.5..4.0).contains(&times), "{line}");
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    // The budget, and a curve for each dial; no chart of strata that are in the sweep.
    assert_eq!(page.matches("data:image/png;base64,").count(), 3);
    assert!(folder.path().join("sweep-marker.emitters.png").exists());
    assert!(!folder.path().join("tre.png").exists());
    assert!(!page.contains("On its way"));
    report::write(folder.path(), &plan, &done.rows[..3], &[]).unwrap();
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("On its way: 3 of 8 lines are here."));
}
