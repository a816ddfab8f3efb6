//! Bad input of every kind: one paragraph that names it, no exit code 0, nothing left behind, and the next run is clean.

#![allow(clippy::print_stdout, reason = "a test that is skipped says why")]
#![allow(clippy::disallowed_methods, reason = "one test mounts its own shared memory")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::nifti::{Nifti, VOXELS};
use crate::support::room::Room;
use crate::support::*;
use bus::run::{SHM_DIR, shm_free_bytes};
use serde_json::Value;

/// Name, content, and what the error must say beside the name, between bars.
type Case = (&'static str, Vec<u8>, &'static str);

macro_rules! table {
    ($($name:literal: $content:expr => $words:literal;)*) => { vec![$(($name, Vec::from($content), $words)),*] };
}

fn broken_files() -> Vec<Case> {
    let (noise, packed) = (Nifti::noise(), Nifti::noise().gzip());
    let text = "What is this? Not a volume. ".repeat(20);
    let bomb = noise.clone().with(vec![0; 1 << 20]).gzip();
    let mut flipped = packed.clone();
    flipped[1000..1008].iter_mut().for_each(|byte| *byte = !*byte);
    table! {
        "empty.nii": "" => "empty | 0 bytes | copy it again";
        "text.nii": text => "not a NIfTI file | 348 or 540";
        "short.nii": &noise.0[..200] => "ends in the header | at least 348 | found 200";
        "cut.nii": &noise.0[..1136] => "ends in slice 3 | at least 2272 bytes | found 1136 | copy it again";
        "cut.nii.gz": &packed[..packed.len() / 2] => "breaks off in slice | at least 2272 | copy it again";
        "flipped.nii.gz": flipped => "compressed stream is damaged | copy it again";
        "promise.nii.gz": Nifti::header().dims([256, 256, 200]).gzip() => "ends in slice 0 | 26214752 | found 352";
        "bomb.nii.gz": bomb => "voxels end at byte 2272 | dimensions or datatype are wrong";
    }
}

fn bad_headers() -> Vec<Case> {
    let h = Nifti::noise;
    let by_qform = || h().i16(254, 0).i16(252, 1);
    table! {
        "flat.nii": h().dims([12, 0, 8]) => "dimension 1 is 0 | 1 to 16384";
        "negative.nii": h().dims([-12, 10, 8]) => "dimension 0 is -12 | 1 to 16384";
        "long.nii": h().dims([12, 10, 32767]) => "dimension 2 is 32767 | 1 to 16384";
        "vast.nii": h().dims([16384; 3]) => "4398046511104 voxels | at most 4294967295";
        "two.nii": h().i16(40, 4).i16(48, 2) => "dim is [4, 12, 10, 8, 2 | expected one volume";
        "rgb.nii": h().i16(70, 128).i16(72, 24) => "datatype 128 | expected an integer";
        "nowhere.nii": h().i16(254, 0) => "no orientation | which side is left";
        "point.nii": h().f32(300, 0.0) => "spacing along axis 1 is 0 mm | 0.001 to 100 mm";
        "metres.nii": h().f32(280, 2e4).f32(80, 2e4) => "spacing along axis 0 is 20000 mm | 0.001 to 100 mm";
        "two-steps.nii": h().f32(88, 5.0) => "the sform steps by 20 along axis k of the voxels and pixdim says 5";
        "nan.nii": h().f32(320, f32::NAN) => "NaN or an infinity";
        "infinite.nii": h().f32(292, f32::INFINITY) => "NaN or an infinity";
        "sheet.nii": h().f32(284, 20.0).f32(300, 0.0) => "nearly in one plane | 0.17";
        "scale.nii": h().f32(112, f32::NAN) => "scl_slope is NaN";
        "q-zero.nii": by_qform().f32(80, 0.0) => "spacing along axis 0 is 0 mm";
        "q-nan.nii": by_qform().f32(84, f32::NAN) => "NaN or an infinity";
        "q-huge.nii": by_qform().f32(88, 1e9) => "spacing along axis 2 is 1000000000 mm";
        // Mirroring the patient would be a guess: some readers refuse this, others take it for 1.
        "q-mirror.nii": by_qform().f32(80, -20.0) => "spacing along axis 0 is -20 mm";
        "q-turn.nii": by_qform().f32(256, 1.5) => "quaternion | norm 1.5";
    }
}

