//! Whole associations, as bytes that a peer sends: good ones, lying ones, and each of them cut off and damaged everywhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use dicom_ul::pdu::{
    AssociationRQ, PDataValue, PDataValueType, Pdu, PresentationContextProposed, UserVariableItem, write_pdu,
};

use super::association::{Rules, serve_bytes};
use super::command::request;
use super::instance::tests::{implicit, instance};
use super::limits::Limits;
use super::outcome::{Ended, Outcome};
use super::store::Store;

const CT: &str = "1.2.840.10008.5.1.4.1.1.2";
const MR: &str = "1.2.840.10008.5.1.4.1.1.4";
const ECHO: &str = "1.2.840.10008.1.1";
const IMPLICIT: &str = "1.2.840.10008.1.2";
const STORE: u16 = 1;

/// What a peer sends.
#[derive(Default)]
struct Peer(Vec<u8>);

impl Peer {
    fn new() -> Self {
        let context = |id, class: &str| PresentationContextProposed {
            id,
            abstract_syntax: class.to_owned(),
            transfer_syntaxes: vec![IMPLICIT.to_owned()],
        };
        Self::default().pdu(Pdu::AssociationRQ(AssociationRQ {
            protocol_version: 1,
            calling_ae_title: "PACS".to_owned(),
            called_ae_title: "TROCAR".to_owned(),
            application_context_name: "1.2.840.10008.3.1.1.1".to_owned(),
            presentation_contexts: vec![context(1, CT), context(3, ECHO), context(5, MR)],
            user_variables: vec![UserVariableItem::MaxLength(16384)],
        }))
    }

    fn pdu(mut self, pdu: Pdu) -> Self {
        write_pdu(&mut self.0, &pdu).unwrap();
        self
    }

    fn part(self, id: u8, value_type: PDataValueType, is_last: bool, data: &[u8]) -> Self {
        let value = PDataValue {
            presentation_context_id: id,
            value_type,
            is_last,
            data: data.to_vec(),
        };
        self.pdu(Pdu::PData { data: vec![value] })
    }

    fn command(self, id: u8, field: u16, uids: [&str; 2], has_data_set: bool) -> Self {
        self.part(
            id,
            PDataValueType::Command,
            true,
            &request(field, 1, uids, has_data_set),
        )
    }

    /// An instance of this name, with this data set.
    fn store(self, name: &str, data: &[u8]) -> Self {
        let (first, second) = data.split_at(data.len() / 2);
        self.command(1, STORE, [CT, name], true)
            .part(1, PDataValueType::Data, false, first)
            .part(1, PDataValueType::Data, true, second)
    }

    fn release(self) -> Vec<u8> {
        self.pdu(Pdu::ReleaseRQ).0
    }
}

/// Three instances of one series.
fn three() -> Peer {
    names()
        .iter()
        .fold(Peer::new(), |peer, name| peer.store(name, &slice(name)))
}

fn names() -> [String; 3] {
    [1, 2, 3].map(|k| format!("1.2.3{k}"))
}

fn slice(name: &str) -> Vec<u8> {
    instance([name, "1.2.10", "1.2.20"], name.as_bytes())
}

fn rules(limits: Limits) -> Rules {
    let pacs = scene::RawPacs::default().checked().unwrap();
    let free_bytes = 0;
    Rules {
        pacs,
        limits: Limits { free_bytes, ..limits },
    }
}

/// A folder, and what an association left in it.
struct World {
    tmp: tempfile::TempDir,
}

impl World {
    fn new() -> Self {
        Self {
            tmp: tempfile::tempdir().unwrap(),
        }
    }

    fn folder(&self) -> PathBuf {
        self.tmp.path().join("in")
    }

    fn serve_with(&self, bytes: &[u8], limits: Limits) -> Option<Outcome> {
        serve_bytes(bytes, &rules(limits), &Store::open(&self.folder()).unwrap())
    }

    fn serve(&self, bytes: &[u8]) -> Option<Outcome> {
        self.serve_with(bytes, Limits::default())
    }

    /// Every file, as a path in the folder, and its bytes.
    fn files(&self) -> Vec<(String, Vec<u8>)> {
        let mut found = Vec::new();
        below(&self.folder(), &mut found);
        let name = |path: &Path| path.strip_prefix(self.folder()).unwrap().to_str().unwrap().to_owned();
        let mut found: Vec<_> = found.iter().map(|path| (name(path), fs::read(path).unwrap())).collect();
        found.sort();
        found
    }
}

