//! The channels of a recording, served instead of written.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::Arc;

use foxglove::messages::SceneUpdate;
use foxglove::{Channel, ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServer};
use foxglove::{FoxgloveError, WebSocketServerHandle};
use scene::Scene;

use super::{NOTICE, ServeError};
use crate::wire::proto::file_time;
use crate::wire::schema::{self, EMITTER_CHANNEL, MARKER_CHANNEL, PROTOBUF, Source};
use crate::write::pose_log::{Entry, Take};

/// Where the scene is.
const SCENE_TOPIC: &str = "/scene";

/// A server with its channels.
pub(super) struct Outlet {
    // Channels live as long as their context.
    _context: Arc<Context>,
    channels: BTreeMap<u16, Arc<RawChannel>>,
    scene: Channel<SceneUpdate>,
    server: WebSocketServerHandle,
    buffer: Vec<u8>,
    /// The newest of what comes only when it changes, by channel and process: who comes late is told it again.
    newest: BTreeMap<(u16, String), (u64, Vec<u8>)>,
}

impl Outlet {
    /// Starts to listen.
    ///
    /// # Errors
    /// [`ServeError::Server`].
    pub(super) fn start(scene: &Scene, address: SocketAddr) -> Result<Self, ServeError> {
        let failed = |source| ServeError::Server { address, source };
        // A context of its own: nothing that is logged elsewhere in the process gets out.
        let context = Context::new();
        let channels = channels(scene, &context).map_err(failed)?;
        let scene = ChannelBuilder::new(SCENE_TOPIC)
            .context(&context)
            .add_metadata("notice", NOTICE)
            .build::<SceneUpdate>();
        let server = WebSocketServer::new()
            .name(format!("Trocar, {NOTICE}"))
            .context(&context)
            .bind(address.ip().to_string(), address.port())
            .start_blocking()
            .map_err(failed)?;
        Ok(Self {
            _context: context,
            channels,
            scene,
            server,
            buffer: Vec::new(),
            newest: BTreeMap::new(),
        })
    }

    /// The port that it listens on.
    pub(super) fn port(&self) -> u16 {
        self.server.port()
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

    /// Ends all connections.
    pub(super) fn stop(self) {
        self.server.stop().wait_blocking();
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
        let mut buffer = std::mem::take(&mut self.buffer);
        let of = match entry {
            Entry::Status(status) => Some(status.process.clone()),
            Entry::Workflow(_) | Entry::Guide(..) => Some(String::new()),
            _ => None,
        };
        let Ok(()) = entry.encoded(&mut buffer, |place, bytes| {
            // The run's clock, as in a recording and in the messages themselves.
            let log_time = file_time(place.times[0]);
            if let Some(channel) = self.channels.get(&place.channel) {
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
