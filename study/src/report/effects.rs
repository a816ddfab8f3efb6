//! What each dial of a factorial sweep does: main effects, interactions, curves.
//!
//! An operation counts by the logarithm of the root mean square over its targets, so that effects are factors: noise that is twice as large
//! doubles an error wherever the other dials stand. A cell is a stratum with at least two operations that were not refused. Effects are taken
//! over those settings of the other dials at which every value of the dial in question has a cell, as means of cells (no weight by
//! how many operations they have): a combination that is refused would else stand for the values that it has.

use std::collections::BTreeMap;

use picture::chart::{Axis, Chart, Series};

use super::charts::{colours, drawn};
use super::page;
use super::table::{Cell, Table, plain};
use crate::plan::{Factor, Plan, Sweep};
use crate::record::{Ended, Row};
use crate::statistics::{Estimate, Sample, contrast, rms};

/// What is told of an operation.
const RESPONSES: [&str; 3] = ["error, mm", "predicted radius, mm", "time, s"];

/// One combination.
struct CellOf {
    /// By response, of logarithms; `None` with less than two operations.
    samples: Option<[Sample; RESPONSES.len()]>,
    /// Lines, those given up, and those refused.
    lines: [usize; 3],
}

/// Cells with the level of each dial.
type Cells<'a> = Vec<(Vec<usize>, &'a CellOf)>;

/// A sweep with what came of it.
pub(super) struct Effects<'a> {
    sweep: &'a Sweep,
    cells: Vec<CellOf>,
}

impl<'a> Effects<'a> {
    /// Of the lines of a study.
    pub(super) fn of(plan: &Plan, sweep: &'a Sweep, rows: &[Row]) -> Self {
        let mut by_stratum: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
        for row in rows {
            by_stratum.entry(&row.stratum).or_default().push(row);
        }
        let strata = plan.strata.iter().skip(sweep.first).take(sweep.cells());
        let cell = |name: &str| cell(by_stratum.get(name).map(Vec::as_slice).unwrap_or_default());
        Self {
            sweep,
            cells: strata.map(|stratum| cell(&stratum.name)).collect(),
        }
    }

    /// Its tables: effects of each dial, interactions, all combinations.
    pub(super) fn tables(&self) -> Vec<Table> {
        vec![self.main(), self.pairs(), self.combinations()]
    }

    /// A curve for each dial, once for each value of the next one.
    ///
    /// # Errors
    /// The system's.
    pub(super) fn charts(&self) -> std::io::Result<Vec<page::Chart>> {
        let factors = &self.sweep.factors;
        let chart = |at: usize| {
            let factor = factors.get(at)?;
            let other = (factors.len() > 1).then(|| (at + 1) % factors.len());
            let name = format!("{}-{}.png", self.sweep.name, factor.key);
            let what = format!("{}: the error at the target, geometric mean of operations", factor.key);
            Some(drawn(&name, &what, &self.curves(at, other)))
        };
        (0..factors.len()).filter_map(chart).collect()
    }

    fn curves(&self, at: usize, other: Option<usize>) -> Chart {
        let factor = &self.sweep.factors[at];
        let mut chart = Chart::new("", Axis::linear(factor.key.clone()), Axis::linear(RESPONSES[0]));
        let series = match other {
            None => vec![None],
            Some(other) => (0..self.sweep.factors[other].levels.len()).map(Some).collect(),
        };
        for (level, (colour, mark)) in series.into_iter().zip(colours()) {
            let held = other.zip(level);
            let points = (0..factor.levels.len()).filter_map(|x| {
                let is_here = |levels: &[usize]| levels[at] == x && held.is_none_or(|(f, l)| levels[f] == l);
                let mean = self.mean(0, &self.complete(at), is_here)?;
                Some([place(factor, x), mean.found])
            });
            let name =
                held.map(|(f, l)| format!("{} = {}", self.sweep.factors[f].key, self.sweep.factors[f].levels[l]));
            chart.push(Series::joined(name.unwrap_or_default(), colour, mark, points));
        }
        chart
    }