const VIEW: &str = "[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"";

fn bad_scenes() -> Vec<Case> {
    table! {
        "key.toml": "[tracker]\nrate_herz = 5" => "line 2, column 1, | key tracker.rate_herz | expected one of";
        "type.toml": "seed = \"x\"" => "line 1, column 8, | key seed | string \"x\", expected u64";
        "rate.toml": "[tracker]\nrate_hz = -5" => "line 2, column 11, | key tracker.rate_hz | found -5 | 1 to 4000 Hz";
        "nan.toml": "[limits]\nstale_ms = nan" => "line 2, column 12, | key limits.stale_ms | found NaN | 1 to 10000 ms";
        "twice.toml": format!("{VIEW}\n{VIEW}") => "line 6, column 8, | key views.1.name | \"a\" a second time";
        "escape.toml": VIEW.replace("\"a\"", "\"../a\"") => "line 2, column 8, | key views.0.name | characters a-z";
        "filter.toml": format!("{VIEW}\nfilter = \"lanczos\"") => "line 5, | key views.0.filter | `lanczos` | `b-spline`";
        "slab.toml": format!("{VIEW}\nslab = {{ mode = \"mean\", thickness_mm = 0 }}") => "key views.0.slab.thickness_mm | found 0 | 0.01 to 500 mm";
        "ahead.toml": format!("{VIEW}\nahead_mm = 5") => "key views.0.ahead_mm | found 5 | perpendicular";
        "render.toml": format!("[render]\nback_end = \"cuda\"\n{VIEW}") => "key render.back_end | `cuda` | `gpu`";
        "plane.toml": VIEW.replace("axial", "coronal") => "line 3, column 9, | key views.0.plane | `coronal` | `frontal`";
        "open.toml": "seed = 1\n[[views]\nname = 2" => "line 2, column 9: | unclosed | expected `]`";
        "double.toml": "seed = 1\nseed = 2" => "line 2, column 1 | duplicate key";
        "latin.toml": b"seed = 1 # \xe9".to_vec() => "reading scene | UTF-8";
        "long.toml": "# comment\n".repeat(200_000) => "2000000 bytes | at most 1048576";
    }
}

fn volumes_are_refused(cases: Vec<Case>) {
    let room = Room::new();
    for (name, bytes, words) in cases {
        fs::write(room.path(name), bytes).unwrap();
        room.run_is_refused(&room.scene_on(name), &[], &format!("{name} | {words}"));
    }
    room.good_run(&[]);
}

#[test]
fn broken_files_are_refused() {
    volumes_are_refused(broken_files());
}

#[test]
fn bad_headers_are_refused() {
    volumes_are_refused(bad_headers());
}

#[test]
fn bad_scenes_are_refused() {
    let room = Room::new();
    for (name, text, words) in bad_scenes() {
        fs::write(room.path(name), text).unwrap();
        room.run_is_refused(&room.path(name), &[], &format!("{name} | {words}"));
    }
    let absent = room.path("absent.toml");
    room.run_is_refused(&absent, &[], "reading scene | absent.toml | No such file");
    assert!(!room.out.exists());
    room.good_run(&[]);
}

