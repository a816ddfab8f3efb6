//! A registration takes no memory, and neither does a pose: every allocation of the thread that solves is counted.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(
    unsafe_code,
    reason = "an allocator can be replaced in no other way; this one counts and hands on"
)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use calib::pose::{self, Body, Gates, Localizer, Sighting};
use calib::registration::{Method, Pairs, fit};
use common::{Random, images};
use geometry::{Marker, Point, Rigid, Tracker, Vector};

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
fn the_counter_counts() {
    assert_eq!(taken(|| drop(black_box(vec![1_u8; 100]))), 1);
}

#[test]
fn a_fit_allocates_nothing_by_any_method_and_neither_does_a_refusal() {
    let mut random = Random::new(5);
    for n in [3, 4, 24, 200] {
        let from = random.cloud(n, 50.0);
        let to = images(random.transform(), &from);
        let flat = vec![from[0]; n];
        for method in Method::ALL {
            let solved = taken(|| {
                let fit = fit(Pairs::new(&to, &from).unwrap(), method).unwrap();
                assert!(fit.certificate().is_global());
                black_box(fit.residual_mm(to[0], from[0]));
            });
            assert_eq!(solved, 0, "{method:?}, {n} points");
            let refused = taken(|| assert!(fit(Pairs::new(&to, &flat).unwrap(), method).is_err()));
            assert_eq!(refused, 0, "{method:?}, {n} points at one place");
        }
    }
}

#[test]
fn a_pose_from_emitters_allocates_nothing() {
    let mut random = Random::new(9);
    let places: Vec<Point<Marker>> = random.cloud(24, 50.0).iter().map(|p| retyped(*p)).collect();
    let body = Body::of_points(&places).unwrap();
    let away =
        Rigid::<Tracker, Marker>::from_rotation_vector(random.vector(1.0), Vector::new(0.0, 0.0, 2000.0)).unwrap();
    let mut seen: Vec<Sighting> = Vec::new();
    for (emitter, place) in places.iter().enumerate() {
        let place = away * *place + random.noise([0.1; 3]);
        seen.push(Sighting { emitter, place });
    }
    // One that has to be left out.
    seen[7].place = seen[7].place + Vector::new(5.0, 5.0, 0.0);
    let tip = Point::new(0.0, 0.0, 300.0);
    let localizer = Localizer::isotropic(0.1);
    let solved = taken(|| {
        let pose = pose::solve(&body, tip, &seen, &localizer, &Gates::default()).unwrap();
        assert_eq!((pose.used, pose.outliers), (23, 1));
    });
    let refused = taken(|| assert!(pose::solve(&body, tip, &seen[..2], &localizer, &Gates::default()).is_err()));
    assert_eq!([solved, refused], [0, 0]);
}

fn retyped(p: Point<Tracker>) -> Point<Marker> {
    let [x, y, z] = p.mm();
    Point::new(x, y, z)
}
