//! The run folder, its facts and its lock.

use super::*;

#[test]
fn names_cannot_leave_their_folder() {
    for bad in ["", "..", "a/b", "A", "a b", "a.b", &"x".repeat(25)] {
        assert!(matches!(run_dir(bad), Err(RunError::Name(_))), "{bad}");
    }
    assert!(run_dir("theatre-2").unwrap().ends_with("theatre-2"));
}

#[test]
fn one_pilot_a_run() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path().join("demo");
    let lock = RunLock::acquire(&dir).unwrap();
    assert!(RunLock::is_held(&dir));
    let text = RunLock::acquire(&dir).unwrap_err().to_string();
    assert!(text.contains("\"demo\" is already going"), "{text}");
    assert!(text.contains(&std::process::id().to_string()), "{text}");
    drop(lock);
    assert!(!RunLock::is_held(&dir));
    assert!(RunLock::acquire(&dir).is_ok());
}

/// `pilot status` in a loop could have a start refused as "already going".
#[test]
fn who_only_looks_does_not_keep_a_pilot_out() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path().join("demo");
    drop(RunLock::acquire(&dir).unwrap());
    let (looker, _) = file::open(&dir.join("lock")).unwrap();
    flock(&looker, FlockOperation::NonBlockingLockShared).unwrap();
    let looking = std::thread::spawn(move || {
        std::thread::sleep(3 * BETWEEN_LOOKS);
        drop(looker);
    });
    assert!(RunLock::acquire(&dir).is_ok());
    looking.join().unwrap();
}

/// `pilot status` asked the bus of a pilot that had been killed, and waited 15 s for its answer, while the next one was there.
#[test]
fn a_run_without_its_pilot_and_its_successor_are_told_apart() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path().join("demo");
    let lock = RunLock::acquire(&dir).unwrap();
    let [first, next] = [1, 2].map(|epoch_ns| RunContext::new(&dir, epoch_ns).unwrap());
    assert!(!first.is_running());
    first.store().unwrap();
    assert!(first.is_running() && !next.is_running());
    next.remove_facts();
    assert!(!first.is_running());
    next.store().unwrap();
    assert!(next.is_running() && !first.is_running());
    drop(lock);
    assert!(!next.is_running());
}

#[test]
fn facts_come_back_and_a_missing_run_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let nowhere = RunContext::load(&tmp.path().join("nowhere"));
    assert!(matches!(nowhere, Err(RunError::NotRunning { .. })));
    let dir = tmp.path().join("demo");
    own::make(&dir).unwrap();
    let context = RunContext::new(&dir, 42).unwrap();
    assert!(matches!(RunContext::load(&dir), Err(RunError::NotRunning { .. })));
    context.store().unwrap();
    assert_eq!(RunContext::load(&dir).unwrap(), context);
}

/// Another user who makes a file of that name first would keep a run from starting.
#[test]
fn the_names_in_shared_memory_cannot_be_guessed_and_are_swept_all_the_same() {
    let tmp = tempfile::tempdir().unwrap();
    let [one, other] = [0, 0].map(|_| RunContext::new(tmp.path(), 0).unwrap());
    assert_ne!(one.prefix(), other.prefix());
    assert_eq!(one.folder_prefix(), other.folder_prefix());
    assert!(one.prefix().starts_with(&other.folder_prefix()) && one.prefix().len() == 12);
    let left = Path::new(SHM_DIR).join(format!("{}_left", one.prefix()));
    fs::write(&left, b"x").unwrap();
    other.sweep();
    assert!(!left.exists());
}

#[test]
fn files_that_were_exchanged_are_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path().join("demo");
    own::make(&dir).unwrap();
    let mut context = RunContext::new(&dir, 0).unwrap();
    context.store().unwrap();
    context.store_scene("seed = 1").unwrap();
    let hash = context.facts_hash("seed = 1");
    let load = || RunContext::load_with_scene(&dir, Some(&hash));
    assert_eq!(load().unwrap(), (context.clone(), "seed = 1".to_owned()));
    context.store_scene("seed = 2").unwrap();
    assert!(matches!(load(), Err(RunError::Changed { .. })));
    context.store_scene("seed = 1").unwrap();
    load().unwrap();
    context.epoch_ns = 1;
    context.store().unwrap();
    assert!(matches!(load(), Err(RunError::Changed { .. })));
    // Somebody who starts a process by hand takes the run as it is.
    assert!(RunContext::load_with_scene(&dir, None).is_ok());
}

/// `pilot status` waited for ever for whoever would write into it.
#[test]
fn a_pipe_in_place_of_the_lock_holds_nobody_up() {
    let tmp = tempfile::tempdir().unwrap();
    let pipe = tmp.path().join("lock");
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR).unwrap();
    assert!(!RunLock::is_held(tmp.path()));
}

#[test]
fn the_end_of_a_duration_belongs_to_it_no_more() {
    let mut context = RunContext::new(Path::new("/tmp/r"), 0).unwrap();
    assert!(!context.is_beyond(i64::MAX));
    context.duration_ns = Some(1_500);
    assert_eq!([1_499, 1_500].map(|ns| context.is_beyond(ns)), [false, true]);
}

#[test]
fn long_paths_are_refused_before_a_socket_fails() {
    let long = PathBuf::from(format!("/tmp/{}", "x".repeat(60)));
    assert!(matches!(RunContext::new(&long, 0), Err(RunError::TooLong(_))));
}
