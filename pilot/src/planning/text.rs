//! What is said of a plan: its targets with their ways, and what speaks against it in its examination.

use bus::volume::VolumeView;
use geometry::{Ct, Point};
use guidance::plan::{Concern, Measure, Plan, Target, Trajectory, concerns};
use serde::Serialize;

use super::safety::{Safety, WaySafety};
use super::store::PlanStore;

/// What was found of a plan in its examination.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Findings {
    file: String,
    /// Of the file's content; empty where nothing was written yet.
    id: String,
    volume_hash: String,
    /// Who confirmed it; `null`: nobody, and it may still be changed.
    confirmed_by: Option<String>,
    confirmed_at: Option<String>,
    targets: Vec<TargetFindings>,
    measures: Vec<MeasureFindings>,
    notes: String,
    /// What speaks against it.
    concerns: Vec<String>,
    /// What is doubtful about the examination, by the loader's words.
    examination_warnings: Vec<String>,
    /// The ways beside the structures of the label map; `null`: there is none, and nothing was checked.
    structures: Option<Vec<WaySafety>>,
    /// The label map; `null`: there is none.
    label_map: Option<String>,
    /// Whether that lies on the CT's voxels; `null`: there is none.
    label_map_on_grid: Option<bool>,
    /// By how much it is moved against the CT, where that is all that is wrong with it.
    label_map_moved_mm: Option<[f64; 3]>,
    /// What is doubtful about whose that is, and whether anybody approved of it.
    label_map_doubts: Option<Vec<String>>,
    #[serde(skip)]
    safety: Vec<String>,
    /// That points lie outside the examination or in its bone, and the like: more than that a way is missing.
    #[serde(skip)]
    is_doubtful: bool,
}

#[derive(Debug, Clone, Serialize)]
struct TargetFindings {
    name: String,
    ct_mm: [f64; 3],
    diameter_mm: f64,
    entry_ct_mm: Option<[f64; 3]>,
    stop_mm: f64,
    /// From the entry to where the tip stops.
    depth_mm: Option<f64>,
    /// Between the tube and the axial plane, positive towards the head.
    to_head_deg: Option<f64>,
    /// On the axial plane, between the tube and straight from front to back, positive towards the patient's left.
    to_left_deg: Option<f64>,
}

#[derive(Debug, Clone, Serialize)]
struct MeasureFindings {
    distance_mm: Option<f64>,
    angle_deg: Option<f64>,
    ct_mm: Vec<[f64; 3]>,
}