#[test]
fn what_is_no_file_is_refused_at_once_wherever_a_path_is_read() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let room = Room::new();
    let pipe = room.path("pipe");
    mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    for (path, words) in [
        (pipe.as_path(), "this is a pipe, expected a file"),
        (Path::new("/dev/zero"), "this is a device, expected a file"),
    ] {
        let named = path.to_str().unwrap();
        let all = format!("reading scene {named} | {words}");
        room.run_is_refused(path, &[], &all);
        room.is_refused(&room.output("pilot", &["check", named]), &all);
        room.is_refused(&room.output("volume-loader", &["inspect", named]), words);
        room.run_is_refused(&room.good, &["--volume", named], words);
        room.is_refused(&room.output("recorder", &["verify", named]), words);
        room.is_refused(&room.output("recorder", &["info", named]), words);
        room.is_refused(&room.output("simulate", &["check", named]), words);
    }
    room.good_run(&[]);
}

#[test]
fn paths_that_are_no_file_are_refused() {
    let room = Room::new();
    let absent = room.scene_on("absent.nii");
    room.run_is_refused(&absent, &[], "/absent.nii: there is no such file | check the name");
    let empty = room.path("empty");
    fs::create_dir(&empty).unwrap();
    for (volume, words) in [
        ("absent.nii", "--volume absent.nii | no such file | give the path"),
        (
            empty.to_str().unwrap(),
            "/empty: no DICOM image in this folder (0 other files)",
        ),
        ("/dev/null", "/dev/null: this is a device, expected a file"),
    ] {
        room.run_is_refused(&room.good, &["--volume", volume], words);
    }
    room.good_run(&[]);
}

/// Slices of 4096 x 4096 voxels that need more than `free` bytes; `None` where that is more than a volume may have.
fn slices_beyond(free: u64) -> Option<i16> {
    let slices = i16::try_from(free / (2 << 24) + 1).ok()?;
    (slices < 256).then_some(slices)
}

/// Runs the pilot with 48 MiB of shared memory of its own; `None`, with a printed reason, where that is not allowed.
fn in_small_shared_memory(room: &Room, scene: &Path) -> Option<Output> {
    let mount = format!("mount -t tmpfs -o size=48m tmpfs {SHM_DIR}");
    let inside = |script: &str| {
        let mut command = Command::new("timeout");
        command.args(["--signal=KILL", &WATCHDOG.as_secs().to_string()]);
        command.args(["unshare", "--map-root-user", "--mount", "sh", "-c", script]);
        command.env("TROCAR_RUNTIME_DIR", room.path("r"));
        command.output()
    };
    if !inside(&mount).is_ok_and(|output| output.status.success()) {
        println!("skipped: no volume is larger than {SHM_DIR}, and this user may not mount a smaller one");
        return None;
    }
    let pilot = env!("CARGO_BIN_EXE_pilot");
    let (scene, out) = (scene.display(), room.out.display());
    Some(inside(&format!("{mount} && exec {pilot} run {scene} --for 500ms --out {out}")).unwrap())
}

#[test]
fn volumes_larger_than_memory_are_refused() {
    let room = Room::new();
    let scene = room.scene_on("large.nii.gz");
    let write = |slices| {
        // Voxels of 1 mm: of 20 mm they would lie where no patient is.
        let header = Nifti::header().dims([4096, 4096, slices]);
        let header = (0..3).fold(header, |header, axis| {
            header.f32(80 + 4 * axis, 1.0).f32(280 + 20 * axis, 1.0)
        });
        fs::write(room.path("large.nii.gz"), header.gzip()).unwrap();
    };
    write(256);
    room.run_is_refused(&scene, &[], "large.nii.gz | 4294967296 voxels | at most 4294967295");
    let words = "large.nii.gz | MiB of shared memory | /dev/shm | MiB free | mount -o remount,size= | --shm-size";
    if let Some(slices) = slices_beyond(shm_free_bytes().unwrap()) {
        write(slices);
        return room.run_is_refused(&scene, &[], words);
    }
    // 128 MiB of voxels and 64 MiB for images.
    write(4);
    if let Some(output) = in_small_shared_memory(&room, &scene) {
        room.is_refused(&output, &format!("{words} | needs 192 MiB"));
    }
}

