//! Studies that cannot be are refused by file, stratum and key.

use std::path::Path;

use crate::support::plan;
use study::plan::{Beads, Display, Plan};

fn refusal(text: &str) -> String {
    Plan::of_texts([(Path::new("s.toml"), text)]).unwrap_err().to_string()
}

fn of(dials: &str) -> String {
    refusal(&format!("[[stratum]]\nname = \"a\"\n{dials}\n"))
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let line = "beads = { at_mm = [[0, -90, 0], [0, -90, 50], [0, -90, 100]] }";
    for (dials, words) in [
        (
            "targets = []",
            "stratum \"a\": targets: found []; an operation needs a target",
        ),
        (
            "targets = [\"spleen\"]",
            "targets: found \"spleen\"; each of para-aortic-left, pre-aortic",
        ),
        ("targets = [\"pre-aortic\", \"pre-aortic\"]", "at most once"),
        ("operations = 0", "operations: found 0; 1 to 100000 is allowed"),
        ("operations = 1000000", "operations: found 1000000"),
        (
            "localizer = { rate_hz = 0.0 }",
            "localizer.rate_hz: found 0.0; 15 to 1000 is allowed",
        ),
        ("localizer = { rate_hz = nan }", "localizer.rate_hz: found NaN"),
        (
            "localizer = { across_mm = 0.01, depth_mm = 1.0 }",
            "within a factor of 50",
        ),
        ("beads = { touched = 2 }", "beads.touched: found 2; 3 to 7 is allowed"),
        ("beads = { touched = 8 }", "beads.touched: found 8"),
        ("beads = { places = \"front\", touched = 5 }", "3 to 4 is allowed"),
        ("beads = { places = \"back\" }", "\"spread\" or \"front\" is allowed"),
        (
            "beads = { at_mm = [[0, 0, 0], [9, 9, 9]] }",
            "beads.at_mm: found 2; 3 to 40 beads are needed",
        ),
        (
            "beads = { at_mm = [[0, 0, 0], [90, 9, 9], [0, 0, 900]] }",
            "bead 3 lies outside the CT",
        ),
        (
            "beads = { at_mm = [[0, 0, 0], [90, 9, 9], [0, nan, 0]] }",
            "bead 3 lies outside the CT",
        ),
        (
            "beads = { at_mm = [[0, 0, 0], [170, -120, 9], [0, 0, 50]] }",
            "bead 2 hangs in the air",
        ),
        (
            "beads = { at_mm = [[0, 0, 0], [0, 0, 3], [0, 50, 50]] }",
            "nearer than 5 mm",
        ),
        (line, "all beads lie on a line to within 5 mm"),
        (
            "registration = \"landmarks\"",
            "registration: found \"landmarks\"; \"beads\" or \"surface\" is allowed",
        ),
        (
            "surface = { share = 0.5 }",
            "surface: found \"a table\"; registration = \"surface\" must be said",
        ),
        (
            "registration = \"surface\"\nsurface = { share = 0.05 }",
            "surface.share: found 0.05; 0.1 to 1 is allowed",
        ),
        (
            "registration = \"surface\"\nsurface = { every = 0 }",
            "surface.every: found 0",
        ),
        (
            "registration = \"surface\"\nsurface = { phantom_deg = nan }",
            "surface.phantom_deg: found NaN",
        ),
        (
            "display = \"slices\"",
            "stratum \"a\": display: found \"slices\"; \"sight\" or \"pixels\" is allowed",
        ),
        (
            "breathing = { mm = -1.0 }",
            "breathing.mm: found -1.0; 0 to 50 is allowed",
        ),
        (
            "breathing = { mm = 1.0, period_s = 0.0 }",
            "breathing.period_s: found 0.0; 0.5 to 60",
        ),
        ("planted = { mm = 1.0 }", "planted.link must say in which link"),
        (
            "planted = { link = \"probe\", mm = 1.0 }",
            "\"tool\" or \"registration\" is allowed",
        ),
        ("ct = { spacing_mm = [1, 1, 20] }", "ct.spacing_mm: found 20.0"),
        ("beeds = { touched = 3 }", "line 3, column 1"),
        ("beads = { touched = \"three\" }", "line 3, column 21"),
    ] {
        let found = of(dials);
        assert!(
            found.starts_with("study file s.toml") && found.contains(words),
            "{dials}: {found}"
        );
    }
    for (text, words) in [
        ("", "no stratum to study"),
        ("[[stratum]]\nseed = 1", "unknown field `seed`"),
        ("[[stratum]]\nname = \"a b\"", "name: found \"a b\""),
        (
            "[[stratum]]\nname = \"a\"\n[[stratum]]\nname = \"a\"",
            "a second stratum \"a\"",
        ),
        (
            "display = \"ink\"\n[[stratum]]\nname = \"a\"",
            "the file: display: found \"ink\"; \"sight\" or \"pixels\" is allowed",
        ),
        ("[all]\nname = \"a\"\n[[stratum]]\nname = \"a\"", "strata have names"),
    ] {
        assert!(refusal(text).contains(words), "{text}: {}", refusal(text));
    }
    let error = Plan::load(&["nowhere.toml".into()]).unwrap_err().to_string();
    assert!(error.starts_with("study file nowhere.toml"), "{error}");
}