impl Findings {
    /// Of a plan and the examination that it was made for.
    ///
    /// `volume`: that examination, and what is doubtful about it; `safety`: its ways beside the structures of a label map, where there is one.
    pub(crate) fn of(
        store: &PlanStore,
        plan: &Plan,
        (volume, doubts): (&VolumeView<'_>, Vec<String>),
        safety: Option<Safety>,
    ) -> Self {
        let hu = |p: Point<Ct>| volume.nearest(p);
        let concerns = concerns(plan, volume.grid, &hu);
        let is_doubt = |concern: &Concern| !matches!(concern, Concern::NoEntry { .. });
        Self {
            file: store.path().display().to_string(),
            id: store.id(),
            volume_hash: bus::message::VolumeHash(plan.volume.0).to_string(),
            confirmed_by: plan.confirmed.as_ref().map(|confirmed| confirmed.by.clone()),
            confirmed_at: plan.confirmed.as_ref().map(|confirmed| confirmed.at.clone()),
            targets: plan.targets.iter().map(TargetFindings::of).collect(),
            measures: plan.measures.iter().map(MeasureFindings::of).collect(),
            notes: plan.notes.clone(),
            is_doubtful: concerns.iter().any(is_doubt) || safety.as_ref().is_some_and(Safety::is_doubtful),
            concerns: concerns.iter().map(Concern::to_string).collect(),
            examination_warnings: doubts,
            label_map: safety.as_ref().map(|safety| safety.label_map.clone()),
            label_map_on_grid: safety.as_ref().map(|safety| safety.is_on_the_grid),
            label_map_doubts: safety.as_ref().map(|safety| safety.doubts.clone()),
            label_map_moved_mm: safety.as_ref().and_then(|safety| safety.moved_mm),
            safety: safety.as_ref().map(Safety::lines).unwrap_or_default(),
            structures: safety.map(|safety| safety.ways),
        }
    }

    /// Whether something speaks against the plan.
    pub(crate) fn is_doubtful(&self) -> bool {
        self.is_doubtful
    }

    /// For people.
    pub(crate) fn table(&self) -> String {
        let state = match (&self.confirmed_by, self.id.is_empty()) {
            (Some(by), _) => format!("confirmed by {by} at {}", self.confirmed_at.as_deref().unwrap_or("?")),
            (None, true) => "not written yet: there is nothing in it".to_owned(),
            (None, false) => "not confirmed".to_owned(),
        };
        let mut lines = vec![format!("plan {}: id {}, {state}", self.file, or_none(&self.id))];
        lines.push(format!("examination {}", self.volume_hash));
        lines.extend((!self.targets.is_empty()).then(|| {
            format!(
                "{:<24}{:>24}{:>8}{:>24}{:>7}{:>8}{:>9}{:>9}",
                "target", "centre, mm", "diam.", "entry, mm", "stop", "depth", "to head", "to left"
            )
        }));
        lines.extend(self.targets.iter().map(TargetFindings::line));
        lines.extend(self.measures.iter().enumerate().map(MeasureFindings::line));
        lines.extend((!self.notes.is_empty()).then(|| format!("notes: {}", self.notes.replace(char::is_control, " "))));
        let doubts = self.examination_warnings.iter();
        lines.extend(doubts.map(|words| format!("warning: the examination: {words}")));
        match self.concerns.is_empty() {
            true if !self.examination_warnings.is_empty() => {
                lines.push("nothing else was found against it in the CT, as far as that can be relied on".to_owned());
            }
            true => lines.push("nothing was found against it in the CT".to_owned()),
            false => lines.extend(self.concerns.iter().map(|concern| format!("! {concern}"))),
        }
        match &self.structures {
            Some(_) => lines.extend(self.safety.iter().cloned()),
            None => lines.push("structures beside the ways: NOT CHECKED, there is no label map (--labels)".to_owned()),
        }
        lines.join("\n")
    }
}

fn or_none(id: &str) -> &str {
    if id.is_empty() { "-" } else { id }
}

impl TargetFindings {
    fn of(target: &Target) -> Self {
        let way = Trajectory::of(target);
        Self {
            name: target.name.clone(),
            ct_mm: target.centre.mm(),
            diameter_mm: target.diameter_mm,
            entry_ct_mm: target.entry.map(Point::mm),
            stop_mm: target.stop_mm,
            depth_mm: way.map(|way| way.depth_mm),
            to_head_deg: way.map(|way| way.to_head_rad().to_degrees()),
            to_left_deg: way.and_then(|way| way.to_left_rad()).map(f64::to_degrees),
        }
    }

    fn line(&self) -> String {
        let place = |mm: [f64; 3]| format!("{:.1} {:.1} {:.1}", mm[0], mm[1], mm[2]);
        let or_dash = |number: Option<f64>| number.map_or("-".to_owned(), |number| format!("{number:.1}"));
        format!(
            "{:<24}{:>24}{:>8.1}{:>24}{:>7.1}{:>8}{:>9}{:>9}",
            self.name,
            place(self.ct_mm),
            self.diameter_mm,
            self.entry_ct_mm.map_or("-".to_owned(), place),
            self.stop_mm,
            or_dash(self.depth_mm),
            or_dash(self.to_head_deg),
            or_dash(self.to_left_deg)
        )
    }
}

impl MeasureFindings {
    fn of(measure: &Measure) -> Self {
        Self {
            distance_mm: measure.distance_mm(),
            angle_deg: measure.angle_rad().map(f64::to_degrees),
            ct_mm: measure.points().iter().map(|p| p.mm()).collect(),
        }
    }

    fn line((place, measure): (usize, &Self)) -> String {
        let place = place + 1;
        match (measure.distance_mm, measure.angle_deg) {
            (Some(mm), _) => format!("distance {place}: {mm:.1} mm"),
            (None, Some(deg)) => format!("angle {place}: {deg:.1} degrees"),
            (None, None) => format!("angle {place}: two of its points lie together"),
        }
    }
}
