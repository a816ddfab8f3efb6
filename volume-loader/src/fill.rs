//! From a source's slices to voxels in their places.

use std::num::NonZero;
use std::slice::ChunksMut;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

use bus::message::VolumeHash;
use bus::volume::{Hasher, Layout, SliceHash};
use geometry::VolumeGrid;

use crate::error::LoadError;
use crate::source::{Conversion, ReadError, Scratch, SliceReader, VoxelSource};

/// More threads than this gain nothing: memory is the limit.
const MAX_THREADS: usize = 8;
/// How often `progress` is asked while slices take their time.
const ASK: Duration = Duration::from_millis(50);

/// What is known after the last slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filled {
    /// The volume's identity.
    pub hash: VolumeHash,
    /// How many voxels were changed on the way.
    pub conversion: Conversion,
}

/// Reads every slice of `source` into `stored` and takes the hash on the way. One slice per thread is held beside
/// `stored`: threads there are where the source has its slices apart.
///
/// `progress` is called now and then with the number of slices read, on the calling thread, and says whether to go on.
///
/// # Errors
/// The source's, or [`LoadError::Stopped`]; what is in `stored` then is not a volume.
pub fn fill(
    source: &mut dyn VoxelSource,
    layout: &Layout,
    stored: &mut [i16],
    mut progress: impl FnMut(u32) -> bool,
) -> Result<Filled, LoadError> {
    let (grid, padding_hu) = (*source.grid(), source.padding_hu());
    let mut filling = Filling {
        hashes: vec![None; grid.dims()[2] as usize],
        conversion: Conversion::default(),
        done: 0,
    };
    match source.slices() {
        Some(slices) => filling.side_by_side(slices, &grid, layout, stored, &mut progress)?,
        None => filling.one_by_one(source, &grid, layout, stored, &mut progress)?,
    }
    let mut hasher = Hasher::new(&grid, padding_hu);
    for hash in filling.hashes {
        // A slice without a hash was never read: a thread ended without a word.
        hasher.update(hash.ok_or(LoadError::Stopped)?);
    }
    Ok(Filled {
        hash: hasher.finish(),
        conversion: filling.conversion,
    })
}

/// What is known so far.
struct Filling {
    hashes: Vec<Option<SliceHash>>,
    conversion: Conversion,
    done: u32,
}

impl Filling {
    fn one_by_one(
        &mut self,
        source: &mut dyn VoxelSource,
        grid: &VolumeGrid,
        layout: &Layout,
        stored: &mut [i16],
        progress: &mut dyn FnMut(u32) -> bool,
    ) -> Result<(), LoadError> {
        let mut slice = vec![0; slice_voxels(grid)];
        for k in 0..grid.dims()[2] {
            if !progress(k) {
                return Err(LoadError::Stopped);
            }
            source.read_slice(k, &mut slice)?;
            layout.scatter(k, &slice, stored);
            self.hashes[k as usize] = Some(SliceHash::of(&slice));
        }
        self.conversion = source.finish()?;
        Ok(())
    }

    /// Threads take layers of bricks in turn: what they write lies apart.
    fn side_by_side(
        &mut self,
        slices: &dyn SliceReader,
        grid: &VolumeGrid,
        layout: &Layout,
        stored: &mut [i16],
        progress: &mut dyn FnMut(u32) -> bool,
    ) -> Result<(), LoadError> {
        let threads = thread::available_parallelism().map_or(1, NonZero::get).min(MAX_THREADS);
        let work = Work {
            slices,
            layout,
            slice_voxels: slice_voxels(grid),
            layers: Mutex::new(stored.chunks_mut(layout.layer()).enumerate()),
            stop: AtomicBool::new(false),
        };
        thread::scope(|scope| {
            let (tell, told) = mpsc::channel();
            for _ in 0..threads {
                let (work, tell) = (&work, tell.clone());
                scope.spawn(move || work.run(&tell));
            }
            drop(tell);
            let result = self.collect(&told, progress);
            work.stop.store(result.is_err(), Ordering::Relaxed);
            result
        })
    }

    fn collect(
        &mut self,
        told: &mpsc::Receiver<Result<ReadSlice, ReadError>>,
        progress: &mut dyn FnMut(u32) -> bool,
    ) -> Result<(), LoadError> {
        loop {
            match told.recv_timeout(ASK) {
                Ok(read) => {
                    let read = read?;
                    self.hashes[read.k as usize] = Some(read.hash);
                    self.conversion += read.conversion;
                    self.done += 1;
                }
                Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if !progress(self.done) {
                return Err(LoadError::Stopped);
            }
        }
    }
}

fn slice_voxels(grid: &VolumeGrid) -> usize {
    let [columns, rows, _] = grid.dims();
    columns as usize * rows as usize
}

/// What threads share.
struct Work<'a> {
    slices: &'a dyn SliceReader,
    layout: &'a Layout,
    slice_voxels: usize,
    layers: Mutex<std::iter::Enumerate<ChunksMut<'a, i16>>>,
    stop: AtomicBool,
}

struct ReadSlice {
    k: u32,
    hash: SliceHash,
    conversion: Conversion,
}

impl Work<'_> {
    /// Reads layers until none is left, a slice fails or all are to stop.
    fn run(&self, tell: &mpsc::Sender<Result<ReadSlice, ReadError>>) {
        let (mut slice, mut scratch) = (vec![0; self.slice_voxels], Scratch::default());
        loop {
            let next = self.layers.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((index, layer)) = next else { return };
            for k in self.layout.slices_of_layer(index) {
                if self.stop.load(Ordering::Relaxed) {
                    return;
                }
                let read = self.slices.read(k, &mut slice, &mut scratch).map(|conversion| {
                    self.layout.scatter_in_layer(k, &slice, layer);
                    ReadSlice {
                        k,
                        hash: SliceHash::of(&slice),
                        conversion,
                    }
                });
                let failed = read.is_err();
                // Nobody listens any more: the reading has ended.
                if tell.send(read).is_err() || failed {
                    return;
                }
            }
        }
    }
}
