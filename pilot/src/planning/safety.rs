//! How far planned ways stay from the structures of a label map, in words and numbers.

use bus::volume::OwnedVolume;
use guidance::plan::{Plan, Trajectory};
use guidance::safety::{Clearance, Distance, GridMatch, LabelNames, MapError, Structures, Tube, TubeError};
use serde::Serialize;

/// Structures are looked for so far from a way, mm.
const WITHIN_MM: f64 = 30.0;
/// So many of those that are clear are told; of those that are not, all.
const TOLD: usize = 6;

/// A label map as it was found.
#[derive(Debug, Clone)]
pub(crate) struct LabelMap {
    pub(crate) file: String,
    /// How it lies beside the CT.
    pub(crate) grid: GridMatch,
    /// What is doubtful about whose it is.
    pub(crate) doubts: Vec<String>,
    pub(crate) names: LabelNames,
}

/// What ways are measured against.
pub(crate) struct Measured {
    map: LabelMap,
    structures: Structures,
    radius_mm: f64,
    /// The error of navigation, where it is known.
    error_mm: Option<f64>,
}

/// The ways of a plan beside the structures of a label map.
#[derive(Debug, Clone)]
pub(crate) struct Safety {
    pub(super) label_map: String,
    /// Whether the map lies on the CT's voxels: else nobody can tell that it belongs to this CT.
    pub(super) is_on_the_grid: bool,
    /// By how much it is moved against the CT, where it is that alone, mm.
    pub(super) moved_mm: Option<[f64; 3]>,
    grid: GridMatch,
    pub(super) doubts: Vec<String>,
    pub(super) ways: Vec<WaySafety>,
}

/// A way beside the structures.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct WaySafety {
    target: String,
    /// Parts of the way that lie outside the label map, from where to where, mm: NOT CHECKED.
    outside_map_mm: Vec<[f64; 2]>,
    /// How near the label map ends beside the way, mm, where that is nearer than the error of navigation: beyond it NOT CHECKED.
    beyond_map_mm: Option<f64>,
    /// The nearest, nearest first.
    nearest: Vec<StructureSafety>,
    /// How many more are looked for so far and clear.
    more: usize,
}

#[derive(Debug, Clone, Serialize)]
struct StructureSafety {
    label: i16,
    /// What the label map's own files call it.
    name: Option<String>,
    /// Both, for people.
    #[serde(skip)]
    words: String,
    cuts: bool,
    /// From the tube to the nearest centre of its voxels; below zero within the tube.
    distance_mm: f64,
    /// How deep that is on the way.
    depth_mm: f64,
    /// What is left of it at least: less half a voxel's diagonal and the error of navigation; `null` where that is not known.
    at_least_mm: Option<f64>,
    /// Whether no voxel of it meets the tube.
    is_clear: bool,
    /// The same where the tube is off by the error of navigation.
    is_clear_within_error: bool,
}

impl Measured {
    /// Of a label map that was read as a volume, and a tube of this diameter.
    pub(crate) fn of(
        labels: &OwnedVolume,
        map: LabelMap,
        (tube_mm, error_mm): (f64, Option<f64>),
    ) -> Result<Self, MapError> {
        Ok(Self {
            map,
            structures: labels.structures()?,
            radius_mm: tube_mm / 2.0,
            error_mm,
        })
    }

    /// Each way of a plan.
    pub(crate) fn safety(&self, plan: &Plan) -> Result<Safety, TubeError> {
        let ways = plan
            .targets
            .iter()
            .filter_map(|target| Some((target, Trajectory::of(target)?)));
        let ways: Result<Vec<WaySafety>, TubeError> = ways.map(|(target, way)| self.way(&target.name, &way)).collect();
        let grid = self.map.grid;
        Ok(Safety {
            label_map: self.map.file.clone(),
            is_on_the_grid: !grid.is_doubtful(),
            moved_mm: match grid {
                GridMatch::Moved { by_mm } => Some(by_mm),
                _ => None,
            },
            grid,
            doubts: self.map.doubts.clone(),
            ways: ways?,
        })
    }

