//! The command on files made by hand: what it writes is read back, what is wrong is refused by name.

use std::fs;
use std::path::PathBuf;

use clap::Parser;
use serde_json::{Value, json};

use super::CameraFile;
use crate::cli::{Cli, run};
use crate::commands::Outcome;

/// Discs of a pinhole of 1000 px that sees a grid of 8 x 6 discs, 10 mm apart, turned about x and y.
fn image(tilts: [f64; 2], refinement: &str) -> Value {
    image_by([1000.0, 319.5], tilts, refinement)
}

/// The same by a pinhole of a given focal length and column of the principal point.
fn image_by([focal, column]: [f64; 2], tilts: [f64; 2], refinement: &str) -> Value {
    let [(sa, ca), (sb, cb)] = tilts.map(f64::sin_cos);
    let discs: Vec<Value> = (0..48)
        .map(|i| {
            let (col, row) = (i % 8, i / 8);
            let (x, y) = (f64::from(col) * 10.0, f64::from(row) * 10.0);
            let [u, v] = [x - 35.0, y - 25.0];
            let [a, b, c] = [cb * u + sb * sa * v, ca * v, -sb * u + cb * sa * v + 140.0];
            let pixel = [focal * a / c + column, focal * b / c + 239.5];
            json!({"col": col, "row": row, "x_mm": x, "y_mm": y, "x_px": pixel[0], "y_px": pixel[1],
                "covariance_px2": [1e-4, 0.0, 1e-4], "mark": true})
        })
        .collect();
    json!({"path": format!("views/{tilts:?}.png"), "width": 640, "height": 480, "found": true, "refinement": refinement,
        "px_from_col_row": [[70.0, 0.0, 60.0], [0.0, 70.0, 60.0], [0.0, 0.0, 1.0]], "radius_pitch": 0.3,
        "discs": discs})
}

fn grids(images: &[Value]) -> Value {
    json!({"trocar_grid": 1, "cols": 8, "rows": 6, "pitch_mm": 10.0, "images": images})
}

fn good() -> Vec<Value> {
    [[0.4, 0.1], [-0.3, 0.3], [0.1, -0.4], [0.0, 0.5]]
        .map(|t| image(t, "each"))
        .to_vec()
}

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, grids: &Value, options: &str) -> Result<Outcome, String> {
        let path = self.path("grids.json");
        fs::write(&path, grids.to_string()).unwrap();
        let mut words = vec!["calib".to_owned(), "camera".to_owned(), path.display().to_string()];
        words.extend(
            options
                .split_whitespace()
                .map(|w| w.replace("@", &format!("{}/", self.folder.path().display()))),
        );
        run(Cli::try_parse_from(words).unwrap(), |_| {
            unreachable!("no volume is read")
        })
    }
}

#[test]
fn what_is_written_is_read_back() {
    let bench = Bench::new();
    let outcome = bench
        .run(&grids(&good()), "--lens radial --out @camera.toml --png @camera.png")
        .unwrap();
    assert!(outcome.refused.is_none(), "{:?}", outcome.refused);
    assert!(
        outcome.text.contains("from 4 views, 192 discs, 0 left out"),
        "{}",
        outcome.text
    );
    assert!(outcome.text.contains("p1         0.00000    held"), "{}", outcome.text);
    let file = CameraFile::read(&bench.path("camera.toml")).unwrap();
    // The discs are exact: what rounding leaves.
    assert!((file.camera().focal.x - 1000.0).abs() < 1e-6 && (file.numbers[2] - 319.5).abs() < 1e-6);
    assert!(
        file.deviations[0] > 0.01 && file.deviations[0] < 5.0,
        "{}",
        file.deviations[0]
    );
    assert_eq!((file.views.len(), file.views[1].discs), (4, [48, 0]));
    assert_eq!(file.sources[0].blake3.len(), 64);
    assert!(fs::read(bench.path("camera.png")).unwrap().starts_with(b"\x89PNG"));
    let text = fs::read_to_string(bench.path("camera.toml")).unwrap();
    // 1000 to rounding: 999.999... or 1000.000...
    let numbers = format!("numbers = [{:?}", file.numbers[0]);
    for (from, to, words) in [
        (&*numbers, "numbers = [1100.0", "it was changed; calibrate again"),
        ("version = 1", "version = 2", "version 2; expected"),
        (&*numbers, "numbers = [\"a\"", "line"),
    ] {
        assert!(text.contains(from), "{text}");
        fs::write(bench.path("changed.toml"), text.replace(from, to)).unwrap();
        let error = CameraFile::read(&bench.path("changed.toml")).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("changed.toml"), "{error}");
    }
}

