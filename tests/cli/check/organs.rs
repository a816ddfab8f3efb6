//! `pilot check` of scenes whose organs no run can move: each was called good, and the run refused it when it had started.

use std::path::Path;
use std::process::Output;

use crate::support::{World, stderr, stdout};

/// The shipped kidney of the generated patient.
fn kidney() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/solids/demo-kidney.toml");
    std::fs::read_to_string(file).unwrap()
}

/// Voxels so large that a label map is read in a fraction of a second.
const VOLUME: &str = "[volume]\nspacing_mm = 4.0\n";

/// `pilot check` of these organs in a scene with more, or other, keys than [`VOLUME`]'s.
fn check(organs: &str, scene: &str, more: &[&str]) -> Output {
    let world = World::new();
    world.file("organs.toml", organs);
    let scene = format!("{scene}[tool]\ndiameter_mm = 12.0\n[tissue]\norgans = \"organs.toml\"\n");
    let scene = world.file("scene.toml", &scene);
    let arguments = [&["check", scene.to_str().unwrap()], more].concat();
    world.output("pilot", &arguments)
}

/// Exit code 1, and one paragraph with all `words`, between bars; and the scene is not called good.
fn is_refused(output: &Output, words: &str) {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{words}: {said}");
    let is_it = |line: &&str| {
        line.contains("error: the organs of [tissue]: ") && words.split(" | ").all(|word| line.contains(word))
    };
    assert_eq!(said.lines().filter(is_it).count(), 1, "{words:?} in:\n{said}");
    assert!(stdout(output).contains("scene.toml: 1 wrong"), "{}", stdout(output));
}

/// The line of a text that begins so, counted from 1.
fn line(text: &str, start: &str) -> usize {
    1 + text.lines().position(|line| line.starts_with(start)).unwrap()
}

#[test]
fn values_of_organs_that_a_run_would_refuse_are_named_with_their_line() {
    let text = kidney();
    let other = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let second = text.replace("[[rigid]]", "[[organs]]\nname = \"liver\"\nlabel = 1\nyoung = 5e-3\npoisson = 0.49\nsmoothing = 2.0\ncubes = { side = 20.0 }\n\n[[rigid]]");
    for (organs, words) in [
        (
            other("\nstep = 2.0", "\nstep = 3.0"),
            format!(
                "organs.toml, line {}, column 8, | key tube.step: found 3 mm; allowed: less than 3 mm",
                line(&text, "step")
            ),
        ),
        (
            other("poisson = 0.49", "poisson = 0.5"),
            format!("line {}, | key organs.0.poisson: found 0.5", line(&text, "poisson")),
        ),
        (
            other("diameter = 12.0", "diameter = 14.0"),
            "key tube.diameter: found 14 mm; the run's tool has 12 mm".to_owned(),
        ),
        (second, "2 organs; one is moved in a run so far".to_owned()),
        (
            other("young = 10e-3", "youngs = 10e-3"),
            format!("line {}, column | unknown field `youngs`", line(&text, "young")),
        ),
    ] {
        is_refused(&check(&organs, VOLUME, &[]), &words);
        // They need no mesh.
        is_refused(&check(&organs, VOLUME, &["--quick"]), &words);
    }
}

#[test]
fn a_label_map_that_is_not_on_the_voxels_of_the_run_is_named() {
    for (scene, voxels) in [
        (
            "[volume]\nspacing_mm = 4.0\n[volume.region]\nbox_voxels = [[10, 10, 10], [60, 50, 60]]\n",
            "50 x 40 x 50 of 4.000",
        ),
        (
            "[volume]\nspacing_mm = 4.0\ndownsample = [2, 2, 2]\n",
            "46 x 32 x 44 of 8.000",
        ),
    ] {
        let words = format!(
            "phantom: its voxels, 92 x 64 x 88 of 4.000 | are not those of the run's examination, {voxels} | [volume.region] and \
             volume.downsample make others"
        );
        for more in [&[][..], &["--quick"]] {
            is_refused(&check(&kidney(), scene, more), &words);
        }
    }
}

#[test]
fn organs_that_cannot_be_meshed_or_met_are_named_unless_that_is_left_out() {
    let text = kidney();
    let cubes = "cubes = { side = 20.0, levels = 1, within = [8.0] }";
    let at = |start: &str| line(&text, start);
    for (organs, words) in [
        (
            text.replace(cubes, "cubes = { side = 40.0, levels = 0, within = [] }"),
            format!(
                "organs.toml, line {}, column 9, | key organs.0.cubes: found points of the surface of \"left kidney\" | allowed: at most 3.00 mm",
                at("cubes")
            ),
        ),
        (
            text.replace("label = 3", "label = 77"),
            format!(
                "line {}, | key organs.0.label: found 77, which no voxel has",
                at("label =")
            ),
        ),
        (
            text.replace("entry = [115.1, 86.3, 115.4]", "entry = [600.0, 86.3, 115.4]")
                .replace("target = [28.5", "target = [600.5"),
            format!(
                "line {}, | key tube: found a way on which the tube touches no organ",
                at("[tube]")
            ),
        ),
    ] {
        is_refused(&check(&organs, VOLUME, &[]), &words);
        let quick = check(&organs, VOLUME, &["--quick"]);
        assert!(quick.status.success(), "{}", stderr(&quick));
        assert!(
            stdout(&quick).contains("were not meshed (--quick)"),
            "{}",
            stdout(&quick)
        );
    }
}
