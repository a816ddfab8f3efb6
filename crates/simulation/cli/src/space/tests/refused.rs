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
    refused(
        "side = 12.0",
        "side = 0.5",
        &["organs.0.cubes", "unknowns at the least", "at most 150000"],
    );
    let error = refusal(SCENE, 0.01);
    assert!(
        error.contains("space.labels") && error.contains("not orthogonal") && error.contains("axis [0, 1]"),
        "{error}"
    );
}

#[test]
fn targets_that_are_none_are_named() {
    let with = |target: &str| refusal(&format!("{SCENE}\n[[targets]]\n{target}\n"), 0.0);
    let said = |target: &str, words: &[&str]| {
        let error = with(target);
        println!("{error}");
        for words in words.iter().chain([&"line "]) {
            assert!(error.contains(words), "{target}: {words:?} is not in: {error}");
        }
    };
    // The ball's surface is 20 mm from its middle, and this place 30 mm.
    said(
        "name = \"far\"\nat = [40.0, -20.0, 30.0]",
        &[
            "targets.0.at",
            "[40, -20, 30], in no organ",
            "some 10.",
            "mm from \"ball\", the nearest",
        ],
    );
    said(
        "name = \"far\"\nat = [40.0, nan, 30.0]",
        &["targets.0.at", "three numbers"],
    );
    said(
        "name = \"in\"\nat = [10.0, -20.0, 30.0]\norgan = \"liver\"",
        &["targets.0.organ", "\"liver\"", "\"ball\""],
    );
    said("name = \"\"\nat = [10.0, -20.0, 30.0]", &["targets.0.name"]);
    said("name = \"in\"\nat = [10.0, -20.0]", &["targets"]);
    said(
        "name = \"in\"\nat = [10.0, -20.0, 30.0]\n[[targets]]\nname = \"in\"\nat = [10.0, -20.0, 31.0]",
        &["targets.1.name", "a second time"],
    );
    let many: String = (0..65)
        .map(|k| format!("[[targets]]\nname = \"{k}\"\nat = [10.0, -20.0, 30.0]\n"))
        .collect();
    assert!(refusal(&format!("{SCENE}\n{many}"), 0.0).contains("0 to 64"));
    let two = two_organs();
    let error = refusal(
        &format!("{two}\n[[targets]]\nname = \"in\"\nat = [10.0, -20.0, 30.0]\norgan = \"slab\""),
        0.0,
    );
    assert!(
        error.contains("targets.0.at")
            && error.contains("a place in \"ball\"")
            && error.contains("a place in \"slab\", its organ"),
        "{error}"
    );
    assert!(
        with("name = \"in\"\nat = [10.0, -20.0, 30.0]\norgan = \"ball\"")
            .contains("target     in at (10.00, -20.00, 30.00), in ball")
    );
}

/// The scene with the layer behind the ball as an organ of its own.
fn two_organs() -> String {
    let from = SCENE.find("[[rigid]]").unwrap()..SCENE.find("[surroundings]").unwrap();
    let mut scene = SCENE.to_owned();
    scene.replace_range(
        from,
        "[[organs]]\nname = \"slab\"\nlabel = 3\nlaw = \"neo-hookean\"\nyoung = 0.01\npoisson = 0.45\nsmoothing = 2.0\ncubes = { side = 9.0 }\n\n",
    );
    scene
}

