//! `calib bone-line` as it is typed, on images whose truth is known and on PLUS's recording of a bone.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use geometry::{Image, Marker, Point, Rigid, Tracker, Vector};
use ultrasound::{Beams, Pose, Scanner, Scene, Settings, Shape};

use crate::cli::{Cli, run};
use crate::commands::Outcome;
use crate::commands::probe::ImagesRecord;
use crate::surface::calibrated::Calibrated;
use crate::surface::calibrated::tests::calibrated;

use super::BoneLineArgs;

const SIZE: [usize; 2] = [300, 300];
const PIXEL: f64 = 0.13;
const IMAGES: usize = 3;
/// Depth of the flat bone in image 0, and how much deeper each next one shows it, as its probe is held higher.
const DEPTH_MM: [f64; 2] = [18.0, 1.0];

fn rigid<A, B>(w: [f64; 3], t: [f64; 3]) -> Rigid<A, B> {
    Rigid::from_rotation_vector(Vector::new(w[0], w[1], w[2]), Vector::new(t[0], t[1], t[2])).unwrap()
}

fn marker_from_image() -> Rigid<Marker, Image> {
    rigid([0.4, -0.9, 1.1], [12.0, 45.0, -8.0])
}

/// In the tracker's frame the image's plane of frame 0, moved towards its own top by each next one.
fn tracker_from_image(frame: usize) -> Rigid<Tracker, Image> {
    let moved: Rigid<Image, Image> = rigid([0.0; 3], [0.0, -DEPTH_MM[1] * frame as f64, 0.0]);
    rigid::<Tracker, Image>([0.2, 0.7, -0.3], [50.0, -20.0, 35.0]) * moved
}

fn matrix<A, B>(pose: &Rigid<A, B>, scale: f64) -> String {
    let (rows, t) = (pose.rotation().matrix().rows(), pose.translation_mm());
    let row = |i: usize| {
        let [a, b, c] = rows[i].map(|x| x * scale);
        format!("{a:.9} {b:.9} {c:.9} {:.9}", t[i])
    };
    format!("{} {} {} 0 0 0 1", row(0), row(1), row(2))
}

/// A folder with a sequence of a flat bone under muscle.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new(status: &str, is_bone: bool) -> Self {
        let beams = Beams::Linear {
            from_mm: 0.0,
            to_mm: 299.0 * PIXEL,
            face_mm: 0.0,
        };
        let shape = Shape::new(SIZE, [PIXEL; 2], beams, 38.0).unwrap();
        let mut scanner = Scanner::new(&shape, &Settings::shallow()).unwrap();
        let mut header = format!(
            "ObjectType = Image\nNDims = 3\nDimSize = {} {} {IMAGES}\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MF\n",
            SIZE[0], SIZE[1]
        );
        let mut data = Vec::new();
        for frame in 0..IMAGES {
            let pose = tracker_from_image(frame) * marker_from_image().inverse();
            writeln!(
                header,
                "Seq_Frame{frame:04}_ProbeToTrackerTransform = {}",
                matrix(&pose, 1.0)
            )
            .unwrap();
            writeln!(header, "Seq_Frame{frame:04}_ProbeToTrackerTransformStatus = {status}").unwrap();
            writeln!(header, "Seq_Frame{frame:04}_Timestamp = {}", 5.0 + 0.1 * frame as f64).unwrap();
            let top = DEPTH_MM[0];
            let body = move |[_, y, _]: [f64; 3]| if !is_bone || y < top { 50.0 } else { 900.0 };
            let at = Pose::new(
                [0.0, -DEPTH_MM[1] * frame as f64, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
            )
            .unwrap();
            data.extend(scanner.scan(&Scene::of(&body), &at, frame as u64).unwrap());
        }
        header.push_str("ElementDataFile = LOCAL\n");
        let desk = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        fs::write(desk.path("s.mha"), [header.as_bytes(), &data].concat()).unwrap();
        fs::write(desk.path("m.txt"), matrix(&marker_from_image(), PIXEL)).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `calib bone-line` with these words; one that begins with `@` is a file of the folder.
    fn line(&self, words: &str) -> Result<Outcome, String> {
        let line = format!("calib bone-line {words}");
        let words = line.split_whitespace().map(|word| match word.strip_prefix('@') {
            Some(name) => self.path(name).to_str().unwrap().to_owned(),
            None => word.to_owned(),
        });
        let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
        run(cli, |_| Err("no CT is read here".into()))
    }
}

