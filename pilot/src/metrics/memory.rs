//! What each process's memory costs: proportional set sizes from the kernel.

use std::fs;

/// Memory of one process, bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct ProcessMemory {
    /// Everything, shared pages divided by their users.
    pub(crate) pss: u64,
    /// The part of it that is the volume.
    pub(crate) volume_pss: u64,
}

/// The memory of process `pid`; `volume_inode` is the volume's file in shared memory. Zero where the process has gone.
pub(crate) fn of_process(pid: u32, volume_inode: u64) -> ProcessMemory {
    fs::read_to_string(format!("/proc/{pid}/smaps"))
        .map(|smaps| parse(&smaps, volume_inode))
        .unwrap_or_default()
}

/// Sums `/proc/PID/smaps`: a head line for each mapping, with its inode in the fifth field, and `Pss:  N kB` below it.
fn parse(smaps: &str, volume_inode: u64) -> ProcessMemory {
    let mut memory = ProcessMemory::default();
    let mut in_volume = false;
    for line in smaps.lines() {
        let mut fields = line.split_whitespace();
        let first = fields.next().unwrap_or_default();
        if first == "Pss:" {
            let kib: u64 = fields.next().and_then(|n| n.parse().ok()).unwrap_or(0);
            memory.pss += kib * 1024;
            memory.volume_pss += if in_volume { kib * 1024 } else { 0 };
        } else if first.contains('-') && !first.ends_with(':') {
            let inode = fields.nth(3).and_then(|n| n.parse().ok());
            in_volume = volume_inode != 0 && inode == Some(volume_inode);
        }
    }
    memory
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_by_inode() {
        let smaps = "7f00-7f10 r--s 00000000 00:19 4711   /dev/shm/x.data\nRss: 90 kB\nPss:   30 kB\nPss_Dirty: 5 kB\n\
                     7f20-7f30 rw-p 00000000 00:00 0 \nPss:   12 kB\nVmFlags: rd wr\n";
        let expected = ProcessMemory {
            pss: 42 * 1024,
            volume_pss: 30 * 1024,
        };
        assert_eq!(parse(smaps, 4711), expected);
        assert_eq!(parse(smaps, 0).volume_pss, 0);
    }

    #[test]
    fn this_process_has_memory() {
        assert!(of_process(std::process::id(), 0).pss > 100_000);
        assert_eq!(of_process(u32::MAX, 0), ProcessMemory::default());
    }
}
