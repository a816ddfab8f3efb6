//! What a study came to: a page, and charts.

mod charts;
mod effects;
mod organs;
mod page;
pub mod summary;
mod table;
mod tables;

use std::fs;
use std::io;
use std::path::Path;

use crate::plan::Plan;
use crate::record::Row;
use crate::worst::Kept;
use effects::Effects;
use summary::Summary;

/// Writes `report.html`, which holds everything, its charts beside it as PNGs, and its tables as `tables.md`.
///
/// # Errors
/// The system's.
pub fn write(folder: &Path, plan: &Plan, rows: &[Row], kept: &[Kept]) -> io::Result<()> {
    let of = |name: &str| rows.iter().filter(|row| row.stratum == name).collect::<Vec<_>>();
    let summaries: Vec<Summary> = plan
        .strata
        .iter()
        .map(|stratum| Summary::of(&stratum.name, &of(&stratum.name), stratum.dials.radius_mm))
        .collect();
    let cells = plan
        .sweeps
        .iter()
        .flat_map(|sweep| plan.strata.iter().skip(sweep.first).take(sweep.cells()));
    let swept: Vec<&str> = cells.map(|stratum| stratum.name.as_str()).collect();
    let mut tables = tables::all(plan, &summaries, rows);
    let mut charts = charts::all(&summaries, &swept, rows)?;
    for sweep in &plan.sweeps {
        let effects = Effects::of(plan, sweep, rows);
        tables.extend(effects.tables());
        charts.extend(effects.charts()?);
    }
    for (name, _, png) in &charts {
        fs::write(folder.join(name), png)?;
    }
    fs::write(folder.join("tables.md"), page::markdown(plan, &tables))?;
    let page = page::page(plan, &tables, &charts, kept, rows.len());
    fs::write(folder.join("report.html"), page)
}
