//! One run of a row, and what is counted over many.

use chance::Chance;
use geometry::{Ct, Point, Tracker};
use surface_registration::{Field, Limits, Options, Points, Priors, Refusal, SharedError, Start, Surface};
use surface_registration::{SurfaceRegistration, refine, register};

use super::common::change;
use super::common::draw::{Drawn, Source, bound_mm, chi2, off, patch, rms, targets, tre_mm};
use super::rows::{From, Matter, Row};

pub(crate) struct Scene {
    pub(crate) surface: Surface<Ct>,
    pub(crate) field: Field,
    pub(crate) source: Source,
}

#[derive(Default)]
pub(crate) struct Count {
    pub(crate) runs: usize,
    pub(crate) right: usize,
    pub(crate) wrong: usize,
    pub(crate) silent: usize,
    pub(crate) refused: usize,
    pub(crate) failed: usize,
    /// Refused as moved, of all and of the right ones.
    pub(crate) moved: usize,
    pub(crate) right_moved: usize,
    /// Refused of all.
    pub(crate) stopped: usize,
    pub(crate) tre: Vec<f64>,
    /// Of all that have a result.
    pub(crate) all_tre: Vec<f64>,
    pub(crate) bound: Vec<f64>,
    pub(crate) within: usize,
    pub(crate) looked: usize,
    /// Squares of errors at targets in their covariance.
    pub(crate) squares: Vec<f64>,
    pub(crate) seconds: f64,
    /// Of each run; of one start the second time.
    pub(crate) least_ms: Vec<f64>,
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
    count.judged(row.name, seed, tre, &found, &refusals, &drawn, &targets());
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

pub(crate) fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Count {
    /// Counts what became of a run.
    #[allow(clippy::too_many_arguments, reason = "all that is known of a run")]
    pub(crate) fn judged(
        &mut self,
        name: &str,
        seed: u64,
        tre: f64,
        found: &SurfaceRegistration<Ct, Tracker>,
        refusals: &[Refusal],
        drawn: &Drawn,
        targets: &[Point<Ct>],
    ) {
        self.all_tre.push(tre);
        let is_refused = refusals.iter().any(|r| *r != Refusal::NotSearched);
        let is_moved = refusals.iter().any(|r| matches!(r, Refusal::Moved { .. }));
        self.stopped += usize::from(is_refused);
        self.moved += usize::from(is_moved);
        self.wrong += usize::from(tre >= 4.0);
        if std::env::var_os("WHY").is_some() {
            println!(
                "  {name} {seed} {tre:.2} share beyond {:.2}, {:?}, {} seeds, {} steps",
                found.share_beyond,
                found.halves.as_ref().map(|h| (h.before, h.square)),
                found.seeds,
                found.steps,
            );
            refusals.iter().for_each(|r| println!("  {seed} {tre:.2} {r}"));
        }
        if tre >= 4.0 && !is_refused {
            self.silent += 1;
            println!(
                "  SILENT {name} seed {seed}: TRE {tre:.1}, ratio {:.2}, margin {:?}, share {:.2}, beyond {:.2}, hits {}",
                found.noise_ratio,
                found.margin(),
                found.share_kept,
                found.share_beyond,
                found.hits
            );
        }
        if tre < 2.0 {
            self.right += 1;
            self.refused += usize::from(is_refused);
            self.right_moved += usize::from(is_moved);
            self.tre.push(tre);
        }
        // Of all that are in the right minimum, right by 2 mm or not.
        if !is_refused || tre < 6.0 {
            for target in targets {
                let square = chi2(found, &drawn.ct_from_tracker, *target);
                self.looked += 1;
                self.within += usize::from(square < 7.815);
                self.squares.push(square);
            }
        }
    }

    /// Adds what is counted of a row to what is counted of all.
    pub(crate) fn add(&mut self, row: &Self) {
        self.runs += row.runs;
        self.wrong += row.wrong;
        self.silent += row.silent;
        self.right += row.right;
        self.refused += row.refused;
        self.failed += row.failed;
        self.right_moved += row.right_moved;
        self.seconds += row.seconds;
    }

    /// Of a row of [`super::ends`]: beside the counts the mean share beyond the end, and of the runs that were taken the errors' root mean
    /// square with the predicted one.
    pub(crate) fn line_of_end(&self, name: &str, beyond: f64, [tre, predicted]: [f64; 2]) -> String {
        format!(
            "| {name} | {} of {} | {} | {} | {} | {:.0} % | {tre:.2}, {predicted:.2} | {:.1} | {:.2} | {:.1} |",
            self.right,
            self.runs,
            self.wrong,
            self.silent,
            self.refused,
            100.0 * beyond,
            self.coverage(),
            self.squares.iter().sum::<f64>() / self.squares.len() as f64 / 3.0,
            self.ms(),
        )
    }

    /// Milliseconds of a run, their mean.
    pub(crate) fn ms(&self) -> f64 {
        1e3 * self.seconds / self.runs as f64
    }

    /// Share of targets within the 95 % that were promised, %.
    pub(crate) fn coverage(&self) -> f64 {
        100.0 * self.within as f64 / self.looked as f64
    }

    pub(crate) fn line(&self, name: &str) -> String {
        format!(
            "| {name} | {} of {} | {} | {} | {} | {}, {} | {:.2} | {:.2}, {:.2} | {:.1} | {:.2} | {:.2}, {:.2} |",
            self.right,
            self.runs,
            self.wrong,
            self.silent,
            self.refused,
            self.moved,
            self.right_moved,
            middle(&self.tre),
            middle(&self.tre) / middle(&self.bound),
            rms(&self.tre) / rms(&self.bound),
            self.coverage(),
            // Of three degrees of freedom.
            self.squares.iter().sum::<f64>() / self.squares.len() as f64 / 3.0,
            self.ms(),
            middle(&self.least_ms),
        )
    }
}
