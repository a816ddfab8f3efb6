//! The connection to a real localizer: `[localizer]`.

mod images;

use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid, number, seconds};
pub use images::{ImagesSpec, RawConvex, RawImages, ShownBeams};

/// The longest host name, bytes.
const HOST_BYTES: usize = 253;
/// The longest name of a tool, bytes.
const NAME_BYTES: usize = 64;
/// As many tools as one frame of markers holds.
const MOST_TOOLS: usize = 16;

/// As many mm as a localizer that states metres may see far, m; none looks further than 10 m.
const LEAST_DISTANCE_MM: f64 = 10.0;

/// What a localizer speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Protocol {
    /// OpenIGTLink: PLUS, 3D Slicer and most research platforms.
    Openigtlink,
    /// The combined API of NDI's localizers.
    Ndi,
}

/// Which header version an OpenIGTLink peer is sent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Peer {
    /// 2 at first, and 1 where the peer falls silent at that.
    #[default]
    Auto,
    /// 2 from the first message on: PLUS states the status of a tool to nobody else.
    Plus,
    /// 1 for ever: the C++ library before version 3, many vendors.
    V1,
}

/// What a pose without a status is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StatusRule {
    /// None: nothing says that the tool was seen.
    #[default]
    Required,
    /// A good one: the peer is known to send nothing for a tool that it does not see.
    AbsentMeansValid,
}

/// What the time of a capture is made of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StampRule {
    /// The localizer's stamp, mapped onto the run's clock.
    #[default]
    Mapped,
    /// The arrival.
    Arrival,
}

/// What follows on a connection that is over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reconnect {
    /// The next one, as soon as it can be had.
    #[default]
    Always,
    /// Nothing before a person says so (`pilot restart localizer`): for peers where somebody confirms every connection.
    Ask,
}

/// `[localizer]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLocalizer {
    /// What it speaks.
    pub kind: Protocol,
    /// `host:port`.
    pub address: String,
    /// For people; absent: the address.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// OpenIGTLink: which version it reads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peer: Option<Peer>,
    /// OpenIGTLink: what a pose without a status is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status: Option<StatusRule>,
    /// OpenIGTLink: ask for a stream of TDATA with so long between two messages, ms; absent: take what comes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream_ms: Option<f64>,
    /// OpenIGTLink: the largest entry of `R^T R - I` that a matrix may have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_rotation_error: Option<f64>,
    /// OpenIGTLink: a marker nearer to the localizer's origin than this has no pose, mm; absent: 10.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_distance_mm: Option<f64>,
    /// OpenIGTLink: what follows on a connection that is over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reconnect: Option<Reconnect>,
    /// NDI: tools whose definitions are written to it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tools: Vec<RawLocalizerTool>,
    /// OpenIGTLink: ultrasound images of the same peer; absent: none are taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub images: Option<RawImages>,
    /// OpenIGTLink: a connection on which nothing comes for so long is given up, s; absent: `limits.silent_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub silent_s: Option<f64>,
    /// What the time of a capture is made of.
    #[serde(default)]
    pub clock: StampRule,
    /// What is known of the least time from the capture to the arrival, ms: taken off.
    #[serde(default)]
    pub least_delay_ms: f64,
}

/// `[[localizer.tools]]`
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLocalizerTool {
    /// What it is called here.
    pub name: String,
    /// Its definition, relative to the scene file.
    pub rom: String,
    /// With `tracker.source = "emitters"`: what its markers sit on; absent: the surgeon's tool.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<Carrier>,
}

/// What a tool of the localizer sits on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Carrier {
    /// The surgeon's tool.
    #[default]
    Tool,
    /// The patient.
    Patient,
}

/// The connection, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalizerSpec {
    /// For people.
    pub name: String,
    /// `host:port`.
    pub address: String,
    /// What is spoken on it.
    pub link: LinkSpec,
    /// What the time of a capture is made of.
    pub clock: StampRule,
    /// The least time from the capture to the arrival.
    pub least_delay: Duration,
}