#[test]
fn spreads_that_are_none_are_named() {
    for (spread, said) in [
        ("0", "at most 1"),
        ("-0.1", "-0.1"),
        ("1.1", "1.1"),
        ("nan", "NaN"),
        ("inf", "inf"),
    ] {
        refused(
            "young = 0.01",
            &format!("young = 0.01\nyoung_spread = {spread}"),
            &["organs.0.young_spread", said, "logarithm"],
        );
        refused(
            "young = 1e-3",
            &format!("young = 1e-3\nyoung_spread = {spread}"),
            &["surroundings.young_spread", said],
        );
        refused(
            "kind = \"fixed\"",
            &format!("kind = \"tied\"\nyoung = 1e-3\nmargin = 5.0\nyoung_spread = {spread}"),
            &["attachments.0.young_spread", said],
        );
    }
    for spread in ["0", "-0.01", "0.0500", "nan"] {
        refused(
            "poisson = 0.45",
            &format!("poisson = 0.45\npoisson_spread = {spread}"),
            &["organs.0.poisson_spread", "beside a ratio of 0.45", "at most 0.4999"],
        );
    }
    refused(
        "kind = \"fixed\"",
        "kind = \"fixed\"\nyoung_spread = 0.3",
        &["attachments.0.young_spread", "kind = \"fixed\""],
    );
    refused(
        "margin = 20.0",
        "margin = 20.0\npoisson_spread = 0.1",
        &["poisson_spread", "unknown field"],
    );
}

#[test]
fn fields_and_digests_that_are_none_are_named() {
    for law in ["linear", "st-venant-kirchhoff"] {
        let scene =
            format!("{SCENE}\n[output]\nfield = \"von-mises\"\n").replace("\"neo-hookean\"", &format!("{law:?}"));
        let error = refusal(&scene, 0.0);
        assert!(
            error.contains("output.field") && error.contains(law) && error.contains("line "),
            "{error}"
        );
    }
    for digest in ["abc", "", &"g".repeat(64), &"a".repeat(65)] {
        refused(
            "obtain =",
            &format!("labels_sha256 = \"{digest}\"\nobtain ="),
            &["space.labels_sha256", "64 hexadecimal digits"],
        );
    }
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
    let contact = |words: &str| {
        format!("[[contacts]]\norgan = \"ball\"\nwith = [\"floor\"]\nball = 3.0\n{words}\n[surroundings]")
    };
    refused(
        "[surroundings]",
        &contact("friction = 0.1"),
        &["friction", "unknown field"],
    );
    for (old, new, key) in [
        ("\"ball\"", "\"liver\"", "contacts.0.organ"),
        ("[\"floor\"]", "[\"wall\"]", "contacts.0.with.0"),
        ("[\"floor\"]", "[]", "contacts.0.with"),
        ("ball = 3.0", "ball = 0.0", "contacts.0.ball"),
        ("ball = 3.0", "ball = 40.0", "contacts.0.ball"),
        ("ball = 3.0", "ball = 3.0\nsmoothing = -1.0", "contacts.0.smoothing"),
        ("ball = 3.0", "ball = 3.0\nsmoothing = 20.0", "contacts.0.with"),
    ] {
        refused("[surroundings]", &contact("").replace(old, new), &[key]);
    }
    refused("label = 1", "label = \"1\"", &["organs.0.label"]);
    refused("label = 1", "label = 70000", &["label"]);
    refused("label = 1", "label = 0", &["organs.0.label"]);
    refused("law = \"neo-hookean\"", "law = \"rubber\"", &["rubber", "neo-hookean"]);
    refused(
        "law = \"neo-hookean\"",
        "law = \"ogden\"",
        &["organs.0.ogden", "nothing"],
    );
    for (terms, found) in [
        ("[]", "0"),
        ("[[1.0, 2.0], [1.0, 3.0], [1.0, 4.0], [1.0, 5.0]]", "4"),
        ("[[1.0, 2.0], [1.0, -3.0]]", "exponent -3"),
        ("[[nan, 2.0]]", "NaN"),
        ("[[1.0, 30.5]]", "30.5"),
        ("[[1.0, inf]]", "inf"),
    ] {
        let law = format!("law = \"ogden\"\nogden = {terms}");
        refused(
            "law = \"neo-hookean\"",
            &law,
            &["organs.0.ogden", found, "exponents from -30 to 30"],
        );
    }
    refused(
        "law = \"neo-hookean\"",
        "law = \"neo-hookean\"\nogden = [[1.0, 2.0]]",
        &["organs.0.ogden", "law = \"ogden\""],
    );
    refused("law = \"neo-hookean\"", "ogden = [[1.0, 2.0]]", &["organs.0.ogden"]);
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
