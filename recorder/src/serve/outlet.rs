//! The channels of a recording, served instead of written.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use bus::message::{ToolPose, Workflow};
use foxglove::messages::SceneUpdate;
use foxglove::{Channel, ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServer};
use foxglove::{FoxgloveError, WebSocketServerHandle};
use scene::Scene;

use super::{NOTICE, ServeError};
use crate::wire::proto::{self, file_time};
use crate::wire::schema::{self, EMITTER_CHANNEL, MARKER_CHANNEL, PROTOBUF, Source, TF_CHANNEL, VIEW_CHANNEL};
use crate::write::pose_log::{Entry, Take};

/// Where the scene is.
const SCENE_TOPIC: &str = "/scene";
/// Of messages for a client that does not read as fast as they come; the oldest make room. A third of a second of them at 60 poses a
/// second: what is shown late must not be shown for long.
const BACKLOG: usize = 64;
/// How long clients have to take the end. Who reads nothing would hold it up for ever.
const GOODBYE: Duration = Duration::from_millis(500);
/// The frame that the tool hangs on while there is no pose: it is connected to none that anything is drawn in.
const NOWHERE: &str = "NO POSE";

/// A server with its channels.
pub(super) struct Outlet {
    // Channels live as long as their context.
    _context: Arc<Context>,
    channels: BTreeMap<u16, Arc<RawChannel>>,
    scene: Channel<SceneUpdate>,
    server: WebSocketServerHandle,
    buffer: Vec<u8>,
    /// Whether the tool's transform may be told.
    has_pose: bool,
    /// How far the run has come, as it was told last.
    workflow: Option<Workflow>,
    /// The newest of what comes only when it changes, by channel and process: who comes late is told it again.
    newest: BTreeMap<(u16, String), (u64, Vec<u8>)>,
}

impl Outlet {
    /// Starts to listen. `origin` is what the poses come from, empty for a localizer in the present.
    ///
    /// # Errors
    /// [`ServeError::Server`].
    pub(super) fn start(scene: &Scene, origin: &str, address: SocketAddr) -> Result<Self, ServeError> {
        let failed = |source| ServeError::Server { address, source };
        // A context of its own: nothing that is logged elsewhere in the process gets out.
        let context = Context::new();
        let channels = channels(scene, &context).map_err(failed)?;
        let scene = ChannelBuilder::new(SCENE_TOPIC)
            .context(&context)
            .add_metadata("notice", NOTICE)
            .build::<SceneUpdate>();
        let server = WebSocketServer::new()
            .name(name(origin))
            .context(&context)
            .message_backlog_size(BACKLOG)
            .bind(address.ip().to_string(), address.port())
            .start_blocking()
            .map_err(failed)?;
        Ok(Self {
            _context: context,
            channels,
            scene,
            server,
            buffer: Vec::new(),
            has_pose: false,
            workflow: None,
            newest: BTreeMap::new(),
        })
    }

    /// The port that it listens on.
    pub(super) fn port(&self) -> u16 {
        self.server.port()
    }

    /// How far the run has come, as it was told last.
    pub(super) fn workflow(&self) -> Option<&Workflow> {
        self.workflow.as_ref()
    }

    /// Whether any client looks at a view, by its place in the scene.
    pub(super) fn is_watched(&self, view: u16) -> bool {
        let channel = self.channels.get(&VIEW_CHANNEL.saturating_add(view));
        channel.is_some_and(|channel| channel.has_sinks())
    }

    /// Whether the tool has a pose that may be shown. As long as it has none no transform of it is told, and it is [`Outlet::forget`]ten
    /// once.
    pub(super) fn tool(&mut self, now_ns: i64, has_pose: bool) {
        if std::mem::replace(&mut self.has_pose, has_pose) && !has_pose {
            self.forget(now_ns);
        }
    }

    /// Takes the tool's transform away. Foxglove keeps the last one of a frame for ever; it has no message to take one away, but a frame
    /// that gets another parent loses all transforms of before, and is drawn nowhere where that hangs on nothing.
    pub(super) fn forget(&self, now_ns: i64) {
        let nowhere = proto::FrameTransform {
            timestamp: Some(proto::timestamp(file_time(now_ns))),
            parent_frame_id: NOWHERE.to_owned(),
            child_frame_id: Source::Tool.frame().to_owned(),
            translation: Some(proto::Vector3::default()),
            rotation: Some(proto::Quaternion {
                w: 1.0,
                ..proto::Quaternion::default()
            }),
        };
        self.tell_transform(&nowhere, now_ns);
    }

