//! No lost tool is shown as valid, whatever a peer makes of status words, header versions, kinds of messages, names and silences.
//!
//! Of each pose of each frame it is asked what was sent: the oracle below knows the words that were sent, and nothing of how the client
//! reads them. `TROCAR_SEQUENCES` says how many sequences there are.

use std::collections::BTreeMap;

use igtl::{Orientation, Placed, Position, Tool};

use super::*;

/// Sequences where nothing else is said: some seconds in a development build.
const USUAL: u64 = 20_000;
/// Messages of a sequence, at most.
const LONGEST: u64 = 12;
/// A scene's name of a tool that PLUS cuts, and what is left of it.
const LONG: &str = "StylusToTrackerOfTheRoom";
const CUT: &str = "StylusToTrackerOfThe";
/// Another tool of the same peer that is cut to the same.
const TWIN: &str = "StylusToTrackerOfTheHall";
const SHORT: &str = "StylusToTracker";
const REFERENCE: &str = "ReferenceToTracker";

/// Numbers that look like chance and are the same everywhere.
struct Chance(u64);

impl Chance {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }
}

/// Words that are no OK, among them what is nearly one. `None`: nothing is said.
const WORDS: [Option<&str>; 17] = [
    Some("OK"),
    Some("OK"),
    Some("OK"),
    Some("MISSING"),
    Some("OUT_OF_VIEW"),
    Some("OUT_OF_VOLUME"),
    Some("SWITCH1_IS_ON"),
    Some("REQ_TIMEOUT"),
    Some("INVALID"),
    Some("PATH_NOT_FOUND"),
    Some("UNKNOWN"),
    Some("ok"),
    Some("OK "),
    Some(""),
    Some("0"),
    None,
    None,
];

/// What one message says of one tool.
#[derive(Debug, Clone)]
struct Said {
    /// Where the tool lies along x, mm: another number in every message.
    x: f64,
    /// All that is said of tools of that name: whether each is OK.
    words: Vec<bool>,
    /// The tool's turn is measured.
    is_whole: bool,
    /// No word was said of it before, and the scene's rule.
    may_be_silent: bool,
}

impl Said {
    /// Whether the tool may be shown: all that is said of it is OK; where nothing is, the scene must have said what that means.
    fn may_be_shown(&self) -> bool {
        let is_said_good = !self.words.is_empty() && self.words.iter().all(|good| *good);
        self.is_whole && (is_said_good || (self.words.is_empty() && self.may_be_silent))
    }
}

/// What was sent, by stamp and marker.
type Sent = BTreeMap<(i64, u32), Vec<Said>>;

/// One sequence: its scene, its client, and what was sent.
struct Sequence<'a> {
    chance: &'a mut Chance,
    client: OpenIgtLink,
    rule: StatusRule,
    /// The scene's tool, and its name on the wire.
    tool: [&'static str; 2],
    sent: Sent,
    /// Markers of which a word was said, on whatever connection.
    stated: Vec<u32>,
    /// The message that is being made is damaged on the way.
    is_damaged: bool,
    stamp_ns: i64,
    now_ns: i64,
    x: f32,
    /// The kinds of message that its peer sends, as many times as they are likely.
    kinds: &'static [Sends],
    /// Poses that were shown.
    shown: u64,
}

/// A kind of message.
#[derive(Debug, Clone, Copy)]
enum Sends {
    Transform,
    Position,
    Tdata,
    Qtdata,
}

/// Of most peers one kind makes the frames of a marker, and others are held against it; the rest of the peers send one alone.
const KINDS: [&[Sends]; 5] = [
    &[Sends::Transform],
    &[Sends::Tdata],
    &[Sends::Transform, Sends::Position],
    &[
        Sends::Transform,
        Sends::Transform,
        Sends::Position,
        Sends::Tdata,
        Sends::Qtdata,
    ],
    &[
        Sends::Transform,
        Sends::Transform,
        Sends::Position,
        Sends::Tdata,
        Sends::Qtdata,
    ],
];

