//! One run of a row.

use chance::Chance;
use geometry::{Ct, Tracker};
use surface_registration::{Field, Limits, Options, Points, Priors, SharedError, Start, Surface};
use surface_registration::{SurfaceRegistration, refine, register};

use super::common::change;
use super::common::draw::{Drawn, Source, bound_mm, off, patch, rms, targets, tre_mm};
use super::count::{Count, Truth};
use super::rows::{From, Matter, Row};

pub(crate) struct Scene {
    pub(crate) surface: Surface<Ct>,
    pub(crate) field: Field,
    pub(crate) source: Source,
}

/// Seconds that this thread had a processor for.
fn busy() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

pub(crate) fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let began = busy();
    let made = work();
    (busy() - began, made)
}

/// Deviations of a probe's calibration: a quarter of a degree about each axis, 0.3 mm along it.
const CALIBRATION: [f64; 6] = [0.004, 0.004, 0.004, 0.3, 0.3, 0.3];

/// The points of a run, and what is known of an error that they share.
pub(crate) fn drawn(scene: &Scene, row: &Row, seed: u64) -> (Drawn, Option<SharedError>) {
    let mut sweep = row.sweep;
    if matches!(row.matter, Matter::Priors | Matter::Shared) {
        let (c, priors) = (Chance::new(seed, 1 << 45), Priors::default());
        // A depth that is too long by the share k is found as k / (1 + k).
        let scale = priors.depth_scale * c.normal(0);
        (sweep.speed, sweep.offset_mm) = (scale / (1.0 - scale), priors.offset_mm * c.normal(5));
    }
    let mut drawn = scene.source.draw(&sweep, seed);
    if row.patch_mm > 0.0 {
        drawn = patch(drawn, row.patch_mm, 60);
    }
    let mut shared = None;
    match row.matter {
        Matter::Nothing | Matter::Priors => {}
        Matter::InOrder => drawn = change::in_order(drawn),
        Matter::Moved(mm, is_in_order) => {
            if is_in_order {
                drawn = change::in_order(drawn);
            }
            change::moved(&mut drawn, mm, seed);
        }
        Matter::Held => drawn = change::held(drawn, seed),
        Matter::Skin => drawn = change::skin(drawn),
        Matter::Line => drawn = change::line(drawn, 60),
        Matter::Mirrored => drawn = change::mirrored(drawn),
        Matter::OneSided(mm) => change::one_sided(&mut drawn, &scene.surface, mm, seed),
        Matter::Raised(share, mm) => {
            let is_raised = |i: usize, _| Chance::new(seed, (1 << 50) + i as u64).uniform(0) < share;
            change::raised(&mut drawn, &scene.surface, mm, is_raised);
        }
        Matter::Drifting(mm, is_in_order) => {
            if is_in_order {
                drawn = change::in_order(drawn);
            }
            change::drifting(&mut drawn, mm, seed);
        }
        Matter::Shared => shared = Some(change::with_calibration_error(&mut drawn, CALIBRATION, seed)),
    }
    (drawn, shared)
}

pub(crate) fn run(scene: &Scene, row: &Row, options: &Options, seed: u64, count: &mut Count) {
    let mut options = *options;
    if row.is_pose_only {
        options.priors = Priors {
            depth_scale: 0.0,
            offset_mm: 0.0,
            ..options.priors
        };
    }
    // Points lie on the very surface.
    options.priors.bone_mm = 0.0;
    let (mut drawn, shared) = drawn(scene, row, seed);
    let bound = bound_mm(&scene.surface, &drawn, &targets(), &options.priors);
    for point in &mut drawn.points {
        point.covariance_mm2 *= row.told * row.told;
    }
    count.runs += 1;
    let (time, found) = seconds(|| found(scene, row, &drawn, shared.clone(), seed, &options));
    count.seconds += time;
    count.least_ms.push(time * 1e3);
    if let From::One(..) = row.from {
        // Again at once: what the processor keeps near itself then is there for who refines twenty times a second.
        let again = || seconds(|| self::found(scene, row, &drawn, shared.clone(), seed, &options)).0;
        count.least_ms.pop();
        count
            .least_ms
            .push((0..5).map(|_| again()).fold(f64::INFINITY, f64::min) * 1e3);
    }
    let Some(found) = found else {
        count.failed += 1;
        return;
    };
    let tre = rms(&tre_mm(
        &found.transform.transform(),
        &drawn.ct_from_tracker,
        &targets(),
    ));
    let refusals = Limits::default().judge(&found, &targets());
    if tre < 2.0 {
        count.bound.push(bound);
    }
    let truth = Truth {
        tre,
        kind: row
            .kind
            .of_run(&scene.surface, &drawn, |_| false, &targets(), &options.priors),
        drawn: &drawn,
        targets: &targets(),
    };
    count.judged(row.name, seed, &truth, &found, &refusals);
}

fn found(
    scene: &Scene,
    row: &Row,
    drawn: &Drawn,
    shared: Option<SharedError>,
    seed: u64,
    options: &Options,
) -> Option<SurfaceRegistration<Ct, Tracker>> {
    let points = Points::new(&drawn.points, shared, 0.5).ok()?;
    let (surface, field) = (&scene.surface, &scene.field);
    match row.from {
        From::One(deg, mm) => refine(surface, field, &points, &off(drawn, deg, mm, seed), options).ok(),
        From::Nothing => register(surface, field, &points, &Start::Nothing, options).ok(),
        From::Guess(deg, mm) => {
            let start = Start::Guess {
                pose: off(drawn, deg, mm, seed),
                // Who is off by 180 degrees does not know it.
                turn_rad: if deg > 90.0 { 0.5 } else { (1.2 * deg).to_radians() },
                shift_mm: 1.2 * mm,
            };
            register(surface, field, &points, &start, options).ok()
        }
    }
}
