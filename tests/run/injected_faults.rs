//! Processes that are killed at each system call of joining, opening, publishing and cleaning, and disks whose calls fail: strace
//! counts the calls and kills, or lets fail, at the one that is asked for, so that no point is missed by chance.

#![allow(clippy::print_stdout, reason = "the figures")]
#![allow(
    clippy::disallowed_methods,
    reason = "a folder of programs of its own, strace, and real time"
)]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::nifti::Nifti;
use crate::support::{Pilot, SMALL, World, kill_9, pid_in, wait_for};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// A program, and the process of it that is killed.
const KINDS: [(&str, &str); 4] = [
    ("tracker-proc", "tracker"),
    ("slice-view-proc", "view-axial"),
    ("recorder", "recorder"),
    ("volume-loader", "volume-loader"),
];
/// The calls by which a process shows itself to others, or takes something from them.
const CALLS: &str = "openat,mkdir,mkdirat,ftruncate,fchmod,mmap,munmap,unlink,unlinkat,rename,renameat,linkat,fcntl,flock,write,close,\
                     socket,bind,connect,sendto,sendmsg,recvfrom,recvmsg,poll,getdents64,kill";
/// A process that is killed must be back by then.
const PATIENCE: Duration = Duration::from_secs(10);

/// One call: its name, and which of its kind.
type Point = (String, u32);

/// Copies a program by another process: what this one writes itself its children of other tests may hold open, and until they are other
/// programs the system refuses to start it (ETXTBSY).
fn copied(from: &Path, to: &Path) {
    assert!(
        Command::new("cp")
            .arg("-p")
            .args([from, to])
            .status()
            .unwrap()
            .success()
    );
}

/// The programs in a folder of their own, where strace stands before those that are killed.
struct Theatre {
    folder: PathBuf,
}

impl Theatre {
    fn new(world: &World) -> Self {
        let folder = world.path("bin");
        fs::create_dir(&folder).unwrap();
        let real = |program: &str| PathBuf::from(world.command(program).get_program());
        // A program looks for its siblings where it lies itself, whatever link led there.
        copied(&real("pilot"), &folder.join("pilot"));
        for (program, _) in KINDS {
            let script = format!(
                "#!/bin/sh\n# The first start after the file was written is traced as it says.\n\
                 if mv {folder}/{program}.asked {folder}/{program}.taken 2>/dev/null; then\n\
                 echo $$ >{folder}/{program}.pid\n\
                 exec strace -D -qq $(cat {folder}/{program}.taken) {real} \"$@\"\nfi\n\
                 if [ -e {folder}/{program}.always ]; then\n\
                 exec strace -D -qq $(cat {folder}/{program}.always) {real} \"$@\"\nfi\nexec {real} \"$@\"\n",
                folder = folder.display(),
                real = real(program).display(),
            );
            let written = folder.join("script");
            fs::write(&written, script).unwrap();
            fs::set_permissions(&written, fs::Permissions::from_mode(0o700)).unwrap();
            copied(&written, &folder.join(program));
        }
        for program in ["calib", "simulate"] {
            symlink(real(program), folder.join(program)).unwrap();
        }
        Self { folder }
    }

    fn command(&self, world: &World, scene: &Path, out: &Path) -> Command {
        let mut command = Command::new(self.folder.join("pilot"));
        command.env("TROCAR_RUNTIME_DIR", world.path("r")).stdin(Stdio::null());
        command.args(["run", "--headless", "--out"]).args([out, scene]);
        command
    }

    fn start<'a>(&self, world: &'a World, scene: &Path, out: &Path) -> Pilot<'a> {
        let child = self.command(world, scene, out).stdout(Stdio::null()).spawn().unwrap();
        Pilot::of(world, "default", child)
    }

    fn file(&self, program: &str, kind: &str) -> PathBuf {
        self.folder.join(format!("{program}.{kind}"))
    }

    /// Has the next start of `program` traced as `options` say.
    fn ask(&self, program: &str, options: &str) {
        fs::write(self.file(program, "asked.new"), options).unwrap();
        fs::rename(self.file(program, "asked.new"), self.file(program, "asked")).unwrap();
    }

    /// Kills `process` once, and has the one that follows traced as `options` say; returns its number.
    fn follow(&self, pilot: &Pilot<'_>, program: &str, process: &str, options: &str) -> u64 {
        let _ = fs::remove_file(self.file(program, "pid"));
        let victim = wait_for(process, || pilot.pid(process));
        self.ask(program, &format!("-e trace={CALLS} {options}"));
        kill_9(victim);
        wait_for("a start", || {
            fs::read_to_string(self.file(program, "pid")).ok()?.trim().parse().ok()
        })
    }

    /// The calls of a process from where it comes to its run until its views are live.
    fn points(&self, pilot: &Pilot<'_>, program: &str, process: &str) -> Vec<Point> {
        let log = self.file(program, "log");
        let pid = self.follow(pilot, program, process, &format!("-o {}", log.display()));
        pilot.wait_for("the traced process", |status| {
            is_well(status) && pid_in(status, process) == Some(pid)
        });
        let text = fs::read_to_string(&log).unwrap();
        let mut counts: BTreeMap<String, u32> = BTreeMap::new();
        let mut points = Vec::new();
        let mut has_joined = false;
        for line in text.lines() {
            let Some((call, _)) = line.split_once('(') else {
                continue;
            };
            let count = counts.entry(call.to_owned()).or_default();
            *count += 1;
            has_joined |= line.contains("run.json");
            if has_joined {
                points.push((call.to_owned(), *count));
            }
        }
        points
    }
}

