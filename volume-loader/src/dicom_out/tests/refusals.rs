//! What is refused, and that nothing is left then.

use std::fs;

use super::*;

const PLAIN: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn refused(folder: &Path, mut source: Made) -> String {
    write(folder, &mut source, &Options::default()).unwrap_err().to_string()
}

#[test]
fn a_folder_with_something_in_it() {
    let tmp = tempfile::tempdir().unwrap();
    fs::write(tmp.path().join("mine.txt"), "mine").unwrap();
    let said = refused(tmp.path(), Made::boxed());
    assert!(said.contains("not empty (it holds mine.txt)"), "{said}");
    let said = refused(&tmp.path().join("mine.txt"), Made::boxed());
    assert!(said.contains("this is a file"), "{said}");
    let said = refused(&tmp.path().join("no/such/folder"), Made::boxed());
    assert!(said.contains("make a new folder beside it"), "{said}");
    assert_eq!(files(tmp.path()).len(), 1);
}

#[test]
fn an_empty_folder_is_filled() {
    let tmp = tempfile::tempdir().unwrap();
    write(tmp.path(), &mut Made::boxed(), &Options::default()).unwrap();
    assert_eq!(files(tmp.path()).len(), 4);
    let (empty, link) = (tmp.path().join("empty"), tmp.path().join("link"));
    fs::create_dir(&empty).unwrap();
    std::os::unix::fs::symlink(&empty, &link).unwrap();
    write(&link.join("."), &mut Made::boxed(), &Options::default()).unwrap();
    assert_eq!((files(&empty).len(), files(tmp.path()).len()), (4, 6));
    fs::remove_dir_all(&empty).unwrap();
    fs::remove_file(&link).unwrap();
    let said = refused(tmp.path(), Made::boxed());
    assert!(said.contains("not empty (it holds IM000"), "{said}");
}

#[test]
fn slanted_rows() {
    let tmp = tempfile::tempdir().unwrap();
    let folder = tmp.path().join("s");
    let mut slanted = PLAIN;
    slanted[0][1] = 2e-5;
    let said = refused(&folder, Made::new([2, 2, 2], slanted));
    assert!(said.contains("89.9989 degrees"), "{said}");
    slanted[0][1] = 0.9e-5;
    write(&folder, &mut Made::new([2, 2, 2], slanted), &Options::default()).unwrap();
    assert_eq!(files(tmp.path()), [folder]);
}

#[test]
fn a_source_that_fails_leaves_nothing() {
    let tmp = tempfile::tempdir().unwrap();
    let mut source = Made::boxed();
    source.fails_at = Some(2);
    let said = refused(&tmp.path().join("s"), source);
    assert!(said.contains("not written: made: there is no such file"), "{said}");
    assert_eq!(files(tmp.path()).len(), 0);
}