#[test]
fn a_stratum_has_what_all_have_but_for_its_own() {
    let text = "seed = 9\noperations = 7\n[all]\nbeads = { touched = 4 }\nct = { images = 3, noise_hu = 5.0 }\n\
                [[stratum]]\nname = \"a\"\n[[stratum]]\nname = \"b\"\noperations = 2\nct = { noise_hu = 8.0, fresh = true }\nbeads = { touched = 3 }";
    let plan = plan(text);
    let [a, b] = &plan.strata[..] else { panic!() };
    assert_eq!((a.seed, a.operations, b.operations, plan.operations()), (9, 7, 2, 9));
    assert_eq!((a.dials.ct.images, a.dials.ct.noise_hu), (3, 5.0));
    // Fresh: an examination for each operation.
    assert_eq!((b.dials.ct.images, b.dials.ct.noise_hu), (2, 8.0));
    let counts = [a, b].map(|stratum| match &stratum.dials.beads {
        Beads::OnSkin(numbers) => numbers.len(),
        Beads::At(_) => 0,
    });
    assert_eq!(counts, [4, 3]);
    let places: Vec<(String, u64)> = (0..10)
        .filter_map(|at| plan.operation(at))
        .map(|(s, n)| (s.name.clone(), n))
        .collect();
    assert_eq!(
        (places[6].clone(), places[7].clone(), places.len()),
        (("a".to_owned(), 6), ("b".to_owned(), 0), 9)
    );
}

#[test]
fn the_shipped_studies_are_good() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/study");
    let operations = |path: &Path| Plan::load(&[path.to_owned()]).unwrap().operations();
    for (name, expected) in [
        ("small.toml", 20),
        ("accuracy.toml", 1000),
        ("planted.toml", 100),
        ("pixels.toml", 20),
        ("breathing.toml", 80),
        ("dials.toml", 1600),
        ("extremes.toml", 100),
        ("factorial.toml", 960),
        ("fresh.toml", 50),
        ("shares.toml", 320),
        ("surface.toml", 120),
        ("tissue.toml", 80),
    ] {
        assert_eq!(operations(&folder.join(name)), expected, "{name}");
    }
    // Those of the folder that are not named above.
    for file in std::fs::read_dir(&folder).unwrap() {
        assert!(operations(&file.unwrap().path()) > 0);
    }
}

/// The nearest word counts: of the stratum, of all, at the top.
#[test]
fn a_display_is_said_at_the_top_of_all_or_of_one() {
    let text = |top: &str, all: &str| {
        plan(&format!(
            "{top}\n[all]\n{all}\n[[stratum]]\nname = \"a\"\n[[stratum]]\nname = \"b\"\ndisplay = \"sight\""
        ))
    };
    let (sight, pixels) = ("display = \"sight\"", "display = \"pixels\"");
    for (top, all, expected) in [
        ("", "", Display::Sight),
        (pixels, "", Display::Pixels),
        ("", pixels, Display::Pixels),
        (pixels, sight, Display::Sight),
        (sight, pixels, Display::Pixels),
    ] {
        let found = text(top, all)
            .strata
            .iter()
            .map(|s| s.dials.display)
            .collect::<Vec<_>>();
        assert_eq!(found, [expected, Display::Sight], "{top} {all}");
    }
}

