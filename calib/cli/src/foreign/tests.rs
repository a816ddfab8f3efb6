//! Calibrations of other programs on planted files: what is read of them, what is said beside them, what is refused.

use std::fs;

use calib::file::{FileError, ToolFile};
use clap::Parser;
use exchange::{itk, plus};
use geometry::rotation::Rotation;
use geometry::{Ct, Direction, Marker, Point, Rigid, Tool, Tracker, Vector};
use tempfile::TempDir;

use crate::cli::{Cli, run};
use crate::commands::Outcome;

/// Of a tool whose shaft is the first axis of its own frame.
fn planted<To, From>() -> Rigid<To, From> {
    let rotation = Rotation::from_quaternion([0.5, 0.1, -0.7, 0.5]).unwrap();
    Rigid::from_parts(rotation, Vector::new(12.5, -40.25, 160.125))
}

fn calib(folder: &TempDir, line: &str) -> Result<Outcome, String> {
    let words = line
        .split(' ')
        .map(|word| word.replace("DIR", &folder.path().to_string_lossy()));
    let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
    run(cli, |_| Err("no volume is read here".into()))
}

/// What is said of every import here.
const SAID: &str = "--shaft x --tip-error-mm 0.5 --axis-error-deg 1 --tool scope --marker ball";

fn imported(folder: &TempDir, line: &str) -> ToolFile {
    let line = format!("calib import {line} {SAID} --out DIR/tool.json --overwrite");
    calib(folder, &line).unwrap_or_else(|error| panic!("{line}: {error}"));
    ToolFile::parse(&fs::read_to_string(folder.path().join("tool.json")).unwrap()).unwrap()
}

/// How far the tip is from the planted one, mm, and the shaft from the planted first axis.
fn off(tool: &ToolFile) -> [f64; 2] {
    let (found, given) = (tool.marker_from_tool.transform(), planted::<Marker, Tool>());
    let origin = Point::<Tool>::new(0.0, 0.0, 0.0);
    let shafts = [found * Direction::Z, given * Direction::X].map(|axis| axis.vector());
    [
        (found * origin).distance(given * origin),
        (shafts[0] - shafts[1]).norm(),
    ]
}

