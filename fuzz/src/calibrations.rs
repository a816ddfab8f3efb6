//! Tables, results, tool definitions and images, as the command line `calib` takes them.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use calib_cli::cli::{Hands, answer};
use calib_cli::{CameraFile, FollowMarkers, Loaded};
use image::{DynamicImage, GrayImage, ImageFormat, Luma};

use crate::{Failure, Folder};

type Seeds = Result<Vec<Vec<u8>>, Failure>;

/// A command and the name of the file that takes the bytes.
type Command = (&'static [&'static str], &'static str);

const TABLES: [Command; 7] = [
    (&["pivot", "--poses"], "poses.csv"),
    (&["spin", "--poses"], "poses.csv"),
    (&["register", "--pairs"], "pairs.csv"),
    (&["register", "--to-points", "good.txt", "--from-points"], "points.txt"),
    (&["marker", "--sigma-mm", "0.1"], "frames.csv"),
    (&["base", "--drawing", "base.toml"], "touches.csv"),
    (&["base", "touches.csv", "--drawing"], "drawing.toml"),
];

const RESULTS: [Command; 5] = [
    (
        &["check", "--known", "1,2,3", "--touched", "1,2,3"],
        "registration.json",
    ),
    (&["tool", "--spin", "axis.json", "--pivot"], "tip.json"),
    (&["match", "beads.json"], "touched.txt"),
    (&["seat", "--poses", "poses.csv", "--base"], "base.json"),
    (&["camera"], "grids.json"),
];

/// Runs a command line, with a file as its last word.
pub(crate) fn calib(words: &[&str], last: Option<&Path>) {
    let _ = output(words, last);
}

fn output(words: &[&str], last: Option<&Path>) -> Result<String, String> {
    let follow: FollowMarkers = |_| Err("nothing is followed here".into());
    let hands = Hands {
        load: |spec| {
            let (volume, told) = volume_loader::load_told(spec)?;
            Ok(Loaded {
                volume,
                modality: told.modality,
                warnings: told.warnings,
            })
        },
        labels: volume_loader::load_labels,
        label_names: |path| Ok(volume_loader::label_names(path)?),
        follow,
    };
    let words = words.iter().map(PathBuf::from).chain(last.map(Path::to_owned));
    answer(
        std::iter::once(PathBuf::from("calib"))
            .chain(words)
            .map(PathBuf::into_os_string),
        hands,
    )
}

/// The first byte says which command, the others are its file.
fn by_command(commands: &[Command], bytes: &[u8], others: &[(&str, &str)]) {
    let Some((which, bytes)) = bytes.split_first() else {
        return;
    };
    let (words, name) = commands[usize::from(*which) % commands.len()];
    let Ok(folder) = Folder::new() else { return };
    for (name, text) in others {
        folder.file(name, text.as_bytes());
    }
    let Some(path) = folder.file(name, bytes) else { return };
    // Words that name a file beside it.
    let whole: Vec<String> = words
        .iter()
        .map(|w| {
            let beside = folder.path().join(w);
            if beside.is_file() {
                beside.to_string_lossy().into_owned()
            } else {
                (*w).to_owned()
            }
        })
        .collect();
    calib(&whole.iter().map(String::as_str).collect::<Vec<_>>(), Some(&path));
}

/// Tables of poses, pairs, points, sightings and touches; a drawing; a gesture.
pub(crate) fn table(bytes: &[u8]) {
    by_command(
        &TABLES,
        bytes,
        &[("good.txt", POINTS), ("base.toml", DRAWING), ("touches.csv", TOUCHES)],
    );
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = tracker_proc::operating_room::Played::parse(text, Path::new("fuzz.csv"), Default::default());
    }
}

