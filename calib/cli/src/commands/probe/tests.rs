//! The command on files made by hand: what it writes is read back, what is wrong is refused by name.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use geometry::{Image, Phantom, Point, Probe, Reference, Rigid, Vector};

use super::{ArrayRecord, ProbeFile};
use crate::cli::{Cli, run};
use crate::commands::Outcome;

/// Three wires in N, twice, 15 mm apart.
const WIRES: [(&str, [f64; 3], [f64; 3]); 6] = [
    ("a", [0.0, 0.0, 0.0], [0.0, 40.0, 0.0]),
    ("b", [5.0, 0.0, 0.0], [25.0, 40.0, 0.0]),
    ("c", [30.0, 0.0, 0.0], [30.0, 40.0, 0.0]),
    ("d", [0.0, 0.0, 15.0], [0.0, 40.0, 15.0]),
    ("e", [25.0, 0.0, 15.0], [5.0, 40.0, 15.0]),
    ("f", [30.0, 0.0, 15.0], [30.0, 40.0, 15.0]),
];
const PIXEL: [f64; 2] = [0.1, 0.08];

fn rigid<A, B>(w: [f64; 3], t: [f64; 3]) -> Rigid<A, B> {
    Rigid::from_rotation_vector(Vector::new(w[0], w[1], w[2]), Vector::new(t[0], t[1], t[2])).unwrap()
}

fn planted() -> (Rigid<Probe, Image>, Rigid<Reference, Phantom>) {
    (
        rigid([0.4, -0.9, 1.1], [12.0, 45.0, -8.0]),
        rigid([0.2, 0.7, -0.3], [50.0, -20.0, 35.0]),
    )
}

fn matrix<A, B>(pose: &Rigid<A, B>) -> String {
    let (rows, t) = (pose.rotation().matrix().rows(), pose.translation_mm());
    let row = |i: usize| format!("{:.9} {:.9} {:.9} {:.9}", rows[i][0], rows[i][1], rows[i][2], t[i]);
    format!("{} {} {} 0 0 0 1", row(0), row(1), row(2))
}

/// Twelve images of the wires: sequence, points as CSV, device set.
struct Files {
    folder: tempfile::TempDir,
    header: String,
    points: String,
    config: String,
}

fn files() -> Files {
    let (probe_from_image, reference_from_phantom) = planted();
    let (mut header, mut points) = (
        "ObjectType = Image\nNDims = 3\n".to_owned(),
        "frame,wire,u,v\n".to_owned(),
    );
    for i in 0..12_u32 {
        let k = f64::from(i);
        // The image's middle in the phantom's, its rows along x, its beam down.
        let tilt: Rigid<Phantom, Phantom> = rigid(
            [0.2 * k.sin(), 0.15 * (2.0 * k).cos(), 0.2 * (1.3 * k).sin()],
            [15.0, 10.0 + 1.7 * k, 7.0],
        );
        let upright: Rigid<Phantom, Image> = rigid([-std::f64::consts::FRAC_PI_2, 0.0, 0.0], [-20.0, 0.0, 20.0]);
        let phantom_from_image = tilt * upright;
        let pose = reference_from_phantom * phantom_from_image * probe_from_image.inverse();
        writeln!(header, "Seq_Frame{i:04}_ProbeToReferenceTransform = {}", matrix(&pose)).unwrap();
        writeln!(header, "Seq_Frame{i:04}_ProbeToReferenceTransformStatus = OK").unwrap();
        writeln!(header, "Seq_Frame{i:04}_Timestamp = {}", 100.0 + 0.1 * k).unwrap();
        for (name, front, back) in WIRES {
            let back_of = phantom_from_image.inverse();
            let [a, b] = [front, back].map(|p| (back_of * Point::new(p[0], p[1], p[2])).mm());
            let share = a[2] / (a[2] - b[2]);
            let [u, v] = [0, 1].map(|k| (a[k] + share * (b[k] - a[k])) / PIXEL[k]);
            if (0.0..=1.0).contains(&share) {
                writeln!(points, "{i},{name},{u:.4},{v:.4}").unwrap();
            }
        }
    }
    header.push_str("ElementDataFile = LOCAL\n");
    let wire = |(name, a, b): (&str, [f64; 3], [f64; 3])| {
        let end = |p: [f64; 3]| format!("{} {} {}", p[0], p[1], p[2]);
        format!(
            "<Wire Name=\"{name}\" EndPointFront=\"{}\" EndPointBack=\"{}\" />",
            end(a),
            end(b)
        )
    };
    let wires: Vec<String> = WIRES.into_iter().map(wire).collect();
    let config = format!(
        "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Phantom\" To=\"Reference\" Matrix=\"{}\" Error=\"0.5\" />\
         </CoordinateDefinitions><PhantomDefinition><Geometry><Pattern>{}</Pattern></Geometry></PhantomDefinition></PlusConfiguration>",
        matrix(&reference_from_phantom),
        wires.concat()
    );
    Files {
        folder: tempfile::tempdir().unwrap(),
        header,
        points,
        config,
    }
}

