//! What held while the run navigated, however often it changed.

use bus::message::Workflow;

use super::*;

/// A recording whose run is NAVIGATING with these flags, one after the other.
fn navigated(flags: impl IntoIterator<Item = u32>) -> Rig {
    let mut log = testing::log(0, 0);
    poses(&mut log, 0..60, |_| None);
    for (n, flags) in (0..).zip(flags) {
        let (t_ns, stage_word) = (1_000_000 * n, "NAVIGATING".to_owned());
        let stage = (0..16).find(|stage| {
            let workflow = Workflow {
                stage: *stage,
                ..Workflow::default()
            };
            workflow.stage().is_some_and(|stage| stage.word() == stage_word)
        });
        let workflow = proto::Workflow {
            t_ns,
            stage: stage.unwrap(),
            flags,
            stage_word,
        };
        log.put(Entry::Workflow(&workflow)).unwrap();
    }
    Rig::of(ended(log))
}

/// Only the first 300 changes are listed, and only these were looked at: what came later was "passed".
#[test]
fn what_the_run_navigated_without_is_told_however_late_it_came() {
    let fine = Workflow::CONFIRMED;
    let often = || (0..302).map(|n| fine | if n % 2 == 0 { Workflow::SIGHT } else { 0 });
    let (page, facts) = navigated(often()).said();
    assert!(page.contains("confirmed by a person. Check of the registration: passed."));
    assert!(!words(&facts).contains(&"NOT CHECKED"));
    for (flag, word, said) in [
        (
            fine | Workflow::NOT_CHECKED,
            "NOT CHECKED",
            "registration: NOT CHECKED for some",
        ),
        (
            fine | Workflow::CHECK_FAILED,
            "CHECK FAILED",
            "registration: FAILED for some",
        ),
        (
            fine | Workflow::BUMPED,
            "MARKER PUSHED",
            "registration: FAILED for some",
        ),
        (
            fine | Workflow::REJECTED,
            "IDENTITY REJECTED",
            "it is: REJECTED by a person",
        ),
        (0, "IDENTITY NOT CONFIRMED", "it is: skipped for some"),
        (fine | Workflow::RESEARCH, "RESEARCH", "passed."),
    ] {
        let (page, facts) = navigated(often().chain([flag])).said();
        assert!(
            words(&facts).contains(&word) && page.contains(said),
            "{word}: {:?}",
            words(&facts)
        );
    }
}
