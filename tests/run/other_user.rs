//! Another user of the same machine can neither stop a run, nor change what it shows, nor read a patient's files.

#![allow(clippy::disallowed_methods, reason = "the attacker is a shell of another user")]
#![allow(clippy::print_stderr, reason = "a test that is skipped says so")]

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{Pilot, SMALL, World, kill_9, wait_for};
use bus::run::{RunContext, SHM_DIR};

/// Nobody's, on Debian.
const OTHER: u32 = 65_534;

/// Only root may become somebody else.
fn is_root() -> bool {
    let root = rustix::process::getuid().is_root();
    if !root {
        eprintln!("skipped: only root can play another user");
    }
    root
}

/// What another user gets done with a shell.
fn as_another(script: &str) -> bool {
    let mut shell = Command::new("sh");
    shell.args(["-c", script]).uid(OTHER).gid(OTHER).current_dir("/");
    shell.stderr(std::process::Stdio::null()).status().unwrap().success()
}

fn start(world: &World) -> Pilot<'_> {
    let scene = world.file("s.toml", SMALL);
    let pilot = world.start(&scene, &world.path("out"), "default");
    pilot.wait_live();
    pilot
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![folder.to_owned()];
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type().unwrap().is_dir() {
            true => found.extend(files_below(&entry.path())),
            false => found.push(entry.path()),
        }
    }
    found
}

fn shared_memory(world: &World) -> Vec<PathBuf> {
    let prefix = RunContext::new(&world.run_dir("default"), 0).unwrap().folder_prefix();
    let entries = fs::read_dir(SHM_DIR).unwrap().flatten();
    let ours = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    ours.map(|entry| entry.path()).collect()
}

#[test]
fn no_file_of_a_run_is_open_to_others() {
    let world = World::new();
    let pilot = start(&world);
    let mut all = files_below(&world.run_dir("default"));
    all.extend(files_below(&world.path("out")));
    let shared = shared_memory(&world);
    assert!(shared.len() > 20, "{shared:?}");
    all.extend(shared);
    // Some come and go with clients.
    let open: Vec<_> = all
        .iter()
        .filter_map(|path| Some((path, fs::symlink_metadata(path).ok()?.mode() & 0o7777)))
        .filter(|(path, mode)| mode & 0o077 != 0 && !is_within_closed(path, &world.run_dir("default")))
        .collect();
    assert!(open.is_empty(), "{open:?}");
    assert_eq!(fs::metadata(world.run_dir("default")).unwrap().mode() & 0o777, 0o700);
    assert!(pilot.stop().success());
    for path in files_below(&world.path("out")) {
        let mode = fs::metadata(&path).unwrap().mode() & 0o777;
        assert_eq!(mode & 0o077, 0, "{} {mode:o}", path.display());
    }
}

/// Below the run's folder, which lets nobody through, iceoryx2's folders have modes of its own.
fn is_within_closed(path: &Path, run_dir: &Path) -> bool {
    path != run_dir && path.starts_with(run_dir)
}

/// Sixteen bytes of 0xff in the one segment that is made for everybody stopped `status`, `stop` and every recovery.
#[test]
fn another_user_stops_nothing() {
    if !is_root() {
        return;
    }
    let world = World::new();
    let pilot = start(&world);
    for file in shared_memory(&world) {
        let file = file.display();
        assert!(
            !as_another(&format!("test -e {file} && printf x >> {file}")),
            "{file} was written"
        );
        assert!(!as_another(&format!("rm {file}")), "{file} was removed");
    }
    let run = world.run_dir("default");
    for name in ["run.json", "scene.toml", "lock", "began"] {
        assert!(
            !as_another(&format!("cat {}", run.join(name).display())),
            "{name} was read"
        );
    }
    // And who was killed comes back.
    let victim = wait_for("the renderer", || pilot.pid("view-axial"));
    kill_9(victim);
    wait_for("another renderer", || {
        pilot.pid("view-axial").filter(|&pid| pid != victim)
    });
    pilot.wait_live();
    assert_eq!(pilot.stop().code(), Some(3));
}

