//! A run's folder: where its lock, its facts and its sockets lie, and how left-overs of killed processes are removed.
//!
//! Runs of one user are told apart by name. The folder and everything in shared memory carry the run's own prefix, so
//! two runs, two users or two tests never see each other. Part of the prefix is drawn anew for each run and stands in its folder
//! only, so that no other user can make a file of that name first.

mod error;
mod kept;
pub(crate) mod own;

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::rand::{GetRandomFlags, getrandom};
use serde::{Deserialize, Serialize};

pub use error::RunError;

use scene::file;

/// Names the folder that holds all runs of a user; tests set it to have a world of their own.
pub const RUNTIME_DIR_VARIABLE: &str = "TROCAR_RUNTIME_DIR";
/// Where iceoryx2 keeps payloads.
pub const SHM_DIR: &str = "/dev/shm";
/// Socket paths end at 107 bytes; iceoryx2 needs up to 60 of them behind the run's folder.
const MAX_DIR_BYTES: usize = 107 - 61;
const MAX_NAME: usize = 24;
/// The files of a run's folder that its processes read.
const FACTS: &str = "run.json";
const SCENE: &str = "scene.toml";
/// What the names of files begin with that a process keeps for the one that follows on it.
const KEPT: &str = "kept-";
/// How often a pilot tries to take its run, and how long it waits in between: who asks whether it is held has it for less.
const LOOKS: u32 = 40;
const BETWEEN_LOOKS: Duration = Duration::from_millis(5);

/// What every process of a run knows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunContext {
    /// The run's name.
    pub name: String,
    /// The run's folder.
    pub dir: PathBuf,
    /// CLOCK_MONOTONIC at the run's start, ns: the zero of all its stamps.
    pub epoch_ns: i64,
    /// The pilot's process.
    pub pilot_pid: u32,
    /// What is replayed; `None`: the run navigates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replay: Option<ReplayOf>,
    /// The run of another machine that is shown; `None`: it is this machine's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remote: Option<RemoteOf>,
    /// How long the run navigates from sample 0 on, ns: what is captured later belongs to no sample of it. `None`: until it is
    /// stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_ns: Option<i64>,
    /// Whether time is made up: each sample waits until every view has drawn the one before ([`crate::session`]).
    #[serde(default)]
    pub simulated_time: bool,
    /// Whether an operation is planned: no pose is published, and the pilot tells the plan.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub planning: bool,
    /// What its files in shared memory are called beside those of other runs in the same folder: nobody can guess it.
    key: String,
}

/// What a replay replays.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReplayOf {
    /// The recording.
    pub recording: PathBuf,
    /// The examination that was navigated in, as its hash is written; `None` where the recording does not say.
    pub volume_hash: Option<String>,
    /// Whether a model answers the recorded poses again: time waits for its states.
    #[serde(default)]
    pub tissue_again: bool,
}

/// The run of another machine that is shown here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RemoteOf {
    /// Where it is to be had, as it was given: `tls/10.0.0.5:7447`.
    pub endpoint: String,
    /// Its name there.
    pub run: String,
}

fn io_error(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> RunError {
    let path = path.to_owned();
    move |source| RunError::Io { doing, path, source }
}

/// The folder of a run: `$TROCAR_RUNTIME_DIR/NAME`, else `$XDG_RUNTIME_DIR/trocar/NAME`, else `/tmp/trocar-UID/NAME`.
///
/// # Errors
/// [`RunError::Name`].
pub fn run_dir(name: &str) -> Result<PathBuf, RunError> {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if name.is_empty() || name.len() > MAX_NAME || !name.chars().all(allowed) {
        return Err(RunError::Name(name.to_owned()));
    }
    Ok(base_dir().join(name))
}

fn base_dir() -> PathBuf {
    if let Some(dir) = std::env::var_os(RUNTIME_DIR_VARIABLE).filter(|d| !d.is_empty()) {
        return PathBuf::from(dir);
    }
    match std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from) {
        Some(dir) if dir.is_dir() => dir.join("trocar"),
        _ => PathBuf::from(format!("/tmp/trocar-{}", rustix::process::getuid().as_raw())),
    }
}

/// Letters and digits that name `number`, as many as `length`.
fn named(mut number: u64, length: usize) -> String {
    const DIGITS: &[u8; 62] = b"0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    let digit = |_| {
        let digit = DIGITS[(number % 62) as usize];
        number /= 62;
        char::from(digit)
    };
    (0..length).map(digit).collect()
}

/// Five letters or digits that nobody can guess.
fn key() -> Result<String, RunError> {
    let mut bytes = [0; 8];
    getrandom(&mut bytes, GetRandomFlags::empty()).map_err(|e| RunError::Random(e.into()))?;
    Ok(named(u64::from_ne_bytes(bytes), 5))
}

