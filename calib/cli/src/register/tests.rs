//! The command in the test's own process.

use std::fs;

use calib::pose::radius_95_mm;
use chance::SplitMix64;
use geometry::{Affine, Point, Uncertain, VolumeGrid};
use tempfile::TempDir;

use crate::commands::tests::calib;
use crate::input_files::source::Source;
use crate::register::input::Input;
use crate::register::row::Row;
use crate::register::solve::{From, Options, Solution, solve};

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
    calib(line.trim_end()).map(|outcome| outcome.text)
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

/// A pair's frames were taken from the command line, against what its comment says.
#[test]
fn pairs_of_touches_keep_the_frame_that_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pairs.csv");
    let rows = "0,0,0,1,0,0\n9,0,0,10,0,0\n0,9,0,1,9,0\n0,0,9,1,0,9\n";
    let places = "# places of the tip of scope in the reference, mm";
    fs::write(
        &path,
        format!("# ward 4\n{places}\nfrom_x,from_y,from_z,to_x,to_y,to_z\n{rows}"),
    )
    .unwrap();
    let error = calib(&format!("calib register --pairs {} --from tracker", path.display()));
    let error = error.err().unwrap();
    assert!(error.contains("in the reference, and tracker is said"), "{error}");
    assert!(
        calib(&format!("calib register --pairs {}", path.display()))
            .unwrap()
            .text
            .contains("to_from_reference")
    );
}

/// Metres were taken for millimetres, and points that the CT does not show for points of it.
#[test]
fn points_of_no_patient_and_points_outside_the_ct_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let metres = "0 0 0\n0.06 0 0\n0 0.08 0\n0 0 0.05\n";
    for (files, side) in [([metres, PLACES], "to"), ([PLACES, metres], "from")] {
        let error = registered(&folder, files, "").err().unwrap();
        let words = format!("the box around the {side} points is 0.112 mm across, expected at least 5 mm");
        assert!(error.contains(&words), "{error}");
    }
    assert!(registered(&folder, [PLACES, metres], "--scale").is_ok());
    let source = Source::from_bytes("to.txt".as_ref(), PLACES.into()).unwrap();
    let from = Source::from_bytes("from.txt".as_ref(), PLACES.into()).unwrap();
    let input = Input::from_points(source, from).unwrap();
    let grid = |half_mm: f64| {
        let map = Affine::from_rows([
            [2.0, 0.0, 0.0, -half_mm],
            [0.0, 2.0, 0.0, -half_mm],
            [0.0, 0.0, 2.0, -half_mm],
        ]);
        VolumeGrid::checked([half_mm as i64 + 1; 3], map).unwrap()
    };
    assert!(input.refuse_outside(&grid(80.0)).is_ok());
    let error = input.refuse_outside(&grid(70.0)).unwrap_err().to_string();
    assert!(
        error.contains("to.txt: line 3: the point [-75.0, 0.0, -7.0] of the CT lies outside it"),
        "{error}"
    );
}

