//! A message to whoever looks on: made once, encoded once for each version of the header, shared by all clients.

use std::io::IoSlice;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, OnceLock};

use igtl::{Body, Image, Message, Version};

/// The voxels of an image, where one copy of them serves all clients.
#[derive(Debug)]
pub(crate) enum Voxels {
    /// Pixels.
    Bytes(Vec<u8>),
    /// Hounsfield units in the order of this machine's bytes.
    Shorts(Vec<i16>),
}

impl Voxels {
    /// As they go out.
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Shorts(shorts) => bytemuck::cast_slice(shorts),
        }
    }
}

/// The bytes of a message: what was made of it, what lies where it is shared, and what stands behind.
#[derive(Debug)]
pub(crate) struct Wire {
    head: Vec<u8>,
    voxels: Option<Arc<Voxels>>,
    tail: Vec<u8>,
}

impl Wire {
    fn pieces(&self) -> [&[u8]; 3] {
        let voxels = self.voxels.as_ref().map(|voxels| voxels.bytes());
        [&self.head, voxels.unwrap_or_default(), &self.tail]
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.pieces().iter().map(|piece| piece.len()).sum()
    }

    /// Those from byte `from` on, to be sent in one call.
    pub(crate) fn rest(&self, from: usize) -> [IoSlice<'_>; 3] {
        let mut before = from;
        self.pieces().map(|piece| {
            let skipped = before.min(piece.len());
            before -= skipped;
            IoSlice::new(piece.get(skipped..).unwrap_or_default())
        })
    }
}

/// Until when the newest pose may be called valid, ns on CLOCK_MONOTONIC: what claims it is not said later, whoever says it, and also
/// where the thread that judges poses has come to a stop.
#[derive(Debug, Clone)]
pub(crate) struct Claim(Arc<AtomicI64>);

impl Default for Claim {
    fn default() -> Self {
        Self(Arc::new(AtomicI64::new(i64::MIN)))
    }
}

impl Claim {
    /// There is a pose until then; there is none where that has passed.
    pub(crate) fn set(&self, until_ns: i64) {
        self.0.store(until_ns, Ordering::Relaxed);
    }

    fn holds_at(&self, monotonic_ns: i64) -> bool {
        monotonic_ns <= self.0.load(Ordering::Relaxed)
    }
}

/// What makes a message once somebody wants its bytes.
struct Content(Box<dyn Fn() -> Message<'static> + Send + Sync>);

impl std::fmt::Debug for Content {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0().fmt(f)
    }
}

/// A message for every client, in both versions of the header.
#[derive(Debug)]
pub(crate) struct Letter {
    content: Content,
    voxels: Option<Arc<Voxels>>,
    to_one: bool,
    until_ns: Option<i64>,
    claim: Option<Claim>,
    wires: [OnceLock<Option<Arc<Wire>>>; 2],
}

impl Letter {
    /// A message with its number and metadata, which clients of version 1 are sent without.
    pub(crate) fn new(message: Message<'static>) -> Self {
        Self::made(move || message.clone())
    }

    /// The same, of a message that is made where one is sent: most of some kinds are wanted by nobody.
    pub(crate) fn made(make: impl Fn() -> Message<'static> + Send + Sync + 'static) -> Self {
        Self {
            content: Content(Box::new(make)),
            voxels: None,
            to_one: true,
            until_ns: None,
            claim: None,
            wires: [OnceLock::new(), OnceLock::new()],
        }
    }

    /// Not for clients of version 1: what makes it no pose stands in the metadata, which they do not read.
    #[must_use]
    pub(crate) fn not_to_one(self) -> Self {
        Self { to_one: false, ..self }
    }

    /// Not to be sent later than this, ns on CLOCK_MONOTONIC.
    #[must_use]
    pub(crate) fn until(self, until_ns: Option<i64>) -> Self {
        Self { until_ns, ..self }
    }

    /// Not to be sent while the newest pose is none.
    #[must_use]
    pub(crate) fn claiming(self, claim: Option<Claim>) -> Self {
        Self { claim, ..self }
    }

    /// An IMAGE whose own voxels are empty, with these.
    #[must_use]
    pub(crate) fn with(self, voxels: Arc<Voxels>) -> Self {
        Self {
            voxels: Some(voxels),
            ..self
        }
    }

    /// Whether it is still true at this time of CLOCK_MONOTONIC.
    pub(crate) fn holds_at(&self, monotonic_ns: i64) -> bool {
        let is_young = self.until_ns.is_none_or(|until| monotonic_ns <= until);
        is_young && self.claim.as_ref().is_none_or(|claim| claim.holds_at(monotonic_ns))
    }

    /// Its bytes for a client of this version; `None` where it is not for one.
    pub(crate) fn wire(&self, version: Version) -> Option<Arc<Wire>> {
        if version == Version::One && !self.to_one {
            return None;
        }
        let [one, two] = &self.wires;
        let wire = if version == Version::One { one } else { two };
        wire.get_or_init(|| self.encoded(version)).clone()
    }

