//! `volume-loader inspect` and `export`: known facts of known volumes, and series that other software reads alike.

#![allow(clippy::print_stdout, reason = "measured differences, and why a test was skipped")]
#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::support::nifti::Nifti;
use crate::support::*;
use serde_json::Value;

/// Runs `volume-loader`, which must succeed; returns what it printed.
fn tool(world: &World, arguments: &[&str]) -> String {
    let output = world.output("volume-loader", arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

/// Runs `volume-loader`, which must fail with one paragraph that holds all `words`, between bars.
fn refused(world: &World, arguments: &[&str], words: &str) {
    let output = world.output("volume-loader", arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("volume-loader: error: ") && said.lines().count() == 1,
        "{said}"
    );
    for word in words.split(" | ") {
        assert!(said.contains(word), "{word:?} in: {said}");
    }
    assert_eq!(stdout(&output), "");
}

/// The generated patient at 6 mm.
fn patient(world: &World) -> PathBuf {
    let path = world.path("patient.nii.gz");
    tool(
        world,
        &["phantom", "--spacing-mm", "6", "--out", path.to_str().unwrap()],
    );
    path
}

/// A volume of noise with this map from voxels to mm RAS.
fn noise(world: &World, name: &str, rows: [[f32; 4]; 3]) -> PathBuf {
    let mut nifti = Nifti::noise();
    for (at, value) in rows.iter().flatten().enumerate() {
        nifti = nifti.f32(280 + 4 * at, *value);
    }
    for axis in 0..3 {
        let step = rows.iter().map(|row| row[axis] * row[axis]).sum::<f32>().sqrt();
        nifti = nifti.f32(80 + 4 * axis, step);
    }
    let path = world.path(name);
    fs::write(&path, Vec::<u8>::from(nifti)).unwrap();
    path
}

#[test]
fn the_generated_patient_has_its_known_facts() {
    let world = World::new();
    let (path, png) = (patient(&world), world.path("patient.png"));
    let (path, png) = (path.to_str().unwrap(), png.to_str().unwrap());
    let text = tool(&world, &["inspect", path, "--json", "--png", png]);
    let summary: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["dims"], serde_json::json!([60, 44, 60]));
    assert_eq!(summary["letters"], "LPS");
    assert_eq!(summary["handedness"], "right-handed");
    assert!(summary["tilt_degrees"].as_f64().unwrap() < 1e-9, "{text}");
    for axis in 0..3 {
        assert!((summary["spacing_mm"][axis].as_f64().unwrap() - 6.0).abs() < 1e-6);
    }
    assert_eq!(
        (&summary["hu"]["min"], &summary["voxels"]),
        (&(-1000).into(), &158_400.into())
    );
    assert_eq!(summary["warnings"], serde_json::json!([]));
    let texts = png_texts(Path::new(png));
    assert_eq!(texts["volume_hash"], summary["hash"].as_str().unwrap());
    let report = tool(&world, &["inspect", path]);
    for words in ["orientation    LPS: columns to left", "60 x 44 x 60 = 158400", "soft"] {
        assert!(report.contains(words), "{words}: {report}");
    }
}

#[test]
fn formats_that_cannot_be_are_refused_and_leave_nothing() {
    let world = World::new();
    let path = patient(&world);
    let path = path.to_str().unwrap();
    let target = |name: &str| world.path(name).to_str().unwrap().to_owned();
    refused(
        &world,
        &["export", path, &target("x.tif")],
        "x.tif: the ending .tif | .nii.gz",
    );
    let full = world.path("");
    let full = format!("dicom:{}", full.display());
    refused(&world, &["export", path, &full], "the folder is not empty");
    let slanted = noise(
        &world,
        "slanted.nii",
        [[-2.0, 0.5, 0.0, 0.0], [0.0, -2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]],
    );
    let slanted = slanted.to_str().unwrap();
    refused(
        &world,
        &["export", slanted, &target("s")],
        "rows and columns of the slices meet at",
    );
    refused(
        &world,
        &["inspect", &target("absent.nii")],
        "absent.nii: there is no such file",
    );
    assert_eq!(fs::read_dir(world.path("")).unwrap().count(), 2);
    // A copy is the same volume.
    tool(&world, &["export", path, &target("copy.nii")]);
    refused(
        &world,
        &["export", path, &target("copy.nii")],
        "copy.nii: there is a file of this name",
    );
    tool(&world, &["export", path, &target("copy.nii"), "--overwrite"]);
    let hash = |path: &str| {
        let summary: Value = serde_json::from_str(&tool(&world, &["inspect", path, "--json"])).unwrap();
        summary["hash"].as_str().unwrap().to_owned()
    };
    assert_eq!(hash(path), hash(&target("copy.nii")));
    // The voxels of another header stay, whatever may be replaced: a second export took the first one's for its own.
    tool(&world, &["export", path, &target("a.mhd")]);
    let before = hash(&target("a.mhd"));
    let other = target("a.nhdr");
    let words = ["export", path, &other, "--box-voxels", "0,0,0,9,9,9", "--overwrite"];
    for words in [&words[..5], &words] {
        refused(
            &world,
            words,
            "a.raw: there is a file of this name, which may hold the voxels of another header",
        );
    }
    assert_eq!(hash(&target("a.mhd")), before);
    tool(&world, &["export", path, &target("a.mhd"), "--overwrite"]);
}

/// What the script says of the series of `volume`.
fn checked(python: &Path, series: &Path, volume: &Path) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_dicom_export.py");
    let output = Command::new(python).args([&script, series, volume]).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{seen}");
    assert_eq!(seen["voxels_differ"], 0, "{seen}");
    assert_eq!(seen["named"], serde_json::json!([]), "{seen}");
    assert!(seen["corner_mm"].as_f64().unwrap() < 1e-6, "{seen}");
    for (tool, errors) in seen["validators"].as_object().unwrap() {
        assert_eq!(errors, &serde_json::json!([]), "{tool}");
    }
    seen
}