impl LocalizerSpec {
    /// Why no sweep takes the images that the scene asks for, with the key to change; `None` where one may, or none are asked for.
    pub fn why_no_sweep(&self) -> Option<&'static str> {
        let LinkSpec::OpenIgtLink(OpenIgtLinkSpec {
            images: Some(images), ..
        }) = &self.link
        else {
            return None;
        };
        match (self.clock, images.shown) {
            (StampRule::Arrival, _) => Some(
                "images are timed by their arrival (localizer.clock = \"arrival\"), which is late by no one number: write clock = \"mapped\"",
            ),
            (StampRule::Mapped, None) => Some(
                "nothing says where beams run in an image: write localizer.images.depth_mm, and linear_mm or convex",
            ),
            (StampRule::Mapped, Some(_)) => None,
        }
    }
}

/// What is spoken.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkSpec {
    /// OpenIGTLink.
    OpenIgtLink(OpenIgtLinkSpec),
    /// NDI's combined API.
    Ndi(NdiSpec),
}

/// A peer that speaks OpenIGTLink.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenIgtLinkSpec {
    /// Which version it reads.
    pub peer: Peer,
    /// What a pose without a status is.
    pub status: StatusRule,
    /// Between two messages of the stream that is asked for; `None`: nothing is asked for.
    pub stream: Option<Duration>,
    /// The largest entry of `R^T R - I` that a matrix may have.
    pub max_rotation_error: f64,
    /// A marker nearer to the localizer's origin than this has no pose, mm: metres that are taken for mm lie there, and places that nobody set.
    pub least_distance_mm: f64,
    /// What follows on a connection that is over.
    pub reconnect: Reconnect,
    /// A connection on which nothing comes for so long is given up.
    pub silent: Duration,
    /// Ultrasound images that are taken; `None`: none.
    pub images: Option<ImagesSpec>,
}

/// A localizer of NDI.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NdiSpec {
    /// Tools whose definitions are written to it: name and file.
    pub tools: Vec<(String, PathBuf)>,
    /// With `tracker.source = "emitters"`: its single markers are published, those of these tools.
    pub single: Option<SingleMarkers>,
}

/// Whose single markers are emitters of the tracker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SingleMarkers {
    /// The name of the tool whose markers are those of `[tracker.emitters.marker]`, in the same order.
    pub tool: String,
    /// The same of `[tracker.emitters.reference]`.
    pub patient: Option<String>,
}

/// What the tracker makes poses of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Followed {
    /// Poses of markers.
    Markers,
    /// Emitters, also of a marker on the patient where the scene has one.
    Emitters {
        /// It has.
        has_reference: bool,
    },
    /// Nothing that comes of a localizer's driver.
    Other,
}

/// What the rest of the scene says that matters here.
pub(super) struct Around<'a> {
    /// By `tracker.source`.
    pub(super) followed: Followed,
    /// `tracker.markers.marker` and `tracker.markers.reference`.
    pub(super) names: [Option<&'a str>; 2],
    /// `limits.silent_s`.
    pub(super) silent_s: f64,
}

pub(super) fn checked(raw: Option<&RawLocalizer>, around: &Around<'_>) -> Checked<Option<LocalizerSpec>> {
    let Some(localizer) = raw else {
        return Ok(None);
    };
    match (around.followed, localizer.kind) {
        (Followed::Markers, _) | (Followed::Emitters { .. }, Protocol::Ndi) => {}
        (Followed::Emitters { .. }, Protocol::Openigtlink) => {
            let allowed = "\"ndi\" with tracker.source = \"emitters\", as OpenIGTLink has no single markers";
            return Err(invalid("localizer.kind", "\"openigtlink\"", allowed));
        }
        (Followed::Other, _) => {
            let allowed = "no such table unless tracker.source = \"markers\" or \"emitters\"";
            return Err(invalid("localizer", "a table", allowed));
        }
    }
    of_other_kinds(localizer)?;
    let delay_ms = number("localizer.least_delay_ms", localizer.least_delay_ms, 0.0..=1000.0, "ms")?;
    let address = address(&localizer.address)?;
    Ok(Some(LocalizerSpec {
        name: match &localizer.name {
            Some(name) => label("localizer.name", name)?,
            None => address.clone(),
        },
        address,
        link: match localizer.kind {
            Protocol::Openigtlink => LinkSpec::OpenIgtLink(openigtlink(around.silent_s, localizer)?),
            Protocol::Ndi => LinkSpec::Ndi(ndi(around, localizer)?),
        },
        clock: localizer.clock,
        least_delay: Duration::from_secs_f64(delay_ms / 1e3),
    }))
}

