//! Touched points, as their file has them.

use std::fs;
use std::path::Path;

use crate::live::read_touches;
use crate::store;

/// Touches of one task, in the order in which they were made.
#[derive(Debug, Default)]
pub(super) struct Touches {
    /// What stands above them: what all are of, and the columns.
    head: String,
    rows: Vec<Touch>,
}

/// A touched point.
#[derive(Debug, Clone)]
pub(super) struct Touch {
    /// As it was called on the command line.
    pub(super) name: String,
    /// As its file has it.
    pub(super) line: String,
}

/// What came of taking a touch.
#[derive(Debug)]
pub(super) struct Taken {
    /// As it was called on the command line.
    pub(super) name: String,
    forgotten: usize,
}

impl Taken {
    /// What a person has to know of it.
    ///
    /// # Errors
    /// That touches were forgotten.
    pub(super) fn told(&self) -> Result<(), String> {
        match self.forgotten {
            0 => Ok(()),
            count => Err(format!(
                "the tool has another calibration than when {count} points were touched before: these are forgotten, touch them again"
            )),
        }
    }
}

impl Touches {
    pub(super) fn rows(&self) -> &[Touch] {
        &self.rows
    }

    /// Takes the one touch of a file that `calib touch` made. Those that were made with another calibration of the tool, as the files'
    /// first lines say, are forgotten.
    pub(super) fn take(&mut self, path: &Path) -> Result<Taken, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("reading {}: {error}", path.display()))?;
        let touches = read_touches(path).map_err(|error| error.to_string())?;
        let [(name, _)] = &touches[..] else {
            return Err(format!(
                "{}: {} touches, one is expected",
                path.display(),
                touches.len()
            ));
        };
        let mut lines = text.lines();
        let head: Vec<&str> = lines.by_ref().take(1).collect();
        let rest: Vec<&str> = lines.filter(|line| !line.starts_with('#')).collect();
        let [columns, line] = rest[..] else {
            return Err(format!("{}: not the file of a touch", path.display()));
        };
        let head = format!("{}\n{columns}\n", head.join(""));
        let mut forgotten = 0;
        if std::mem::replace(&mut self.head, head.clone()) != head {
            forgotten = self.rows.len();
            self.rows.clear();
        }
        self.rows.push(Touch {
            name: name.clone(),
            line: line.to_owned(),
        });
        Ok(Taken {
            name: name.clone(),
            forgotten,
        })
    }

    /// What all are of, as their first line says.
    pub(super) fn of(&self) -> String {
        self.head.lines().next().unwrap_or_default().to_owned()
    }

    /// The columns of their lines behind the name.
    pub(super) fn columns(&self) -> impl Iterator<Item = &str> {
        self.head.lines().nth(1).unwrap_or_default().split(',').skip(1)
    }

    /// Leaves the touches of a name out that were made before the last.
    pub(super) fn keep_last_of(&mut self, name: &str) {
        let last = self.rows.iter().rposition(|row| row.name == name);
        let mut at = 0;
        self.rows.retain(|row| {
            at += 1;
            row.name != name || Some(at - 1) == last
        });
    }

    /// Leaves the last touch out; whether there was one.
    pub(super) fn pop(&mut self) -> bool {
        self.rows.pop().is_some()
    }

    /// Writes them as one file.
    pub(super) fn write(&self, path: &Path) -> Result<(), String> {
        let mut text = self.head.clone();
        for row in &self.rows {
            text += &row.line;
            text.push('\n');
        }
        store::write(path, Ok(text), std::iter::empty()).map_err(|error| error.to_string())
    }
}