#[test]
fn other_software_reads_the_series_alike() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    let volume = patient(&world);
    for (name, more) in [
        ("plain", &[][..]),
        ("implicit", &["--syntax", "implicit-little"]),
        ("big", &["--syntax", "explicit-big"]),
        ("packed", &["--compress", "--shuffle-names", "7"]),
    ] {
        let series = world.path(name);
        let arguments = [&["export", volume.to_str().unwrap(), series.to_str().unwrap()], more].concat();
        tool(&world, &arguments);
        let seen = checked(&python, &series, &volume);
        assert_eq!((&seen["files"], &seen["tilt_degrees"]), (&60.into(), &Value::Null));
        for key in ["spacing_mm", "origin_mm", "direction"] {
            // NIfTI holds f32.
            assert!(seen[key].as_f64().unwrap() < 1e-5, "{key}: {seen}");
        }
    }
}

#[test]
fn tilted_and_mirrored_series_keep_every_place() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    // A gantry tilted by 18.5 degrees, in RAS; and slices that go down.
    let (s, c) = 18.5_f32.to_radians().sin_cos();
    let tilted = [
        [-2.0, 0.0, 0.0, 50.0],
        [0.0, -2.0 * c, 0.0, 60.0],
        [0.0, -2.0 * s, 2.5, 742.3],
    ];
    let mirrored = [[-2.0, 0.0, 0.0, 50.0], [0.0, -1.5, 0.0, 60.0], [0.0, 0.0, -2.5, 742.3]];
    for (name, rows, tilt) in [("tilted", tilted, Some(-18.5)), ("mirrored", mirrored, None)] {
        let (volume, series) = (noise(&world, &format!("{name}.nii"), rows), world.path(name));
        tool(&world, &["export", volume.to_str().unwrap(), series.to_str().unwrap()]);
        let seen = checked(&python, &series, &volume);
        match (seen["tilt_degrees"].as_f64(), tilt) {
            (None, None) => {}
            (Some(found), Some(tilt)) => assert!((found - tilt).abs() < 1e-4, "{seen}"),
            _ => panic!("{seen}"),
        }
    }
}

