//! Courses over time as SVG. A course is a band from the least to the largest of each column, so that no peak is missing; it ends where
//! there is no value, and what is not known is hatched and says so.

use std::fmt::Write;

use super::axis::{LEFT, RIGHT, TimeAxis, ValueAxis, WIDTH};
use super::escape::text;
use super::units::plain;
use crate::report::quantity::{Drawn, Quantity};

const HEIGHT: f64 = 250.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 200.0;
/// Where the strip lies that says UNKNOWN.
const UNKNOWN: (f64, f64) = (202.0, 212.0);

/// One course with its name; how it is drawn tells it from the other without colour.
pub(super) struct Course<'a> {
    pub(super) name: &'a str,
    pub(super) of: &'a Quantity,
    /// `line` or `band`: the classes of the style sheet.
    pub(super) class: &'a str,
}

/// Draws courses over one axis of time; `unit` is of the values, `title` says what is drawn.
pub(super) fn draw(title: &str, unit: &str, time: &TimeAxis, courses: &[Course<'_>]) -> String {
    let values = value_axis(courses);
    let mut svg = String::new();
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" \
         aria-label=\"{0}\">\n<title>{0}</title>",
        text(title)
    );
    frame(&mut svg, time, &values, unit);
    for course in courses {
        bands(&mut svg, course, time, &values);
    }
    unknown(&mut svg, courses, time);
    legend(&mut svg, courses);
    svg + "</svg>\n"
}

fn value_axis(courses: &[Course<'_>]) -> ValueAxis {
    let spreads = || courses.iter().filter_map(|course| course.of.spread());
    let least = spreads().map(|s| s.min).fold(f64::INFINITY, f64::min);
    let middle = spreads().map(|s| s.p50).fold(0.0, f64::max);
    let most = spreads().map(|s| s.max).fold(0.0, f64::max);
    ValueAxis::new((if least.is_finite() { least } else { 0.0 }, middle, most), TOP, BOTTOM)
}

fn frame(svg: &mut String, time: &TimeAxis, values: &ValueAxis, unit: &str) {
    let scale = if values.is_log() { ", powers of ten" } else { "" };
    let _ = writeln!(
        svg,
        "<text x=\"{LEFT}\" y=\"{}\" class=\"unit\">{unit}{scale}</text>",
        TOP - 8.0
    );
    for value in values.ticks() {
        let y = values.y(value);
        let _ = writeln!(
            svg,
            "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/><text x=\"{}\" y=\"{:.1}\" \
             class=\"end\">{}</text>",
            LEFT - 6.0,
            y + 5.0,
            plain(value)
        );
    }
    times(svg, time, TOP, BOTTOM, UNKNOWN.1 + 18.0);
    let _ = writeln!(
        svg,
        "<text x=\"{RIGHT}\" y=\"{}\" class=\"end\">time of the run, min:s</text>",
        HEIGHT - 4.0
    );
}

/// The lines and words of an axis of time.
pub(super) fn times(svg: &mut String, time: &TimeAxis, top: f64, bottom: f64, words_at: f64) {
    for (t_ns, words) in time.ticks() {
        let x = time.x(t_ns);
        let _ = writeln!(
            svg,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{top}\" y2=\"{bottom}\"/><text x=\"{x:.1}\" y=\"{words_at}\" \
             class=\"middle\">{words}</text>"
        );
    }
}

fn bands(svg: &mut String, course: &Course<'_>, time: &TimeAxis, values: &ValueAxis) {
    let mut path = String::new();
    let mut band: Vec<(f64, Drawn)> = Vec::new();
    for ((from_ns, to_ns), column) in course.of.columns.each() {
        let Some(drawn) = column.drawn else {
            close(&mut path, &mut band, values);
            continue;
        };
        if band.last().is_some_and(|(_, last)| last.runs.1 != drawn.runs.0) {
            close(&mut path, &mut band, values);
        }
        band.push((time.x(from_ns + (to_ns - from_ns) / 2), drawn));
    }
    close(&mut path, &mut band, values);
    let _ = writeln!(svg, "<path class=\"{}\" d=\"{}\"/>", course.class, path.trim_end());
}

/// Along the largest values there and along the least ones back; a single column is a stroke.
fn close(path: &mut String, band: &mut Vec<(f64, Drawn)>, values: &ValueAxis) {
    let there = band.iter().map(|(x, drawn)| (*x, drawn.range.1));
    let back = band.iter().rev().map(|(x, drawn)| (*x, drawn.range.0));
    for (place, (x, value)) in there.chain(back).enumerate() {
        let command = if place == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{command}{x:.1} {:.1}", values.y(value));
    }
    if !band.is_empty() {
        path.push_str("Z ");
    }
    band.clear();
}

fn unknown(svg: &mut String, courses: &[Course<'_>], time: &TimeAxis) {
    let mut first = None;
    for course in courses {
        for ((from_ns, to_ns), _) in course.of.columns.each().filter(|(_, column)| column.unknown > 0) {
            let x = time.x(from_ns);
            let width = (time.x(to_ns) - x).max(1.2);
            let (top, bottom) = UNKNOWN;
            let _ = writeln!(
                svg,
                "<rect class=\"unknown\" x=\"{x:.1}\" y=\"{top}\" width=\"{width:.1}\" height=\"{}\"/>",
                bottom - top
            );
            first.get_or_insert(x);
        }
    }
    if first.is_some() {
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" class=\"end\">UNKNOWN</text>",
            LEFT - 6.0,
            UNKNOWN.1
        );
    }
}

/// The names above the plot, each behind a piece of what it looks like.
fn legend(svg: &mut String, courses: &[Course<'_>]) {
    let mut x = LEFT;
    for course in courses {
        let _ = writeln!(
            svg,
            "<path class=\"{}\" d=\"M{x} 8L{} 8L{1} 14L{x} 14Z\"/><text x=\"{}\" y=\"16\">{}</text>",
            course.class,
            x + 28.0,
            x + 34.0,
            text(course.name)
        );
        x += 34.0 + 8.0 * course.name.chars().count() as f64 + 24.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_parts_the_course_and_the_unknown_says_so() {
        let mut of = Quantity::new(1e-3, 1e3);
        let s = 1_000_000_000;
        (0..10).for_each(|i| of.add(i * s, 1.0));
        of.unknown(10 * s);
        (11..20).for_each(|i| of.add(i * s, 2.0));
        let course = Course {
            name: "error",
            of: &of,
            class: "line",
        };
        let time = TimeAxis {
            from_ns: 0,
            to_ns: 20 * s,
        };
        let svg = draw("errors", "mm", &time, &[course]);
        let path = svg
            .lines()
            .find(|line| line.starts_with("<path class=\"line\" d=\"M150."))
            .unwrap();
        assert_eq!(path.matches('M').count(), 2, "{path}");
        assert!(svg.contains(">UNKNOWN</text>") && svg.contains("class=\"unknown\""));
    }
}
