//! `calib grid`: from drawn images to the place of every disc, and every kind of bad input refused by name.

use std::fs;
use std::process::Output;

use crate::support::*;
use serde_json::Value;

const SIDE: [usize; 2] = [360, 300];
/// Distance of neighbours and radii, pixels.
const PITCH: f64 = 30.0;
const RADIUS: f64 = 6.0;
const LARGE: f64 = 11.0;
const FIRST: [f64; 2] = [52.3, 46.8];

/// 9 columns and 7 rows seen from the front, turned by 2 degrees; large discs where `marks` says; columns less than `from`
/// left out of the image.
fn view(marks: &[[usize; 2]], from: usize) -> Vec<u8> {
    let (s, c) = 2.0_f64.to_radians().sin_cos();
    let grey = |x: f64, y: f64| {
        let (dx, dy) = (x - FIRST[0], y - FIRST[1]);
        let (u, v) = ((dx * c + dy * s) / PITCH + from as f64, (dy * c - dx * s) / PITCH);
        let (i, j) = (u.round(), v.round());
        let on = (0.0..9.0).contains(&i) && (0.0..7.0).contains(&j);
        let large = marks.iter().any(|m| [m[0] as f64, m[1] as f64] == [i, j]);
        let radius = if large { LARGE } else { RADIUS } / PITCH;
        if on && (u - i).hypot(v - j) < radius {
            45.0
        } else {
            190.0
        }
    };
    let pixel = |i: usize| {
        let (x, y) = ((i % SIDE[0]) as f64, (i / SIDE[0]) as f64);
        let parts = (0..36).map(|k| grey(x + (f64::from(k % 6) - 2.5) / 6.0, y + (f64::from(k / 6) - 2.5) / 6.0));
        // A little noise that is the same in every run.
        let noise = ((i.wrapping_mul(2_654_435_761) >> 7) % 7) as f64 - 3.0;
        (parts.sum::<f64>() / 36.0 + noise).round() as u8
    };
    (0..SIDE[0] * SIDE[1]).map(pixel).collect()
}

fn pgm(bytes: &[u8]) -> Vec<u8> {
    let mut file = format!("P5 {} {} 255\n", SIDE[0], SIDE[1]).into_bytes();
    file.extend(bytes);
    file
}

fn write(world: &World, name: &str, bytes: &[u8]) -> String {
    let path = world.path(name);
    fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

fn run(world: &World, image: &str, more: &[&str]) -> Output {
    let grid = ["grid", image, "--cols", "9", "--rows", "7", "--pitch-mm", "5"];
    world.output("calib", &[&grid[..], more].concat())
}

/// The words of a run that must fail, by an error of the command's own.
fn refused(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1), "{}", stdout(output));
    let said = stderr(output);
    assert!(!said.contains("panicked"), "{said}");
    said
}

fn expected(col: usize, row: usize) -> [f64; 2] {
    let (s, c) = 2.0_f64.to_radians().sin_cos();
    let (u, v) = (col as f64 * PITCH, row as f64 * PITCH);
    [FIRST[0] + u * c - v * s, FIRST[1] + u * s + v * c]
}

