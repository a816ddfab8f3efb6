//! A run that is shown, made by hand so that it can lie, and one that shows it.

use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bus::Bus;
use bus::run::{RUNTIME_DIR_VARIABLE, RunContext, RunLock};
use tempfile::TempDir;

// The benchmarks take this file by its path too: from there these would be looked for beside it.
#[path = "rig/room.rs"]
mod room;
#[path = "rig/second.rs"]
mod second;

#[allow(unused_imports, reason = "shared with the benchmarks, which use some of it")]
pub(crate) use room::{Room, Voxels, grid};
pub(crate) use second::Second;

/// Far beyond what anything takes on a busy machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
const SCENE: &str = "[tracker]\nsource = \"external\"\n[tissue]\norgans = \"organs.toml\"\n";

/// One at a time: each has processes and links of its own, and two cores are all there are.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder for all runs of a test, with a short path.
pub(crate) fn world() -> TempDir {
    tempfile::Builder::new().prefix("tr").tempdir_in("/tmp").unwrap()
}

/// A port of the loopback that nobody listens at.
pub(crate) fn free_endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}")
}

/// Looks again and again until `is` gives something.
pub(crate) fn until<T>(what: &str, mut is: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = is() {
            return found;
        }
        assert!(
            began.elapsed() < PATIENCE,
            "{what}: not within {} s",
            PATIENCE.as_secs()
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A run of `scene` that nobody but its test keeps.
fn run(
    (world, name, scene): (&Path, &str, &str),
    epoch_ns: i64,
    change: impl FnOnce(&mut RunContext),
) -> (RunLock, RunContext, Bus) {
    let dir = world.join(name);
    let lock = RunLock::acquire(&dir).unwrap();
    let mut run = RunContext::new(&dir, epoch_ns).unwrap();
    change(&mut run);
    run.store_scene(scene).unwrap();
    let bus = Bus::keep(&run).unwrap();
    run.store().unwrap();
    (lock, run, bus)
}

/// A process under test; killed with the test. What it says is kept.
pub(crate) struct Program {
    pub(crate) child: Child,
    said: PathBuf,
}

impl Program {
    pub(crate) fn start(world: &Path, name: &str, mut command: Command) -> Self {
        let said = world.join(format!("{name}.log"));
        command
            .env(RUNTIME_DIR_VARIABLE, world)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        command.stderr(std::fs::File::create(&said).unwrap());
        Self {
            child: command.spawn().unwrap(),
            said,
        }
    }

    pub(crate) fn said(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap()
    }

    pub(crate) fn ended(&mut self) -> ExitStatus {
        self.ended_while(|| {})
    }

    /// `meanwhile` is done again and again.
    pub(crate) fn ended_while(&mut self, meanwhile: impl Fn()) -> ExitStatus {
        until("the end of a process", || {
            meanwhile();
            self.child.try_wait().unwrap()
        })
    }

    pub(crate) fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).unwrap();
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            println!("{}:\n{}", self.said.display(), self.said());
        }
    }
}

pub(crate) fn remote_proc() -> Command {
    Command::new(env!("CARGO_BIN_EXE_remote-proc"))
}

fn verb(verb: &str) -> Command {
    let mut command = remote_proc();
    command.arg(verb);
    command
}

/// A folder with keys for a sender at `host`.
pub(crate) fn keys(world: &Path, host: &str) -> String {
    let out = world.join("keys");
    let mut command = remote_proc();
    let made = command
        .arg("keys")
        .arg("--out")
        .arg(&out)
        .args(["--host", host])
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    out.to_string_lossy().into_owned()
}

/// All that `command` says on stderr; it must fail.
pub(crate) fn refused(mut command: Command) -> String {
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(!child.wait().unwrap().success(), "{said}");
    said
}
