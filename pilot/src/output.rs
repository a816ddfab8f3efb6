//! The folder that a run writes into.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The recording's file name.
pub(crate) const SESSION: &str = "session.mcap";
/// That of poses that were made again in a replay.
pub(crate) const RECOMPUTED: &str = "recomputed.mcap";

/// Behind the name of a file that is being replaced.
const REPLACED: &str = ".replaced";

/// Why a folder cannot be written into.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    #[error("output folder {path}: {source}. Name a folder that you may write into, with `--out DIR`")]
    NotWritable { path: PathBuf, source: io::Error },
    #[error(
        "output folder {path} holds a recorded session ({SESSION}). Name another folder with `--out DIR`, or replace \
         the session with `--overwrite`"
    )]
    HoldsSession { path: PathBuf },
}

/// Prepares `dir`: it exists, can be written into, and holds nothing of an earlier run that could be taken for this one's
/// (`pictures` are the names of this one's). Nobody else's file is touched.
pub(crate) fn prepare(dir: &Path, pictures: &[String], overwrite: bool) -> Result<Replaced, OutputError> {
    let fail = |source| OutputError::NotWritable {
        path: dir.to_owned(),
        source,
    };
    fs::create_dir_all(dir).map_err(fail)?;
    let probe = dir.join(".trocar-probe");
    fs::write(&probe, b"x")
        .and_then(|()| fs::remove_file(&probe))
        .map_err(fail)?;
    let names = fs::read_dir(dir).map_err(fail)?.flatten().map(|entry| entry.path());
    let old: Vec<PathBuf> = names.filter(|path| is_ours(path, pictures)).collect();
    if !overwrite && old.iter().any(|path| is_session(path)) {
        return Err(OutputError::HoldsSession { path: dir.to_owned() });
    }
    Replaced::set_aside(old).map_err(fail)
}

/// What an earlier run left, set aside until the new one has something to put in its place.
#[derive(Debug, Default)]
pub(crate) struct Replaced(Vec<(PathBuf, PathBuf)>);

impl Replaced {
    fn set_aside(files: Vec<PathBuf>) -> io::Result<Self> {
        let mut pairs = Vec::new();
        for path in files {
            let aside = match is_aside(&path) {
                // A pilot that was killed had set it aside: it stays where it is until a run comes to its end.
                true => path.clone(),
                false => free_name(&path),
            };
            fs::rename(&path, &aside)?;
            pairs.push((aside, path));
        }
        Ok(Self(pairs))
    }

    /// The new run failed: everything is as it was.
    pub(crate) fn restore(self) {
        for (aside, path) in self.0 {
            // A failure leaves the file under its other name, which says what it is.
            let _ = fs::rename(aside, path);
        }
    }

    /// The new run has written its own.
    pub(crate) fn discard(self) {
        for (aside, _) in self.0 {
            let _ = fs::remove_file(aside);
        }
    }
}

/// Whether a file was set aside, by this pilot or by one that was killed.
fn is_aside(path: &Path) -> bool {
    name(path).contains(REPLACED)
}

/// A name beside `path` that nobody has: `.replaced`, or with a number behind it where killed pilots left theirs.
fn free_name(path: &Path) -> PathBuf {
    let numbered = |n: u64| match n {
        1 => PathBuf::from(format!("{}{REPLACED}", path.display())),
        n => PathBuf::from(format!("{}{REPLACED}-{n}", path.display())),
    };
    let mut names = (1..).map(numbered);
    names.find(|name| !name.exists()).unwrap_or_else(|| numbered(1))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn is_session(path: &Path) -> bool {
    is_part(path, SESSION)
}

/// Whether a file is the recording `of`, or a part of it: finished or not, set aside or not.
fn is_part(path: &Path, of: &str) -> bool {
    let stem = of.trim_end_matches("mcap");
    name(path).starts_with(stem) && name(path).contains("mcap")
}

/// Also what a pilot that was killed had set aside.
fn is_ours(path: &Path, pictures: &[String]) -> bool {
    let name = name(path);
    let name = name.split(REPLACED).next().unwrap_or_default();
    is_session(path)
        || is_part(path, RECOMPUTED)
        || name == "report.json"
        || pictures.iter().any(|picture| picture == name)
}

/// The files of the recording `of` ([`SESSION`] or [`RECOMPUTED`]) that a run left in `dir`, by name.
pub(crate) fn recordings(dir: &Path, of: &str) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(dir)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| is_part(path, of) && !is_aside(path))
        .map(|path| name(&path))
        .collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recorded_session_is_not_overwritten_unasked() {
        let tmp = tempfile::tempdir().unwrap();
        fs::write(tmp.path().join("session.mcap"), b"x").unwrap();
        fs::write(tmp.path().join("sheet.png"), b"x").unwrap();
        fs::write(tmp.path().join("holiday.png"), b"x").unwrap();
        let pictures = ["sheet.png".to_owned()];
        assert!(matches!(
            prepare(tmp.path(), &pictures, false),
            Err(OutputError::HoldsSession { .. })
        ));
        assert!(tmp.path().join("sheet.png").exists());
        let replaced = prepare(tmp.path(), &pictures, true).unwrap();
        assert!(!tmp.path().join("session.mcap").exists());
        replaced.restore();
        assert!(tmp.path().join("session.mcap").exists() && tmp.path().join("sheet.png").exists());
        fs::write(tmp.path().join("sheet.png.replaced"), b"x").unwrap();
        prepare(tmp.path(), &pictures, true).unwrap().discard();
        let left: Vec<_> = fs::read_dir(tmp.path())
            .unwrap()
            .flatten()
            .map(|e| e.file_name())
            .collect();
        assert_eq!(left, ["holiday.png"]);
    }

    /// Names once grew by `.replaced` with each killed pilot, until the file system took them no more.
    #[test]
    fn killed_pilots_leave_names_of_one_length_and_the_next_whole_run_removes_them() {
        let tmp = tempfile::tempdir().unwrap();
        let names = || {
            let entries = fs::read_dir(tmp.path()).unwrap().flatten();
            let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
            names.sort();
            names
        };
        for round in 0..300 {
            fs::write(tmp.path().join("session.mcap"), round.to_string()).unwrap();
            // Its pilot is killed: what it set aside is neither restored nor discarded.
            let _ = prepare(tmp.path(), &[], true).unwrap();
        }
        assert_eq!(names().len(), 300);
        assert!(
            names()
                .iter()
                .all(|name| name.len() <= "session.mcap.replaced-300".len())
        );
        assert!(recordings(tmp.path(), SESSION).is_empty());
        fs::write(tmp.path().join("session.mcap"), "last").unwrap();
        prepare(tmp.path(), &[], true).unwrap().restore();
        assert_eq!(fs::read_to_string(tmp.path().join("session.mcap")).unwrap(), "last");
        prepare(tmp.path(), &[], true).unwrap().discard();
        assert!(names().is_empty(), "{:?}", names());
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let text = prepare(Path::new("/proc/trocar"), &[], false).unwrap_err().to_string();
        assert!(text.contains("/proc/trocar") && text.contains("--out DIR"), "{text}");
    }
}