fn of_files<'a>(files: &[(&'a str, &'a str)]) -> Result<Plan, String> {
    let texts = files.iter().map(|(name, text)| (Path::new(*name), *text));
    Plan::of_texts(texts).map_err(|error| error.to_string())
}

fn names(plan: &Plan) -> Vec<&str> {
    plan.strata.iter().map(|stratum| stratum.name.as_str()).collect()
}

/// `pilot study config/study/*.toml`: many of them have a stratum "usual".
#[test]
fn all_shipped_studies_are_one_study() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../config/study"));
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    let all = Plan::load(&paths).unwrap();
    let alone = paths.iter().map(|path| Plan::load(std::slice::from_ref(path)).unwrap());
    assert_eq!(all.operations(), alone.map(|plan| plan.operations()).sum::<u64>());
    let found = names(&all);
    for name in [
        "small.usual",
        "accuracy.usual",
        "tool.noisy",
        "accuracy.noisy",
        "fresh",
        "shape-1-1-1-1",
    ] {
        assert!(found.contains(&name), "{name}: {found:?}");
    }
    assert!(!found.contains(&"usual"));
    let different: std::collections::BTreeSet<&str> = found.iter().copied().collect();
    assert_eq!(different.len(), found.len());
    let of = |name: &str| all.strata.iter().find(|stratum| stratum.name == name).unwrap();
    assert_eq!(
        (of("small.usual").own_name.as_str(), of("small.usual").seed),
        ("usual", 1)
    );
}