impl<'a> Sequence<'a> {
    fn new(chance: &'a mut Chance) -> Self {
        let rule = chance.of(&[StatusRule::Required, StatusRule::AbsentMeansValid]);
        let tool = chance.of(&[[SHORT, SHORT], [LONG, CUT]]);
        let spec = OpenIgtLinkSpec {
            peer: chance.of(&[Peer::Auto, Peer::Plus, Peer::V1]),
            ..spec(rule)
        };
        let mut markers = markers();
        markers.marker = Some(tool[0].to_owned());
        if chance.below(3) == 0 {
            markers.reference = None;
        }
        let mut client = OpenIgtLink::new(&spec, &markers).unwrap();
        client.connected(0);
        let kinds = chance.of(&KINDS);
        Self {
            chance,
            kinds,
            client,
            rule,
            tool,
            sent: Sent::new(),
            stated: Vec::new(),
            is_damaged: false,
            stamp_ns: 0,
            now_ns: 0,
            x: 0.0,
            shown: 0,
        }
    }

    fn run(mut self) -> u64 {
        for _ in 0..2 + self.chance.below(LONGEST - 1) {
            // Stamps go on, stand still, go back.
            self.stamp_ns += self.chance.of(&[0, 0, 16 * MS, 16 * MS, 17 * MS, -16 * MS, -400 * MS]);
            self.stamp_ns = self.stamp_ns.max(0);
            self.pass();
            let bytes = self.message();
            let acts = self.client.bytes(&bytes, self.now_ns);
            self.take(acts);
            let acts = self.client.tick(self.now_ns);
            self.take(acts);
        }
        self.pass();
        self.shown
    }

    /// Time goes by: hardly any, a frame, or more than the peer may be silent for.
    fn pass(&mut self) {
        let pause_ns = self.chance.of(&[0, 0, 1, 3, 16, 16, 40, 400, 1700, 2600]) * MS;
        for _ in 0..4 {
            self.now_ns += pause_ns / 4;
            let acts = self.client.tick(self.now_ns);
            self.take(acts);
        }
    }

    /// What the client makes of it; each pose that it shows must be one that may be.
    fn take(&mut self, acts: Vec<Act>) {
        if acts.iter().any(|act| matches!(act, Act::Close(_))) {
            self.client.closed(self.now_ns);
            self.client.connected(self.now_ns);
        }
        for frame in frames(acts) {
            for (marker, place) in seen(&frame) {
                let Ok(x) = place else { continue };
                let all = self.sent.get(&(frame.device_ns, marker));
                let is_right = all.is_some_and(|all| all.iter().any(|said| said.x == x && said.may_be_shown()));
                assert!(is_right, "{frame:?} of {all:?}");
                self.shown += 1;
            }
        }
    }

    /// A message of some kind, whole or damaged on the way.
    fn message(&mut self) -> Vec<u8> {
        // What is said in a message that does not come whole is not heard.
        self.is_damaged = self.chance.below(30) == 0;
        let mut bytes = match self.chance.of(self.kinds) {
            Sends::Transform => self.one(false),
            Sends::Position => self.one(true),
            Sends::Tdata => self.several(false),
            Sends::Qtdata => self.several(true),
        };
        if self.is_damaged {
            let at = 58 + self.chance.below(bytes.len() as u64 - 58) as usize;
            bytes[at] ^= 0x55;
        }
        bytes
    }

    /// A TRANSFORM or POSITION of one tool: its word is that of the message.
    fn one(&mut self, is_position: bool) -> Vec<u8> {
        let (name, marker) = self
            .chance
            .of(&[(self.tool[1], 0), (self.tool[1], 0), (REFERENCE, 1), ("Other", 9)]);
        let word = self.chance.of(&WORDS);
        let place = self.place();
        let is_whole = !is_position || self.chance.below(8) > 0;
        let body = match is_position {
            false => Body::Transform(at(place)),
            true => Body::Position(Position {
                place: [place, 0.0, -1500.0],
                orientation: match is_whole {
                    true => self
                        .chance
                        .of(&[Orientation::Full([0.0, 0.0, 0.0, 1.0]), Orientation::Short([0.0; 3])]),
                    false => Orientation::None,
                },
            }),
        };
        let words = word.iter().map(|word| *word == "OK").collect();
        self.said(marker, place, words, is_whole);
        let words: Vec<(String, &str)> = word
            .iter()
            .map(|word| (igtl::TRANSFORM_STATUS.to_owned(), *word))
            .collect();
        self.bytes(DeviceName::new(name).unwrap(), body, &words)
    }

