//! The tables of strata: what the page and `tables.md` hold.

use bus::message::Lost;

use super::organs;
use super::summary::{Refusals, Summary, WITHIN_MM};
use super::table::{Table, bad, length, percent, plain};
use crate::plan::Plan;
use crate::record::Row;
use crate::truth::LINKS;
use crate::worst;

/// Of the worst operations so many are told.
const WORST: usize = 10;

/// All of them, in order.
pub(super) fn all(plan: &Plan, summaries: &[Summary], rows: &[Row]) -> Vec<Table> {
    let organs = organs::table(summaries, rows);
    let first = [
        misses(summaries),
        accuracy(summaries),
        coverage(summaries),
        budget(summaries),
    ];
    let others = [ways(summaries), lost(summaries), refused(summaries), worst(plan, rows)];
    first.into_iter().chain(organs).chain(others).collect()
}

fn misses(summaries: &[Summary]) -> Table {
    let head = [
        "stratum",
        "arrived",
        "given up",
        "refused",
        "tip from the target, median, mm",
        "95 of 100 within, mm",
        "arrived by the display, the tip outside the target",
    ];
    let row = |s: &Summary| {
        let mut cells = vec![plain(&s.name), plain(s.lines[1]), plain(s.lines[2]), plain(s.lines[3])];
        cells.extend(s.miss_mm.map(length));
        cells.push(match s.false_arrivals {
            0 => plain(0),
            many => bad(many),
        });
        cells
    };
    Table::new("Does the tube reach the node?", &head, summaries.iter().map(row))
}

fn accuracy(summaries: &[Summary]) -> Table {
    let first = [
        "stratum",
        "operations",
        "targets",
        "error, median, mm",
        "95 of 100 within, mm",
    ];
    let row = |s: &Summary| {
        let mut cells = vec![
            plain(&s.name),
            plain(s.approached),
            plain(s.errors_mm.len()),
            length(s.tre_mm[0]),
            length(s.tre_mm[1]),
        ];
        cells.extend(s.within.map(percent));
        cells
    };
    let mut table = Table::new("True error at the targets", &first, summaries.iter().map(row));
    table.head.extend(WITHIN_MM.map(|mm| format!("within {mm} mm, %")));
    table.noted(
        "In brackets intervals of 95 %, by order statistics and after Clopper and Pearson, for as many independent observations as there \
         are operations: the targets of one share a registration. A ? is an end that so few do not bound (of the 0.95 quantile the upper \
         one below 72 operations, of the median both below 6).",
    )
}

fn coverage(summaries: &[Summary]) -> Table {
    let head = [
        "stratum",
        "predicted radius of 95 %, median, mm",
        "within it, %",
        "within the ellipsoid of 95 %, %",
        "NEES, mean",
        "NEES in 95 of 100 studies",
        "word",
    ];
    let row = |s: &Summary| {
        let (nees, [low, high]) = s.nees;
        let word = match s.keeps_its_word() {
            None => plain("nothing predicted"),
            Some(true) => plain("kept"),
            Some(false) => bad("NOT KEPT"),
        };
        let known = |text: String| plain(if high.is_finite() { text } else { String::new() });
        vec![
            plain(&s.name),
            known(format!("{:.2}", s.predicted_mm)),
            percent(s.covered),
            percent(s.in_ellipsoid),
            match nees > high {
                true => bad(format!("{nees:.2}")),
                false => known(format!("{nees:.2}")),
            },
            known(format!("{low:.2} to {high:.2}")),
            word,
        ]
    };
    Table::new("Was the predicted error right?", &head, summaries.iter().map(row)).noted(
        "The ball is as wide as the longest axis of the ellipsoid, and holds more than 95 % where the axes differ; the ellipsoid holds \
         95 % if the covariance is right, and the mean of NEES is 3.",
    )
}

fn budget(summaries: &[Summary]) -> Table {
    let row = |s: &Summary| {
        let mut cells = vec![plain(&s.name)];
        let both = |[found, predicted]: [f64; 2]| match (found.is_finite(), predicted.is_finite()) {
            (false, _) => plain(""),
            (_, true) => plain(format!("{found:.3} / {predicted:.3}")),
            (_, false) => plain(format!("{found:.3} / none")),
        };
        cells.extend(s.links.map(both));
        cells
    };
    let mut table = Table::new(
        "What each link has made of it (root mean square)",
        &["stratum"],
        summaries.iter().map(row),
    );
    let links = LINKS.iter().map(|link| format!("{link}: found / predicted, mm"));
    table.head.extend(links);
    table.noted(
        "registration: touches, tool and CT of the registration, or images of the bone, the probe's calibration and the bone that was taken from the CT; bump: the marker on the patient was moved on it; reference and frame: the noise of the last \
         frame at the patient's marker and at the tool's; marker: the calibrated emitters; tool: tip, base and seat; organs: where the breath, or the tube, had moved the organs since \
         the CT. Nobody predicts a bump, the error of calibrated emitters, nor the breath; what the tube does has a table of its own.",
    )
}