#[test]
fn a_stylus_of_plus_becomes_a_tool_with_the_error_that_a_person_says() {
    let folder = TempDir::new().unwrap();
    let set = plus::DeviceSet {
        definitions: vec![plus::Definition {
            error: Some(0.450335),
            ..plus::Definition::new("StylusTip", "Stylus", &planted::<Marker, Tool>())
        }],
    };
    fs::write(folder.path().join("set.xml"), plus::write(&set)).unwrap();
    let tool = imported(&folder, "DIR/set.xml --from StylusTip --to Stylus");
    assert!(off(&tool).iter().all(|off| *off < 1e-9), "{:?}", off(&tool));
    tool.of("scope", "ball").unwrap();
    // What was said, and not what the file calls its error.
    let error = tool.reached.tip_error_mm.unwrap();
    assert!((error - 0.5).abs() < 1e-9, "{error}");
    // What nobody measured keeps no gate.
    assert_eq!(
        (tool.reached.rms_mm, tool.reached.condition, tool.reached.count),
        (None, None, None)
    );
    let text = fs::read_to_string(folder.path().join("tool.json")).unwrap();
    for words in [
        "\"source_error\": 0.450335",
        "\"said_tip_error_mm\": 0.5",
        "\"transform\": \"StylusTipToStylus\"",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    // Its content is sealed like any calibration's: an error that is made smaller afterwards is no calibration.
    let changed = ToolFile::parse(&text.replace("\"said_tip_error_mm\": 0.5", "\"said_tip_error_mm\": 0.1"));
    assert!(matches!(changed, Err(FileError::OtherId { .. })));
}

/// With `--from` and `--to` exchanged the way back was taken for the tool's frame, and a word in a line told it.
#[test]
fn a_device_set_is_turned_round_when_that_is_said_and_not_else() {
    let folder = TempDir::new().unwrap();
    let there = plus::Definition::new("StylusTip", "Stylus", &planted::<Marker, Tool>());
    let back = plus::Definition::new("Stylus", "StylusTip", &planted::<Marker, Tool>().inverse());
    let write = |definitions: &[plus::Definition]| {
        let definitions = definitions.to_vec();
        fs::write(
            folder.path().join("set.xml"),
            plus::write(&plus::DeviceSet { definitions }),
        )
        .unwrap();
    };
    let refused = |line: &str| {
        let line = format!("calib import DIR/set.xml {line} {SAID} --out DIR/none.json");
        let said = calib(&folder, &line).unwrap_err();
        assert!(!folder.path().join("none.json").exists());
        said
    };
    write(std::slice::from_ref(&there));
    let said = refused("--from Stylus --to StylusTip");
    assert!(said.contains("exchange --from and --to"), "{said}");
    assert!(refused("--from StylusTip --to Stylus --backwards").contains("the way there"));
    write(std::slice::from_ref(&back));
    assert!(refused("--from StylusTip --to Stylus").contains("has StylusToStylusTip alone"));
    let tool = imported(&folder, "DIR/set.xml --from StylusTip --to Stylus --backwards");
    assert!(off(&tool).iter().all(|off| *off < 1e-9), "{:?}", off(&tool));
    // Both ways, of which the one is another tool's.
    write(&[
        there.clone(),
        plus::Definition {
            rows: there.rows,
            ..back.clone()
        },
    ]);
    assert!(refused("--from StylusTip --to Stylus").contains("contradict one another"));
    write(&[there, back]);
    let tool = imported(&folder, "DIR/set.xml --from StylusTip --to Stylus");
    assert!(off(&tool).iter().all(|off| *off < 1e-9), "{:?}", off(&tool));
}

/// The matrix is put right about the file's centre: the tip, far from it, moved by a millimetre, and the error that was said stayed.
#[test]
fn a_tip_that_putting_right_moves_is_refused_beside_the_error_that_is_said() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str, centre: &str, z: &str| {
        let head = "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\n";
        let text = format!(
            "{head}Parameters: 1.000115 0 0 0 1.000115 0 0 0 1.000115 12.5 -40 {z}\nFixedParameters: {centre}\n"
        );
        fs::write(folder.path().join(name), text).unwrap();
    };
    file("near.tfm", "0 0 0", "160");
    file("far.tfm", "9000 0 0", "160");
    file("long.tfm", "0 0 0", "1160");
    for (line, words) in [
        ("DIR/far.tfm --holds marker-from-tool", "moves the tip by 1.0350 mm"),
        // Tip and origin are 1160 mm apart in the file.
        ("DIR/long.tfm --holds tool-from-marker", "moves the tip by 0.133"),
        ("DIR/long.tfm --holds slicer-node", "moves the tip by 0.133"),
    ] {
        let line = format!("calib import {line} {SAID} --out DIR/tool.json");
        let said = calib(&folder, &line).unwrap_err();
        assert!(
            said.contains(words) && said.contains("a tenth of the error that you say, 0.5 mm"),
            "{said}"
        );
    }
    let fine = "calib import DIR/near.tfm --holds marker-from-tool --shaft x --tip-error-mm 0.5 --axis-error-deg 0.05 --out DIR/tool.json";
    let said = calib(&folder, fine).unwrap_err();
    assert!(said.contains("moves the shaft by up to 0.0114 degrees"), "{said}");
    let tool = imported(&folder, "DIR/near.tfm --holds marker-from-tool");
    assert_eq!(tool.marker_from_tool.transform().translation_mm(), [12.5, -40.0, 160.0]);
}

#[test]
fn a_transform_is_what_it_is_said_to_map_and_something_else_if_that_is_wrong() {
    let folder = TempDir::new().unwrap();
    let given = planted::<Marker, Tool>();
    let files = [
        ("marker-from-tool", itk::write(&given)),
        ("tool-from-marker", itk::write(&given.inverse())),
        ("slicer-node", itk::write(&itk::slicer_file(&given))),
    ];
    for (written, text) in &files {
        fs::write(folder.path().join("a.tfm"), text).unwrap();
        for (holds, _) in &files {
            let tool = imported(&folder, &format!("DIR/a.tfm --holds {holds}"));
            let [tip, shaft] = off(&tool);
            match written == holds {
                true => assert!(tip < 1e-9 && shaft < 1e-12, "{holds}: {tip} {shaft}"),
                false => assert!(tip > 10.0, "{written} read as {holds}: {tip}"),
            }
        }
    }
}

