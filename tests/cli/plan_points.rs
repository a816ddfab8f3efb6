//! `pilot plan --import` and `--export`: points of 3D Slicer, written and read by another program than Trocar.

#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use crate::support::nifti::Nifti;
use crate::support::{World, python, stderr, stdout};
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output};

const DIMS: [usize; 3] = [12, 10, 8];
/// A target with its entry, and one alone: both inside [`Case`]'s CT, whose voxel (i, j, k) lies at (-20 i, -20 j, 20
/// k), LPS.
const NODE: [f64; 3] = [-40.123_456_789_012_3, -100.25, 80.5];
const NODE_ENTRY: [f64; 3] = [-199.5, -100.0, 80.1];
const HILUS: [f64; 3] = [-60.0, -120.062_5, 33.3];

/// A CT of soft tissue in a folder of its own.
struct Case(World);

impl Case {
    fn new() -> Self {
        let world = World::new();
        let ct = vec![40_i16; DIMS.iter().product()];
        let header = Nifti::header().i16(70, 4).i16(72, 16);
        let ct = header.with(ct.iter().flat_map(|hu| hu.to_le_bytes()).collect::<Vec<u8>>());
        fs::write(world.path("ct.nii"), ct.0).unwrap();
        Self(world)
    }

    fn path(&self, name: &str) -> String {
        self.0.path(name).to_string_lossy().into_owned()
    }

    fn ask(&self, plan: &str, arguments: &[&str]) -> Output {
        let [plan, ct] = [plan, "ct.nii"].map(|name| self.path(name));
        self.0
            .output("pilot", &[&["plan", &plan, "--volume", &ct], arguments].concat())
    }

    /// The targets of a plan, each with its place, and its entry or null.
    fn targets(&self, plan: &str) -> Vec<[Value; 3]> {
        let output = self.ask(plan, &["--json"]);
        let said: Value = serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)));
        let targets = said["targets"].as_array().unwrap().iter();
        targets
            .map(|target| ["name", "ct_mm", "entry_ct_mm"].map(|key| target[key].clone()))
            .collect()
    }

    /// A plan of both targets.
    fn planned(&self) {
        let at = |name: &str, [x, y, z]: [f64; 3]| format!("{name}={x},{y},{z}");
        let places = [at("node", NODE), at("hilus", HILUS), at("node", NODE_ENTRY)];
        let [node, hilus, entry] = &places;
        let sizes = [
            "--diameter",
            "node=8.1",
            "--stop",
            "node=4.3",
            "--measure",
            "0,0,0:1,2,3",
        ];
        let made = ["--target", node, "--target", hilus, "--entry", entry];
        let made = self.ask("plan.json", &[&made[..], &sizes].concat());
        assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    }
}

fn peer(python: &Path, arguments: &[&str]) -> Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/check_exchange.py");
    let output = Command::new(python).arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// Whether these are the same to 1e-9 mm.
fn same(found: &Value, expected: [f64; 3]) -> bool {
    let found = found.as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
    found.zip(expected).all(|(a, b)| (a - b).abs() < 1e-9)
}

#[test]
fn another_program_reads_where_the_targets_lie() {
    let Some(python) = python() else { return };
    let case = Case::new();
    case.planned();
    for name in ["targets.mrk.json", "targets.fcsv"] {
        let path = case.path(name);
        let made = case.ask("plan.json", &["--export", &path]);
        assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
        assert!(
            stderr(&made).contains("1 measures of the plan are not in it"),
            "{}",
            stderr(&made)
        );
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        let read = peer(&python, &["read", &path]);
        let expected = [("node entry", NODE_ENTRY), ("node", NODE), ("hilus", HILUS)];
        assert_eq!(read.as_array().unwrap().len(), expected.len(), "{read}");
        for (found, (label, place)) in read.as_array().unwrap().iter().zip(expected) {
            assert_eq!(found["label"], label, "{name}: {read}");
            assert!(same(&found["lps"], place), "{name}: {read}");
        }
        assert_eq!(read[1]["description"], "diameter_mm=8.1 stop_mm=4.3");
        // And back into a new plan, sizes too.
        let plan = format!("{name}.json");
        let back = case.ask(&plan, &["--import", &path, "--json"]);
        assert_eq!(back.status.code(), Some(0), "{}", stderr(&back));
        let said: Value = serde_json::from_str(&stdout(&back)).unwrap();
        assert_eq!(
            (&said["targets"][0]["diameter_mm"], &said["targets"][0]["stop_mm"]),
            (&json!(8.1), &json!(4.3))
        );
        assert_eq!(case.targets(&plan), case.targets("plan.json"), "{name}");
    }
}

