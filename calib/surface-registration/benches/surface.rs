//! How often a registration by the surface is right, how near it comes, what it promises, what it refuses and what it takes.
//!
//! `cargo bench -p surface-registration --bench surface -- [runs] [words of rows]`. Points are drawn on the phantom of
//! `shared/oracles/surface` (`TROCAR_SHARED`), seeds of this bench's own. A run is right with a root mean square TRE below 2 mm at six
//! targets, wrong from 4 mm on. Times are those that a thread had a processor for.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::draw::{Drawn, LEFT, Source, Sweep, bound_mm, checked_points, chi2, off, patch, rms, targets, tre_mm};
use common::oracle;
use geometry::{Ct, Tracker};
use surface_registration::{Effort, Field, Limits, Options, Priors, Spacing, Start, Surface, SurfaceRegistration};
use surface_registration::{refine, register};

/// How a run begins.
#[derive(Clone, Copy, PartialEq)]
enum From {
    /// Degrees and millimetres off; searched within 1.2 times that.
    Guess(f64, f64),
    /// The same, one start followed alone.
    One(f64, f64),
    Nothing,
}

struct Row {
    name: &'static str,
    sweep: Sweep,
    from: From,
    /// Pose alone: depth scale and offset held at 0.
    is_pose_only: bool,
    /// Points of one patch of this radius, mm; 0 takes all.
    patch_mm: f64,
    /// What the solver is told of the noise, times the truth.
    told: f64,
}

/// Seconds that this thread had a processor for.
fn busy() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}

fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let began = busy();
    let made = work();
    (busy() - began, made)
}

fn rows() -> Vec<Row> {
    let all = Sweep::default();
    let crest = Sweep {
        regions: LEFT,
        points: 100,
        ..all
    };
    let row = |name, sweep, from| Row {
        name,
        sweep,
        from,
        is_pose_only: false,
        patch_mm: 0.0,
        told: 1.0,
    };
    let with = |outliers: f64, sweep: Sweep| Sweep { outliers, ..sweep };
    let fine = |points: usize| Sweep {
        points,
        outliers: 0.0,
        ..all
    };
    let wrong = Sweep {
        outliers: 0.1,
        speed: 0.04,
        offset_mm: -1.0,
        ..all
    };
    vec![
        row("crests + pubis 200, 20 %, 30/30", all, From::Guess(30.0, 30.0)),
        row("crests + pubis 200, 20 %, 60/50", all, From::Guess(60.0, 50.0)),
        row(
            "crests + pubis 200, 40 %, 20/20",
            with(0.4, all),
            From::Guess(20.0, 20.0),
        ),
        row("one crest 100, 30 %, 10/10", with(0.3, crest), From::Guess(10.0, 10.0)),
        row("one crest 100, 10 %, 10/10", with(0.1, crest), From::Guess(10.0, 10.0)),
        row("no guess 200, 10 %", with(0.1, all), From::Nothing),
        row("no guess 200, 40 %", with(0.4, all), From::Nothing),
        row("one start 200, 20 %, 10/10", all, From::One(10.0, 10.0)),
        row("one start 200, 20 %, 30/30", all, From::One(30.0, 30.0)),
        Row {
            is_pose_only: true,
            ..row("pose only 200, 0 %, 10/10", fine(200), From::Guess(10.0, 10.0))
        },
        Row {
            is_pose_only: true,
            ..row("pose only 500, 0 %, 10/10", fine(500), From::Guess(10.0, 10.0))
        },
        Row {
            is_pose_only: true,
            ..row("pose only 200, 20 %, 10/10", all, From::Guess(10.0, 10.0))
        },
        Row {
            is_pose_only: true,
            ..row(
                "pose only 500, 30 %, 20/20",
                Sweep {
                    points: 500,
                    ..with(0.3, all)
                },
                From::Guess(20.0, 20.0),
            )
        },
        row(
            "all unknowns 500, 30 %, 20/20",
            Sweep {
                points: 500,
                ..with(0.3, all)
            },
            From::Guess(20.0, 20.0),
        ),
        row(
            "pointer 20, 0 %, 10/10",
            Sweep {
                points: 20,
                sigma_mm: [0.4; 3],
                has_beams: false,
                ..with(0.0, all)
            },
            From::Guess(10.0, 10.0),
        ),
        row(
            "pointer 40, 10 %, 10/10",
            Sweep {
                points: 40,
                sigma_mm: [0.4; 3],
                has_beams: false,
                ..with(0.1, all)
            },
            From::Guess(10.0, 10.0),
        ),
        row("bone 1 mm out and 4 % speed, 200, 10 %", wrong, From::Guess(10.0, 10.0)),
        Row {
            patch_mm: 14.0,
            ..row(
                "patch of 14 mm, 5 %, 10/10",
                Sweep {
                    points: 6000,
                    ..with(0.05, all)
                },
                From::Guess(10.0, 10.0),
            )
        },
        row("60 % echoes 200, 20/20", with(0.6, all), From::Guess(20.0, 20.0)),
        row("guess 180 degrees off, 20 %", all, From::Guess(180.0, 10.0)),
        Row {
            told: 0.1,
            ..row("noise told 10 x too small", all, From::Guess(10.0, 10.0))
        },
        Row {
            told: 10.0,
            ..row("noise told 10 x too large", all, From::Guess(10.0, 10.0))
        },
        row(
            "one crest 20, 10 %, 10/10",
            Sweep {
                points: 20,
                ..with(0.1, crest)
            },
            From::Guess(10.0, 10.0),
        ),
    ]
}