/// Runs a script of `tests/python`, which must succeed and print one JSON object.
pub(crate) fn script(python: &Path, name: &str, arguments: &[&str]) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(name);
    let output = Command::new(python).arg(&script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{name} {arguments:?}: {}", stderr(&output));
    let text = stdout(&output);
    println!("{name} {}: {}", arguments.first().unwrap_or(&""), text.trim());
    serde_json::from_str(text.lines().last().unwrap_or_default()).unwrap()
}

#[test]
fn other_software_reads_and_writes_nrrd_and_metaimage_alike() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    let folder = world.path("formats");
    fs::create_dir(&folder).unwrap();
    let loader = env!("CARGO_BIN_EXE_volume-loader");
    let seen = script(&python, "check_formats.py", &[loader, folder.to_str().unwrap()]);
    assert_eq!(seen["voxels_wrong"], 0, "{seen}");
    // Exact text for every double, and maps composed of a few of them.
    assert!(seen["world_mm"].as_f64().unwrap() < 1e-9, "{seen}");
    assert!(seen["files"].as_u64().unwrap() >= 400, "{seen}");
}

#[test]
fn real_examinations_have_the_hu_and_places_that_other_readers_find() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let world = World::new();
    // What is read, how by the others, and options of ours.
    let sets: [(&str, &str, &[&str], u64); 10] = [
        ("dicom", "ct-chest-lidc-dicom", &[], 23_592_960),
        ("dicom", "ct-head-phantom-tilt-dicom", &[], 14_155_776),
        ("dicom", "ct-lego-phantom-dicom", &["--regrid", "--unmarked"], 2_621_440),
        ("dicom", "dicom-bad-inputs/gantrytilting/001", &[], 1_048_576),
        (
            "dicom",
            "dicom-bad-inputs/sliceincrement/001",
            &["--regrid", "--unmarked"],
            1_048_576,
        ),
        ("dicom", "dicom-bad-inputs/compressed/compressed_rle", &[], 262_144),
        (
            "dicom",
            "dicom-bad-inputs/compressed/uncompressed_implicit",
            &[],
            262_144,
        ),
        ("nifti", "ct-abdopelvis-nifti/example_ct.nii.gz", &[], 1_380_064),
        ("sitk", "vol-small-nrrd-mha/TinyPatientCT.nrrd", &[], 1000),
        ("sitk", "vol-small-nrrd-mha/tooth.nhdr", &["--assume-lps"], 1_558_802),
    ];
    for (kind, set, options, voxels) in sets {
        let (input, output) = (data.join(set), world.path("ours.nrrd"));
        let (input, output) = (input.to_str().unwrap(), output.to_str().unwrap());
        tool(&world, &[&["export", input, output, "--overwrite"], options].concat());
        let seen = script(&python, "check_volumes.py", &[kind, input, output]);
        assert_eq!(
            (&seen["differ"], &seen["missing"]),
            (&0.into(), &0.into()),
            "{set}: {seen}"
        );
        assert_eq!(seen["voxels"], voxels, "{set}");
        assert!(seen["off_grid_mm"].as_f64().unwrap() < 1e-3, "{set}: {seen}");
    }
}

/// `volume-loader inspect --json`.
fn summary(world: &World, path: &Path) -> Value {
    serde_json::from_str(&tool(world, &["inspect", "--json", path.to_str().unwrap()])).unwrap()
}

#[test]
fn an_enhanced_ct_that_other_software_wrote_is_the_volume_of_its_classic_series() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let world = World::new();
    let (chest, tilted, packed) = (
        "ct-chest-lidc-dicom",
        "ct-head-phantom-tilt-dicom",
        "dicom-bad-inputs/compressed/compressed_",
    );
    // Folder, what follows its name, syntax, table of offsets, and the seed of the frames' order.
    let sets = [
        (chest, "", "explicit", "none", "0"),
        (chest, "", "implicit", "none", "7"),
        (tilted, "", "rle", "extended", "12"),
        (tilted, "", "big", "none", "3"),
        (packed, "rle", "same", "none", "0"),
        (packed, "jpeg", "same", "basic", "3"),
        (packed, "jpegls", "same", "extended", "2"),
        (packed, "j2k", "same", "basic", "1"),
    ];
    for (set, more, syntax, table, seed) in sets {
        let (input, file) = (data.join(format!("{set}{more}")), world.path("many.dcm"));
        let arguments = [input.to_str().unwrap(), file.to_str().unwrap(), syntax, table, seed];
        script(&python, "write_enhanced_ct.py", &arguments);
        let (want, found) = (summary(&world, &input), summary(&world, &file));
        for key in ["hash", "dims", "spacing_mm", "hu"] {
            assert_eq!(found[key], want[key], "{set}{more} {syntax} {table} {seed}: {key}");
        }
        fs::remove_file(file).unwrap();
    }
}

