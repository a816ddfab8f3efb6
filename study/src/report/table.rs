//! A table, for the page and for `tables.md`.

use crate::statistics::Estimate;

/// A table with what is to be known of it.
pub(super) struct Table {
    /// What it answers.
    pub(super) title: String,
    /// The columns.
    pub(super) head: Vec<String>,
    /// As many cells as there are columns in each.
    pub(super) rows: Vec<Vec<Cell>>,
    /// Below it.
    pub(super) notes: Vec<String>,
}

/// A cell.
pub(super) struct Cell {
    /// Its text.
    pub(super) text: String,
    /// Something is not as it should be.
    pub(super) warns: bool,
}

impl Table {
    pub(super) fn new(title: &str, head: &[&str], rows: impl Iterator<Item = Vec<Cell>>) -> Self {
        Self {
            title: title.to_owned(),
            head: head.iter().map(|&cell| cell.to_owned()).collect(),
            rows: rows.collect(),
            notes: Vec::new(),
        }
    }

    /// The same with a sentence below it.
    pub(super) fn noted(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// In Markdown, as it can be put into a page of the documentation.
    pub(super) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let escaped = |text: &str| text.replace('|', "\\|").replace(['\n', '\r'], " ");
        let mut text = format!("## {}\n\n", escaped(&self.title));
        text += &line(self.head.iter().map(|cell| escaped(cell)).collect());
        text += &line(vec!["---".to_owned(); self.head.len()]);
        for row in &self.rows {
            let cell = |cell: &Cell| match cell.warns {
                true => format!("**{}**", escaped(&cell.text)),
                false => escaped(&cell.text),
            };
            text += &line(row.iter().map(cell).collect());
        }
        for note in &self.notes {
            text += &format!("\n{note}\n");
        }
        text + "\n"
    }
}

pub(super) fn plain(value: impl ToString) -> Cell {
    Cell {
        text: value.to_string(),
        warns: false,
    }
}

pub(super) fn bad(value: impl ToString) -> Cell {
    Cell {
        text: value.to_string(),
        warns: true,
    }
}

/// With two digits, or nothing where there is nothing.
pub(super) fn length(e: Estimate) -> Cell {
    estimate(e, 1.0, 2)
}

pub(super) fn percent(e: Estimate) -> Cell {
    estimate(e, 100.0, 1)
}

fn estimate(e: Estimate, times: f64, digits: usize) -> Cell {
    let [found, low, high] = [e.found, e.interval[0], e.interval[1]].map(|value| times * value);
    // What the numbers do not bound is no number either.
    let end = |value: f64| match value.is_finite() {
        true => format!("{value:.digits$}"),
        false => "?".to_owned(),
    };
    match found.is_finite() {
        true => plain(format!("{found:.digits$} ({}-{})", end(low), end(high))),
        false => plain(""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_in_markdown_has_its_columns_whatever_stands_in_them() {
        let rows = [vec![plain("a|b"), bad(3)], vec![plain("line\nend"), length(NONE)]];
        let table = Table::new("What", &["name", "count"], rows.into_iter()).noted("Below.");
        let expected = "## What\n\n| name | count |\n| --- | --- |\n| a\\|b | **3** |\n| line end |  |\n\nBelow.\n\n";
        assert_eq!(table.markdown(), expected);
    }

    const NONE: Estimate = Estimate {
        found: f64::NAN,
        interval: [f64::NAN; 2],
    };

    #[test]
    fn estimates_are_told_with_their_intervals() {
        let e = Estimate {
            found: 0.5,
            interval: [0.25, 0.756],
        };
        assert_eq!(
            (length(e).text.as_str(), percent(e).text.as_str()),
            ("0.50 (0.25-0.76)", "50.0 (25.0-75.6)")
        );
        let interval = [0.25, f64::INFINITY];
        assert_eq!(length(Estimate { interval, ..e }).text, "0.50 (0.25-?)");
    }
}
