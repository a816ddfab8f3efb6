//! From the raw scene to the checked one.

mod targets;
mod views;

use geometry::checked;

use super::limits::limits;
use super::localizer::Followed;
use super::raw::{RawApproach, RawScene, RawTracker, RawTrackerSource};
use super::values::{Checked, UNIT_TOLERANCE, invalid, number, point};
use super::{Approach, Scene, Simulation, Target, ToolSpec, TrackerSource, TrackerSpec, operating_room, tracking};

pub(super) fn scene(raw: &RawScene) -> Checked<Scene> {
    let targets = targets::targets(raw.targets.as_deref().unwrap_or_default())?;
    Ok(Scene {
        seed: raw.seed,
        volume: super::volume::checked(&raw.volume, &targets, raw.tracker.approach.entry_ct_mm)?,
        tool: tool(raw)?,
        tracker: tracker(&raw.tracker, &targets, raw.tool.length_mm)?,
        localizer: localizer(raw)?,
        guide: targets::chosen(raw, &targets)?,
        workflow: super::workflow::checked(&raw.workflow)?,
        steps: steps(raw)?,
        plan: super::plan::checked(raw.plan.as_ref())?,
        targets,
        views: views::views(raw.views.as_deref())?,
        identity: super::identity::checked(raw.identity.as_ref())?,
        render: raw.render,
        recording: super::recording::checked(raw.recording.as_ref())?,
        tissue: super::tissue::checked(raw.tissue.as_ref(), raw.limits.stale_ms)?,
        gateway: super::gateway::checked(raw.gateway.as_ref())?,
        pacs: super::pacs::checked(raw.pacs.as_ref())?,
        limits: limits(&raw.limits)?,
        priorities: super::priorities::checked(&raw.priorities)?,
    })
}

fn localizer(raw: &RawScene) -> Checked<Option<super::localizer::LocalizerSpec>> {
    let markers = raw.tracker.markers.as_ref();
    let names = [
        markers.and_then(|markers| markers.marker.as_deref()),
        markers.and_then(|markers| markers.reference.as_deref()),
    ];
    let around = super::localizer::Around {
        followed: match raw.tracker.source {
            RawTrackerSource::Markers => Followed::Markers,
            RawTrackerSource::Emitters => Followed::Emitters {
                has_reference: raw
                    .tracker
                    .emitters
                    .as_ref()
                    .is_some_and(|source| source.reference.is_some()),
            },
            _ => Followed::Other,
        },
        names,
        silent_s: raw.limits.silent_s,
    };
    super::localizer::checked(raw.localizer.as_ref(), &around)
}

fn steps(raw: &RawScene) -> Checked<Option<super::steps::StepsSpec>> {
    let tracker = &raw.tracker;
    let has_chain = matches!(
        tracker.source,
        RawTrackerSource::OperatingRoom | RawTrackerSource::Emitters | RawTrackerSource::Markers
    );
    let has_files = [tracker.calibration.is_some(), tracker.registration.is_some()];
    super::steps::checked(raw.steps.as_ref(), has_chain, has_files)
}

fn tool(raw: &RawScene) -> Checked<ToolSpec> {
    Ok(ToolSpec {
        name: raw.tool.name.clone(),
        length_mm: number("tool.length_mm", raw.tool.length_mm, 1.0..=1000.0, "mm")?,
        diameter_mm: number("tool.diameter_mm", raw.tool.diameter_mm, 0.1..=100.0, "mm")?,
    })
}

fn tracker(raw: &RawTracker, targets: &[Target], tool_mm: f64) -> Checked<TrackerSpec> {
    tables_of_other_sources(raw)?;
    let source = match raw.source {
        RawTrackerSource::External => TrackerSource::External,
        RawTrackerSource::OperatingRoom => {
            let room = raw.room.clone().unwrap_or_default();
            let room = operating_room::room(&room, approach(&raw.approach, targets)?, tool_mm)?;
            TrackerSource::OperatingRoom(Box::new(room))
        }
        RawTrackerSource::Emitters => {
            let emitters = raw.emitters.clone().unwrap_or_default();
            TrackerSource::Emitters(Box::new(tracking::emitters(&emitters, tool_mm)?))
        }
        RawTrackerSource::Markers => {
            let markers = raw.markers.clone().unwrap_or_default();
            TrackerSource::Markers(Box::new(tracking::markers(&markers)?))
        }
        RawTrackerSource::Sequence => {
            let missing = || invalid("tracker.sequence", "nothing", "a table with file = \"....mha\"");
            let sequence = raw.sequence.as_ref().ok_or_else(missing)?;
            TrackerSource::Sequence(Box::new(tracking::sequence(sequence)?))
        }
        RawTrackerSource::Simulated => TrackerSource::Simulated(Simulation {
            noise_mm: number("tracker.noise_mm", raw.noise_mm, 0.0..=50.0, "mm")?,
            noise_rad: number("tracker.noise_deg", raw.noise_deg, 0.0..=45.0, "degrees")?.to_radians(),
            dropout: number("tracker.dropout", raw.dropout, 0.0..=1.0, "")?,
            dropout_samples: raw.dropout_samples,
            approach: approach(&raw.approach, targets)?,
        }),
    };
    let rigid = match raw.source {
        RawTrackerSource::OperatingRoom => operating_room::place_of_localizer(&raw.ct_from_tracker),
        _ => raw.ct_from_tracker.clone(),
    };
    let ct_from_tracker = checked::rigid(rigid.quaternion, rigid.translation_mm, UNIT_TOLERANCE).map_err(|e| {
        let found = format!("{:?}, {:?}", rigid.quaternion, rigid.translation_mm);
        invalid("tracker.ct_from_tracker", found, e.to_string())
    })?;
    Ok(TrackerSpec {
        source,
        rate_hz: number("tracker.rate_hz", raw.rate_hz, 1.0..=4000.0, "Hz")?,
        ct_from_tracker,
        links: tracking::link_files(raw)?,
        smoothing: tracking::smoothing(raw)?,
    })
}

