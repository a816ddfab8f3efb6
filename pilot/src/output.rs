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
        let aside = |path: &PathBuf| PathBuf::from(format!("{}{REPLACED}", path.display()));
        let pairs: Vec<_> = files.into_iter().map(|path| (aside(&path), path)).collect();
        pairs.iter().try_for_each(|(aside, path)| fs::rename(path, aside))?;
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
    let name = name.strip_suffix(REPLACED).unwrap_or(&name);
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
        .filter(|path| is_part(path, of))
        .map(|path| name(&path))
        .filter(|name| !name.ends_with(REPLACED))
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

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let text = prepare(Path::new("/proc/trocar"), &[], false).unwrap_err().to_string();
        assert!(text.contains("/proc/trocar") && text.contains("--out DIR"), "{text}");
    }
}
