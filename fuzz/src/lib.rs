//! What the targets share: bytes as a file, and reading all of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use bus::scene::{FileSpec, VolumeSource, VolumeSpec};
use volume_loader::phantom_source::PhantomSource;
use volume_loader::source::Scratch;
use volume_loader::{dicom_out, open};

/// More voxels than this are not read: a target is to be fast.
const MAX_VOXELS: u64 = 1 << 16;

/// A folder of this process's own, in memory where there is room for it.
fn folder() -> PathBuf {
    let shared = Path::new("/dev/shm");
    let base = if shared.is_dir() {
        shared.to_owned()
    } else {
        std::env::temp_dir()
    };
    base.join(format!("trocar-fuzz-{}", std::process::id()))
}

/// Puts `bytes` into a file whose name has this ending and reads it, in order and where it lies.
pub fn read_as(ending: &str, bytes: &[u8]) {
    let folder = folder();
    let path = folder.join(format!("bytes.{ending}"));
    if fs::create_dir_all(&folder).and_then(|()| fs::write(&path, bytes)).is_ok() {
        for assume_lps in [false, true] {
            read(FileSpec {
                path: path.clone(),
                assume_lps,
                ..FileSpec::default()
            });
        }
    }
    // The next input writes it again.
    let _ = fs::remove_file(&path);
}

/// Puts `bytes` in the place of one slice of a good series and reads it all.
pub fn read_as_slice(bytes: &[u8]) {
    static SERIES: OnceLock<Option<PathBuf>> = OnceLock::new();
    let Some(series) = SERIES.get_or_init(series) else { return };
    if fs::write(series.join("IM0002.dcm"), bytes).is_ok() {
        for regrid in [false, true] {
            read(FileSpec {
                path: series.clone(),
                regrid,
                ..FileSpec::default()
            });
        }
    }
}

/// A series of the generated patient, with few and small slices.
fn series() -> Option<PathBuf> {
    let series = folder().join("series");
    fs::create_dir_all(folder()).ok()?;
    let mut patient = PhantomSource::new(1, [90.0; 3]).ok()?;
    dicom_out::write(&series, &mut patient, &dicom_out::Options::default()).ok()?;
    Some(series)
}

fn read(file: FileSpec) {
    let spec = VolumeSpec {
        source: VolumeSource::File(file),
        region: None,
        downsample: [1; 3],
    };
    let mut source = match open(&spec, 1) {
        Ok(source) => source,
        Err(error) => return drop(error.to_string()),
    };
    let _ = (source.describe(), source.facts());
    if source.grid().voxels() > MAX_VOXELS {
        return;
    }
    let [columns, rows, count] = source.grid().dims();
    let mut slice = vec![0; columns as usize * rows as usize];
    if let Some(slices) = source.slices() {
        let mut scratch = Scratch::default();
        for k in 0..count {
            let _ = slices.read(k, &mut slice, &mut scratch);
        }
    }
    for k in 0..count {
        if source.read_slice(k, &mut slice).is_err() {
            return;
        }
    }
    let _ = source.finish();
}
