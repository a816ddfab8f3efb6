//! What a study came to: a page, and charts.

mod charts;
mod page;
pub mod summary;

use std::fs;
use std::io;
use std::path::Path;

use crate::plan::Plan;
use crate::record::Row;
use summary::Summary;

/// Writes `report.html`, which holds everything, and its charts beside it as PNGs.
///
/// # Errors
/// The system's.
pub fn write(folder: &Path, plan: &Plan, rows: &[Row]) -> io::Result<()> {
    let of = |name: &str| rows.iter().filter(|row| row.stratum == name).collect::<Vec<_>>();
    let summaries: Vec<Summary> = plan
        .strata
        .iter()
        .map(|stratum| Summary::of(&stratum.name, &of(&stratum.name), stratum.dials.radius_mm))
        .collect();
    let charts = charts::all(&summaries, rows)?;
    for (name, _, png) in &charts {
        fs::write(folder.join(name), png)?;
    }
    fs::write(folder.join("report.html"), page::page(plan, &summaries, rows, &charts))
}
