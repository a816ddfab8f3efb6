//! `volume-loader receive` with senders of others (pynetdicom), and with bytes that no sender should send.

#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};

use crate::support::*;
use serde_json::{Value, json};

/// `volume-loader receive`, ended with the test.
struct Receiver {
    child: Child,
    lines: Arc<Mutex<Vec<String>>>,
    port: u16,
}

impl Receiver {
    fn start(world: &World, more: &[&str]) -> Self {
        let out = world.path("in");
        let arguments = ["receive", "--out", out.to_str().unwrap(), "--listen", "127.0.0.1:0"];
        let mut command = world.command("volume-loader");
        command.args(arguments).args(["--min-free-mib", "0"]).args(more);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let lines = Arc::new(Mutex::new(Vec::new()));
        let pipes: [Box<dyn Read + Send>; 2] = [
            Box::new(child.stdout.take().unwrap()),
            Box::new(child.stderr.take().unwrap()),
        ];
        for pipe in pipes {
            let lines = lines.clone();
            std::thread::spawn(move || {
                for line in BufReader::new(pipe).lines().map_while(Result::ok) {
                    lines.lock().unwrap().push(line);
                }
            });
        }
        let mut receiver = Self { child, lines, port: 0 };
        let line = receiver.wait("listening on 127.0.0.1:");
        let port = line.split("127.0.0.1:").nth(1).unwrap().split(' ').next().unwrap();
        receiver.port = port.parse().unwrap();
        receiver
    }

    /// The first line that has these words.
    fn wait(&self, words: &str) -> String {
        wait_for(words, || {
            let lines = self.lines.lock().unwrap();
            lines.iter().find(|line| line.contains(words)).cloned()
        })
    }

    fn text(&self) -> String {
        self.lines.lock().unwrap().join("\n")
    }

    fn end(&mut self) -> ExitStatus {
        wait_for("the receiver's end", || self.child.try_wait().unwrap())
    }

    fn interrupt(&mut self) -> ExitStatus {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        self.end()
    }

