//! What a person wishes becomes requests to the processes that keep it: the window keeps nothing.

use std::path::PathBuf;
use std::time::Duration;

use bus::clock::Clock;
use bus::message::{ClockLaw, Command, CommandKind, ReplayState, ToolPose};
use bus::port::CommandClient;
use bus::{Bus, BusError};
use scene::Scene;

use crate::feed::Feed;
use crate::screen::Wish;

/// So long the answers to a wish are waited for, all together: a window that stands still for longer is taken for frozen.
const PATIENCE: Duration = Duration::from_millis(150);
/// The replayer's process.
const REPLAYER: &str = "replay";

/// Whoever is asked.
#[derive(Debug)]
pub struct Asked {
    pilot: CommandClient,
    renderers: Vec<CommandClient>,
    replayer: Option<CommandClient>,
    clock: Clock,
    /// Where pictures of the screen go.
    pub shots: PathBuf,
}

impl Asked {
    /// Prepares to ask the processes of a run.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, scene: &Scene, is_replay: bool, shots: PathBuf) -> Result<Self, BusError> {
        let renderers = scene.renderers().into_iter().map(|(plane, _)| plane.process());
        Ok(Self {
            pilot: CommandClient::open(bus, "pilot")?,
            renderers: renderers
                .map(|name| CommandClient::open(bus, &name))
                .collect::<Result<_, _>>()?,
            replayer: is_replay.then(|| CommandClient::open(bus, REPLAYER)).transpose()?,
            clock: bus.clock().clone(),
            shots,
        })
    }

    /// Asks for what is wished; `replay` is the clock of a replay with what it shows now, ns.
    ///
    /// # Errors
    /// In words: what was answered, or that nobody did.
    pub fn carry_out(
        &self,
        wish: &Wish,
        feed: &Feed,
        scene: &Scene,
        replay: Option<(ClockLaw, i64)>,
    ) -> Result<(), String> {
        match wish {
            Wish::NextTarget { is_forward } => {
                let name = next_target(feed, scene, *is_forward).ok_or("the scene has no targets")?;
                ask(&self.pilot, Command::with_text(CommandKind::Choose, &name))
            }
            Wish::Mark => ask(
                &self.pilot,
                Command::with_text(CommandKind::Mark, "marked on the screen"),
            ),
            Wish::Hold => self.hold(feed),
            Wish::Pause => self.pause(replay.map(|(law, _)| law.replay_state())),
            Wish::Step => self.replay(Command::new(CommandKind::Step)),
            Wish::Skip(by_s) => {
                let (law, now_ns) = replay.ok_or("there is no recording to go through")?;
                let now_s = bus::clock::ms(now_ns.saturating_sub(law.first_ns)) / 1000.0;
                let to_s = (now_s + f64::from(*by_s)).max(0.0);
                self.replay(Command::with_number(CommandKind::Seek, to_s))
            }
            // Of this screen alone.
            Wish::Shot | Wish::Enlarge(_) => Ok(()),
        }
    }

    /// Has every view drawn of the pose shown, and then says that it is held; or follows again.
    fn hold(&self, feed: &Feed) -> Result<(), String> {
        if feed.guide().is_some_and(|guide| guide.held().is_some()) {
            return ask(&self.pilot, Command::new(CommandKind::Follow));
        }
        let pose: ToolPose = feed.pose_shown().ok_or("there is no pose to hold")?;
        let until_ns = self.clock.now_ns() + bus::clock::ns(PATIENCE);
        let left = || Duration::from_nanos(u64::try_from(until_ns - self.clock.now_ns()).unwrap_or(0));
        for renderer in &self.renderers {
            ask_for(renderer, Command::render(pose), left())?;
        }
        ask_for(&self.pilot, Command::hold(pose), left())
    }

    fn pause(&self, state: Option<ReplayState>) -> Result<(), String> {
        self.replay(Command::new(match state {
            Some(ReplayState::Paused) => CommandKind::Play,
            _ => CommandKind::Pause,
        }))
    }

    fn replay(&self, command: Command) -> Result<(), String> {
        let replayer = self.replayer.as_ref().ok_or("this is no replay")?;
        ask(replayer, command)
    }
}

fn ask(client: &CommandClient, command: Command) -> Result<(), String> {
    ask_for(client, command, PATIENCE)
}

fn ask_for(client: &CommandClient, command: Command, patience: Duration) -> Result<(), String> {
    match client.ask(command, patience) {
        Ok(reply) if reply.refused => Err(reply.text),
        Ok(_) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}

/// The target of the scene after the chosen one, or before it; the first where none is chosen.
fn next_target(feed: &Feed, scene: &Scene, is_forward: bool) -> Option<String> {
    let chosen = feed.guide().and_then(|guide| guide.chosen().ok().flatten());
    let place = chosen.and_then(|chosen| scene.targets.iter().position(|target| target.name == chosen.name));
    let count = scene.targets.len();
    let next = match (place, is_forward) {
        (None, _) => 0,
        (Some(place), true) => (place + 1) % count,
        (Some(place), false) => (place + count - 1) % count,
    };
    scene.targets.get(next).map(|target| target.name.clone())
}
