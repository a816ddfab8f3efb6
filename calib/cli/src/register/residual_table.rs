//! The table of residuals, the longest marked.

use std::fmt::Write;

use crate::register::file::{PairResult, RegistrationFile};
use crate::text::{mm, shown};

/// From more pairs than this only the worst are shown.
const MANY: usize = 40;
/// How many these are.
const WORST: usize = 20;
/// Distances above this many root mean squares are marked.
const LONG: f64 = 2.0;
/// The longest label, characters.
const LABEL: usize = 20;

/// The table: each pair in the order of the file, or the worst of many, the longest first.
pub(crate) fn text(file: &RegistrationFile, all: bool) -> String {
    let mut order: Vec<usize> = (0..file.pairs.len()).collect();
    let few = all || order.len() <= MANY;
    if !few {
        order.sort_by(|&i, &j| file.pairs[j].fre_mm.total_cmp(&file.pairs[i].fre_mm));
        order.truncate(WORST);
    }
    let longest = longest(&file.pairs);
    let (lines, label) = ("line", "label");
    let (fre, out, weight) = ("residual mm", "left out mm", "weight");
    let mut text = format!("{lines:>11}  {label:<LABEL$}  {fre:>12}  {out:>12}  {weight:>8}\n");
    for &i in &order {
        let mark = mark(file, i, longest);
        text.push_str(row(&file.pairs[i], mark).trim_end());
        text.push('\n');
    }
    let left_over = file.pairs.len() - order.len();
    if left_over > 0 {
        let _ = writeln!(
            text,
            "and {left_over} more pairs with shorter residuals; --all shows them"
        );
    }
    text
}

/// The pair of the longest residual among those used.
fn longest(pairs: &[PairResult]) -> Option<usize> {
    let used = (0..pairs.len()).filter(|&i| pairs[i].weight > 0.0);
    used.max_by(|&i, &j| pairs[i].fre_mm.total_cmp(&pairs[j].fre_mm))
}

fn mark(file: &RegistrationFile, i: usize, longest: Option<usize>) -> &'static str {
    let pair = &file.pairs[i];
    if pair.inlier == Some(false) {
        return "outlier";
    }
    if pair.weight == 0.0 {
        return "not used";
    }
    if longest == Some(i) {
        return "longest";
    }
    if pair.fre_mm > LONG * file.fre_rms_mm {
        return "above 2 rms";
    }
    ""
}

fn row(pair: &PairResult, mark: &str) -> String {
    let [to, from] = pair.lines;
    let lines = if to == from {
        to.to_string()
    } else {
        format!("{to}/{from}")
    };
    let label: String = shown(&pair.label).chars().take(LABEL).collect();
    let fre = mm(pair.fre_mm);
    let left_out = pair.leave_one_out_mm.map_or("-".to_owned(), mm);
    let weight = pair.weight;
    format!("{lines:>11}  {label:<LABEL$}  {fre:>12}  {left_out:>12}  {weight:>8.4}  {mark}")
}