impl Files {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn answer(&self, more: &str) -> Result<Outcome, String> {
        fs::write(self.path("s.mha"), &self.header).unwrap();
        fs::write(self.path("p.csv"), &self.points).unwrap();
        fs::write(self.path("c.xml"), &self.config).unwrap();
        let at = |name: &str| self.path(name).to_string_lossy().into_owned();
        let fixed = [
            "calib".into(),
            "probe".into(),
            "--points".into(),
            at("p.csv"),
            "--sequence".into(),
            at("s.mha"),
        ];
        let more = more.split_whitespace().map(|word| match word {
            "c.xml" | "out.json" => at(word),
            word => word.to_owned(),
        });
        let cli = Cli::try_parse_from(fixed.into_iter().chain(more)).map_err(|e| e.to_string())?;
        run(cli, |_| Err("no volume here".into()))
    }

    fn refused(&self, more: &str) -> String {
        match self.answer(more) {
            Err(error) => error,
            Ok(outcome) => outcome.refused.unwrap_or_else(|| panic!("{}", outcome.text)),
        }
    }
}

const EXACT: &str = "--config c.xml --phantom-error-mm 0 --phantom-error-deg 0";

#[test]
fn what_is_written_is_read_back_and_is_the_planted_image() {
    let files = files();
    let outcome = files.answer(&format!("{EXACT} --out out.json")).unwrap();
    assert_eq!(outcome.refused, None, "{}", outcome.text);
    assert!(outcome.text.contains("held least       the image "), "{}", outcome.text);
    let file = ProbeFile::read(&files.path("out.json")).unwrap();
    let (planted, _) = planted();
    let found = file.probe_from_image().unwrap();
    // Pixels with four digits are rounded by 5e-6 mm, and nine digits of a matrix less.
    let off = Vector3::from(found.transform().translation_mm()) - Vector3::from(planted.translation_mm());
    assert!(off.norm() < 1e-3, "{off}");
    assert!(found.transform().rotation().distance(planted.rotation()) < 1e-4);
    assert!((file.pixel_mm[0] / PIXEL[0] - 1.0).abs() < 1e-5, "{:?}", file.pixel_mm);
    assert_eq!(
        (file.frames, file.method.as_str(), file.sources.len()),
        ([12, 0], "wires", 3)
    );
    // By its own wires it is right, and by a phantom 1 mm aside it is not.
    let check = format!("{EXACT} --check out.json");
    let checked = files.answer(&check).unwrap();
    assert!(
        checked.refused.is_none() && checked.text.contains("of one wire"),
        "{}",
        checked.text
    );
    let mut aside = self::files();
    let (_, place) = self::planted();
    let moved = rigid::<Reference, Reference>([0.0; 3], [1.0, 1.0, 0.0]) * place;
    aside.config = aside.config.replace(&matrix(&place), &matrix(&moved));
    fs::copy(files.path("out.json"), aside.path("out.json")).unwrap();
    let refused = aside.refused(&check);
    assert!(refused.contains("is not where these wires say"), "{refused}");
    // A changed number is seen, and so is a file of another kind.
    let text = fs::read_to_string(files.path("out.json")).unwrap();
    let changed = |from: &str, to: &str| {
        fs::write(files.path("changed.json"), text.replace(from, to)).unwrap();
        ProbeFile::read(&files.path("changed.json")).unwrap_err().to_string()
    };
    assert!(changed("\"points\": ", "\"points\": 1").contains("it was changed; calibrate again"));
    assert!(changed("trocar-probe", "trocar-camera").contains("expected \"trocar-probe\", 1"));
    assert!(
        files
            .refused(&format!("{EXACT} --out out.json"))
            .contains("there is a file of this name")
    );
}

use nalgebra::Vector3;

