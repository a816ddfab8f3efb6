//! The loop: a client, its commands and the frames of the room, then the next client.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread;
use std::time::Duration;

use bus::clock::{Clock, monotonic_ns};
use bus::process::StopFlag;
use ndi::session::{Device, DeviceRules};
use rustix::event::PollFlags;

use super::roles::{Definitions, Roles};
use super::room::Room;
use super::served::served;
use crate::stream;

/// How often a frame is looked for; frames come with less than this added.
const LOOK: Duration = Duration::from_millis(1);
/// How long a client is waited for before the wish to stop is looked at.
const WAIT: Duration = Duration::from_millis(100);
/// Frames of longer ago are not looked for: after a pause only the newest is of use.
const CATCH_UP_NS: i64 = 1_000_000_000;
/// Bytes of a client that are read at once: each reply is to be sent before many more commands are taken.
const CHUNK: usize = 4 << 10;

/// The room and where its script stands; it goes on whether there is a client or not.
pub(super) struct Server {
    room: Box<dyn Room>,
    clock: Clock,
    definitions: Definitions,
    looked_ns: i64,
    /// The number of the newest frame.
    newest: Option<u64>,
}

impl Server {
    /// The script begins now.
    pub(super) fn new(room: Box<dyn Room>, definitions: Definitions) -> Self {
        Self {
            room,
            clock: Clock::monotonic(monotonic_ns()),
            definitions,
            looked_ns: -1,
            newest: None,
        }
    }

    /// Serves one client after the other until asked to stop.
    pub(super) fn serve(&mut self, listener: &TcpListener, stop: &StopFlag) {
        while !stop.is_set() {
            if !stream::ready(listener, PollFlags::IN, WAIT).unwrap_or(false) {
                continue;
            }
            // A client that has gone before it was accepted is none; where the system has no room for one, later may be better.
            let Ok((connection, from)) = listener.accept() else {
                thread::sleep(WAIT);
                continue;
            };
            bus::stderr_line!("localizer-proc: {from} is connected");
            let why = self.client(connection, from, stop);
            bus::stderr_line!("localizer-proc: {from} is gone: {why}");
        }
    }

    /// Serves a client; why it is over. Each one finds the device as it is when it was just switched on.
    fn client(&mut self, connection: TcpStream, from: SocketAddr, stop: &StopFlag) -> String {
        let mut connection = match stream::prepared(connection) {
            Ok(connection) => connection,
            Err(error) => return stream::words(&error),
        };
        let mut device = Device::new(DeviceRules::default());
        let mut roles = Roles::new(self.definitions.clone());
        let mut bytes = [0; CHUNK];
        while !stop.is_set() {
            let count = match stream::read(&mut connection, &mut bytes, LOOK) {
                Ok(count) => count,
                Err(why) => return why,
            };
            if count > 0 {
                let tracked = device.is_tracking();
                let replies = device.bytes(&bytes[..count]);
                roles.look(&device);
                if let Err(why) = stream::write(&mut connection, &replies) {
                    return why;
                }
                if device.is_tracking() && !tracked {
                    tell(&device, &roles, from);
                }
            }
            self.measure(&mut device, &roles);
        }
        "asked to stop".to_owned()
    }

    /// Shows the newest frame, if there is one that was not shown.
    fn measure(&mut self, device: &mut Device, roles: &Roles) {
        let now_ns = self.clock.now_ns();
        let after_ns = self.looked_ns.max(now_ns.saturating_sub(CATCH_UP_NS));
        self.looked_ns = now_ns;
        let found = self.room.newest(after_ns, now_ns);
        // A frame that the room delivers late is none of a device that has measured newer ones.
        let Some(number) = found.filter(|number| self.newest.is_none_or(|newest| *number > newest)) else {
            return;
        };
        self.newest = Some(number);
        if device.is_tracking() {
            device.show(served(&self.room.frame(number), device, roles));
        }
    }
}

fn tell(device: &Device, roles: &Roles, from: SocketAddr) {
    let tools: Vec<String> = device.tools().filter_map(|tool| roles.words(&tool)).collect();
    let tools = match tools.is_empty() {
        true => "no tool".to_owned(),
        false => tools.join("; "),
    };
    bus::stderr_line!("localizer-proc: {from} tracks {tools}");
}
