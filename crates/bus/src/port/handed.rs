//! The volume handed on: a process that starts while no loader serves the run maps the voxels that others still hold.
//!
//! What a loader published stays in memory for as long as anybody has it open, but no name leads there any more once the loader has
//! died. So the pilot opens the file while it has a name, and gives the descriptor to each process that it starts, as its standard
//! input; where in the file header and voxels lie stands in [`VOLUME_VARIABLE`].

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use rustix::fs::OFlags;
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};

use crate::message::VolumeHeader;
use crate::volume::ALIGNMENT;

/// In it the pilot says where in the file on a process's standard input the volume lies: inode, header and voxels.
pub(crate) const VOLUME_VARIABLE: &str = "TROCAR_VOLUME";

/// A volume in shared memory that is open, whatever becomes of its loader and its name.
#[derive(Debug)]
pub struct HandedVolume {
    file: File,
    place: Place,
}

/// Where a volume lies in its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    inode: u64,
    /// Bytes from the file's beginning.
    header_at: u64,
    voxels_at: u64,
}

impl Place {
    fn words(self) -> String {
        format!("{} {} {}", self.inode, self.header_at, self.voxels_at)
    }

    fn parse(words: &str) -> Option<Self> {
        let mut numbers = words.split(' ').map(|word| word.parse().ok());
        let place = Self {
            inode: numbers.next()??,
            header_at: numbers.next()??,
            voxels_at: numbers.next()??,
        };
        numbers.next().is_none().then_some(place)
    }
}

impl HandedVolume {
    /// Opens the file of a volume that this process has mapped. `None` where its name has gone already, or names another file.
    pub(super) fn of(header: *const VolumeHeader, voxels: *const i16) -> Option<Self> {
        let mapped = MappedFile::at(voxels.addr())?;
        let place = Place {
            inode: mapped.inode,
            header_at: mapped.offset_of(header.addr())?,
            voxels_at: mapped.offset_of(voxels.addr())?,
        };
        let mut options = File::options();
        let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32;
        let file = options.read(true).custom_flags(flags).open(&mapped.path).ok()?;
        (file.metadata().ok()?.ino() == place.inode).then_some(Self { file, place })
    }

    /// Gives the volume to a process about to be started, in place of its standard input.
    ///
    /// # Errors
    /// Where there are no descriptors left.
    pub fn give_to(&self, command: &mut Command) -> io::Result<()> {
        command.stdin(Stdio::from(self.file.try_clone()?));
        command.env(VOLUME_VARIABLE, self.place.words());
        Ok(())
    }

    /// What the pilot gave to this process; `None` where it gave nothing.
    pub(crate) fn received() -> Option<Self> {
        let place = Place::parse(&std::env::var(VOLUME_VARIABLE).ok()?)?;
        let own: OwnedFd = rustix::io::fcntl_dupfd_cloexec(io::stdin().as_fd(), 3).ok()?;
        let file = File::from(own);
        let found = file.metadata().ok()?;
        let is_ours = found.is_file() && found.uid() == rustix::process::getuid().as_raw();
        (is_ours && found.ino() == place.inode).then_some(Self { file, place })
    }

    /// Maps header and voxels. `None` where the file cannot hold them.
    pub(super) fn map(&self) -> Option<(VolumeHeader, MappedVoxels)> {
        let bytes = self.file.metadata().ok()?.len();
        let header_end = self.place.header_at.checked_add(size_of::<VolumeHeader>() as u64)?;
        let is_aligned = self.place.header_at.is_multiple_of(align_of::<VolumeHeader>() as u64)
            && self.place.voxels_at.is_multiple_of(ALIGNMENT as u64);
        if header_end > bytes || !is_aligned {
            return None;
        }
        let mapping = Mapping::of(&self.file, usize::try_from(bytes).ok()?)?;
        #[allow(unsafe_code, reason = "the header lies in the file, as it does in a sample")]
        // SAFETY: inside the mapping and aligned, as was checked; every pattern of bits is a header, which has numbers only.
        let header = unsafe { mapping.at::<VolumeHeader>(self.place.header_at).read() };
        let stored = header.layout().ok()?.stored();
        let voxels_end = self.place.voxels_at.checked_add(stored.checked_mul(2)?)?;
        (voxels_end <= bytes).then_some((
            header,
            MappedVoxels {
                mapping,
                at: self.place.voxels_at,
                stored: stored as usize,
            },
        ))
    }
}

/// The voxels of a volume that was handed on.
#[derive(Debug)]
pub(super) struct MappedVoxels {
    mapping: Mapping,
    at: u64,
    stored: usize,
}

impl MappedVoxels {
    pub(super) fn as_slice(&self) -> &[i16] {
        #[allow(unsafe_code, reason = "the voxels lie in the file, as they do in a sample")]
        // SAFETY: inside the mapping and aligned, as `HandedVolume::map` checked. Its loader wrote them before it published, and
        // nobody writes there afterwards.
        unsafe {
            std::slice::from_raw_parts(self.mapping.at::<i16>(self.at), self.stored)
        }
    }
}

/// A file mapped read-only.
#[derive(Debug)]
struct Mapping {
    start: *mut std::ffi::c_void,
    bytes: usize,
}

