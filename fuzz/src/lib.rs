//! What the targets share: bytes as a file, and reading all of it.

use std::path::Path;

use volume_loader::open_file;
use volume_loader::raster::OpenOptions;
use volume_loader::source::Scratch;

/// More voxels than this are not read: a target is to be fast.
const MAX_VOXELS: u64 = 1 << 16;

/// Puts `bytes` into a file whose name has this ending and reads it, in order and where it lies.
pub fn read_as(ending: &str, bytes: &[u8]) {
    let folder = if Path::new("/dev/shm").is_dir() {
        "/dev/shm".into()
    } else {
        std::env::temp_dir()
    };
    let path = folder.join(format!("trocar-fuzz-{}.{ending}", std::process::id()));
    if std::fs::write(&path, bytes).is_ok() {
        for assume_lps in [false, true] {
            read(&path, OpenOptions { assume_lps });
        }
    }
    // The next input writes it again.
    let _ = std::fs::remove_file(&path);
}

fn read(path: &Path, options: OpenOptions) {
    let mut source = match open_file(path, options) {
        Ok(source) => source,
        Err(error) => return drop(error.to_string()),
    };
    let _ = source.describe();
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
