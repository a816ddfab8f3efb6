//! Bad input, each kind refused with line and name; and what a good scene becomes.

use std::path::Path;

use super::Model;
use crate::scene::Source;

const GOOD: &str = r#"
title = "two blocks"
units = { length = "mm", stress = "kPa" }
[[materials]]
name = "soft"
law = "neo-hookean"
young = 1.0
poisson = 0.3
[[solids]]
name = "left"
material = "soft"
weight = [0, -0.01]
rectangle = { corner = [0, 0], size = [1, 1], elements = [1, 1] }
[[solids]]
name = "right"
polygon = { vertices = [[1.5, 0], [2.5, 0], [2.5, 1], [1.5, 1]] }
[[walls]]
name = "floor"
normal = [0, 2]
offset = -0.5
[contact]
"#;

fn refusal(text: &str) -> String {
    let source = match Source::parse(text.to_owned(), Path::new("s.toml")) {
        Ok(source) => source,
        Err(error) => return error.to_string(),
    };
    match Model::new(&source.scene) {
        Ok(_) => "accepted".to_owned(),
        Err(invalid) => source.error_at(invalid).to_string(),
    }
}

fn model(text: &str) -> Model {
    let source = Source::parse(text.to_owned(), Path::new("s.toml")).unwrap();
    Model::new(&source.scene).unwrap()
}

/// The line of a scene on which some words stand, from 1.
fn line(text: &str, words: &str) -> usize {
    1 + text.lines().position(|l| l.contains(words)).unwrap()
}

/// Replaces words, and expects all of `said`, with the line of the new words.
fn refused(old: &str, new: &str, said: &[&str]) {
    assert!(GOOD.contains(old), "{old}");
    let text = GOOD.replacen(old, new, 1);
    let error = refusal(&text);
    let end = GOOD.find(old).unwrap() + new.len();
    let at = format!("line {},", 1 + text[..end].matches('\n').count());
    for words in said.iter().chain([&at.as_str()]) {
        assert!(error.contains(words), "{new}: {words:?} is not in: {error}");
    }
}

#[test]
fn a_good_scene_is_what_it_names() {
    let model = model(GOOD);
    assert_eq!(
        (model.solids.len(), model.system.bodies.size(), model.free()),
        (2, 21, 21)
    );
    assert_eq!(model.walls[0].normal.y, 1.0);
    assert!(model.links.is_empty() && model.separated.is_empty());
}

#[test]
fn numbers_are_refused_with_line_and_name() {
    refused(
        "young = 1.0",
        "young = -2.0",
        &["materials.0.young", "material \"soft\"", "-2"],
    );
    refused("young = 1.0", "young = nan", &["materials.0.young", "NaN"]);
    refused(
        "poisson = 0.3",
        "poisson = 0.5",
        &["materials.0.poisson", "0.4999 with mixed = true"],
    );
    refused(
        "poisson = 0.3",
        "poisson = 0.499",
        &["0.499 with plain elements", "mixed = true"],
    );
    refused("weight = [0, -0.01]", "weight = [0, inf]", &["solids.0.weight", "inf"]);
    refused(
        "corner = [0, 0]",
        "corner = [nan, 0]",
        &["solids.0.rectangle.corner", "NaN"],
    );
    refused("size = [1, 1]", "size = [1, -1]", &["solid \"left\"", "height is -1"]);
    refused("normal = [0, 2]", "normal = [0, 0]", &["walls.0.normal", "a direction"]);
    refused("offset = -0.5", "offset = -inf", &["walls.0.offset"]);
    refused("[contact]", "[contact]\nstiffness = -1", &["contact.stiffness"]);
    refused(
        "[contact]",
        "[contact]\nwidths = [0.1, 0.2]",
        &["contact.widths", "a smaller one"],
    );
    refused(
        "[contact]",
        "[contact]\npairs = [[\"left\", \"nobody\"]]",
        &["contact.pairs.0.1", "\"nobody\"", "\"left\""],
    );
    refused("[contact]", "[contact]\npairs = []", &["contact.pairs", "found 0"]);
}

