//! The processes that a scene needs, and nothing else.

use std::path::Path;

use scene::{Scene, TrackerSource};

use crate::supervise::Role;

/// The name of the replayer's process.
pub(crate) const REPLAYER: &str = "replay";
/// The name of the process that calibrates, registers and checks.
pub(crate) const CALIBRATOR: &str = "calib";
/// The server through which other programs look on.
pub(crate) const GATEWAY: &str = "gateway";
/// That of the process that brings another machine's run.
pub(crate) const REMOTE: &str = "remote";
/// The tracker's.
pub(crate) const TRACKER: &str = "tracker";
/// That of the process that dials a localizer.
pub(crate) const LOCALIZER: &str = "localizer";

/// That of the process that moves organs with the tube.
pub(crate) const TISSUE: &str = "tissue";

/// One process of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Planned {
    /// Its name on the bus and in reports.
    pub(crate) name: String,
    /// The program.
    pub(crate) binary: &'static str,
    /// Its arguments, without the ones that all share.
    pub(crate) arguments: Vec<String>,
    /// What the supervisor must know.
    pub(crate) role: Role,
    /// The views it renders.
    pub(crate) views: Vec<usize>,
}

/// Where the poses of a run come from, with the replayer's arguments.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Poses<'a> {
    /// From where the scene says.
    Tracked,
    /// Out of a recording.
    Replayed(&'a [String]),
    /// From the scene's tracker, which makes them again of the emitters of a recording.
    MadeAgain(&'a [String]),
    /// Out of a recording, for a model that answers them again.
    Answered(&'a [String]),
    /// From another machine, with its examination; with the receiver's arguments.
    Remote(&'a [String]),
}

/// The processes of `scene`: a loader (who brings another machine's run brings its examination), a renderer for each plane direction, a recorder where the scene records, a
/// tracker unless poses come from elsewhere, and who dials its localizer; in a replay the replayer in its place, or behind it. Who publishes poses, or what
/// they are made of, starts last, so that the first one finds everybody ready.
pub(crate) fn plan(scene: &Scene, recording: &str, poses: Poses<'_>) -> Vec<Planned> {
    let plain = |name: &str, binary, arguments: &[&str], stop_rank| Planned {
        name: name.to_owned(),
        binary,
        arguments: arguments.iter().map(ToString::to_string).collect(),
        role: Role {
            after: Vec::new(),
            stop_rank,
        },
        views: Vec::new(),
    };
    let loader = match poses {
        Poses::Remote(arguments) => {
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            plain(REMOTE, "remote-proc", &arguments, 2)
        }
        _ => plain("volume-loader", "volume-loader", &["run"], 2),
    };
    let mut processes = vec![loader];
    for (plane, views) in scene.renderers() {
        let arguments = ["run", "--plane", plane.name()];
        let renderer = plain(&plane.process(), "slice-view-proc", &arguments, 0);
        processes.push(Planned { views, ..renderer });
    }
    if scene.recording.is_some() {
        processes.push(plain("recorder", "recorder", &["record", "--out", recording], 1));
    }
    // It answers poses as they come: in a recording it has.
    if scene.tissue.is_some() && matches!(poses, Poses::Tracked | Poses::Answered(_)) {
        processes.push(plain(TISSUE, "tissue-proc", &[], 0));
    }
    let mut last = |mut source: Planned| {
        source.role.after = (0..processes.len()).collect();
        processes.push(source);
    };
    let is_tracked = !matches!(scene.tracker.source, TrackerSource::External);
    if is_tracked && !matches!(poses, Poses::Replayed(_) | Poses::Answered(_) | Poses::Remote(_)) {
        last(plain(TRACKER, "tracker-proc", &[], 0));
    }
    if scene.localizer.is_some() && matches!(poses, Poses::Tracked) {
        last(plain(LOCALIZER, "localizer-proc", &[], 0));
    }
    if let Poses::Replayed(arguments) | Poses::Answered(arguments) | Poses::MadeAgain(arguments) = poses {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        last(plain(REPLAYER, "recorder", &arguments, 0));
    }
    processes
}

/// Who calibrates, registers and checks with a person, where the scene has steps for it; what is touched is kept in `out`. Nobody
/// waits for it.
pub(crate) fn add_steps(processes: &mut Vec<Planned>, scene: &Scene, out: &Path) {
    if scene.steps.is_none() {
        return;
    }
    let work = out.join("steps").to_string_lossy().into_owned();
    processes.push(Planned {
        name: CALIBRATOR.to_owned(),
        binary: "calib",
        arguments: vec!["steps".to_owned(), "--work".to_owned(), work],
        role: Role {
            after: Vec::new(),
            stop_rank: 0,
        },
        views: Vec::new(),
    });
}

/// The server for 3D Slicer and its like, where the scene has one. Nobody waits for it, and it has nothing that others need.
pub(crate) fn add_gateway(processes: &mut Vec<Planned>, scene: &Scene) {
    if scene.gateway.is_none() {
        return;
    }
    processes.push(Planned {
        name: GATEWAY.to_owned(),
        binary: "gateway-proc",
        arguments: Vec::new(),
        role: Role {
            after: Vec::new(),
            stop_rank: 0,
        },
        views: Vec::new(),
    });
}

/// The operator's window, which comes up first and says what is still missing, and who reads it back off the screen. Nobody waits
/// for them.
pub(crate) fn add_window(processes: &mut Vec<Planned>, out: &Path) {
    let shots = out.to_string_lossy().into_owned();
    let plain = |name: &'static str, arguments: Vec<String>, stop_rank| Planned {
        name: name.to_owned(),
        binary: name,
        arguments,
        role: Role {
            after: Vec::new(),
            stop_rank,
        },
        views: Vec::new(),
    };
    // The watcher ends first: a window that ends is no window that has died.
    processes.push(plain("window", vec!["--shots".to_owned(), shots], 1));
    processes.push(plain("window-watch", Vec::new(), 0));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn names(text: &str) -> Vec<String> {
        let scene = Scene::parse(text, Path::new("")).unwrap();
        plan(&scene, "x.mcap", Poses::Tracked)
            .into_iter()
            .map(|p| p.name)
            .collect()
    }

    #[test]
    fn a_scene_starts_only_what_it_names() {
        assert_eq!(
            names("[recording]"),
            [
                "volume-loader",
                "view-axial",
                "view-frontal",
                "view-sagittal",
                "view-perpendicular",
                "recorder",
                "tracker"
            ]
        );
        let one = "[tracker]\nsource = \"external\"\n[[views]]\nname = \"a\"\nplane = \"frontal\"\nextent = \"local\"";
        assert_eq!(names(one), ["volume-loader", "view-frontal"]);
    }

    #[test]
    fn organs_are_moved_where_the_scene_says_so_and_poses_are_tracked() {
        let scene = Scene::parse("[tissue]\norgans = \"kidney.toml\"", Path::new("")).unwrap();
        let has = |poses| plan(&scene, "x.mcap", poses).iter().any(|p| p.name == TISSUE);
        assert!(has(Poses::Tracked) && !has(Poses::Replayed(&[])) && !has(Poses::Remote(&[])));
        assert!(!names("").contains(&TISSUE.to_owned()));
    }

    #[test]
    fn a_gateway_is_started_where_the_scene_has_one_and_nobody_waits_for_it() {
        for (text, expected) in [("", false), ("[gateway]", true)] {
            let scene = Scene::parse(text, Path::new("")).unwrap();
            let mut planned = plan(&scene, "x.mcap", Poses::Tracked);
            add_gateway(&mut planned, &scene);
            let place = planned.iter().position(|process| process.name == GATEWAY);
            assert_eq!(place.is_some(), expected);
            let is_waited_for = |process: &Planned| place.is_some_and(|place| process.role.after.contains(&place));
            assert!(!planned.iter().any(is_waited_for));
        }
    }

    #[test]
    fn the_tracker_waits_for_all_others() {
        let scene = Scene::parse("[recording]", Path::new("")).unwrap();
        let plan = plan(&scene, "x.mcap", Poses::Tracked);
        assert_eq!(plan[6].role.after, [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn a_replayer_takes_the_trackers_place() {
        let scene = Scene::parse("", Path::new("")).unwrap();
        let arguments = ["replay".to_owned(), "s.mcap".to_owned()];
        let plan = plan(&scene, "x.mcap", Poses::Replayed(&arguments));
        let names: Vec<&str> = plan.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names[4..], ["view-perpendicular", "replay"]);
        assert_eq!((plan[5].binary, plan[5].role.after.len()), ("recorder", 5));
        assert_eq!(plan[5].arguments, ["replay", "s.mcap"]);
    }

    #[test]
    fn another_machines_run_comes_with_its_examination_and_nothing_is_tracked_here() {
        let scene = Scene::parse("", Path::new("")).unwrap();
        let arguments = ["receive".to_owned(), "tcp/127.0.0.1:7447".to_owned()];
        let plan = plan(&scene, "x.mcap", Poses::Remote(&arguments));
        let names: Vec<&str> = plan.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "remote",
                "view-axial",
                "view-frontal",
                "view-sagittal",
                "view-perpendicular"
            ]
        );
        assert_eq!((plan[0].binary, plan[0].arguments.len()), ("remote-proc", 2));
    }

    #[test]
    fn a_localizer_is_dialled_in_a_run_and_in_no_replay() {
        let text = "[tracker]\nsource = \"markers\"\n[localizer]\nkind = \"openigtlink\"\naddress = \"127.0.0.1:18944\"\n\
                    [[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\n";
        let scene = Scene::parse(text, Path::new("s.toml")).unwrap();
        let of = |poses| plan(&scene, "", poses).into_iter().map(|p| p.name).collect::<Vec<_>>();
        assert_eq!(of(Poses::Tracked)[2..], ["tracker", "localizer"]);
        assert_eq!(of(Poses::MadeAgain(&[]))[2..], ["tracker", "replay"]);
        assert_eq!(of(Poses::Replayed(&[]))[2..], ["replay"]);
    }

    #[test]
    fn where_poses_are_made_again_the_replayer_waits_for_the_tracker() {
        let scene = Scene::parse("[recording]", Path::new("")).unwrap();
        let plan = plan(&scene, "x.mcap", Poses::MadeAgain(&["replay".to_owned()]));
        let names: Vec<&str> = plan.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names[5..], ["recorder", "tracker", "replay"]);
        assert_eq!((plan[6].role.after.len(), plan[7].role.after.len()), (6, 7));
    }
}
