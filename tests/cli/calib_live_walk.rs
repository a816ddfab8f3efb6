//! The whole way to a navigated instrument while a run goes on: its tip, the calibration base, its seat, the patient, the check.
//! The test is the localizer, and holds the instrument.

#![allow(clippy::print_stdout, reason = "the figures of the calibration")]

mod localizer;

use std::path::Path;
use std::process::Output;

use crate::support::links::CT_FROM_TRACKER;
use crate::support::{SMALL, World, stderr, stdout, wait_for};
use bus::run::RunContext;
use geometry::{Base, Ct, Marker, Point, Rigid, Tool, Tracker, Vector, checked};
use localizer::{EMITTERS_MM, Held, Localizer, NOISE_MM, NOISE_RAD, marker_from_tool, tool};
use serde_json::Value;

const DRAWING: &str = "[plane]\nat_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
    [[groove]]\nstart_mm = [15, 0, -4]\nend_mm = [60, 0, -4]\nhalf_angle_deg = 45\n\
    [[groove]]\nstart_mm = [-3, 15, -4]\nend_mm = [-10, 60, -4]\nhalf_angle_deg = 45\n\
    [[groove]]\nstart_mm = [-15, -15, -4]\nend_mm = [-45, -45, -4]\nhalf_angle_deg = 45\n\
    [seat]\nquaternion = [1, 0, 0, 0]\ntranslation_mm = [5, -7, 80]\nsigma_mm = 0.05\nsigma_deg = 0.02\n";
const SEAT_MM: [f64; 3] = [5.0, -7.0, 80.0];

/// Where the base stands.
fn tracker_from_base() -> Rigid<Tracker, Base> {
    Rigid::from_rotation_vector(Vector::new(0.3, 0.1, -0.6), Vector::new(-120.0, 60.0, 1900.0)).unwrap()
}

fn scene() -> String {
    let list = EMITTERS_MM.map(|at| format!("{{ at_mm = {at:?} }}")).join(", ");
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"emitters\"\n")
        + &format!(
            "[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n[tracker.calibration.gates]\nmax_rms_mm = 1.5\n\
             max_tip_error_mm = 1.0\n[tracker.registration]\nfile = \"registration.json\"\n[tracker.registration.gates]\n\
             max_fre_mm = 1.0\nmax_tre_mm = 4.0\n[tracker.emitters.marker]\nemitters = [{list}]\n\
             [tracker.emitters.localizer]\nacross_mm = {NOISE_MM}\ndepth_mm = {NOISE_MM}\ngrowth_across = 0.0\ngrowth_depth = 0.0\n"
        )
}

/// A world with a run in it, and the test as its localizer.
struct Walk {
    world: World,
}

impl Walk {
    fn calibrate(&self, line: &str) -> Output {
        let word = |word: &str| match word.strip_prefix('@') {
            Some(file) => self.world.path(file).to_string_lossy().into_owned(),
            None => word.to_owned(),
        };
        let words: Vec<String> = format!("calibrate {line}").split(' ').map(word).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        self.world.output("pilot", &words)
    }

    /// What stdout says of a step that succeeds.
    fn done(&self, line: &str) -> String {
        let output = self.calibrate(line);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        stdout(&output)
    }

    /// Exit code 1, one paragraph with all of `words`, and no file.
    fn refused(&self, line: &str, file: &str, words: &str) {
        let output = self.calibrate(line);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{line}: {said}{}", stdout(&output));
        let is_it = |line: &&str| line.contains("error: ") && words.split(" | ").all(|word| line.contains(word));
        assert_eq!(said.lines().filter(is_it).count(), 1, "{words:?} in\n{said}");
        assert!(!self.world.path(file).exists(), "{file} after {line}");
    }

    fn json(&self, file: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.world.path(file)).unwrap()).unwrap()
    }
}

/// Where each touch is on the base, by name.
fn base_touches() -> Vec<(&'static str, [f64; 3])> {
    let mut list = vec![
        ("plane", [45.0, 30.0, 0.0]),
        ("plane", [-40.0, 20.0, 0.0]),
        ("plane", [10.0, -50.0, 0.0]),
    ];
    for s in [0.1, 0.5, 0.9] {
        list.push(("groove_0", [15.0 + 45.0 * s, 0.0, -4.0]));
        list.push(("groove_1", [-3.0 - 7.0 * s, 15.0 + 45.0 * s, -4.0]));
        list.push(("groove_2", [-15.0 - 30.0 * s, -15.0 - 30.0 * s, -4.0]));
    }
    list
}

#[test]
fn an_instrument_is_calibrated_in_its_seat_and_the_patient_registered_while_the_run_goes_on() {
    let walk = Walk { world: World::new() };
    let world = &walk.world;
    world.file("base.toml", DRAWING);
    let pilot = world.start(&world.file("s.toml", &scene()), &world.path("out"), "default");
    let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
    pilot.wait_for("the tracker", |status| {
        crate::support::pid_in(status, "tracker").is_some()
    });
    let localizer = Localizer::start(&context);
    tip_of(&walk);
    seat(&walk, &localizer);
    let tracker_from_ct = register(&walk, &localizer);
    check(&walk, &localizer, tracker_from_ct);
    // Both files are in use.
    pilot.wait_live();
    drop(localizer);
    assert!(pilot.stop().success());
}