/// Results that another step reads: registrations, tips, axes, beads, bases, grids, cameras.
pub(crate) fn result(bytes: &[u8]) {
    by_command(
        &RESULTS,
        bytes,
        &[("poses.csv", &poses()), ("beads.json", "{}"), ("axis.json", "{}")],
    );
    let Some((_, bytes)) = bytes.split_first() else { return };
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = calib::file::RegistrationFile::parse(text).map_err(|error| error.to_string());
        let _ = calib::file::ToolFile::parse(text).map_err(|error| error.to_string());
    }
    let Ok(folder) = Folder::new() else { return };
    if let Some(path) = folder.file("camera.toml", bytes) {
        let _ = CameraFile::read(&path).map_err(|error| error.to_string());
    }
}

/// A tool definition; its checksum is put right in half of the inputs, as hardly one would be otherwise.
pub(crate) fn rom(bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    let mut summed = bytes.to_vec();
    if bytes.len() > 6 {
        let sum: u16 = bytes[6..].iter().fold(0, |sum, b| sum.wrapping_add(u16::from(*b)));
        summed[4..6].copy_from_slice(&sum.to_le_bytes());
    }
    for bytes in [bytes, &summed] {
        if let Some(path) = folder.file("bytes.rom", bytes) {
            calib(&["rom", "info"], Some(&path));
            calib(&["marker", "--rom"], Some(&path));
        }
    }
}

/// An image, whose pixels are only read.
pub(crate) fn image(bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    if let Some(path) = folder.file("bytes.png", bytes) {
        let _ = calib_cli::read_image(&path).map_err(|error| error.to_string());
    }
}

const POINTS: &str = "0 0 0\n100 0 0\n0 80 0\n0 0 60\n";
const DRAWING: &str = "[plane]\nat_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
                       [[groove]]\nstart_mm = [15, 0, -4]\nend_mm = [60, 0, -4]\nhalf_angle_deg = 45\n\
                       [[groove]]\nstart_mm = [-7.5, 13, -4]\nend_mm = [-30, 52, -4]\nhalf_angle_deg = 45\n\
                       [[groove]]\nstart_mm = [-7.5, -13, -4]\nend_mm = [-30, -52, -4]\nhalf_angle_deg = 45\n\
                       [seat]\nquaternion = [1, 0, 0, 0]\ntranslation_mm = [0, 0, 80]\n";
const TOUCHES: &str = "on,x,y,z\nplane,1,2,0\nplane,30,-9,0\nplane,-20,30,0\ngroove 0,20,0,-4\ngroove 0,50,0,-4\n\
                       groove 1,-10,17.3,-4\ngroove 1,-25,43.3,-4\ngroove 2,-10,-17.3,-4\ngroove 2,-25,-43.3,-4\n";

/// Poses of an instrument that turns about its tip.
fn poses() -> String {
    let mut text = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned();
    for i in 0..40 {
        let turn = f64::from(i) * 0.4;
        let (s, c) = 0.3_f64.sin_cos();
        let (x, y) = (s * turn.cos(), s * turn.sin());
        // The marker 100 mm from the tip, along the turned z axis.
        let at = [200.0 * c * y, -200.0 * c * x, 100.0 * (1.0 - 2.0 * (x * x + y * y))];
        text += &format!("{},{c},{x},{y},0,{},{},{}\n", 0.02 * f64::from(i), at[0], at[1], at[2]);
    }
    text
}

fn with(which: u8, text: &str) -> Vec<u8> {
    [&[which], text.as_bytes()].concat()
}

pub(crate) fn tables() -> Seeds {
    let pairs = "to_x,to_y,to_z,from_x,from_y,from_z,weight,label\n0,0,0,1,2,3,1,a\n100,0,0,101,2,3,1,b\n\
                 0,80,0,1,82,3,1,c\n0,0,60,1,2,63,1,d\n";
    let mut frames = "frame,emitter,x,y,z,cxx,cxy,cxz,cyy,cyz,czz\n".to_owned();
    for (frame, emitter) in (0..6).flat_map(|f| (0..4).map(move |e| (f, e))) {
        let place = [[0, 0, 0], [50, 0, 0], [0, 40, 0], [0, 0, 30]][emitter];
        frames += &format!(
            "{frame},{emitter},{},{},{},0.01,0,0,0.01,0,0.04\n",
            place[0] + frame,
            place[1],
            place[2]
        );
    }
    Ok(vec![
        with(0, &poses()),
        with(1, &poses()),
        with(2, pairs),
        with(3, POINTS),
        with(4, &frames),
        with(5, TOUCHES),
        with(6, DRAWING),
        poses().into_bytes(),
    ])
}