const COMMON: &str = "--sequence @s.mha --transform ProbeToTracker --image-to-probe @m.txt --to @p.csv";
const BEAMS: &str = "--array linear:0,299,0 --depth-mm 38";

/// Columns of a file of points, by name.
fn columns<const N: usize>(path: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let text = fs::read_to_string(path).unwrap();
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = rows.next().unwrap().split(',').collect();
    let at = names.map(|name| head.iter().position(|column| *column == name).unwrap());
    rows.map(|row| {
        let words: Vec<&str> = row.split(',').collect();
        at.map(|i| words[i].parse().unwrap())
    })
    .collect()
}

/// A flat bone, of which each image shows another depth by another pose: all points are in its plane.
#[test]
fn bone_in_a_recorded_sequence_becomes_points_in_the_reference() {
    let desk = Desk::new("OK", true);
    let made = desk.line(&format!("{COMMON} {BEAMS} --picture @l.png")).unwrap();
    println!("{}", made.text);
    assert!(made.text.contains("in 3 of 3 images"), "{}", made.text);
    let points = columns(&desk.path("p.csv"), ["x", "y", "z", "depth"]);
    // 38 mm of it, a point each 2 mm: 17 and more in each image.
    assert!(points.len() >= 3 * 15, "{}", points.len());
    let back = tracker_from_image(0).inverse();
    for [x, y, z, depth] in &points {
        let [_, below, aside] = (back * Point::<Tracker>::new(*x, *y, *z)).mm();
        // The top of the echo lies within half a pulse of the surface: docs/bone-line.md.
        assert!(
            (below - DEPTH_MM[0]).abs() < 0.5 && aside.abs() < 1e-6,
            "{below} {aside}"
        );
        assert!((DEPTH_MM[0] - 0.5..DEPTH_MM[0] + 2.5).contains(depth), "{depth}");
    }
    assert!(
        image::load_from_memory(&fs::read(desk.path("l.png")).unwrap())
            .unwrap()
            .width()
            == 1200
    );
    // Its file says the frame, and that no calibration was compared.
    let text = fs::read_to_string(desk.path("p.csv")).unwrap();
    assert!(
        text.starts_with("# places of the tip of Probe in the tracker, mm; calibration "),
        "{text}"
    );
    // A lag of one frame's time: the points of an image lie by the next one's pose, 1 mm higher.
    let late = desk
        .line(&format!("{COMMON} {BEAMS} --overwrite --lag-ms 100,0"))
        .unwrap();
    assert!(late.text.contains("in 3 of 3 images"), "{}", late.text);
    for [x, y, z] in columns(&desk.path("p.csv"), ["x", "y", "z"]) {
        let [_, below, _] = (back * Point::<Tracker>::new(x, y, z)).mm();
        assert!((below - DEPTH_MM[0] + DEPTH_MM[1]).abs() < 0.5, "{below}");
    }
}

#[test]
fn what_gives_no_points_is_refused_by_name() {
    let desk = Desk::new("OK", true);
    let refused = |desk: &Desk, words: &str| desk.line(words).unwrap_err();
    let words = refused(&desk, COMMON);
    assert!(words.contains("where beams run in the images is not known"), "{words}");
    let words = refused(&desk, &format!("{COMMON} --array linear:0,299,0 --depth-mm 8"));
    assert!(words.contains("searching image 0: the image is 8.0 mm deep"), "{words}");
    let other = COMMON.replace("ProbeToTracker", "ProbeToTable");
    let words = refused(&desk, &format!("{other} {BEAMS}"));
    assert!(words.contains("no transform ProbeToTable"), "{words}");
    fs::write(desk.path("p.csv"), "mine").unwrap();
    let words = refused(&desk, &format!("{COMMON} {BEAMS}"));
    assert!(words.contains("there is a file of this name"), "{words}");
    // Nobody saw the marker.
    let hidden = Desk::new("INVALID", true);
    let words = refused(&hidden, &format!("{COMMON} {BEAMS}"));
    assert!(
        words.contains("none of 3 frames") && words.contains("valid pose ProbeToTracker"),
        "{words}"
    );
    // Muscle all the way down; the picture is there to look at.
    let muscle = Desk::new("OK", false);
    let words = refused(&muscle, &format!("{COMMON} {BEAMS} --picture @l.png"));
    assert!(
        words.contains("of 3 images of") && words.contains("none shows bone"),
        "{words}"
    );
    assert!(muscle.path("l.png").exists() && !muscle.path("p.csv").exists());
}

