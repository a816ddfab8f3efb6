//! What the end-to-end tests share: a world of their own with real processes in it, and a watchdog on everything.

#![allow(unreachable_pub, reason = "a module of each test file, and not a crate")]
#![allow(dead_code, reason = "each test file uses its own part of it")]
#![allow(
    clippy::disallowed_methods,
    reason = "tests start the real binaries and time their own patience"
)]
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "part of the tests, where both are allowed"
)]

pub mod cable;
pub mod frames;
pub mod links;
pub mod nifti;
pub mod proxy;
pub mod room;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Longer than anything a test waits for; a test that hangs fails here and not at the CI's limit.
pub const WATCHDOG: Duration = Duration::from_secs(180);

/// The generated patient at 6 mm and small images: a run that starts in a fraction of a second. Its limits are those of a busy
/// machine: what is tested is what happens when one is passed, and that does not happen for want of a processor.
pub const SMALL: &str = r#"
seed = 1
[volume]
source = "phantom"
spacing_mm = 6.0
[tracker]
rate_hz = 60.0
[tracker.approach]
insert_s = 1.0
pause_s = 0.2
sweep_s = 1.0
[recording]
[limits]
stale_ms = 1000.0
silent_s = 30.0
stop_s = 30.0
restart_window_s = 3600.0
max_missing_share = 1.0
latency_p99_ms = 0.0
[[views]]
name = "axial-global"
plane = "axial"
extent = "global"
size = [128, 128]
[[views]]
name = "frontal-local"
plane = "frontal"
extent = "local"
size = [128, 128]
[[views]]
name = "perpendicular"
plane = "perpendicular"
extent = "local"
size = [128, 128]
"#;

/// A folder with its own runs, scenes and outputs; everything in it goes with it.
pub struct World {
    folder: tempfile::TempDir,
}

impl World {
    /// Short paths: sockets live below it.
    pub fn new() -> Self {
        let folder = tempfile::Builder::new()
            .prefix("tc")
            .rand_bytes(5)
            .tempdir_in("/tmp")
            .unwrap();
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file and returns its path.
    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The folder of a run.
    pub fn run_dir(&self, run: &str) -> PathBuf {
        self.path("r").join(run)
    }

    /// One of the project's binaries, in this world.
    pub fn command(&self, binary: &str) -> Command {
        let path = match binary {
            "pilot" => env!("CARGO_BIN_EXE_pilot"),
            "volume-loader" => env!("CARGO_BIN_EXE_volume-loader"),
            "tracker-proc" => env!("CARGO_BIN_EXE_tracker-proc"),
            "localizer-proc" => env!("CARGO_BIN_EXE_localizer-proc"),
            "slice-view-proc" => env!("CARGO_BIN_EXE_slice-view-proc"),
            "calib" => env!("CARGO_BIN_EXE_calib"),
            "recorder" => env!("CARGO_BIN_EXE_recorder"),
            "gateway-proc" => env!("CARGO_BIN_EXE_gateway-proc"),
            "tissue-proc" => env!("CARGO_BIN_EXE_tissue-proc"),
            "window" => env!("CARGO_BIN_EXE_window"),
            "window-watch" => env!("CARGO_BIN_EXE_window-watch"),
            "simulate" => env!("CARGO_BIN_EXE_simulate"),
            other => panic!("no such binary: {other}"),
        };
        let mut command = Command::new(path);
        command.env("TROCAR_RUNTIME_DIR", self.path("r")).stdin(Stdio::null());
        command
    }

    /// Runs a binary to its end.
    pub fn output(&self, binary: &str, arguments: &[&str]) -> Output {
        let child = self
            .command(binary)
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_with_output(child)
    }

    /// Runs a scene to its end and returns its report.
    pub fn navigate(&self, scene: &Path, out: &Path, arguments: &[&str]) -> Value {
        let (scene, out_text) = (scene.to_string_lossy(), out.to_string_lossy());
        let mut all = vec!["run", &scene, "--headless", "--out", &out_text];
        all.extend(arguments);
        let output = self.output("pilot", &all);
        assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
        report(out)
    }

    /// Starts a scene and returns the pilot, which navigates until it is stopped.
    pub fn start(&self, scene: &Path, out: &Path, run: &str) -> Pilot<'_> {
        let child = self
            .command("pilot")
            .args(["run", &scene.to_string_lossy(), "--headless", "--run", run])
            .args(["--out", &out.to_string_lossy()])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        Pilot {
            world: self,
            run: run.to_owned(),
            child,
        }
    }
}

/// A pilot that is running.
pub struct Pilot<'a> {
    world: &'a World,
    run: String,
    pub child: Child,
}

impl<'a> Pilot<'a> {
    /// A pilot that was started some other way.
    pub fn of(world: &'a World, run: &str, child: Child) -> Self {
        let run = run.to_owned();
        Self { world, run, child }
    }
}