/// What commands write.
pub(crate) fn results() -> Seeds {
    let folder = Folder::new()?;
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let mut seeds = Vec::new();
    for (which, input, content, words) in [
        (
            0,
            "pairs.txt",
            POINTS,
            vec![
                "register",
                "--to-points",
                "@",
                "--from-points",
                "@",
                "--to",
                "ct",
                "--from",
                "tracker",
            ],
        ),
        (1, "poses.csv", &poses(), vec!["pivot", "--poses", "@"]),
        (
            3,
            "touches.csv",
            TOUCHES,
            vec!["base", "@", "--drawing", "@base.toml", "--sigma-mm", "0.1"],
        ),
    ] {
        fs::write(file("base.toml"), DRAWING)?;
        fs::write(file(input), content)?;
        let out = file(&format!("{which}.json"));
        let words: Vec<String> = words
            .iter()
            .map(|w| match *w {
                "@" => file(input),
                w if w.starts_with('@') => file(&w[1..]),
                w => w.to_owned(),
            })
            .chain(["--out".to_owned(), out.clone()])
            .collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let said = output(&words, None);
        let text = fs::read_to_string(&out).map_err(|error| format!("{words:?}: {error}: {said:?}"))?;
        seeds.push(with(which, &text));
    }
    let image = folder.path().join("grid.png");
    fs::write(&image, encoded(ImageFormat::Png)?)?;
    let grids = file("grids.json");
    let said = output(
        &[
            "grid",
            &image.to_string_lossy(),
            "--cols",
            "5",
            "--rows",
            "5",
            "--pitch-mm",
            "5",
            "--out",
            &grids,
        ],
        None,
    );
    seeds.push(with(
        4,
        &fs::read_to_string(&grids).map_err(|error| format!("{error}: {said:?}"))?,
    ));
    seeds.push(with(2, POINTS));
    Ok(seeds)
}

pub(crate) fn roms() -> Seeds {
    let mut rom = vec![0_u8; 752];
    rom[..4].copy_from_slice(b"NDI\0");
    (rom[24], rom[28], rom[32]) = (90, 4, 3);
    rom[36..40].copy_from_slice(&0.5_f32.to_le_bytes());
    let places = [0.0, 0.0, 0.0, 0.0, 50.0, 0.0, 0.0, 0.0, 40.0, 30.0, 20.0, 10.0_f32];
    for (i, x) in places.iter().enumerate() {
        rom[72 + 4 * i..76 + 4 * i].copy_from_slice(&x.to_le_bytes());
    }
    rom[580..585].copy_from_slice(b"maker");
    rom[613..617].fill(1);
    rom[664..668].copy_from_slice(&1.0_f32.to_le_bytes());
    let sum: u16 = rom[6..].iter().fold(0, |sum, b| sum.wrapping_add(u16::from(*b)));
    rom[4..6].copy_from_slice(&sum.to_le_bytes());
    Ok(vec![rom])
}

/// A grid of 5 x 5 discs.
fn encoded(format: ImageFormat) -> Result<Vec<u8>, Failure> {
    let grey = |x: u32, y: u32| {
        let off = |k: u32| f64::from(k % 20) - 9.5;
        let inside = (16..116).contains(&x) && (16..116).contains(&y) && off(x - 16).hypot(off(y - 16)) < 5.0;
        Luma([if inside { 40 } else { 200 }])
    };
    let drawn = GrayImage::from_fn(132, 132, |x, y| if x < 16 || y < 16 { Luma([200]) } else { grey(x, y) });
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::from(drawn).write_to(&mut bytes, format)?;
    Ok(bytes.into_inner())
}

pub(crate) fn images() -> Seeds {
    [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Pnm]
        .into_iter()
        .map(encoded)
        .collect()
}
