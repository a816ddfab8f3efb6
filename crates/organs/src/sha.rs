//! SHA-256 of files, as `sha256sum` prints it, and the label map that a scene names by it.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::numbers::{Checked, invalid};

/// Headers whose voxels lie in another file, by their ending.
const DETACHED: [&str; 4] = ["mhd", "nhdr", "hdr", "img"];
/// Readers of volumes take no longer header, bytes.
const MAX_HEAD: u64 = 1 << 20;

/// Of bytes: 64 hexadecimal digits in lower case.
pub fn of(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

/// Of a file; `None` of what is no file, as a folder of images.
///
/// # Errors
/// What reading it says.
pub fn of_file(path: &Path) -> io::Result<Option<String>> {
    if !path.is_file() {
        return Ok(None);
    }
    let (mut file, mut hash) = (File::open(path)?, Sha256::new());
    let mut bytes = vec![0; 1 << 16];
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(Some(hexadecimal(hash))),
            read => hash.update(&bytes[..read]),
        }
    }
}

/// Of the one file that holds a label map; `None` where that is none: a folder of images, a header whose voxels lie in a file of their
/// own, whatever its ending, and the generated patient.
///
/// # Errors
/// What reading it says.
pub fn of_labels(path: &Path) -> io::Result<Option<String>> {
    if scene::is_generated(path) || !path.is_file() {
        return Ok(None);
    }
    // Voxels in a file of their own are not in the hash of their header.
    let detached = path
        .extension()
        .is_some_and(|last| DETACHED.iter().any(|one| last.eq_ignore_ascii_case(one)));
    if detached || names_another(path)? {
        Ok(None)
    } else {
        of_file(path)
    }
}

/// Whether a header names the file of its voxels: NRRD's field `data file`, MetaImage's `ElementDataFile` that is not `LOCAL`. As the
/// readers of volumes take them, and a header that is too long for these is said to name one.
fn names_another(path: &Path) -> io::Result<bool> {
    let mut head = Vec::new();
    File::open(path)?.take(MAX_HEAD).read_to_end(&mut head)?;
    let is_nrrd = head.starts_with(b"NRRD");
    let is_cut = head.len() as u64 == MAX_HEAD;
    let mut lines = head.split(|byte| *byte == b'\n').map(String::from_utf8_lossy);
    if is_nrrd {
        // An empty line ends the header.
        let mut fields = lines.by_ref().take_while(|line| !line.trim_end().is_empty());
        let is_field = fields.any(|line| {
            let field = line.split_once(':').filter(|(_, value)| !value.starts_with('='));
            field.is_some_and(|(name, _)| name.replace(' ', "").eq_ignore_ascii_case("datafile"))
        });
        return Ok(is_field || is_cut && lines.next().is_none());
    }
    let mut fields = lines.map_while(|line| {
        let (name, value) = line.split_once('=')?;
        Some((name.trim().to_owned(), value.trim().to_owned()))
    });
    let data = fields.find(|(name, _)| name == "ElementDataFile");
    Ok(data.is_some_and(|(_, value)| !value.eq_ignore_ascii_case("LOCAL")))
}

/// Refuses another label map than the one that a scene names by its SHA-256 (`wanted`, in lower case): what was `found` of the file at
/// `path` ([`of_labels`]).
///
/// # Errors
/// [`scene::Invalid`] with the key `space.labels_sha256`.
pub fn pinned(wanted: Option<&str>, path: &Path, found: Option<&str>) -> Checked<()> {
    match wanted {
        Some(wanted) if found != Some(wanted) => {
            let found = found.map_or("not one file that holds the voxels".to_owned(), |found| {
                format!("a file of {found}")
            });
            let allowed = format!("the file of {wanted}; leave the key out to take any");
            Err(invalid(
                "space.labels_sha256",
                format!("{}: {found}", path.display()),
                allowed,
            ))
        }
        _ => Ok(()),
    }
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