    /// A TDATA or QTDATA of some tools; the words stand under the whole names, which two tools may share the beginning of.
    fn several(&mut self, has_quaternions: bool) -> Vec<u8> {
        let names = [self.tool[1], REFERENCE, "Other"];
        let first = self.chance.below(3) as usize;
        let count = 1 + self.chance.below(3) as usize;
        let names: Vec<&str> = names.into_iter().cycle().skip(first).take(count).collect();
        let mut words: Vec<(String, &str)> = Vec::new();
        let mut put = |stem: &str, word: Option<&'static str>| {
            words.extend(word.map(|word| (format!("{stem}Status"), word)));
        };
        put(self.tool[0], self.chance.of(&WORDS));
        put(REFERENCE, self.chance.of(&WORDS));
        if self.tool[1] == CUT && self.chance.below(4) == 0 {
            put(self.chance.of(&[TWIN, CUT]), self.chance.of(&WORDS));
        }
        let mut tools = Vec::new();
        for name in names {
            let (place, kind) = (
                self.place(),
                self.chance
                    .of(&[ToolKind::Six, ToolKind::Six, ToolKind::Six, ToolKind::Five]),
            );
            let marker = if name == REFERENCE {
                1
            } else {
                u32::from(name == "Other") * 9
            };
            let of_it = words
                .iter()
                .filter(|(key, _)| key.as_bytes().iter().take(name.len().min(20)).eq(name.as_bytes()));
            let own: Vec<bool> = of_it.map(|(_, word)| *word == "OK").collect();
            self.said(marker, place, own, kind == ToolKind::Six);
            tools.push((DeviceName::new(name).unwrap(), kind, place));
        }
        let body = match has_quaternions {
            false => Body::Tdata(
                tools
                    .into_iter()
                    .map(|(name, kind, x)| Tool {
                        name,
                        kind,
                        pose: at(x),
                    })
                    .collect(),
            ),
            true => Body::Qtdata(
                tools
                    .into_iter()
                    .map(|(name, kind, x)| Tool {
                        name,
                        kind,
                        pose: placed(x),
                    })
                    .collect(),
            ),
        };
        let list = self.chance.of(&["", "", "Tracking"]);
        self.bytes(DeviceName::new(list).unwrap(), body, &words)
    }

    /// A place that no other tool of the sequence has, and that a localizer sees.
    fn place(&mut self) -> f32 {
        self.x += 1.0;
        self.x
    }

    fn said(&mut self, marker: u32, x: f32, words: Vec<bool>, is_whole: bool) {
        let may_be_silent = self.rule == StatusRule::AbsentMeansValid && !self.stated.contains(&marker);
        if !words.is_empty() && !self.is_damaged && !self.stated.contains(&marker) {
            self.stated.push(marker);
        }
        let said = Said {
            x: x.into(),
            words,
            is_whole,
            may_be_silent,
        };
        let device_ns = 1_790_000_000_000_000_000 + self.stamp_ns;
        self.sent.entry((device_ns, marker)).or_default().push(said);
    }

    /// Of version 1 where nothing is said, or of 2.
    fn bytes(&mut self, device: DeviceName, body: Body<'static>, words: &[(String, &str)]) -> Vec<u8> {
        let mut message = Message::new(device, body);
        message.stamp = stamp(self.stamp_ns);
        if !words.is_empty() || self.chance.below(2) == 0 {
            message = message.in_version(Version::Two);
        }
        for (key, word) in words {
            let text = Text {
                encoding: US_ASCII,
                bytes: word.as_bytes().to_vec(),
            };
            message.metadata = message.metadata.with(key, text);
        }
        message.to_vec().unwrap()
    }
}

fn placed(x: f32) -> Placed {
    Placed {
        place: [x, 0.0, -1500.0],
        quaternion: [0.0, 0.0, 0.0, 1.0],
    }
}

#[test]
fn no_lost_tool_is_shown_whatever_a_peer_says_and_leaves_out() {
    let asked = std::env::var("TROCAR_SEQUENCES").ok();
    let count = asked.map_or(USUAL, |text| text.parse().expect("TROCAR_SEQUENCES is a number"));
    let mut chance = Chance(7);
    let shown: u64 = (0..count).map(|_| Sequence::new(&mut chance).run()).sum();
    println!("{count} sequences, {shown} poses shown, each of them rightly");
    // A client that shows nothing would be right for ever: about one pose a sequence is shown.
    assert!(shown > count / 2, "{shown}");
}
