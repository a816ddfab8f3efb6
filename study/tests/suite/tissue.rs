//! Organs that the tube moves: what is told of them, and what cannot be.

use std::fs;
use std::path::{Path, PathBuf};

use study::plan::{Plan, PlanError};
use study::record::Row;
use study::run::run;

use crate::support::QUICK;

fn config() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config")
}

/// A study of two operations beside `tissue-kidney.toml`, with this table.
fn planned(folder: &Path, tissue: &str) -> Result<Plan, PlanError> {
    let text = format!("seed = 2\noperations = 2\n{QUICK}[[stratum]]\nname = \"a\"\ntissue = {{ {tissue} }}\n");
    Plan::of_texts([(folder.join("study.toml").as_path(), text.as_str())])
}

const BOTH: &str =
    "scene = \"tissue-kidney.toml\", aimed = \"under the kidney\", told = \"in the lower pole\", rate_hz = 6.0";

/// The tube of the shipped scene presses the kidney on its last centimetres: the place in it has gone, the picture at rest is off by that,
/// and the model knows most of it.
#[test]
fn a_place_in_an_organ_is_told_where_the_tube_has_moved_it() {
    let folder = tempfile::tempdir().unwrap();
    run(&planned(&config(), BOTH).unwrap(), folder.path(), 2).unwrap();
    let text = fs::read_to_string(folder.path().join("operations.csv")).unwrap();
    let rows: Vec<Row> = text.lines().skip(1).map(|line| Row::read(line).unwrap()).collect();
    assert_eq!(rows.len(), 2);
    for row in &rows {
        assert_eq!(
            (row.target.as_str(), row.model.as_str()),
            ("in-the-lower-pole", "settled"),
            "{row:?}"
        );
        let ([moved_mm, _], [off_mm, radius_mm, nees, shown_mm]) = (row.links[6], row.model_numbers);
        assert!((0.5..20.0).contains(&moved_mm) && off_mm < moved_mm, "{row:?}");
        assert!(radius_mm > 0.0 && nees > 0.0, "{row:?}");
        // Errors of a picture differ by no more than the places that it shows the target at.
        assert!((row.tre_mm - shown_mm).abs() <= moved_mm + off_mm + 1e-9, "{row:?}");
    }
    // Each has organs of its own.
    assert_ne!(rows[0].links[6][0], rows[1].links[6][0]);
}

#[test]
fn a_study_is_another_with_another_organ() {
    let folder = tempfile::tempdir().unwrap();
    let copy = |name: &str| {
        let to = folder.path().join(name);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(config().join(name), &to).unwrap();
        to
    };
    let scene = fs::read_to_string(copy("tissue-kidney.toml")).unwrap();
    let organs = scene
        .lines()
        .find_map(|line| line.strip_prefix("organs = \"")?.split('"').next())
        .unwrap();
    let organs = copy(organs);
    let hash = || planned(folder.path(), BOTH).unwrap().hash;
    let before = hash();
    assert_eq!(
        before,
        planned(&config(), BOTH).unwrap().hash,
        "the same files elsewhere"
    );
    let text = fs::read_to_string(&organs).unwrap();
    fs::write(&organs, text.replacen("poisson = 0.49", "poisson = 0.48", 1)).unwrap();
    assert_ne!(before, hash());
}

#[test]
fn organs_that_cannot_be_moved_are_refused_with_their_place() {
    for (tissue, words) in [
        ("scene = \"none.toml\"", "tissue.scene: found \"none.toml\""),
        ("scene = \"demo.toml\"", "a scene with a table [tissue] is needed"),
        (
            "aimed = \"under the kidney\"",
            "tissue.scene must say which scene has that target",
        ),
        (
            "scene = \"tissue-kidney.toml\", aimed = \"spleen\"",
            "tissue.aimed: found Some(\"spleen\"); a target of the scene: ",
        ),
        (
            "scene = \"tissue-kidney.toml\", told = \"spleen\"",
            "tissue.told: found",
        ),
        // The shipped way to the aorta is longer than a hand steers about its entry.
        (
            "scene = \"tissue.toml\", aimed = \"beside the aorta\"",
            "20 to 120 mm before what is aimed at",
        ),
        (
            "scene = \"tissue-kidney.toml\", rate_hz = 0.0",
            "tissue.rate_hz: found 0.0; 5 to 60 is allowed",
        ),
    ] {
        let why = planned(&config(), tissue).unwrap_err().to_string();
        assert!(why.contains(words) && why.contains("stratum \"a\""), "{tissue}: {why}");
    }
    let both = format!("{BOTH} }}\ntargets = [\"pre-aortic\"]\nbump = {{ mm = 3.0");
    let why = planned(&config(), &both).unwrap_err().to_string();
    assert!(
        why.contains("targets: found \"tissue-kidney.toml\"; not beside tissue.scene"),
        "{why}"
    );
    // Stated: a study of organs that breathe. True: while the tube pushed them they did not.
    let both = format!("{BOTH} }}\nbreathing = {{ mm = 10.0");
    let why = planned(&config(), &both).unwrap_err().to_string();
    assert!(
        why.contains("breathing.mm: found \"tissue-kidney.toml\"; not beside tissue.scene"),
        "{why}"
    );
}

/// Stated: moved by 0 mm. True: nobody knows, as the target lies in no organ.
#[test]
fn a_target_in_no_organ_is_not_told_as_one_that_did_not_move() {
    let folder = tempfile::tempdir().unwrap();
    let plan = planned(
        &config(),
        "scene = \"tissue-kidney.toml\", aimed = \"under the kidney\", rate_hz = 6.0",
    );
    let why = run(&plan.unwrap(), folder.path(), 1).unwrap_err().to_string();
    assert!(
        why.contains("tissue.told: target \"under-the-kidney\" lies in no organ of the scene"),
        "{why}"
    );
}
