//! A sample of the whole chain, both markers and all links, takes no memory: every allocation of the thread is counted.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(
    unsafe_code,
    reason = "an allocator can be replaced in no other way; this one counts and hands on"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;
use std::path::Path;

use geometry::Point;
use scene::{Scene, TrackerSource};
use tracker_proc::operating_room::{Frame, OperatingRoom, Script};

struct Counting;

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // A thread that is ending has no counter left; it is not the one that solves.
    let _ = TAKEN.try_with(|taken| taken.set(taken.get() + 1));
}

// SAFETY: every call goes on to the system's allocator unchanged; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is handed on.
        unsafe { System.dealloc(place, layout) }
    }
    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promise is handed on.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn taken(work: impl FnOnce()) -> u64 {
    let before = TAKEN.with(Cell::get);
    work();
    TAKEN.with(Cell::get) - before
}

#[test]
fn a_sample_of_the_chain_takes_no_memory_and_neither_does_a_lost_one() {
    assert_eq!(taken(|| drop(black_box(vec![1_u8; 100]))), 1);
    let text = "[tracker]\nsource = \"operating-room\"\n[tracker.room.marker]\ncone_deg = 180\n[tracker.room.handle]\n\
                radius_mm = 0\n[tracker.room.reference]\ncone_deg = 180\n[tracker.room.faults]\nswapped = [1, 2]\nfrom_s = 1\n";
    let scene = Scene::parse(text, Path::new("s.toml")).unwrap();
    let TrackerSource::OperatingRoom(spec) = &scene.tracker.source else {
        panic!("an operating room")
    };
    let script = Script::of_room(spec, &[], None).unwrap();
    let room = OperatingRoom::new(script, spec, &scene.tracker.ct_from_tracker, 1, 60.0).unwrap();
    let chain = room.chain(Point::new(0.0, 0.0, 0.0)).unwrap();
    // The later ones leave two emitters out that carry each other's names.
    let frames: Vec<Frame> = (0..200).map(|seq| room.frame(seq)).collect();
    let (mut solved, mut outliers) = (0, 0);
    let allocations = taken(|| {
        for frame in &frames {
            assert_eq!((frame.tool.len(), frame.reference.len()), (24, 24));
            let found = black_box(chain.solve(&frame.tool, &frame.reference));
            solved += usize::from(found.is_ok());
            outliers += found.map_or(0, |found| found.outliers);
            assert!(black_box(chain.solve(&frame.tool[..2], &frame.reference)).is_err());
            assert!(black_box(chain.solve(&frame.tool, &[])).is_err());
        }
    });
    assert_eq!((allocations, solved), (0, 200));
    assert!(outliers >= 200, "{outliers}");
}
