//! Names by which the lines of `operations.csv` are told apart, where several files have strata of one name.
//!
//! Such strata are told as `FILE.NAME`. What is drawn follows from the name in the file, so that a stratum is the same operations
//! alone and beside other files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::at::At;
use super::check::is_name;
use super::error::PlanError;
use super::{Stratum, Sweep};

/// What stands in one file.
pub(super) struct OfFile<'a> {
    pub(super) path: &'a Path,
    pub(super) strata: Vec<Stratum>,
    pub(super) sweep: Option<Sweep>,
}

/// Gives every stratum a name of its own, and every sweep, whose strata are told alike. Names with a file's are hashed: the file's is
/// not in its text.
///
/// # Errors
/// [`PlanError::Twice`] for a name that stands twice in one file, and for files of one name; [`PlanError::Value`] for a file whose name
/// cannot stand in one of a stratum.
pub(super) fn apart(files: &mut [OfFile<'_>], hash: &mut blake3::Hasher) -> Result<(), PlanError> {
    let mut holders: BTreeMap<String, usize> = BTreeMap::new();
    for file in files.iter() {
        let mut names = BTreeSet::new();
        for stratum in &file.strata {
            if !names.insert(stratum.own_name.clone()) {
                return Err(twice(file.path, &stratum.own_name));
            }
        }
        // A sweep's own name is told of its charts.
        names.extend(file.sweep.iter().map(|sweep| sweep.name.clone()));
        for name in names {
            *holders.entry(name).or_default() += 1;
        }
    }
    let is_shared = |name: &str| holders.get(name).is_some_and(|files| *files > 1);
    for file in files.iter_mut() {
        let swept: BTreeSet<String> = file.swept().map(|stratum| stratum.own_name.clone()).collect();
        let sweep_is_shared =
            file.sweep.iter().any(|sweep| is_shared(&sweep.name)) || swept.iter().any(|n| is_shared(n));
        let is_told = |name: &str| is_shared(name) || (sweep_is_shared && swept.contains(name));
        if !sweep_is_shared && !file.strata.iter().any(|stratum| is_told(&stratum.own_name)) {
            continue;
        }
        let stem = stem(file.path)?;
        for stratum in file.strata.iter_mut().filter(|stratum| is_told(&stratum.own_name)) {
            stratum.name = format!("{stem}.{}", stratum.own_name);
            hash.update(stratum.name.as_bytes());
        }
        if let Some(sweep) = file.sweep.as_mut().filter(|_| sweep_is_shared) {
            sweep.name = format!("{stem}.{}", sweep.name);
        }
    }
    // Two files of one name in different folders.
    let mut told = BTreeSet::new();
    for file in files.iter() {
        for stratum in &file.strata {
            if !told.insert(stratum.name.as_str()) {
                return Err(twice(file.path, &stratum.name));
            }
        }
    }
    Ok(())
}

impl OfFile<'_> {
    /// The strata of its sweep: the last of the file.
    fn swept(&self) -> impl Iterator<Item = &Stratum> {
        let cells = self.sweep.as_ref().map_or(0, Sweep::cells);
        self.strata.iter().skip(self.strata.len().saturating_sub(cells))
    }
}

fn twice(path: &Path, name: &str) -> PlanError {
    PlanError::Twice {
        path: path.to_owned(),
        name: name.to_owned(),
    }
}

/// What the file's strata are told by.
fn stem(path: &Path) -> Result<String, PlanError> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let of = "its strata, of whose names another file has some".to_owned();
    match is_name(&stem) {
        true => Ok(stem),
        false => Err(At { path, of }.wrong(
            "the file's name",
            &stem,
            "they are told by it: 1 to 40 of the characters a-z, A-Z, 0-9, - and _ are allowed before its ending",
        )),
    }
}
