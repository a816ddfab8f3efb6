//! A file that only grows, and keeps what was once handed over whole.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Handed to the operating system at this size even where nobody asks: memory is bounded.
const SPILL: usize = 1 << 20;

/// Takes bytes in memory and hands them to the operating system when it is flushed.
///
/// Where that fails, the file is cut back to what an earlier flush handed over, and nothing more is taken: what was
/// acknowledged stays as it was, without half a record behind it.
#[derive(Debug)]
pub(crate) struct Sink {
    file: Arc<File>,
    buffer: Vec<u8>,
    position: u64,
    flushed: Arc<AtomicU64>,
    failed: bool,
}

impl Sink {
    /// Writes into `file`, which is empty.
    pub(crate) fn new(file: Arc<File>) -> Self {
        Self {
            file,
            buffer: Vec::new(),
            position: 0,
            flushed: Arc::default(),
            failed: false,
        }
    }

    /// How many bytes were flushed, also later, when the sink itself is out of reach.
    pub(crate) fn size(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.flushed)
    }

    fn spill(&mut self) -> io::Result<()> {
        let handed_over = (&*self.file).write_all(&self.buffer);
        self.buffer.clear();
        if handed_over.is_err() {
            self.failed = true;
            // Where this fails too, half a record stays behind what is whole: readers pass over it.
            let _ = self.file.set_len(self.flushed.load(Ordering::Relaxed));
        }
        handed_over
    }

    fn refuse_after_failure(&self) -> io::Result<()> {
        match self.failed {
            true => Err(io::Error::other("an earlier write failed")),
            false => Ok(()),
        }
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.refuse_after_failure()?;
        self.buffer.extend_from_slice(bytes);
        self.position += bytes.len() as u64;
        if self.buffer.len() > SPILL {
            self.spill()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.refuse_after_failure()?;
        self.spill()?;
        self.flushed.store(self.position, Ordering::Relaxed);
        Ok(())
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position),
            _ => Err(io::Error::new(io::ErrorKind::Unsupported, "this file only grows")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_flushed_counts_and_nothing_is_written_back_to() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("f");
        let mut sink = Sink::new(Arc::new(File::create(&path).unwrap()));
        sink.write_all(b"abc").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"");
        sink.flush().unwrap();
        assert_eq!(
            (
                std::fs::read(&path).unwrap().as_slice(),
                sink.stream_position().unwrap()
            ),
            (&b"abc"[..], 3)
        );
        assert!(sink.seek(SeekFrom::Start(0)).is_err());
    }

    #[test]
    fn after_a_full_disk_nothing_is_taken() {
        let Ok(full) = File::options().write(true).open("/dev/full") else {
            return;
        };
        let mut sink = Sink::new(Arc::new(full));
        sink.write_all(b"abc").unwrap();
        let error = sink.flush().unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(sink.write_all(b"d").is_err() && sink.flush().is_err());
        assert_eq!(sink.size().load(Ordering::Relaxed), 0);
    }
}