/// The radius that holds 95 % of errors held 77 of 100 with three pairs, whose noise was estimated from three degrees of freedom.
#[test]
fn the_radius_holds_its_share_of_errors_with_few_pairs() {
    const DRAWS: u32 = 2000;
    // The share of 2000 draws of 0.95 has the deviation sqrt(0.95 0.05 / 2000); four of them.
    let bound = 4.0 * (0.95_f64 * 0.05 / f64::from(DRAWS)).sqrt();
    let body = [
        [-60.0, 0.0, 0.0],
        [60.0, 10.0, 0.0],
        [0.0, 70.0, 20.0],
        [10.0, -60.0, 40.0],
        [0.0, 0.0, 80.0],
        [30.0, 30.0, -50.0],
        [-40.0, 50.0, 30.0],
        [-50.0, -40.0, -20.0],
        [20.0, -30.0, -70.0],
        [70.0, -50.0, 10.0],
    ];
    let mut random = SplitMix64::new(7);
    let mut normal = move || {
        let [radius, angle] = [0, 1].map(|_| random.around(0.5, 0.5));
        (-2.0 * (1.0 - radius).ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    };
    for pairs in [3, 4, 5, 6, 10] {
        let centre: [f64; 3] = std::array::from_fn(|k| body[..pairs].iter().map(|p| p[k]).sum::<f64>() / pairs as f64);
        let mut held = [0; 2];
        for _ in 0..DRAWS {
            let row = |p: &[f64; 3]| Row {
                lines: [1; 2],
                to: *p,
                from: p.map(|x| x + 0.5 * normal()),
                weight: 1.0,
                label: String::new(),
                error: None,
            };
            let rows: Vec<Row> = body[..pairs].iter().map(row).collect();
            let found = solve(&rows, &Options::default(), "").unwrap();
            let to_from = Uncertain::new(found.registration.fit.transform, found.covariance().unwrap()).unwrap();
            // In the middle the error is alike in all directions, and the share is exact; elsewhere it is somewhat more.
            for (held, place) in held.iter_mut().zip([centre, [10.0, 20.0, 150.0]]) {
                let point = Point::new(place[0], place[1], place[2]);
                let placed = to_from * Point::<From>::new(place[0], place[1], place[2]);
                *held += u32::from(placed.point().distance(point) <= radius_95_mm(&placed.covariance()));
            }
        }
        let [middle, apart] = held.map(|held| f64::from(held) / f64::from(DRAWS));
        assert!((middle - 0.95).abs() < bound, "{pairs} pairs: {middle}");
        assert!((0.95 - bound..0.97 + bound).contains(&apart), "{pairs} pairs: {apart}");
        assert!(pairs > 3 || middle > 0.9);
    }
    // Known noise stays as it was told.
    let rows: Vec<Row> = body.iter().map(|p| exact(*p)).collect();
    let told = Options {
        noise_mm: Some(0.5),
        ..Options::default()
    };
    let found = solve(&rows, &told, "").unwrap();
    assert!(found.estimated.is_none());
    let middle = rms_in_the_middle(&found);
    assert!((middle - 0.5 * (3.0_f64 / 10.0).sqrt()).abs() < 1e-12, "{middle}");
}

fn exact(point: [f64; 3]) -> Row {
    Row {
        lines: [1; 2],
        to: point,
        from: point,
        weight: 1.0,
        label: String::new(),
        error: None,
    }
}

fn rms_in_the_middle(found: &Solution) -> f64 {
    let [x, y, z] = found.registration.centre().mm();
    found.predicted_tre_mm(Point::new(x, y, z))
}

/// Places in a plane with x and y exchanged were registered, predicted to 0.6 mm and passed, 160 mm off at a target.
#[test]
fn a_registration_by_points_in_a_plane_says_so_and_passes_at_no_point_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let to = "-60 0 0\n60 10 0\n0 70 0\n30 -40 0\n";
    let swapped = "0 -60 0\n10 60 0\n70 0 0\n-40 30 0\n";
    let out = folder.path().join("r.json");
    let more = format!(
        "--to ct --from tracker --noise-mm 0.3 --target=5,5,80 --target=5,5,0 --out {} --overwrite",
        out.display()
    );
    let text = registered(&folder, [to, swapped], &more).unwrap();
    assert!(text.contains("the points lie in a plane to their noise"), "{text}");
    assert!(text.contains("the target 5.000, 5.000, 80.000 would be 160"), "{text}");
    assert!(!text.contains("the target 5.000, 5.000, 0.000 would be"), "{text}");
    let checked = |known: &str, touched: &str| {
        let line = format!(
            "calib check {} --known={known} --touched={touched} --json",
            out.display()
        );
        let outcome = calib(&line).unwrap();
        let record: serde_json::Value = serde_json::from_str(&outcome.text).unwrap();
        (
            record["verdict"].as_str().unwrap().to_owned(),
            record["off_plane_mm"].as_f64().unwrap(),
        )
    };
    let (verdict, off_mm) = checked("0,30,0", "30,0,0");
    assert_eq!(verdict, "warn");
    assert!(off_mm < 1e-9, "{off_mm}");
    // Off the plane the mirrored registration fails, and the true one passes.
    assert_eq!(checked("0,30,40", "30,0,40").0, "fail");
    assert_eq!(checked("0,30,40", "30,0,-40").0, "pass");
    // Points that tell their mirror image, say nothing.
    let text = registered(&folder, [PLACES, "0 0 0\n60 0 0\n0 80 0\n0 0 50\n"], &more).unwrap();
    assert!(!text.contains("plane"), "{text}");
}