#[test]
fn what_is_wrong_is_refused_by_name() {
    assert!(files().refused("--config c.xml").contains("--phantom-error-mm"));
    assert!(
        files()
            .refused(&format!("{EXACT} --wall"))
            .contains("cannot be used with")
    );
    assert!(
        files()
            .refused(&format!("{EXACT} --noise-mm 0,0.1,0.1"))
            .contains("the lateral noise, mm is 0; allowed is 0.001 to 10")
    );
    assert!(
        files()
            .refused(&format!("{EXACT} --lag-ms 50"))
            .contains("give the track a window")
    );
    assert!(
        files()
            .refused(&format!("{EXACT} --transform ProbeToTable"))
            .contains("ProbeToTable")
    );
    let with = |change: &dyn Fn(&mut Files)| {
        let mut files = files();
        change(&mut files);
        files.refused(EXACT)
    };
    let points =
        |from: &'static str, to: &'static str| with(&move |files| files.points = files.points.replacen(from, to, 1));
    assert!(
        points("frame,wire", "wire,frame")
            .contains("line 1: found \"wire,frame,u,v\", expected the columns frame,wire,u,v")
    );
    assert!(points("\n0,a,", "\n0,x,").contains("frame 0: there is no wire \"x\"; there are \"a\", \"b\""));
    assert!(points("\n0,a,", "\n0,a,nan,").contains("line 2: found"));
    assert!(points("\n0,a,", "\n99,a,").contains("has no frame of that number"));
    let lost = with(&|files| {
        for i in 0..8 {
            let status = format!("Seq_Frame{i:04}_ProbeToReferenceTransformStatus = ");
            files.header = files
                .header
                .replace(&format!("{status}OK"), &format!("{status}INVALID"));
        }
    });
    assert!(lost.contains("8 of 12 frames with points have no valid pose"), "{lost}");
    // Two wires that were taken for one another.
    let swapped = with(&|files| {
        files.points = files
            .points
            .replace(",a,", ",A,")
            .replace(",c,", ",a,")
            .replace(",A,", ",c,");
    });
    assert!(
        swapped.contains("residuals over the noise given") || swapped.contains("calibrating the probe"),
        "{swapped}"
    );
    // A phantom in metres.
    let metres = with(&|files| {
        files.config = files
            .config
            .replace("40 0\"", "0.04 0\"")
            .replace("40 15\"", "0.04 15\"");
    });
    assert!(
        metres.contains("are these metres?") || metres.contains("parallel") || metres.contains("noise given"),
        "{metres}"
    );
}

/// Water of 20 degrees makes pixels 3.7 % too short along the beam, unless its temperature is told; the phantom stands where it stands.
#[test]
fn a_probe_calibrated_in_cold_water_has_the_pixels_of_tissue() {
    let array = "--array linear:0,400,6";
    let share = 1482.38 / 1540.0;
    let mut cold = files();
    let shown = |line: &str| match line.rsplit_once(',') {
        Some((left, v)) if v != "v" => format!("{left},{:.4}\n", 6.0 + (v.parse::<f64>().unwrap() - 6.0) / share),
        _ => format!("{line}\n"),
    };
    cold.points = cold.points.lines().map(shown).collect();
    let of = |more: &str| {
        let outcome = cold.answer(&format!("{EXACT} --out out.json {more}")).unwrap();
        assert_eq!(outcome.refused, None, "{}", outcome.text);
        let file = ProbeFile::read(&cold.path("out.json")).unwrap();
        fs::remove_file(cold.path("out.json")).unwrap();
        (outcome.text, file)
    };
    let (_, untold) = of("");
    assert!((untold.pixel_mm[1] / (share * PIXEL[1]) - 1.0).abs() < 1e-5 && untold.water.is_none());
    let (text, told) = of(&format!("{array} --water-celsius 20"));
    // The planted image and its pixels, as without water: the formula's speed is that above to 3e-6.
    let ((planted, _), found) = (planted(), told.probe_from_image().unwrap());
    let off = Vector3::from(found.transform().translation_mm()) - Vector3::from(planted.translation_mm());
    assert!(off.norm() < 2e-3, "{off}");
    assert!((told.pixel_mm[1] / PIXEL[1] - 1.0).abs() < 2e-5, "{:?}", told.pixel_mm);
    assert!((told.pixel_mm[0] / PIXEL[0] - 1.0).abs() < 1e-5, "{:?}", told.pixel_mm);
    let water = told.water.unwrap();
    assert!((water.speed_m_s - 1482.38).abs() < 0.01 && water.scanner_m_s == 1540.0 && water.celsius == 20.0);
    assert!(text.contains("20.0 C: sound at 1482.4 m/s, 3.7 % slower"), "{text}");
    // Its check is made in water too.
    let written = cold
        .answer(&format!("{EXACT} {array} --water-celsius 20 --out out.json"))
        .unwrap();
    assert_eq!(written.refused, None);
    let check = format!("{EXACT} --check out.json");
    assert!(
        cold.answer(&format!("{check} {array} --water-celsius 20"))
            .unwrap()
            .refused
            .is_none()
    );
    assert!(cold.answer(&check).unwrap().refused.is_some());
    assert!(
        cold.refused(&format!("{EXACT} --water-celsius 20"))
            .contains("needs to know where beams run")
    );
    assert!(
        cold.refused(&format!("{EXACT} {array} --water-celsius 96"))
            .contains("from 0 to 95")
    );
}

