//! Files that the scene names and that a recording keeps a copy of: calibrations, registrations.

use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// A longer file is no calibration.
pub(crate) const MAX_BYTES: u64 = 4 << 20;
/// More of them are not attached.
const MAX_FILES: usize = 32;

/// A file to attach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Beside {
    /// Its name in the recording: that of the file, without its folder.
    pub name: String,
    /// Its kind.
    pub media_type: &'static str,
    /// Its content.
    pub bytes: Vec<u8>,
    /// When it was changed last, ns since 1970.
    pub changed_ns: u64,
}

/// The JSON files that the text of a scene names, under whatever key; relative ones lie in `folder`.
pub(crate) fn named_files(text: &str, folder: &Path) -> Vec<PathBuf> {
    let Ok(mut table) = text.parse::<toml::Table>() else {
        return Vec::new();
    };
    // Whatever a patient is called, it is no file.
    table.remove(scene::identity::TABLE);
    let mut names = Vec::new();
    table.values().for_each(|value| collect(value, &mut names));
    names.sort();
    names.dedup();
    names
        .into_iter()
        .take(MAX_FILES)
        .map(|name| folder.join(name))
        .collect()
}

fn collect(value: &toml::Value, names: &mut Vec<String>) {
    match value {
        toml::Value::String(text) if text.to_ascii_lowercase().ends_with(".json") => names.push(text.clone()),
        toml::Value::Array(values) => values.iter().for_each(|value| collect(value, names)),
        toml::Value::Table(table) => table.values().for_each(|value| collect(value, names)),
        _ => {}
    }
}

/// Reads a file to attach.
///
/// # Errors
/// Those of reading it; [`io::ErrorKind::FileTooLarge`] beyond [`MAX_BYTES`].
pub(crate) fn read(path: &Path) -> io::Result<Beside> {
    let (file, facts) = scene::file::open(path)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        let why = format!("it has more than {MAX_BYTES} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, why));
    }
    let since_1970 = facts.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok(Beside {
        name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        media_type: media_type(path),
        bytes,
        changed_ns: u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX),
    })
}

fn media_type(path: &Path) -> &'static str {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("json") => "application/json",
        Some("toml") => "application/toml",
        Some("png") => "image/png",
        Some("csv") => "text/csv",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    #[test]
    fn json_files_are_found_under_every_key() {
        let scene = "[tracker.calibration]\nfile = \"tool.json\"\n[tracker.registration]\nfile = \"/r/r.JSON\"\n\
                     [volume]\nsource = \"ct.nii\"\n[identity]\nname = \"patient.json\"\n[[more]]\nfile = \"tool.json\"\nlist = [\"a.json\", 3]";
        let expected = ["/r/r.JSON", "/s/a.json", "/s/tool.json"].map(PathBuf::from);
        assert_eq!(named_files(scene, Path::new("/s")), expected);
        assert!(named_files("no = toml = at all", Path::new("/s")).is_empty());
    }

    #[test]
    fn files_are_read_with_their_kind_and_long_ones_refused() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("tool.json");
        fs::write(&path, "{}").unwrap();
        let found = read(&path).unwrap();
        assert_eq!(
            (found.name.as_str(), found.media_type, found.bytes.as_slice()),
            ("tool.json", "application/json", &b"{}"[..])
        );
        File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("more than"));
        assert!(read(tmp.path()).is_err());
    }
}