    fn encoded(&self, version: Version) -> Option<Arc<Wire>> {
        let message = message_of_two(self.content.0()).in_version(version);
        let message = match (&self.voxels, message.body) {
            (Some(voxels), Body::Image(image)) => Message {
                body: Body::Image(Image {
                    voxels: voxels.bytes().into(),
                    ..image
                }),
                ..message
            },
            (_, body) => Message { body, ..message },
        };
        // Numbers, names and lengths were checked where the message was made: what is refused here is sent to nobody.
        let encoded = message.encode().ok()?;
        let [head, shared, tail] = encoded.pieces();
        let is_shared = self.voxels.is_some();
        let head = if is_shared {
            head.to_vec()
        } else {
            [head, shared].concat()
        };
        Some(Arc::new(Wire {
            head,
            voxels: self.voxels.clone(),
            tail: tail.to_vec(),
        }))
    }
}

fn message_of_two(message: Message<'static>) -> Message<'static> {
    Message {
        version: Version::Two,
        ..message
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use igtl::{ByteOrder, DeviceName, Limits, Matrix, Metadata, Scalar, Space, Text, decode};

    fn transform() -> Message<'static> {
        let body = Body::Transform(Matrix::IDENTITY);
        Message {
            metadata: Metadata::EMPTY.with("TransformStatus", Text::new("OK")),
            number: 7,
            ..Message::new(DeviceName::new("ToolToRas").unwrap(), body)
        }
    }

    fn bytes(letter: &Letter, version: Version) -> Option<Vec<u8>> {
        let wire = letter.wire(version)?;
        Some(wire.rest(0).iter().flat_map(|piece| piece.to_vec()).collect())
    }

    #[test]
    fn a_client_of_version_1_is_sent_no_byte_of_version_2() {
        let letter = Letter::new(transform());
        let one = bytes(&letter, Version::One).unwrap();
        assert_eq!((one.len(), &one[..2]), (106, &[0, 1][..]));
        let (message, _) = decode(&one, &Limits::POSES).unwrap();
        assert!(message.metadata.is_empty() && message.number == 0);
        let two = bytes(&letter, Version::Two).unwrap();
        let (message, _) = decode(&two, &Limits::POSES).unwrap();
        assert_eq!(message.metadata.get("TransformStatus"), Some(&Text::new("OK")));
        assert_eq!(message.number, 7);
    }

    #[test]
    fn what_is_no_pose_is_nothing_to_a_client_of_version_1() {
        let letter = Letter::new(transform()).not_to_one();
        assert!(letter.wire(Version::One).is_none() && letter.wire(Version::Two).is_some());
    }

    #[test]
    fn a_message_is_made_once_and_begins_again_where_it_stopped() {
        let image = Image {
            components: 1,
            scalar: Scalar::Int16,
            order: ByteOrder::Little,
            space: Space::Ras,
            dimensions: [2, 1, 1],
            placed: Matrix::IDENTITY,
            offset: [0; 3],
            size: [2, 1, 1],
            voxels: Vec::new().into(),
        };
        let name = DeviceName::new("Volume").unwrap();
        let voxels = Arc::new(Voxels::Shorts(vec![1, -2]));
        let letter = Letter::new(Message::new(name, Body::Image(image))).with(voxels);
        let (first, again) = (letter.wire(Version::One).unwrap(), letter.wire(Version::One).unwrap());
        assert!(Arc::ptr_eq(&first, &again));
        let whole = bytes(&letter, Version::One).unwrap();
        assert_eq!(whole.len(), first.len());
        let (message, _) = decode(&whole, &Limits::VOLUMES).unwrap();
        let Body::Image(image) = message.body else { panic!() };
        assert_eq!(&*image.voxels, &[1, 0, 0xfe, 0xff]);
        for from in 0..=whole.len() {
            let rest: Vec<u8> = first.rest(from).iter().flat_map(|piece| piece.to_vec()).collect();
            assert_eq!(rest, whole[from..]);
        }
    }

    #[test]
    fn a_pose_is_not_sent_once_it_is_old() {
        let letter = Letter::new(transform()).until(Some(100));
        assert!(letter.holds_at(100) && !letter.holds_at(101));
        assert!(Letter::new(transform()).holds_at(i64::MAX));
    }

    #[test]
    fn who_says_that_there_is_a_pose_is_not_heard_once_it_is_old() {
        let claim = Claim::default();
        let letter = Letter::new(transform()).claiming(Some(claim.clone()));
        assert!(!letter.holds_at(i64::MIN + 1));
        claim.set(100);
        assert!(letter.holds_at(100) && !letter.holds_at(101));
        claim.set(i64::MIN);
        assert!(!letter.holds_at(100));
    }
}
