//! What happened when, as a strip chart: a lane for each state, each stage, marks and restarts. A lane's name stands beside it, so that
//! no colour has to say what it is.

use std::fmt::Write;

use super::axis::{LEFT, RIGHT, TimeAxis, WIDTH};
use super::curve::times;
use super::escape::text;
use crate::report::facts::Facts;
use crate::report::states::State;

const LANE: f64 = 20.0;
const TOP: f64 = 6.0;
/// Shorter pieces are drawn as long, so that they are seen.
const LEAST: f64 = 1.5;
/// A letter takes no more, units.
const LETTER: f64 = 8.0;

/// A lane: its name and what is drawn in it, as SVG with its top at 0.
struct Lane {
    name: String,
    drawn: String,
}

/// Draws the whole recording.
pub(super) fn draw(facts: &Facts, time: &TimeAxis) -> String {
    let mut lanes = vec![marks(facts, time), restarts(facts, time)];
    lanes.extend(states(facts, time));
    lanes.extend(stages(facts, time));
    let lanes: Vec<Lane> = lanes.into_iter().filter(|lane| !lane.drawn.is_empty()).collect();
    let bottom = TOP + LANE * lanes.len() as f64;
    let mut svg = String::new();
    let title = "What happened when: states, stages, marks and restarts over the time of the run";
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {WIDTH} {}\" role=\"img\" \
         aria-label=\"{title}\">\n<title>{title}</title>",
        bottom + 40.0
    );
    times(&mut svg, time, TOP, bottom, bottom + 18.0);
    for (place, lane) in lanes.iter().enumerate() {
        let y = TOP + LANE * place as f64;
        let _ = writeln!(
            svg,
            "<g transform=\"translate(0 {y})\"><text x=\"{}\" y=\"14\" class=\"end\">{}</text><line class=\"grid\" x1=\"{LEFT}\" \
             x2=\"{RIGHT}\" y1=\"{LANE}\" y2=\"{LANE}\"/>{}</g>",
            LEFT - 6.0,
            text(&lane.name),
            lane.drawn
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{RIGHT}\" y=\"{}\" class=\"end\">time of the run, min:s</text>",
        bottom + 35.0
    );
    svg + "</svg>\n"
}

/// Numbers of marks that lie too near to each other are told together: `3-7`.
fn marks(facts: &Facts, time: &TimeAxis) -> Lane {
    let times = facts
        .marks
        .listed
        .iter()
        .zip(1..)
        .map(|(mark, number)| (mark.t_ns, number));
    Lane {
        name: "mark number".to_owned(),
        drawn: numbered(times, time),
    }
}

fn restarts(facts: &Facts, time: &TimeAxis) -> Lane {
    let times = facts
        .story
        .restarts
        .listed
        .iter()
        .zip(1..)
        .map(|(restart, number)| (restart.t_ns, number));
    Lane {
        name: "restart number".to_owned(),
        drawn: numbered(times, time),
    }
}

fn numbered(times: impl Iterator<Item = (i64, u64)>, time: &TimeAxis) -> String {
    let mut at: Vec<(f64, u64)> = times.map(|(t_ns, number)| (time.x(t_ns), number)).collect();
    at.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut drawn = String::new();
    // First and last number of a group, and where it begins.
    let mut groups: Vec<(f64, u64, u64)> = Vec::new();
    for (x, number) in at {
        let _ = write!(
            drawn,
            "<line class=\"tick\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"2\" y2=\"{}\"/>",
            LANE - 2.0
        );
        match groups.last_mut() {
            Some((start, first, last)) if x < *start + width((*first).min(number), (*last).max(number)) => {
                (*first, *last) = ((*first).min(number), (*last).max(number));
            }
            _ => groups.push((x, number, number)),
        }
    }
    for (x, first, last) in groups {
        let words = words(first, last);
        // At the right edge it stands before its line.
        let (x, class) = match x + width(first, last) > WIDTH {
            true => (x - 3.0, "end"),
            false => (x + 3.0, "start"),
        };
        let _ = write!(drawn, "<text x=\"{x:.1}\" y=\"14\" class=\"{class}\">{words}</text>");
    }
    drawn
}

fn words(first: u64, last: u64) -> String {
    match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    }
}

fn width(first: u64, last: u64) -> f64 {
    6.0 + LETTER * words(first, last).len() as f64
}

fn states(facts: &Facts, time: &TimeAxis) -> Vec<Lane> {
    let states = &facts.curves.states;
    let lane = |state: State| {
        let cells = states.columns.each().filter(|(_, shares)| shares.of(state) > 0);
        let class = match state {
            State::Live => "live",
            State::Stale => "stale",
            State::Lost(_) | State::Missing => "lost",
            State::NotYet | State::NotReadable | State::Ending => "unknown",
        };
        Lane {
            name: state.words(),
            drawn: bars(joined(cells.map(|(span, _)| span)), class, time),
        }
    };
    State::all().map(lane).collect()
}

fn stages(facts: &Facts, time: &TimeAxis) -> Vec<Lane> {
    let stages = &facts.story.stages.listed;
    let ends = stages.iter().skip(1).map(|next| next.t_ns).chain([time.to_ns]);
    let spans: Vec<(&str, (i64, i64))> = stages
        .iter()
        .zip(ends)
        .map(|(stage, to_ns)| (stage.stage.as_str(), (stage.t_ns, to_ns)))
        .collect();
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in &spans {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let lane = |name: &str| {
        let of = spans.iter().filter(|(other, _)| *other == name).map(|(_, span)| *span);
        Lane {
            name: format!("stage {name}"),
            drawn: bars(joined(of), "stage", time),
        }
    };
    names.into_iter().map(lane).collect()
}

/// Neighbours that touch are one.
fn joined(spans: impl Iterator<Item = (i64, i64)>) -> Vec<(i64, i64)> {
    let mut all: Vec<(i64, i64)> = Vec::new();
    for (from_ns, to_ns) in spans {
        match all.last_mut() {
            Some((_, end_ns)) if *end_ns == from_ns => *end_ns = to_ns,
            _ => all.push((from_ns, to_ns)),
        }
    }
    all
}

fn bars(spans: Vec<(i64, i64)>, class: &str, time: &TimeAxis) -> String {
    let mut drawn = String::new();
    for (from_ns, to_ns) in spans {
        let x = time.x(from_ns).min(RIGHT - LEAST);
        let width = (time.x(to_ns) - x).max(LEAST);
        let _ = write!(
            drawn,
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"4\" width=\"{width:.1}\" height=\"{}\"/>",
            LANE - 8.0
        );
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn numbers_that_would_touch_are_told_together() {
        let time = TimeAxis {
            from_ns: 0,
            to_ns: 100 * S,
        };
        let near = [10, 11, 50, 99, 100].map(|s| s * S).into_iter().zip(1..);
        let drawn = numbered(near, &time);
        let words: Vec<&str> = drawn
            .split("</text>")
            .filter_map(|part| part.rsplit_once('>'))
            .map(|(_, w)| w)
            .collect();
        assert_eq!(words, ["1-2", "3", "4-5"]);
        assert_eq!(drawn.matches("<line").count(), 5);
    }

    #[test]
    fn short_moments_are_seen_and_neighbours_are_one() {
        let time = TimeAxis {
            from_ns: 0,
            to_ns: 3600 * S,
        };
        let spans = joined([(0, S), (S, 2 * S), (3600 * S - 1, 3600 * S)].into_iter());
        assert_eq!(spans.len(), 2);
        let drawn = bars(spans, "lost", &time);
        assert_eq!(drawn.matches("width=\"1.5\"").count(), 2, "{drawn}");
    }
}