fn below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => below(&path, found),
            false => found.push(path),
        }
    }
}

#[test]
fn a_series_lands_under_its_identifiers_byte_for_byte() {
    let world = World::new();
    let outcome = world.serve(&three().release()).unwrap();
    assert_eq!(
        (&outcome.ended, outcome.asked, outcome.refused),
        (&Ended::Released, 3, 0)
    );
    assert!(outcome.is_kept() && outcome.stored() == 3);
    assert_eq!(outcome.series[0].path, world.folder().join("1.2.10/1.2.20"));
    let files = world.files();
    assert_eq!(files.len(), 3);
    for ((path, bytes), name) in files.iter().zip(names()) {
        assert_eq!(path, &format!("1.2.10/1.2.20/{name}.dcm"));
        assert!(bytes.ends_with(&slice(&name)) && &bytes[128..132] == b"DICM");
        let meta = dicom_object::FileMetaTable::from_reader(&bytes[128..]).unwrap();
        assert_eq!(meta.media_storage_sop_instance_uid().trim_end_matches('\0'), name);
        assert_eq!(meta.media_storage_sop_class_uid().trim_end_matches('\0'), CT);
        assert_eq!(meta.transfer_syntax().trim_end_matches('\0'), IMPLICIT);
    }
    // Once more: nothing is new, and nothing is changed.
    let outcome = world.serve(&three().release()).unwrap();
    assert!(outcome.is_kept() && (outcome.stored(), outcome.same()) == (0, 3));
    assert_eq!(world.files(), files);
}

#[test]
fn an_association_that_is_cut_off_anywhere_leaves_no_part_and_no_complete_series() {
    let bytes = three().release();
    // The release alone makes it complete.
    for end in (0..bytes.len()).rev().step_by(13).chain(bytes.len() - 20..bytes.len()) {
        let world = World::new();
        let outcome = world.serve(&bytes[..end]);
        for (path, bytes) in world.files() {
            let name = path.rsplit('/').next().unwrap().trim_end_matches(".dcm");
            assert!(path.starts_with("1.2.10/.1.2.20.incomplete/"), "{end}: {path}");
            assert!(bytes.ends_with(&slice(name)), "{end}: {path}");
        }
        let Some(outcome) = outcome else { continue };
        assert!(
            !outcome.is_kept() && matches!(outcome.ended, Ended::BrokenOff(_)),
            "{end}"
        );
        assert!(
            outcome
                .series
                .iter()
                .all(|came| came.is_hidden && came.lacking.is_some()),
            "{end}"
        );
        // What is sent again completes it.
        assert!(world.serve(&three().release()).unwrap().is_kept(), "{end}");
        assert_eq!(world.files().len(), 3);
    }
}

#[test]
fn what_is_not_what_it_was_announced_as_is_refused_and_its_series_is_not_complete() {
    let other = implicit(&[(0x0008, 0x0016, MR.as_bytes())]);
    let of_mr = [&other[..], &slice("1.2.34")[34..]].concat();
    let cases: [(&str, Vec<u8>); 8] = [
        ("1.2.34", slice("1.2.35")),
        ("1.2.34", of_mr),
        ("../1", slice("1.2.34")),
        ("", slice("1.2.34")),
        ("1.2.34", slice("1.2.34")[..60].to_vec()),
        ("1.2.34", Vec::new()),
        ("1.2.34", instance(["1.2.34", "../..", "1.2.20"], b"")),
        ("1.2.34", slice("1.2.34")[..slice("1.2.34").len() - 14].to_vec()),
    ];
    for (name, data) in cases {
        let world = World::new();
        let outcome = world.serve(&three().store(name, &data).release()).unwrap();
        assert_eq!(
            (&outcome.ended, outcome.asked, outcome.refused),
            (&Ended::Released, 4, 1),
            "{name}"
        );
        assert!(!outcome.is_kept() && outcome.series.len() == 1);
        let why = outcome.series[0].lacking.as_ref().unwrap();
        assert!(why.contains("refused before it was known"), "{why}");
        assert_eq!(world.files().len(), 3);
    }
}

