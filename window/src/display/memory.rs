//! Memory for pixels that an X server reads in place.

use std::os::fd::OwnedFd;

use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};

/// Anonymous memory, mapped here and handed to the server by its descriptor.
#[derive(Debug)]
pub(super) struct Shared {
    start: *mut std::ffi::c_void,
    /// Of 4 bytes.
    pixels: usize,
}

impl Shared {
    /// Takes memory for so many pixels, all black; returns it with the descriptor for the server.
    pub(super) fn new(pixels: usize) -> std::io::Result<(Self, OwnedFd)> {
        let file = memfd_create("trocar-window", MemfdFlags::CLOEXEC)?;
        let bytes = pixels.max(1) * 4;
        ftruncate(&file, bytes as u64)?;
        #[allow(unsafe_code, reason = "mapping has no safe form")]
        // SAFETY: a new mapping where the kernel finds room; nothing of this process lies there.
        let start = unsafe {
            let access = ProtFlags::READ | ProtFlags::WRITE;
            mmap(std::ptr::null_mut(), bytes, access, MapFlags::SHARED, &file, 0)?
        };
        Ok((Self { start, pixels }, file))
    }

    /// The pixels. The server may read them at any time; it never writes.
    pub(super) fn pixels(&mut self) -> &mut [u32] {
        #[allow(unsafe_code, reason = "the pixels lie in the mapping")]
        // SAFETY: the mapping has `pixels` numbers of 4 bytes and begins at a page, so they are aligned; any bits are a number; it lives
        // as long as `self`, which is borrowed mutably, and nobody else in this process has its address.
        unsafe {
            std::slice::from_raw_parts_mut(self.start.cast::<u32>(), self.pixels)
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        #[allow(unsafe_code, reason = "unmapping has no safe form")]
        // SAFETY: the mapping made above, which nothing refers to any longer.
        let _ = unsafe { munmap(self.start, self.pixels.max(1) * 4) };
    }
}
