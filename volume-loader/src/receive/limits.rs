//! How much a peer may send, and how long it may take.

use std::time::Duration;

/// Bounds of an association.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Bytes of one instance's data set.
    pub instance_bytes: u64,
    /// Bytes of all data sets of an association.
    pub association_bytes: u64,
    /// Instances of an association, those that are refused included.
    pub instances: u64,
    /// Bytes that stay free on the disk.
    pub free_bytes: u64,
    /// A PDU must be there so long after the one before it, or after the connection was made (ARTIM, PS3.8 section 9.1.5). A message may
    /// take that long and a second more for each [`Limits::SLOWEST`] bytes of it.
    pub silence: Duration,
}

impl Limits {
    /// Bytes a second that a message comes with at least, on average and but for the time of silence. A modem is faster.
    pub const SLOWEST: u64 = 1024;
    /// So long an association may go on without an instance that is new, as many times [`Limits::silence`].
    pub(crate) const IDLE: u32 = 10;

    pub(crate) fn silence_ns(&self) -> i64 {
        i64::try_from(self.silence.as_nanos()).unwrap_or(i64::MAX)
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            // 2048 slices of 512 x 512 x 2 bytes are 1 GiB.
            instance_bytes: 2 << 30,
            association_bytes: 32 << 30,
            instances: 20_000,
            free_bytes: 1 << 30,
            silence: Duration::from_secs(30),
        }
    }
}