#[test]
fn what_another_program_writes_lies_where_it_says_in_every_format_and_along_either_axes() {
    let Some(python) = python() else { return };
    let case = Case::new();
    let points = json!([
        {"label": "node", "lps": NODE}, {"label": "hilus, \"left\"", "lps": HILUS}, {"label": "node entry", "lps": NODE_ENTRY},
    ]);
    for (name, axes) in [
        ("lps.mrk.json", "LPS"),
        ("ras.mrk.json", "RAS"),
        ("lps.fcsv", "LPS"),
        ("ras.fcsv", "RAS"),
    ] {
        let path = case.path(name);
        peer(&python, &["write", &path, axes, &points.to_string()]);
        let plan = format!("{name}.json");
        let taken = case.ask(&plan, &["--import", &path]);
        assert_eq!(taken.status.code(), Some(0), "{}", stderr(&taken));
        let targets = case.targets(&plan);
        assert_eq!(targets.len(), 2, "{name}");
        assert_eq!(
            (&targets[0][0], &targets[1][0]),
            (&json!("node"), &json!("hilus, \"left\""))
        );
        let found = [
            (&targets[0][1], NODE),
            (&targets[0][2], NODE_ENTRY),
            (&targets[1][1], HILUS),
        ];
        assert!(
            found.iter().all(|(found, place)| same(found, *place)),
            "{name}: {targets:?}"
        );
        // The same file with the other word is the mirror, and lies outside this CT.
        let (word, other) = if axes == "LPS" { ("LPS", "RAS") } else { ("RAS", "LPS") };
        let text = fs::read_to_string(&path).unwrap();
        let lied = case.path(&format!("lied-{name}"));
        fs::write(&lied, text.replace(word, other)).unwrap();
        let taken = case.ask(&format!("lied-{plan}"), &["--import", &lied]);
        assert_eq!(taken.status.code(), Some(3), "{}", stdout(&taken));
        let mirrored = &case.targets(&format!("lied-{plan}"))[0][1];
        assert!(same(mirrored, [-NODE[0], -NODE[1], NODE[2]]), "{name}: {mirrored}");
    }
}

