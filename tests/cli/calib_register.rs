//! `calib register`: planted and real answers, the same by other software, and every kind of bad input refused by name.

#![allow(clippy::print_stdout, reason = "measured differences, and why a test was skipped")]
#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

mod bad;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::*;
use calib_cli::RegistrationFile;
use geometry::rotation::{Rotation, RotationVector};

const HEADER: &str = "from_x,from_y,from_z,to_x,to_y,to_z";
const ROTATION: [f64; 3] = [0.3, -1.1, 0.7];
const TRANSLATION: [f64; 3] = [12.0, -340.5, 77.25];

/// Numbers in -1..1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn planted() -> Rotation {
    Rotation::from_vector(RotationVector::new(ROTATION).unwrap())
}

/// Pairs under the planted transform, each `to` point off by up to `noise` mm an axis.
fn pairs(count: usize, noise: f64) -> Vec<[[f64; 3]; 2]> {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let turn = planted();
    let mut pair = || {
        let from = [(); 3].map(|()| 80.0 * random.next());
        let mut to = turn.apply(from);
        for (x, t) in to.iter_mut().zip(TRANSLATION) {
            *x += t + noise * random.next();
        }
        [from, to]
    };
    (0..count).map(|_| pair()).collect()
}

fn csv(pairs: &[[[f64; 3]; 2]]) -> String {
    let line = |[[a, b, c], [x, y, z]]: &[[f64; 3]; 2]| format!("{a},{b},{c},{x},{y},{z}\n");
    format!("{HEADER}\n{}", pairs.iter().map(line).collect::<String>())
}

fn register(world: &World, arguments: &[&str]) -> Output {
    world.output("calib", &[&["register"], arguments].concat())
}