#[test]
fn an_enhanced_ct_has_the_hu_and_places_that_other_readers_find() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let world = World::new();
    let (file, output) = (world.path("many.dcm"), world.path("ours.nrrd"));
    let (file, output) = (file.to_str().unwrap(), output.to_str().unwrap());
    let check = |set: &str, seed: &str, reader: &str, voxels: u64| {
        let set = data.join(set);
        let arguments = [set.to_str().unwrap(), file, "explicit", "none", seed];
        script(&python, "write_enhanced_ct.py", &arguments);
        tool(&world, &["export", file, output, "--overwrite"]);
        let seen = script(&python, "check_volumes.py", &[reader, file, output]);
        assert_eq!((&seen["differ"], &seen["missing"]), (&0.into(), &0.into()), "{seen}");
        assert_eq!(seen["voxels"], voxels, "{seen}");
        assert!(seen["off_grid_mm"].as_f64().unwrap() < 1e-3, "{seen}");
    };
    check("ct-head-phantom-tilt-dicom", "5", "enhanced", 14_155_776);
    check("ct-chest-lidc-dicom", "9", "enhanced", 23_592_960);
    // GDCM takes frames in the order of the file.
    check("ct-chest-lidc-dicom", "0", "sitk", 23_592_960);
}

#[test]
fn doubtful_examinations_end_as_they_should() {
    let Some(data) = shared("data") else {
        return;
    };
    let world = World::new();
    let at = |set: &str| data.join(set).to_str().unwrap().to_owned();
    for (set, words) in [
        ("dicom-bad-inputs/notavolume/001", "not a volume: 4 slices at one place"),
        (
            "dicom-bad-inputs/slicecount/001",
            "too few slices: 2, expected at least 3",
        ),
        ("vol-small-nrrd-mha/tooth.nhdr", "no orientation | which side is left"),
    ] {
        refused(&world, &["inspect", &at(set)], words);
    }
    for (set, words) in [
        (
            "dicom-bad-inputs/sliceincrement/001",
            "expected 5.0000 mm, found 10.0000 mm, 1 missing",
        ),
        (
            "ct-lego-phantom-dicom",
            "expected 1.8750 mm, found 90.0000 mm, 47 missing",
        ),
    ] {
        let output = world.output("volume-loader", &["inspect", &at(set)]);
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
        let text = tool(&world, &["inspect", "--regrid", "--json", &at(set)]);
        // A file without the mark would be read as what the scanner measured, its holes as air.
        let lost = world.path("regridded.nii.gz");
        refused(
            &world,
            &["export", "--regrid", &at(set), lost.to_str().unwrap()],
            "say --unmarked",
        );
        assert!(!lost.exists());
        let summary: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(summary["marks"], "REGRIDDED", "{set}");
    }
    // One image in four compressions: one volume.
    let hash = |name: &str| {
        let text = tool(
            &world,
            &[
                "inspect",
                "--json",
                &at(&format!("dicom-bad-inputs/compressed/compressed_{name}")),
            ],
        );
        let summary: Value = serde_json::from_str(&text).unwrap();
        summary["hash"].as_str().unwrap().to_owned()
    };
    for name in ["j2k", "jpeg", "jpegls"] {
        assert_eq!(hash(name), hash("rle"), "{name}");
    }
    let tilted: Value =
        serde_json::from_str(&tool(&world, &["inspect", "--json", &at("ct-head-phantom-tilt-dicom")])).unwrap();
    assert!(
        (tilted["tilt_degrees"].as_f64().unwrap() - 18.5).abs() < 1e-4,
        "{tilted}"
    );
}