    /// The cells at those settings of all other dials at which every value of this one has a cell.
    fn complete(&self, at: usize) -> Cells<'_> {
        self.complete_among(&[at], self.sweep.factors[at].levels.len(), |_| true)
    }

    /// Of the cells that are asked for those at settings of all other dials than `of` at which there are so many.
    fn complete_among(&self, of: &[usize], wanted: usize, is_asked: impl Fn(&[usize]) -> bool) -> Cells<'_> {
        let rest = |levels: &[usize]| {
            let others = levels.iter().enumerate().filter(|(at, _)| !of.contains(at));
            others.map(|(_, level)| *level).collect::<Vec<_>>()
        };
        let known: Cells<'_> = self
            .cells
            .iter()
            .enumerate()
            .map(|(at, cell)| (self.sweep.levels(at), cell))
            .filter(|(levels, cell)| cell.samples.is_some() && is_asked(levels))
            .collect();
        let mut count: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        for (levels, _) in &known {
            *count.entry(rest(levels)).or_default() += 1;
        }
        known
            .into_iter()
            .filter(|(levels, _)| count.get(&rest(levels)) == Some(&wanted))
            .collect()
    }

    /// The four corners that two dials' first values make with others, at all settings that have them: with the last values that
    /// there are such settings of, and which these are.
    fn corners(&self, a: usize, b: usize) -> Option<([usize; 2], Cells<'_>)> {
        let last = |at: usize| self.sweep.factors[at].levels.len();
        let mut ends: Vec<[usize; 2]> = (1..last(a)).flat_map(|x| (1..last(b)).map(move |y| [x, y])).collect();
        // The farthest from the first values before all, and of those as far the first.
        ends.sort_by_key(|[x, y]| std::cmp::Reverse(x + y));
        ends.into_iter().find_map(|[x, y]| {
            let is_corner = |levels: &[usize]| [0, x].contains(&levels[a]) && [0, y].contains(&levels[b]);
            let found = self.complete_among(&[a, b], 4, is_corner);
            (!found.is_empty()).then_some(([x, y], found))
        })
    }

    /// The geometric mean of a response over those of the cells.
    fn mean(&self, response: usize, cells: &Cells<'_>, is_here: impl Fn(&[usize]) -> bool) -> Option<Estimate> {
        let here: Vec<Sample> = cells
            .iter()
            .filter(|(levels, _)| is_here(levels))
            .filter_map(|(_, cell)| Some(cell.samples?[response]))
            .collect();
        let weight = 1.0 / here.len() as f64;
        let terms: Vec<(f64, Sample)> = here.iter().map(|sample| (weight, *sample)).collect();
        (!terms.is_empty()).then(|| factor_of(contrast(&terms)))
    }

    /// How many times a response is where cells have the sign 1 what it is where they have -1; of four corners two have each, and what is
    /// told is how many times the one ratio is the other.
    fn ratio(
        &self,
        (response, corners): (usize, f64),
        cells: &Cells<'_>,
        sign: impl Fn(&[usize]) -> f64,
    ) -> Option<Estimate> {
        let signed: Vec<(f64, Sample)> = cells
            .iter()
            .filter_map(|(levels, cell)| Some((sign(levels), cell.samples?[response])))
            .filter(|(sign, _)| *sign != 0.0)
            .collect();
        // Each corner is in every complete setting, so as many cells have each sign.
        let weight = corners / signed.len() as f64;
        let terms: Vec<(f64, Sample)> = signed
            .into_iter()
            .map(|(sign, sample)| (sign * weight, sample))
            .collect();
        (!terms.is_empty()).then(|| factor_of(contrast(&terms)))
    }

    fn main(&self) -> Table {
        let mut rows = Vec::new();
        for (at, factor) in self.sweep.factors.iter().enumerate() {
            let complete = self.complete(at);
            for (level, value) in factor.levels.iter().enumerate() {
                let mut cells = vec![plain(&factor.key), plain(value)];
                for response in 0..RESPONSES.len() {
                    cells.push(told(self.mean(response, &complete, |levels| levels[at] == level)));
                    let against = |levels: &[usize]| match levels[at] {
                        here if here == level => 1.0,
                        0 => -1.0,
                        _ => 0.0,
                    };
                    cells.push(match level {
                        0 => plain("1"),
                        _ => told(self.ratio((response, 2.0), &complete, against)),
                    });
                }
                cells.extend(self.shares(|levels| levels[at] == level));
                rows.push(cells);
            }
        }
        let head = [
            "dial",
            "value",
            RESPONSES[0],
            "times",
            RESPONSES[1],
            "times",
            RESPONSES[2],
            "times",
            "given up, %",
            "refused, %",
        ];
        Table::new(&format!("{}: what each dial does", self.sweep.name), &head, rows.into_iter()).noted(
            "Geometric means of operations, over the settings of the other dials at which every value of this one was operated; `times`: how many times as much as with the first \
             value. In brackets intervals of 95 %. What was given up counts with the time until then. Shares are of all lines of the value.",
        )
    }

    fn shares(&self, is_here: impl Fn(&[usize]) -> bool) -> [Cell; 2] {
        let mut sums = [0; 3];
        for (at, cell) in self.cells.iter().enumerate() {
            if is_here(&self.sweep.levels(at)) {
                (0..3).for_each(|k| sums[k] += cell.lines[k]);
            }
        }
        let share = |k: usize| plain(format!("{:.1}", 100.0 * sums[k] as f64 / sums[0].max(1) as f64));
        [share(1), share(2)]
    }

    fn pairs(&self) -> Table {
        let factors = &self.sweep.factors;
        let mut rows = Vec::new();
        for a in 0..factors.len() {
            for b in a + 1..factors.len() {
                let Some(([x, y], complete)) = self.corners(a, b) else {
                    continue;
                };
                let end = |level: usize, last: usize| if level == last { 1.0 } else { -1.0 };
                let sign = |levels: &[usize]| end(levels[a], x) * end(levels[b], y);
                let between = |at: usize, level: usize| {
                    let Factor { key, levels, .. } = &factors[at];
                    plain(format!("{key} {} to {}", levels[0], levels[level]))
                };
                let mut cells = vec![between(a, x), between(b, y)];
                let times = |response| told(self.ratio((response, 4.0), &complete, sign));
                cells.extend((0..RESPONSES.len()).map(times));
                rows.push(cells);
            }
        }
        let head = ["dial", "and", "error, times", "predicted radius, times", "time, times"];
        Table::new(&format!("{}: what dials do to one another", self.sweep.name), &head, rows.into_iter()).noted(
            "How many times as much the second dial does, from the one of its values to the other, where the first one has its other value: 1 where both work apart from one another. \
             Over the settings of the other dials at which all four corners were operated.",
        )
    }

    fn combinations(&self) -> Table {
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        let error = |at: usize| self.cells[at].samples.map_or(f64::INFINITY, |samples| samples[0].mean);
        order.sort_by(|a, b| error(*a).total_cmp(&error(*b)));
        let row = |at: usize| {
            let cell = &self.cells[at];
            let mut cells: Vec<Cell> = self
                .sweep
                .levels(at)
                .iter()
                .zip(&self.sweep.factors)
                .map(value)
                .collect();
            for response in 0..RESPONSES.len() {
                let sample = cell.samples.map(|samples| samples[response]);
                cells.push(told(sample.map(|sample| factor_of(contrast(&[(1.0, sample)])))));
            }
            cells.extend(cell.lines.map(plain));
            cells
        };
        let keys = self.sweep.factors.iter().map(|factor| factor.key.as_str());
        let head: Vec<&str> = keys.chain(RESPONSES).chain(["lines", "given up", "refused"]).collect();
        let title = format!("{}: all combinations, the least error first", self.sweep.name);
        Table::new(&title, &head, order.into_iter().map(row))
    }
}

