//! The scene as a recording carries it.

use std::fs;
use std::io;
use std::path::Path;
use std::time::UNIX_EPOCH;

/// The text of the scene at `path` and its wall-clock time, ns since 1970; without whose examination it is, unless that is to be
/// `named`.
///
/// # Errors
/// Those of reading it.
pub(crate) fn read(path: &Path, named: bool) -> io::Result<(String, u64)> {
    let text = fs::read_to_string(path)?;
    let changed = fs::metadata(path)?.modified()?;
    let since_1970 = changed.duration_since(UNIX_EPOCH).unwrap_or_default();
    let text = if named { text } else { unnamed(text) };
    Ok((text, u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)))
}

/// The same scene without its `[identity]`. One that has none stays as it is, to the letter; what is no TOML says nothing that a
/// process of the run could have read, and is left out.
fn unnamed(text: String) -> String {
    let Ok(mut table) = text.parse::<toml::Table>() else {
        return String::new();
    };
    match table.remove(scene::identity::TABLE) {
        // Comments may name the patient as well: they go with the text.
        Some(_) => toml::to_string(&table).unwrap_or_default(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Scene;

    #[test]
    fn the_scene_is_the_same_without_its_words_on_the_patient() {
        let rest = "seed = 7\n[[targets]]\nname = \"n\"\nct_mm = [1, 2, 3]\n[recording]\nchunk_s = 0.25\n";
        let named = format!("# of SECRET\n{rest}[identity]\nname = \"SECRET^A\"\npatient_id = \"S\\u0045CRET\"\n");
        let text = unnamed(named.clone());
        assert!(!text.contains("SECRET") && !text.contains("identity"), "{text}");
        let parsed = |text: &str| Scene::parse(text, Path::new("s.toml")).unwrap();
        assert_eq!(parsed(&text), parsed(rest));
        assert_eq!(unnamed(rest.to_owned()), rest);
        // However the table is written.
        for text in [
            "identity.name = \"SECRET\"",
            "identity = { name = \"SECRET\" }",
            "[\"identity\"]\nname = 'SECRET'",
        ] {
            assert_eq!(unnamed(text.to_owned()), "", "{text}");
        }
        assert_eq!(unnamed("[identity\nname = \"SECRET\"".to_owned()), "");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        fs::write(&path, &named).unwrap();
        assert_eq!(read(&path, true).unwrap().0, named);
        assert_eq!(read(&path, false).unwrap().0, text);
    }
}