#[test]
fn what_nobody_says_is_refused_with_what_to_say() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let given = planted::<Marker, Tool>();
    file("a.tfm", &itk::write(&given));
    file(
        "near.tfm",
        &itk::write(&Rigid::<Marker, Tool>::from_parts(
            given.rotation(),
            Vector::new(0.0125, -0.04, 0.16),
        )),
    );
    file("set.xml", &plus::write(&plus::DeviceSet::default()));
    file("a.csv", "1,2,3");
    for (line, words) in [
        (format!("DIR/a.tfm {SAID}"), "say it with --holds"),
        (
            format!("DIR/a.tfm {SAID} --holds ct-from-tracker"),
            "which holds the frame of a tool in its marker",
        ),
        (
            format!("DIR/near.tfm {SAID} --holds marker-from-tool"),
            "looks like metres",
        ),
        (format!("DIR/set.xml {SAID}"), "say the tool's frame with --from"),
        (
            format!("DIR/set.xml {SAID} --from A --to B"),
            "no transform from \"A\" to \"B\"",
        ),
        (
            format!("DIR/a.csv {SAID}"),
            ".tfm, .txt and .h5 of ITK and .xml of PLUS are known",
        ),
        (format!("DIR/none.tfm {SAID} --holds marker-from-tool"), "none.tfm"),
        (format!("DIR {SAID} --holds marker-from-tool"), "known"),
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --axis-error-deg 1".to_owned(),
            "--tip-error-mm",
        ),
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --tip-error-mm 1".to_owned(),
            "--axis-error-deg",
        ),
        // A covariance of nothing, which gates believe, and one that no first order holds for.
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --tip-error-mm 1e-170 --axis-error-deg 1".to_owned(),
            "expected 0.001 to 20 mm",
        ),
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --tip-error-mm 1 --axis-error-deg 170".to_owned(),
            "expected 0.001 to 10 degrees",
        ),
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --tip-error-mm 1 --axis-error-deg 1e-300".to_owned(),
            "expected 0.001 to 10 degrees",
        ),
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --tip-error-mm nan --axis-error-deg 1".to_owned(),
            "expected 0.001 to 20 mm",
        ),
        (
            "DIR/a.tfm --holds marker-from-tool --tip-error-mm 1 --axis-error-deg 1".to_owned(),
            "--shaft",
        ),
        (
            "DIR/a.tfm --holds marker-from-tool --shaft x --tip-error-mm 0 --axis-error-deg 1".to_owned(),
            "expected 0.001 to 20 mm",
        ),
    ] {
        let said = calib(&folder, &format!("calib import {line} --out DIR/tool.json")).unwrap_err();
        assert!(said.contains(words), "{line}: {said}");
        assert!(!folder.path().join("tool.json").exists(), "{line}");
    }
    let metres = imported(&folder, "DIR/near.tfm --holds marker-from-tool --unit m");
    assert!((metres.marker_from_tool.transform().translation_mm()[2] - 160.0).abs() < 1e-9);
}