    /// Tells the transform of a pose alone, without its numbers.
    pub(super) fn transform(&self, pose: &ToolPose) {
        if let Some(transform) = proto::frame_transform_in_metres(pose, Source::Tool.frame()) {
            self.tell_transform(&transform, pose.t_capture_ns);
        }
    }

    fn tell_transform(&self, transform: &proto::FrameTransform, t_ns: i64) {
        if let Some(channel) = self.channels.get(&TF_CHANNEL) {
            let metadata = PartialMetadata::with_log_time(file_time(t_ns));
            channel.log_with_meta(&prost::Message::encode_to_vec(transform), metadata);
        }
    }

    /// Gives out a scene.
    pub(super) fn scene(&self, now_ns: i64, update: &SceneUpdate) {
        self.scene
            .log_with_meta(update, PartialMetadata::with_log_time(file_time(now_ns)));
    }

    /// Gives out once more what comes only when it changes.
    pub(super) fn again(&self) {
        for ((channel, _), (log_time, bytes)) in &self.newest {
            if let Some(channel) = self.channels.get(channel) {
                channel.log_with_meta(bytes, PartialMetadata::with_log_time(*log_time));
            }
        }
    }

    /// Ends all connections: soon, whatever clients do.
    pub(super) fn stop(self) {
        // What was told last is on its way before the connections are closed.
        std::thread::sleep(GOODBYE / 2);
        let (done, wait) = std::sync::mpsc::channel();
        let handle = self.server.stop();
        std::thread::spawn(move || {
            handle.wait_blocking();
            let _ = done.send(());
        });
        let _ = wait.recv_timeout(GOODBYE);
    }
}

/// As Foxglove shows it beside the address.
fn name(origin: &str) -> String {
    match origin {
        "" => format!("Trocar, {NOTICE}"),
        origin => format!("Trocar, {NOTICE}: {origin}"),
    }
}

/// Those of a recording, but for what the localizer delivered, which few may listen to, and the simulator's truth.
fn channels(scene: &Scene, context: &Arc<Context>) -> Result<BTreeMap<u16, Arc<RawChannel>>, FoxgloveError> {
    let schemas = schema::schemas();
    let views = schema::view_channels(scene.views.iter().map(|view| view.name.as_str()));
    let all = schema::channels().into_iter().chain(views);
    let left_out = [EMITTER_CHANNEL, MARKER_CHANNEL, Source::Truth.channel()];
    let mut channels = BTreeMap::new();
    for channel in all.filter(|channel| !left_out.contains(&channel.id)) {
        let schema = schemas.iter().find(|schema| schema.0 == channel.schema_id);
        let schema = schema.map(|(_, name, data)| Schema::new(*name, PROTOBUF, *data));
        let raw = ChannelBuilder::new(channel.topic)
            .context(context)
            .message_encoding(PROTOBUF)
            .schema(schema)
            .metadata(channel.metadata)
            .build_raw()?;
        channels.insert(channel.id, raw);
    }
    Ok(channels)
}

impl Take for Outlet {
    fn put(&mut self, _now_ns: i64, entry: Entry<'_>) {
        if let Entry::Workflow(told) = entry {
            self.workflow = Some(Workflow {
                t_ns: told.t_ns,
                stage: told.stage,
                flags: told.flags,
                ..Workflow::default()
            });
        }
        let mut buffer = std::mem::take(&mut self.buffer);
        let of = match entry {
            Entry::Status(status) => Some(status.process.clone()),
            Entry::Workflow(_) | Entry::Guide(..) => Some(String::new()),
            _ => None,
        };
        let Ok(()) = entry.encoded(&mut buffer, |place, bytes| {
            // The run's clock, as in a recording and in the messages themselves.
            let log_time = file_time(place.times[0]);
            let is_kept_back = place.channel == TF_CHANNEL && !self.has_pose;
            if let Some(channel) = self.channels.get(&place.channel).filter(|_| !is_kept_back) {
                channel.log_with_meta(bytes, PartialMetadata::with_log_time(log_time));
            }
            if let Some(of) = of.clone() {
                self.newest.insert((place.channel, of), (log_time, bytes.to_vec()));
            }
            Ok::<(), Infallible>(())
        });
        self.buffer = buffer;
    }
}

#[cfg(test)]
mod tests;
