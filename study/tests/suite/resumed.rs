//! Whatever happens to the program, the lines are those of an unbroken run.

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::sync::OnceLock;
use std::time::Duration;

use crate::support::six;
use study::run::run;

fn lines(folder: &Path) -> String {
    fs::read_to_string(folder.join("operations.csv")).unwrap()
}

/// Of a run by one thread, done once.
fn unbroken() -> &'static str {
    static LINES: OnceLock<String> = OnceLock::new();
    LINES.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        run(&six(), folder.path(), 1).unwrap();
        lines(folder.path())
    })
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    run(&six(), folder.path(), 3).unwrap();
    let found = lines(folder.path());
    assert_eq!(found, unbroken());
    assert_eq!(found.lines().count(), 1 + 6 * 2);
}

/// Not a test: what [`killed_at_any_moment_it_goes_on_without_counting_twice`] starts and kills.
#[test]
#[ignore = "the child of another test"]
fn child() {
    if let Ok(out) = std::env::var("TROCAR_STUDY_OUT") {
        run(&six(), Path::new(&out), 2).unwrap();
    }
}

#[allow(clippy::disallowed_methods, reason = "a process is needed that can be killed")]
fn started(out: &Path) -> Child {
    let exe = std::env::current_exe().unwrap();
    let words = ["resumed::child", "--exact", "--ignored", "--test-threads=1"];
    Command::new(exe)
        .args(words)
        .env("TROCAR_STUDY_OUT", out)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn killed_at_any_moment_it_goes_on_without_counting_twice() {
    let folder = tempfile::tempdir().unwrap();
    let (mut killed, mut wait) = (0, 100);
    // 40 s of waiting at most.
    while wait < 10_000 {
        let mut child = started(folder.path());
        std::thread::sleep(Duration::from_millis(wait));
        if child.try_wait().unwrap().is_some_and(|status| status.success()) {
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        killed += 1;
        // Longer each time, by a part that falls on other moments.
        wait += wait / 3 + 7;
    }
    // On a machine that has other work too much of that may be left; what is done in the end counts.
    assert!(started(folder.path()).wait().unwrap().success());
    assert!(killed >= 3, "killed {killed} times only");
    assert_eq!(lines(folder.path()), unbroken());
}

/// As the kernel may leave a write of several lines.
#[test]
fn half_an_operation_is_done_again() {
    let folder = tempfile::tempdir().unwrap();
    run(&six(), folder.path(), 1).unwrap();
    let whole = lines(folder.path());
    let path = folder.path().join("operations.csv");
    // A file system may leave zeros where data did not arrive.
    for (cut, zeros) in [
        (whole.len() - 1, 0),
        (whole.len() - 1, 20_000),
        (whole.len() / 2, 20_000),
        (whole.len() / 3, 0),
        (200, 20_000),
        (10, 0),
        (0, 20_000),
    ] {
        fs::write(&path, [&whole.as_bytes()[..cut], &vec![0; zeros]].concat()).unwrap();
        run(&six(), folder.path(), 2).unwrap();
        assert_eq!(lines(folder.path()), whole, "cut at {cut}, {zeros} zeros");
    }
}

#[test]
fn a_folder_of_something_else_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = || run(&six(), folder.path(), 1).unwrap_err().to_string();
    fs::write(folder.path().join("letter.txt"), "Dear").unwrap();
    assert!(refused().contains("is not empty and holds no study"), "{}", refused());
    fs::remove_file(folder.path().join("letter.txt")).unwrap();
    run(&six(), folder.path(), 2).unwrap();
    let about = folder.path().join("study.json");
    let text = fs::read_to_string(&about).unwrap();
    for (from, to, words) in [
        (
            "\"version\": 5",
            "\"version\": 4",
            "found format \"trocar-study\", version 4",
        ),
        ("trocar-study", "other", "found format \"other\", version 5"),
        ("{", "", "found trailing characters"),
    ] {
        fs::write(&about, text.replacen(from, to, 1)).unwrap();
        assert!(refused().contains(words), "{}", refused());
    }
    let by_another = text.replacen("\"program\": \"", "\"program\": \"0.0.1 ", 1);
    fs::write(&about, by_another).unwrap();
    assert!(refused().contains("was begun by program 0.0.1 "), "{}", refused());
    fs::write(&about, &text).unwrap();
    let mut other = six();
    other.hash = "0123456789abcdef0123".to_owned();
    let error = run(&other, folder.path(), 1).unwrap_err().to_string();
    assert!(
        error.contains("is of another study") && error.contains("0123456789abcdef"),
        "{error}"
    );
    let whole = lines(folder.path());
    let path = folder.path().join("operations.csv");
    fs::write(&path, whole.replacen("arrived", "vanished", 1)).unwrap();
    assert!(refused().contains("line 2: its hash is "), "{}", refused());
    // What somebody else wrote, with hashes that fit.
    for (changed, words) in [
        (
            whole.replacen("a,1,", "a,2,", 1),
            "line 4: operation 2 of \"a\" does not come next",
        ),
        (whole.replacen("stratum", "layer", 1), "line 1: other columns"),
        (
            whole.clone() + whole.lines().last().unwrap() + "\n",
            "line 14: operation 2 of \"b\" does not come next",
        ),
        (whole.replacen("arrived", "vanished", 1), "how it ended is not known"),
        (
            whole.replacen("pre-aortic", "iliac-left", 1),
            "line 2: target \"iliac-left\" does not come next",
        ),
        (
            whole.replacen("\n", &format!("\n{}", "x".repeat(9000)), 1),
            "line 2: it is longer than 8192 bytes",
        ),
    ] {
        fs::write(&path, sealed(&changed)).unwrap();
        assert!(refused().contains(words), "{}", refused());
    }
}

/// The lines with the hashes that belong to them.
fn sealed(lines: &str) -> String {
    let line = |line: &str| match line.rsplit_once(',') {
        Some((text, _)) if !line.ends_with(",hash") => {
            format!("{text},{}\n", &blake3::hash(text.as_bytes()).to_hex()[..8])
        }
        _ => format!("{line}\n"),
    };
    lines.lines().map(line).collect()
}

/// Beads that were moved in a study's folder went into its operations: the folder's name is a hash of what the CT is made of alone.
#[test]
fn beads_that_were_changed_are_not_used_again() {
    let folder = tempfile::tempdir().unwrap();
    run(&six(), folder.path(), 1).unwrap();
    let whole = lines(folder.path());
    let images = fs::read_dir(folder.path().join("images")).unwrap();
    for image in images {
        let path = image.unwrap().path().join("beads.json");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replacen("0.", "3.", 1)).unwrap();
    }
    fs::write(folder.path().join("operations.csv"), "").unwrap();
    let refused = run(&six(), folder.path(), 1).unwrap_err().to_string();
    assert!(
        refused.contains("beads.json was changed after it was written"),
        "{refused}"
    );
    fs::remove_dir_all(folder.path().join("images")).unwrap();
    run(&six(), folder.path(), 2).unwrap();
    assert_eq!(lines(folder.path()), whole);
}

#[test]
fn two_programs_do_not_write_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    run(&six(), folder.path(), 2).unwrap();
    let held = fs::File::open(folder.path().join("study.json")).unwrap();
    held.lock().unwrap();
    let error = run(&six(), folder.path(), 1).unwrap_err().to_string();
    assert!(error.contains("another program is working in this folder"), "{error}");
}

/// A disk that fails says nothing of an operation: there is no line of it, and the study goes on once the disk is well.
#[test]
fn what_the_machine_cannot_is_no_refusal() {
    let folder = tempfile::tempdir().unwrap();
    let images = folder.path().join("images");
    let none = six();
    let empty = study::plan::Plan {
        strata: Vec::new(),
        ..none.clone()
    };
    run(&empty, folder.path(), 1).unwrap();
    // A file in the place of a folder.
    fs::write(&images, "").unwrap();
    let error = run(&none, folder.path(), 1).unwrap_err().to_string();
    assert!(error.contains("ct: ") && error.contains("os error"), "{error}");
    assert_eq!(lines(folder.path()).lines().count(), 1);
    fs::remove_file(&images).unwrap();
    run(&none, folder.path(), 1).unwrap();
    assert_eq!(lines(folder.path()), unbroken());
}