#[test]
fn another_instance_of_a_name_that_is_there_is_refused_and_what_is_there_stays() {
    let world = World::new();
    world.serve(&three().release()).unwrap();
    let before = world.files();
    let other = instance(["1.2.32", "1.2.10", "1.2.20"], b"another");
    let outcome = world.serve(&Peer::new().store("1.2.32", &other).release()).unwrap();
    assert!(!outcome.is_kept() && outcome.refused == 1);
    // It says so, and not that the series is among the incomplete ones, where it is not.
    assert!(!outcome.series[0].is_hidden);
    assert_eq!(
        outcome.series[0].lacking.as_ref().unwrap(),
        "1 of its instances were refused"
    );
    assert_eq!(world.files(), before);
}

#[test]
fn beyond_each_limit_it_is_refused_or_ended_and_nothing_of_it_stays() {
    let length = slice("1.2.31").len() as u64;
    let default = Limits::default();
    let instance_bytes = Limits {
        instance_bytes: length - 1,
        ..default
    };
    let association_bytes = Limits {
        association_bytes: 2 * length,
        ..default
    };
    let instances = Limits {
        instances: 1,
        ..default
    };
    for (limits, kept) in [(instance_bytes, 0), (association_bytes, 2), (instances, 1)] {
        let world = World::new();
        let outcome = world.serve_with(&three().release(), limits).unwrap();
        assert_eq!((outcome.stored(), outcome.refused), (kept, 3 - kept), "{limits:?}");
        assert!(!outcome.is_kept() && world.files().len() as u64 == kept);
    }
    // A data set that never ends.
    let world = World::new();
    let mut peer = three().command(1, STORE, [CT, "1.2.34"], true);
    for _ in 0..40 {
        peer = peer.part(1, PDataValueType::Data, false, &[0; 1000]);
    }
    let limits = Limits {
        instance_bytes: 10_000,
        association_bytes: 20_000,
        ..default
    };
    let outcome = world.serve_with(&peer.0, limits).unwrap();
    assert!(
        matches!(&outcome.ended, Ended::BrokenOff(why) if why.contains("beyond 20000 bytes")),
        "{:?}",
        outcome.ended
    );
    assert!(outcome.bytes < 32_000 && world.files().len() == 3);
    // A disk that is full.
    let world = World::new();
    let mut full = rules(default);
    full.limits.free_bytes = u64::MAX;
    let store = Store::open(&world.folder()).unwrap();
    let outcome = serve_bytes(&three().release(), &full, &store).unwrap();
    assert_eq!((outcome.stored(), outcome.refused), (0, 3));
    assert!(world.files().is_empty());
}

#[test]
fn what_dicom_has_not_ends_the_association() {
    let data = PDataValueType::Data;
    let store = || three().command(1, STORE, [CT, "1.2.34"], true);
    let cases = [
        (
            store().part(3, data.clone(), true, b"x"),
            "a fragment in context 3 within",
        ),
        (
            store().part(5, data.clone(), true, b"x"),
            "context 5, which was not accepted",
        ),
        (
            store().command(1, STORE, [CT, "1.2.35"], true),
            "a command within the data set",
        ),
        (
            three().part(1, data.clone(), true, b"x"),
            "a data set without a command",
        ),
        (store().pdu(Pdu::ReleaseRQ), "release in the middle"),
        (
            three().command(1, 0x8001, [CT, "1.2.34"], false),
            "an answer to nothing",
        ),
        (three().pdu(Pdu::ReleaseRP), "out of turn"),
        (
            three().pdu(Pdu::Unknown {
                pdu_type: 9,
                data: Vec::new(),
            }),
            "unknown type 0x09",
        ),
        (
            three().part(1, PDataValueType::Command, true, b"nonsense!"),
            "a command set that is none",
        ),
    ];
    for (peer, words) in cases {
        let world = World::new();
        let outcome = world.serve(&peer.release()).unwrap();
        let Ended::BrokenOff(why) = &outcome.ended else {
            panic!("{words}: {:?}", outcome.ended)
        };
        assert!(why.contains(words), "{why}");
        assert!(!outcome.is_kept() && world.files().len() == 3);
    }
    // A PDU longer than is allowed is not waited for, nor one that says it is and is not.
    for head in [[4, 0, 0xff, 0xff, 0xff, 0xff], [1, 0, 0, 2, 0, 1]] {
        let world = World::new();
        assert_eq!(world.serve(&head), None);
        let mut peer = three();
        peer.0.extend(head);
        let outcome = world.serve(&peer.0).unwrap();
        assert!(matches!(&outcome.ended, Ended::BrokenOff(why) if why.contains("allowed are 131072")));
    }
}