/// The same tip of the poses that a localizer makes itself.
#[test]
fn a_tip_is_calibrated_of_poses_that_a_localizer_makes() {
    let walk = Walk { world: World::new() };
    let world = &walk.world;
    let text = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
        + &format!(
            "[tracker.markers]\nmarker = \"T\"\nnoise_mm = {NOISE_MM}\nnoise_deg = {}\n[tracker.calibration]\nfile = \"tool.json\"\n\
             [tracker.calibration.gates]\nmax_rms_mm = 1.5\nmax_tip_error_mm = 1.0\n",
            NOISE_RAD.to_degrees()
        );
    let pilot = world.start(&world.file("s.toml", &text), &world.path("out"), "default");
    let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
    pilot.wait_for("the tracker", |status| {
        crate::support::pid_in(status, "tracker").is_some()
    });
    let localizer = Localizer::start_with_poses(&context);
    tip_of(&walk);
    let tip = walk.json("tip.json");
    let numbers = |key: &str| -> Vec<f64> {
        tip["pivot"][key]
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    let built = (marker_from_tool() * Point::<Tool>::new(0.0, 0.0, 0.0)).mm();
    let off = built
        .iter()
        .zip(numbers("tip_mm"))
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt();
    let c = numbers("covariance_upper_mm2");
    let rms = (c[0] + c[6] + c[11]).sqrt();
    println!("tip off by {off:.4} mm, by its covariance {rms:.4} mm rms");
    // Beyond four times its root mean square an error has a chance of 1e-6, in whichever directions it may be.
    assert!(off < 4.0 * rms && rms < 0.2, "{off} mm, {rms} mm");
    drop(localizer);
    // A run without a picture of a pose is no success.
    let _ = pilot.stop();
}

/// The tip, for touching.
fn tip_of(walk: &Walk) {
    let said = walk.done("pivot --seconds 4 --out @tip.json");
    assert!(
        said.contains("max_tip_error_mm 1 (tracker.calibration.gates of run default): found"),
        "{said}"
    );
    // A tighter gate of the command line goes before the scene's.
    walk.refused(
        "pivot --seconds 2 --max-tip-error-mm 0.0001 --out @no.json",
        "no.json",
        "not accepted: --max-tip-error-mm 0.0001: found",
    );
    walk.refused(
        "spin --seconds 2 --towards 0,0,1 --max-rms-mm 0.0001 --out @no.json",
        "no.json",
        "spin calibration from the",
    );
}

/// The base, and the tool in its seat.
fn seat(walk: &Walk, localizer: &Localizer) {
    for (i, (name, [x, y, z])) in base_touches().into_iter().enumerate() {
        let lean = Vector::new(0.2 * (i as f64).sin(), 0.2 * (i as f64).cos(), 0.1 * i as f64);
        localizer.hold(Held::Still(tool(lean, tracker_from_base() * Point::new(x, y, z))));
        let said = walk.done(&format!("touch {name} --tip @tip.json --seconds 0.6 --to @base.csv"));
        assert!(said.contains("gate             max_rms_mm 1.5"), "{said}");
    }
    walk.done("base @base.csv --drawing @base.toml --out @base.json");
    assert_eq!(walk.json("base.json")["base"]["of_frame"], "tracker");

    let [x, y, z] = SEAT_MM;
    let drawn: Rigid<Base, Tool> = Rigid::from_parts(Rigid::<Base, Tool>::identity().rotation(), Vector::new(x, y, z));
    let seated = tracker_from_base() * drawn;
    localizer.hold(Held::Walking(seated, 3.0));
    walk.refused(
        "seat --base @base.json --seconds 2 --out @tool.json",
        "tool.json",
        "the tool in its seat from the | of run default | moved",
    );
    localizer.hold(Held::Still(seated));
    walk.refused(
        "seat --base @base.json --seconds 1 --max-tip-error-mm 0.0001 --out @tool.json",
        "tool.json",
        "--max-tip-error-mm 0.0001: found",
    );
    walk.refused(
        "seat --base @base.json --seconds 1 --against reference --out @tool.json",
        "tool.json",
        "reference has nothing to go by",
    );
    let said = walk.done("seat --base @base.json --seconds 2 --out @tool.json");
    for words in [
        "residuals ",
        "condition ",
        "max_rms_mm 1.5 (tracker.calibration.gates of run default)",
    ] {
        assert!(said.contains(words), "{words:?} in\n{said}");
    }
    println!("{said}");
    check_tool(&walk.json("tool.json"));
}

/// The frame that was found is the one that was built, within its covariance.
fn check_tool(file: &Value) {
    let frame = &file["tool_frame"];
    let numbers = |key: &str| -> Vec<f64> {
        frame[key]
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    let (q, t) = (numbers("quaternion_wxyz"), numbers("translation_mm"));
    let found: Rigid<Marker, Tool> = checked::rigid(q.try_into().unwrap(), t.try_into().unwrap(), 1e-9).unwrap();
    let uncertain = geometry::Uncertain::from_upper(found, numbers("covariance_upper").try_into().unwrap()).unwrap();
    let origin = Point::<Tool>::new(0.0, 0.0, 0.0);
    let off = (found * origin).distance(marker_from_tool() * origin);
    let rms = (uncertain * origin).rms_mm();
    println!("tip off by {off:.4} mm, by its covariance {rms:.4} mm rms");
    // Beyond four times its root mean square an error has a chance of 1e-6, in whichever directions it may be.
    assert!(off < 4.0 * rms && rms < 1.0, "{off} mm, {rms} mm");
    assert_eq!((&file["kind"], &file["marker"]), (&"tool".into(), &"ball".into()));
    assert!(file["seat"]["rms_mm"].as_f64().unwrap() > 0.0 && file["seat"]["condition"].as_f64().unwrap() >= 1.0);
    let of = "tracker.calibration.gates of run default";
    assert!(
        file["gates"].as_array().unwrap().iter().any(|gate| gate["of"] == of),
        "{file}"
    );
}

const TOUCHED_CT: [[f64; 3]; 5] = [
    [90.0, 0.0, 0.0],
    [-90.0, 10.0, 30.0],
    [0.0, 80.0, -40.0],
    [10.0, -80.0, 60.0],
    [40.0, 30.0, 110.0],
];

/// The patient, from points touched with the tool in its new calibration.
fn register(walk: &Walk, localizer: &Localizer) -> Rigid<Tracker, Ct> {
    let (q, t) = CT_FROM_TRACKER;
    let ct_from_tracker: Rigid<Ct, Tracker> = checked::rigid(q, t, 1e-9).unwrap();
    let tracker_from_ct = ct_from_tracker.inverse();
    let place = |[x, y, z]: [f64; 3]| tracker_from_ct * Point::new(x, y, z);
    // A command that starts sooner than that gets frames of the touch before first.
    localizer.is_late_by_ms(300);
    for at in TOUCHED_CT {
        localizer.hold(Held::Still(tool(Vector::new(0.1, 0.2, 0.3), place(at))));
        walk.done("touch bead --seconds 0.8 --to @touched.csv");
    }
    // So late that all that comes during the touch is from before it.
    localizer.is_late_by_ms(1500);
    std::thread::sleep(std::time::Duration::from_millis(1700));
    walk.refused(
        "touch bead --seconds 0.6 --to @no.csv",
        "no.csv",
        "all were captured before it was listened to",
    );
    localizer.is_late_by_ms(0);
    let lines = |moved: f64| -> String {
        let line = |(i, [x, y, z]): (usize, &[f64; 3])| format!("{} {y} {z}\n", x + if i == 0 { moved } else { 0.0 });
        TOUCHED_CT.iter().enumerate().map(line).collect()
    };
    walk.world.file("ct.txt", &lines(0.0));
    walk.world.file("wrong.txt", &lines(15.0));
    walk.refused(
        "register --to-points @wrong.txt --from-points @touched.csv --out @registration.json",
        "registration.json",
        "max_fre_mm 1 (tracker.registration.gates of run default): found",
    );
    walk.refused(
        "register --to-points @ct.txt --from-points @touched.csv --from reference --out @registration.json",
        "registration.json",
        "its touches are in the tracker, and reference is said",
    );
    walk.refused(
        "register --to-points @ct.txt --from-points @touched.csv --ct-hash abab --out @registration.json",
        "registration.json",
        "--ct-hash \"abab\" | is of ct-hash",
    );
    let said = walk.done("register --to-points @ct.txt --from-points @touched.csv --out @registration.json");
    assert!(
        said.contains("max_tre_mm 4 (tracker.registration.gates of run default)"),
        "{said}"
    );
    let file = walk.json("registration.json");
    assert_eq!((&file["to"], &file["from"]), (&"ct".into(), &"tracker".into()));
    assert_eq!(file["gates"].as_array().unwrap().len(), 2, "{file}");
    assert!(file["ct_hash"].as_str().unwrap().len() > 16);
    tracker_from_ct
}

/// A known point is touched, and a wrong one.
fn check(walk: &Walk, localizer: &Localizer, tracker_from_ct: Rigid<Tracker, Ct>) {
    let known = [20.0, -15.0, 40.0];
    let [x, y, z] = known;
    let at = tracker_from_ct * Point::new(x, y, z);
    localizer.hold(Held::Still(tool(Vector::new(-0.1, 0.1, 0.0), at)));
    let said = walk.done("check --known 20,-15,40");
    assert!(
        said.contains("max_fre_mm 1 (tracker.registration.gates of run default)"),
        "{said}"
    );
    // The scene's bound of the error at the target is what an error may be.
    assert!(said.contains("4 mm allowed"), "{said}");
    walk.refused("check --known 30,-15,40", "no.json", "do not use this registration");
    assert!(!Path::new("no.json").exists());
}
