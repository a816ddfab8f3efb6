//! Volumes: all of a file is read, in order and where it lies.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use scene::{FileSpec, VolumeSource, VolumeSpec};
use volume_loader::phantom_source::PhantomSource;
use volume_loader::source::Scratch;
use volume_loader::{dicom_out, open};

use crate::Folder;

/// More voxels than this are not read: a target is to be fast.
const MAX_VOXELS: u64 = 1 << 16;

/// A file whose name has this ending.
pub(crate) fn read_as(ending: &str, bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    let Some(path) = folder.file(&format!("bytes.{ending}"), bytes) else {
        return;
    };
    for assume_lps in [false, true] {
        read(FileSpec {
            path: path.clone(),
            assume_lps,
            ..FileSpec::default()
        });
    }
}

/// One slice of a series whose others are good; and a file of several slices.
pub(crate) fn read_as_dicom(bytes: &[u8]) {
    read_as("dcm", bytes);
    read_as_slice(bytes);
}

fn read_as_slice(bytes: &[u8]) {
    static SERIES: OnceLock<Option<Folder>> = OnceLock::new();
    let Some(good) = SERIES.get_or_init(series) else { return };
    let Ok(folder) = Folder::new() else { return };
    let copied = fs::read_dir(good.path()).and_then(|mut files| {
        files.try_for_each(|file| {
            let file = file?;
            fs::copy(file.path(), folder.path().join(file.file_name())).map(drop)
        })
    });
    if copied.is_err() || folder.file("IM0002.dcm", bytes).is_none() {
        return;
    }
    for regrid in [false, true] {
        read(FileSpec {
            path: folder.path().to_owned(),
            regrid,
            ..FileSpec::default()
        });
    }
}

/// A series of the generated patient, with few and small slices.
fn series() -> Option<Folder> {
    let folder = Folder::new().ok()?;
    let mut patient = PhantomSource::new(1, [90.0; 3]).ok()?;
    let inner: PathBuf = folder.path().join("series");
    dicom_out::write(&inner, &mut patient, &dicom_out::Options::default()).ok()?;
    for file in fs::read_dir(&inner).ok()? {
        let file = file.ok()?;
        fs::rename(file.path(), folder.path().join(file.file_name())).ok()?;
    }
    fs::remove_dir(inner).ok()?;
    Some(folder)
}

fn read(file: FileSpec) {
    let spec = VolumeSpec {
        source: VolumeSource::File(file),
        region: None,
        downsample: [1; 3],
        hash: None,
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