#[test]
fn hu_outside_16_bits_are_held_and_counted() {
    let room = Room::new();
    let mut hu = vec![0.0_f32; VOXELS];
    hu[..6].copy_from_slice(&[f32::NAN, 1e9, -40_000.0, f32::INFINITY, 32_768.0, f32::NEG_INFINITY]);
    let floats = Nifti::header().i16(70, 16).i16(72, 32);
    let floats = floats.with(hu.iter().flat_map(|v| v.to_le_bytes()));
    fs::write(room.path("float.nii"), floats.0).unwrap();
    let output = room.run(&room.scene_on("float.nii"), &[]);
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    for words in ["1 voxels below and 2 above", "were clamped, 3 that were not numbers"] {
        assert!(said.contains(words), "{said}");
    }
    // RAS voxel i lies at x = -20 i mm, so the image shows the first six from right to left.
    let (volume, row) = (room.path("float.nii"), room.path("row.mha"));
    let files = ["--volume", volume.to_str().unwrap(), "--hu", row.to_str().unwrap()];
    let plane = [
        "--view=axial",
        "--pose=1,0,0,0,-50,0,0",
        "--size=6x1",
        "--pixel-mm=20",
        "--minify=point",
    ];
    let all = [&["snapshot", "--filter=nearest"], &plane[..], &files].concat();
    assert!(room.output("slice-view-proc", &all).status.success());
    let bytes = fs::read(row).unwrap();
    let (found, _) = bytes[bytes.len() - 24..].as_chunks();
    let found: Vec<_> = found.iter().map(|raw| f32::from_le_bytes(*raw)).collect();
    assert_eq!(found, [-1024.0, 32_767.0, -1024.0, -32_768.0, 32_767.0, -1024.0]);
}

#[test]
fn folders_that_cannot_be_written_are_refused() {
    let mut room = Room::new();
    let file = room.file("file", "mine");
    for out in [Path::new("/proc/trocar"), &file, &file.join("below")] {
        room.out = out.to_owned();
        let words = format!("output folder {} | --out DIR", out.display());
        let output = room.run(&room.good, &[]);
        room.out = room.path("elsewhere");
        room.is_refused(&output, &words);
    }
    assert_eq!(fs::read_to_string(file).unwrap(), "mine");
    room.good_run(&[]);
}

#[test]
fn a_recorded_session_is_not_replaced_unasked() {
    let mut room = Room::new();
    room.good_run(&[]);
    let out = room.out.clone();
    let content = || -> BTreeMap<_, _> {
        let files = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
        files.map(|path| (path.clone(), fs::read(path).unwrap())).collect()
    };
    let before = content();
    let output = room.run(&room.good, &[]);
    assert!(before == content(), "the old session was touched");
    room.out = room.path("elsewhere");
    room.is_refused(
        &output,
        "holds a recorded session (session.mcap) | --out DIR | --overwrite",
    );
    room.out = out.clone();
    room.good_run(&["--overwrite"]);
    assert!(before != content(), "the new session is the old one");
}

#[test]
fn a_name_belongs_to_one_pilot() {
    let room = Room::new();
    let first = room.start(&room.good, &room.path("first"), "default");
    let seq = |status: &Value| status["pose"]["seq"].as_u64().unwrap();
    let before = seq(&first.wait_live());
    // The pilot, its six processes, and the volume at least: what the other tests look for can be found.
    assert!(room.left().len() > 7, "{:?}", room.left());
    let output = room.run(&room.good, &[]);
    let said = stderr(&output);
    assert!(!output.status.success() && !room.out.exists(), "{said}");
    let pid = format!("\"default\" is already going (pilot process {})", first.child.id());
    for word in [&pid, "`pilot stop --run default`", "`--run NAME`"] {
        assert!(said.contains(word), "{word}: {said}");
    }
    first.wait_for("the first to go on", |status| all_live(status) && seq(status) > before);
    assert!(first.stop().success());
    assert_eq!(report(&room.path("first"))["restarts"], serde_json::json!([]));
    room.nothing_is_left();
}