#[test]
fn a_part_of_an_examination_is_the_same_voxels_in_the_same_places() {
    let world = World::new();
    let path = patient(&world);
    let part = world.path("part.nrrd");
    let (path, part) = (path.to_str().unwrap(), part.to_str().unwrap());
    tool(&world, &["export", path, part, "--box-voxels", "10,11,12,40,33,52"]);
    let read = |arguments: &[&str]| -> Value {
        serde_json::from_str(&tool(&world, &[&["inspect", "--json"], arguments].concat())).unwrap()
    };
    let whole = read(&[path, "--box-voxels", "10,11,12,40,33,52"]);
    let again = read(&[part]);
    assert_eq!(
        (&whole["dims"], &whole["marks"]),
        (&serde_json::json!([30, 22, 40]), &"PART OF CT".into())
    );
    // NRRD keeps the affine to the bit: the same volume has the same name.
    assert_eq!((&whole["hash"], &again["marks"]), (&again["hash"], &"".into()));
    let half = read(&[path, "--downsample", "2,2,2"]);
    assert_eq!(
        (&half["dims"], &half["marks"]),
        (&serde_json::json!([30, 22, 30]), &"DOWNSAMPLED".into())
    );
    assert!(
        half["warnings"][0].as_str().unwrap().contains("HU (rms)"),
        "{}",
        half["warnings"]
    );
    refused(
        &world,
        &["inspect", path, "--box-mm", "9000,0,0,9001,1,1"],
        "nothing in common | check the region's axes",
    );
}

#[test]
fn bombs_end_at_once() {
    let world = World::new();
    let began = Instant::now();
    // 64 MiB of zeros in gzip, whose header promises a small volume; and headers that promise terabytes.
    let mut zeros = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut zeros, &Vec::<u8>::from(Nifti::noise())).unwrap();
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), 64 << 20), &mut zeros).unwrap();
    fs::write(world.path("bomb.nii.gz"), zeros.finish().unwrap()).unwrap();
    let space = "space: LPS\nspace origin: (0,0,0)\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n";
    let huge = format!(
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 16000 16000 16000\nendian: little\nencoding: raw\n{space}\n"
    );
    fs::write(world.path("huge.nrrd"), huge).unwrap();
    let huge = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n\
                Offset = 0 0 0\nElementSpacing = 1 1 1\nDimSize = 900 900 900\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    fs::write(world.path("huge.mha"), huge).unwrap();
    for name in ["bomb.nii.gz", "huge.nrrd", "huge.mha"] {
        let output = world.output("volume-loader", &["inspect", world.path(name).to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(1), "{name}: {}", stdout(&output));
        println!("{name}: {}", stderr(&output).trim());
    }
    // They end in milliseconds; what is asserted is that nothing went through gigabytes.
    assert!(began.elapsed().as_secs() < 60);
}

/// They stood in the line of the format alone: a person who looks at warnings saw none.
#[test]
fn what_is_doubtful_about_a_text_header_is_among_the_warnings() {
    let world = World::new();
    let head = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n\
                Offset = 0 0 0\nElementSpacing = 1 1 1\nDistanceUnits = cm\nModality = MET_MOD_MR\nDimSize = 2 3 2\nElementType = MET_SHORT\n\
                ElementDataFile = LOCAL\n";
    let bytes = [head.as_bytes(), &[0; 24 + 5]].concat();
    fs::write(world.path("mr.mha"), bytes).unwrap();
    let path = world.path("mr.mha");
    let text = tool(&world, &["inspect", "--json", path.to_str().unwrap()]);
    let summary: Value = serde_json::from_str(&text).unwrap();
    let warnings = summary["warnings"].to_string();
    for words in [
        "lengths converted from cm",
        "not a CT (MR, by Modality)",
        "and 5 more follow",
    ] {
        assert!(warnings.contains(words), "{words}: {warnings}");
    }
    let folder = world.path("as-ct");
    refused(
        &world,
        &["export", path.to_str().unwrap(), folder.to_str().unwrap()],
        "not a CT but of the modality MR | say --unmarked",
    );
    assert!(!folder.exists());
    assert_eq!(
        summary["modality"].as_str().or(summary["extra"]["modality"].as_str()),
        Some("MR"),
        "{text}"
    );
}