/// With their lengths, so that nothing moves from one to the other.
fn hash_of(facts: &[u8], scene: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    for bytes in [facts, scene] {
        hasher.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    }
    hasher.finalize().to_hex().to_string()
}

impl RunContext {
    /// The facts of a new run in `dir`, with this process as its pilot.
    ///
    /// # Errors
    /// [`RunError::TooLong`], [`RunError::Random`].
    pub fn new(dir: &Path, epoch_ns: i64) -> Result<Self, RunError> {
        if dir.as_os_str().len() > MAX_DIR_BYTES {
            return Err(RunError::TooLong(dir.to_owned()));
        }
        let name = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self {
            name,
            dir: dir.to_owned(),
            epoch_ns,
            pilot_pid: std::process::id(),
            replay: None,
            remote: None,
            duration_ns: None,
            simulated_time: false,
            planning: false,
            key: key()?,
        })
    }

    /// Reads the facts of a run from its folder.
    ///
    /// # Errors
    /// [`RunError::Io`], [`RunError::Facts`], [`RunError::NotRunning`] where there is no such run; [`RunError::Foreign`] and
    /// [`RunError::Open`] where somebody else may have written them.
    pub fn load(dir: &Path) -> Result<Self, RunError> {
        Self::parse(dir, &Self::read_facts(dir)?)
    }

    /// The same with the text of the run's scene. What is parsed is what was hashed: with `hash`, which the pilot hands to each
    /// process that it starts ([`RunContext::facts_hash`]), none goes by files that were exchanged.
    ///
    /// # Errors
    /// As [`RunContext::load`], and [`RunError::Changed`] where the files are not those of `hash`.
    pub fn load_with_scene(dir: &Path, hash: Option<&str>) -> Result<(Self, String), RunError> {
        let facts = Self::read_facts(dir)?;
        let path = dir.join(SCENE);
        let scene = own::read(&path).map_err(io_error("reading", &path))?;
        if hash.is_some_and(|hash| hash_of(&facts, &scene) != hash) {
            return Err(RunError::Changed { dir: dir.to_owned() });
        }
        let not_text = |e| io_error("reading", &path)(io::Error::new(io::ErrorKind::InvalidData, e));
        Ok((Self::parse(dir, &facts)?, String::from_utf8(scene).map_err(not_text)?))
    }

    fn read_facts(dir: &Path) -> Result<Vec<u8>, RunError> {
        let path = dir.join(FACTS);
        let not_running = || RunError::NotRunning {
            name: dir.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        };
        if !dir.exists() {
            return Err(not_running());
        }
        own::check(dir)?;
        own::read(&path).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => not_running(),
            _ => io_error("reading", &path)(source),
        })
    }

    fn parse(dir: &Path, facts: &[u8]) -> Result<Self, RunError> {
        let path = dir.join(FACTS);
        serde_json::from_slice(facts).map_err(|source| RunError::Facts { path, source })
    }

    fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// The hash of what the processes of this run read: these facts, and the text of its scene.
    pub fn facts_hash(&self, scene: &str) -> String {
        hash_of(self.text().as_bytes(), scene.as_bytes())
    }

    /// Writes the facts into the run's folder, for the processes that join.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn store(&self) -> Result<(), RunError> {
        let path = self.dir.join(FACTS);
        own::write(&path, self.text().as_bytes()).map_err(io_error("writing", &path))
    }

    /// Removes the facts, so that nobody joins: at a run's end, and where a pilot that was killed left them.
    pub fn remove_facts(&self) {
        let _ = std::fs::remove_file(self.dir.join(FACTS));
    }

    /// Whether this run still has its pilot; another run of the name is another run.
    pub fn is_running(&self) -> bool {
        RunLock::is_held(&self.dir) && Self::load(&self.dir).is_ok_and(|now| now.key == self.key)
    }

    /// Writes the scene into the run's folder, for the processes that join.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn store_scene(&self, text: &str) -> Result<(), RunError> {
        let path = self.scene_path();
        own::write(&path, text.as_bytes()).map_err(io_error("writing", &path))
    }

    /// Says to the run's tracker when sample 0 is due, ns on the run's clock: once it is ready.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn begin(&self, began_ns: i64) -> Result<(), RunError> {
        let path = self.began_path();
        // Whoever looks finds all of it, or nothing.
        own::write(&path, began_ns.to_string().as_bytes()).map_err(io_error("writing", &path))
    }

    /// When sample 0 is due; `None` until the pilot has said.
    pub fn began_ns(&self) -> Option<i64> {
        std::str::from_utf8(&own::read(&self.began_path()).ok()?)
            .ok()?
            .parse()
            .ok()
    }

    /// Whether what is captured this long after sample 0, ns, is beyond the time that the run navigates for.
    pub fn is_beyond(&self, since_start_ns: i64) -> bool {
        self.duration_ns
            .is_some_and(|duration_ns| since_start_ns >= duration_ns)
    }

    fn began_path(&self) -> PathBuf {
        self.dir.join("began")
    }

    /// Where iceoryx2 keeps this run's services and sockets.
    pub fn ipc_root(&self) -> PathBuf {
        self.dir.join("i")
    }

    /// What every shared-memory file of this run begins with.
    pub fn prefix(&self) -> String {
        format!("{}{}", self.folder_prefix(), self.key)
    }

    /// What the shared-memory files of every run in this folder begin with, those before this one included.
    pub fn folder_prefix(&self) -> String {
        let hash = blake3::hash(self.dir.as_os_str().as_encoded_bytes());
        let mut first = [0; 8];
        first.copy_from_slice(&hash.as_bytes()[..8]);
        format!("tr{}", named(u64::from_le_bytes(first), 5))
    }

    /// Closes what this run has in shared memory to every other user: one segment of iceoryx2's is made for everybody.
    pub(crate) fn close_shared_memory(&self) {
        own::close_files(Path::new(SHM_DIR), &self.prefix());
    }

    /// The scene of this run, with every override applied.
    pub fn scene_path(&self) -> PathBuf {
        self.dir.join(SCENE)
    }

    /// Removes what killed processes of this run left behind. Only for the holder of the run's lock.
    pub fn sweep(&self) {
        // Nothing can be done about a failure here, and the next start tries again.
        let _ = fs::remove_dir_all(self.ipc_root());
        let _ = fs::remove_file(self.began_path());
        for entry in fs::read_dir(&self.dir).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(KEPT) {
                let _ = fs::remove_file(entry.path());
            }
        }
        let prefix = self.folder_prefix();
        for entry in fs::read_dir(SHM_DIR).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Held by the pilot of a run for as long as it lives; the kernel releases it when the process dies in any way.