#[test]
fn what_falls_short_is_said_with_what_to_do() {
    let bench = Bench::new();
    let flat: Vec<Value> = [[0.05, 0.0], [-0.06, 0.02], [0.0, 0.07]]
        .map(|t| image(t, "each"))
        .to_vec();
    let outcome = bench.run(&grids(&flat), "--lens pinhole --out @poor.toml").unwrap();
    let refused = outcome.refused.unwrap();
    assert!(
        refused.contains("tilt the grid more about the image's x axis: the views differ by 6.3"),
        "{refused}"
    );
    let error = CameraFile::read(&bench.path("poor.toml")).unwrap_err().to_string();
    assert!(error.contains("its verdict is \"refused\""), "{error}");
    let outcome = bench.run(&grids(&flat), "--lens pinhole --allow-poor").unwrap();
    assert!(outcome.refused.is_none());
}

/// The left and the right camera of a head, taken for one: each gives pictures of its own.
#[test]
fn pictures_of_two_cameras_are_refused_with_those_that_agree() {
    let bench = Bench::new();
    let tilts = [
        [0.4, 0.1],
        [-0.3, 0.3],
        [0.1, -0.4],
        [0.0, 0.5],
        [0.3, -0.2],
        [-0.4, -0.1],
        [0.2, 0.3],
        [-0.1, -0.5],
    ];
    let by = |i: usize| {
        if i.is_multiple_of(2) {
            [1000.0, 319.5]
        } else {
            [1000.6, 320.2]
        }
    };
    let images: Vec<Value> = (0..8).map(|i| image_by(by(i), tilts[i], "each")).collect();
    let options = "--lens radial --out @camera.toml --overwrite";
    let refused = bench.run(&grids(&images), options).unwrap().refused.unwrap();
    assert!(
        refused.contains("two cameras mixed") && refused.contains("at most 3 is accepted"),
        "{refused}"
    );
    let names = |first: usize| {
        let some: Vec<String> = (first..8).step_by(2).map(|i| format!("{:?}.png", tilts[i])).collect();
        some.join(", ")
    };
    let [left, right] = [0, 1].map(names);
    let said = format!("{left} agree on one camera (");
    assert!(
        refused.contains(&said) && refused.contains(&format!("but not with {right}, which agree")),
        "{refused}"
    );
    assert!(CameraFile::read(&bench.path("camera.toml")).is_err());
    let asked = bench
        .run(&grids(&images), &format!("{options} --max-noise-ratio 1e3"))
        .unwrap();
    assert!(asked.refused.is_none(), "{:?}", asked.refused);
    // One picture of the other camera is named.
    let mut one: Vec<Value> = (0..6).map(|i| image(tilts[i], "each")).collect();
    one[4] = image_by([1012.0, 331.0], tilts[4], "each");
    let refused = match bench.run(&grids(&one), options) {
        Ok(outcome) => outcome.refused.unwrap(),
        Err(refused) => refused,
    };
    assert!(
        refused.contains(&format!("but not with {:?}.png", tilts[4])),
        "{refused}"
    );
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    let bench = Bench::new();
    let refused = |images: &[Value], options: &str| bench.run(&grids(images), options).unwrap_err();
    let few = refused(&good()[..2], "");
    assert!(
        few.contains("2 views; at least 3") && few.contains("Take more pictures"),
        "{few}"
    );
    let twice = refused(&[good(), good()].concat(), "");
    assert!(
        twice.contains("views 0 and 4 are the same") && twice.contains("[0.4, 0.1].png"),
        "{twice}"
    );
    let mut whole = good();
    whole[2]["refinement"] = json!("whole");
    let text = refused(&whole, "");
    assert!(
        text.contains("--one-by-one") && text.contains("[0.1, -0.4].png"),
        "{text}"
    );
    assert!(bench.run(&grids(&whole), "--lens pinhole").is_ok());
    let mut lens = good();
    lens[1]["refinement"] = json!("lens");
    for options in ["", "--lens pinhole"] {
        let text = refused(&lens, options);
        assert!(
            text.contains("a lens of its own") && text.contains("--one-by-one"),
            "{text}"
        );
    }
    let mut other = good();
    other[3]["width"] = json!(800);
    let text = refused(&other, "");
    assert!(text.contains("640 x 480") && text.contains("800 x 480"), "{text}");
    let mut lost = good();
    lost[1] = json!({"path": "a.png", "width": 640, "height": 480, "found": false, "refused": "none"});
    let outcome = bench.run(&grids(&lost), "--lens pinhole").unwrap();
    assert!(outcome.text.contains("no grid was found: a.png"), "{}", outcome.text);
}

