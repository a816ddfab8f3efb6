//! `calib surface` as it is typed, on a bone whose pose is planted.

pub(super) mod bone;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use geometry::{Ct, Point, Tracker};

use crate::cli::{Cli, run};
use crate::commands::Outcome;
use crate::register::file::RegistrationFile;
use bone::{NOISE_MM, Planted};

/// A folder with a bone and points of it.
struct Desk {
    folder: tempfile::TempDir,
    planted: Planted,
}

impl Desk {
    fn new(count: usize) -> Self {
        let desk = Self {
            folder: tempfile::tempdir().unwrap(),
            planted: Planted::new(count),
        };
        fs::write(desk.path("bone.ply"), desk.planted.ply()).unwrap();
        fs::write(desk.path("p.csv"), desk.planted.csv()).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `calib surface` with these words more; a word that begins with `@` is a file of the folder.
    fn surface(&self, words: &str) -> Result<Outcome, String> {
        let line = format!("calib surface --bone @bone.ply {words}");
        let words = line.split_whitespace().map(|word| match word.strip_prefix('@') {
            Some(name) => self.path(name).to_str().unwrap().to_owned(),
            None => word.to_owned(),
        });
        let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
        run(cli, |_| Err("no CT is read here".into()))
    }

    /// Why it is refused, wherever that is said.
    fn refused(&self, words: &str) -> String {
        match self.surface(words) {
            Err(error) => error,
            Ok(outcome) => outcome
                .refused
                .unwrap_or_else(|| panic!("{words}: accepted\n{}", outcome.text)),
        }
    }
}

const TARGET: &str = "--target 10,-20,15";

fn tre_mm(planted: &Planted, file: &RegistrationFile) -> f64 {
    let text = file.to_json().unwrap();
    let read = calib::file::RegistrationFile::parse(&text).unwrap();
    let calib::file::Registered::Fixed(found) = read.registered else {
        panic!("{text}")
    };
    let target = Point::<Ct>::new(10.0, -20.0, 15.0);
    let seen: Point<Tracker> = planted.ct_from_tracker.inverse() * target;
    (found.transform() * seen).distance(target)
}

/// From nothing, a guess and landmarks to the planted pose, in a file that a tracker reads, with a picture.
#[test]
fn points_of_a_bone_give_its_pose() {
    let desk = Desk::new(160);
    fs::write(desk.path("three.csv"), desk.planted.landmarks()).unwrap();
    let common = format!("--points @p.csv --noise-mm {NOISE_MM} {TARGET} --ct-hash ab --marker m --shared-mm 0");
    let made = desk
        .surface(&format!("{common} --out @nothing.json --picture @p.png"))
        .unwrap();
    assert_eq!(made.refused, None, "{}", made.text);
    assert!(made.text.contains("nothing speaks against it"), "{}", made.text);
    for (name, more) in [
        ("guess", "--guess @nothing.json --guess-deg 15 --guess-mm 15"),
        ("landmarks", "--landmarks @three.csv --landmark-mm 4"),
    ] {
        let made = desk.surface(&format!("{common} {more} --out @{name}.json")).unwrap();
        assert_eq!(made.refused, None, "{name}: {}", made.text);
    }
    for name in ["nothing", "guess", "landmarks"] {
        let file = RegistrationFile::read(&desk.path(&format!("{name}.json"))).unwrap();
        let predicted = file.predicted_tre[1].rms_mm.unwrap();
        // 160 points of 0.3 mm on a bone of 45 mm; three dimensions are beyond 3.2 times their rms once in a million.
        let tre = tre_mm(&desk.planted, &file);
        assert!(
            tre < 3.2 * predicted && predicted < 0.5,
            "{name}: {tre} mm, {predicted} predicted"
        );
        assert_eq!(
            (file.ct_hash.as_deref(), file.marker.as_deref(), file.method.as_str()),
            (Some("ab"), Some("m"), "surface")
        );
        let surface = file.surface.as_ref().unwrap();
        assert_eq!((surface.start.as_str(), surface.points.len()), (name, 160));
        assert!(
            surface
                .points
                .iter()
                .all(|point| point.line > 1 && point.residual_mm.abs() < 2.0)
        );
    }
    let picture = image::load_from_memory(&fs::read(desk.path("p.png")).unwrap()).unwrap();
    assert!(picture.width() > 1000, "{picture:?}");
    // The same input gives the same file.
    let again = desk.surface(&format!("{common} --out @again.json")).unwrap();
    assert_eq!(again.refused, None);
    assert_eq!(
        fs::read(desk.path("again.json")).unwrap(),
        fs::read(desk.path("nothing.json")).unwrap()
    );
}

/// What is wrong is told, nothing is written, and the numerics' verdict is an exit code.
#[test]
fn what_must_not_be_used_is_refused_and_not_written() {
    let desk = Desk::new(120);
    let told = format!("--noise-mm {NOISE_MM} {TARGET} --ct-hash ab --out @r.json");
    fs::write(desk.path("mirrored.csv"), desk.planted.mirrored_csv()).unwrap();
    fs::write(desk.path("few.csv"), first_lines(&desk.planted.csv(), 6)).unwrap();
    fs::write(desk.path("metres.csv"), desk.planted.scaled_csv(1e-3)).unwrap();
    for (words, expected) in [
        (
            format!("--points @mirrored.csv {told}"),
            "times the noise that was told",
        ),
        (format!("--points @few.csv {told}"), "5 points; 7 to"),
        (format!("--points @metres.csv {told}"), "are they in metres?"),
        (format!("--points @p.csv --noise-mm {NOISE_MM}"), "no target is given"),
        (format!("--points @p.csv {TARGET}"), "say --noise-mm"),
        (
            format!("--points @p.csv {told} --max-tre-mm 0.01"),
            "the error predicted at target 1",
        ),
        (
            format!("--points @p.csv --noise-mm 3 {TARGET} --out @r.json"),
            "no wrong pose would be noticed",
        ),
        (
            format!("--points @p.csv {told} --guess @p.csv"),
            "reading the registration",
        ),
    ] {
        let why = desk.refused(&words);
        assert!(why.contains(expected), "{words}: {why}");
        assert!(!desk.path("r.json").exists(), "{words}");
    }
}

/// It is there to be looked at: where it lay under the name that a tracker reads, it would be taken for one that was accepted.
#[test]
fn a_refused_result_is_kept_where_that_is_asked_and_nothing_reads_it_as_a_registration() {
    let desk = Desk::new(160);
    let common = format!("--points @p.csv --noise-mm {NOISE_MM} {TARGET} --ct-hash ab --shared-mm 0");
    let made = desk
        .surface(&format!("{common} --out @r.json --keep-refused @not.json"))
        .unwrap();
    assert!(
        made.refused.is_none() && !desk.path("not.json").exists(),
        "{}",
        made.text
    );
    let why = desk.refused(&format!(
        "{common} --max-tre-mm 0.01 --out @none.json --keep-refused @kept.json"
    ));
    assert!(why.contains("the error predicted at target 1"), "{why}");
    assert!(!desk.path("none.json").exists());
    let kept = fs::read_to_string(desk.path("kept.json")).unwrap();
    let why = RegistrationFile::read(&desk.path("kept.json")).unwrap_err().to_string();
    assert!(why.contains(super::REFUSED_FORMAT), "{why}");
    assert!(calib::file::RegistrationFile::parse(&kept).is_err());
    // But for its format it is what was found.
    let kept: RegistrationFile = serde_json::from_str(&kept).unwrap();
    let taken = RegistrationFile::read(&desk.path("r.json")).unwrap();
    assert_eq!((kept.transform, kept.covariance), (taken.transform, taken.covariance));
}

#[test]
fn columns_that_do_not_go_together_are_refused_with_their_place() {
    let desk = Desk::new(20);
    for (header, row, words, expected) in [
        ("x,y,z,sigma", "1,2,3,0", "", "a deviation above 0 mm"),
        ("x,y,z,sigma", "1,2,3,0.5", "--noise-mm 1", "would overrule them"),
        (
            "x,y,z,sigma,axial,lateral,elevation",
            "1,2,3,1,1,1,1",
            "",
            "in more than one way",
        ),
        (
            "x,y,z,axial,lateral,elevation",
            "1,2,3,1,1,1",
            "",
            "beam_x,beam_y,beam_z are missing",
        ),
        (
            "x,y,z,sigma,depth",
            "1,2,3,1,20",
            "",
            "beam_x,beam_y,beam_z are missing",
        ),
        (
            "x,y,z,sigma,beam_x,beam_y,beam_z",
            "1,2,3,1,0,0,2",
            "",
            "its length is 2.000000",
        ),
        (
            "x,y,z,axial,lateral,elevation,beam_x,beam_y,beam_z",
            "1,2,3,1,1,2,0,0,1",
            "",
            "which tell the two apart",
        ),
        (
            "x,y,z,sigma,beam_x,beam_y,beam_z,depth",
            "1,2,3,1,0,0,1,-5",
            "",
            "line 2 of the file",
        ),
        ("x,y,z,sigma", "1,2,NaN,1", "", "line 2, column 5 (z)"),
        ("x,y,sigma", "1,2,1", "", "no column z"),
    ] {
        let text = format!("{header}\n{}", format!("{row}\n").repeat(8));
        fs::write(desk.path("bad.csv"), text).unwrap();
        let why = desk.refused(&format!("--points @bad.csv {words} {TARGET}"));
        assert!(why.contains(expected), "{header}: {why}");
    }
}

/// Found by somebody who tried to have a wrong pose accepted.
#[test]
fn wrong_poses_that_look_right_are_refused() {
    let desk = Desk::new(160);
    let told = format!("--noise-mm {NOISE_MM} {TARGET} --ct-hash ab --shared-mm 0");
    fs::write(desk.path("late.csv"), desk.planted.moved_csv(24, 10.0)).unwrap();
    fs::write(desk.path("skin.csv"), desk.planted.skin_csv(6.0)).unwrap();
    let made = desk
        .surface(&format!("--points @p.csv {told} --out @right.json"))
        .unwrap();
    assert_eq!(made.refused, None, "{}", made.text);
    // The guess is 8 mm from where the points are.
    let text = fs::read_to_string(desk.path("right.json")).unwrap();
    let mut guess: serde_json::Value = serde_json::from_str(&text).unwrap();
    let x = guess["transform"]["translation_mm"][0].as_f64().unwrap();
    guess["transform"]["translation_mm"][0] = (x + 8.0).into();
    guess["transform"]["matrix"][0][3] = (x + 8.0).into();
    fs::write(desk.path("guess.json"), guess.to_string()).unwrap();
    for (words, expected) in [
        (
            format!("--points @late.csv {told}"),
            "the bone moved under the reference, or the tool left it",
        ),
        (format!("--points @skin.csv {told}"), "another surface than the bone's"),
        (
            format!("--points @p.csv {told} --target 1e300,0,0"),
            "is no place in a patient",
        ),
        (
            format!("--points @p.csv {told} --guess @guess.json --guess-deg 5 --guess-mm 3"),
            "nothing was searched out there",
        ),
        (
            format!("--points @p.csv --noise-mm 0.3 {TARGET} --ct-hash cd --guess @guess.json"),
            "is of the CT \"ab\"",
        ),
        (
            format!("--points @p.csv {told} --landmarks @p.csv --landmark-mm 0.01"),
            "at least 0.5",
        ),
    ] {
        let why = desk.refused(&words);
        assert!(why.contains(expected), "{words}: {why}");
    }
    // A scene that refuses what the numerics do not: nothing says that nothing speaks against it.
    let scene = "[tracker]\nsource = \"operating-room\"\n[tracker.registration]\nfile = \"r.json\"\n\
                 [tracker.registration.gates]\nmax_tre_mm = 0.01\n";
    fs::write(desk.path("s.toml"), scene).unwrap();
    let gated = desk
        .surface(&format!("--points @p.csv {told} --scene @s.toml --out @gated.json"))
        .unwrap();
    assert!(
        gated.refused.is_some_and(|why| why.contains("max_tre_mm 0.01")),
        "{}",
        gated.text
    );
    assert!(!gated.text.contains("nothing speaks against it") && !desk.path("gated.json").exists());
    // A file of a refused registration looks like any other to whoever reads it.
    let refused = desk
        .surface(&format!("--points @p.csv {told} --max-tre-mm 0.01 --json"))
        .unwrap();
    assert_eq!((refused.text.as_str(), refused.refused.is_some()), ("", true));
}

/// The file of `calib bone` beside a bone says which CT it is of and how exact; facts of another surface, or another CT, stop everything.
#[test]
fn a_bone_of_another_ct_is_refused() {
    let desk = Desk::new(120);
    let common = format!("--points @p.csv --noise-mm {NOISE_MM} {TARGET} --shared-mm 0");
    let hash = blake3::hash(desk.planted.ply().as_ref()).to_hex().to_string();
    let facts = |hash: &str, sigma: &str| {
        format!(
            r#"{{"format":"trocar-bone","version":1,"frame":"LPS","ct_hash":"of this CT","surface_blake3":"{hash}",
            "surface_sigma_mm":{sigma},"surface_shared_sigma_mm":0.2,"more":[1]}}"#
        )
    };
    fs::write(desk.path("bone.json"), facts(&hash, "0.1")).unwrap();
    let made = desk.surface(&format!("{common} --out @r.json")).unwrap();
    assert_eq!(made.refused, None, "{}", made.text);
    let file = RegistrationFile::read(&desk.path("r.json")).unwrap();
    let surface = file.surface.unwrap();
    assert_eq!(file.ct_hash.as_deref(), Some("of this CT"));
    assert_eq!((surface.bone.sigma_mm, surface.offset_mm.prior_sigma), (0.1, 0.2));
    let why = desk.refused(&format!("{common} --ct-hash another"));
    assert!(why.contains("is of the CT of this CT, another is used"), "{why}");
    for (text, expected) in [
        (facts(&"0".repeat(64), "0.1"), "one of the two was changed"),
        (facts(&hash, "-1"), "surface_sigma_mm is -1; 0 to 10 mm"),
        (
            facts(&hash, "0.1").replace("trocar-bone", "other"),
            "expected \"trocar-bone\", 1",
        ),
        ("{".to_owned(), "reading what calib bone says of the bone"),
    ] {
        fs::write(desk.path("bone.json"), text).unwrap();
        let why = desk.refused(&common);
        assert!(why.contains(expected), "{why}");
    }
}

