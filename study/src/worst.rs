//! The worst operations of a study, done once more and kept as recordings that `pilot replay` shows.
//!
//! First come operations of which a target was reported as reached with the tip outside of it (false arrivals), the farthest first; then all
//! others by their true error. Of each operation its worst target is kept. An operation follows from the study's file alone, so it
//! is done again with all its frames, and its line must be the one that stands in `operations.csv`.

mod recording;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Words;
use crate::folder::{self, FolderError};
use crate::images::Images;
use crate::operation::again;
use crate::patient::{metal, patient};
use crate::plan::{Plan, Stratum};
use crate::record::{Ended, Row};

/// The folder of recordings in that of a study.
const WORST: &str = "worst";
/// Files of an operation that are kept beside its recording.
const BESIDE: [&str; 5] = ["marker.json", "tip.json", "base.json", "tool.json", "registration.json"];
/// What it was registered by, besides: beads that were touched, or the bone's surface.
const BY_BEADS: [&str; 1] = ["touched.csv"];
const BY_SURFACE: [&str; 4] = ["probe-marker.json", "probe.json", "seen.csv", "guess.json"];

/// One operation that is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kept {
    /// Its stratum.
    pub stratum: String,
    /// Its number there.
    pub number: u64,
    /// Its worst target.
    pub target: String,
    /// Its folder, from that of the study.
    pub folder: PathBuf,
    /// The image of its examination, from the folder of the study.
    pub ct: PathBuf,
}

impl Kept {
    /// What shows it, in the folder of the study.
    pub fn command(&self) -> String {
        format!(
            "pilot replay {} --window --out {}",
            self.folder.join(recording::FILE).display(),
            self.folder.join("replay").display()
        )
    }
}

/// Why a recording was not made.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// The folder of the study.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// One of the operations.
    #[error("the recording of operation {number} of {stratum}: {why}. The folder can be gone on with")]
    Operation {
        /// Its stratum.
        stratum: String,
        /// Its number there.
        number: u64,
        /// In words.
        why: String,
    },
}

/// The worst line of each of the `count` worst operations, in order.
pub fn worst<'a>(plan: &Plan, rows: &'a [Row], count: usize) -> Vec<&'a Row> {
    let radius_mm = |row: &Row| {
        let stratum = plan.strata.iter().find(|stratum| stratum.name == row.stratum);
        stratum.map_or(f64::INFINITY, |stratum| stratum.dials.radius_mm)
    };
    let badness = |row: &Row| match row.ended == Ended::Arrived && row.miss_mm > radius_mm(row) {
        true => (true, row.miss_mm),
        false => (false, row.tre_mm),
    };
    let mut known: Vec<&Row> = rows
        .iter()
        .filter(|row| row.ended != Ended::Refused && badness(row).1.is_finite())
        .collect();
    known.sort_by(|a, b| {
        let ((false_a, mm_a), (false_b, mm_b)) = (badness(a), badness(b));
        false_b.cmp(&false_a).then(mm_b.total_cmp(&mm_a))
    });
    let mut seen = BTreeSet::new();
    known.retain(|row| seen.insert((&row.stratum, row.number)));
    known.truncate(count);
    known
}