/// The name was known beforehand: whoever made a file of it first kept the run from starting.
#[test]
fn files_that_another_user_makes_first_stop_no_start() {
    if !is_root() {
        return;
    }
    let world = World::new();
    let prefix = RunContext::new(&world.run_dir("default"), 0).unwrap().folder_prefix();
    let name = format!("{SHM_DIR}/{prefix}_node.0_10_0.global_mgmt");
    assert!(as_another(&format!(
        "printf 0123456789abcdef > {name}; chmod 666 {name}"
    )));
    let pilot = start(&world);
    assert!(pilot.stop().success());
    fs::remove_file(name).ok();
}

#[test]
fn a_run_folder_that_others_could_exchange_is_refused() {
    if !is_root() {
        return;
    }
    let world = World::new();
    let scene = world.file("s.toml", SMALL);
    let refused = |words: &str| {
        let arguments = ["run", scene.to_str().unwrap(), "--for", "500ms", "--out"];
        let out = world.path("out");
        let output = world.output("pilot", &[&arguments[..], &[out.to_str().unwrap()]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(words), "{said}");
    };
    // The folder of all runs is another's; so is the run's own; others may write into the one above.
    let runs = world.path("r");
    fs::create_dir_all(&runs).unwrap();
    chown(&runs, Some(OTHER), Some(OTHER)).unwrap();
    refused("belongs to user 65534");
    chown(&runs, Some(0), Some(0)).unwrap();
    fs::create_dir_all(runs.join("default")).unwrap();
    chown(runs.join("default"), Some(OTHER), Some(OTHER)).unwrap();
    refused("belongs to user 65534");
    fs::remove_dir_all(runs.join("default")).unwrap();
    fs::set_permissions(&runs, fs::Permissions::from_mode(0o777)).unwrap();
    refused("others may write into it");
    fs::set_permissions(&runs, fs::Permissions::from_mode(0o700)).unwrap();
    fs::remove_dir_all(runs.join("default")).unwrap();
    // A link to a folder of one's own, which stays as it is.
    let elsewhere = world.path("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    fs::set_permissions(&elsewhere, fs::Permissions::from_mode(0o755)).unwrap();
    std::os::unix::fs::symlink(&elsewhere, runs.join("default")).unwrap();
    refused("no folder");
    assert_eq!(fs::metadata(&elsewhere).unwrap().mode() & 0o777, 0o755);
    // And `status` believes no `run.json` in such a folder.
    let output = world.output("pilot", &["status"]);
    assert!(!output.status.success());
}

/// `pilot status` opened whatever bore the lock's name, and waited for whoever would write into a pipe.
#[test]
fn a_pipe_in_a_folder_that_another_user_made_holds_up_no_status() {
    if !is_root() {
        return;
    }
    let world = World::new();
    let dir = world.run_dir("default");
    fs::create_dir_all(&dir).unwrap();
    chown(&dir, Some(OTHER), Some(OTHER)).unwrap();
    let lock = dir.join("lock");
    fs::set_permissions(world.path("."), fs::Permissions::from_mode(0o755)).unwrap();
    assert!(as_another(&format!("mkfifo {}", lock.display())));
    let said = world.output("pilot", &["status"]);
    assert!(
        String::from_utf8_lossy(&said.stderr).contains("is not going"),
        "{said:?}"
    );
}

/// Whoever exchanged scene or registration and killed a renderer was shown the new ones as LIVE.
#[test]
fn an_exchanged_scene_is_no_run_of_this_pilot() {
    let world = World::new();
    let scene = world.file("s.toml", &SMALL.replace("[limits]", "[limits]\nrestarts = 1"));
    let pilot = world.start(&scene, &world.path("out"), "default");
    pilot.wait_live();
    let path = world.run_dir("default").join("scene.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("seed = 1", "seed = 2")).unwrap();
    kill_9(wait_for("the tracker", || pilot.pid("tracker")));
    let status = pilot.wait_held("tracker", |_| true);
    assert_eq!(status["pose"]["state"], "tracker silent");
    assert_eq!(pilot.stop().code(), Some(3));
}
