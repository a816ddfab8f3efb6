//! A run, live in Foxglove: what a recording would hold, as it comes, and a scene of the tool, the targets and the planes.
//!
//! A research display: what it shows may be late or lost on its way, and nobody who operates goes by it. It says so on every image and
//! in the scene, and the tool is drawn only as long as an image of the run may claim its pose.

mod cli;
mod outlet;
mod scene_update;
mod views;

use std::collections::VecDeque;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use bus::clock;
use bus::message::{Level, ToolPose};
use bus::port::Subscriber;
use bus::process::{JoinError, StopFlag};
use bus::run::{RunContext, RunError, run_dir};
use bus::session::Session;
use bus::topic::TOOL_POSE;
use bus::{Bus, BusError};
use scene::Scene;

use crate::wire::proto::Log;
use crate::wire::schema::Source;
use crate::write::pose_log::{Entry, Take};
use crate::write::record::watch::Watch;
pub(crate) use cli::{SERVE_HELP, ServeArgs};
use outlet::Outlet;
use views::Views;

/// Between two looks at the topics.
const TICK: Duration = Duration::from_millis(20);
/// Between two scenes, and between two notices that this is a research display: who comes late has them then.
const SCENE_EVERY: Duration = Duration::from_millis(100);
const NOTICE_EVERY: Duration = Duration::from_secs(5);
/// What is said wherever there is room.
pub(super) const NOTICE: &str = "RESEARCH DISPLAY";
/// Poses that are kept for the images that show them.
const KEPT: usize = 4096;

/// Why nothing is served, or not any longer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServeError {
    /// There is no such run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Its scene.
    #[error("the run's scene: {0}")]
    Scene(#[from] scene::SceneError),
    /// Signals.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Other machines could look on.
    #[error(
        "--listen {found}: only this machine's own addresses are served, as nothing asks who looks on: for another machine forward the \
         port, for instance with `ssh -L 8765:localhost:8765`"
    )]
    NotLoopback {
        /// The address.
        found: IpAddr,
    },
    /// The server did not start.
    #[error("serving on {address}: {source}")]
    Server {
        /// Where.
        address: SocketAddr,
        /// Why.
        source: foxglove::FoxgloveError,
    },
}

/// Serves a run until it ends or this process is asked to stop.
///
/// # Errors
/// [`ServeError`].
pub(crate) fn serve(args: &ServeArgs) -> Result<(), ServeError> {
    if !args.listen.ip().is_loopback() {
        return Err(ServeError::NotLoopback {
            found: args.listen.ip(),
        });
    }
    let (run, text) = RunContext::load_with_scene(&run_dir(&args.run)?, None)?;
    let scene = Scene::parse(&text, &run.scene_path())?;
    let stop = StopFlag::install(false)?;
    let mut served = Served::open(&run, &scene, args)?;
    bus::stderr_line!(
        "recorder: serving run {} on ws://{}:{}; in Foxglove open a connection of the kind Foxglove WebSocket. {NOTICE}: nobody operates by it",
        run.name,
        args.listen.ip(),
        served.outlet.port()
    );
    while !stop.is_set() {
        if !run.is_running() {
            bus::stderr_line!("recorder: run {} has ended", run.name);
            break;
        }
        served.step()?;
        std::thread::sleep(TICK);
    }
    served.outlet.stop();
    Ok(())
}

/// A run being served.
struct Served<'a> {
    scene: &'a Scene,
    session: Session,
    poses: Subscriber<ToolPose>,
    watch: Watch,
    views: Views,
    outlet: Outlet,
    /// The newest, for the images that show them.
    known: VecDeque<ToolPose>,
    next_scene_ns: i64,
    next_notice_ns: i64,
}

impl<'a> Served<'a> {
    fn open(run: &RunContext, scene: &'a Scene, args: &ServeArgs) -> Result<Self, ServeError> {
        let bus = Bus::join(run)?;
        Ok(Self {
            scene,
            session: Session::open(&bus, run)?,
            poses: Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer)?,
            watch: Watch::open(&bus, scene)?,
            views: Views::open(&bus, scene, args.every)?,
            outlet: Outlet::start(scene, args.listen)?,
            known: VecDeque::new(),
            next_scene_ns: i64::MIN,
            next_notice_ns: i64::MIN,
        })
    }

    fn step(&mut self) -> Result<(), ServeError> {
        self.session.follow()?;
        let (now_ns, steady_ns) = (self.session.clock().now_ns(), clock::monotonic_ns());
        while let Some(pose) = self.poses.next()? {
            self.outlet.put(now_ns, Entry::Pose(Source::Tool, &pose));
            self.watch.pose(now_ns, &pose, &mut self.outlet);
            if self.known.len() == KEPT {
                self.known.pop_front();
            }
            self.known.push_back(pose);
        }
        self.watch.step(now_ns, &mut self.outlet)?;
        self.views.step(now_ns, steady_ns, &mut self.outlet)?;
        if steady_ns >= self.next_scene_ns {
            self.next_scene_ns = steady_ns + clock::ns(SCENE_EVERY);
            let claim = self.views.claim(now_ns);
            let pose = claim.as_ref().and_then(|claim| {
                let shown =
                    |pose: &&ToolPose| pose.seq == claim.stamp.seq && pose.t_capture_ns == claim.stamp.t_capture_ns;
                self.known.iter().rev().find(shown)
            });
            let update = scene_update::of(self.scene, now_ns, claim.as_ref(), pose, self.views.planes(now_ns));
            self.outlet.scene(now_ns, &update);
        }
        if steady_ns >= self.next_notice_ns {
            self.next_notice_ns = steady_ns + clock::ns(NOTICE_EVERY);
            self.outlet.again();
            let words = format!("{NOTICE}: what is shown here may be late or lost on its way; nobody operates by it");
            self.outlet.put(
                now_ns,
                Entry::Log(now_ns, &Log::new(now_ns, Level::Warning, "recorder", words)),
            );
        }
        Ok(())
    }
}
