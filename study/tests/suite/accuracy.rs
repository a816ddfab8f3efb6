//! Twenty operations of each setting: the predicted error keeps its word where it is right, and is found out where it is not.

use std::sync::OnceLock;

use crate::support::plan;
use study::LINKS;
use study::record::Row;
use study::report::summary::Summary;
use study::run::run;

/// `config/study/planted.toml`, done once.
fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let text = include_str!("../../../config/study/planted.toml");
        let folder = tempfile::tempdir().unwrap();
        let done = run(&plan(text), folder.path(), 2).unwrap();
        study::report::write(folder.path(), &plan(text), &done.rows, &[]).unwrap();
        let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
        assert_eq!(page.matches("NOT KEPT").count(), 3, "the page names what is not right");
        assert_eq!(page.matches("data:image/png;base64,").count(), 3);
        done.rows
    })
}

fn summary(stratum: &str) -> Summary {
    let rows: Vec<&Row> = rows().iter().filter(|row| row.stratum == stratum).collect();
    assert_eq!(rows.len(), 100, "20 operations at 5 targets");
    // As in config/study/small.toml.
    Summary::of(stratum, &rows, 5.0)
}

/// Were the share that is covered below 0.7, one study of 20 operations in 60 would keep its word all the same (binomial, 18 of
/// 20 or more have intervals that reach 0.95: 3.5 %); at 0.95 one in 40 would not.
#[test]
fn what_is_stated_right_keeps_its_word() {
    let s = summary("as-stated");
    assert_eq!((s.operations, s.approached), (20, 20));
    assert_eq!(s.keeps_its_word(), Some(true), "{:?}", s.covered);
    // Within what 95 of 100 studies with right covariances find.
    let (nees, [low, high]) = s.nees;
    assert!((low..=high).contains(&nees), "{:?}", s.nees);
    // A root mean square of 60 independent numbers at least is good to 1 / sqrt(2 60) = 9 %; three of these.
    for link in [0, 2, 3, 5] {
        let [found, predicted] = s.links[link];
        assert!(
            (found / predicted - 1.0).abs() < 0.3,
            "{}: {found} {predicted}",
            LINKS[link]
        );
    }
}

#[test]
fn a_planted_error_is_found_in_its_link_and_breaks_the_word() {
    for (stratum, planted, others) in [("tool-off", 5, [0, 2, 3]), ("registration-off", 0, [2, 3, 5])] {
        let (s, right) = (summary(stratum), summary("as-stated"));
        assert!(
            s.keeps_its_word() == Some(false) && s.nees.0 > s.nees.1[1],
            "{stratum}: {:?} {:?}",
            s.covered,
            s.nees
        );
        let [found, predicted] = s.links[planted];
        // 2 mm, with what the link errs by besides: at most its own error, to either side.
        assert!((found - 2.0).abs() < 3.0 * predicted, "{stratum}: {found}");
        for link in others {
            assert!(
                (s.links[link][0] / right.links[link][0] - 1.0).abs() < 0.3,
                "{stratum}: {}",
                LINKS[link]
            );
        }
    }
}

#[test]
fn deviations_that_are_stated_half_as_large_break_the_word() {
    let (s, right) = (summary("understated"), summary("as-stated"));
    assert_eq!(s.keeps_its_word(), Some(false), "{:?}", s.covered);
    assert!(s.nees.0 > s.nees.1[1], "{:?}", s.nees);
    assert!(
        (s.predicted_mm / right.predicted_mm - 0.5).abs() < 0.05,
        "{} {}",
        s.predicted_mm,
        right.predicted_mm
    );
}

/// Errors of links add up to the whole but for products of two of them: 3 mm by 0.01 rad.
#[test]
fn the_links_explain_the_whole_error() {
    let rests = rows().iter().map(|row| row.rest_mm);
    let largest = rests.fold(0.0, f64::max);
    assert!(largest < 0.03, "{largest}");
}