/// Registers, and returns the report and the file.
fn registered(world: &World, arguments: &[&str]) -> (String, RegistrationFile) {
    let out = world.path("registration.json");
    let more = ["--overwrite", "--out", out.to_str().unwrap()];
    let output = register(world, &[arguments, &more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    (stdout(&output), RegistrationFile::read(&out).unwrap())
}

/// The angle to the planted rotation, rad, and the largest difference of the translations, mm.
fn off(file: &RegistrationFile) -> (f64, f64) {
    let found = Rotation::from_quaternion(file.transform.quaternion_wxyz).unwrap();
    let t = file.transform.translation_mm;
    let shift = (0..3).map(|i| (t[i] - TRANSLATION[i]).abs()).fold(0.0, f64::max);
    (found.distance(planted()), shift)
}

#[test]
fn finds_the_planted_transform_by_every_method() {
    let world = World::new();
    let path = world.file("pairs.csv", &csv(&pairs(24, 0.0)));
    let path = path.to_str().unwrap();
    for method in [
        "newton",
        "svd",
        "horn-quaternion",
        "faugeras-hebert",
        "horn-polar",
        "rotation-vector",
    ] {
        let arguments = ["--pairs", path, "--method", method, "--to", "ct", "--from", "tracker"];
        let (report, file) = registered(&world, &arguments);
        let (angle, shift) = off(&file);
        // Coordinates below 512 mm are good to 2^-44 mm, over radii of 60 mm; the polar form loses some more.
        assert!(angle < 1e-13 && shift < 1e-11, "{method}: {angle:e} rad, {shift:e} mm");
        assert!(
            file.fre_rms_mm < 1e-12 && file.certificate.as_ref().unwrap().global_optimum,
            "{report}"
        );
        assert_eq!(
            (file.method.as_str(), file.transform.name.as_str()),
            (method, "ct_from_tracker")
        );
        assert!(
            report.contains("ct_from_tracker by ") && report.contains("global optimum"),
            "{report}"
        );
    }
}

#[test]
fn noise_is_estimated_and_errors_predicted() {
    let world = World::new();
    let path = world.file("pairs.csv", &csv(&pairs(400, 0.5)));
    let arguments = [
        "--pairs",
        path.to_str().unwrap(),
        "--target",
        "12,-340.5,177.25",
        "--target",
        "0,0,0",
    ];
    let (report, file) = registered(&world, &arguments);
    let noise = file.noise.clone().unwrap();
    // Even noise of half width 0.5 has the deviation 0.5 / sqrt(3), known to 1 / sqrt(2 * 1200), 2 %; 4 of these.
    assert!(
        (noise.sigma_mm / (0.5 / 3.0_f64.sqrt()) - 1.0).abs() < 0.08,
        "{noise:?}"
    );
    let tre: Vec<f64> = file.predicted_tre.iter().map(|tre| tre.rms_mm.unwrap()).collect();
    assert!(tre[0] < tre[1] && tre[1] < tre[2], "{tre:?}");
    // Of 1194 degrees of freedom: the variance is taken for 0.3 % more.
    assert_eq!(noise.degrees_of_freedom, Some(1194));
    let factor = calib::registration::few_residuals_factor(1194);
    assert!(factor > 1.001 && factor < 1.005, "{factor}");
    assert!((tre[0] - noise.sigma_mm * (3.0 * factor / 400.0).sqrt()).abs() < 1e-12);
    let (angle, _) = off(&file);
    let deviations = file.covariance.unwrap();
    let turn = (0..3).map(|i| deviations[i][i]).sum::<f64>().sqrt();
    assert!(angle < 4.0 * turn, "{angle} rad, {turn} expected");
    // Of many pairs the worst are shown, the longest first.
    assert!(
        report.contains("longest") && report.contains("and 380 more pairs"),
        "{report}"
    );
    let all = stdout(&register(&world, &["--pairs", path.to_str().unwrap(), "--all"]));
    assert!(all.lines().count() > 400, "{all}");
    let given = ["--pairs", path.to_str().unwrap(), "--noise-mm", "2"];
    let given = registered(&world, &given).1.noise.unwrap();
    assert!(given.sigma_mm == 2.0 && !given.estimated);
    // An estimate that is not to fall below a bound is one above it, and none at it.
    let least = |mm: &str| {
        let arguments = ["--pairs", path.to_str().unwrap(), "--least-noise-mm", mm];
        registered(&world, &arguments).1.noise.unwrap()
    };
    assert_eq!(least("0.01"), noise);
    assert!(least("3").sigma_mm == 3.0 && !least("3").estimated);
}

#[test]
fn weights_count_only_where_they_are_asked_for() {
    let world = World::new();
    let mut set = pairs(8, 0.0);
    set[3][1][0] += 5.0;
    let text: String = csv(&set).lines().enumerate().fold(String::new(), |text, (i, line)| {
        let weight = ["weight", "0.5", "2e300", "1e300", "0"].get(i).unwrap_or(&"1e300");
        text + line + "," + weight + "\n"
    });
    let path = world.file("pairs.csv", &text);
    let arguments = ["--pairs", path.to_str().unwrap()];
    let (report, file) = registered(&world, &arguments);
    assert!(
        file.fre_rms_mm > 1.0 && report.contains("--weights uses them"),
        "{report}"
    );
    let (report, file) = registered(&world, &[&arguments[..], &["--weights"]].concat());
    assert!(file.fre_rms_mm < 1e-12 && off(&file).0 < 1e-13, "{report}");
    assert_eq!(
        file.pairs.iter().map(|p| p.weight).collect::<Vec<_>>()[1..4],
        [1.0, 0.5, 0.0]
    );
    let mark = report.lines().find(|line| line.contains("not used")).unwrap();
    assert!(mark.trim_start().starts_with("5 "), "{report}");
}

#[test]
fn outliers_are_found_and_named() {
    let world = World::new();
    let mut set = pairs(24, 0.2);
    for (i, pair) in set.iter_mut().take(16).enumerate() {
        pair[1][i % 3] += 30.0 + 7.0 * i as f64;
    }
    let path = world.file("pairs.csv", &csv(&set));
    let arguments = ["--pairs", path.to_str().unwrap(), "--robust", "0.8"];
    let refused = register(&world, &arguments);
    assert!(stderr(&refused).contains("13 are needed"), "{}", stderr(&refused));
    let (report, file) = registered(&world, &[&arguments[..], &["--min-inliers", "5"]].concat());
    let inliers: Vec<bool> = file.pairs.iter().map(|pair| pair.inlier.unwrap()).collect();
    assert_eq!(inliers, (0..24).map(|i| i >= 16).collect::<Vec<_>>());
    assert!(off(&file).0 < 0.01 && file.fre_max_mm < 0.8, "{report}");
    assert_eq!(
        report.lines().filter(|line| line.ends_with("outlier")).count(),
        16,
        "{report}"
    );
    assert!(report.contains("8 agree within 0.8 mm"), "{report}");
}

#[test]
fn a_scale_is_found() {
    let world = World::new();
    let mut set = pairs(12, 0.0);
    // Inches on one side.
    set.iter_mut().for_each(|pair| pair[0] = pair[0].map(|x| x / 25.4));
    let path = world.file("pairs.csv", &csv(&set));
    let (report, file) = registered(&world, &["--pairs", path.to_str().unwrap(), "--scale"]);
    assert!((file.transform.scale / 25.4 - 1.0).abs() < 1e-14, "{report}");
    assert!(off(&file).0 < 1e-13 && file.fre_rms_mm < 1e-12, "{report}");
    let [a, b, c, t] = file.transform.matrix[0];
    assert!(
        ((a * a + b * b + c * c).sqrt() - file.transform.scale).abs() < 1e-12 && (t - TRANSLATION[0]).abs() < 1e-11
    );
}

#[test]
fn the_file_holds_every_bit_and_is_not_replaced_unasked() {
    let world = World::new();
    let path = world.file("pairs.csv", &csv(&pairs(10, 0.3)));
    let (pairs, out) = (path.to_str().unwrap(), world.path("registration.json"));
    let (_, file) = registered(&world, &["--pairs", pairs]);
    let text = fs::read_to_string(&out).unwrap();
    assert_eq!(file.to_json().unwrap(), text);
    assert_eq!(serde_json::from_str::<RegistrationFile>(&text).unwrap(), file);
    let m = Rotation::from_quaternion(file.transform.quaternion_wxyz)
        .unwrap()
        .matrix()
        .rows();
    let near = |i: usize, j: usize| (m[i][j] - file.transform.matrix[i][j]).abs() < 4.0 * f64::EPSILON;
    assert!((0..9).all(|k| near(k / 3, k % 3)));
    assert_eq!((file.inputs.len(), file.inputs[0].blake3.len()), (1, 64));
    assert_eq!(file.inputs[0].bytes, fs::metadata(&path).unwrap().len());

    let again = register(&world, &["--pairs", pairs, "--out", out.to_str().unwrap()]);
    refused(&again, "registration.json: there is a file of this name | --overwrite");
    assert_eq!(fs::read_to_string(&out).unwrap(), text);
    let onto_itself = register(&world, &["--pairs", pairs, "--overwrite", "--out", pairs]);
    refused(
        &onto_itself,
        "pairs.csv: this is the file that the points were read from",
    );
    let folder = world.path("");
    refused(
        &register(&world, &["--pairs", pairs, "--out", folder.to_str().unwrap()]),
        "this is a folder",
    );
    refused(
        &register(&world, &["--pairs", pairs, "--out", "/no/such/r.json"]),
        "writing /no/such/r.json | there is no folder /no/such",
    );
    let left: Vec<_> = fs::read_dir(world.path(""))
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 2, "{left:?}");
    fs::write(&out, text.replace("trocar-registration", "something-else")).unwrap();
    assert!(
        RegistrationFile::read(&out)
            .unwrap_err()
            .to_string()
            .contains("something-else")
    );
}

/// One paragraph that holds all `words`, between bars, and exit code 1.
fn refused(output: &Output, words: &str) {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("calib: error: ") && said.lines().count() == 1,
        "{said}"
    );
    for word in words.split(" | ") {
        assert!(said.contains(word), "{word:?} in: {said}");
    }
    assert_eq!(stdout(output), "");
}