#[test]
fn what_is_not_storage_is_answered_and_changes_nothing() {
    let world = World::new();
    let peer = three()
        .command(3, 0x0030, [ECHO, ""], false)
        .command(1, 0x0020, [CT, ""], false)
        .command(1, 0x0020, [CT, ""], true)
        .part(1, PDataValueType::Data, true, &[0; 99])
        .command(1, 0x0FFF, [CT, ""], false);
    let outcome = world.serve(&peer.release()).unwrap();
    assert_eq!((outcome.echoes, outcome.asked, outcome.refused), (1, 3, 0));
    assert!(outcome.is_kept());
}

/// A panic while an association is served ends the association, and not the process.
#[test]
fn a_panic_is_told_as_an_error_and_nothing_is_left_of_it() {
    use std::io::{Read, Write};
    let world = World::new();
    let (mut rules, store) = (rules(Limits::default()), Store::open(&world.folder()).unwrap());
    rules.pacs.address.set_port(0);
    let report: super::server::Report = Box::new(|_| panic!("in the middle of an association"));
    let server = super::Server::bind(rules, store, bus::process::StopFlag::default(), true, report).unwrap();
    let mut stream = std::net::TcpStream::connect(server.address()).unwrap();
    let served = std::thread::spawn(|| server.serve());
    stream.write_all(&three().release()).unwrap();
    let mut answers = Vec::new();
    stream.read_to_end(&mut answers).unwrap();
    // A-ASSOCIATE-AC, and A-RELEASE-RP at the end.
    assert_eq!((answers.first(), answers.get(answers.len() - 10)), (Some(&2), Some(&6)));
    assert!(matches!(served.join().unwrap(), Err(super::ServeError::NotAll)));
    assert_eq!(world.files().len(), 3);
}

/// The same on a wire that is slow or silent: its time is over, and it is no instance.
#[test]
fn a_peer_that_sends_a_byte_now_and_then_is_cut_off() {
    use super::association::{Association, Place, agree};
    use super::wire::Wire;
    use std::io::{ErrorKind, Read, Write};

    /// Gives `first` bytes at once, then one each millisecond, and closes once it was told that it is over.
    struct Slow {
        bytes: Vec<u8>,
        at: usize,
        first: usize,
        is_over: bool,
    }
    impl Read for Slow {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            if self.is_over {
                return Ok(0);
            }
            let Some(rest) = self.bytes.get(self.at..).filter(|rest| !rest.is_empty()) else {
                std::thread::sleep(Duration::from_millis(1));
                return Err(ErrorKind::WouldBlock.into());
            };
            let mut count = 1;
            match self.at < self.first {
                true => count = (self.first - self.at).min(out.len()),
                false => std::thread::sleep(Duration::from_millis(1)),
            }
            out[..count].copy_from_slice(&rest[..count]);
            self.at += count;
            Ok(count)
        }
    }
    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            // A-ABORT.
            self.is_over |= bytes.first() == Some(&7);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let limits = Limits {
        silence: Duration::from_millis(200),
        ..Limits::default()
    };
    let rules = rules(limits);
    let whole = three();
    // One PDU a byte at a time; many small PDUs of one message; nothing at all; verifications without end.
    let mut small = three().command(1, STORE, [CT, "1.2.34"], true);
    for _ in 0..200 {
        small = small.part(1, PDataValueType::Data, false, b"x");
    }
    let mut echoes = three();
    for _ in 0..200 {
        echoes = echoes.command(3, 0x0030, [ECHO, ""], false);
    }
    let begun = whole.0.len();
    let cases = [
        (whole.store("1.2.34", &[0; 60_000]).0, begun + 200),
        (small.0, begun),
        (three().0, begun),
        (echoes.0, begun),
    ];
    for (bytes, first) in cases {
        let world = World::new();
        let store = Store::open(&world.folder()).unwrap();
        let stop = || false;
        let mut wire = Wire::new(
            Slow {
                bytes,
                at: 0,
                first,
                is_over: false,
            },
            &stop,
        );
        let agreed = agree(&mut wire, &rules, || true).unwrap();
        let place = Place {
            rules: &rules,
            store: &store,
            tell: &|_| {},
        };
        let outcome = Association::new(&mut wire, place, agreed).run(&mut |_| {});
        assert!(matches!(outcome.ended, Ended::BrokenOff(_)), "{outcome:?}");
        assert_eq!(world.files().len(), 3);
    }
}