#[test]
fn absurd_sizes_are_refused_before_they_are_made() {
    refused(
        "elements = [1, 1]",
        "elements = [4000000000, 4000000000]",
        &["elements", "1 to 20000"],
    );
    refused(
        "elements = [1, 1]",
        "elements = [20000, 20000]",
        &["400000000 elements", "at most 20000"],
    );
    refused(
        "elements = [1, 1]",
        "elements = [-1, 1]",
        &["solids.0.rectangle.elements"],
    );
    refused("elements = [1, 1]", "elements = [0, 1]", &["found 0"]);
    let many: Vec<String> = (0..2001).map(|k| format!("[{k}, 0]")).collect();
    let text = GOOD.replace(
        "[[1.5, 0], [2.5, 0], [2.5, 1], [1.5, 1]]",
        &format!("[{}]", many.join(",")),
    );
    assert!(refusal(&text).contains("2001 vertices"), "{}", refusal(&text));
    let long = "[contact]\n[[steps]]\nframes = 5000\nmoves = [{ wall = \"floor\", advance = 0 }]";
    let large = GOOD
        .replace("elements = [1, 1]", "elements = [60, 60]")
        .replace("[contact]", long);
    assert!(
        refusal(&large).contains("5000 frames of 29285 unknowns"),
        "{}",
        refusal(&large)
    );
    let more = GOOD.replace("[contact]", &long.replace("5000", "5001"));
    assert!(
        refusal(&more).contains("steps.0.frames: found 5001"),
        "{}",
        refusal(&more)
    );
    refused("[contact]", "[search]\nwatch = 0", &["search.watch", "found 0"]);
    let mut solids = String::new();
    for k in 0..201 {
        solids += &format!("[[solids]]\nname = \"s{k}\"\npolygon = {{ vertices = [[0,0],[1,0],[0,1]] }}\n");
    }
    let error = refusal(&GOOD.replace("[[walls]]", &format!("{solids}[[walls]]")));
    assert!(error.contains("found 203") && error.contains("1 to 200"), "{error}");
}

#[test]
fn names_and_keys_must_be_known() {
    refused("young = 1.0", "yuong = 1.0", &["yuong", "young"]);
    refused(
        "law = \"neo-hookean\"",
        "law = \"hooke\"",
        &["hooke", "st-venant-kirchhoff"],
    );
    refused(
        "material = \"soft\"",
        "material = \"hard\"",
        &["solids.0.material", "\"hard\"", "\"soft\""],
    );
    refused(
        "name = \"right\"",
        "name = \"left\"",
        &["solids.1.name", "a second time"],
    );
    let twice = GOOD.replace(
        "polygon = {",
        "rounded = { centre = [0,0], half_axes = [1,1], elements = [1,1] }\npolygon = {",
    );
    assert!(
        refusal(&twice).contains("with rounded and polygon"),
        "{}",
        refusal(&twice)
    );
    let both = GOOD.replace("polygon = {", "material = \"soft\"\npolygon = {");
    assert!(refusal(&both).contains("polygons are rigid"), "{}", refusal(&both));
    let wall = GOOD.replace("offset = -0.5", "offset = -0.5\nkeeps = [\"left\", \"lift\"]");
    assert!(
        refusal(&wall).contains("walls.0.keeps.1: found \"lift\""),
        "{}",
        refusal(&wall)
    );
    let step = GOOD.replace(
        "[contact]",
        "[contact]\n[[steps]]\nframes = 2\nmoves = [{ solid = \"left\", by = [0, 1] }]",
    );
    assert!(refusal(&step).contains("not driven"), "{}", refusal(&step));
    let link = GOOD.replace(
        "[contact]",
        "[contact]\n[[links]]\nsolid = \"left\"\nat = [0.5, 0.5]\nto = [0, 0]",
    );
    assert!(
        refusal(&link).contains("0.5 away from the boundary"),
        "{}",
        refusal(&link)
    );
}

#[test]
fn polygons_that_cross_or_run_clockwise_are_refused() {
    let good = "[[1.5, 0], [2.5, 0], [2.5, 1], [1.5, 1]]";
    refused(
        good,
        "[[1.5, 0], [2.5, 1], [2.5, 0], [1.5, 1]]",
        &["solid \"right\"", "sides 0 and 2 cross"],
    );
    refused(
        good,
        "[[1.5, 0], [1.5, 1], [2.5, 1], [2.5, 0]]",
        &["solid \"right\"", "counter-clockwise"],
    );
    refused(good, "[[1.5, 0], [2.5, 0], [2.5, nan]]", &["vertices.2", "NaN"]);
    refused(good, "[[1.5, 0], [1.5, 0], [2.5, 1]]", &["vertices 0 and 1 coincide"]);
    refused(good, "[[0, 0], [1, 1]]", &["at least 3"]);
}

