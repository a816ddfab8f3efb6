//! What is lost on the way is counted, and why; and what a check refuses is judged.

use std::fs;

use bus::message::Lost;
use study::record::Ended;
use study::report;
use study::run::run;

use crate::support::{QUICK, plan};

/// A hand before the marker for most of the time: pictures without a pose, each with its reason.
#[test]
fn a_hand_before_the_marker_loses_pictures_and_each_has_its_reason() {
    let text = format!(
        "seed = 2\noperations = 2\n{QUICK}targets = [\"pre-aortic\", \"iliac-left\"]\nmarker = {{ emitters = 12 }}\n\
         [[stratum]]\nname = \"clear\"\n[[stratum]]\nname = \"a\"\nocclusion = {{ share = 0.9, every_s = 0.5 }}\n"
    );
    let (plan, folder) = (plan(&text), tempfile::tempdir().unwrap());
    let done = run(&plan, folder.path(), 2).unwrap();
    for row in &done.rows {
        assert_eq!(row.reasons.iter().sum::<u64>(), row.pictures[1], "{row:?}");
    }
    let lost = |name: &str| {
        let rows = done.rows.iter().filter(|row| row.stratum == name);
        rows.fold([0; 13], |mut all, row| {
            all.iter_mut().zip(row.reasons).for_each(|(all, one)| *all += one);
            all
        })
    };
    assert_eq!(lost("clear"), [0; 13]);
    let hidden = lost("a");
    assert!(hidden.iter().sum::<u64>() > 0, "{:?}", done.rows);
    // It never hides all of the tool's marker, and of twelve emitters leaves too few; the patient's marker is not behind it.
    for (reason, count) in Lost::ALL.into_iter().zip(hidden) {
        assert_eq!(count > 0, reason == Lost::TooFew, "{reason:?} {count}");
    }
    report::write(folder.path(), &plan, &done.rows, &[]).unwrap();
    for (file, part) in [
        ("tables.md", "## Pictures without a pose"),
        ("report.html", "<h2>Pictures without a pose</h2>"),
    ] {
        let text = fs::read_to_string(folder.path().join(file)).unwrap();
        assert!(text.contains(part), "{text}");
    }
    let tables = fs::read_to_string(folder.path().join("tables.md")).unwrap();
    for (reason, count) in Lost::ALL.into_iter().zip(hidden).filter(|(_, count)| *count > 0) {
        let line = format!("| a | {} | {count} | ", reason.words());
        assert!(tables.contains(&line), "{line} {tables}");
    }
}

/// 10 mm at the marker: what the check refuses is truly off, and is told with the error that the tool would have had.
#[test]
fn a_marker_that_was_knocked_before_the_check_is_refused_and_rightly_so() {
    let text = format!(
        "seed = 5\noperations = 4\n{QUICK}targets = [\"pre-aortic\"]\n[[stratum]]\nname = \"knocked\"\nbump = {{ share = 1.0, mm = 10.0 }}\n"
    );
    let (plan, folder) = (plan(&text), tempfile::tempdir().unwrap());
    let done = run(&plan, folder.path(), 2).unwrap();
    let (before, after): (Vec<_>, Vec<_>) = done.rows.iter().partition(|row| row.bump == "before");
    assert!(!before.is_empty() && !after.is_empty(), "{:?}", done.rows);
    for row in before {
        assert_eq!(
            (row.ended, row.step.as_str(), row.check.as_str()),
            (Ended::Refused, "check", "fail"),
            "{row:?}"
        );
        assert_eq!(row.right, Some(true), "{row:?}");
        // A shift of 10 mm, and what the registration errs by.
        assert!(
            (row.links[1][0] - 10.0).abs() < 1e-9 && (row.tre_mm - 10.0).abs() < 3.0,
            "{row:?}"
        );
        assert!(
            !row.why.is_empty() && row.pictures == [0; 2] && row.miss_mm.is_nan(),
            "{row:?}"
        );
    }
    for row in after {
        assert!(
            row.ended != Ended::Refused && row.right.is_none() && row.check != "fail",
            "{row:?}"
        );
    }
}
