//! A run that follows a plan: its targets, in its examination and no other.

use std::path::Path;

use crate::support::{World, report, stderr};
use serde_json::Value;

const SMALL: &str = crate::support::SMALL;

/// The small scene with a plan.
fn following(world: &World, name: &str, table: &str, changed: impl Fn(&str) -> String) -> String {
    let scene = world.file(
        name,
        &format!("{}\n[plan]\nfile = \"plan.json\"\n{table}", changed(SMALL)),
    );
    scene.to_string_lossy().into_owned()
}

fn planned(world: &World, arguments: &[&str]) -> std::process::Output {
    let (plan, scene) = (world.path("plan.json"), world.file("small.toml", SMALL));
    let (plan, scene) = (plan.to_string_lossy(), scene.to_string_lossy());
    let mut all = vec!["plan", &plan, "--scene", &scene];
    all.extend(arguments);
    world.output("pilot", &all)
}

fn run(world: &World, scene: &str, out: &Path) -> std::process::Output {
    let out = out.to_string_lossy();
    world.output("pilot", &["run", scene, "--headless", "--for", "500ms", "--out", &out])
}

/// H5: a plan that was shifted, as it was drawn over another examination than it was made for.
#[test]
fn h5_a_plan_is_followed_in_its_own_examination_alone() {
    let world = World::new();
    let made = planned(
        &world,
        &[
            "--target",
            "node=10,20,30",
            "--entry",
            "node=100,50,30",
            "--stop",
            "node=4",
        ],
    );
    // Whatever speaks against it: nothing was refused.
    assert_ne!(made.status.code(), Some(1), "{}", stderr(&made));
    let scene = following(&world, "follows.toml", "[guide]\ntarget = \"node\"", str::to_owned);
    let out = world.path("out");
    let ran = run(&world, &scene, &out);
    assert!(ran.status.code() != Some(1), "{}", stderr(&ran));
    let shown = report(&out);
    let plan: Value = serde_json::from_slice(&std::fs::read(world.path("plan.json")).unwrap()).unwrap();
    assert_eq!(shown["volume"]["hash"], plan["volume"]["hash"]);

    // Another patient: refused by the loader, before anything is shown.
    let other = following(&world, "other.toml", "", |small| small.replace("seed = 1", "seed = 2"));
    let out = world.path("other");
    let ran = run(&world, &other, &out);
    assert_eq!(ran.status.code(), Some(1));
    let said = stderr(&ran);
    let hash = plan["volume"]["hash"].as_str().unwrap();
    assert!(
        said.contains(&format!("the scene is for the examination {hash} alone")),
        "{said}"
    );
    let pictures = std::fs::read_dir(&out).into_iter().flatten().flatten();
    assert_eq!(
        pictures
            .filter(|file| file.path().extension().is_some_and(|e| e == "png"))
            .count(),
        0
    );
    // The same patient at another spacing is other voxels, and in the command line it is refused as well.
    let coarse = world.file("coarse.toml", &SMALL.replace("spacing_mm = 6.0", "spacing_mm = 5.0"));
    let plan = world.path("plan.json");
    let asked = world.output(
        "pilot",
        &["plan", plan.to_str().unwrap(), "--scene", coarse.to_str().unwrap()],
    );
    assert!(
        stderr(&asked).contains("it was made for the examination"),
        "{}",
        stderr(&asked)
    );
}

#[test]
fn plans_that_cannot_be_followed_are_refused_by_name_before_a_process_starts() {
    let world = World::new();
    let follows = |name: &str, table: &str| following(&world, name, table, str::to_owned);
    let refused = |scene: &str, words: &str| {
        let checked = world.output("pilot", &["check", scene]);
        assert_eq!(checked.status.code(), Some(1), "{words}");
        assert!(stderr(&checked).contains(words), "{words}: {}", stderr(&checked));
    };
    refused(&follows("none.toml", ""), "there is no such file; `pilot plan");
    assert!(planned(&world, &["--target", "node=10,20,30"]).status.success());
    let plan = world.path("plan.json");
    let text = std::fs::read_to_string(&plan).unwrap();
    let plain = follows("plain.toml", "");
    assert!(world.output("pilot", &["check", &plain]).status.success());
    refused(
        &follows("both.toml", "[[targets]]\nname = \"a\"\nct_mm = [1, 2, 3]"),
        "whose targets are others",
    );
    refused(
        &follows("id.toml", "id = \"0123456789abcdef\""),
        "the scene follows 0123456789abcdef alone",
    );
    refused(
        &follows("strict.toml", "[workflow]\nstrict = true"),
        "nobody has confirmed the plan",
    );
    let bad = "ab".repeat(32);
    let other = following(&world, "hash.toml", "", |small| {
        small.replace("[volume]", &format!("[volume]\nhash = \"{bad}\""))
    });
    refused(&other, "and the scene loads abab");
    for (changed, words) in [
        (text.replace("10.0", "11.0"), "changed by other means"),
        (
            text.replace("\"version\": 1", "\"version\": 9"),
            "written by a later Trocar",
        ),
        (text[..text.len() / 2].to_owned(), "EOF while parsing"),
        (String::new(), "EOF while parsing"),
    ] {
        std::fs::write(&plan, changed).unwrap();
        refused(&plain, words);
    }
    // Confirmed, it is followed also by a strict scene: with that very scene, as the refusal says.
    std::fs::write(&plan, text).unwrap();
    let (plan, strict) = (world.path("plan.json"), world.path("strict.toml"));
    let (plan, strict) = (plan.to_str().unwrap(), strict.to_str().unwrap());
    let confirmed = world.output("pilot", &["plan", plan, "--scene", strict, "--confirm", "Dr. A"]);
    assert!(confirmed.status.success(), "{}", stderr(&confirmed));
    let strict = world.path("strict.toml");
    let checked = world.output("pilot", &["check", strict.to_str().unwrap()]);
    assert!(checked.status.success(), "{}", stderr(&checked));
}
