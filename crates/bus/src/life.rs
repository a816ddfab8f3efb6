//! Signs of life before a process is on the bus: bytes on the pipe that the pilot gives its children as their stdout.
//!
//! Joining needs others (a dead predecessor's place must be freed first), so it may take a while; a process that gave no
//! sign meanwhile would be taken for one that hangs. What a byte says is that the process has come to the next step or try.

use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;

use rustix::fd::AsFd;
use rustix::io::write;
use rustix::pipe::{PipeFlags, pipe_with};

/// A child's end. Of any thread: one that never waits may answer for a process whose work has to wait, as for a disk.
#[derive(Debug, Clone, Copy)]
pub struct LifeLine {
    is_supervised: bool,
}

impl LifeLine {
    /// To the pilot that started this process.
    pub(crate) fn to_pilot() -> Self {
        Self { is_supervised: true }
    }

    /// To nobody: nobody waits for this process.
    pub fn none() -> Self {
        Self { is_supervised: false }
    }

    /// Whether a pilot listens.
    pub(crate) fn is_supervised(self) -> bool {
        self.is_supervised
    }

    /// Gives a sign. The pipe never makes its writer wait; one that is full, or whose reader has gone, is no matter.
    pub fn beat(self) {
        if self.is_supervised {
            let _ = write(std::io::stdout().as_fd(), b".");
        }
    }
}

/// The pilot's end.
#[derive(Debug)]
pub struct LifeSigns(File);

impl LifeSigns {
    /// A new line: what the pilot listens to, and what the child gets as its stdout.
    ///
    /// # Errors
    /// Where there are no descriptors left.
    pub fn new() -> std::io::Result<(Self, OwnedFd)> {
        let (reading, writing) = pipe_with(PipeFlags::CLOEXEC | PipeFlags::NONBLOCK)?;
        Ok((Self(File::from(reading)), writing))
    }

    /// Whether there was a sign since the last call.
    pub fn came(&mut self) -> bool {
        let mut bytes = [0; 4096];
        let mut came = false;
        // At most a pipe's worth, so that a child that floods its line holds nobody up.
        for _ in 0..16 {
            match self.0.read(&mut bytes) {
                Ok(read) if read > 0 => came = true,
                _ => break,
            }
        }
        came
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_heard_once_and_a_full_line_holds_nobody_up() {
        let (mut signs, writing) = LifeSigns::new().unwrap();
        assert!(!signs.came());
        write(&writing, b".").unwrap();
        assert!(signs.came());
        assert!(!signs.came());
        // A pipe holds 64 KiB.
        while write(&writing, &[b'.'; 1000]).is_ok() {}
        assert!(signs.came());
        drop(writing);
        signs.came();
        assert!(!signs.came(), "an end is no sign");
    }
}