#[test]
fn what_is_refused_leaves_plan_and_files_as_they_were() {
    let case = Case::new();
    case.planned();
    let before = fs::read_to_string(case.path("plan.json")).unwrap();
    let columns = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";
    let file = |name: &str, axes: &str, rows: &str| {
        let path = case.path(name);
        fs::write(
            &path,
            format!("# Markups fiducial file version = 4.11\n{axes}\n{columns}\n{rows}"),
        )
        .unwrap();
        path
    };
    let row = "1,-50,-90,60,0,0,0,1,1,1,0,new,,\n";
    let unsaid = file("unsaid.fcsv", "#", row);
    let taken = file("taken.fcsv", "# CoordinateSystem = 1", &row.replace("new", "node"));
    let metres = file(
        "metres.fcsv",
        "# CoordinateSystem = 1",
        &row.replace("-50,-90,60", "-.05,-.09,.06"),
    );
    let stray = file(
        "stray.fcsv",
        "# CoordinateSystem = 1",
        &row.replace("new", "other entry"),
    );
    let lps = "# CoordinateSystem = 1";
    let fine = file("fine.fcsv", lps, row);
    let empty = file("empty.fcsv", lps, "");
    let second = file("second.fcsv", lps, &row.replace("new", "node_entry"));
    let label = file("label.fcsv", lps, &row.replace("new", "new entry-1"));
    let linked = case.path("linked.fcsv");
    symlink("fine.fcsv", &linked).unwrap();
    symlink("plan.json", case.path("plan-link.fcsv")).unwrap();
    fs::create_dir(case.path("folder.fcsv")).unwrap();
    fs::write(case.path("left.fcsv.part"), "theirs").unwrap();
    let text = case.path("points.txt");
    fs::write(&text, "1 2 3").unwrap();
    let there = case.path("there.fcsv");
    fs::write(&there, "theirs").unwrap();
    for (arguments, words) in [
        (
            &["--import", &unsaid][..],
            "does not say whether its coordinates are LPS or RAS",
        ),
        (&["--import", &taken], "there is a target \"node\" already"),
        (&["--import", &metres], "looks like metres"),
        (&["--import", &stray], "there is no target \"other\""),
        (&["--import", &text], ".mrk.json and .fcsv are known"),
        (&["--import", "none.fcsv"], "reading none.fcsv"),
        (
            &["--import", &unsaid, "--frame", "lps", "--import", &taken],
            "there is a target \"node\" already",
        ),
        (
            &["--import", &taken, "--frame", "ras", "--remove", "node"],
            "the file says LPS and it was said to be RAS",
        ),
        (
            &["--export", &there, "--target", "b=-50,-90,60"],
            "there is a file of this name",
        ),
        (
            &["--export", "no/such/folder.fcsv", "--target", "b=-50,-90,60"],
            "writing no/such/folder.fcsv: there is no folder no/such",
        ),
        (
            &[
                "--export",
                &case.path("folder.fcsv"),
                "--overwrite",
                "--target",
                "b=-50,-90,60",
            ],
            "this is a folder",
        ),
        (
            &["--export", &case.path("left.fcsv"), "--target", "b=-50,-90,60"],
            "left.fcsv.part lies beside it",
        ),
        // By another name of the same file.
        (
            &["--import", &fine, "--export", &linked, "--overwrite"],
            "this is an imported file, which it would replace",
        ),
        (
            &[
                "--export",
                &case.path("./plan-link.fcsv"),
                "--overwrite",
                "--target",
                "b=-50,-90,60",
            ],
            "this is the plan, which it would replace",
        ),
        (&["--import", &empty], "there is no point with a place in it"),
        (&["--import", &second], "target \"node\" has an entry already"),
        (&["--import", &label], "has `entry` in its name"),
    ] {
        let refused = case.ask("plan.json", arguments);
        assert_eq!(refused.status.code(), Some(1), "{arguments:?}");
        assert!(stderr(&refused).contains(words), "{words}: {}", stderr(&refused));
        assert_eq!(fs::read_to_string(case.path("plan.json")).unwrap(), before, "{words}");
    }
    assert_eq!(fs::read_to_string(&there).unwrap(), "theirs");
    assert_eq!(fs::read_to_string(case.path("left.fcsv.part")).unwrap(), "theirs");
    let both = case.ask("plan.json", &["--import", &fine, "--confirm", "Dr. A"]);
    assert_eq!(both.status.code(), Some(2), "{}", stderr(&both));
    assert_eq!(fs::read_to_string(case.path("plan.json")).unwrap(), before);
    // What was refused is taken when a person says what the file does not.
    let said = case.ask("plan.json", &["--import", &unsaid, "--frame", "lps"]);
    assert_eq!(said.status.code(), Some(0), "{}", stderr(&said));
    assert!(same(&case.targets("plan.json")[2][1], [-50.0, -90.0, 60.0]));
    let said = case.ask("plan.json", &["--remove", "new"]);
    assert_eq!(said.status.code(), Some(0), "{}", stderr(&said));
    let said = case.ask("plan.json", &["--import", &metres, "--unit", "m"]);
    assert_eq!(said.status.code(), Some(0), "{}", stderr(&said));
    assert!(same(&case.targets("plan.json")[2][1], [-50.0, -90.0, 60.0]));
}