#[test]
fn files_of_points_are_paired_line_by_line() {
    let world = World::new();
    let to = world.file("to.txt", "# seen\n5 0 -7\n5,60,-7\n-75\t0\t-7\n5 0 43\n");
    let from = world.file("from.txt", "0 0 0\n60 0 0\n0 80 0\n0 0 50\n");
    let arguments = [
        "--to-points",
        to.to_str().unwrap(),
        "--from-points",
        from.to_str().unwrap(),
    ];
    let (report, file) = registered(&world, &arguments);
    assert!(file.fre_rms_mm < 1e-13 && report.contains(" 3/2 "), "{report}");
    assert_eq!(
        file.inputs.iter().map(|i| i.role.as_str()).collect::<Vec<_>>(),
        ["to", "from"]
    );
    fs::write(&from, "0 0 0\n60 0 0\n0 80 0\n").unwrap();
    let words = "to.txt with | from.txt: 4 points in the first and 3 in the second";
    refused(&register(&world, &arguments), words);
    fs::write(&from, "0 0 0\n60 0\n").unwrap();
    refused(
        &register(&world, &arguments),
        "from.txt: line 2, column 5: 2 fields, expected 3",
    );
    fs::write(&from, "0 0 0\n60 0 0\n60 0 0\n1 2 3\n").unwrap();
    refused(
        &register(&world, &arguments),
        "from.txt: lines 2 and 3 hold the same from point",
    );
}

