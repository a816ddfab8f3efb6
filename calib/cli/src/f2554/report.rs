//! The report in words and as JSON.

use calib::f2554::{Distances, Report, Scatter, Test};
use serde::Serialize;

use crate::calibration::Gate;
use crate::text::line;

/// The value of `trocar_f2554`.
const VERSION: u32 = 1;

/// The report as JSON; lengths in mm.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    pub(super) trocar_f2554: u32,
    /// The first 16 hexadecimal digits of the BLAKE3 of the samples' file, or of the samples as that file.
    pub(super) id: String,
    pub(super) date_utc: String,
    pub(super) program: String,
    /// The file of the samples, or the seed of the simulation.
    pub(super) source: String,
    pub(super) samples: usize,
    /// Touches of a simulation whose pose was lost.
    pub(super) lost: usize,
    pub(super) places: Vec<PlaceRecord>,
    pub(super) single_max_mm: Option<f64>,
    pub(super) turn_max_mm: Option<f64>,
    pub(super) distances: Option<DistancesRecord>,
    pub(super) gates: Vec<Gate>,
    pub(super) verdict: String,
}

#[derive(Debug, Serialize)]
pub(super) struct PlaceRecord {
    place: usize,
    registration_rms_mm: Option<f64>,
    single: Option<ScatterRecord>,
    roll: Option<ScatterRecord>,
    pitch: Option<ScatterRecord>,
    yaw: Option<ScatterRecord>,
    distances: Option<DistancesRecord>,
}

#[derive(Debug, Serialize)]
pub(super) struct ScatterRecord {
    count: usize,
    bias_mm: Option<f64>,
    precision_mm: f64,
    p95_mm: f64,
    max_mm: f64,
    range_deg: [f64; 2],
}

#[derive(Debug, Serialize)]
pub(super) struct DistancesRecord {
    count: usize,
    bias_mm: f64,
    precision_mm: f64,
    p95_mm: f64,
    max_mm: f64,
}

impl From<Scatter> for ScatterRecord {
    fn from(s: Scatter) -> Self {
        Self {
            count: s.count,
            bias_mm: s.bias_mm,
            precision_mm: s.precision_mm,
            p95_mm: s.p95_mm,
            max_mm: s.max_mm,
            range_deg: s.range_rad.map(f64::to_degrees),
        }
    }
}

impl From<Distances> for DistancesRecord {
    fn from(d: Distances) -> Self {
        Self {
            count: d.count,
            bias_mm: d.bias_mm,
            precision_mm: d.precision_mm,
            p95_mm: d.p95_mm,
            max_mm: d.max_mm,
        }
    }
}

impl Record {
    pub(super) fn new(
        report: &Report,
        id: String,
        source: String,
        [samples, lost]: [usize; 2],
        gates: Vec<Gate>,
    ) -> Self {
        let place = |p: &calib::f2554::PlaceReport| {
            let [roll, pitch, yaw] = p.turns.map(|t| t.map(ScatterRecord::from));
            PlaceRecord {
                place: p.place,
                registration_rms_mm: p.registration_rms_mm,
                single: p.single.map(ScatterRecord::from),
                roll,
                pitch,
                yaw,
                distances: p.distances.map(DistancesRecord::from),
            }
        };
        let accepted = gates.iter().all(|gate| gate.kept);
        Self {
            trocar_f2554: VERSION,
            id,
            date_utc: crate::calibration::now(),
            program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
            source,
            samples,
            lost,
            places: report.places.iter().map(place).collect(),
            single_max_mm: report.single_max_mm,
            turn_max_mm: report.turn_max_mm,
            distances: report.distances.map(DistancesRecord::from),
            gates,
            verdict: if accepted { "accepted" } else { "refused" }.to_owned(),
        }
    }
}

/// The report in words.
pub(super) fn text(report: &Report, record: &Record) -> String {
    let mut text = format!(
        "point localization of {}: {} samples at {} places",
        crate::text::shown(&record.source),
        record.samples,
        report.places.len()
    );
    let lost = if record.lost > 0 {
        format!(", {} touches lost", record.lost)
    } else {
        String::new()
    };
    text.push_str(&format!(
        "{lost}\n\nplace  test       samples   turn deg      bias mm  precision mm    95 % mm     max mm\n"
    ));
    for p in &report.places {
        let tests = [p.single, p.turns[0], p.turns[1], p.turns[2]];
        let names = [Test::Single, Test::Roll, Test::Pitch, Test::Yaw];
        for (scatter, test) in tests.iter().zip(names) {
            if let Some(s) = scatter {
                scattered(&mut text, p.place, test, s);
            }
        }
        if let Some(d) = &p.distances {
            distanced(&mut text, &p.place.to_string(), d);
        }
    }
    text.push('\n');
    if let Some(d) = &report.distances {
        distanced(&mut text, "all", d);
    }
    if let Some(mm) = report.single_max_mm {
        line!(
            text,
            "all    single: no sample further than {mm:.3} mm from the mean of its place"
        );
    }
    if let Some(mm) = report.turn_max_mm {
        line!(
            text,
            "all    turns: no sample further than {mm:.3} mm from the mean of its test"
        );
    }
    text.push_str(
        "\nbias: of single, the mean's distance from the registered phantom; of distance, measured less known.\nprecision: \
         deviation from the mean. Nothing here is about the pointer's orientation.\n\n",
    );
    text
}

fn scattered(text: &mut String, place: usize, test: Test, s: &Scatter) {
    let [least, most] = s.range_rad.map(f64::to_degrees);
    let range = if test == Test::Single {
        "-".to_owned()
    } else {
        format!("{least:.0} to {most:.0}")
    };
    // Turned about a tip that is off, the mean of the test is no measurement of the divot.
    let bias = s.bias_mm.filter(|_| test == Test::Single);
    let bias = bias.map_or("-".to_owned(), |mm| format!("{mm:.3}"));
    line!(
        text,
        "{place:>5}  {:<9} {:>8} {range:>10} {bias:>12} {:>13.3} {:>10.3} {:>10.3}",
        test.name(),
        s.count,
        s.precision_mm,
        s.p95_mm,
        s.max_mm
    );
}

fn distanced(text: &mut String, place: &str, d: &Distances) {
    let range = "-";
    line!(
        text,
        "{place:>5}  {:<9} {:>8} {range:>10} {:>12.3} {:>13.3} {:>10.3} {:>10.3}",
        "distance",
        d.count,
        d.bias_mm,
        d.precision_mm,
        d.p95_mm,
        d.max_mm
    );
}