fn value((level, factor): (&usize, &Factor)) -> Cell {
    plain(&factor.levels[*level])
}

/// Where a value lies along the axis: its number, or which it is.
fn place(factor: &Factor, level: usize) -> f64 {
    let number = factor.numbers.as_ref().and_then(|numbers| numbers.get(level).copied());
    number.unwrap_or(level as f64 + 1.0)
}

fn cell(rows: &[&Row]) -> CellOf {
    let ended = |which: Ended| rows.iter().filter(|row| row.ended == which).count();
    let mut by_number: BTreeMap<u64, Vec<&Row>> = BTreeMap::new();
    for row in rows
        .iter()
        .filter(|row| row.ended != Ended::Refused && row.is_within().is_some())
    {
        by_number.entry(row.number).or_default().push(row);
    }
    let of = |response: fn(&Row) -> f64| {
        let one = |rows: &Vec<&Row>| rms(rows.iter().map(|row| response(row))).ln();
        let logs: Vec<f64> = by_number.values().map(one).filter(|log| log.is_finite()).collect();
        Sample::of(&logs)
    };
    let responses = [of(|row| row.tre_mm), of(|row| row.predicted_mm), of(|row| row.time_s)];
    CellOf {
        samples: match responses {
            [Some(a), Some(b), Some(c)] => Some([a, b, c]),
            _ => None,
        },
        lines: [rows.len(), ended(Ended::GivenUp), ended(Ended::Refused)],
    }
}