/// A unit square of one element, with its lists of nodes and elements replaced.
fn mesh(nodes: &str, elements: &str) -> String {
    let mesh = format!("mesh = {{ nodes = {nodes}, elements = {elements} }}");
    let old = "rectangle = { corner = [0, 0], size = [1, 1], elements = [1, 1] }";
    let text = GOOD.replace(old, &mesh);
    let error = refusal(&text);
    if error != "accepted" {
        assert!(error.contains(&format!("line {},", line(&text, "mesh ="))), "{error}");
        assert!(
            error.contains("solid \"left\"") || error.contains("solids.0.mesh"),
            "{error}"
        );
    }
    error
}

#[test]
fn meshes_are_refused_by_element_and_node() {
    let nodes = "[[0,0],[0.5,0],[1,0],[0,0.5],[0.5,0.5],[1,0.5],[0,1],[0.5,1],[1,1]]";
    assert_eq!(mesh(nodes, "[[0,1,2,3,4,5,6,7,8]]"), "accepted");
    for (nodes, elements, words) in [
        (nodes, "[[2,1,0,5,4,3,8,7,6]]", "element 0 runs clockwise"),
        (
            nodes,
            "[[0,1,2,3,4,5,6,7,9]]",
            "element 0 names node 9; there are 9 nodes",
        ),
        (nodes, "[[0,1,2,3,4,5,6,7,7]]", "names node 7 twice"),
        (nodes, "[[0,1,2,3,4,5,6,7]]", "elements"),
        (nodes, "[]", "found 0"),
        (nodes, "[[0,1,2,3,4,5,6,7,-8]]", "elements"),
        (
            &nodes.replace("[0.5,0.5]", "[0.5,nan]"),
            "[[0,1,2,3,4,5,6,7,8]]",
            "nodes.4",
        ),
        (&nodes.replace("[0.5,0]", "[0.2,0]"), "[[0,1,2,3,4,5,6,7,8]]", "folds"),
        (
            &nodes.replace("]]", "],[3,3]]"),
            "[[0,1,2,3,4,5,6,7,8]]",
            "node 9 belongs to no element",
        ),
    ] {
        let error = mesh(nodes, elements);
        assert!(error.contains(words), "{words}: {error}");
    }
}

const CLOSE: (&str, &str) = (
    "[[1.5, 0], [2.5, 0], [2.5, 1], [1.5, 1]]",
    "[[0.9, 0.2], [1.9, 0.2], [1.9, 0.6], [0.9, 0.6]]",
);

#[test]
fn overlapping_starts_are_refused_with_the_pairs_or_moved_apart() {
    let text = GOOD.replace(CLOSE.0, CLOSE.1);
    let error = refusal(&text);
    assert!(
        error.contains("overlap or touch") && error.contains("\"right\" in \"left\" by 1.000e-1"),
        "{error}"
    );
    for how in ["move", "push"] {
        let text = text.replace("[contact]", &format!("[contact]\noverlaps = \"{how}\""));
        let model = model(&text);
        assert!(!model.separated.is_empty(), "{how}");
        assert!(
            (model.separated[0].depth - 0.1).abs() < 1e-12,
            "{how} {:?}",
            model.separated
        );
        assert!(
            simulation::constraint::overlapping(&model.system.bodies, &model.start).is_empty(),
            "{how}"
        );
        assert_ne!(model.start, model.placed);
    }
    // Without contact solids pass through one another: nothing overlaps.
    assert_eq!(refusal(&text.replace("[contact]", "")), "accepted");
    // A wall counts too, but not one that is exact from the start: it pushes out what is in it.
    let deep = GOOD.replace("offset = -0.5", "offset = 0.5");
    assert!(
        refusal(&deep).contains("\"left\" in \"floor\" by 5.000e-1"),
        "{}",
        refusal(&deep)
    );
    assert_eq!(
        refusal(&deep.replace("[contact]", "[search]\nwalls = \"exact\"")),
        "accepted"
    );
}

#[test]
fn what_is_no_text_or_too_long_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |bytes: &[u8]| {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, bytes).unwrap();
        organs::read(&path).unwrap_err().to_string()
    };
    let error = file(b"title = \"a\"\nunits = \"\xff\"\n");
    assert!(error.contains("line 2") && error.contains("not UTF-8"), "{error}");
    let error = file(&vec![b'#'; (4 << 20) + 1]);
    assert!(error.contains("4194305 bytes; at most 4194304"), "{error}");
    assert!(
        organs::read(Path::new("/no/such.toml"))
            .unwrap_err()
            .to_string()
            .contains("/no/such.toml")
    );
    for text in ["", "[", "title = 1", "title = \"a\""] {
        assert!(refusal(text).contains("line 1"), "{text}: {}", refusal(text));
    }
}