fn is_well(status: &Value) -> bool {
    let are_ready = status["processes"]
        .as_array()
        .unwrap()
        .iter()
        .all(|p| p["stage"] == "ready");
    crate::support::all_live(status) && are_ready
}

/// Whether strace may trace here; else a word why these tests do nothing.
fn can_trace() -> bool {
    let traced = Command::new("strace").args(["-qq", "-o", "/dev/null", "true"]).status();
    let can = traced.is_ok_and(|status| status.success());
    if !can {
        println!("skipped: strace is not installed, or may not trace here");
    }
    can
}

/// Kills each process at `count` of its points, evenly spread (`None`: at all), and prints how long each kind took to be back.
fn kill_at_points(count: Option<usize>) {
    if !can_trace() {
        return;
    }
    let world = World::new();
    let scene = SMALL.replace("[limits]", "[limits]\nrestarts = 100");
    let scene = scene.replace("restart_window_s = 3600.0", "restart_window_s = 1.0");
    let theatre = Theatre::new(&world);
    let pilot = theatre.start(&world, &world.file("s.toml", &scene), &world.path("out"));
    pilot.wait_for("the run", is_well);
    for (program, process) in KINDS {
        let points = theatre.points(&pilot, program, process);
        assert!(points.len() > 20, "{program}: {}", points.len());
        let step = points.len() / count.unwrap_or(points.len()).max(1);
        let mut took_ms = Vec::new();
        let mut missed = 0;
        for (call, number) in points.iter().step_by(step.max(1)) {
            pilot.wait_for("the run", is_well);
            let options = format!("-o /dev/null -e inject={call}:signal=KILL:when={number}");
            let began = Instant::now();
            let pid = theatre.follow(&pilot, program, process, &options);
            pilot.wait_for(&format!("{process} after it was killed at {call} {number}"), is_well);
            let took = began.elapsed();
            assert!(
                took < PATIENCE,
                "{process}, killed at {call} {number}, was back after {took:?}"
            );
            took_ms.push(took.as_millis());
            // One that did not come to its point may do so at any time: it must not die in the midst of the next try.
            if pilot.pid(process) == Some(pid) {
                missed += 1;
                let _ = kill_process(Pid::from_raw(pid as i32).unwrap(), Signal::KILL);
                pilot.wait_for(process, |status| {
                    is_well(status) && pid_in(status, process) != Some(pid)
                });
            }
        }
        took_ms.sort_unstable();
        let (n, at) = (took_ms.len(), |share: usize| took_ms[(took_ms.len() - 1) * share / 100]);
        println!(
            "{process}: killed at {} of {} points ({missed} not reached again), back after {} / {} / {} ms (median, p95, most)",
            n - missed,
            points.len(),
            at(50),
            at(95),
            at(100)
        );
        assert!(2 * missed < n, "{process}: {missed} of {n} points were not reached");
    }
    // The last one killed may still be ending: what it leaves is removed in the next round.
    pilot.wait_for("the run well and nothing left of the killed", |status| {
        is_well(status) && status["dead_processes_left"] == 0
    });
    assert_eq!(pilot.stop().code(), Some(3));
    for view in crate::support::report(&world.path("out"))["views"].as_array().unwrap() {
        assert_eq!(view["unflagged_old"], 0);
    }
}

#[test]
fn processes_killed_at_points_of_their_joining_come_back() {
    kill_at_points(Some(5));
}

#[test]
#[ignore = "takes minutes: cargo test --test run injected_faults -- --ignored --nocapture"]
fn processes_killed_at_every_point_of_their_joining_come_back() {
    kill_at_points(None);
}

