//! What is doubtful about an examination is said wherever it is planned in, or looked at before a run.

use crate::support::nifti::Nifti;
use crate::support::{World, stderr, stdout};

/// `inspect` and `calib bone` said it; a plan in the same examination ended with "nothing was found against it in the CT".
#[test]
fn what_is_doubtful_about_an_examination_is_said_by_plan_and_check() {
    let world = World::new();
    let voxels = 12 * 10 * 8;
    let ct = Nifti::header().i16(70, 4).i16(72, 16).with([40, 0].repeat(voxels));
    let (ct_file, plan) = (world.path("ct.nii"), world.path("plan.json"));
    std::fs::write(&ct_file, ct.0).unwrap();
    let doubt = "warning: the examination: every voxel holds 40 HU";
    let ask = |more: &[&str]| {
        let words = ["plan", plan.to_str().unwrap(), "--volume", ct_file.to_str().unwrap()];
        let made = world.output("pilot", &[&words[..], more].concat());
        assert_eq!(made.status.code(), Some(0), "{}\n{}", stdout(&made), stderr(&made));
        stdout(&made)
    };
    let said = ask(&["--target", "n=-40,-100,80", "--entry", "n=-200,-100,80"]);
    assert!(said.contains(doubt), "{said}");
    assert!(!said.contains("nothing was found against it in the CT"), "{said}");
    let json: serde_json::Value = serde_json::from_str(&ask(&["--json"])).unwrap();
    let listed = json["examination_warnings"].as_array().unwrap();
    assert!(
        listed.iter().any(|words| words == "every voxel holds 40 HU"),
        "{listed:?}"
    );
    let scene = world.file("scene.toml", "[volume]\nsource = \"ct.nii\"\n");
    let checked = world.output("pilot", &["check", scene.to_str().unwrap()]);
    assert!(
        stdout(&checked).contains(doubt),
        "{}\n{}",
        stdout(&checked),
        stderr(&checked)
    );
}
