//! `pilot check` of scenes whose organs no run can move: each was called good, and the run refused it when it had started.

use std::path::Path;
use std::process::Output;

use crate::support::nifti::Nifti;
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
    let organ = |k: usize| {
        format!(
            "[[organs]]\nname = \"{k}\"\nlabel = {}\nyoung = 5e-3\npoisson = 0.49\nsmoothing = 2.0\ncubes = {{ side = 20.0 }}\n\n",
            300 + k
        )
    };
    let many: String = (0..16).map(organ).collect();
    let many = text.replace("[[rigid]]", &format!("{many}[[rigid]]"));
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
        (many, "key organs: found 17; allowed: 1 to 16".to_owned()),
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

/// The model has no contact between organs: two that lie at one another would come into one another as soon as one is pushed.
#[test]
fn organs_that_lie_at_one_another_are_named() {
    let text = kidney();
    let vessel = |name: &str, label: u16| {
        format!(
            "[[organs]]\nname = \"{name}\"\nlabel = {label}\nyoung = 0.1\npoisson = 0.45\nsmoothing = 2.0\ncubes = {{ side = 26.0 }}\n\n"
        )
    };
    let both = text.replace(
        "[[rigid]]",
        &format!("{}{}[[rigid]]", vessel("aorta", 52), vessel("iliac artery", 65)),
    );
    is_refused(
        &check(&both, VOLUME, &[]),
        "organs.toml: organs aorta and iliac artery | at rest | the model has no contact between organs",
    );
    assert!(check(&both, VOLUME, &["--quick"]).status.success());
    // The aorta alone lies apart from the kidney, and what is made of both is told.
    let apart = check(
        &text.replace("[[rigid]]", &format!("{}[[rigid]]", vessel("aorta", 52))),
        VOLUME,
        &[],
    );
    let said = stdout(&apart) + &stderr(&apart);
    assert!(
        apart.status.success() && said.contains("2 organs of ") && said.contains("; aorta: "),
        "{said}"
    );
}

/// Without them an organ has no place that it comes back to.
#[test]
fn an_organ_that_nothing_holds_is_named() {
    let text = kidney();
    let held = text.find("# Fat of some").unwrap()..text.find("[tube]").unwrap();
    let free = text.replace(&text[held], "");
    is_refused(&check(&free, VOLUME, &[]), "left kidney | which nothing holds");
}

/// 40 x 30 x 30 voxels of 3 mm whose axes are the patient's, from voxel 0 at the origin.
fn voxels(value: impl Fn([f64; 3]) -> i16) -> Vec<u8> {
    let turned = Nifti::header().dims([40, 30, 30]);
    // LPS is the file's RAS with x and y the other way.
    let placed = (0..3).fold(turned, |nifti, axis| {
        let along = if axis == 2 { 3.0 } else { -3.0 };
        nifti.f32(80 + 4 * axis, 3.0).f32(280 + 20 * axis, along)
    });
    let all = (0..40 * 30 * 30).map(|at| [at % 40, at / 40 % 30, at / 1200].map(|index| 3.0 * f64::from(index)));
    placed.with(all.flat_map(|place| value(place).to_le_bytes())).into()
}

/// `pilot check` of a ball of 15 mm whose middle lies at this height; the map ends at 88.5 mm.
fn check_ball(height: f64) -> String {
    let world = World::new();
    let ball = |[x, y, z]: [f64; 3]| {
        let away = ((x - 60.0).powi(2) + (y - 45.0).powi(2) + (z - height).powi(2)).sqrt();
        i16::from(away < 15.0)
    };
    std::fs::write(world.path("ct.nii"), voxels(|_| 0)).unwrap();
    std::fs::write(world.path("labels.nii"), voxels(ball)).unwrap();
    let [from, to] = [height - 20.0, height - 12.0];
    let organs = format!(
        "title = \"A ball\"\nunits = {{ length = \"mm\", stress = \"N/mm2\" }}\n[space]\nlabels = \"labels.nii\"\n\
        [[organs]]\nname = \"ball\"\nlabel = 1\nlaw = \"neo-hookean\"\nyoung = 5e-3\npoisson = 0.45\nsmoothing = 2.0\n\
        cubes = {{ side = 12.0, levels = 0, within = [] }}\n[surroundings]\nyoung = 2e-3\nmargin = 20.0\ncorridor = 12.0\n\
        [tube]\ndiameter = 12.0\nlength = 180.0\nentry = [20.0, 45.0, {from:?}]\ntarget = [60.0, 45.0, {to:?}]\nstroke = 20.0\nstep = 2.0\n"
    );
    world.file("organs.toml", &organs);
    let scene = "[volume]\nsource = \"ct.nii\"\n[tool]\ndiameter_mm = 12.0\n[tissue]\norgans = \"organs.toml\"\n";
    let scene = world.file("scene.toml", scene);
    let output = world.output("pilot", &["check", scene.to_str().unwrap()]);
    let said = stdout(&output) + &stderr(&output);
    assert!(said.contains("ball: "), "{said}");
    said
}

/// `simulate` told it, and whoever started a run did not.
#[test]
fn an_organ_that_the_border_of_the_examination_cuts_off_is_said_and_a_whole_one_is_not() {
    let cut = check_ball(80.0);
    assert!(cut.contains("CUT OFF by the border of the label map"), "{cut}");
    let whole = check_ball(50.0);
    assert!(whole.contains("cubes") && !whole.contains("CUT OFF"), "{whole}");
}