/// What the calls on the growing recording do, and what the run must say then.
const DISKS: [(&str, &str); 7] = [
    ("write:error=EIO:when=3+", "Input/output error"),
    ("write:error=EROFS:when=4+", "Read-only file system"),
    ("write:error=EDQUOT:when=4+", "Disk quota exceeded"),
    ("fdatasync:error=EIO:when=2+", "Input/output error"),
    ("fsync:error=EIO", "was not finished"),
    ("rename:error=EIO", "was not finished"),
    // A disk that says it wrote what it did not.
    ("write:retval=2000:when=4", "the recording lacks"),
];

#[test]
fn disks_that_fail_are_named_and_no_pose_is_missed_in_silence() {
    if !can_trace() {
        return;
    }
    for (inject, said) in DISKS {
        let world = World::new();
        let (theatre, out) = (Theatre::new(&world), world.path("out"));
        let growing = out.join("session.mcap.recording");
        theatre.ask(
            "recorder",
            &format!("-f -o /dev/null -P {} -e inject={inject}", growing.display()),
        );
        let scene = SMALL.replace("[recording]", "[recording]\nchunk_s = 0.1\nsync_s = 0.2");
        let mut command = theatre.command(&world, &world.file("s.toml", &scene), &out);
        let output = command.args(["--for", "1500ms"]).output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(3),
            "{inject}: {}",
            crate::support::stderr(&output)
        );
        let report = crate::support::report(&out);
        let problems = report["problems"].to_string();
        assert!(problems.contains(said), "{inject}: {problems}");
        // What is in whole files and what is said to be in none are all that went out.
        let published = report["poses"]["published"].as_u64().unwrap();
        let kept: u64 = whole_poses(&world, &out);
        let lacking = format!("the recording lacks {} of the {published} samples", published - kept);
        assert!(
            kept < published && problems.contains(&lacking),
            "{inject}: {kept}, {problems}"
        );
    }
}

/// Both at once: the recorder dies, and its disk takes no file any more. It once ended again and again, and was held for good.
#[test]
fn a_recorder_that_dies_with_its_disk_says_so_and_records_again_when_it_can() {
    if !can_trace() {
        return;
    }
    let world = World::new();
    let (theatre, out) = (Theatre::new(&world), world.path("out"));
    let pilot = theatre.start(&world, &world.file("s.toml", SMALL), &out);
    pilot.wait_for("the run", is_well);
    let growing = out.join("session.mcap.recording");
    theatre.ask(
        "recorder",
        // Its first two tries.
        &format!(
            "-f -o /dev/null -P {} -e inject=openat:error=EROFS:when=1..2",
            growing.display()
        ),
    );
    kill_9(pilot.pid("recorder").unwrap());
    let note = |status: &Value| {
        let processes = status["processes"].as_array().unwrap();
        let recorder = processes.iter().find(|p| p["name"] == "recorder").unwrap();
        recorder["note"].as_str().unwrap().to_owned()
    };
    pilot.wait_for("a recorder that says what is amiss", |status| {
        is_well(status) && note(status).contains("NOT RECORDING") && note(status).contains("Read-only file system")
    });
    pilot.wait_for("a recorder that records", |status| {
        is_well(status) && note(status).contains("synced")
    });
    assert_eq!(pilot.stop().code(), Some(3));
    let problems = crate::support::report(&out)["problems"].to_string();
    assert!(problems.contains("Read-only file system"), "{problems}");
    assert!(whole_poses(&world, &out) > 0);
}

/// The poses of the finished recordings, read from start to end.
fn whole_poses(world: &World, out: &Path) -> u64 {
    let files = fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path());
    let whole = files.filter(|path| path.extension().is_some_and(|end| end == "mcap"));
    let poses = |path: PathBuf| {
        let facts = world.output("recorder", &["facts", "--whole", path.to_str().unwrap()]);
        let facts: Value = serde_json::from_slice(&facts.stdout).unwrap_or_default();
        facts["poses"].as_u64().unwrap_or(0)
    };
    whole.map(poses).sum()
}

#[test]
fn a_volume_that_cannot_be_read_to_its_end_is_refused_with_the_reason() {
    if !can_trace() {
        return;
    }
    let world = World::new();
    let theatre = Theatre::new(&world);
    let file = world.path("patient.nii");
    fs::write(&file, Vec::from(Nifti::noise())).unwrap();
    theatre.ask(
        "volume-loader",
        &format!(
            "-f -o /dev/null -P {} -e inject=read,pread64:error=EIO:when=2+",
            file.display()
        ),
    );
    let scene = SMALL.replace("source = \"phantom\"\nspacing_mm = 6.0", "source = \"patient.nii\"");
    let mut command = theatre.command(&world, &world.file("s.toml", &scene), &world.path("out"));
    let output = command.args(["--for", "1s"]).output().unwrap();
    let said = crate::support::stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("patient.nii") && said.contains("Input/output error"),
        "{said}"
    );
}
