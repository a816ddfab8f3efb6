//! Screens as they might be: one of each kind of state that the window knows.

use std::fmt::Write as _;
use std::rc::Rc;

use bus::gather::Set;
use bus::message::{
    Chosen, ClockLaw, FrameState, Guide, Identity, IdentitySource, Lost, Timeline, TimelineColumn, TimelineMark,
    ToolPose, VolumeHash, Workflow,
};
use geometry::Point;
use guidance::workflow::Stage;

use super::sample;
use crate::model::sample::{CAPTURED_NS, Sample, VOLUME, id, pose, workflow};
use crate::model::{Aimed, Model};

/// A name as long and as wide as forty letters can be.
pub(super) const WIDE: &str = "WWWWWWWWWW MMMMMMMMMM WWWWWWWWW MMMMMMMM";

/// Every sample with what it is.
pub(super) fn all() -> Vec<(&'static str, Sample)> {
    let live = || sample(37.4, 1.3);
    vec![
        ("live", live()),
        ("arrived", sample(0.2, 0.2)),
        ("past", sample(-6.7, 1.3)),
        ("off", sample(42.6, 28.9)),
        ("planned", planned()),
        ("error not known", without_error()),
        ("old", live().in_state(FrameState::Stale)),
        ("silent", late(150)),
        ("lost", live().in_state(FrameState::Lost(Lost::NotSeen))),
        ("held", held()),
        ("mixed", mixed()),
        ("wrong", wrong()),
        ("no images", no_images()),
        ("replay", replay()),
        ("simulated", simulated()),
        ("no target", no_target()),
        ("not navigating", not_navigating()),
        ("one view", views(1)),
        ("sixteen views", views(16)),
        ("sixteen lost", views(16).in_state(FrameState::Lost(Lost::Reference))),
        ("wide name", named(WIDE)),
    ]
}

/// Those without a pose that may be followed: nothing on their screens is a distance, an angle or a depth.
pub(super) fn without_a_pose() -> Vec<(String, Sample)> {
    let live = || sample(37.4, 1.3);
    let mut all: Vec<(String, Sample)> = Lost::ALL
        .into_iter()
        .map(|reason| (format!("{reason:?}"), live().in_state(FrameState::Lost(reason))))
        .collect();
    let old = |planned: Sample| planned.in_state(FrameState::Stale);
    let others = [
        ("old", old(live())),
        ("planned and old", old(planned())),
        ("nobody draws", late(150)),
        ("nobody draws for long", late(90_000)),
        ("held", held()),
        ("wrong", wrong()),
        ("no images", no_images()),
        ("one of sixteen", one_old_of_sixteen()),
    ];
    all.extend(others.map(|(name, sample)| (name.to_owned(), sample)));
    all
}

/// With an entry and a stop: an angle is known.
pub(super) fn planned() -> Sample {
    let mut sample = sample(37.4, 1.3);
    let centre = target(&sample);
    let chosen = Chosen {
        name: "para-aortic-left".to_owned(),
        centre,
        radius_mm: 2.5,
        entry: Some(pose([0.3, 0.9, 0.1], [10.0, -5.0, 70.0]) * Point::new(2.0, -1.0, -60.0)),
        stop_mm: 12.5,
    };
    sample.guide = Some(Guide::default().choosing(Some(&chosen), 7));
    sample
}

fn target(sample: &Sample) -> Point<geometry::Ct> {
    let aimed = |model: Model| model.sight.map(|Aimed { target, .. }| target.centre);
    aimed(sample.model()).unwrap()
}

fn without_error() -> Sample {
    let mut sample = sample(37.4, 1.3);
    sample.poses[0].flags &= !ToolPose::TIP_KNOWN;
    sample
}

fn late(by_ms: i64) -> Sample {
    Sample {
        now_ns: CAPTURED_NS + by_ms * 1_000_000,
        ..sample(37.4, 1.3)
    }
}

pub(super) fn held() -> Sample {
    let mut sample = sample(37.4, 1.3);
    let pose = id(&sample.poses[0]);
    sample.guide = sample.guide.map(|guide| guide.holding(Some(pose)));
    sample.in_state(FrameState::Requested)
}