#[test]
fn strata_of_one_name_are_told_apart_by_their_files() {
    let (a, ab) = (
        "[[stratum]]\nname = \"a\"",
        "[[stratum]]\nname = \"a\"\n[[stratum]]\nname = \"b\"",
    );
    let plan = of_files(&[("dir/one.toml", a), ("two.toml", ab)]).unwrap();
    assert_eq!(names(&plan), ["one.a", "two.a", "b"]);
    // The file's name is not in its text.
    let other = of_files(&[("three.toml", a), ("two.toml", ab)]).unwrap();
    assert_ne!(plan.hash, other.hash);
    let alone = of_files(&[("one.toml", a)]).unwrap();
    assert_eq!(
        (names(&alone), &alone.hash),
        (vec!["a"], &of_files(&[("other.toml", a)]).unwrap().hash)
    );
    for (files, words) in [
        (
            [("x/one.toml", a), ("y/one.toml", a)],
            "study file y/one.toml: a second stratum \"one.a\"",
        ),
        (
            [("one two.toml", a), ("two.toml", ab)],
            "the file's name: found \"one two\"; they are told by it: 1 to 40 of the characters",
        ),
        ([("one,.toml", a), ("two.toml", ab)], "study file one,.toml"),
    ] {
        let why = of_files(&files).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
}

/// Tables and charts of sweeps are told apart as well.
#[test]
fn sweeps_of_one_name_are_told_apart_by_their_files() {
    let sweep = |values: &str| format!("[sweep]\nmarker.emitters = {values}");
    let (two, three) = (sweep("[12, 13]"), sweep("[14, 15, 16]"));
    let plan = of_files(&[("one.toml", two.as_str()), ("other.toml", three.as_str())]).unwrap();
    assert_eq!(
        names(&plan),
        [
            "one.sweep-1",
            "one.sweep-2",
            "other.sweep-1",
            "other.sweep-2",
            "other.sweep-3"
        ]
    );
    let told: Vec<(&str, usize)> = plan
        .sweeps
        .iter()
        .map(|sweep| (sweep.name.as_str(), sweep.first))
        .collect();
    assert_eq!(told, [("one.sweep", 0), ("other.sweep", 2)]);
    // A stratum that is called as one of a sweep.
    let stratum = "[[stratum]]\nname = \"sweep-2\"";
    let plan = of_files(&[("one.toml", two.as_str()), ("other.toml", stratum)]).unwrap();
    assert_eq!(names(&plan), ["one.sweep-1", "one.sweep-2", "other.sweep-2"]);
    assert_eq!(plan.sweeps[0].name, "one.sweep");
}

/// What all strata say of a sweep of images is of those alone that are registered by it.
#[test]
fn a_way_of_registration_is_a_dial_like_any_other() {
    let text = "[all]\nsurface = { share = 0.5 }\n[sweep]\nregistration = [\"beads\", \"surface\"]";
    let plan = plan(text);
    let shares: Vec<Option<f64>> = plan
        .strata
        .iter()
        .map(|stratum| stratum.dials.surface.map(|surface| surface.share))
        .collect();
    assert_eq!(shares, [None, Some(0.5)]);
}

#[test]
fn a_sweep_is_every_value_with_every_other() {
    let text = "operations = 3\n[all]\ntargets = [\"pre-aortic\"]\n[[stratum]]\nname = \"a\"\n[sweep]\nname = \"s\"\n\
                marker.emitters = [12, 24]\nmarker.radius_mm = [25.0, 50.0, 75.0]\nct.spacing_mm = [[1.0, 1.0, 1.0], [1.0, 1.0, 2.5]]";
    let plan = plan(text);
    let sweep = &plan.sweeps[0];
    assert_eq!(
        (plan.strata.len(), plan.operations(), sweep.first, sweep.cells()),
        (13, 39, 1, 12)
    );
    let keys: Vec<&str> = sweep.factors.iter().map(|factor| factor.key.as_str()).collect();
    assert_eq!(keys, ["ct.spacing_mm", "marker.emitters", "marker.radius_mm"]);
    assert_eq!(sweep.factors[1].numbers, Some(vec![12.0, 24.0]));
    assert_eq!(sweep.factors[0].numbers, None);
    for cell in 0..12 {
        let (stratum, levels) = (&plan.strata[1 + cell], sweep.levels(cell));
        let dials = &stratum.dials;
        assert_eq!(
            stratum.name,
            format!("s-{}-{}-{}", levels[0] + 1, levels[1] + 1, levels[2] + 1)
        );
        assert_eq!(dials.ct.spacing_mm[2], [1.0, 2.5][levels[0]]);
        assert_eq!(dials.marker.emitters, [12, 24][levels[1]]);
        assert_eq!(dials.marker.radius_mm, [25.0, 50.0, 75.0][levels[2]]);
        assert_eq!(dials.targets.len(), 1);
    }
}

#[test]
fn a_sweep_that_cannot_be_is_refused_with_its_key() {
    let many = (0..6).map(|k| {
        format!(
            "{} = [1.0, 1.1, 1.2]",
            [
                "radius_mm",
                "marker.radius_mm",
                "ct.noise_hu",
                "touch.error_mm",
                "touch.stated_mm",
                "check.max_mm"
            ][k]
        )
    });
    let many = many.collect::<Vec<_>>().join("\n");
    for (sweep, words) in [
        ("", "sweep: dials: found 0; 1 to 6 dials are allowed"),
        (
            "marker.emitters = 12",
            "sweep: marker.emitters: found 12; a list of values is needed",
        ),
        ("marker.emitters = [12]", "2 to 16 values are allowed"),
        (
            "marker.emitters = [12, 12]",
            "sweep: marker.emitters: found 12; each value at most once",
        ),
        ("marker.emitter = [12, 13]", "unknown field `emitter`"),
        ("marker.emitters = [12, \"many\"]", "sweep-2"),
        (
            "marker.emitters = [12, 99]",
            "stratum \"sweep-2\": marker.emitters: found 99; 3 to 32",
        ),
        ("operations = [12, 13]", "operations stand at the top"),
        ("name = 3", "sweep: name: found 3; a text"),
        ("name = \"a b\"\nmarker.emitters = [12, 13]", "name: found \"a b-1\""),
        (&many, "sweep: all values: found 729; at most 512"),
    ] {
        let found = refusal(&format!("[sweep]\n{sweep}"));
        assert!(
            found.starts_with("study file s.toml") && found.contains(words),
            "{sweep}: {found}"
        );
    }
}
