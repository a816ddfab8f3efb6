//! What is of two runs is replayed by nobody.

use bus::message::VolumeHash;

use super::*;
use crate::read::info::info;
use crate::read::verify::verify;
use crate::report::{Wanted, report};
use crate::wire::schema::RunFacts;

/// The recording of one run, with a second record of it and maybe another scene, in a folder.
fn written(change: impl Fn(RunFacts) -> RunFacts, scene: Option<&str>) -> (tempfile::TempDir, PathBuf) {
    let known = RunFacts {
        volume_hash: Some(VolumeHash([0xab; 32])),
        ..testing::facts()
    };
    let mut log = testing::log(2, 5);
    log.facts(&known).unwrap();
    log.facts(&change(known)).unwrap();
    scene.map_or(Ok(()), |text| log.scene(text, 0)).unwrap();
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, log.finish().unwrap().into_inner()).unwrap();
    (tmp, path)
}

/// What verifying finds, and why it is not replayed, by the index and by every message.
fn said(change: impl Fn(RunFacts) -> RunFacts, scene: Option<&str>) -> (Vec<String>, [Option<String>; 2]) {
    let (_tmp, path) = written(change, scene);
    let why = [facts(&path), facts_of_all(&path)].map(|found| found.err().map(|error| error.to_string()));
    (verify(&path).unwrap().findings, why)
}

/// A pose of one patient was drawn in the CT of another, and the file was called whole.
#[test]
fn a_recording_of_two_runs_is_refused_by_name() {
    // More becomes known as a run goes on.
    let (found, why) = said(
        |facts| RunFacts {
            registration_id: Some(7),
            ..facts
        },
        None,
    );
    assert_eq!((found, why), (vec![], [None, None]));
    type Change = fn(RunFacts) -> RunFacts;
    let changes: [(&str, Change); 3] = [
        ("name \"other\", and one before it \"demo\"", |facts| RunFacts {
            name: "other".to_owned(),
            ..facts
        }),
        ("epoch_ns \"9\", and one before it \"123456\"", |facts| RunFacts {
            epoch_ns: 9,
            ..facts
        }),
        ("volume_hash \"cdcd", |facts| RunFacts {
            volume_hash: Some(VolumeHash([0xcd; 32])),
            ..facts
        }),
    ];
    for (words, change) in changes {
        let (found, why) = said(change, None);
        assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
        assert!(
            why.iter().flatten().filter(|why| why.contains(words)).count() == 2,
            "{why:?}"
        );
    }
}

/// The second took the place of the run's own.
#[test]
fn two_scenes_of_one_recording_are_refused_by_name() {
    let (found, why) = said(|facts| facts, Some("seed = 1\n"));
    assert_eq!((found, why), (vec![], [None, None]));
    let (found, why) = said(|facts| facts, Some("seed = 2\n"));
    assert!(
        found.len() == 1 && found[0].contains("two scenes: an attached scene.toml"),
        "{found:?}"
    );
    assert!(
        why.iter().flatten().filter(|why| why.contains("two scenes")).count() == 2,
        "{why:?}"
    );
}

/// Both told of the last run as if the file were of no other.
#[test]
fn info_and_report_of_two_runs_say_so_in_the_same_words() {
    let other = |facts| RunFacts { epoch_ns: 9, ..facts };
    type Change<'a> = &'a dyn Fn(RunFacts) -> RunFacts;
    let of_two: [(Change<'_>, Option<&str>); 2] = [(&other, None), (&|facts| facts, Some("seed = 2\n"))];
    for (change, scene) in of_two {
        let (tmp, path) = written(change, scene);
        let words = &verify(&path).unwrap().findings[0];
        let told = info(&path).unwrap().to_string();
        assert!(told.contains(&format!("NOT OF ONE RUN: {words}")), "{told}");
        let page = tmp.path().join("report.html");
        let refused = report(&path, &page, Wanted::default()).unwrap_err().to_string();
        assert!(refused.contains(words) && !page.exists(), "{refused}");
    }
    let (tmp, path) = written(
        |facts| RunFacts {
            registration_id: Some(7),
            ..facts
        },
        Some("seed = 1\n"),
    );
    assert_eq!(info(&path).unwrap().of_two_runs, None);
    report(&path, &tmp.path().join("report.html"), Wanted::default()).unwrap();
}
