//! What each dial is worth: right of all, error and time, as a table and a picture.

use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use surface_registration::{Effort, Field, Options, Spacing};

use super::common::draw::Sweep;
use super::common::oracle::Triangles;
use super::count::{Count, middle};
use super::rows::{From, Matter, Row};
use super::run::{Scene, run};
use super::trade::{Dial as Traded, Trade};

struct Dial {
    name: &'static str,
    values: &'static [f64],
    from: From,
    outliers: f64,
    /// Sets it: points, options and lattice.
    set: fn(f64, &mut Sweep, &mut Options, &mut Spacing),
}

const NEAR: From = From::Guess(30.0, 30.0);

const DIALS: [Dial; 7] = [
    Dial {
        name: "seeds",
        values: &[200.0, 1000.0, 5000.0, 20_000.0, 60_000.0],
        from: From::Guess(60.0, 50.0),
        outliers: 0.4,
        set: |x, _, options, _| options.effort.seeds = x as usize,
    },
    Dial {
        name: "seeds fitted",
        values: &[10.0, 50.0, 150.0, 400.0, 1000.0],
        from: From::Guess(60.0, 50.0),
        outliers: 0.4,
        set: |x, _, options, _| options.effort.tried = x as usize,
    },
    Dial {
        name: "points of the sample",
        values: &[12.0, 24.0, 48.0, 96.0],
        from: From::Guess(60.0, 50.0),
        outliers: 0.4,
        set: |x, _, options, _| options.effort.sample = x as usize,
    },
    Dial {
        name: "pairs, no guess",
        values: &[2.0, 5.0, 15.0, 40.0],
        from: From::Nothing,
        outliers: 0.4,
        set: |x, _, options, _| options.effort.pairs = x as usize,
    },
    Dial {
        name: "points",
        values: &[25.0, 50.0, 100.0, 200.0, 500.0],
        from: NEAR,
        outliers: 0.2,
        set: |x, sweep, _, _| sweep.points = x as usize,
    },
    Dial {
        name: "lattice, mm",
        values: &[1.5, 2.0, 3.0, 4.0, 6.0],
        from: NEAR,
        outliers: 0.2,
        set: |x, _, _, spacing| spacing.spacing_mm = x,
    },
    Dial {
        name: "kernel's end",
        values: &[2.5, 3.5, 4.5, 6.0, 9.0],
        from: NEAR,
        outliers: 0.2,
        set: |x, _, options, _| options.kernel_end = x,
    },
];

impl Dial {
    /// So many runs with one value.
    fn count(&self, value: f64, scene: &mut Scene, spacing: &mut Spacing, runs: u64) -> Count {
        let mut row = Row {
            kind: super::kinds::Kind::Holds,
            name: self.name,
            sweep: Sweep {
                outliers: self.outliers,
                ..Sweep::default()
            },
            from: self.from,
            is_pose_only: false,
            patch_mm: 0.0,
            told: 1.0,
            matter: Matter::Nothing,
        };
        let (mut options, mut wanted) = (Options::default(), Spacing::default());
        (self.set)(value, &mut row.sweep, &mut options, &mut wanted);
        if wanted != *spacing {
            scene.field = Field::new(&scene.surface, wanted).unwrap();
            *spacing = wanted;
        }
        let mut count = Count::default();
        for seed in 0..runs {
            run(scene, &row, &options, 9_000_000 + seed, &mut count);
        }
        count
    }
}

/// Points, the seeds that are fitted and the lattice of distances. The error is that of the last but a tenth of all runs, wrong ones too.
pub(crate) fn trade(trade: &Trade, mut scene: Scene) {
    let (runs, mut spacing) = (trade.rounds(3, 40) as u64, Spacing::default());
    let dials = [
        ("points", "surface-points", 200.0, " points"),
        (
            "seeds fitted",
            "surface-fitted",
            Effort::default().tried as f64,
            " seeds",
        ),
        ("lattice, mm", "surface-lattice", Spacing::default().spacing_mm, " mm"),
    ];
    for (dial, name, chosen, unit) in dials {
        let dial = DIALS.iter().find(|d| d.name == dial).unwrap();
        let rows: Vec<_> = dial
            .values
            .iter()
            .map(|value| {
                let count = dial.count(*value, &mut scene, &mut spacing, runs);
                (format!("{value}{unit}"), middle(&count.least_ms), nine_of_ten(&count))
            })
            .collect();
        let traded = Traded {
            name,
            chosen: format!("{chosen}{unit}"),
            time_unit: "ms a registration",
            error_unit: "mm",
            against: "root mean square at six targets that nine of ten drawn sweeps of a pelvis stay below; a fifth of the points are gross errors (seeds: two fifths)",
        };
        trade.write(&traded, &rows);
    }
}

/// A run without a result is worse than any.
fn nine_of_ten(count: &Count) -> f64 {
    let mut sorted = count.all_tre.clone();
    sorted.extend((0..count.failed).map(|_| f64::INFINITY));
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(f64::NAN)
}

pub(crate) fn dials((corners, triangles): &Triangles, mut scene: Scene, runs: u64, file: &str) {
    println!(
        "{} corners, {} triangles; {:?}",
        corners.len(),
        triangles.len(),
        Effort::default()
    );
    println!("| dial | value | right | median TRE, mm | within the 95 % | ms |");
    println!("|---|---|---|---|---|---|");
    let mut chart = Chart::new(
        "Dials of the registration by the surface",
        Axis::log("time of a thread's processor, ms"),
        Axis::log("median TRE, mm"),
    );
    let mut spacing = Spacing::default();
    for (k, dial) in DIALS.iter().enumerate() {
        let mut line = Vec::new();
        for value in dial.values {
            let count = dial.count(*value, &mut scene, &mut spacing, runs);
            println!(
                "| {} | {value} | {} of {} | {:.2} | {:.1} | {:.1} |",
                dial.name,
                count.right,
                count.runs,
                middle(&count.tre),
                count.coverage(),
                count.ms()
            );
            line.push([count.ms(), middle(&count.tre)]);
        }
        let marks = Mark::ALL;
        chart.push(Series::joined(
            dial.name,
            COLOURS[k % COLOURS.len()],
            marks[k % marks.len()],
            line,
        ));
    }
    let drawn = chart.draw(1000, 700);
    picture::write_png(std::path::Path::new(file), &drawn.canvas, &[]).unwrap();
}
