//! Things to begin with.

use std::path::{Path, PathBuf};

use ndi::session::{Action, Client, ClientRules, Device, DeviceRules, Event, Notice, Reason, Tool};
use ndi::status::{MarkerStatus, ToolStatus};
use ndi::{
    Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, Decoder, Frame, FrameKind, Handle, Limits, Malformed, Reply, Rom,
    Transform,
};

pub(crate) const MS: i64 = 1_000_000;

/// Definitions of real tools by name; empty, with the reason printed, where they are not to be had.
pub(crate) fn real_roms() -> Vec<(String, Vec<u8>)> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("TROCAR_SHARED")
        .map_or(beside, PathBuf::from)
        .join("data/tracker-plus/NdiToolDefinitions");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!(
            "skipped: {} is not there (TROCAR_SHARED names its folder)",
            folder.display()
        );
        return Vec::new();
    };
    let file = |path: PathBuf| {
        (
            path.file_name().unwrap().to_string_lossy().into_owned(),
            std::fs::read(path).unwrap(),
        )
    };
    entries.map(|entry| file(entry.unwrap().path())).collect()
}

/// A definition with these markers and a right sum.
pub(crate) fn rom_bytes(markers: &[[f32; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 752];
    bytes[..4].copy_from_slice(b"NDI\0");
    bytes[24] = 90;
    bytes[28] = markers.len() as u8;
    bytes[32] = 3;
    bytes[36..40].copy_from_slice(&0.75_f32.to_le_bytes());
    for (number, coordinate) in markers.iter().flatten().enumerate() {
        bytes[72 + 4 * number..76 + 4 * number].copy_from_slice(&coordinate.to_le_bytes());
    }
    bytes[580..583].copy_from_slice(b"NDI");
    bytes[592..596].copy_from_slice(b"ball");
    summed(&mut bytes);
    bytes
}

/// Puts its sum right.
pub(crate) fn summed(bytes: &mut [u8]) {
    let sum = ndi::checksum(bytes);
    bytes[4..6].copy_from_slice(&sum.to_le_bytes());
}

pub(crate) const MARKERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [0.0, 28.6, 41.0], [0.0, 0.0, 88.0], [0.0, -44.3, 40.5]];

pub(crate) fn rom() -> Rom {
    Rom::checked(&rom_bytes(&MARKERS)).unwrap()
}

/// A transform of numbers that single precision has.
pub(crate) fn transform(x: f64) -> Transform {
    Transform {
        q: [0.5, -0.5, 0.5, 0.5],
        t_mm: [x, -20.25, -1500.5],
        error_mm: 0.125,
    }
}

pub(crate) fn tool(handle: u16, status: u16) -> Bx2Tool {
    let status = ToolStatus(status);
    Bx2Tool {
        handle: Handle(handle),
        status,
        transform: (!status.is_missing()).then(|| transform(f64::from(handle))),
    }
}

pub(crate) fn stray(index: u16, status: u8) -> Bx2Marker {
    Bx2Marker {
        status: MarkerStatus(status),
        index,
        place_mm: [f64::from(index), 2.0, -1400.0],
    }
}

/// A frame with these tools and two strays.
pub(crate) fn frame(number: u32, tools: Vec<Bx2Tool>) -> Bx2Frame {
    Bx2Frame {
        kind: FrameKind(2),
        index: 0,
        status: ToolStatus(0),
        number,
        device_ns: 1_700_000_000_000_000_000 + i64::from(number) * 16_666_667,
        tools,
        markers: vec![Bx2Markers {
            handle: Handle::STRAY,
            markers: vec![stray(0, 0), stray(1, 6)],
        }],
        errors: Vec::new(),
    }
}

/// All that a stream says, in pieces of this length.
pub(crate) fn stream(bytes: &[u8], piece: usize) -> Vec<Result<Owned, Malformed>> {
    let mut decoder = Decoder::new(Limits::DEFAULT);
    let mut said = Vec::new();
    for mut piece in bytes.chunks(piece) {
        while let Some(result) = decoder.feed(&mut piece) {
            said.push(result.map(|reply| match reply {
                Reply::Text(text) => Owned::Text(text.to_owned()),
                Reply::Binary(body) => Owned::Binary(body.to_vec()),
            }));
        }
    }
    said.extend(decoder.end().map(Err));
    said
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Owned {
    Text(String),
    Binary(Vec<u8>),
}

pub(crate) fn rules() -> ClientRules {
    let tool = |name: &str| Tool {
        name: name.to_owned(),
        rom: rom(),
        priority: 'D',
    };
    ClientRules {
        tools: vec![tool("ball"), tool("reference")],
        markers: ndi::Markers::Strays,
        ..ClientRules::default()
    }
}

/// A client and a device on one wire without delay.
pub(crate) struct Pair {
    pub(crate) client: Client,
    pub(crate) device: Device,
    pub(crate) now: i64,
    pub(crate) published: Vec<Frame>,
    pub(crate) told: Vec<Notice>,
    pub(crate) closed: Option<Reason>,
    pub(crate) sent: Vec<String>,
}

impl Pair {
    pub(crate) fn new(client: ClientRules, device: DeviceRules) -> Self {
        Self {
            client: Client::new(client),
            device: Device::new(device),
            now: 0,
            published: Vec::new(),
            told: Vec::new(),
            closed: None,
            sent: Vec::new(),
        }
    }

    /// Hands an event over and carries bytes to and fro until nobody has any.
    pub(crate) fn event(&mut self, event: Event<'_>) {
        let actions = self.client.step(event, self.now);
        let replies = self.take(actions);
        if !replies.is_empty() {
            self.event(Event::Bytes(&replies));
        }
    }

    /// Carries out; what the device answers.
    pub(crate) fn take(&mut self, actions: Vec<Action>) -> Vec<u8> {
        let mut replies = Vec::new();
        for action in actions {
            match action {
                Action::Send(bytes) => {
                    self.sent.push(String::from_utf8(bytes.clone()).unwrap());
                    replies.extend(self.device.bytes(&bytes));
                }
                Action::Tell(notice) => self.told.push(notice),
                Action::Publish(frame, _) => self.published.push(frame),
                Action::Close(reason) => self.closed = Some(reason),
                Action::Speed(_) => {}
            }
        }
        replies
    }

    /// Lets time go by in steps of 10 ms.
    pub(crate) fn wait(&mut self, ms: i64) {
        for _ in 0..ms / 10 {
            self.now += 10 * MS;
            self.event(Event::Tick);
        }
    }

    pub(crate) fn show(&mut self, frame: Bx2Frame) {
        self.device.show(frame);
        self.wait(10);
    }
}