#[derive(Debug)]
pub struct RunLock {
    _file: File,
}

impl RunLock {
    /// Takes the run in `dir`.
    ///
    /// # Errors
    /// [`RunError::AlreadyRunning`] with the holder's process, [`RunError::Foreign`], [`RunError::Io`].
    pub fn acquire(dir: &Path) -> Result<Self, RunError> {
        own::make(dir)?;
        let path = dir.join("lock");
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .custom_flags(OFlags::NOFOLLOW.bits() as i32)
            .open(&path)
            .map_err(io_error("opening", &path))?;
        if !locked(&file) {
            let mut pid = String::new();
            let _ = file.read_to_string(&mut pid);
            return Err(RunError::AlreadyRunning {
                name: dir.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                pid: pid.trim().to_owned(),
            });
        }
        let write = |file: &mut File| {
            file.set_len(0)?;
            file.rewind()?;
            writeln!(file, "{}", std::process::id())
        };
        write(&mut file).map_err(io_error("writing", &path))?;
        Ok(Self { _file: file })
    }

    /// Whether somebody holds the run in `dir`. A pipe of that name, which another user may have put there, holds nobody up.
    pub fn is_held(dir: &Path) -> bool {
        file::open(&dir.join("lock"))
            .is_ok_and(|(file, _)| flock(&file, FlockOperation::NonBlockingLockShared).is_err())
    }
}

/// Takes the lock, and does not take for a pilot whoever only looks whether there is one.
fn locked(file: &File) -> bool {
    (0..LOOKS).any(|look| {
        if look > 0 {
            std::thread::sleep(BETWEEN_LOOKS);
        }
        flock(file, FlockOperation::NonBlockingLockExclusive).is_ok()
    })
}

/// Bytes of memory that can be taken without swapping; `None` where the system does not say.
pub fn free_memory_bytes() -> Option<u64> {
    let meminfo = fs::read_to_string("/proc/meminfo").ok()?;
    let available = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = available.split_whitespace().next()?.parse().ok()?;
    Some(kib.saturating_mul(1024))
}

/// Free bytes in shared memory.
///
/// # Errors
/// [`RunError::Io`] where `/dev/shm` cannot be asked.
pub fn shm_free_bytes() -> Result<u64, RunError> {
    let path = Path::new(SHM_DIR);
    let stat = rustix::fs::statvfs(path).map_err(|e| io_error("asking for the free space of", path)(e.into()))?;
    Ok(stat.f_bavail.saturating_mul(stat.f_frsize))
}

#[cfg(test)]
mod tests;