impl Pilot<'_> {
    /// `pilot status`, or `None` while there is none to be had.
    pub fn status(&self) -> Option<Value> {
        let output = self.world.output("pilot", &["status", "--json", "--run", &self.run]);
        output
            .status
            .success()
            .then(|| serde_json::from_slice(&output.stdout).unwrap())
    }

    /// Waits until `ready(status)`; returns that status.
    pub fn wait_for(&self, what: &str, ready: impl Fn(&Value) -> bool) -> Value {
        let mut last = None;
        let found = poll(|| {
            assert!(
                is_alive(self.child.id().into()),
                "the pilot ended while waiting for {what}"
            );
            last = self.status();
            last.as_ref().filter(|status| ready(status)).cloned()
        });
        found.unwrap_or_else(|| panic!("waited {WATCHDOG:?} for {what}; the last status: {last:#?}"))
    }

    /// Waits until every view is live.
    pub fn wait_live(&self) -> Value {
        self.wait_for("every view live", all_live)
    }

    /// Waits until a process has ended too often and is left alone, and `also` holds.
    pub fn wait_held(&self, process: &str, also: impl Fn(&Value) -> bool) -> Value {
        self.wait_for(&format!("{process} to be held"), |status| {
            let is_held = |p: &Value| p["name"] == process && p["stage"] == "held";
            status["processes"].as_array().unwrap().iter().any(is_held) && also(status)
        })
    }

    /// The process number of a child.
    pub fn pid(&self, process: &str) -> Option<u64> {
        pid_in(&self.status()?, process)
    }

    /// `pilot stop`, and waits for the end.
    pub fn stop(mut self) -> std::process::ExitStatus {
        let output = self.world.output("pilot", &["stop", "--run", &self.run]);
        assert!(output.status.success(), "{}", stderr(&output));
        wait_for("the pilot to end", || self.child.try_wait().unwrap())
    }
}

impl Drop for Pilot<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn all_live(status: &Value) -> bool {
    status["views"]
        .as_array()
        .is_some_and(|views| views.iter().all(|v| v["state"] == "live"))
}

pub fn pid_in(status: &Value, process: &str) -> Option<u64> {
    let processes = status["processes"].as_array()?;
    processes.iter().find(|p| p["name"] == process)?["pid"].as_u64()
}

/// kill -9.
pub fn kill_9(pid: u64) {
    let pid = rustix::process::Pid::from_raw(i32::try_from(pid).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
}

pub fn is_alive(pid: u64) -> bool {
    // A zombie has ended; its parent has not looked yet.
    std::fs::read_to_string(format!("/proc/{pid}/stat")).is_ok_and(|stat| {
        stat.rsplit(')')
            .next()
            .is_some_and(|rest| !rest.trim_start().starts_with('Z'))
    })
}

/// Polls until there is an answer; fails at the watchdog.
pub fn wait_for<T>(what: &str, ready: impl FnMut() -> Option<T>) -> T {
    poll(ready).unwrap_or_else(|| panic!("waited {WATCHDOG:?} for {what}"))
}

fn poll<T>(mut ready: impl FnMut() -> Option<T>) -> Option<T> {
    let began = Instant::now();
    loop {
        let answer = ready();
        if answer.is_some() || began.elapsed() > WATCHDOG {
            return answer;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn wait_with_output(mut child: Child) -> Output {
    // The pipes are read by a thread of the standard library's own in `wait_with_output`; the watchdog kills.
    let pid = u64::from(child.id());
    let (done, watched) = std::sync::mpsc::channel::<()>();
    let watchdog = std::thread::spawn(move || {
        if watched.recv_timeout(WATCHDOG).is_err() && is_alive(pid) {
            kill_9(pid);
        }
    });
    drop(child.stdin.take());
    let output = child.wait_with_output().unwrap();
    let _ = done.send(());
    watchdog.join().unwrap();
    output
}

pub fn report(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The PNG files of a run by name.
pub fn pictures(out: &Path) -> std::collections::BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path());
    let pngs = files.filter(|path| path.extension().is_some_and(|end| end == "png"));
    pngs.map(|path| {
        (
            path.file_name().unwrap().to_string_lossy().into_owned(),
            std::fs::read(&path).unwrap(),
        )
    })
    .collect()
}

/// The text chunks of a PNG.
pub fn png_texts(path: &Path) -> std::collections::BTreeMap<String, String> {
    let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap()));
    let reader = reader.read_info().unwrap();
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().map(|t| (t.keyword.clone(), t.text.clone())).collect()
}

/// Data that is not part of the project: `None`, with a printed reason, where it is not there.
pub fn shared(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("TROCAR_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let path = root.join(path);
    if path.exists() {
        return Some(path);
    }
    println!(
        "skipped: {} is not there (set TROCAR_SHARED to the folder that holds it)",
        path.display()
    );
    None
}

/// The Python interpreter with the packages that `cargo xtask test` installs: `None`, with a printed reason, elsewhere.
pub fn python() -> Option<PathBuf> {
    let python = std::env::var_os("TROCAR_PYTHON").map(PathBuf::from);
    if python.is_none() {
        println!("skipped: TROCAR_PYTHON is not set (`cargo xtask test` prepares an interpreter and sets it)");
    }
    python
}