/// Of a logarithm what it is the logarithm of.
fn factor_of(e: Estimate) -> Estimate {
    Estimate {
        found: e.found.exp(),
        interval: e.interval.map(f64::exp),
    }
}

fn told(e: Option<Estimate>) -> Cell {
    match e {
        Some(Estimate {
            found,
            interval: [low, high],
        }) => plain(format!("{found:.2} ({low:.2}-{high:.2})")),
        None => plain(""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::sealed;
    use std::path::Path;

    fn plan() -> Plan {
        let text = "operations = 4\n[all]\ntargets = [\"pre-aortic\"]\n[sweep]\nmarker.emitters = [12, 24]\nmarker.radius_mm = [25.0, 50.0, 75.0]";
        Plan::of_texts([(Path::new("a.toml"), text)]).unwrap()
    }

    /// Four operations of each combination: an error of `of(emitters, radius)` with factors of 1.1 to both sides.
    fn rows(plan: &Plan, of: impl Fn(usize, usize) -> Option<f64>) -> Vec<Row> {
        let empty = ",".repeat(crate::record::HEADER.split(',').count() - 17);
        let line = |cell: usize, number: i32| {
            let levels = plan.sweeps[0].levels(cell);
            let name = &plan.strata[cell].name;
            let line = match of(levels[0], levels[1]) {
                Some(mm) => {
                    let mm = mm * 1.1_f64.powi([1, -1, 2, -2][number as usize]);
                    format!("{name},{number},x,arrived,,,,,{mm},2,3,1,6,4,100,0{empty}")
                }
                None => format!("{name},{number},x,refused,marker,,,,,,,,,0,0,0{empty}"),
            };
            Row::read(&sealed(&line)).unwrap()
        };
        (0..6)
            .flat_map(|cell| (0..4).map(move |number| (cell, number)))
            .map(|(cell, number)| line(cell, number))
            .collect()
    }

    fn cells(table: &Table, first: &[&str]) -> Vec<String> {
        let is_it = |row: &&Vec<Cell>| first.iter().zip(row.iter()).all(|(text, cell)| *text == cell.text);
        let row = table.rows.iter().find(is_it).unwrap();
        row.iter().map(|cell| cell.text.clone()).collect()
    }

    /// Halved by the emitters, and by 1, 2 and 3 with the radius: what is told is that, to the digits that are told.
    #[test]
    fn effects_that_multiply_are_found_and_do_nothing_to_one_another() {
        let plan = plan();
        let rows = rows(&plan, |a, b| Some(1.2 / (a as f64 + 1.0) / (b as f64 + 1.0)));
        let [main, pairs, all] = &Effects::of(&plan, &plan.sweeps[0], &rows).tables()[..] else {
            panic!()
        };
        let emitters = cells(main, &["marker.emitters", "24"]);
        // The geometric mean of 0.6, 0.3 and 0.2, and of four operations each of 12 and of 24.
        assert!(
            emitters[2].starts_with("0.33 (") && emitters[3].starts_with("0.50 (0.4"),
            "{emitters:?}"
        );
        let radius = cells(main, &["marker.radius_mm", "75.0"]);
        assert!(
            radius[3].starts_with("0.33 (0.2") && radius[3].ends_with("-0.40)"),
            "{radius:?}"
        );
        assert_eq!((&*radius[8], &*radius[9]), ("0.0", "0.0"));
        let pair = cells(pairs, &["marker.emitters 12 to 24", "marker.radius_mm 25.0 to 75.0"]);
        assert!(pair[2].starts_with("1.00 (0."), "{pair:?}");
        // The best first.
        assert_eq!((&*all.rows[0][0].text, &*all.rows[0][1].text), ("24", "75.0"));
    }

    /// Student's interval by hand: logarithms of deviations 1, -1, 2 and -2 times ln 1.1 have the variance 10 / 3 of their square; the ratio of
    /// two means over three such cells has 18 degrees of freedom, t = 2.101.
    #[test]
    fn the_interval_of_a_ratio_is_students() {
        let plan = plan();
        let rows = rows(&plan, |_, _| Some(1.0));
        let effects = Effects::of(&plan, &plan.sweeps[0], &rows);
        let sign = |levels: &[usize]| [-1.0, 1.0][levels[0]];
        let found = effects.ratio((0, 2.0), &effects.complete(0), sign).unwrap();
        let half = 2.101 * 1.1_f64.ln() * (10.0_f64 / 3.0 / 4.0 * 2.0 / 3.0).sqrt();
        assert!((found.found - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.interval[1].ln() - half).abs() < 1e-3 * half, "{found:?} {half}");
    }

    #[test]
    fn what_dials_do_to_one_another_is_found() {
        let plan = plan();
        let rows = rows(&plan, |a, b| Some(if (a, b) == (1, 2) { 3.0 } else { 1.0 }));
        let tables = Effects::of(&plan, &plan.sweeps[0], &rows).tables();
        let pair = cells(&tables[1], &["marker.emitters 12 to 24"]);
        assert!(pair[2].starts_with("3.00 (2."), "{pair:?}");
    }

    /// The largest ball refused with few emitters: what the emitters do is told of the other balls, where it is 2 throughout.
    #[test]
    fn a_combination_that_is_refused_does_not_stand_for_its_values() {
        let plan = plan();
        let of = |a: usize, b: usize| ((a, b) != (0, 2)).then(|| [2.0, 1.0][a] * [1.0, 1.0, 100.0][b]);
        let rows = rows(&plan, of);
        let tables = Effects::of(&plan, &plan.sweeps[0], &rows).tables();
        let emitters = cells(&tables[0], &["marker.emitters", "24"]);
        assert!(
            emitters[2].starts_with("1.00 (") && emitters[3].starts_with("0.50 ("),
            "{emitters:?}"
        );
        let radius = cells(&tables[0], &["marker.radius_mm", "75.0"]);
        assert!(radius[3].starts_with("100.00 (") && radius[9] == "50.0", "{radius:?}");
        // Of the pair the corners with the second ball are told.
        let pair = cells(&tables[1], &["marker.emitters 12 to 24"]);
        assert!(
            pair[1] == "marker.radius_mm 25.0 to 50.0" && pair[2].starts_with("1.00 ("),
            "{pair:?}"
        );
    }
}
