//! Small copies of what was shown, a few a second.

use std::time::Duration;

use bus::clock;
use bus::message::Ages;
use bus::port::{Frame, FrameSubscriber};
use bus::topic::VIEW_FRAME;
use bus::{Bus, BusError};
use picture::{Canvas, encode_png};
use scene::Scene;

use crate::wire::proto::CompressedImage;
use crate::write::pose_log::{Entry, Take};

/// Longest side, pixels.
const SIDE: u32 = 256;

/// Takes small images of each view.
#[derive(Debug)]
pub(crate) struct Thumbnails {
    views: Vec<(String, FrameSubscriber)>,
    ages: Ages,
    every_ns: i64,
    next_ns: i64,
}

impl Thumbnails {
    /// Subscribes to the views of `scene`.
    pub(crate) fn open(bus: &Bus, scene: &Scene, every: Duration) -> Result<Self, BusError> {
        let views = scene.views.iter().map(|view| {
            let frames = FrameSubscriber::open(bus, &VIEW_FRAME, &view.name)?;
            Ok((view.name.clone(), frames))
        });
        Ok(Self {
            views: views.collect::<Result<_, BusError>>()?,
            ages: Ages::of(&scene.limits),
            every_ns: clock::ns(every),
            next_ns: i64::MIN,
        })
    }

    /// Records the newest image of each view, if it is time. An image that cannot be encoded is left out.
    pub(crate) fn step(&mut self, now_ns: i64, series: &mut impl Take) -> Result<(), BusError> {
        if now_ns < self.next_ns {
            return Ok(());
        }
        self.next_ns = now_ns.saturating_add(self.every_ns);
        for ((name, frames), view) in self.views.iter().zip(0..) {
            let Some(frame) = frames.newest()? else { continue };
            let Some(png) = small_png(&frame, self.ages) else {
                continue;
            };
            let stamp = &frame.header().stamp;
            let (seq, t_ns) = (stamp.seq, stamp.t_framed_ns);
            let image = &CompressedImage::png(t_ns, name, png);
            series.put(now_ns, Entry::Image { view, seq, t_ns, image });
        }
        Ok(())
    }
}

fn small_png(frame: &Frame, ages: Ages) -> Option<Vec<u8>> {
    let header = frame.header();
    // The record says when the image was handed over: it is what it was then.
    let shown = frame.shown(header.stamp.t_framed_ns, ages);
    let (width, height, rgba) = shrunk(header.width, header.height, shown.rgba);
    if width == 0 || height == 0 {
        return None;
    }
    let mut canvas = Canvas::new(width, height);
    canvas.rgba_mut().copy_from_slice(&rgba);
    encode_png(&canvas, &header.stamp.texts()).ok()
}

/// The image with blocks of n x n pixels averaged to one, so that no side is longer than [`SIDE`]; what is left of a block
/// at the right and at the bottom is left out. `rgba` has `4 * width * height` bytes.
pub(crate) fn shrunk(width: u32, height: u32, rgba: &[u8]) -> (u32, u32, Vec<u8>) {
    let n = width.max(height).div_ceil(SIDE).max(1) as usize;
    let (columns, rows) = (width as usize / n, height as usize / n);
    let stride = 4 * width as usize;
    let mut small = Vec::with_capacity(4 * columns * rows);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        for channel in 0..4 {
            let start = row * n * stride + 4 * column * n + channel;
            let block = (0..n).flat_map(|y| (0..n).map(move |x| start + y * stride + 4 * x));
            let sum: usize = block.map(|at| usize::from(rgba[at])).sum();
            // An average of bytes is one.
            small.push(((sum + n * n / 2) / (n * n)) as u8);
        }
    }
    // Both are at most 256.
    (columns as u32, rows as u32, small)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged() {
        // 512 x 300: blocks of 2 x 2, 256 x 150.
        let pixel = |x: u32, y: u32| [(x % 2 * 100) as u8, (y % 2 * 50) as u8, 7, 255];
        let rgba: Vec<u8> = (0..300).flat_map(|y| (0..512).flat_map(move |x| pixel(x, y))).collect();
        let (width, height, small) = shrunk(512, 300, &rgba);
        assert_eq!((width, height), (256, 150));
        assert!(small.chunks_exact(4).all(|p| p == [50, 25, 7, 255]));
    }

    #[test]
    fn small_images_stay_as_they_are_and_thin_ones_do_no_harm() {
        let rgba: Vec<u8> = (0..4 * 3 * 2).collect();
        assert_eq!(shrunk(3, 2, &rgba), (3, 2, rgba.clone()));
        assert_eq!(shrunk(1000, 1, &[9; 4000]).1, 0);
        assert_eq!(shrunk(0, 0, &[]), (0, 0, vec![]));
    }
}