fn ways(summaries: &[Summary]) -> Table {
    let head = ["stratum", "time to the target, median, s", "pictures without a pose, %"];
    let row = |s: &Summary| {
        let lost = match s.lost.is_finite() {
            true => format!("{:.1}", 100.0 * s.lost),
            false => String::new(),
        };
        vec![plain(&s.name), length(s.time_s), plain(lost)]
    };
    Table::new("The ways to the targets", &head, summaries.iter().map(row))
}

fn lost(summaries: &[Summary]) -> Table {
    let head = ["stratum", "reason", "pictures", "of all looked at, %"];
    let rows = summaries.iter().flat_map(|s| {
        let some = Lost::ALL.into_iter().zip(s.reasons).filter(|(_, count)| *count > 0);
        some.map(|(reason, count)| {
            let share = 100.0 * count as f64 / s.pictures as f64;
            vec![
                plain(&s.name),
                plain(reason.words()),
                plain(count),
                plain(format!("{share:.2}")),
            ]
        })
    });
    Table::new("Pictures without a pose", &head, rows).noted("In the words that the operator reads then.")
}

fn refused(summaries: &[Summary]) -> Table {
    let head = [
        "stratum",
        "step",
        "lines",
        "right",
        "wrong",
        "not to be judged",
        "error of what was refused, median, mm",
        "at most",
        "predicted radius of 95 %, median",
    ];
    let row = |name: &str, step: &str, of: &Refusals| {
        let [right, wrong] = of.judged;
        let counts = [of.lines, right, wrong, of.lines - right - wrong].map(plain);
        // Those of the middle are in the file.
        let median = |mm: &[f64]| mm.get(mm.len() / 2).copied();
        let [errors, radii] = &of.known_mm;
        let known = [median(errors), errors.last().copied(), median(radii)];
        let known = known.map(|mm| plain(mm.map_or_else(String::new, |mm| format!("{mm:.2}"))));
        [plain(name), plain(step)]
            .into_iter()
            .chain(counts)
            .chain(known)
            .collect::<Vec<_>>()
    };
    let rows = summaries
        .iter()
        .flat_map(|s| s.refusals.iter().map(move |(step, of)| row(&s.name, step, of)));
    let mut table = Table::new("Refusals", &head, rows);
    for s in summaries.iter().filter(|s| s.missed[1] > 0) {
        let [missed, moved] = s.missed;
        table = table.noted(format!(
            "{}: in {moved} operations the marker on the patient was moved before the check; {missed} of them passed it.",
            s.name
        ));
    }
    table.noted(
        "A refusal of the check, and of a registration by the bone's surface, is right where the registration is truly off at the target by more than the radius \
         that its own covariance gives for 95 of 100, or by more than a check allows. So one is wrong that was made because the predicted error was too large, where \
         the true one was no larger than that; it promised no more. What was refused before there was a registration, and a check that could not be made, cannot be \
         judged. The error is the registration's own, but for the check's, where it is the tool's as it would have been shown.",
    )
}

fn worst(plan: &Plan, rows: &[Row]) -> Table {
    let head = [
        "stratum",
        "operation",
        "target",
        "error, mm",
        "predicted, mm",
        "tip from the target, mm",
    ];
    let row = |row: &Row| {
        let mut cells = vec![plain(&row.stratum), plain(row.number), plain(&row.target)];
        cells.extend([row.tre_mm, row.predicted_mm, row.miss_mm].map(|mm| plain(format!("{mm:.2}"))));
        cells.extend(row.links.map(|[found, _]| plain(format!("{found:.2}"))));
        cells
    };
    let known = worst::worst(plan, rows, WORST);
    let mut table = Table::new("The worst of what was not refused", &head, known.into_iter().map(row));
    table.head.extend(LINKS.map(str::to_owned));
    table.noted(
        "False arrivals come first, the farthest before; then the others by their error. One target of each operation.",
    )
}
