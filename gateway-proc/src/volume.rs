//! The examination as an IMAGE: the bricks of shared memory become rows, once for all clients that are being sent them.

use std::sync::{Arc, Weak};
use std::thread;
use std::time::Duration;

use bus::message::VolumeHash;
use bus::port::SharedVolume;
use bus::volume::{Layout, VolumeView};
use igtl::{Body, Message, Metadata, Text, Version};

use crate::letter::{Letter, Voxels};
use crate::origin::Origin;
use crate::place::{PlaceError, of_grid};
use crate::tell::named;

/// The device of the examination.
pub(crate) const VOLUME: &str = "Volume";
/// The nice value of what copies it.
const NICE: i32 = 10;
/// Between two looks at whether it is done.
const LOOK: Duration = Duration::from_millis(2);

/// Makes the letter of a volume, and makes it again only once the last client has been sent it: no second copy is held.
#[derive(Debug, Default)]
pub(crate) struct Copied {
    last: Option<(VolumeHash, Weak<Letter>)>,
}

impl Copied {
    /// The volume as a message to all clients, its bytes for one of this version made. `alive` is called again and again meanwhile.
    ///
    /// # Errors
    /// [`PlaceError`].
    pub(crate) fn letter(
        &mut self,
        volume: &SharedVolume,
        origin: Origin,
        version: Version,
        alive: &mut dyn FnMut(),
    ) -> Result<Arc<Letter>, PlaceError> {
        let letter = self.made(volume, origin, alive)?;
        // Here, and not where the next pose of that client would wait for it.
        aside(&mut || drop(letter.wire(version)), alive);
        Ok(letter)
    }

    fn made(
        &mut self,
        volume: &SharedVolume,
        origin: Origin,
        alive: &mut dyn FnMut(),
    ) -> Result<Arc<Letter>, PlaceError> {
        if let Some((hash, letter)) = &self.last
            && *hash == volume.hash()
            && let Some(letter) = letter.upgrade()
        {
            return Ok(letter);
        }
        let marks = volume.header().marks().words();
        let hash = volume.hash().to_string();
        let letter = Arc::new(letter(&volume.view(), [&hash, &marks], origin, alive)?);
        self.last = Some((volume.hash(), Arc::downgrade(&letter)));
        Ok(letter)
    }
}

fn letter(
    view: &VolumeView<'_>,
    [hash, marks]: [&str; 2],
    origin: Origin,
    alive: &mut dyn FnMut(),
) -> Result<Letter, PlaceError> {
    let (image, is_reversed) = of_grid(view.grid)?;
    let mut metadata = Metadata::EMPTY
        .with("VolumeHash", Text::new(hash))
        .with("SessionStatus", Text::new(origin.session()));
    if !marks.is_empty() {
        metadata = metadata.with("VolumeStatus", Text::new(marks));
    }
    let mut out = Vec::new();
    let mut gather = || out = rows(view.layout, view.voxels, view.grid.dims(), is_reversed);
    aside(&mut gather, alive);
    let voxels = Voxels::Shorts(out);
    let message = Message {
        metadata,
        ..Message::new(named(VOLUME), Body::Image(image))
    };
    Ok(Letter::new(message).with(Arc::new(voxels)))
}

/// Does something long on a thread that gives way to all others, poses first of all, and calls `alive` meanwhile.
fn aside(work: &mut (dyn FnMut() + Send), alive: &mut dyn FnMut()) {
    thread::scope(|threads| {
        let worker = threads.spawn(|| {
            give_way();
            work();
        });
        while !worker.is_finished() {
            thread::sleep(LOOK);
            alive();
        }
    });
}

/// From here on this thread, and those that it starts, take what processor time others leave.
fn give_way() {
    bus::process::leave_real_time();
    // Of this thread alone, as the system is Linux. Everybody may ask for less.
    let _ = rustix::process::setpriority_process(None, NICE);
}

/// Row after row, slice after slice; from the last slice to the first where `is_reversed`.
fn rows(layout: &Layout, stored: &[i16], dims: [u32; 3], is_reversed: bool) -> Vec<i16> {
    let [nx, ny, nz] = dims.map(|n| n as usize);
    let mut out = vec![0; nx * ny * nz];
    let half = nz.div_ceil(2) * nx * ny;
    let (low, high) = out.split_at_mut(half);
    let gather = |part: &mut [i16], first: usize| {
        for (at, slice) in part.chunks_exact_mut(nx * ny).enumerate() {
            let sent = first + at;
            let z = if is_reversed { nz - 1 - sent } else { sent };
            gather_slice(layout, stored, z, nx, slice);
        }
    };
    // Memory alone bounds it, and a second processor has its own way to there.
    // What is started here gives way as its starter does.
    thread::scope(|threads| {
        threads.spawn(|| gather(low, 0));
        gather(high, half / (nx * ny));
    });
    out
}

fn gather_slice(layout: &Layout, stored: &[i16], z: usize, nx: usize, slice: &mut [i16]) {
    let [xs, ys, zs] = [0, 1, 2].map(|axis| layout.table(axis));
    // Along x the voxels of a brick lie together.
    let side = layout.brick()[0] as usize;
    let run = if side == 1 && xs.get(1) == Some(&1) { nx } else { side };
    for (row, y) in slice.chunks_exact_mut(nx).zip(ys) {
        let base = (*y + zs[z]) as usize;
        for (part, x) in row.chunks_mut(run).zip(xs.iter().step_by(run)) {
            let from = base + *x as usize;
            if let (Ok(to), Some(four)) = (<&mut [i16; 4]>::try_from(&mut *part), stored.get(from..from + 4)) {
                to.copy_from_slice(four);
            } else {
                part.copy_from_slice(&stored[from..from + part.len()]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_voxel_of_any_layout_comes_out_at_its_place() {
        for dims in [[1, 1, 1], [9, 5, 6], [8, 8, 8], [4, 4, 3], [13, 1, 2]] {
            for brick in [[1, 1, 1], [4, 4, 4], [2, 8, 1], [16, 1, 4]] {
                let layout = Layout::new(dims, brick).unwrap();
                let mut stored = vec![-9999; layout.stored() as usize];
                let [nx, ny, nz] = dims;
                let value = |x: u32, y: u32, z: u32| (x + 20 * y + 400 * z) as i16;
                let all = || (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y, z))));
                for (x, y, z) in all() {
                    stored[layout.offset([x, y, z])] = value(x, y, z);
                }
                let expected: Vec<i16> = all().map(|(x, y, z)| value(x, y, z)).collect();
                assert_eq!(rows(&layout, &stored, dims, false), expected, "{dims:?} {brick:?}");
                let reversed: Vec<i16> = all().map(|(x, y, z)| value(x, y, nz - 1 - z)).collect();
                assert_eq!(rows(&layout, &stored, dims, true), reversed, "{dims:?} {brick:?}");
            }
        }
    }
}