/// A table that would mean nothing is more likely a wrong source than a leftover.
fn tables_of_other_sources(raw: &RawTracker) -> Checked<()> {
    for (table, there, source, name) in [
        (
            "room",
            raw.room.is_some(),
            RawTrackerSource::OperatingRoom,
            "operating-room",
        ),
        (
            "emitters",
            raw.emitters.is_some(),
            RawTrackerSource::Emitters,
            "emitters",
        ),
        ("markers", raw.markers.is_some(), RawTrackerSource::Markers, "markers"),
        (
            "sequence",
            raw.sequence.is_some(),
            RawTrackerSource::Sequence,
            "sequence",
        ),
    ] {
        if there && raw.source != source {
            let allowed = format!("no such table unless tracker.source = \"{name}\"");
            return Err(invalid(format!("tracker.{table}"), "a table", allowed));
        }
    }
    Ok(())
}

fn approach(raw: &RawApproach, targets: &[Target]) -> Checked<Approach> {
    if let Some(name) = &raw.target {
        targets::named("tracker.approach.target", name, targets)?;
    }
    let key = |name: &str| format!("tracker.approach.{name}");
    let entry = raw.entry_ct_mm.map(|mm| point(&key("entry_ct_mm"), mm)).transpose()?;
    Ok(Approach {
        target: raw.target.clone(),
        entry,
        stop_short_mm: number(&key("stop_short_mm"), raw.stop_short_mm, 0.0..=500.0, "mm")?,
        insert_s: number(&key("insert_s"), raw.insert_s, 0.1..=3600.0, "s")?,
        pause_s: number(&key("pause_s"), raw.pause_s, 0.0..=3600.0, "s")?,
        sweep_s: number(&key("sweep_s"), raw.sweep_s, 0.0..=3600.0, "s")?,
        sweep_rad: number(&key("sweep_deg"), raw.sweep_deg, 0.0..=60.0, "degrees")?.to_radians(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn error(text: &str) -> String {
        Scene::parse(text, Path::new("s.toml")).unwrap_err().to_string()
    }

    #[test]
    fn an_empty_scene_is_the_thesis() {
        let scene = Scene::parse("", Path::new("s.toml")).unwrap();
        assert_eq!(scene.views.len(), 7);
        assert_eq!(scene.renderers().len(), 4);
        assert!(scene.recording.is_none());
    }

    #[test]
    fn one_view_one_renderer() {
        let scene = Scene::parse(
            "[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"",
            Path::new("s.toml"),
        );
        assert_eq!(scene.unwrap().renderers().len(), 1);
    }

    #[test]
    fn errors_point_at_the_line_and_say_what_is_allowed() {
        let cases = [
            (
                "[tracker]\nrate_hz = -5",
                "line 2, column 11, key tracker.rate_hz: found -5; allowed: 1 to 4000 Hz",
            ),
            ("[tracker]\nrate_hz = nan", "key tracker.rate_hz: found NaN"),
            (
                "[tracker]\nrate_herz = 5",
                "line 2, column 1, key tracker.rate_herz: unknown field `rate_herz`, expected one of",
            ),
            (
                "seed = \"x\"",
                "line 1, column 8, key seed: invalid type: string \"x\", expected u64",
            ),
            (
                "[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\n[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"",
                "line 6, column 8, key views.1.name: found \"a\" a second time",
            ),
            (
                "[[views]]\nname = \"a\"\nplane = \"coronal\"\nextent = \"local\"",
                "unknown variant `coronal`, expected one of `axial`",
            ),
            (
                "[[views]]\nname = \"../a\"\nplane = \"axial\"\nextent = \"local\"",
                "key views.0.name",
            ),
            (
                "[tracker.approach]\ntarget = \"x\"",
                "key tracker.approach.target: found \"x\"; allowed: no target",
            ),
            (
                "[tracker.ct_from_tracker]\nquaternion = [1, 1, 0, 0]",
                "needs a quaternion of norm 1",
            ),
            (
                "[limits]\nrestarts = 0",
                "line 2, column 12, key limits.restarts: found 0",
            ),
            ("views = []", "key views: found 0; allowed: 1 to 16 views"),
            ("seed = ", "line 1, column 8"),
        ];
        for (text, expected) in cases {
            let got = error(text);
            assert!(got.contains(expected), "{text}\n  gave {got}\n  not  {expected}");
            assert!(got.starts_with("scene s.toml, line "), "{got}");
        }
    }

    #[test]
    fn a_written_scene_reads_back() {
        let source = super::super::raw::parse(
            "[recording]\n[[targets]]\nname = \"n\"\nct_mm = [1, 2, 3]",
            Path::new("s.toml"),
        )
        .unwrap();
        let again = super::super::raw::parse(&source.to_toml(), Path::new("s.toml")).unwrap();
        assert_eq!(source.scene, again.scene);
    }
}
