//! The end of a run whose poses another program or machine publishes: it goes on beyond the time that the run navigates for, and the
//! recording does not.

use bus::message::ToolPose;
use bus::run::RunContext;
use scene::{Scene, TrackerSource};

/// Which messages belong to a run.
#[derive(Debug)]
pub(super) struct Bound {
    /// `None`: all that come. The run's own tracker ends by itself.
    run: Option<RunContext>,
    began_ns: Option<i64>,
}

impl Bound {
    pub(super) fn new(run: &RunContext, scene: &Scene) -> Self {
        let external = matches!(scene.tracker.source, TrackerSource::External) || run.remote.is_some();
        let bounded = run.duration_ns.is_some() && external;
        Self {
            run: bounded.then(|| run.clone()),
            began_ns: None,
        }
    }

    /// Whether a pose was published within the run's time.
    pub(super) fn holds(&mut self, pose: &ToolPose) -> bool {
        let Some(run) = &self.run else { return true };
        if self.began_ns.is_none() {
            self.began_ns = run.began_ns();
        }
        self.began_ns
            .is_none_or(|began_ns| !run.is_beyond(pose.t_publish_ns.saturating_sub(began_ns)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn poses_of_another_program_end_with_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let mut run = RunContext::new(folder.path(), 0).unwrap();
        run.duration_ns = Some(100);
        let pose = |t_publish_ns| ToolPose {
            t_publish_ns,
            ..ToolPose::EMPTY
        };
        let scene = |source: &str| Scene::parse(&format!("[tracker]\nsource = {source:?}"), Path::new("")).unwrap();
        let mut external = Bound::new(&run, &scene("external"));
        assert!(external.holds(&pose(1_099)), "the run has not begun");
        run.begin(1_000).unwrap();
        assert!(external.holds(&pose(1_099)) && !external.holds(&pose(1_100)));
        assert!(Bound::new(&run, &scene("simulated")).holds(&pose(1_100)));
        // The tracker of another machine goes on, whatever its scene says it is.
        run.remote = Some(bus::run::RemoteOf {
            endpoint: "tcp/127.0.0.1:7443".to_owned(),
            run: "or".to_owned(),
        });
        let mut remote = Bound::new(&run, &scene("simulated"));
        assert!(remote.holds(&pose(1_099)) && !remote.holds(&pose(1_100)));
    }
}