struct Scene {
    surface: Surface<Ct>,
    field: Field,
    source: Source,
}

#[derive(Default)]
struct Count {
    runs: usize,
    right: usize,
    wrong: usize,
    silent: usize,
    refused: usize,
    failed: usize,
    tre: Vec<f64>,
    bound: Vec<f64>,
    within: usize,
    looked: usize,
    ms: Vec<f64>,
}

fn run(scene: &Scene, row: &Row, seed: u64, count: &mut Count) {
    let mut options = Options::default();
    if row.is_pose_only {
        options.priors = Priors {
            depth_scale: 0.0,
            offset_mm: 0.0,
            ..options.priors
        };
    }
    // Points lie on the very surface.
    options.priors.bone_mm = 0.0;
    let mut drawn = scene.source.draw(&row.sweep, seed);
    if row.patch_mm > 0.0 {
        drawn = patch(drawn, row.patch_mm, 60);
    }
    let bound = bound_mm(&scene.surface, &drawn, &targets(), &options.priors);
    for point in &mut drawn.points {
        point.covariance_mm2 *= row.told * row.told;
    }
    count.runs += 1;
    let (time, found) = seconds(|| found(scene, row, &drawn, seed, &options));
    count.ms.push(time * 1e3);
    let Some(found) = found else {
        count.failed += 1;
        return;
    };
    let each = tre_mm(&found.transform.transform(), &drawn.ct_from_tracker, &targets());
    let tre = rms(&each);
    let refusals = Limits::default().judge(&found, &targets());
    if std::env::var_os("WHY").is_some() {
        println!("  {seed}: {} steps, {:.1} ms", found.steps, time * 1e3);
    }
    let is_refused = refusals
        .iter()
        .any(|r| *r != surface_registration::Refusal::NotSearched);
    count.wrong += usize::from(tre >= 4.0);
    if tre >= 4.0 && !is_refused {
        count.silent += 1;
        println!(
            "  SILENT {} seed {seed}: TRE {tre:.1}, ratio {:.2}, margin {:?}, share {:.2}, hits {}",
            row.name,
            found.noise_ratio,
            found.margin(),
            found.share_kept,
            found.hits
        );
    }
    if tre < 2.0 {
        count.right += 1;
        count.refused += usize::from(is_refused);
        if is_refused && std::env::var_os("WHY").is_some() {
            refusals.iter().for_each(|r| println!("  {seed} {tre:.2} {r}"));
        }
        count.tre.push(tre);
        count.bound.push(bound);
    }
    // Of all that are in the right minimum, right by 2 mm or not.
    if !is_refused || tre < 6.0 {
        count.looked += targets().len();
        count.within += targets()
            .iter()
            .filter(|t| chi2(&found, &drawn.ct_from_tracker, **t) < 7.815)
            .count();
    }
}

fn found(
    scene: &Scene,
    row: &Row,
    drawn: &Drawn,
    seed: u64,
    options: &Options,
) -> Option<SurfaceRegistration<Ct, Tracker>> {
    let points = checked_points(drawn);
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

fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let runs = args.first().and_then(|a| a.parse().ok()).unwrap_or(80);
    let Some(bone) = oracle::bone("pelvis-phantom") else {
        return;
    };
    let (surface_s, surface) = seconds(|| Surface::<Ct>::new(&bone.0, &bone.1).unwrap());
    let (field_s, field) = seconds(|| Field::new(&surface, Spacing::default()).unwrap());
    println!(
        "surface {surface_s:.3} s, field {field_s:.3} s ({} nodes); {:?}",
        field.nodes(),
        Effort::default()
    );
    let scene = Scene {
        surface,
        field,
        source: Source::new(&bone),
    };
    println!("| row | right | wrong | silent | right refused | TRE mm | over bound: median, rms | 95 % | ms |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut all = Count::default();
    for row in rows()
        .iter()
        .filter(|row| args.len() < 2 || args[1..].iter().all(|word| row.name.contains(word.as_str())))
    {
        let mut count = Count::default();
        for seed in 0..runs {
            run(&scene, row, 7_000_000 + seed, &mut count);
        }
        println!(
            "| {} | {} of {} | {} | {} | {} | {:.2} | {:.2}, {:.2} | {:.1} | {:.1} |",
            row.name,
            count.right,
            count.runs,
            count.wrong,
            count.silent,
            count.refused,
            middle(&count.tre),
            middle(&count.tre) / middle(&count.bound),
            rms(&count.tre) / rms(&count.bound),
            100.0 * count.within as f64 / count.looked as f64,
            middle(&count.ms),
        );
        if !matches!(row.from, From::One(..)) {
            all.runs += count.runs;
            all.wrong += count.wrong;
            all.silent += count.silent;
            all.right += count.right;
            all.refused += count.refused;
            all.failed += count.failed;
        }
    }
    println!(
        "searched: {} runs, {} wrong by 4 mm and more, {} of them not refused; {} right, {} of them refused; {} without a result",
        all.runs, all.wrong, all.silent, all.right, all.refused, all.failed
    );
}