/// The marker that a scene names was not asked for, and names that a file does not have were passed over.
#[test]
fn a_check_asks_for_the_names_that_it_is_given_and_for_the_marker_of_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (out, scene) = (folder.path().join("r.json"), folder.path().join("scene.toml"));
    let check = |more: &str| {
        let line = format!(
            "calib check {} --known=5,0,-7 --touched=0,0,0 --touch-mm 5 {more}",
            out.display()
        );
        calib(line.trim_end()).err()
    };
    let made = |more: &str| {
        let more = format!(
            "--to ct --from tracker --noise-mm 0.3 --out {} --overwrite {more}",
            out.display()
        );
        registered(&folder, [PLACES, "0 0 0\n60 0 0\n0 80 0\n0 0 50\n"], &more).unwrap();
    };
    made("");
    assert_eq!(check(""), None);
    for (more, words) in [
        (
            "--marker leg",
            "does not say of which marker it is, and \"leg\" is used",
        ),
        ("--ct-hash abc", "does not say of which CT it is, and \"abc\" is used"),
    ] {
        let error = check(more).unwrap();
        assert!(error.contains(words), "{error}");
    }
    made("--marker leg");
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/operating-room.toml")).unwrap();
    fs::write(
        &scene,
        format!("{text}\n[tracker.registration]\nfile = \"r.json\"\nmarker = \"skull\"\n"),
    )
    .unwrap();
    let error = check(&format!("--scene {}", scene.display())).unwrap();
    assert!(error.contains("is of marker \"leg\", \"skull\" is used"), "{error}");
    assert_eq!(check("--marker leg"), None);
    // One that names none passed for one of the scene's marker.
    made("");
    let error = check(&format!("--scene {}", scene.display())).unwrap();
    assert!(
        error.contains("does not say of which marker it is, and \"skull\" is used"),
        "{error}"
    );
}

/// Two of six pairs exchanged were registered with 0.22 mm predicted and 69 true, as the noise told was taken as it was.
#[test]
fn pairs_that_a_noise_does_not_explain_are_not_registered_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let from = "0 0 0\n90 0 0\n0 80 0\n0 0 70\n60 50 0\n0 60 55\n";
    let to = "5 0 0\n95 0 0\n5 0 70\n5 80 0\n65 50 0\n5 60 55\n";
    let out = folder.path().join("r.json");
    let told = format!("--to ct --from tracker --noise-mm 0.3 --out {}", out.display());
    let error = registered(&folder, [to, from], &told).err().unwrap();
    assert!(error.contains("are none of a noise of 0.3 mm"), "{error}");
    assert!(!out.exists());
    // The same by touches, and as what the residuals show.
    let text = registered(&folder, [to, from], "--to ct --from tracker").unwrap();
    assert!(text.contains("estimated from the residuals"), "{text}");
    // With the two outliers named there is nothing to refuse.
    assert!(registered(&folder, [to, from], &format!("{told} --robust 1 --min-inliers 4")).is_ok());
}

/// Of a noise told 1.5 times too small the predicted radius held as few as a known noise's would; of one told right it stays.
#[test]
fn residuals_that_show_more_noise_than_was_told_make_errors_larger() {
    let mut random = SplitMix64::new(77);
    // Nearly normal, deviation 1: the sum of twelve even numbers.
    let mut normal = || (0..12).map(|_| random.bits() as f64 / 2.0_f64.powi(64)).sum::<f64>() - 6.0;
    let body = [
        [0.0, 0.0, 0.0],
        [90.0, 0.0, 0.0],
        [0.0, 80.0, 0.0],
        [0.0, 0.0, 70.0],
        [60.0, 50.0, 20.0],
    ];
    let (mut accepted, mut held, mut held_told) = (0.0, 0.0, 0.0);
    for _ in 0..400 {
        let rows: Vec<Row> = body
            .iter()
            .map(|p| Row {
                to: p.map(|x| x + 0.45 * normal()),
                ..exact(*p)
            })
            .collect();
        let options = Options {
            noise_mm: Some(0.3),
            ..Options::default()
        };
        let Ok(found) = solve(&rows, &options, "") else {
            continue;
        };
        let centre = found.registration.centre();
        let middle = Point::<From>::new(30.0, 26.0, 18.0);
        let off = (found.registration.fit.transform * middle).mm();
        let off = (0..3)
            .map(|k| (off[k] - [30.0, 26.0, 18.0][k]).powi(2))
            .sum::<f64>()
            .sqrt();
        let radius = 2.7955 / 3.0_f64.sqrt()
            * found.predicted_tre_mm(Point::new(centre.mm()[0], centre.mm()[1], centre.mm()[2]));
        let told = 2.7955 * 0.3 / 5.0_f64.sqrt();
        accepted += 1.0;
        held += f64::from(u8::from(off <= radius));
        held_told += f64::from(u8::from(off <= told));
    }
    // Four deviations of 400 at 95 % are 0.044; what is refused are those of the largest residuals, which costs some.
    assert!(accepted > 300.0, "{accepted}");
    assert!(held / accepted > 0.88, "{}", held / accepted);
    assert!(held_told / accepted < 0.8, "{}", held_told / accepted);
}