#[test]
fn a_tool_goes_out_and_comes_back_by_every_way() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("a.tfm"), itk::write(&planted::<Marker, Tool>())).unwrap();
    let tool = imported(&folder, "DIR/a.tfm --holds marker-from-tool");
    fs::rename(folder.path().join("tool.json"), folder.path().join("scope.json")).unwrap();
    let there = |line: &str| calib(&folder, &format!("calib export DIR/scope.json {line} --overwrite")).unwrap();
    for (out, back) in [
        (
            "--out DIR/b.tfm --holds marker-from-tool",
            "DIR/b.tfm --holds marker-from-tool",
        ),
        (
            "--out DIR/b.txt --holds tool-from-marker",
            "DIR/b.txt --holds tool-from-marker",
        ),
        ("--out DIR/b.tfm --holds slicer-node", "DIR/b.tfm --holds slicer-node"),
        ("--out DIR/b.xml --from Tip --to Ball", "DIR/b.xml --from Tip --to Ball"),
    ] {
        there(out);
        // Trocar's own frame has its shaft along the third axis.
        let line = format!(
            "calib import {back} {} --out DIR/tool.json --overwrite",
            SAID.replace("--shaft x", "--shaft z")
        );
        calib(&folder, &line).unwrap();
        let again = ToolFile::parse(&fs::read_to_string(folder.path().join("tool.json")).unwrap()).unwrap();
        let p = Point::<Tool>::new(10.0, -20.0, 30.0);
        let [a, b] = [&tool, &again].map(|tool| tool.marker_from_tool.transform() * p);
        assert!(a.distance(b) < 1e-9, "{out}: {}", a.distance(b));
    }
    for (line, words) in [
        (
            "--out DIR/c.h5 --holds marker-from-tool",
            "WriteTransform(ReadTransform",
        ),
        (
            "--out DIR/c.tfm --holds ct-from-tracker",
            "which holds marker_from_tool",
        ),
        ("--out DIR/c.tfm", "say what is to be in it with --holds"),
        ("--out DIR/c.xml", "with --from"),
        ("--out DIR/c.xml --from Tip --to Tip", "are one name"),
        (
            "--out DIR/c.xml --from T\u{e9} --to Ball",
            "a name is 1 to 64 of the characters",
        ),
        (
            "--out DIR/c.xml --from \"Tip --to Ball",
            "a name is 1 to 64 of the characters",
        ),
        (
            "--out DIR/a.tfm --holds marker-from-tool",
            "there is a file of this name",
        ),
    ] {
        let said = calib(&folder, &format!("calib export DIR/scope.json {line}")).unwrap_err();
        assert!(said.contains(words), "{line}: {said}");
    }
}

/// The whole way of a registration into 3D Slicer: its node takes what the localizer says, as it came, to the patient in RAS.
#[test]
fn a_registration_in_slicer_takes_the_localizers_own_axes_to_ras() {
    let folder = TempDir::new().unwrap();
    let given = planted::<Ct, Tracker>();
    let points = [
        [0.0, 0.0, 0.0],
        [100.0, 5.0, 0.0],
        [0.0, 90.0, -3.0],
        [10.0, 20.0, 80.0],
    ];
    let mut pairs = "from_x,from_y,from_z,to_x,to_y,to_z\n".to_owned();
    for [x, y, z] in points {
        // A tenth of a millimetre off, so that there is an error to be had.
        let [a, b, c] = (given * Point::<Tracker>::new(x + 0.05, y - 0.05, z)).mm();
        pairs += &format!("{x},{y},{z},{a},{b},{c}\n");
    }
    fs::write(folder.path().join("pairs.csv"), pairs).unwrap();
    calib(
        &folder,
        "calib register --pairs DIR/pairs.csv --to ct --from tracker --noise-mm 0.2 --out DIR/r.json",
    )
    .unwrap();
    let held = |holds: &str| {
        calib(
            &folder,
            &format!("calib export DIR/r.json --holds {holds} --out DIR/r.tfm --overwrite"),
        )
        .unwrap();
        fs::read(folder.path().join("r.tfm")).unwrap()
    };
    let ct_from_tracker = itk::read::<Ct, Tracker>(&held("ct-from-tracker")).unwrap().to_from_from;
    let back = itk::read::<Tracker, Ct>(&held("tracker-from-ct")).unwrap().to_from_from;
    let file = itk::read::<Tracker, Ct>(&held("slicer-node")).unwrap().to_from_from;
    for [x, y, z] in points {
        let p = Point::<Tracker>::new(x, y, z);
        let lps = ct_from_tracker * p;
        assert!((back * lps).distance(p) < 1e-9);
        // As Slicer reads a file: its node is the inverse of what the file holds, with the axes of both sides turned.
        let half = |[x, y, z]: [f64; 3]| [-x, -y, z];
        let [x, y, z] = half(p.mm());
        let shown = half((file.inverse() * Point::<Tracker>::new(x, y, z)).mm());
        let ras = half(lps.mm());
        assert!(
            shown.iter().zip(ras).all(|(a, b)| (a - b).abs() < 1e-9),
            "{shown:?} {ras:?}"
        );
    }
    let said = calib(
        &folder,
        "calib export DIR/r.json --holds marker-from-tool --out DIR/x.tfm",
    )
    .unwrap_err();
    assert!(said.contains("which holds ct_from_tracker"), "{said}");
    let said = calib(&folder, "calib export DIR/r.json --from A --to B --out DIR/x.xml").unwrap_err();
    assert!(said.contains("write a registration as .tfm"), "{said}");
}