/// A crop, a flip, another depth, another array and another tool's probe went unseen: nothing in the file said what it was of.
#[test]
fn a_calibration_says_which_images_and_which_tool_it_is_of() {
    let of = |files: &Files, more: &str| {
        let outcome = files.answer(&format!("{EXACT} --out out.json {more}")).unwrap();
        let file = ProbeFile::read(&files.path("out.json")).unwrap();
        fs::remove_file(files.path("out.json")).unwrap();
        (outcome.text, file.images.unwrap())
    };
    // Poses alone and a phantom: the transform's names are all that is known, and what is not is told.
    let files = files();
    let (text, bare) = of(&files, "");
    assert_eq!(
        (
            bare.tool.as_deref(),
            bare.marker.as_deref(),
            bare.reference.as_deref(),
            bare.size_px
        ),
        (Some("Probe"), Some("Probe"), Some("Reference"), None)
    );
    assert!(
        text.contains("not told: the size of the images, the array (--array or --scan)"),
        "{text}"
    );
    // All that PLUS writes.
    let mut whole = self::files();
    whole.header = whole.header.replace(
        "NDims = 3\n",
        "NDims = 3\nDimSize = 400 300 12\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MF\n",
    );
    let scan = "<ScanConversion TransducerGeometry=\"LINEAR\" ImagingDepthMm=\"24\" TransducerWidthMm=\"38\" OutputImageSizePixel=\"400 300\" \
                TransducerCenterPixel=\"200 2\" OutputImageSpacingMmPerPixel=\"0.1 0.08\" NumberOfScanLines=\"128\" /></PlusConfiguration>";
    whole.config = whole.config.replace("</PlusConfiguration>", scan);
    let (text, told) = of(&whole, "--tool us-probe");
    let linear = ArrayRecord::Linear {
        from_px: 10.0,
        to_px: 390.0,
        face_px: 2.0,
    };
    assert_eq!(
        (
            told.size_px,
            told.orientation.as_deref(),
            told.array,
            told.lines,
            told.depth_mm,
            told.tool.as_deref()
        ),
        (
            Some([400, 300]),
            Some("MF"),
            Some(linear),
            Some(128),
            Some(24.0),
            Some("us-probe")
        )
    );
    assert!(
        text.contains("400 x 300 pixels; turned MF; a linear array") && !text.contains("not told"),
        "{text}"
    );
    // The command line overrules a device set, and one of images of another size is not taken.
    let (_, curved) = of(&whole, "--array curved:200,-600,620,60 --depth-mm 22");
    assert!(
        matches!(curved.array, Some(ArrayRecord::Curved { angle_deg, .. }) if angle_deg == 60.0)
            && curved.depth_mm == Some(22.0)
    );
    whole.header = whole.header.replace("400 300 12", "400 280 12");
    let (text, other) = of(&whole, "");
    assert!(
        other.array.is_none() && text.contains("of images of 400 x 300 pixels and these have 400 x 280"),
        "{text}"
    );
    let refused = whole.refused(&format!("{EXACT} --array linear:390,10,2"));
    assert!(refused.contains("expected linear:U,U,V"), "{refused}");
}

/// The recording of PLUS from its own files: accepted with what its tracker needs, refused without.
#[test]
fn the_recording_of_plus() {
    let Some(shared) = std::env::var_os("TROCAR_SHARED") else {
        println!("SKIPPED: no TROCAR_SHARED");
        return;
    };
    let folder = Path::new(&shared).join("data/plus-ultrasound");
    let at = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let mut words = vec![
        "calib".to_owned(),
        "probe".to_owned(),
        "--points".to_owned(),
        at("nwire_points_calibration.json"),
    ];
    words.extend([
        "--sequence".to_owned(),
        at("fCal_Test_Calibration_3NWires_fCal2.0.igs.mha"),
    ]);
    words.extend([
        "--config".to_owned(),
        at("PlusDeviceSet_fCal_Sim_SpatialCalibration_2.0.xml"),
    ]);
    words.extend("--phantom-error-mm 0 --phantom-error-deg 0 --noise-mm 0.15,0.15,0.3 --pose-noise-mm 0.15 --pose-noise-deg 0.115".split(' ').map(str::to_owned));
    words.extend(
        "--window-ms 100 --lag-ms 100 --tracker-percent 3"
            .split(' ')
            .map(str::to_owned),
    );
    let outcome = run(Cli::try_parse_from(words).unwrap(), |_| Err("no volume here".into())).unwrap();
    println!("{}", outcome.text);
    assert_eq!(outcome.refused, None, "{}", outcome.text);
    assert!(
        outcome.text.contains("184 of 190 frames with points, 1656 points"),
        "{}",
        outcome.text
    );
}
