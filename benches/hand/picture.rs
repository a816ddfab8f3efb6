//! The study as one picture of four charts.

use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::{Canvas, Rgb};

use crate::figures::{Figures, Median};
use crate::study::{CONTENT_MM, Display, Done, LAGS_MS, NOISE_MM, NOISES_MM};

/// Columns and rows of one chart.
const SIZE: [u32; 2] = [760, 540];
/// By the noise.
const MARKS: [Mark; 3] = [Mark::Circle, Mark::Dot, Mark::Square];

/// All four.
pub fn draw(done: &[Done]) -> Canvas {
    let [width, height] = SIZE;
    let mut canvas = Canvas::new(2 * width, 2 * height);
    let charts = [
        over_lag(
            done,
            "Time to target: median, 95 % interval",
            "time to target, s",
            |f| f.time_s,
        ),
        over_lag(done, "True final miss: median, 95 % interval", "true miss, mm", |f| {
            f.miss_mm
        }),
        trade(done),
        compared(done),
    ];
    for (k, chart) in (0_u32..).zip(charts) {
        let drawn = chart.draw(width, height);
        canvas.paste(drawn.canvas.rgba(), width, k % 2 * width, k / 2 * height);
    }
    canvas
}

fn colour(display: Display) -> Rgb {
    match display {
        Display::Sight => COLOURS[0],
        Display::Slices => COLOURS[1],
        Display::Pixels => COLOURS[2],
    }
}

fn of(done: &[Done], display: Display, is_it: impl Fn(&Done) -> bool) -> Option<&Done> {
    done.iter().find(|done| done.case.display == display && is_it(done))
}

/// A figure over the added lag, for each display and noise.
fn over_lag(done: &[Done], title: &str, y: &str, figure: fn(&Figures) -> Median) -> Chart {
    let mut chart = Chart::new(
        title,
        Axis::linear("added lag, ms").within(-10.0, 210.0),
        Axis::linear(y),
    );
    let mut highest: f64 = 0.0;
    for display in [Display::Slices, Display::Sight] {
        for (noise_mm, mark) in NOISES_MM.into_iter().zip(MARKS) {
            let at = |lag_ms: f64| {
                let is_it =
                    |d: &Done| d.case.variant.is_empty() && d.case.noise_mm == noise_mm && d.case.lag_ms == lag_ms;
                of(done, display, is_it).map(|d| (lag_ms, figure(&Figures::of(&d.outcomes))))
            };
            let points: Vec<(f64, Median)> = LAGS_MS.into_iter().filter_map(at).collect();
            for (lag_ms, median) in &points {
                let ends = median.interval.map(|value| [*lag_ms, value]);
                highest = highest.max(median.interval[1]);
                chart.push(Series::joined("", colour(display), Mark::None, ends));
            }
            let name = format!("{}, noise {noise_mm} mm", display.word());
            let medians = points.iter().map(|(lag_ms, median)| [*lag_ms, median.value]);
            chart.push(Series::joined(name, colour(display), mark, medians));
        }
    }
    chart.y = chart.y.within(0.0, 1.05 * highest);
    chart
}

/// What the last tenths of a millimetre cost: she lets go by the display's word, or goes on until it shows her less.
fn trade(done: &[Done]) -> Chart {
    let title = format!("Speed for accuracy, at its end (noise {NOISE_MM} mm, no added lag)");
    let mut chart = Chart::new(
        title,
        Axis::linear("time to target, s: median"),
        Axis::linear("true miss, mm"),
    );
    let (mut longest, mut largest): (f64, f64) = (0.0, 0.0);
    for display in [Display::Slices, Display::Sight] {
        let words = CONTENT_MM.map(|mm| format!("on until shown within {mm} mm"));
        let variants = [String::new()].into_iter().chain(words);
        let figures: Vec<Figures> = variants
            .filter_map(|variant| {
                let is_it = |d: &Done| d.case.variant == variant && d.case.noise_mm == NOISE_MM && d.case.lag_ms == 0.0;
                of(done, display, is_it).map(|d| Figures::of(&d.outcomes))
            })
            .collect();
        let [median, most]: [fn(&Figures) -> f64; 2] = [|f| f.miss_mm.value, |f| f.miss_95_mm];
        for (name, y, mark) in [("median", median, Mark::Dot), ("95 of 100 below", most, Mark::Triangle)] {
            let points: Vec<[f64; 2]> = figures.iter().map(|f| [f.time_s.value, y(f)]).collect();
            longest = points.iter().fold(longest, |longest, p| longest.max(p[0]));
            largest = points.iter().fold(largest, |largest, p| largest.max(p[1]));
            let name = format!("{}: {name}", display.word());
            let series = Series::joined(name, colour(display), mark, points);
            chart.push(if mark == Mark::Dot { series } else { series.dashed() });
        }
    }
    chart.x = chart.x.within(0.0, 1.1 * longest);
    chart.y = chart.y.within(0.0, 1.1 * largest);
    chart
}

/// The same tasks by the numbers and by the pixels.
fn compared(done: &[Done]) -> Chart {
    let mut chart = Chart::new(
        "The same tasks read off the pixels",
        Axis::linear("true miss by the sight's numbers, mm"),
        Axis::linear("true miss by the window's pixels, mm"),
    );
    let of = |display: Display| of(done, display, |d| d.case.variant == "compared");
    if let (Some(sight), Some(pixels)) = (of(Display::Sight), of(Display::Pixels)) {
        let points = sight.outcomes.iter().zip(&pixels.outcomes);
        let points: Vec<[f64; 2]> = points.map(|(a, b)| [a.miss_mm, b.miss_mm]).collect();
        let most = 1.1 * points.iter().flatten().copied().fold(0.0, f64::max);
        chart.x = chart.x.within(0.0, most);
        chart.y = chart.y.within(0.0, most);
        chart.push(Series::joined(
            "equal",
            COLOURS[7],
            Mark::None,
            [[0.0, 0.0], [most, most]],
        ));
        chart.push(Series::scatter("a task", colour(Display::Pixels), Mark::Small, points));
    }
    chart
}
