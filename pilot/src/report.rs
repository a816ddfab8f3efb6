//! `report.json`: what a run did, in keys that scripts can rely on.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::guiding::CheckReport;
use crate::metrics::accuracy::AccuracyReport;
use crate::metrics::tissue::TissueReport;
use crate::metrics::{Latency, PoseCounts, Restart};
use crate::remote::RemoteReport;
use crate::replay::ReplayReport;

/// The report. Keys are only ever added.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Report {
    pub(crate) trocar_version: &'static str,
    pub(crate) run: String,
    pub(crate) scene: String,
    pub(crate) seed: u64,
    pub(crate) duration_s: f64,
    /// Whether time was simulated: nothing in this report then says how fast the machine was.
    pub(crate) simulated_time: bool,
    pub(crate) registration_id: String,
    pub(crate) volume: Option<VolumeReport>,
    /// What was replayed; `null` for a run that navigated. Latencies are then on the clock of the replay.
    pub(crate) replay: Option<ReplayReport>,
    /// Where another machine's run was shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) remote: Option<RemoteReport>,
    pub(crate) poses: PoseCounts,
    pub(crate) accuracy: AccuracyReport,
    /// Stage by stage and as a whole, over every image that showed a pose for the first time; from capture to publication over every
    /// sample too; ms.
    pub(crate) latency_ms: BTreeMap<&'static str, Latency>,
    pub(crate) views: Vec<ViewReport>,
    /// What images showed of organs, in a scene that moves some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) tissue: Option<TissueReport>,
    /// The last check of the registration, in a run with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) check: Option<CheckReport>,
    pub(crate) processes: Vec<ProcessReport>,
    pub(crate) memory: MemoryReport,
    pub(crate) restarts: Vec<Restart>,
    /// Processes that died too often and were left alone.
    pub(crate) held: Vec<String>,
    pub(crate) recording: Vec<String>,
    /// What was wrong, in words; empty for a run that went as it should.
    pub(crate) problems: Vec<String>,
    /// What a run that went as it should has to say all the same; the exit code does not tell of it.
    pub(crate) notes: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct VolumeReport {
    pub(crate) hash: String,
    pub(crate) dims: [u32; 3],
    pub(crate) ct_from_voxel: [[f64; 4]; 3],
    pub(crate) brick: [u32; 3],
    pub(crate) padding_hu: i32,
    /// What every image of it says; empty where there is nothing to say.
    pub(crate) marks: String,
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct ViewReport {
    pub(crate) name: String,
    pub(crate) process: String,
    pub(crate) size: [u32; 2],
    /// Different poses shown.
    pub(crate) rendered: u64,
    /// Poses that were never shown because newer ones had come.
    pub(crate) dropped: u64,
    /// Images older than `limits.stale_ms` that did not say so.
    pub(crate) unflagged_old: u64,
    /// The file; `null`: there is none.
    pub(crate) png: Option<String>,
    /// The pose that the file shows.
    pub(crate) seq: Option<u64>,
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct ProcessReport {
    pub(crate) name: String,
    /// What it said of itself last while the pictures were taken: of a renderer, who samples.
    pub(crate) note: String,
}

#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct MemoryReport {
    /// The voxels alone: 2 bytes each.
    pub(crate) volume_bytes: u64,
    /// What all processes together hold of the volume's shared memory.
    pub(crate) volume_mapped_pss_bytes: u64,
    /// The second divided by the first.
    pub(crate) volume_ratio: f64,
    /// All memory of each process, shared pages divided by their users.
    pub(crate) process_pss_bytes: BTreeMap<String, u64>,
}

/// What was written, and what there was to say about it.
#[derive(Debug, Default)]
pub(crate) struct Pictures {
    /// For each view its file and the pose it shows.
    pub(crate) pngs: Vec<Option<(String, u64)>>,
    pub(crate) processes: Vec<ProcessReport>,
    pub(crate) memory: MemoryReport,
    pub(crate) problems: Vec<String>,
    pub(crate) at_ns: i64,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
#[error("writing {path}: {source}")]
pub(crate) struct ReportError {
    path: PathBuf,
    source: io::Error,
}

impl Report {
    /// Writes `report.json` into `dir`, whole or not at all.
    pub(crate) fn write(&self, dir: &Path) -> Result<(), ReportError> {
        let path = dir.join("report.json");
        let part = dir.join("report.json.part");
        let text = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        let written = fs::write(&part, text).and_then(|()| fs::rename(&part, &path));
        written.map_err(|source| ReportError { path, source })
    }

    /// The short table for people.
    pub(crate) fn table(&self) -> String {
        let mut lines = vec![format!(
            "run {:?}: {:.1} s, {} poses published, {} lost, {} missing, {} refused",
            self.run, self.duration_s, self.poses.published, self.poses.lost, self.poses.missing, self.poses.refused
        )];
        lines.push(self.accuracy.line());
        if let Some(volume) = &self.volume {
            let [x, y, z] = volume.dims;
            lines.push(format!(
                "volume {}: {x} x {y} x {z}, {:.1} MiB, held {:.3} times by all processes together",
                &volume.hash[..12],
                self.memory.volume_bytes as f64 / f64::from(1 << 20),
                self.memory.volume_ratio
            ));
        }
        lines.push(format!(
            "{:<22}{:>9}{:>9}{:>9}{:>9}",
            "latency, ms", "p50", "p95", "p99", "max"
        ));
        for (stage, l) in &self.latency_ms {
            lines.push(format!(
                "{stage:<22}{:>9.2}{:>9.2}{:>9.2}{:>9.2}",
                l.p50, l.p95, l.p99, l.max
            ));
        }
        lines.push(format!("{:<22}{:>9}{:>9}   {}", "view", "shown", "dropped", "image"));
        for view in &self.views {
            let image = view.png.as_deref().unwrap_or("none");
            lines.push(format!(
                "{:<22}{:>9}{:>9}   {image}",
                view.name, view.rendered, view.dropped
            ));
        }
        lines.extend(self.tissue.iter().map(TissueReport::line));
        for restart in &self.restarts {
            let live = restart
                .live_again_s
                .map_or("never".to_owned(), |s| format!("after {s:.2} s"));
            lines.push(format!(
                "restarted {} at {:.2} s ({}), live again {live}",
                restart.process, restart.at_s, restart.cause
            ));
        }
        lines.extend(self.replay.iter().filter_map(ReplayReport::recomputed));
        lines.extend(self.notes.iter().map(|n| format!("NOTE: {n}")));
        lines.extend(self.problems.iter().map(|p| format!("PROBLEM: {p}")));
        lines.join("\n")
    }
}