/// The VTK model `fran_cut` and the same under a known matrix.
fn fran_cut() -> Option<[PathBuf; 3]> {
    let folder = shared("data/surface-francut-known")?;
    Some(["fran_cut_transformed.txt", "fran_cut.txt", "matrix.4x4"].map(|name| folder.join(name)))
}

#[test]
fn the_known_surface_gives_its_known_matrix() {
    let Some([to, from, matrix]) = fran_cut() else {
        return;
    };
    let world = World::new();
    // A surface of 0.2 units, as it stands refused as one of metres: taken for one.
    let in_mm = |name: &str, path: &Path| {
        let row = |line: &str| {
            line.split_whitespace()
                .map(|x| (1000.0 * x.parse::<f64>().unwrap()).to_string())
                .collect::<Vec<_>>()
                .join(" ")
        };
        world.file(
            name,
            &fs::read_to_string(path)
                .unwrap()
                .lines()
                .map(|line| row(line) + "\n")
                .collect::<String>(),
        )
    };
    let [to, from] = [in_mm("to.txt", &to), in_mm("from.txt", &from)];
    let arguments = [
        "--to-points",
        to.to_str().unwrap(),
        "--from-points",
        from.to_str().unwrap(),
    ];
    let (report, file) = registered(&world, &arguments);
    println!("{report}");
    let known = fs::read_to_string(matrix).unwrap();
    let known: Vec<f64> = known.split_whitespace().map(|x| x.parse().unwrap()).collect();
    for (row, known) in file.transform.matrix.iter().zip(known.chunks(4)).take(3) {
        for (column, (found, known)) in row.iter().zip(known).enumerate() {
            let found = if column == 3 { found / 1000.0 } else { *found };
            // It is printed with four decimals.
            assert!((found - known).abs() < 0.5e-4 + 1e-6, "{found} for {known}");
        }
    }
    assert_eq!(file.pairs.len(), 2205);
    // Coordinates are printed with six digits: the last is 1e-6 at 0.1 to 1, of 1000 mm, so that one axis is off by at most 5e-4 mm.
    assert!(file.fre_rms_mm < 5e-4 && file.fre_max_mm < 1e-3, "{report}");
    assert!(file.certificate.unwrap().global_optimum);
}

/// What the script says of a registration of `pairs`.
fn assert_as_scipy(python: &Path, pairs: &Path, registration: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_registration.py");
    let output = Command::new(python)
        .args([&script, pairs, registration])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let seen: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{seen}");
    let number = |key: &str| seen[key].as_f64().unwrap();
    // Both are good to some roundings of points within 512 mm, at a condition near 1.
    assert!(number("angle_rad") < 1e-14, "{seen}");
    assert!(number("translation_mm") < 1e-12 && number("rms_mm") < 1e-12, "{seen}");
}

#[test]
fn scipy_finds_the_same() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    for noise in [0.0, 0.5, 20.0] {
        let plain = csv(&pairs(24, noise));
        let weighted = plain.lines().enumerate().fold(String::new(), |text, (i, line)| {
            let weight = if i == 0 {
                "weight".to_owned()
            } else {
                format!("{}", 1 + i % 5)
            };
            text + line + "," + &weight + "\n"
        });
        for (text, more) in [(plain, &[][..]), (weighted, &["--weights"][..])] {
            let path = world.file("pairs.csv", &text);
            registered(&world, &[&["--pairs", path.to_str().unwrap()], more].concat());
            assert_as_scipy(&python, &path, &world.path("registration.json"));
        }
    }
}

#[test]
fn the_example_of_the_help_works() {
    let world = World::new();
    let help = stdout(&register(&world, &["--help"]));
    let example = help
        .lines()
        .map(str::trim)
        .skip_while(|line| !line.starts_with("from_x,"));
    let example: Vec<&str> = example.take_while(|line| !line.is_empty()).collect();
    assert_eq!(example.len(), 5, "{help}");
    let path = world.file("pairs.csv", &example.join("\n"));
    let (report, file) = registered(&world, &["--pairs", path.to_str().unwrap(), "--weights"]);
    assert!(file.fre_rms_mm < 1e-12 && report.contains("left eye"), "{report}");
    assert!(stdout(&world.output("calib", &["--version"])).starts_with("calib "));
}