/// An error that all points share is in what is predicted, and more points do not take it away.
#[test]
fn a_shared_error_is_in_what_is_predicted() {
    let desk = Desk::new(160);
    let common = format!("--points @p.csv --noise-mm {NOISE_MM} {TARGET} --ct-hash ab --json");
    let tre = |more: &str| -> f64 {
        let text = desk.surface(&format!("{common} {more}")).unwrap().text;
        let file: RegistrationFile = serde_json::from_str(&text).unwrap();
        file.predicted_tre[1].rms_mm.unwrap()
    };
    let (none, some) = (tre("--shared-mm 0"), tre("--shared-mm 0.4"));
    assert_eq!(none, tre(""));
    // A shift of the points is one of the pose: three axes of 0.4 mm, beside what there is without.
    let expected = (none * none + 3.0 * 0.4 * 0.4).sqrt();
    assert!((some / expected - 1.0).abs() < 0.02, "{some} mm, {expected} expected");
    let why = desk.refused(&format!("{common} --tip @none.json"));
    assert!(why.contains("none.json"), "{why}");
}

/// The columns in which touches tell what they share were passed over: 160 points of one tip averaged its error away.
#[test]
fn what_touches_share_is_in_the_registration_by_their_own_columns() {
    let desk = Desk::new(160);
    let (own, whole) = (NOISE_MM * NOISE_MM, NOISE_MM * NOISE_MM + 0.16);
    let mut lines = desk.planted.csv();
    lines = lines
        .lines()
        .enumerate()
        .map(|(i, line)| match i {
            0 => format!("{line},cxx,cxy,cxz,cyy,cyz,czz,u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z\n"),
            _ => format!("{line},{whole},0,0,{whole},0,{whole},0.4,0,0,0,0.4,0,0,0,0.4\n"),
        })
        .collect();
    let head = "# places of the tip of a in the tracker, mm; calibration 00000000000000aa\n";
    fs::write(desk.path("u.csv"), head.to_owned() + &lines).unwrap();
    let made = |words: &str| -> RegistrationFile {
        let text = desk
            .surface(&format!("{words} {TARGET} --ct-hash ab --json"))
            .unwrap()
            .text;
        serde_json::from_str(&text).unwrap()
    };
    let plain = made(&format!("--points @p.csv --noise-mm {NOISE_MM}"));
    assert_eq!(plain.shared.unwrap().columns, None);
    let file = made("--points @u.csv");
    let rms = |file: &RegistrationFile| file.predicted_tre[1].rms_mm.unwrap();
    let none = plain.predicted_tre[1].rms_mm.unwrap();
    // A shift of the points is one of the pose: three axes of 0.4 mm, beside what there is without.
    let expected = (none * none + 3.0 * 0.16).sqrt();
    assert!(
        (rms(&file) / expected - 1.0).abs() < 0.02,
        "{} {expected}; own {own}",
        rms(&file)
    );
    // And what each of the three moves the target by is that shift, turned into the CT: a check takes it off.
    let shared = file.shared.clone().unwrap();
    assert_eq!(shared.calibration.as_deref(), Some("00000000000000aa"));
    let columns = nalgebra::Matrix6x3::from_fn(|i, j| shared.columns.unwrap()[i][j]);
    let mut slope = nalgebra::Matrix3x6::zeros();
    slope
        .fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&-nalgebra::Vector3::new(10.0, -20.0, 15.0).cross_matrix());
    slope.fixed_view_mut::<3, 3>(0, 3).fill_with_identity();
    let turn = nalgebra::Matrix3::from_fn(|i, j| file.transform.matrix[i][j]);
    let off = (slope * columns - turn * 0.4).amax();
    // What the priors hold of it: some hundredths.
    assert!(off < 0.02 * 0.4, "{off}");
    for (words, expected) in [
        ("--shared-mm 0.2", "would overrule it"),
        ("--noise-mm 1", "would overrule them"),
    ] {
        let why = desk.refused(&format!("--points @u.csv {TARGET} {words}"));
        assert!(why.contains(expected), "{why}");
    }
    let less = lines.replace(&format!(",{whole},0,0,"), ",0.1,0,0,");
    fs::write(desk.path("u.csv"), less).unwrap();
    let why = desk.refused(&format!("--points @u.csv {TARGET}"));
    assert!(why.contains("more than u1x to u3z make of it"), "{why}");
}

