//! The loader's process: one volume into shared memory, and there it stays.

mod identified;

use std::time::Duration;

use bus::BusError;
use bus::message::{ProcessState, VolumeHash, VolumeHeader};
use bus::port::{Publisher, VolumePublisher};
use bus::process::{JoinError, Membership, Process};
use bus::run::{RunError as FolderError, SHM_DIR, shm_free_bytes};
use bus::topic::IDENTITY;
use bus::volume::{Layout, LayoutError};

use crate::error::LoadError;
use crate::fill::{Filled, fill};
use crate::load::open;
use crate::progress::Progress;
use crate::source::VoxelSource;
use identified::identified;

/// How often late joiners are looked after.
const PUMP: Duration = Duration::from_millis(10);
/// Shared memory that images and messages need beside the volume.
const MARGIN_BYTES: u64 = 64 << 20;

/// Why the loader ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The volume was not loaded.
    #[error("loading the volume: {0}")]
    Load(#[from] LoadError),
    /// The volume cannot be laid out.
    #[error("loading {what}: {source}")]
    Layout {
        /// The volume, as it describes itself.
        what: String,
        /// What is wrong.
        source: LayoutError,
    },
    /// Another examination than the scene's.
    #[error(
        "loading {what}: its hash is {found}, and the scene is for the examination {expected} alone ([volume] hash, or that of its plan). \
         Nothing of it is shown"
    )]
    Other {
        /// The volume, as it describes itself.
        what: String,
        /// Its hash.
        found: VolumeHash,
        /// The hash that the scene names.
        expected: String,
    },
    /// Shared memory cannot be asked.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The volume does not fit into shared memory.
    #[error(
        "loading {what}: it needs {needed_mib} MiB of shared memory (with {} MiB for the images), and {SHM_DIR} has \
         {free_mib} MiB free. Enlarge it, for instance `mount -o remount,size={}M {SHM_DIR}`, or for a container \
         `--shm-size`, or load a smaller volume",
        MARGIN_BYTES >> 20, needed_mib + used_mib
    )]
    SharedMemory {
        /// The volume, as it describes itself.
        what: String,
        /// What the volume needs.
        needed_mib: u64,
        /// What there is.
        free_mib: u64,
        /// What others use.
        used_mib: u64,
    },
}

/// Loads the scene's volume, publishes it, and serves late joiners until asked to stop.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(membership: &Membership) -> Result<(), RunError> {
    let mut process = Process::join("volume-loader", membership)?;
    let mut source = open(&process.scene.volume, process.scene.seed)?;
    bus::stderr_line!("volume-loader: {}", source.describe());
    let what = || source.describe();
    let layout = Layout::choose(source.grid().dims()).map_err(|e| RunError::Layout {
        what: what(),
        source: e,
    })?;
    check_space(layout.stored() * 2, what)?;
    let publisher = VolumePublisher::open(&process.bus, &layout)?;
    let identities = Publisher::open(&process.bus, &IDENTITY, "")?;
    let hash = publish(&mut process, source.as_mut(), &layout, &publisher)?;
    let shown = process
        .run
        .replay
        .as_ref()
        .and_then(|replay| replay.volume_hash.as_deref());
    // The words of a scene are of the examination that it was written for.
    let said = process.scene.identity.as_ref();
    let said = said.filter(|_| shown.is_none_or(|recorded| recorded == hash.to_string()));
    identities.send(identified(source.as_ref(), said, hash))?;
    let note = note(source.as_ref());
    process.counters.published = 1;
    while !process.stop.is_set() {
        publisher.serve_late_joiners();
        identities.serve_late_joiners();
        process.beat(ProcessState::Ready, &note)?;
        std::thread::sleep(PUMP);
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// What the operator should know of the volume, in few words.
fn note(source: &dyn VoxelSource) -> String {
    let words = source.marks().words();
    let remarks = source.remarks().join("; ");
    match (words.is_empty(), remarks.is_empty()) {
        (true, _) => remarks,
        (_, true) => words,
        _ => format!("{words}: {remarks}"),
    }
}

/// Memory is given page by page as it is written, so a volume that does not fit would kill the process half-way.
fn check_space(bytes: u64, what: impl Fn() -> String) -> Result<(), RunError> {
    let free = shm_free_bytes()?;
    let needed = bytes + MARGIN_BYTES;
    if needed <= free {
        return Ok(());
    }
    let stat_used = rustix::fs::statvfs(SHM_DIR)
        .map(|s| s.f_blocks.saturating_sub(s.f_bavail).saturating_mul(s.f_frsize))
        .unwrap_or(0);
    Err(RunError::SharedMemory {
        what: what(),
        needed_mib: needed.div_ceil(1 << 20),
        free_mib: free >> 20,
        used_mib: stat_used.div_ceil(1 << 20),
    })
}

fn publish(
    process: &mut Process,
    source: &mut dyn VoxelSource,
    layout: &Layout,
    publisher: &VolumePublisher,
) -> Result<VolumeHash, RunError> {
    let (grid, padding_hu, marks) = (*source.grid(), source.padding_hu(), source.marks());
    let slices = grid.dims()[2];
    let mut progress = Progress::new(process.clock().clone(), slices);
    let mut loan = publisher.loan()?;
    let mut beat = Ok(());
    let filled = fill(source, layout, loan.voxels_mut(), |done| {
        progress.at(done);
        beat = process.beat(ProcessState::Starting, &format!("reading slice {done} of {slices}"));
        beat.is_ok() && !process.stop.is_set()
    });
    beat?;
    let Filled { hash, conversion } = filled?;
    let expected = process.scene.volume.hash.clone();
    if let Some(expected) = expected.filter(|expected| *expected != hash.to_string()) {
        return Err(RunError::Other {
            what: source.describe(),
            found: hash,
            expected,
        });
    }
    loan.publish(VolumeHeader::new(&grid, layout, padding_hu, hash, marks))?;
    let seconds = progress.finish();
    let mib = (layout.stored() * 2) as f64 / f64::from(1 << 20);
    bus::stderr_line!(
        "volume-loader: {mib:.1} MiB in shared memory after {seconds:.2} s, bricks of {:?}, hash {hash}",
        layout.brick()
    );
    for remark in source.remarks() {
        bus::stderr_line!("volume-loader: {remark}");
    }
    if conversion.clamped_low + conversion.clamped_high + conversion.not_finite > 0 {
        bus::stderr_line!(
            "volume-loader: warning: {} voxels below and {} above the range of 16 bits were clamped, {} that were not \
             numbers became padding",
            conversion.clamped_low,
            conversion.clamped_high,
            conversion.not_finite
        );
    }
    Ok(hash)
}