/// A key that would mean nothing is more likely a wrong kind than a leftover.
fn of_other_kinds(raw: &RawLocalizer) -> Checked<()> {
    let of = |key: &'static str, there: bool, kind, word| (key, there && raw.kind != kind, word);
    let (openigtlink, ndi) = ((Protocol::Openigtlink, "openigtlink"), (Protocol::Ndi, "ndi"));
    for (key, wrong, word) in [
        of("peer", raw.peer.is_some(), openigtlink.0, openigtlink.1),
        of("status", raw.status.is_some(), openigtlink.0, openigtlink.1),
        of("stream_ms", raw.stream_ms.is_some(), openigtlink.0, openigtlink.1),
        of(
            "max_rotation_error",
            raw.max_rotation_error.is_some(),
            openigtlink.0,
            openigtlink.1,
        ),
        of(
            "least_distance_mm",
            raw.least_distance_mm.is_some(),
            openigtlink.0,
            openigtlink.1,
        ),
        of("silent_s", raw.silent_s.is_some(), openigtlink.0, openigtlink.1),
        of("reconnect", raw.reconnect.is_some(), openigtlink.0, openigtlink.1),
        of("images", raw.images.is_some(), openigtlink.0, openigtlink.1),
        of("tools", !raw.tools.is_empty(), ndi.0, ndi.1),
    ] {
        if wrong {
            let allowed = format!("no such key unless localizer.kind = \"{word}\"");
            return Err(invalid(format!("localizer.{key}"), "a value", allowed));
        }
    }
    Ok(())
}

fn openigtlink(limit_s: f64, raw: &RawLocalizer) -> Checked<OpenIgtLinkSpec> {
    let stream = raw
        .stream_ms
        .map(|ms| number("localizer.stream_ms", ms, 1.0..=1000.0, "ms"));
    let error = raw.max_rotation_error.unwrap_or(2e-3);
    let nearest_mm = raw.least_distance_mm.unwrap_or(LEAST_DISTANCE_MM);
    Ok(OpenIgtLinkSpec {
        peer: raw.peer.unwrap_or_default(),
        status: raw.status.unwrap_or_default(),
        stream: stream.transpose()?.map(|ms| Duration::from_secs_f64(ms / 1e3)),
        max_rotation_error: number("localizer.max_rotation_error", error, 1e-6..=1e-2, "")?,
        least_distance_mm: number("localizer.least_distance_mm", nearest_mm, 0.0..=1000.0, "mm")?,
        reconnect: raw.reconnect.unwrap_or_default(),
        images: raw.images.as_ref().map(images::images).transpose()?,
        // A peer is asked each second, and has half of one to answer.
        silent: match raw.silent_s {
            Some(silent_s) => seconds("localizer.silent_s", silent_s, 1.5..=60.0)?,
            None => Duration::from_secs_f64(limit_s.clamp(1.5, 60.0)),
        },
    })
}