    fn way(&self, target: &str, way: &Trajectory) -> Result<WaySafety, TubeError> {
        let tube = Tube::new(way.entry, way.stop, self.radius_mm)?;
        let found = self.structures.clearance(&tube, WITHIN_MM)?;
        let all: Vec<StructureSafety> = found.structures.iter().filter_map(|one| self.told(one)).collect();
        let not_clear = all.iter().filter(|one| !one.is_clear_within_error).count();
        let told = all.len().min(not_clear.max(TOLD));
        Ok(WaySafety {
            target: target.to_owned(),
            outside_map_mm: found.coverage.outside_mm(),
            beyond_map_mm: found.coverage.nearer_than(self.error_mm),
            more: all.len() - told,
            // The nearest first: those that are not clear are before all that are.
            nearest: all.into_iter().take(told).collect(),
        })
    }

    fn told(&self, one: &Clearance) -> Option<StructureSafety> {
        let Distance::Nearest(nearest) = one.distance else {
            return None;
        };
        Some(StructureSafety {
            label: one.label,
            name: self.map.names.get(one.label).map(str::to_owned),
            words: self.map.names.words(one.label),
            cuts: one.cuts,
            distance_mm: nearest.distance_mm,
            depth_mm: nearest.depth_mm,
            at_least_mm: one.at_least_mm(self.error_mm),
            is_clear: one.is_clear(),
            is_clear_within_error: one.is_clear_within(self.error_mm),
        })
    }
}

impl Safety {
    /// Whether a way meets a structure, or is not checked in part, or against a map that may be of another CT or is in doubt itself.
    pub(super) fn is_doubtful(&self) -> bool {
        self.grid.is_doubtful() || !self.doubts.is_empty() || self.ways.iter().any(WaySafety::is_doubtful)
    }

    /// For people.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("label map {}", self.label_map)];
        lines.extend(self.grid.is_doubtful().then(|| format!("! {}", self.grid)));
        lines.extend(self.doubts.iter().map(|doubt| format!("! the label map: {doubt}")));
        lines.extend(self.ways.iter().flat_map(WaySafety::lines));
        lines
    }
}

impl WaySafety {
    /// Whether the way meets a structure, or is not checked in part.
    pub(super) fn is_doubtful(&self) -> bool {
        !self.outside_map_mm.is_empty()
            || self.beyond_map_mm.is_some()
            || self.nearest.iter().any(|one| !one.is_clear_within_error)
    }

    /// For people.
    pub(super) fn lines(&self) -> Vec<String> {
        let outside = self.outside_map_mm.iter().map(|[from, to]| {
            format!(
                "! {}: from {from:.1} to {to:.1} mm its way lies outside the label map: NOT CHECKED",
                self.target
            )
        });
        let near = self
            .nearest
            .iter()
            .map(|one| format!("{} {}: {}", one.sign(), self.target, one.words()));
        let beyond = self.beyond_map_mm.iter().map(|mm| {
            let target = &self.target;
            format!("! {target}: the label map ends {mm:.1} mm beside its way, within the error: NOT CHECKED beyond")
        });
        let mut lines: Vec<String> = outside.chain(beyond).chain(near).collect();
        if self.more > 0 {
            lines.push(format!(
                "  {}: {} more structures within {WITHIN_MM} mm, all clear",
                self.target, self.more
            ));
        }
        // Where the map says nothing, nothing is said.
        if lines.is_empty() {
            lines.push(format!(
                "  {}: no structure of the label map within {WITHIN_MM} mm of its way",
                self.target
            ));
        }
        lines
    }
}

impl StructureSafety {
    fn sign(&self) -> char {
        if self.is_clear_within_error { ' ' } else { '!' }
    }

    fn words(&self) -> String {
        let (what, mm, depth) = (&self.words, self.distance_mm, self.depth_mm);
        let least = match self.at_least_mm {
            _ if !self.is_clear_within_error => "WITHIN THE ERROR".to_owned(),
            Some(least) => format!("at least {least:.1} mm"),
            None => "the least is not known without the error of navigation, or at the map's border".to_owned(),
        };
        match (self.cuts, self.is_clear) {
            (true, _) => format!("CUTS {what}, {depth:.1} mm deep"),
            (false, true) => format!("{what} is {mm:.1} mm away, {depth:.1} mm deep; {least}"),
            (false, false) => format!("MAY CUT {what}: {mm:.1} mm to the middle of a voxel, {depth:.1} mm deep"),
        }
    }
}
