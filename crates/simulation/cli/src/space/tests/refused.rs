//! What is refused, by name, with line and key.

use nalgebra::Matrix3;

use super::super::{Space, planned};
use super::READ;
use super::maps::{SCENE, folder};

fn refusal(scene: &str, skew: f64) -> String {
    let (_folder, path) = folder(&Matrix3::identity(), skew);
    match Space::new(scene.to_owned(), &path, None, READ) {
        Ok(space) => format!("accepted: {}", space.described()),
        Err(error) => error,
    }
}

/// Replaces words, and expects all of `said` and the line of the new words.
fn refused(old: &str, new: &str, said: &[&str]) {
    assert!(SCENE.contains(old), "{old}");
    let error = refusal(&SCENE.replacen(old, new, 1), 0.0);
    println!("{error}");
    for words in said.iter().chain([&"line "]) {
        assert!(error.contains(words), "{new}: {words:?} is not in: {error}");
    }
}

#[test]
fn what_the_label_map_does_not_have_is_named() {
    refused(
        "label = 1",
        "label = 2",
        &["organs.0.label", "2, which no voxel has", "1, 3"],
    );
    refused(
        "labels = [3]",
        "labels = [3, 9]",
        &["rigid.0.labels.1", "9, which no voxel has"],
    );
    let tied = "within = 0.5\nkind = \"tied\"\nyoung = 1.0\nmargin = 1.0";
    refused(
        "within = 4.0\nkind = \"fixed\"",
        tied,
        &["attachments.0.within", "no point of the surface of \"ball\"", "floor"],
    );
    refused("smoothing = 3.0", "smoothing = 60.0", &["organs.0.smoothing"]);
    refused("side = 12.0", "side = 0.5", &["organs.0.cubes", "more than 20000"]);
    let error = refusal(SCENE, 0.01);
    assert!(
        error.contains("space.labels") && error.contains("not orthogonal") && error.contains("axis [0, 1]"),
        "{error}"
    );
}

#[test]
fn a_file_that_is_not_there_says_what_to_do() {
    refused(
        "ball.nii",
        "other.nii",
        &["space.labels", "other.nii", "--labels FILE", "the test writes it"],
    );
    let (folder, path) = folder(&Matrix3::identity(), 0.0);
    let scene = SCENE.replace("ball.nii", "other.nii");
    // Another one does, wherever it lies.
    assert!(Space::new(scene, &path, Some(&folder.path().join("ball.nii")), READ).is_ok());
    refused("ball.nii", "ball.toml", &["space.labels"]);
}

#[test]
fn ways_that_are_none_are_named() {
    refused(
        "entry = [10.0, -60.0, 31.0]",
        "entry = [10.0, -30.0, 31.0]",
        &["tube.entry", "starts inside \"ball\""],
    );
    refused(
        "entry = [10.0, -60.0, 31.0]\ntarget = [10.0, -20.0, 31.0]",
        "entry = [10.0, -60.0, 131.0]\ndirection = [0, 1, 0]",
        &["touches no organ"],
    );
    refused("step = 2.0", "step = 3.0", &["tube.step", "3 mm", "less than 3 mm"]);
    refused(
        "target = [10.0, -20.0, 31.0]",
        "target = [10.0, -60.0, 31.0]",
        &["tube.target", "no direction"],
    );
    refused("target = [10.0, -20.0, 31.0]", "", &["neither target nor direction"]);
    refused("diameter = 12.0", "diameter = 1.0\nlength = 90", &["tube.step"]);
    let thin = SCENE
        .replace("diameter = 12.0", "diameter = 2.0")
        .replace("step = 2.0", "step = 0.4");
    let error = refusal(&thin, 0.0);
    assert!(
        error.contains("organs.0.cubes") && error.contains("points of the surface of \"ball\""),
        "{error}"
    );
}

#[test]
fn what_holds_nothing_or_twice_is_named() {
    let bare = SCENE.replace(
        "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 4.0\nkind = \"fixed\"",
        "",
    );
    let bare = bare.replace("[surroundings]\nyoung = 1e-3\nmargin = 20.0\ncorridor = 8.0", "");
    let error = refusal(&bare, 0.0);
    assert!(
        error.contains("organs.0") && error.contains("which nothing holds"),
        "{error}"
    );
    refused(
        "to = [\"floor\"]",
        "to = [\"wall\"]",
        &["attachments.0.to.0", "\"wall\"", "\"floor\""],
    );
    refused(
        "labels = [3]",
        "labels = [1]",
        &["rigid.0.labels.0", "\"ball\" already"],
    );
    refused(
        "kind = \"fixed\"",
        "kind = \"tied\"",
        &["attachments.0.young", "nothing"],
    );
    refused(
        "kind = \"fixed\"",
        "kind = \"fixed\"\nyoung = 1.0",
        &["attachments.0.young", "kind = \"tied\""],
    );
}

#[test]
fn unknown_keys_wrong_types_and_ranges_are_named() {
    refused("smoothing = 3.0", "smooth = 3.0", &["smooth", "unknown field"]);
    refused(
        "[surroundings]",
        "[sliding]\nwith = [\"floor\"]\n[surroundings]",
        &["sliding", "unknown field"],
    );
    refused("label = 1", "label = \"1\"", &["organs.0.label"]);
    refused("label = 1", "label = 70000", &["label"]);
    refused("label = 1", "label = 0", &["organs.0.label"]);
    refused("law = \"neo-hookean\"", "law = \"rubber\"", &["rubber", "neo-hookean"]);
    refused("young = 0.01", "young = -0.01", &["organs.0.young"]);
    refused("poisson = 0.45", "poisson = 0.5", &["organs.0.poisson", "0.4999"]);
    refused("poisson = 0.45", "poisson = nan", &["organs.0.poisson"]);
    refused(
        "levels = 1",
        "levels = 2",
        &["organs.0.cubes.within", "as many distances as levels"],
    );
    refused("stress = \"N/mm2\"", "stress = \"kPa\"", &["units.stress", "N/mm2"]);
    refused(
        "entry = [10.0, -60.0, 31.0]",
        "entry = [10.0, inf, 31.0]",
        &["tube.entry"],
    );
    // Without the map the same is refused, and the rest is said to be open.
    assert!(
        planned(SCENE.to_owned(), std::path::Path::new("s.toml"))
            .unwrap()
            .contains("the label map is not read")
    );
    assert!(
        planned(
            SCENE.replace("young = 0.01", "young = 0"),
            std::path::Path::new("s.toml")
        )
        .is_err()
    );
}
