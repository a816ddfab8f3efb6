//! Studies that cannot be are refused by file, stratum and key.

use std::path::Path;

use crate::support::plan;
use study::plan::{Beads, Plan};

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
            "display = \"pixels\"\n[[stratum]]\nname = \"a\"",
            "\"sight\" is the one display there is",
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
    for (text, operations) in [
        (include_str!("../../../config/study/small.toml"), 20),
        (include_str!("../../../config/study/accuracy.toml"), 1000),
        (include_str!("../../../config/study/planted.toml"), 80),
        (include_str!("../../../config/study/dials.toml"), 1600),
        (include_str!("../../../config/study/extremes.toml"), 100),
        (include_str!("../../../config/study/factorial.toml"), 960),
        (include_str!("../../../config/study/fresh.toml"), 50),
        (include_str!("../../../config/study/surface.toml"), 120),
    ] {
        assert_eq!(plan(text).operations(), operations);
    }
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