/// Tools are the markers that the tracker asks for, by their names.
fn ndi(around: &Around<'_>, raw: &RawLocalizer) -> Checked<NdiSpec> {
    let found = raw.tools.len();
    if !(1..=MOST_TOOLS).contains(&found) {
        return Err(invalid("localizer.tools", found, format!("1 to {MOST_TOOLS} tools")));
    }
    let mut tools: Vec<(String, PathBuf)> = Vec::with_capacity(found);
    for (at, tool) in raw.tools.iter().enumerate() {
        let key = |name: &str| format!("localizer.tools.{at}.{name}");
        let name = label(&key("name"), &tool.name)?;
        if tools.iter().any(|(other, _)| *other == name) {
            return Err(invalid(
                key("name"),
                format!("{name:?} a second time"),
                "a name for each tool",
            ));
        }
        if tool.rom.is_empty() || tool.rom.ends_with('/') {
            return Err(invalid(key("rom"), format!("{:?}", tool.rom), "the path of a file"));
        }
        tools.push((name, PathBuf::from(&tool.rom)));
    }
    for (key, named) in ["marker", "reference"].into_iter().zip(around.names) {
        let Some(named) = named else { continue };
        if !tools.iter().any(|(name, _)| *name == named) {
            let allowed = "the name of one of localizer.tools";
            return Err(invalid(format!("tracker.markers.{key}"), format!("{named:?}"), allowed));
        }
    }
    Ok(NdiSpec {
        single: single(around.followed, raw)?,
        tools,
    })
}

/// Which tools carry the emitters, each once.
fn single(followed: Followed, raw: &RawLocalizer) -> Checked<Option<SingleMarkers>> {
    let Followed::Emitters { has_reference } = followed else {
        return match raw.tools.iter().position(|tool| tool.on.is_some()) {
            None => Ok(None),
            Some(at) => {
                let allowed = "no such key unless tracker.source = \"emitters\"";
                Err(invalid(format!("localizer.tools.{at}.on"), "a value", allowed))
            }
        };
    };
    let on = |carrier: Carrier| {
        let all = raw
            .tools
            .iter()
            .filter(move |tool| tool.on.unwrap_or_default() == carrier);
        all.map(|tool| tool.name.clone()).collect::<Vec<_>>()
    };
    let wanted = [
        (Carrier::Tool, 1, "the tool"),
        (Carrier::Patient, usize::from(has_reference), "the patient"),
    ];
    for (carrier, count, words) in wanted {
        let found = on(carrier).len();
        if found != count {
            let allowed = format!("{count}, as [tracker.emitters] has markers");
            return Err(invalid("localizer.tools", format!("{found} on {words}"), allowed));
        }
    }
    Ok(on(Carrier::Tool).pop().map(|tool| SingleMarkers {
        tool,
        patient: on(Carrier::Patient).pop(),
    }))
}

fn label(key: &str, text: &str) -> Checked<String> {
    let good = (1..=NAME_BYTES).contains(&text.len()) && !text.chars().any(char::is_control);
    match good {
        true => Ok(text.to_owned()),
        false => Err(invalid(
            key,
            format!("{text:?}"),
            format!("1 to {NAME_BYTES} bytes on one line"),
        )),
    }
}

fn address(text: &str) -> Checked<String> {
    let (host, port) = text.rsplit_once(':').unwrap_or((text, ""));
    let is_host = (1..=HOST_BYTES).contains(&host.len())
        && host
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || b".-_:[]%".contains(&byte));
    // Digits alone: a number may be written with a sign.
    let is_port = port.bytes().all(|byte| byte.is_ascii_digit()) && port.parse::<u16>().is_ok_and(|port| port > 0);
    match is_host && is_port {
        true => Ok(text.to_owned()),
        false => Err(invalid("localizer.address", format!("{text:?}"), reachable(text))),
    }
}

/// What an address may be; whoever names a serial line is told that none is dialled.
fn reachable(text: &str) -> &'static str {
    let of_windows = text.get(..3).is_some_and(|start| start.eq_ignore_ascii_case("com"))
        && text.bytes().skip(3).all(|byte| byte.is_ascii_digit());
    match text.starts_with("/dev/") || of_windows {
        true => "host:port of a network, such as \"192.168.0.30:8765\": serial lines are not dialled",
        false => "host:port, such as \"192.168.0.30:18944\"",
    }
}

#[cfg(test)]
mod tests;