impl Mapping {
    fn of(file: &File, bytes: usize) -> Option<Self> {
        #[allow(unsafe_code, reason = "mapping has no safe form")]
        // SAFETY: a new mapping where the kernel finds room; nothing of this process lies there.
        let start = unsafe { mmap(std::ptr::null_mut(), bytes, ProtFlags::READ, MapFlags::SHARED, file, 0) };
        start.ok().map(|start| Self { start, bytes })
    }

    /// A place in the file, which the caller has checked to lie in it.
    fn at<T>(&self, offset: u64) -> *const T {
        self.start
            .cast_const()
            .cast::<u8>()
            .wrapping_add(offset as usize)
            .cast()
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        #[allow(unsafe_code, reason = "unmapping has no safe form")]
        // SAFETY: this very mapping, and nothing borrows from it any more.
        let _ = unsafe { munmap(self.start, self.bytes) };
    }
}

/// A file that this process has mapped, from a line of `/proc/self/maps`.
pub(super) struct MappedFile {
    /// The addresses it is mapped at.
    addresses: std::ops::Range<usize>,
    /// Where in the file they begin.
    offset: u64,
    pub(super) inode: u64,
    path: PathBuf,
}

impl MappedFile {
    /// The file mapped at `address`.
    pub(super) fn at(address: usize) -> Option<Self> {
        let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
        maps.lines()
            .filter_map(Self::parse)
            .find(|mapped| mapped.addresses.contains(&address))
    }

    /// `from-to permissions offset device inode      path`.
    fn parse(line: &str) -> Option<Self> {
        let mut fields = line.splitn(6, ' ');
        let (from, to) = fields.next()?.split_once('-')?;
        let hexadecimal = |text| usize::from_str_radix(text, 16).ok();
        let addresses = hexadecimal(from)?..hexadecimal(to)?;
        let offset = u64::from_str_radix(fields.nth(1)?, 16).ok()?;
        let inode = fields.nth(1)?.parse().ok()?;
        let path = PathBuf::from(fields.next()?.trim_start());
        Some(Self {
            addresses,
            offset,
            inode,
            path,
        })
    }

    fn offset_of(&self, address: usize) -> Option<u64> {
        let inside = self.addresses.contains(&address);
        inside.then(|| self.offset + (address - self.addresses.start) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn header() -> VolumeHeader {
        VolumeHeader {
            ct_from_voxel: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            dims: [4, 4, 4],
            brick: [4, 4, 4],
            ..VolumeHeader::default()
        }
    }

    /// A file with a header at 8 and 64 voxels at 256, cut at `bytes`.
    fn handed(header: VolumeHeader, place: [u64; 2], bytes: usize) -> HandedVolume {
        let mut file = tempfile::tempfile().unwrap();
        #[allow(unsafe_code, reason = "a header's bytes")]
        // SAFETY: a header has no padding.
        let words = unsafe { std::mem::transmute::<VolumeHeader, [u8; 168]>(header) };
        let mut content = vec![0; 256 + 128];
        content[8..176].copy_from_slice(&words);
        for i in 0..64_u8 {
            content[256 + 2 * usize::from(i)] = i;
        }
        file.write_all(&content[..bytes]).unwrap();
        let inode = file.metadata().unwrap().ino();
        let [header_at, voxels_at] = place;
        let place = Place {
            inode,
            header_at,
            voxels_at,
        };
        HandedVolume { file, place }
    }

    #[test]
    fn what_the_file_holds_is_mapped() {
        let (found, voxels) = handed(header(), [8, 256], 384).map().unwrap();
        assert_eq!(found, header());
        let expected: Vec<i16> = (0..64).collect();
        assert_eq!(voxels.as_slice(), expected);
    }

    #[test]
    fn what_the_file_cannot_hold_is_refused() {
        let huge = VolumeHeader {
            dims: [1 << 10, 1 << 10, 1 << 10],
            ..header()
        };
        let none = VolumeHeader::default();
        let places = [
            [8, 256 + 128],
            [8, 257],
            [9, 256],
            [380, 256],
            [u64::MAX - 7, 256],
            [8, u64::MAX - 127],
        ];
        assert!(places.iter().all(|&place| handed(header(), place, 384).map().is_none()));
        assert!(
            [huge, none]
                .iter()
                .all(|&bad| handed(bad, [8, 256], 384).map().is_none())
        );
        assert!(
            [0, 100, 383]
                .iter()
                .all(|&bytes| handed(header(), [8, 256], bytes).map().is_none())
        );
    }

    #[test]
    fn places_are_read_as_they_are_written() {
        let place = Place {
            inode: u64::MAX,
            header_at: 0,
            voxels_at: 128,
        };
        assert_eq!(Place::parse(&place.words()), Some(place));
        for bad in ["", "1", "1 2", "1 2 3 4", "1 2 -3", "1 2 x"] {
            assert_eq!(Place::parse(bad), None, "{bad}");
        }
    }

    #[test]
    fn lines_of_maps() {
        let line = "7f00-7f10 r--s 00001000 00:19 4711                       /dev/shm/a b.data";
        let mapped = MappedFile::parse(line).unwrap();
        assert_eq!(
            (mapped.inode, mapped.path.to_str().unwrap()),
            (4711, "/dev/shm/a b.data")
        );
        assert_eq!(mapped.offset_of(0x7f08), Some(0x1008));
        assert_eq!(mapped.offset_of(0x7f10), None);
        assert!(MappedFile::parse("7f20-7f30 rw-p 00000000 00:00 0").is_none());
    }
}