/// The numbers of docs/bone-line.md, by the command and PLUS's own matrix and drawing of the array.
#[test]
fn the_arc_of_the_recording_of_plus_is_found_in_all_its_images() {
    let Some(shared) = std::env::var_os("TROCAR_SHARED") else {
        println!("SKIPPED: no TROCAR_SHARED");
        return;
    };
    let folder = Path::new(&shared).join("data/plus-ultrasound");
    let (sequence, set) = (
        folder.join("BoneUltrasound_L14.igs.mha"),
        folder.join("BoneUltrasound_L14_config.xml"),
    );
    if !sequence.exists() {
        println!("SKIPPED: no recording");
        return;
    }
    let desk = Desk {
        folder: tempfile::tempdir().unwrap(),
    };
    let at = |path: &Path| path.to_str().unwrap().to_owned();
    let common = format!(
        "--sequence {} --image-to-probe {} --to @p.csv --overwrite",
        at(&sequence),
        at(&set)
    );
    // Where beams run as it was read off the images, and as the device set has it.
    for beams in ["--array linear:175.5,642.5,3 --depth-mm 52", ""] {
        let made = desk.line(&format!("{common} {beams} --picture @l.png")).unwrap();
        println!("{}", made.text);
        assert!(made.text.contains("in 21 of 21 images"), "{}", made.text);
        assert!(made.text.contains("in the reference"), "{}", made.text);
        let points = columns(&desk.path("p.csv"), ["depth", "beam_x", "beam_y", "beam_z"]);
        let depths = || points.iter().map(|row| row[0]);
        let top = depths().fold(f64::INFINITY, f64::min);
        // 22.3 to 22.6 mm with pixels of 0.085 mm; the matrix has 0.5 % more. A fascia would be at 20 mm or above.
        assert!((22.2..23.1).contains(&top), "{top}");
        assert!(depths().all(|depth| depth < 40.0));
        // The probe hardly moved: its beams are nearly one direction.
        for axis in 1..4 {
            let (least, most) = points
                .iter()
                .fold((1.0_f64, -1.0_f64), |(a, b), row| (a.min(row[axis]), b.max(row[axis])));
            assert!(most - least < 0.05, "{axis}: {least} {most}");
        }
    }
}

/// Where a lag was told, every image was once refused as of another depth than the calibration's, as the picture ends above the depth that
/// was set.
#[test]
fn a_picture_that_ends_above_the_depth_gives_its_points_with_a_lag_too() {
    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        args: BoneLineArgs,
    }
    let desk = Desk::new("OK", true);
    let path = |name: &str| desk.path(name).to_str().unwrap().to_owned();
    let words = format!(
        "calib --sequence {} --transform ProbeToTracker --image-to-probe {} --to {} --array linear:0,299,0 --depth-mm 60",
        path("s.mha"),
        path("m.txt"),
        path("p.csv")
    );
    let Only { args } = Only::parse_from(words.split_whitespace());
    let mut probe = calibrated(ImagesRecord {
        depth_mm: Some(60.0),
        ..ImagesRecord::default()
    });
    probe.pixel_mm = [PIXEL; 2];
    let shapes = args.shapes(&probe).unwrap();
    assert!(shapes[1].depth_mm() < 40.0);
    let count = |probe: &Calibrated| {
        let found = args.find(probe, &shapes, ("probe", "tracker")).unwrap();
        assert!(found.taken.refused.is_none());
        found.taken.count
    };
    let own = count(&probe);
    probe.lag_s = [-0.01, 0.0];
    let late = count(&probe);
    // The first image has no pose before it.
    assert!(own > 20 && late > own / 2 && late <= own, "{own} {late}");
}
