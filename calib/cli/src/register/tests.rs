//! The command in the test's own process.

use std::fs;

use tempfile::TempDir;

use crate::commands::tests::calib;

/// Touches of a tool in a frame, in the columns of `calib touch`.
const TOUCHES: &str = "\
on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz
a,0,0,0,0.01,0,0,0.01,0,0.01
b,60,0,0,0.01,0,0,0.01,0,0.01
c,0,80,0,0.01,0,0,0.01,0,0.01
d,0,0,50,0.01,0,0,0.01,0,0.01
";
const PLACES: &str = "5 0 -7\n5 60 -7\n-75 0 -7\n5 0 43\n";

fn registered(folder: &TempDir, files: [&str; 2], more: &str) -> Result<String, String> {
    let [to, from] = ["to.txt", "from.txt"].map(|name| folder.path().join(name));
    fs::write(&to, files[0]).unwrap();
    fs::write(&from, files[1]).unwrap();
    let line = format!(
        "calib register --to-points {} --from-points {} {more}",
        to.display(),
        from.display()
    );
    calib(&line).map(|outcome| outcome.text)
}

/// Touches in the frame of the tracker were taken for points of the CT, and what they state of their errors was lost.
#[test]
fn touches_are_no_points_of_another_frame_to_register_to() {
    let folder = tempfile::tempdir().unwrap();
    let of = |frame: &str| format!("# places of the tip of scope in the {frame}, mm\n{TOUCHES}");
    for (to, words) in [
        (of("tracker"), "its touches are in the tracker, and ct is said"),
        (
            TOUCHES.to_owned(),
            "has the columns of touches (cxx to czz) as --to-points",
        ),
    ] {
        let error = registered(&folder, [&to, PLACES], "--to ct --from tracker")
            .err()
            .unwrap();
        assert!(error.contains(words), "{error}");
    }
    assert!(registered(&folder, [&of("reference"), &of("tracker")], "--to reference").is_ok());
}
