//! A frame takes no memory once its like was painted: every allocation of the process is counted.

#![allow(
    unsafe_code,
    reason = "an allocator can be replaced in no other way; this one counts and hands on"
)]
#![allow(dead_code, reason = "other tests use more of what is shared")]

#[path = "paint/screens.rs"]
mod screens;

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};

use egui::Color32;
use screens::{CELLS, Content, Screen, lend, texels};
use window::paint::{CpuPainter, Frame, Painter, Pixels};

struct Counting;

static TAKEN: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes on to the system's allocator unchanged; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is handed on.
        unsafe { System.dealloc(place, layout) }
    }
    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn taken(work: impl FnOnce()) -> u64 {
    let before = TAKEN.load(Ordering::Relaxed);
    work();
    TAKEN.load(Ordering::Relaxed) - before
}

/// The only test of its binary: one beside it would be counted too.
#[test]
fn a_frame_takes_no_memory_once_its_like_was_painted() {
    assert_eq!(taken(|| drop(black_box(vec![1_u8; 100]))), 1);
    let size = [640, 400];
    let screen = Screen::new(size, 1.0);
    let pixels: Vec<Vec<u8>> = (0..CELLS as u32).map(|i| texels([90, 90], i)).collect();
    let mut painter = CpuPainter::new();
    let mut memory = vec![0; 640 * 400];
    for round in 0..30 {
        // The same ten frames again and again, so that the later ones have had their like; images change in all.
        let content = Content {
            moment: round % 10,
            tint: Color32::WHITE,
        };
        let mut made = screen.make(content);
        let images = lend(&pixels, 90, u64::from(round));
        let frame = Frame {
            size,
            pixels_per_point: 1.0,
            clear: Color32::BLACK,
            textures: &mut made.textures,
            primitives: &made.primitives,
            images: &images,
        };
        let target = Pixels {
            pixels: &mut memory,
            age: u8::from(round % 7 != 0),
        };
        let count = taken(|| assert!(black_box(painter.paint(frame, target)).is_ok()));
        assert!(count == 0 || round < 20, "frame {round} took memory {count} times");
    }
}