/// Keeps the `count` worst operations in the study's folder, those that are not there already; by so many threads.
///
/// # Errors
/// [`KeepError`]; what was kept stays.
pub fn keep(plan: &Plan, out: &Path, rows: &[Row], count: usize, threads: usize) -> Result<Vec<Kept>, KeepError> {
    let worst = worst(plan, rows, count);
    if worst.is_empty() {
        return Ok(Vec::new());
    }
    let _lock = folder::locked(out, plan)?;
    let images = Images::new(out.join(folder::IMAGES))?;
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, worst.len()) {
            scope.spawn(|| {
                loop {
                    let rank = next.fetch_add(1, Ordering::Relaxed);
                    let Some(row) = worst.get(rank) else { break };
                    let kept = one(plan, (out, &images), (rank, row));
                    done.lock().unwrap_or_else(PoisonError::into_inner).push((rank, kept));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(rank, _)| *rank);
    done.into_iter().map(|(_, kept)| kept).collect()
}

fn one(plan: &Plan, (out, images): (&Path, &Images), (rank, row): (usize, &Row)) -> Result<Kept, KeepError> {
    let failed = |why: Words| KeepError::Operation {
        stratum: row.stratum.clone(),
        number: row.number,
        why: why.to_string(),
    };
    let stratum = plan.strata.iter().find(|stratum| stratum.name == row.stratum);
    let stratum = stratum.ok_or_else(|| failed("the study has no such stratum".into()))?;
    let metal = metal(&patient(), &stratum.dials.beads);
    let ct = images.ct(stratum, row.number, &metal).map_err(failed)?;
    let ct = ct.strip_prefix(out).unwrap_or(&ct).to_owned();
    let name = format!("{:02}-{}-{}-{}", rank + 1, row.stratum, row.number, row.target);
    let folder = Path::new(WORST).join(name);
    if !out.join(&folder).exists() {
        write((out, &folder, &ct), stratum, images, row).map_err(failed)?;
    }
    Ok(Kept {
        stratum: row.stratum.clone(),
        number: row.number,
        target: row.target.clone(),
        folder,
        ct,
    })
}

/// Makes the folder of one operation beside, and renames it when it is whole.
fn write((out, folder, ct): (&Path, &Path, &Path), stratum: &Stratum, images: &Images, row: &Row) -> Result<(), Words> {
    let all = out.join(WORST);
    fs::create_dir_all(&all)?;
    let scratch = tempfile::Builder::new().prefix("trocar-study-").tempdir()?;
    let targets = stratum.targets();
    let at = targets.iter().position(|target| target.name == row.target);
    let at = at.ok_or("the operation has no such target")?;
    let again = again(stratum, (row.number, at), images, scratch.path())
        .map_err(|refused| format!("{}: {}", refused.step.word(), refused.why))?;
    if again.row.line() != row.line() {
        return Err("done once more it is another operation than the one that stands in operations.csv".into());
    }
    let beside = tempfile::Builder::new().prefix("making-").tempdir_in(&all)?;
    let by: &[&str] = match stratum.dials.surface {
        Some(_) => &BY_SURFACE,
        None => &BY_BEADS,
    };
    for name in BESIDE.iter().chain(by) {
        fs::copy(scratch.path().join(name), beside.path().join(name))?;
    }
    // From that folder, so that the study's folder may be moved.
    let ct = Path::new("../..").join(ct);
    recording::write(beside.path(), (stratum, &ct), &again, (&targets, at))?;
    fs::rename(beside.keep(), out.join(folder))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::sealed;

    fn row(number: u64, target: &str, ended: &str, tre_mm: f64, miss_mm: f64) -> Row {
        let empty = ",".repeat(crate::record::HEADER.split(',').count() - 17);
        let line = format!("a,{number},{target},{ended},,,,,{tre_mm},2,3,{miss_mm},6,4,100,0{empty}");
        Row::read(&sealed(&line)).unwrap()
    }

    #[test]
    fn false_arrivals_come_first_and_each_operation_once() {
        let plan = Plan::of_texts([(Path::new("a.toml"), "[[stratum]]\nname = \"a\"")]).unwrap();
        let rows = [
            row(0, "x", "arrived", 4.0, 1.0),
            row(0, "y", "arrived", 3.0, 5.5),
            row(1, "x", "given-up", 60.0, 70.0),
            row(2, "x", "refused", 90.0, 90.0),
            row(3, "x", "arrived", 1.0, 6.0),
            row(4, "x", "arrived", 2.0, 4.9),
            row(5, "x", "arrived", f64::NAN, 9.0),
        ];
        let found: Vec<(u64, &str)> = worst(&plan, &rows, 10)
            .iter()
            .map(|row| (row.number, row.target.as_str()))
            .collect();
        // One whose error nobody could tell is a false arrival all the same.
        assert_eq!(found, [(5, "x"), (3, "x"), (0, "y"), (1, "x"), (4, "x")]);
        assert_eq!(worst(&plan, &rows, 2).len(), 2);
    }
}