fn mixed() -> Sample {
    Sample {
        set: Some(Set::Mixed { poses: 3, missing: 0 }),
        ..sample(37.4, 1.3)
    }
}

fn wrong() -> Sample {
    Sample {
        volume: Some(VolumeHash([1; 32])),
        ..sample(37.4, 1.3)
    }
}

fn no_images() -> Sample {
    Sample {
        headers: vec![None; 7],
        set: None,
        ..sample(37.4, 1.3)
    }
}

pub(in crate::screen) fn replay() -> Sample {
    let law = ClockLaw {
        first_ns: 1_000_000_000,
        last_ns: 9_000_000_000,
        zero_ns: 1_000_000_000,
        speed: 1.0,
        ..ClockLaw::default()
    };
    Sample {
        is_replay: true,
        law: Some(law),
        timeline: Some(Rc::new(timeline())),
        ..sample(37.4, 1.3)
    }
}

/// Eight seconds: some of it lost, old or without an error, one error that is larger than all others, a part that is not read yet.
fn timeline() -> Timeline {
    let mut told = Timeline {
        from_ns: 1_000_000_000,
        column_ns: 10_000_000,
        read_bytes: 75,
        bytes: 100,
        columns_count: 600,
        marks_count: 2,
        ..Timeline::default()
    };
    for (k, column) in told.columns.iter_mut().take(600).enumerate() {
        column.states = match k {
            200..=230 | 400 => TimelineColumn::LIVE | TimelineColumn::LOST,
            231..=250 => TimelineColumn::STALE | TimelineColumn::LIVE,
            300..=320 => TimelineColumn::NOT_READABLE,
            350..=360 => TimelineColumn::LIVE | TimelineColumn::ERROR_UNKNOWN,
            _ => TimelineColumn::LIVE,
        };
        let mm = 0.6 + 0.4 * (k as f64 / 40.0).sin();
        let has_error = column.states == TimelineColumn::LIVE;
        [0.9 * mm, mm]
            .into_iter()
            .filter(|_| has_error)
            .for_each(|mm| column.error(mm));
    }
    told.columns[450].error(40.0);
    told.marks[0] = TimelineMark::new(3_000_000_000, "at the entry");
    told.marks[1] = TimelineMark::new(6_500_000_000, "biopsy taken");
    told
}

fn simulated() -> Sample {
    Sample {
        is_simulated: true,
        ..sample(37.4, 1.3)
    }
}

fn no_target() -> Sample {
    Sample {
        guide: Some(Guide::default()),
        ..sample(37.4, 1.3)
    }
}

fn not_navigating() -> Sample {
    Sample {
        workflow: Some(workflow(Stage::Registered, Workflow::RESEARCH | Workflow::IMAGES)),
        ..sample(37.4, 1.3)
    }
}

/// With so many views.
pub(super) fn views(count: usize) -> Sample {
    let planes = ["perpendicular", "axial", "frontal", "sagittal"];
    let mut scene = String::new();
    for k in 0..count {
        let (plane, extent) = (planes[k % 4], if k % 8 < 4 { "local" } else { "global" });
        let view = format!("[[views]]\nname = \"view-{k}\"\nplane = \"{plane}\"\nextent = \"{extent}\"\n");
        scene.write_str(&view).unwrap();
    }
    let pose = pose([0.3, 0.9, 0.1], [10.0, -5.0, 70.0]);
    Sample::of(&scene, pose, pose * Point::new(1.3, 0.0, 37.4))
}

fn one_old_of_sixteen() -> Sample {
    let mut sample = views(16);
    let header = sample.headers[11].as_mut().unwrap();
    header.stamp.state = FrameState::Stale.code();
    sample
}

/// A patient of this name, aimed at a target of this name.
pub(super) fn named(name: &str) -> Sample {
    let mut sample = sample(37.4, 1.3);
    let chosen = Chosen {
        name: name.to_owned(),
        centre: target(&sample),
        radius_mm: 2.5,
        entry: None,
        stop_mm: 0.0,
    };
    sample.guide = Some(Guide::default().choosing(Some(&chosen), 1));
    let words = [name, "4711", "1950-01-01", "2026-11-02", ""];
    sample.identity = Some(Identity::new(VOLUME, IdentitySource::Examination, words));
    sample
}