#[test]
fn what_is_typed_wrong_is_refused() {
    let room = Room::new();
    for time in ["10", "-1s", "nans", "1e9s", "0s", "3 weeks", ""] {
        let (time_text, out) = (format!("--for={time}"), room.out.to_str().unwrap());
        let output = room.output("pilot", &["run", &time_text, "--out", out]);
        room.is_refused(&output, &format!("--for <TIME> | '{time}'"));
    }
    for name in ["", "..", "a/b", "A", "a b", &"x".repeat(25)] {
        let words = format!("run name {name:?} | 1 to 24 of the characters a-z, 0-9 and '-'");
        room.run_is_refused(&room.good, &["--run", name], &words);
    }
    for verb in ["status", "stop"] {
        let output = room.output("pilot", &[verb, "--run", "idle"]);
        room.is_refused(&output, "run \"idle\" is not going | `pilot run SCENE --run idle`");
    }
    assert!(!room.out.exists());
}

#[test]
fn snapshots_are_refused_whole() {
    let room = Room::new();
    fs::create_dir(&room.out).unwrap();
    let file = |option: &str, name: &str| format!("--{option}={}", room.out.join(name).display());
    let empty = format!("--volume={}", room.out.display());
    let given = ["snapshot", "--view=axial", "--volume=phantom", "--pose=1,0,0,0,0,0,0"].map(str::to_owned);
    let given = [&given[..], &[file("out", "x.png"), file("hu", "x.mha")]].concat();
    for (bad, words) in [
        ("--pose=nan,0,0,0,0,0,0", "--pose | finite | NaN"),
        ("--pose=1,0,0,0,0,inf,0", "--pose | finite | inf"),
        ("--pose=1,1,0,0,0,0,0", "--pose | norm 1 within | 1.414"),
        ("--pose=0,0,0,0,0,0,0", "--pose | norm 0"),
        ("--pose=1,0,0,0,0,0", "--pose | 6 numbers; 7 are needed"),
        ("--pose=1,0,0,0,0,0,x", "--pose | \"x\""),
        ("--size=0x5", "'0x5' | 1 to 8192"),
        ("--size=9000x5", "'9000x5' | 1 to 8192"),
        ("--pixel-mm=nan", "--pixel-mm | NaN | 0.000001 to 1000 mm"),
        ("--pixel-mm=0", "--pixel-mm | 0 mm | 0.000001 to 1000 mm"),
        ("--pixel-mm=-1", "--pixel-mm | 0.000001 to 1000 mm"),
        ("--filter=lanczos", "'lanczos' | --filter"),
        ("--slab-mm=nan", "--slab-mm | NaN | 0.01 to 500 mm"),
        ("--slab-mm=0", "--slab-mm | 0 mm | 0.01 to 500 mm"),
        ("--ahead-mm=inf", "--ahead-mm | inf | finite"),
        ("--volume=absent.nii", "absent.nii | no such file"),
        (&empty, "no DICOM image in this folder"),
        ("--out=/proc/x.png", "writing /proc/x.png | folder exists"),
        ("--hu=/proc/x.mha", "writing /proc/x.mha | No such file"),
    ] {
        // What is bad takes the place of what was good; a file that cannot be written is the only one.
        let files = bad.contains("/proc/");
        let option = bad.split('=').next().unwrap();
        let is_out = |given: &str| files && given.contains(room.out.to_str().unwrap());
        let mut all: Vec<&str> = given.iter().map(String::as_str).collect();
        all.retain(|given| !given.starts_with(option) && !is_out(given));
        all.push(bad);
        room.is_refused(&room.output("slice-view-proc", &all), words);
    }
}