fn first_lines(text: &str, count: usize) -> String {
    text.lines().take(count).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn an_output_that_is_there_is_not_replaced() {
    let desk = Desk::new(20);
    fs::write(desk.path("r.json"), "mine").unwrap();
    let why = desk.refused(&format!("--points @p.csv --noise-mm 1 {TARGET} --out @r.json"));
    assert!(why.contains("there is a file of this name"), "{why}");
    // As root a device would be gone for everybody.
    let _socket = std::os::unix::net::UnixListener::bind(desk.path("socket")).unwrap();
    for (words, expected) in [
        ("--out @socket --overwrite", "this is no file"),
        ("--out @none/r.json", "there is no folder"),
        ("--out @a.json --picture @a.json", "cannot be in one file"),
        ("--out @a.json --keep-refused @a.json", "cannot be in one file"),
        ("--keep-refused @bone.json", "what lies beside a bone"),
        ("--out @bone.json", "what lies beside a bone"),
    ] {
        let why = desk.refused(&format!("--points @p.csv --noise-mm 1 {TARGET} {words}"));
        assert!(why.contains(expected), "{words}: {why}");
    }
    assert_eq!(fs::read_to_string(Path::new(&desk.path("r.json"))).unwrap(), "mine");
}

/// With 15 to 30 points, such as share an image as one, no place in their order has enough before and after it: it was passed over in silence.
#[test]
fn that_it_could_not_be_looked_whether_the_bone_moved_is_told() {
    let desk = Desk::new(28);
    let told = format!(
        "--points @p.csv --noise-mm {NOISE_MM} {TARGET} --ct-hash ab --shared-mm 0 --out @r.json --max-tre-mm 9"
    );
    let made = desk.surface(&told).unwrap();
    assert_eq!(made.refused, None, "{}", made.text);
    let words = "whether the bone moved under its marker could not be looked at: 28 points";
    assert!(
        made.text.contains(&format!("WARNING          {words}")),
        "{}",
        made.text
    );
    let surface = |desk: &Desk| RegistrationFile::read(&desk.path("r.json")).unwrap().surface.unwrap();
    let record = surface(&desk);
    let check = record.moved_check.unwrap();
    assert!(!check.made && check.places == 0 && check.why_not.unwrap().contains(words));
    assert!(record.warnings.iter().any(|warning| warning.contains(words)));
    // With twice as many it is looked, and nothing is told.
    let desk = Desk::new(60);
    let made = desk.surface(&told).unwrap();
    assert_eq!(made.refused, None, "{}", made.text);
    assert!(!made.text.contains("whether the bone moved"), "{}", made.text);
    let record = surface(&desk);
    let check = record.moved_check.unwrap();
    assert!(check.made && check.places > 0 && check.why_not.is_none());
    assert_eq!(record.warnings, [""; 0]);
}
