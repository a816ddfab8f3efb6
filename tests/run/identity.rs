//! Whose examination it is: on the bus for the operator's screen, and in no file unless the scene asks for it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{Pilot, SMALL, World, stderr, wait_for};
use bus::Bus;
use bus::message::{Identity, IdentitySource};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::IDENTITY;

/// Words that are nowhere but in an identity.
const SECRETS: [&str; 4] = ["QXJ7^SECRET", "QXJ7-0042", "1952-02-29", "19520229"];

fn contains(bytes: &[u8], words: &str) -> bool {
    bytes.windows(words.len()).any(|window| window == words.as_bytes())
}

/// What a guest that joins late is told.
fn on_bus(world: &World) -> Identity {
    let context = RunContext::load(&world.run_dir("default")).unwrap();
    let bus = Bus::join(&context).unwrap();
    let identities = Subscriber::<Identity>::open(&bus, &IDENTITY, "", 1).unwrap();
    wait_for("the identity", || identities.newest().unwrap())
}

/// Runs the scene until it is live; gives what is on the bus, and all that was written and said.
fn ran(world: &World, scene: &str, name: &str) -> (Identity, Vec<(PathBuf, Vec<u8>)>) {
    let (out, log) = (world.path(name), world.path(&format!("{name}.log")));
    let child = world
        .command("pilot")
        .args(["run", "--headless", "--out"])
        .arg(&out)
        .arg(world.file(&format!("{name}.toml"), scene))
        .stdout(fs::File::create(&log).unwrap())
        .stderr(fs::File::options().append(true).open(&log).unwrap())
        .spawn()
        .unwrap();
    let pilot = Pilot::of(world, "default", child);
    pilot.wait_live();
    let identity = on_bus(world);
    let status = pilot.status().unwrap().to_string();
    pilot.stop();
    let entries = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .chain([log])
        .map(|path| (path.clone(), fs::read(path).unwrap()))
        .collect();
    files.push((PathBuf::from("status"), status.into_bytes()));
    assert!(files.iter().any(|(path, _)| path.ends_with("session.mcap")));
    assert!(files.iter().any(|(path, _)| path.ends_with("report.json")));
    (identity, files)
}

/// The files in which a word of the identity stands.
fn named_in(files: &[(PathBuf, Vec<u8>)]) -> Vec<&Path> {
    let names = |bytes: &[u8]| SECRETS.iter().any(|secret| contains(bytes, secret));
    files
        .iter()
        .filter(|(_, bytes)| names(bytes))
        .map(|(path, _)| path.as_path())
        .collect()
}

/// A small DICOM series whose files name a patient.
fn series(world: &World) -> PathBuf {
    let (nifti, folder) = (world.path("p.nii"), world.path("series"));
    for arguments in [
        ["phantom", "--spacing-mm", "12", "--out", nifti.to_str().unwrap()].as_slice(),
        &["export", nifti.to_str().unwrap(), folder.to_str().unwrap()],
    ] {
        let output = world.output("volume-loader", arguments);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let mut bytes = fs::read(&path).unwrap();
        for (tag, vr, words) in [
            ([0x10, 0, 0x10, 0], b"PN", "QXJ7^SECRET "),
            ([0x10, 0, 0x20, 0], b"LO", "QXJ7-0042 "),
            ([0x10, 0, 0x30, 0], b"DA", "19520229"),
        ] {
            let empty = [&tag[..], vr, &[0, 0]].concat();
            let at = bytes.windows(8).position(|window| window == empty);
            let at = at.unwrap_or_else(|| panic!("no empty {tag:?} in {}", path.display()));
            bytes[at + 6] = words.len() as u8;
            bytes.splice(at + 8..at + 8, words.bytes());
        }
        fs::write(&path, bytes).unwrap();
    }
    folder
}

fn scene_of(volume: &str, recording: &str) -> String {
    let recording = format!("[recording]\ncompression = \"none\"\nthumbnails_per_s = 5.0\n{recording}");
    SMALL
        .replace("source = \"phantom\"\nspacing_mm = 6.0", volume)
        .replace("[recording]", &recording)
}

#[test]
fn a_dicom_patient_is_on_the_bus_and_in_no_file_unless_asked() {
    let world = World::new();
    let volume = format!("source = \"{}\"", series(&world).display());
    let (identity, files) = ran(&world, &scene_of(&volume, ""), "unasked");
    assert_eq!(identity.source(), IdentitySource::Examination);
    assert_eq!(identity.words()[..3], ["QXJ7^SECRET", "QXJ7-0042", "1952-02-29"]);
    assert_eq!(named_in(&files), Vec::<&Path>::new());
    let (again, files) = ran(&world, &scene_of(&volume, "identity = true"), "asked");
    assert_eq!(again, identity);
    let recording = world.path("asked").join("session.mcap");
    assert_eq!(named_in(&files), [recording.as_path()]);
}

#[test]
fn a_scenes_words_stay_out_of_its_recording_too_and_a_generated_patient_says_phantom() {
    let world = World::new();
    let phantom = "source = \"phantom\"\nspacing_mm = 6.0";
    let (identity, files) = ran(&world, &scene_of(phantom, ""), "phantom");
    assert_eq!(identity.source(), IdentitySource::Phantom);
    assert_eq!(identity.words(), ["PHANTOM", "", "", "", ""]);
    assert_eq!(named_in(&files), Vec::<&Path>::new());
    let table = format!("{phantom}\n[identity]\nname = \"QXJ7^SECRET\"\nbirth_date = \"1952-02-29\"");
    let (identity, files) = ran(&world, &scene_of(&table, ""), "unasked");
    assert_eq!(identity.source(), IdentitySource::Phantom);
    assert_eq!(identity.words()[..3], ["QXJ7^SECRET", "", "1952-02-29"]);
    assert_eq!(named_in(&files), Vec::<&Path>::new());
    let (_, files) = ran(&world, &scene_of(&table, "identity = true"), "asked");
    let recording = world.path("asked").join("session.mcap");
    assert_eq!(named_in(&files), [recording.as_path()]);
}
