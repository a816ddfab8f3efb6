//! `pilot new`: a scene to begin with, every key in it with what it does.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use crate::resolve::{ResolveError, volume_path};

/// The shipped file; as it stands, it leaves every key at its default.
const TEMPLATE: &str = include_str!("../../../config/template.toml");
/// The line of it that says where the examination comes from.
const SOURCE: &str = "source = \"phantom\"";

pub(crate) const NEW_HELP: &str = "\
Examples:
  pilot new scene.toml                          the generated patient, to begin with
  pilot new scene.toml --volume /data/ct-17     your CT: a folder with a DICOM series, or a file
  pilot new                                     the same on stdout
  pilot check scene.toml                        what it would start, or all that is wrong with it";

/// Where the scene goes, and what it is of.
#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// The file to write; without one, the scene is printed. A file that exists is refused.
    file: Option<PathBuf>,
    /// The examination: a folder with a DICOM series, or a file; written as an absolute path.
    #[arg(long, value_name = "PATH")]
    volume: Option<String>,
}

/// Why there is no new scene.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NewError {
    #[error(transparent)]
    Volume(#[from] ResolveError),
    #[error("writing {path}: {source}; a scene that exists is not replaced")]
    Write { path: PathBuf, source: std::io::Error },
}

impl NewArgs {
    /// Writes the scene; what is to be said on stdout.
    pub(crate) fn carry_out(&self) -> Result<String, NewError> {
        let text = match self.volume.as_deref() {
            None => TEMPLATE.to_owned(),
            // From where the command is given, as with `pilot run --volume`; a scene's own paths count from its folder.
            Some(path) => of_volume(&volume_path(path)?),
        };
        let Some(path) = &self.file else {
            return Ok(text.trim_end().to_owned());
        };
        let fail = |source| NewError::Write {
            path: path.clone(),
            source,
        };
        let mut file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(path)
            .map_err(fail)?;
        file.write_all(text.as_bytes()).map_err(fail)?;
        let path = path.display();
        Ok(format!(
            "{path}: a scene with every key explained; next: pilot check {path}"
        ))
    }
}

/// The template, of another examination.
fn of_volume(path: &str) -> String {
    TEMPLATE.replacen(SOURCE, &format!("source = {}", toml_string(path)), 1)
}

/// A basic string of TOML: JSON's escapes are among its own, but for the one of DEL, which JSON leaves as it is.
fn toml_string(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007F")
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::raw::{RawScene, parse};
    use std::path::Path;

    fn parsed(text: &str) -> RawScene {
        let path = Path::new("scene.toml");
        scene::Scene::parse(text, path).unwrap();
        parse(text, path).unwrap().scene
    }

    fn defaults() -> RawScene {
        parse("[recording]", Path::new("scene.toml")).unwrap().scene
    }

    /// Takes away the `#` before keys with the value that is the default, or before the examples too.
    fn uncommented(examples: bool) -> String {
        let is_key = |line: &str| line.chars().next().is_some_and(|c| c.is_ascii_lowercase() || c == '[');
        let is_example = |line: &str| is_key(line) && (line.starts_with('[') || line.contains(" = "));
        let line = |line: &str| match line.strip_prefix('#') {
            Some(rest) if is_key(rest) => rest.to_owned(),
            Some(rest) if examples && is_example(rest.trim_start()) => rest.trim_start().to_owned(),
            _ => line.to_owned(),
        };
        TEMPLATE.lines().map(|l| line(l) + "\n").collect()
    }

    #[test]
    fn every_key_has_the_value_shown() {
        assert_eq!(parsed(TEMPLATE), defaults());
        let shown = uncommented(false);
        assert!(
            shown.lines().filter(|line| !line.starts_with('#')).count() > 45,
            "{shown}"
        );
        assert_eq!(parsed(&shown), defaults());
    }

    /// Each key that a scene of defaults has is in the template.
    #[test]
    fn no_key_is_left_out() {
        let shown = uncommented(false);
        let all = parse("[recording]", Path::new("scene.toml")).unwrap().to_toml();
        let keys = |text: &str| -> Vec<String> {
            let lines = text.lines().filter_map(|line| line.split_once(" = "));
            lines.map(|(key, _)| key.to_owned()).collect()
        };
        let there = keys(&shown);
        let missing: Vec<_> = keys(&all).into_iter().filter(|key| !there.contains(key)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn examples_are_good_scenes_too() {
        let all = uncommented(true);
        // One of three; files that are not there; and a source that takes files.
        let left_out = [
            "box_mm",
            "box_voxels",
            "[tracker.calibration]",
            "file = ",
            "[tracker.registration]",
            "[steps]",
            "calibrate = ",
            "drawing = ",
            "points = ",
            "beads = ",
            "check_points = ",
            "turn_s = ",
            "touch_s = ",
        ];
        let mut text: String = all
            .lines()
            .filter(|line| !left_out.iter().any(|word| line.starts_with(word)))
            .map(|line| format!("{line}\n"))
            .collect();
        text = text
            .replacen(SOURCE, "source = \"ct\"", 1)
            .replacen("spacing_mm", "#spacing_mm", 1);
        let scene = parsed(&text);
        assert_eq!(scene.targets.unwrap().len(), 1);
        assert_eq!(scene.views.unwrap()[0].field_mm, 100.0);
        assert_eq!(scene.volume.region.unwrap().margin_mm, Some(40.0));
    }

    #[test]
    fn any_path_of_an_examination_comes_back() {
        for path in ["/data/ct 17", "a\"b\\c\n\u{7f}\u{1b}", "é.nii.gz"] {
            let text = of_volume(path);
            let raw: RawScene = toml::from_str(&text).unwrap();
            assert_eq!(raw.volume.source, path);
        }
    }

    #[test]
    fn an_examination_that_is_not_there_is_refused() {
        let new = NewArgs {
            file: None,
            volume: Some("nowhere.nii".to_owned()),
        };
        let refused = new.carry_out().unwrap_err().to_string();
        assert!(refused.contains("nowhere.nii: there is no such file"), "{refused}");
    }

    #[test]
    fn a_scene_that_exists_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let new = NewArgs {
            file: Some(folder.path().join("scene.toml")),
            volume: None,
        };
        assert!(new.carry_out().unwrap().contains("pilot check"));
        let refused = new.carry_out().unwrap_err().to_string();
        assert!(refused.contains("is not replaced"), "{refused}");
    }
}
