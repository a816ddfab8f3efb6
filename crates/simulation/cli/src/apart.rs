//! Solids in one another: what `check` and certificates say of seeded scenes, against exact predicates on fine polygons.

mod oracle;
mod scenes;

use std::path::Path;

use crate::model::Model;
use crate::run::{Run, run};
use crate::scene::Source;
use oracle::{Label, label};
use scenes::{Made, Random, bar, organ, ring, solids, text};

/// What a scene is: the worst of all pairs, and of a strip with itself.
fn labelled(solids: &[Made]) -> Label {
    let pairs = (0..solids.len()).flat_map(|i| (i + 1..solids.len()).map(move |j| (i, j)));
    let own = solids.iter().filter_map(|s| s.ends.as_ref());
    let own = own.map(|[one, other]| label(std::slice::from_ref(one), std::slice::from_ref(other)));
    pairs
        .map(|(i, j)| label(&solids[i].contours, &solids[j].contours))
        .chain(own)
        .max()
        .unwrap_or(Label::Free)
}

fn contact(solids: &[Made]) -> &'static str {
    if solids.len() == 1 {
        "[contact]\npairs = [[\"s0\", \"s0\"]]\n"
    } else {
        "[contact]\n"
    }
}

/// Scenes from `first` on: `check` refuses what crosses, contains or touches, and nothing else; how many of each label.
fn checks(first: u64, count: u64) -> [usize; 4] {
    let mut seen = [0; 4];
    for k in first..first + count {
        let mut random = Random::new(k);
        let solids = solids(&mut random);
        let label = labelled(&solids);
        seen[label as usize] += 1;
        // About the origin, and up to 1e3 sizes away from it: coordinates are rounded to 1e-13 of the size there.
        let far = random.small(1e-3, 1e3) * [0.0, 1.0][random.below(2)];
        let text = text(&solids, contact(&solids), &|_| {
            format!("start = {{ moved = [{far:?}, {:?}] }}", -0.7 * far)
        });
        let said = crate::check(text.clone(), Path::new("made.toml"));
        let together = match &said {
            Ok(_) => false,
            Err(why) => {
                assert!(why.contains("overlap or touch"), "scene {k}: {why}\n{text}");
                true
            }
        };
        match label {
            Label::Free => assert!(!together, "scene {k} is free: {}\n{text}", said.unwrap_err()),
            Label::Touching => {}
            _ => assert!(together, "scene {k} is {label:?}, and accepted\n{text}"),
        }
    }
    seen
}

#[test]
fn a_check_tells_what_exact_predicates_tell() {
    let seen = checks(0, 600);
    // Few are so near that 16384 chords an arc leave them open.
    assert!(
        seen[0] > 120 && seen[1] < 60 && seen[2] > 12 && seen[3] > 120,
        "{seen:?}"
    );
}

/// All of them: `cargo test -p simulation-cli apart -- --ignored`.
#[test]
#[ignore = "10 000 scenes take a minute"]
fn a_check_tells_what_exact_predicates_tell_of_ten_thousand() {
    let seen = checks(10_000, 10_000);
    assert!(seen[1] < 1000, "{seen:?}");
}

/// A scene of a needle that is driven, and of an organ, a bar or a ring that is held on its left side.
fn stuck(random: &mut Random) -> [Made; 2] {
    let angle = random.between(0.0, 6.3);
    let n = 1 + random.below(2);
    let held = match random.below(3) {
        0 => ring([0.0, 0.0], [0.6, 1.0], 6 + random.below(6)),
        _ => organ([0.0, 0.0], [1.0, random.between(0.4, 1.0)], angle, [n + 1, n]),
    };
    // Many miss it, by more than the width of a barrier or by less.
    let centre = [random.between(-2.5, 2.5), random.between(-2.5, 2.5)];
    let thin = random.small(1e-5, 0.05).abs();
    let needle = bar(centre, [random.between(0.3, 4.0), thin], random.between(0.0, 6.3));
    [needle, held]
}

/// How far away the needle is told to be in the file: from there the model's start is moved to where it is.
const AWAY: f64 = 100.0;

/// Runs a scene whose start no check has seen.
fn unchecked(solids: &[Made; 2]) -> Run {
    let more = |k: usize| match k {
        0 => format!("driven = true\nstart = {{ moved = [{AWAY:?}, 0] }}"),
        _ => "weight = [0, -1e-3]\nheld = { low = [-9, -9], high = [-0.2, 9] }".to_owned(),
    };
    let source = Source::parse(text(solids, "[contact]\n", &more), Path::new("made.toml")).unwrap();
    let mut model = Model::new(&source.scene).unwrap_or_else(|why| panic!("{why}"));
    let bodies = &model.system.bodies;
    let needle = bodies.part_mut(0, &mut model.start);
    bodies.solid(0).translate(needle, nalgebra::Vector2::new(-AWAY, 0.0));
    run(&mut model, &source.scene.search, &mut |_| {})
}

/// Runs scenes from `first` on: `[crossing or contained, free, free and certified]`. None that crosses is certified.
fn runs(first: u64, count: u64) -> [usize; 3] {
    let mut seen = [0; 3];
    for k in first..first + count {
        let solids = stuck(&mut Random::new(k));
        let label = labelled(&solids);
        let run = unchecked(&solids);
        let fails = run.uncertified();
        let certified = run.refused.is_none() && fails.is_empty();
        match label {
            Label::Crossing | Label::Contained => {
                seen[0] += 1;
                assert!(!certified, "scene {k} is {label:?}, and certified");
            }
            Label::Free => {
                seen[1] += 1;
                seen[2] += usize::from(certified);
                assert!(certified, "scene {k} is free: {:?} {fails:?}", run.refused);
            }
            Label::Touching => {}
        }
    }
    seen
}

#[test]
fn no_run_of_solids_in_one_another_is_certified() {
    let seen = runs(0, 40);
    assert!(seen[0] > 8 && seen[1] > 8, "{seen:?}");
}

/// All of them: `cargo test -p simulation-cli apart -- --ignored`.
#[test]
#[ignore = "300 runs take some seconds"]
fn no_run_of_solids_in_one_another_is_certified_of_three_hundred() {
    let seen = runs(1000, 300);
    assert!(seen[0] > 60 && seen[1] > 60, "{seen:?}");
}

/// A needle of 0.8 x 200 mm through an organ of 30 x 15 mm, at places between those that eight points an arc see.
#[test]
fn a_needle_through_an_organ_is_refused_wherever_it_goes_through() {
    let organ = organ([0.0, 0.0], [15.0, 7.5], 0.0, [2, 1]);
    let mut random = Random::new(5);
    for round in 0..120 {
        let (angle, along) = (random.between(0.0, std::f64::consts::PI), random.between(-90.0, 90.0));
        let (x, y) = (random.between(-10.0, 10.0), random.between(-3.0, 3.0));
        let centre = [x + along * angle.cos(), y + along * angle.sin()];
        let needle = bar(centre, [100.0, 0.4], angle);
        let solids = [needle, organ.clone()];
        assert_eq!(labelled(&solids), Label::Crossing);
        let text = text(&solids, "[contact]\n", &|_| String::new());
        let said = crate::check(text, Path::new("made.toml")).expect_err("refused");
        assert!(
            said.contains("\"s0\" in \"s1\"") || said.contains("\"s1\" in \"s0\""),
            "{round}: {said}"
        );
    }
}