#[test]
fn every_disc_of_a_drawn_grid_has_its_column_its_row_and_its_place() {
    let world = World::new();
    let image = write(&world, "view.pgm", &pgm(&view(&[[2, 2], [6, 4], [2, 5]], 0)));
    let (out, seen) = (world.path("grid.json"), world.path("seen"));
    let files = ["--out", out.to_str().unwrap(), "--overlay", seen.to_str().unwrap()];
    let marks = ["--mark", "2,2", "--mark", "6,4", "--mark", "2,5"];
    let output = run(&world, &image, &[&files[..], &marks].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("63 discs of 63, turned as its large discs say"),
        "{}",
        stdout(&output)
    );

    let file: Value = serde_json::from_str(&fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!([&file["trocar_grid"], &file["cols"], &file["rows"]], [1, 9, 7]);
    let found = &file["images"][0];
    assert_eq!(
        (&found["found"], &found["turns_alike"]),
        (&Value::Bool(true), &Value::from(1))
    );
    let discs = found["discs"].as_array().unwrap();
    assert_eq!(discs.len(), 63);
    for disc in discs {
        let [col, row] = ["col", "row"].map(|k| disc[k].as_u64().unwrap() as usize);
        let at = ["x_px", "y_px"].map(|k| disc[k].as_f64().unwrap());
        let known = expected(col, row);
        let off = (at[0] - known[0]).hypot(at[1] - known[1]);
        // Noise of 2 steps on a contrast of 145: 0.02 px for one disc, and all of them are fitted at once.
        assert!(off < 0.02, "column {col} row {row}: {off}");
        assert_eq!(disc["x_mm"], col as f64 * 5.0);
        assert_eq!(
            disc["mark"],
            Value::Bool([[2, 2], [6, 4], [2, 5]].contains(&[col, row]))
        );
    }

    let overlay = image::open(seen.join("view.grid.png")).unwrap().into_rgba8();
    assert_eq!([overlay.width() as usize, overlay.height() as usize], SIDE);
    // A green cross on a disc, and none on the paper beside it.
    let green = |[x, y]: [f64; 2]| {
        let p = overlay.get_pixel(x.round() as u32, y.round() as u32).0;
        p[1] > 150 && p[0] < 110
    };
    let between = expected(4, 3);
    assert!(green(expected(4, 3)) && !green([between[0] + 15.0, between[1] + 15.0]));
}

#[test]
fn a_part_of_a_grid_needs_its_large_discs() {
    let world = World::new();
    // Columns 0 and 1 lie to the left of what was cut out.
    let bytes: Vec<u8> = view(&[[4, 2], [7, 2], [4, 5]], 3);
    let image = write(&world, "part.pgm", &pgm(&bytes));
    let marks = ["--mark", "4,2", "--mark", "7,2", "--mark", "4,5"];
    let output = run(&world, &image, &[&marks[..], &["--json"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let file: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let discs = file["images"][0]["discs"].as_array().unwrap();
    for disc in discs {
        let [col, row] = ["col", "row"].map(|k| disc[k].as_u64().unwrap() as usize);
        let at = ["x_px", "y_px"].map(|k| disc[k].as_f64().unwrap());
        let known = expected(col, row);
        let shift = 3.0 * PITCH;
        let (s, c) = 2.0_f64.to_radians().sin_cos();
        let off = (at[0] - known[0] + shift * c).hypot(at[1] - known[1] + shift * s);
        assert!(off < 0.05, "column {col} row {row}: {off}");
    }
    assert!(discs.len() >= 42, "{}", discs.len());

    let out = world.path("blind.json");
    let said = refused(&run(&world, &image, &["--out", out.to_str().unwrap()]));
    assert!(said.contains("part.pgm") && said.contains("7 rows"), "{said}");
    // The file tells what there was.
    let file: Value = serde_json::from_str(&fs::read_to_string(&out).unwrap()).unwrap();
    let one = &file["images"][0];
    assert_eq!(one["found"], Value::Bool(false));
    assert!(one["discs_in_lattice"].as_u64().unwrap() >= 42, "{one}");
    assert!(one["refused"].as_str().unwrap().contains("no grid found"), "{one}");
}

#[test]
fn what_is_no_grid_is_refused_with_what_there_is() {
    let world = World::new();
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let noise: Vec<u8> = (0..SIDE[0] * SIDE[1]).map(|_| random()).collect();
    let constant = vec![77; SIDE[0] * SIDE[1]];
    for (name, bytes) in [("noise.pgm", noise), ("constant.pgm", constant)] {
        let image = write(&world, name, &pgm(&bytes));
        let said = refused(&run(&world, &image, &[]));
        assert!(
            said.contains(name) && said.contains("no grid found") && said.contains("candidates"),
            "{said}"
        );
    }
    for (name, bytes, word) in [
        ("none.pgm", &b"P5 0 0 255\n"[..], "none.pgm"),
        ("one.pgm", b"P5 1 1 255\n\x05", "1 x 1 pixels cannot hold"),
        ("two.pgm", b"P5 2 1 255\n\x05\x06", "2 x 1 pixels cannot hold"),
        ("huge.pgm", b"P5 20000 20000 255\n", "20000 x 20000"),
        ("short.pgm", b"P5 40 40 255\nabc", "damaged"),
        ("text.png", b"no image", "PNG, JPEG or PGM"),
    ] {
        let image = write(&world, name, bytes);
        let said = refused(&run(&world, &image, &[]));
        assert!(said.contains(word), "{name}: {said}");
    }
}

/// The head of a PNG of 20 000 x 20 000 pixels: refused by it, before anything is taken for the pixels.
#[test]
fn a_png_that_says_it_is_huge_is_refused_by_its_head() {
    let world = World::new();
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR".to_vec();
    let mut head = Vec::new();
    head.extend(20_000_u32.to_be_bytes());
    head.extend(20_000_u32.to_be_bytes());
    head.extend([8, 0, 0, 0, 0]);
    let mut crc = flate2::Crc::new();
    crc.update(b"IHDR");
    crc.update(&head);
    png.extend(&head);
    png.extend(crc.sum().to_be_bytes());
    png.extend(b"\0\0\0\x10IDAT0123456789abcdef\0\0\0\0");
    let image = write(&world, "huge.png", &png);
    let said = refused(&run(&world, &image, &[]));
    assert!(said.contains("20000 x 20000") && said.contains("8192"), "{said}");
}

#[test]
fn a_grid_that_cannot_be_is_refused_by_its_numbers() {
    let world = World::new();
    let image = write(&world, "view.pgm", &pgm(&view(&[], 0)));
    let with = |cols: &str, rows: &str, more: &[&str]| {
        let base = ["grid", &image, "--cols", cols, "--rows", rows, "--pitch-mm", "5"];
        let output = world.output("calib", &[&base[..], more].concat());
        assert!(!output.status.success(), "{}", stdout(&output));
        stderr(&output)
    };
    assert!(with("0", "7", &[]).contains("0 columns"));
    assert!(with("9", "201", &[]).contains("201 rows"));
    assert!(with("9", "7", &["--mark", "9,0"]).contains("column 9, row 0"));
    assert!(with("9", "7", &["--mark", "3"]).contains("a column and a row are needed"));
    let other = with("8", "7", &[]);
    assert!(
        other.contains("9 columns and 7 rows") && other.contains("8 columns and 7 rows were looked for"),
        "{other}"
    );
}