#[test]
fn files_that_are_none_are_refused_by_name() {
    let bench = Bench::new();
    for (file, words) in [
        (json!({"trocar_grid": 2}), "found trocar_grid 2, expected 1"),
        (json!({"images": []}), "found trocar_grid nothing"),
        (json!({"trocar_grid": 1, "pitch_mm": 5.0}), "missing field `images`"),
        (
            grids(&[json!({"path": "a", "width": 1, "height": 1, "found": true})]),
            "a: refinement is None",
        ),
        (grids(&[]), "0 views; at least 3"),
    ] {
        let error = bench.run(&file, "").unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    let mut bad = good();
    bad[0]["radius_pitch"] = json!(-1.0);
    assert!(bench.run(&grids(&bad), "").unwrap_err().contains("radius_pitch -1"));
    let mut bad = good();
    bad[0]["discs"][3]["covariance_px2"] = json!([0.0, 0.0, 0.0]);
    let error = bench.run(&grids(&bad), "").unwrap_err();
    assert!(
        error.contains("view 0, disc 3: the covariance") && error.contains("calib grid"),
        "{error}"
    );
}

/// Discs with centres of their own: those are taken, not the ones moved to a homography, and the radius is theirs.
#[test]
fn centres_as_measured_are_taken_where_the_file_has_them() {
    let bench = Bench::new();
    let mut images = good();
    for disc in images.iter_mut().flat_map(|i| i["discs"].as_array_mut().unwrap()) {
        let [x, y] = ["x_px", "y_px"].map(|k| disc[k].as_f64().unwrap());
        // So small a disc has its centre at the image of its centre, to 1e-6 px.
        disc["measured"] = json!({"x_px": x, "y_px": y, "radius_mm": 0.001});
        disc["x_px"] = json!(x + 20.0);
    }
    let options = "--lens radial --out @camera.toml --overwrite";
    bench.run(&grids(&images), options).unwrap();
    let file = CameraFile::read(&bench.path("camera.toml")).unwrap();
    assert!((file.numbers[2] - 319.5).abs() < 1e-3, "{:?}", file.numbers);
    images[0]["discs"][0]["measured"]["radius_mm"] = json!(-1.0);
    let error = bench.run(&grids(&images), options).unwrap_err();
    assert!(error.contains("view 0, disc 0") && error.contains("radius"), "{error}");
}

#[test]
fn a_bent_plate_and_views_held_out_are_reported() {
    let bench = Bench::new();
    let options = "--lens radial --plate bent --held-out --out @camera.toml";
    let outcome = bench.run(&grids(&good()), options).unwrap();
    for words in ["bend u^2", "predicted by the camera of the others", "all views, RMS"] {
        assert!(outcome.text.contains(words), "{}", outcome.text);
    }
    let file = CameraFile::read(&bench.path("camera.toml")).unwrap();
    let plate = file.plate.unwrap();
    // The discs are exact, and the plate is flat.
    assert!(plate.bend_mm.iter().all(|b| b.abs() < 1e-6), "{plate:?}");
    assert_eq!((plate.middle_mm, plate.unit_mm), ([35.0, 25.0], 35.0));
    assert_eq!(file.names.len(), 14);
}

#[test]
fn a_field_is_reported_and_written_by_disc() {
    let bench = Bench::new();
    let outcome = bench
        .run(&grids(&good()), "--lens radial --plate field --out @camera.toml")
        .unwrap();
    let said = "by a smooth field, 0.000 mm RMS in height and 0.000 mm RMS along";
    assert!(outcome.text.contains(said), "{}", outcome.text);
    let file = CameraFile::read(&bench.path("camera.toml")).unwrap();
    let field = file.plate.unwrap().field.unwrap();
    // The discs are exact, and lie where they are said to: every offset is nothing beside a pixel of 0.1 mm.
    assert!(
        field.discs.iter().all(|d| d[2..5].iter().all(|x| x.abs() < 1e-4)),
        "{field:?}"
    );
    assert!((field.reach_mm - 21.0).abs() < 1e-12);
}

#[test]
fn files_from_before_the_prism_are_read() {
    let bench = Bench::new();
    bench.run(&grids(&good()), "--lens radial --out @camera.toml").unwrap();
    let mut file = CameraFile::read(&bench.path("camera.toml")).unwrap();
    file.names.truncate(10);
    file.numbers.truncate(10);
    file.id = file.content_id();
    fs::write(bench.path("old.toml"), file.text().unwrap()).unwrap();
    let old = CameraFile::read(&bench.path("old.toml")).unwrap();
    assert_eq!(old.camera().lens.s, [0.0; 4]);
    file.numbers.truncate(9);
    file.id = file.content_id();
    fs::write(bench.path("old.toml"), file.text().unwrap()).unwrap();
    let error = CameraFile::read(&bench.path("old.toml")).unwrap_err().to_string();
    assert!(error.contains("\"s4\""), "{error}");
}