    /// A connection without any sender behind it.
    fn raw(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(WATCHDOG)).unwrap();
        stream
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn peer_command(python: &Path, port: &str, titles: [&str; 2], work: &[&str]) -> Command {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/dicom_peer.py");
    let mut command = Command::new(python);
    command.arg(script).arg(port).args(titles).args(work);
    command
}

/// Lets a sender work, and gives what it says.
fn peer(python: &Path, receiver: &Receiver, titles: [&str; 2], work: &[&str]) -> Value {
    let output = peer_command(python, &receiver.port.to_string(), titles, work)
        .output()
        .unwrap();
    assert!(output.status.success(), "{work:?}: {}", stderr(&output));
    serde_json::from_str(stdout(&output).lines().last().unwrap()).unwrap()
}

const TITLES: [&str; 2] = ["TROCAR", "PACS"];

/// A generated series of 60 slices.
fn series(world: &World) -> PathBuf {
    let (volume, series) = (world.path("patient.nii"), world.path("series"));
    let arguments = ["phantom", "--spacing-mm", "6", "--out", volume.to_str().unwrap()];
    assert!(world.output("volume-loader", &arguments).status.success());
    let arguments = ["export", volume.to_str().unwrap(), series.to_str().unwrap()];
    assert!(world.output("volume-loader", &arguments).status.success());
    series
}

fn hash(world: &World, path: &Path) -> String {
    let output = world.output("volume-loader", &["inspect", "--json", path.to_str().unwrap()]);
    assert!(output.status.success(), "{}", stderr(&output));
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    summary["hash"].as_str().unwrap().to_owned()
}

/// Folders of series, hidden ones too.
fn kept(world: &World) -> Vec<PathBuf> {
    let studies = fs::read_dir(world.path("in"))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut all: Vec<_> = studies
        .filter(|path| path.is_dir())
        .flat_map(|study| fs::read_dir(study).unwrap().map(|entry| entry.unwrap().path()))
        .collect();
    all.sort();
    all
}

fn count(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

fn is_hidden(folder: &Path) -> bool {
    let name = folder.file_name().unwrap().to_str().unwrap();
    name.starts_with('.') && name.ends_with(".incomplete")
}

#[test]
fn a_series_that_other_software_stores_is_the_volume_it_was() {
    let Some(python) = python() else { return };
    let world = World::new();
    let series = series(&world);
    let folder = series.to_str().unwrap();
    let mut receiver = Receiver::start(&world, &["--once", "--from", "PACS"]);
    // Verification alone is not what it waits for.
    let said = peer(&python, &receiver, TITLES, &["echo"]);
    assert_eq!(said["statuses"], json!(["0000"]), "{said}");
    let said = peer(&python, &receiver, TITLES, &["store", folder]);
    assert_eq!(said["statuses"], json!(vec!["0000"; 60]), "{said}");
    assert!(receiver.end().success(), "{}", receiver.text());
    let told = receiver.text();
    for words in [
        "60 instances are new",
        "60 x 44 x 60",
        "it can be loaded",
        "\"PACS\" ended in order",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let [kept] = kept(&world).try_into().unwrap();
    assert!(!is_hidden(&kept) && count(&kept) == 60);
    assert_eq!(hash(&world, &kept), hash(&world, &series));
    let output = peer_command(&python, "0", [kept.to_str().unwrap(), "-"], &["compare", folder]).output();
    let seen: Value = serde_json::from_slice(&output.unwrap().stdout).unwrap();
    assert_eq!(seen, json!({"sent": 60, "kept": 60, "same": 60, "meta": true}));
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode(&kept), mode(kept.parent().unwrap())), (0o700, 0o700));
    let file = fs::read_dir(&kept).unwrap().next().unwrap().unwrap().path();
    assert_eq!(mode(&file), 0o600);
    // Again: it is all there. With another voxel under the same name: refused, and what is there stays.
    let mut receiver = Receiver::start(&world, &["--once"]);
    let said = peer(&python, &receiver, TITLES, &["store", folder]);
    assert_eq!(said["statuses"], json!(vec!["0000"; 60]), "{said}");
    assert!(
        receiver.end().success() && receiver.text().contains("60 were there already"),
        "{}",
        receiver.text()
    );
    let mut receiver = Receiver::start(&world, &["--once"]);
    let said = peer(&python, &receiver, TITLES, &["change", folder]);
    assert_eq!(said["statuses"], json!(["c001"]), "{said}");
    assert_eq!(receiver.end().code(), Some(1));
    assert!(
        receiver.text().contains("with other content, and is kept"),
        "{}",
        receiver.text()
    );
    assert_eq!(hash(&world, &kept), hash(&world, &series));
}

#[test]
fn what_broke_off_is_incomplete_until_it_is_sent_again() {
    let Some(python) = python() else { return };
    let world = World::new();
    let series = series(&world);
    let folder = series.to_str().unwrap();
    for work in ["abort", "vanish"] {
        let mut receiver = Receiver::start(&world, &["--once"]);
        peer(&python, &receiver, TITLES, &[work, folder, "20"]);
        assert_eq!(receiver.end().code(), Some(1));
        let told = receiver.text();
        assert!(
            told.contains("INCOMPLETE: the association was broken off") && !told.contains("can be loaded,"),
            "{told}"
        );
        let [kept] = kept(&world).try_into().unwrap();
        assert!(is_hidden(&kept) && count(&kept) == 20);
    }
    // Nobody finds it by the folder above.
    let output = world.output("volume-loader", &["inspect", world.path("in").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    // Ctrl-C in the middle of an association.
    let mut receiver = Receiver::start(&world, &[]);
    let port = receiver.port.to_string();
    let mut command = peer_command(&python, &port, TITLES, &["hold", folder, "40"]);
    let mut sender = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(sender.stdout.as_mut().unwrap())
        .read_line(&mut first)
        .unwrap();
    assert_eq!(first.trim(), "holding");
    // Who comes meanwhile is told to come later (rejected-transient, of the presentation service, temporary congestion).
    let said = peer(&python, &receiver, TITLES, &["echo"]);
    assert_eq!(said["rejected"], json!([2, 3, 1]), "{said}");
    assert_eq!(receiver.interrupt().code(), Some(1), "{}", receiver.text());
    assert!(receiver.text().contains("stopped in the middle of an association"));
    drop(sender.stdin.take());
    sender.wait().unwrap();
    let [kept_now] = kept(&world).try_into().unwrap();
    assert!(is_hidden(&kept_now) && count(&kept_now) == 40);
    // One slice more, in order, makes no series of a piece.
    let one = world.path("one");
    fs::create_dir(&one).unwrap();
    fs::copy(series.join("IM0050.dcm"), one.join("a.dcm")).unwrap();
    let mut receiver = Receiver::start(&world, &["--once"]);
    peer(&python, &receiver, TITLES, &["store", one.to_str().unwrap()]);
    assert_eq!(receiver.end().code(), Some(1));
    receiver.wait("of the 41 instances that are there now this association brought 1");
    let mut receiver = Receiver::start(&world, &["--once"]);
    peer(&python, &receiver, TITLES, &["store", folder]);
    assert!(receiver.end().success(), "{}", receiver.text());
    assert!(receiver.text().contains("19 instances are new, 41 were there already"));
    let [kept] = kept(&world).try_into().unwrap();
    assert!(!is_hidden(&kept));
    assert_eq!(hash(&world, &kept), hash(&world, &series));
}

#[test]
fn an_enhanced_ct_that_is_compressed_is_the_volume_of_its_classic_series() {
    let Some(python) = python() else { return };
    let world = World::new();
    let (series, folder) = (series(&world), world.path("enhanced"));
    fs::create_dir(&folder).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/write_enhanced_ct.py");
    let (input, file) = (series.to_str().unwrap(), folder.join("a.dcm"));
    let arguments = [input, file.to_str().unwrap(), "rle", "extended", "12"];
    assert!(
        Command::new(&python)
            .arg(script)
            .args(arguments)
            .output()
            .unwrap()
            .status
            .success()
    );
    let mut receiver = Receiver::start(&world, &["--once"]);
    let said = peer(&python, &receiver, TITLES, &["store", folder.to_str().unwrap()]);
    assert_eq!(said["statuses"], json!(["0000"]), "{said}");
    assert!(receiver.end().success(), "{}", receiver.text());
    assert_eq!(hash(&world, &kept(&world)[0]), hash(&world, &series));
}

/// A gap is told, with exit code 1, though all that was sent is kept.
#[test]
fn a_series_with_a_gap_is_kept_and_told_as_one_that_cannot_be_loaded() {
    let Some(python) = python() else { return };
    let world = World::new();
    let series = series(&world);
    fs::remove_file(series.join("IM0030.dcm")).unwrap();
    let mut receiver = Receiver::start(&world, &["--once"]);
    peer(&python, &receiver, TITLES, &["store", series.to_str().unwrap()]);
    assert_eq!(receiver.end().code(), Some(1));
    let told = receiver.text();
    assert!(
        told.contains("it cannot be loaded") && !told.contains("it can be loaded"),
        "{told}"
    );
    assert_eq!(count(&kept(&world)[0]), 59);
}

#[test]
fn titles_classes_and_codings_that_are_not_taken_are_refused_as_the_standard_has_it() {
    let Some(python) = python() else { return };
    let world = World::new();
    let scene = world.file("s.toml", "[pacs]\naet = \"OR 3\"\nfrom = [\"PACS\"]\n");
    let mut receiver = Receiver::start(&world, &["--scene", scene.to_str().unwrap()]);
    // Rejected-permanent, by the service user: called title, calling title.
    for (titles, reason) in [(["TROCAR", "PACS"], 7), (["OR 3", "OTHER"], 3)] {
        let said = peer(&python, &receiver, titles, &["echo"]);
        assert_eq!(said["rejected"], json!([1, 1, reason]), "{said}");
    }
    receiver.wait("\"PACS\": it calls \"TROCAR\", and this is \"OR 3\"");
    receiver.wait("\"OTHER\" is not among those who may send");
    let said = peer(&python, &receiver, ["OR 3", "PACS"], &["classes"]);
    assert_eq!(
        (&said["connected"], &said["accepted"]),
        (&json!(true), &json!(1)),
        "{said}"
    );
    receiver.wait("JPEG baseline");
    assert!(receiver.interrupt().success(), "{}", receiver.text());
    assert!(kept(&world).is_empty());
}

#[test]
fn a_connection_that_says_nothing_or_nonsense_keeps_nobody_out() {
    let world = World::new();
    let mut receiver = Receiver::start(&world, &["--silence-s", "1"]);
    let silent = receiver.raw();
    let mut nonsense = receiver.raw();
    nonsense.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    nonsense.read_to_end(&mut answer).unwrap();
    // An abort by the provider.
    assert_eq!(answer.first(), Some(&7), "{answer:?}");
    receiver.wait("no association: a PDU of");
    if let Some(python) = python() {
        let said = peer(&python, &receiver, TITLES, &["echo"]);
        assert_eq!(said["statuses"], json!(["0000"]), "{said}");
    }
    receiver.wait("no association: it fell silent");
    drop(silent);
    // Many at once: those beyond a number are closed.
    let many: Vec<_> = (0..12).map(|_| receiver.raw()).collect();
    receiver.wait("8 connections are open");
    drop(many);
    assert!(receiver.interrupt().success());
    assert_eq!(count(&world.path("in")), 0);
    // Who waits for one association is not told that it came.
    let mut receiver = Receiver::start(&world, &["--once"]);
    assert_eq!(receiver.interrupt().code(), Some(1));
    receiver.wait("before an association brought anything");
}

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    let world = World::new();
    let out = world.path("in");
    let refused = |more: &[&str], words: &str| {
        let arguments = [&["receive", "--out", out.to_str().unwrap()], more].concat();
        let output = world.output("volume-loader", &arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{words}: {said}");
    };
    refused(
        &["--listen", "0.0.0.0:0"],
        "--listen: found 0.0.0.0:0; allowed: an address of this machine alone",
    );
    refused(&["--listen", "here"], "an IP address and a port");
    refused(&["--aet", "SEVENTEEN LETTERS"], "--aet: found");
    refused(&["--from", "A", "--from", "A"], "each title once");
    let scene = world.file("s.toml", "[pacs]\naddress = \"0.0.0.0:0\"\n");
    refused(&["--scene", scene.to_str().unwrap()], "line 2");
    // A scene that exposes its own address exposes no other.
    let scene = world.file("s.toml", "[pacs]\naddress = \"127.0.0.1:0\"\nexpose = true\n");
    refused(
        &["--scene", scene.to_str().unwrap(), "--listen", "0.0.0.0:0"],
        "--expose",
    );
    let receiver = Receiver::start(&world, &[]);
    refused(
        &["--listen", "127.0.0.1:0"],
        "another program receives into this folder",
    );
    let taken = format!("127.0.0.1:{}", receiver.port);
    let (other, output) = (world.path("other"), taken.as_str());
    let arguments = ["receive", "--out", other.to_str().unwrap(), "--listen", output];
    let said = stderr(&world.output("volume-loader", &arguments));
    assert!(said.contains("cannot listen on"), "{said}");
}
